"""The operating window of a drive, and what occurs somewhere in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.drive import is_window, sliding_speed, without_friction
from lsvib.assess.mechanisms import applicable, reserves
from lsvib.assess.sheet import Sheet

# The slope of a curve is constant between its points, all of which are looked at from both sides; between them only the
# level of friction changes, for which equal steps do.
_SPEEDS_OF_CURVE = 17
_BESIDE_POINT = 1e-9  # relative, how near: far above rounding, far below any change of the level that counts
_ENDS = ("low", "high")
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
    monotonic in that size, so that the corners and the neighbourhood of R̃ = 0 decide, which is looked for at the ends
    of the speeds and of the forces; with a support, whose reserve need not be, 9 forces on each side are looked at, and
    9 speeds where drag balances the end of the forces or the one force, and with a curve of friction 17 speeds and
    either side of each of its points, where its slope changes.
    """
    return [
        (direction, speed, force)
        for direction in directions(sheet)
        for speed, force in zip(*_points(sheet, values, direction), strict=True)
    ]


def _points(sheet: Sheet, values: Mapping[str, Any], direction: int) -> tuple[NDArray, NDArray]:
    """Speeds [rad/s] and forces [N] of all corners of one direction: (k) for one drive, (k, n) for arrays of drives."""
    shape = np.broadcast_shapes(*map(np.shape, values.values()))
    speeds = _speeds(sheet, values, direction, *(np.broadcast_to(values[f"speed_{end}"], shape) for end in _ENDS))
    rows = np.broadcast_arrays(speeds, *_forces(sheet, values, direction, speeds))
    forces = np.stack(rows[1:], axis=1)  # of each speed one after the other
    return np.repeat(rows[0], forces.shape[1], axis=0), forces.reshape(-1, *forces.shape[2:])


def _speeds(sheet: Sheet, values: Mapping[str, Any], direction: int, low: NDArray, high: NDArray) -> NDArray:
    """Speeds of the screw [rad/s] from ``low`` to ``high`` at which forces are looked at, (k) or (k, n)."""
    if not is_window(sheet, "operation.speed"):
        return low[None]
    curved = sheet.friction.curve is not None
    shares = np.linspace(0.0, 1.0, _SPEEDS_OF_CURVE if curved else 2)
    rows = [low + np.multiply.outer(shares, high - low)]
    if curved:
        rows.append(_beside_points(sheet, values, low, high))
    if curved or sheet.friction.slope is not None:
        for end in _ENDS if is_window(sheet, "load.force") else _ENDS[:1]:
            rows += _beside_balance(sheet, values, direction, low, high, values[f"force_{end}"])
    return np.concatenate(rows)


def _beside_points(sheet: Sheet, values: Mapping[str, Any], low: NDArray, high: NDArray) -> NDArray:
    """Speeds of the screw [rad/s] just below and just above each point of the curve that lies in the window."""
    radius = 0.5 * values["pitch_diameter"]
    one = sliding_speed(1.0, radius, np.arctan(values["lead"] / (2 * np.pi * radius)))
    sliding = np.multiply.outer(sheet.friction.curve.speeds, (1 - _BESIDE_POINT, 1 + _BESIDE_POINT)).ravel()
    speeds = np.divide.outer(sliding, np.broadcast_to(one, low.shape))
    inside = (np.real(low) < np.real(speeds)) & (np.real(speeds) < np.real(high))
    # Of the drives that have it outside, the end of the window is looked at twice.
    return np.where(inside, speeds, low)[np.any(inside, axis=tuple(range(1, inside.ndim)))]


def _beside_balance(
    sheet: Sheet, values: Mapping[str, Any], direction: int, low: NDArray, high: NDArray, force: Any
) -> list[NDArray]:
    """Speeds of the screw [rad/s] from the one in the window where |R̃| is least under a ``force`` [N] to its ends.

    None for an end of a window of forces that is balanced at none of the speeds: where R̃ = 0 lies in the window at all,
    it then lies at an end of the speeds too, for which :func:`_forces` finds it.
    """
    p = without_friction(values, direction, 1.0, force)
    drag = p["pitch_radius"] * np.tan(p["lead_angle"]) * p["translation_damping"] * direction
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        balance = np.divide(p["axial_force"], drag)
    balance = np.where(np.isfinite(balance), balance, low)  # else nothing drags: R̃ is the same at every speed
    below, above = np.real(balance) < np.real(low), np.real(balance) > np.real(high)
    if is_window(sheet, "load.force") and np.all(below | above | (np.real(balance) == np.real(low))):
        return []
    nearest = np.where(below, low, np.where(above, high, balance))
    return [nearest + np.multiply.outer(_shares(sheet), end - nearest) for end in (low, high)]


def _forces(sheet: Sheet, values: Mapping[str, Any], direction: int, speed: NDArray) -> list[Any]:
    """Forces [N] that are looked at, each for all speeds (k) or (k, n)."""
    low, high = values["force_low"], values["force_high"]
    if not is_window(sheet, "load.force"):
        return [low]
    if sheet.friction.curve is None and sheet.friction.slope is None:
        return [low, high]
    p = without_friction(values, direction, speed, 0.0)
    free = p["axial_force"] - p["pitch_radius"] * np.tan(p["lead_angle"]) * p["translation_damping"] * p["input_speed"]
    forces = [low, high]
    for end in (low, high):
        for share in _shares(sheet):
            force = free + share * (end - free)
            force = np.where(np.real(force) < np.real(low), low, force)
            forces.append(np.where(np.real(force) > np.real(high), high, force))
    return forces


def _shares(sheet: Sheet) -> NDArray[np.float64]:
    """Shares [1] of the way from R̃ = 0 to an end of the window."""
    return np.linspace(_BESIDE, 1.0, 1 if sheet.support is None else _FORCES_OF_SLOPE)


def worst(sheet: Sheet, values: Mapping[str, Any]) -> dict[str, Worst]:
    """Return the lowest reserve of each mechanism over the window for drives given by arrays (n) or floats.

    ``push_needed`` is among them, see :func:`lsvib.assess.mechanisms.reserves`. NaN where the friction is so strong
    that the drive cannot move at all.
    """
    rows, sizes = [], []
    for direction in directions(sheet):
        speeds, forces = (table[:, None] if table.ndim == 1 else table for table in _points(sheet, values, direction))
        rows.append(reserves(sheet, values, direction, speeds, forces))
        sizes.append(len(speeds))
    found = {}
    for name in (*applicable(sheet), "push_needed"):
        parts = [np.atleast_1d(row[name]) for row in rows]
        width = max(part.shape[-1] for part in parts)
        table = np.concatenate([np.broadcast_to(part, (size, width)) for part, size in zip(parts, sizes, strict=True)])
        lowest = np.argmin(np.where(np.isnan(np.real(table)), -np.inf, np.real(table)), axis=0)
        found[name] = Worst(np.take_along_axis(table, lowest[None], 0)[0], lowest)
    return found
