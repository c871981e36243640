"""The operating chart: what happens at each speed and force of a data sheet, at its middle values."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.sheets.draw import Draw
from lsvib.sheets.from_rest import outcomes
from lsvib.sheets.operation import Operation
from lsvib.sheets.window import applicable

KINDS = ("steady", "steady_until_perturbed", "steady_once_started", "steady_when_left_alone", "jerks_from_rest",
         "negative_damping", "kinematic_constraint", "mode_coupling", "falling_friction", "thread_contact")  # fmt: skip
"""What the chart distinguishes, by flag value."""


@dataclass(frozen=True)
class Chart:
    """One direction of travel: ``kind`` (force, speed) as flags of :data:`KINDS`, ``speed`` of the load [m/s] and
    ``force`` against outward travel [N].
    """

    direction: int
    speed: NDArray[np.float64]
    force: NDArray[np.float64]
    kind: NDArray[np.int8]


def charts(draw: Draw) -> list[Chart]:
    """Return the operating chart at given values, half as far again as the window, one for each direction of travel."""
    values, weight = draw.values, draw.weight
    top, points = 1.5 * values["speed_high"], 161  # a step is finer than a line of the picture
    turning = np.linspace(top / points, top, points)
    ends = (values["force_low"], values["force_high"], 0.0, -weight)
    room = 0.5 * max(max(ends) - min(ends), 0.1 * max(map(abs, ends)), 1.0)
    force = np.linspace(min(ends) - room, max(ends) + room, points)
    return [
        Chart(way, draw.travel * turning, force, _kinds(draw, way, turning, force)) for way in draw.sheet.directions
    ]


def _kinds(draw: Draw, direction: int, turning: NDArray[Any], force: NDArray[Any]) -> NDArray[np.int8]:
    """Flag of the first mechanism in the order of :data:`KINDS` that occurs at each point (force, speed)."""
    there = Operation(draw, direction, turning[None, :], force[:, None])
    found, p, shape = there.reserves, there.parameters, (force.size, turning.size)
    drag = p["pitch_radius"] * np.tan(p["lead_angle"]) * p["translation_damping"]
    ratio = np.abs(p["axial_force"] - drag * p["input_speed"]) / turning  # |R̃ / Ω|
    kind = np.zeros(shape, dtype=np.int8)
    blind = draw.sheet.friction.law or draw.sheet.dry  # of which the reserve after a perturbation knows nothing
    maybe = np.broadcast_to((found["after_perturbation"] < 0) | blind, shape)
    if maybe.any():
        last = _fatal_ratio(draw, direction, ratio[maybe].max(), drag)
        upset = KINDS.index("steady_once_started" if last is None else "steady_until_perturbed")
        kind[maybe & (ratio <= (math.inf if last is None else last))] = upset
    started = outcomes(draw, direction, turning, force)
    kind[np.isnan(started)] = KINDS.index("steady_when_left_alone")  # what a start becomes is not known
    kind[started == 0] = KINDS.index("jerks_from_rest")
    for name in reversed([name for name in KINDS if name in applicable(draw.sheet)]):
        kind = np.where(np.broadcast_to(found[name], shape) < 0, KINDS.index(name), kind)
    return kind.astype(np.int8)


def _fatal_ratio(draw: Draw, direction: int, most: float, drag: float) -> float | None:
    """The |R̃ / Ω| up to ``most`` [N s/rad] below which a perturbation starts vibration, to 0.3 %; None if not known.

    With Ω and R̃ multiplied alike every motion is; and beyond some force against the motion none ends in vibration.
    """
    if not draw.sheet.closed:
        return None
    speed, (low, high) = draw.values["speed_high"], (1e-4 * most, most)
    for _ in range(12):
        ratio = math.sqrt(low * high)
        size, _ = Operation(draw, direction, speed, direction * speed * (ratio - drag) - draw.weight).tolerated
        if not size:  # not known, or zero as nothing damps the drive
            return None
        low, high = (low, ratio) if size == math.inf else (ratio, high)
    return high
