"""The operating window of a drive, and what occurs somewhere in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.drive import is_window, without_friction
from lsvib.assess.friction import sliding_speed
from lsvib.assess.mechanisms import applicable, reserves
from lsvib.assess.sheet import Sheet

# The slope of a curve is constant between its points, all of which are looked at from both sides; between them only the
# level of friction changes, for which equal steps do.
_SPEEDS_OF_CURVE = 17
_BESIDE_POINT = 1e-9  # relative, how near: far above rounding, far below any change of the level that counts
_FORCES_OF_SLOPE, _BESIDE = 9, 1e-9  # forces on each side of R̃ = 0, and how near the first one is, as a share


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

    All reserves depend on speed and force through R̃ = R − r_m tan λ c_x Ω alone, which is linear in both: through its
    sign, for which the corners decide, and with a slope of friction through its size as well. Reserves of damping are
    monotonic in that size, so that the corners and the neighbourhood of R̃ = 0 decide; with a support, whose reserve
    need not be, 9 forces on each side are looked at, and with a curve of friction 17 speeds and either side of each of
    its points, where its slope changes.
    """
    low, high = values["speed_low"], values["speed_high"]
    count = 1 if not is_window(sheet, "operation.speed") else 2 if sheet.friction.curve is None else _SPEEDS_OF_CURVE
    speeds = [low + share * (high - low) for share in np.linspace(0.0, 1.0, count)]
    if count == _SPEEDS_OF_CURVE:
        speeds += _beside_points(sheet, values)
    return [
        (direction, speed, force)
        for direction in directions(sheet)
        for speed in speeds
        for force in _forces(sheet, values, direction, speed)
    ]


def _beside_points(sheet: Sheet, values: Mapping[str, Any]) -> list[Any]:
    """Speeds of the screw [rad/s] just below and just above each point of the curve that lies in the window."""
    low, high = values["speed_low"], values["speed_high"]
    radius = 0.5 * values["pitch_diameter"]
    one = sliding_speed(1.0, radius, np.arctan(values["lead"] / (2 * np.pi * radius)))
    speeds = []
    for sliding in sheet.friction.curve.speeds:
        for side in (1 - _BESIDE_POINT, 1 + _BESIDE_POINT):
            speed = side * sliding / one
            inside = (np.real(low) < np.real(speed)) & (np.real(speed) < np.real(high))
            if np.any(inside):  # of the drives that have it outside, the end of the window is looked at twice
                speeds.append(np.where(inside, speed, low))
    return speeds


def _forces(sheet: Sheet, values: Mapping[str, Any], direction: int, speed: Any) -> list[Any]:
    low, high = values["force_low"], values["force_high"]
    if not is_window(sheet, "load.force"):
        return [low]
    if sheet.friction.curve is None and sheet.friction.slope is None:
        return [low, high]
    p = without_friction(values, direction, speed, 0.0)
    free = p["axial_force"] - p["pitch_radius"] * np.tan(p["lead_angle"]) * p["translation_damping"] * p["input_speed"]
    forces = [low, high]
    for end in (low, high):
        for share in np.linspace(_BESIDE, 1.0, 1 if sheet.support is None else _FORCES_OF_SLOPE):
            force = free + share * (end - free)
            force = np.where(np.real(force) < np.real(low), low, force)
            forces.append(np.where(np.real(force) > np.real(high), high, force))
    return forces


def worst(sheet: Sheet, values: Mapping[str, Any]) -> dict[str, Worst]:
    """Return the lowest reserve of each mechanism over the window for drives given by arrays (n) or floats.

    ``push_needed`` is among them, see :func:`lsvib.assess.mechanisms.reserves`. NaN where the friction is so strong
    that the drive cannot move at all.
    """
    places = corners(sheet, values)
    rows = []
    for direction in directions(sheet):
        speeds, forces = (_stacked([place[k] for place in places if place[0] == direction]) for k in (1, 2))
        rows.append(reserves(sheet, values, direction, speeds, forces))
    size = len(places) // len(rows)
    found = {}
    for name in (*applicable(sheet), "push_needed"):
        parts = [np.atleast_1d(row[name]) for row in rows]
        width = max(part.shape[-1] for part in parts)
        table = np.concatenate([np.broadcast_to(part, (size, width)) for part in parts])
        lowest = np.argmin(np.where(np.isnan(np.real(table)), -np.inf, np.real(table)), axis=0)
        found[name] = Worst(np.take_along_axis(table, lowest[None], 0)[0], lowest)
    return found


def _stacked(numbers: list[Any]) -> NDArray[np.float64]:
    """Floats (k) as (k, 1), arrays (k of n) as (k, n)."""
    table = np.stack(np.broadcast_arrays(*numbers))
    return table[:, None] if table.ndim == 1 else table
