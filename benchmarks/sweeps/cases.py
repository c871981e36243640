"""Cases at the edge of the domain, family by family, from a seeded generator."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from references.drives import random_drive, rigid_values, sign, uniform

from benchmarks.sweeps import cases_four_states, cases_of_laws
from benchmarks.sweeps.families import Case, CaseFamily
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.stability.boundaries import place_values
from lsvib.stability.force_thresholds import threshold_force

_MOST_TURNS = 50  # of the fastest oscillation
THRESHOLDS = (
    ("onset", Drive.of(translation_damping=1e3)),
    ("stick", Drive.of(translation_damping=1e3)),
    ("detach", Drive.of(translation_damping=1e3)),
    ("global_stability", Drive.of(mass=11.0, support_damping=1e-3)),
)


_some_drive = partial(random_drive, mass=uniform(0.5, 30.0))


def cases(family: CaseFamily, count: int, rng: np.random.Generator) -> Iterator[Case]:
    """Yield ``count`` cases of a family."""
    for _ in range(count):
        if family in _WHOLE:
            yield _WHOLE[family](rng)
        else:
            yield _case(rng, family, *_RIGID[family](rng))


def _scales(drive: Drive) -> tuple[float, float]:
    """A natural time 1/ω [s] and a size of u [rad] of a drive."""
    time = math.sqrt(float(coefficients(drive).gamma[-1]) / drive.coupling_stiffness)
    return time, abs(drive.input_speed) * time


def _case(rng, family: CaseFamily, level: float, drive: Drive, start=None) -> Case:
    """Start anywhere on either side of θ′ = 0 and N = 0, and run for some turns of the slow oscillation."""
    time, size = _scales(drive)
    if start is None:
        start = (size * rng.uniform(-5, 5), drive.input_speed * rng.uniform(-5, 5))
    duration = min(2 * math.pi * time * rng.uniform(0.3, 4.0), _MOST_TURNS / _fastest(drive))
    if family == CaseFamily.TIME_SPAN:
        duration = 10.0**level
    return Case(family, level, drive, tuple(map(float, start)), duration)


def _fastest(drive: Drive) -> float:
    """Frequency [turns/s] of the fastest oscillation under either law; judges follow it turn by turn."""
    c = coefficients(drive)
    squares = [float(drive.coupling_stiffness / x) - (float(c.damping[s]) / (2 * x)) ** 2 for s, x in
               ((s, float(c.gamma[s])) for s in c.gamma) if x > 0]  # fmt: skip
    return math.sqrt(max([*squares, 0.0])) / (2 * math.pi) or 1e-300


# A family: its level, a drive, and perhaps a start.
def _critical_mass(rng):
    drive = _some_drive(rng, friction_coefficient=rng.uniform(0.11, 0.5))
    level = rng.uniform(-12, -1)
    return level, drive.replace(
        mass=place_values(drive, "kinematic_constraint", "mass")[0] * (1 + sign(rng) * 10.0**level)
    )


def _friction(rng):
    drive = _some_drive(rng)
    edge = rng.integers(3)
    level = rng.uniform(-15, -1)
    tan = math.tan(drive.lead_angle)
    if edge == 0:
        level = level if rng.random() < 0.9 else -math.inf
        value = 10.0**level
    elif edge == 1:
        value = tan * (1 + sign(rng) * 10.0**level)
    else:
        # Closer, Γ₋ is so large that slip changes θ′ by less than the last digit of w = θ′ − Ω.
        level = max(level, -13.0)
        value = (1 - 10.0**level) / tan
    return level, drive.replace(friction_coefficient=value)


def _axial_force(rng):
    edge = rng.integers(1 + len(THRESHOLDS))
    if edge == 0:
        level = rng.uniform(-15, -1) if rng.random() < 0.7 else -math.inf
        return level, _some_drive(rng, axial_force=sign(rng) * 10.0**level)
    level = rng.uniform(-10, -1)
    name, drive = THRESHOLDS[edge - 1]
    return level, drive.replace(axial_force=threshold_force(drive, name) * (1 + sign(rng) * 10.0**level))


def _over_decades(key: str, low: float, high: float):
    """A damping over decades, zero in a tenth of the cases."""

    def found(rng):
        level = rng.uniform(low, high) if rng.random() < 0.9 else -math.inf
        return level, _some_drive(rng, **{key: 10.0**level})

    return found


def _input_speed(rng):
    level = rng.uniform(-9, 6)
    return level, _some_drive(rng, input_speed=sign(rng) * 10.0**level)


def _time_span(rng):
    return rng.uniform(-9, 0), _some_drive(rng)


def _start(rng):
    """On θ′ = 0, on N = 0, on both, on and next to the equilibrium, far away."""
    drive = _some_drive(rng)
    _, size = _scales(drive)
    q_u, q_w, q_0 = (float(x) for x in coefficients(drive).q_row)
    u, w = size * rng.uniform(-5, 5), drive.input_speed * rng.uniform(-5, 5)
    rest = -drive.input_speed
    place = rng.integers(6)
    small = 1e-8 * rng.uniform(0.5, 1)
    starts = (
        (u, rest),
        (-(q_0 + q_w * w) / q_u, w),
        (-(q_0 + q_w * rest) / q_u, rest),
        (0.0, 0.0),
        (small * u, small * w),
        (u / small, w / small),
    )
    return 0.0, drive, starts[place]


def _double_rate(rng):
    """c at which C_s² = 4 Γ_s k, by the drive's own 50 digits rounded once, then moved by 10^level of itself."""
    while True:
        drive = _some_drive(rng, support_damping=0.0)
        law = sign(rng)
        c = coefficients(drive)
        if c.gamma[law] <= 0:
            continue
        critical = 2 * (float(c.gamma[law]) * drive.coupling_stiffness) ** 0.5 - float(c.damping[law])
        if critical > 0:
            break
    level = rng.uniform(-17, -1)
    return level, drive.replace(support_damping=critical * (1 + sign(rng) * 10.0**level))


def _random(rng):
    drive = Drive.of(rigid_values(rng))
    return math.log10(drive.mass), drive


_RIGID: dict[CaseFamily, Callable[[Any], tuple]] = {
    CaseFamily.CRITICAL_MASS: _critical_mass,
    CaseFamily.FRICTION: _friction,
    CaseFamily.INPUT_SPEED: _input_speed,
    CaseFamily.AXIAL_FORCE: _axial_force,
    # Above 1e12 N m s/rad a chain of seizures within 1e-13 s may end in a wrong slip; no drive is damped so much.
    CaseFamily.SUPPORT_DAMPING: _over_decades("support_damping", -12, 12),
    CaseFamily.TRANSLATION_DAMPING: _over_decades("translation_damping", -9, 15),
    CaseFamily.TIME_SPAN: _time_span,
    CaseFamily.START: _start,
    CaseFamily.DOUBLE_RATE: _double_rate,
    CaseFamily.RANDOM: _random,
}
_WHOLE: dict[CaseFamily, Callable[[Any], Case]] = {
    CaseFamily.CONTACT: cases_four_states.contact,
    CaseFamily.SUPPORT: cases_four_states.support,
    CaseFamily.NUT: cases_four_states.nut,
    CaseFamily.FRICTION_LAW: cases_of_laws.friction_law,
    CaseFamily.VANISHING_FRICTION: cases_of_laws.vanishing_friction,
    CaseFamily.GRAZING: cases_of_laws.grazing,
    CaseFamily.LAW_AND_PARTS: cases_of_laws.law_and_parts,
}
