"""Random drives of every model over the full ranges of their parameters, and starts of each; seeded one by one."""

import math
from typing import NamedTuple

import numpy as np

from lsvib.accuracy.reference.rigid import Drive
from lsvib.accuracy.sweep_families import power, sign
from lsvib.models.parameters import LeadScrew, NutDrive, SupportDrive, ThreadsDrive

MODELS = ("rigid", "threads", "support", "nut")
_ZERO_DAMPING = 0.25  # share of drives without a damping
_ZERO_FORCE = 0.1
_PLACES = ("anywhere", "anywhere", "anywhere", "speed", "contact", "corner", "near", "equilibrium")


class WideDrive(NamedTuple):
    """A drive, the frictions of a second body that it has, and starts of motions (starts, states)."""

    model: str
    seed: int
    index: int
    drive: LeadScrew
    physics: tuple[str, ...]
    starts: np.ndarray


def wide_drive(model: str, seed: int, index: int, starts: int) -> WideDrive:
    """Draw drive ``index`` of a seed, the same whatever else is drawn, and so many starts of it."""
    rng = np.random.default_rng([seed, MODELS.index(model), index])
    drive = LeadScrew.of(_common(rng))
    return WideDrive(model, seed, index, drive, (), _starts(rng, drive, starts))


def _zero_or(rng, share: float, low: float, high: float) -> float:
    return 0.0 if rng.random() < share else power(rng, low, high)


def _common(rng) -> dict[str, float]:
    lead = math.radians(power(rng, math.log10(0.5), math.log10(45.0)))
    friction = power(rng, -3, math.log10(0.9)) if rng.random() < 0.5 else rng.uniform(0.001, 0.9)
    force = sign(rng) * _zero_or(rng, _ZERO_FORCE, -3, 6)
    return {
        "pitch_radius": power(rng, -3, math.log10(0.05)),
        "lead_angle": lead,
        "friction_coefficient": min(friction, 0.999 / math.tan(lead)),
        "mass": power(rng, -2, 4),
        "screw_inertia": power(rng, -9, 1),
        "coupling_stiffness": power(rng, -3, 6),
        "support_damping": _zero_or(rng, _ZERO_DAMPING, -9, 2),
        "translation_damping": _zero_or(rng, _ZERO_DAMPING, -4, 6),
        "axial_force": force,
        "input_speed": sign(rng) * power(rng, -2, 4),
    }


def _starts(rng, drive: LeadScrew, count: int) -> np.ndarray:
    """Starts (count, 2): anywhere over four decades, on θ′ = 0, on Q = 0, on both, near the equilibrium and on it."""
    reference = Drive(dict(drive), 30)
    q_u, q_w, q_0 = (float(x) for x in reference.Q_terms(1, 1))
    speed = drive.input_speed
    size = float(reference.u_scale)
    found = np.empty((count, 2))
    for k in range(count):
        u, w = sign(rng) * size * power(rng, -2, 2), sign(rng) * speed * power(rng, -2, 2)
        place = _PLACES[rng.integers(len(_PLACES))]
        if place in ("speed", "corner"):
            w = -speed
        if place in ("contact", "corner"):
            u = -(q_0 + q_w * w) / q_u
        if place == "near":
            u, w = 1e-8 * u, 1e-8 * w
        found[k] = (0.0, 0.0) if place == "equilibrium" else (u, w)
    return found
