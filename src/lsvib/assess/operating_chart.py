"""The operating chart: what occurs where, over the speed of the load and the force on it, and its named boundaries."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.drive import GRAVITY
from lsvib.assess.mechanisms import applicable, directions, drive_of, reserves
from lsvib.assess.sheet import Sheet
from lsvib.errors import EngineError, InputError
from lsvib.stability import force_thresholds

KINDS = ("steady", "steady_until_pushed", "negative_damping", "kinematic_constraint", "mode_coupling",
         "falling_friction", "thread_contact")  # fmt: skip
"""What the chart distinguishes, by flag value."""

_POINTS = 161  # along each axis: a step is finer than a line of the picture
_BEYOND = 1.5  # the chart goes on beyond the window by this factor, so that what lies near is seen
_BOUNDARIES = {
    "onset_force": "the load begins to push with the motion",
    "stick_force": "the oscillation reaches standstill (stick-slip)",
    "detach_force": "the threads no longer lose contact",
    "global_stability_force": "a perturbation can start vibration",
}


@dataclass(frozen=True)
class Chart:
    """One direction of travel: ``kind`` (force, speed) as flags of :data:`KINDS`, ``speed`` of the load [m/s] and
    ``force`` against outward travel [N]; ``boundaries``: forces (speed) by what begins or ends there.
    """

    direction: int
    speed: NDArray[np.float64]
    force: NDArray[np.float64]
    kind: NDArray[np.int8]
    boundaries: dict[str, NDArray[np.float64]]


def charts(sheet: Sheet, values: dict[str, float]) -> list[Chart]:
    """Return the operating chart at given values, one for each direction of travel that is used."""
    lead = values["lead"] / (2 * math.pi)  # travel per radian
    top = _BEYOND * values["speed_high"]
    turning = np.linspace(top / _POINTS, top, _POINTS)
    weight = values["mass"] * GRAVITY * math.sin(values["tilt"])
    ends = (values["force_low"], values["force_high"], 0.0, -weight)
    room = (_BEYOND - 1) * max(max(ends) - min(ends), 0.1 * max(map(abs, ends)), 1.0)
    force = np.linspace(min(ends) - room, max(ends) + room, _POINTS)
    return [
        Chart(
            direction, lead * turning, force, _kinds(sheet, values, direction, turning, force),
            _boundaries(sheet, values, direction, turning, weight),
        )
        for direction in directions(sheet)
    ]  # fmt: skip


def _kinds(
    sheet: Sheet, values: dict[str, float], direction: int, turning: NDArray, force: NDArray
) -> NDArray[np.int8]:
    """Flag of the first mechanism in the order of :data:`KINDS` that occurs at each point (force, speed)."""
    found = reserves(sheet, values, direction, turning[None, :], force[:, None])
    shape = (force.size, turning.size)
    kind = np.where(np.broadcast_to(found["push_needed"], shape) < 0, KINDS.index("steady_until_pushed"), 0)
    for name in reversed([name for name in KINDS if name in applicable(sheet)]):
        kind = np.where(np.broadcast_to(found[name], shape) < 0, KINDS.index(name), kind)
    return kind.astype(np.int8)


def _boundaries(
    sheet: Sheet, values: dict[str, float], direction: int, turning: NDArray, weight: float
) -> dict[str, NDArray]:
    """Forces at which the motion changes its kind, from the thresholds of the rigid drive.

    All of them are proportional to Ω: with Ω and R multiplied alike, every motion of the drive is multiplied alike. So
    one threshold gives a line. With friction that depends on speed they are left out.
    """
    if values["friction_slope"] != 0 or sheet.friction.curve is not None:
        return {}
    found = {}
    speed = float(turning[-1])
    drive = drive_of(sheet, values, direction, speed, 0.0)
    if drive.translation_damping > 0 and drive.friction_coefficient > math.tan(drive.lead_angle):
        lever = drive.pitch_radius * math.tan(drive.lead_angle)
        found[_BOUNDARIES["onset_force"]] = -lever * drive.translation_damping * direction * turning - weight
    if sheet.support is not None or sheet.contact is not None:  # the other thresholds are those of rigid parts
        return found
    for name in ("stick_force", "detach_force", "global_stability_force"):
        try:
            force = getattr(force_thresholds, name)(drive)
        except (InputError, EngineError):
            continue
        found[_BOUNDARIES[name]] = -force * turning / speed - weight
    return found
