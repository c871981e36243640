"""The operating window of a drive, and what occurs somewhere in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.mechanisms import applicable, reserves
from lsvib.assess.sheet import Sheet

# A curve bends within the window, where friction may be worst; straight lines have their extremes at the corners.
_SPEEDS_OF_CURVE = 65


@dataclass(frozen=True)
class Worst:
    """The lowest reserve of a mechanism in the window, arrays (n): ``reserve`` and the ``corner`` that has it."""

    reserve: NDArray[np.float64]
    corner: NDArray[np.int64]


def directions(sheet: Sheet) -> tuple[int, ...]:
    """Return the directions of travel, 1 outward and −1 back."""
    return {"out": (1,), "back": (-1,), "both": (1, -1)}[sheet.operation.direction]


def corners(sheet: Sheet, values: Mapping[str, Any]) -> list[tuple[int, Any, Any]]:
    """Return direction, speed [rad/s] and force [N] of the points of the window where a reserve can be lowest.

    All reserves depend on speed and force through the sign and the size of R̃ = R − r_m tan λ c_x Ω alone, which is
    linear in both; so the corners decide. With a friction curve 65 speeds between the ends are looked at.
    """
    low, high = values["speed_low"], values["speed_high"]
    count = 1 if low is high else 2 if sheet.friction.curve is None else _SPEEDS_OF_CURVE
    speeds = [low + share * (high - low) for share in np.linspace(0.0, 1.0, count)]
    forces = [values["force_low"], values["force_high"]]
    forces = forces[:1] if forces[0] is forces[1] else forces
    return [(direction, speed, force) for direction in directions(sheet) for speed in speeds for force in forces]


def worst(sheet: Sheet, values: Mapping[str, Any]) -> dict[str, Worst]:
    """Return the lowest reserve of each mechanism over the window for drives given by arrays (n) or floats.

    ``push_needed`` is among them, see :func:`lsvib.assess.mechanisms.reserves`. NaN where the friction is so strong
    that the drive cannot move at all.
    """
    rows = [reserves(sheet, values, *corner) for corner in corners(sheet, values)]
    found = {}
    for name in (*applicable(sheet), "push_needed"):
        table = np.stack(np.broadcast_arrays(*(np.atleast_1d(row[name]) for row in rows)))
        lowest = np.argmin(np.where(np.isnan(np.real(table)), -np.inf, np.real(table)), axis=0)
        found[name] = Worst(np.take_along_axis(table, lowest[None], 0)[0], lowest)
    return found
