"""Cases at the edge of the domain, family by family, from a seeded generator."""

import math
from collections.abc import Callable, Iterator

import numpy as np
from references.wide_drives import power, rigid_values, sign

from benchmarks.sweeps import cases_four_states
from benchmarks.sweeps.families import Case, CaseFamily, CaseGroup
from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters
from lsvib.steady_sliding import thresholds
from lsvib.steady_sliding.conditions import critical_mass

_MOST_TURNS = 50  # of the fastest oscillation


def cases(family: CaseFamily, count: int, rng: np.random.Generator) -> Iterator[Case]:
    """Yield ``count`` cases of a family."""
    for _ in range(count):
        yield _FAMILIES[family](rng)


def _some_drive(rng, **fixed) -> RigidParameters:
    """A drive like the chapter's: both signs of Γ₊, of R and of Ω, damped in at least one place."""
    support, translation = ((1, 0), (0, 1), (1, 1))[rng.integers(3)]
    values = {
        "mass": rng.uniform(0.5, 30.0),
        "friction_coefficient": rng.uniform(0.05, 0.5),
        "axial_force": sign(rng) * power(rng, 0.0, 2.3),
        "input_speed": sign(rng) * rng.uniform(5.0, 80.0),
        "support_damping": support * power(rng, -4.5, -2.0),
        "translation_damping": translation * rng.uniform(50.0, 2000.0),
    }
    return RigidParameters.of(values | fixed)


def _scales(drive: RigidParameters) -> tuple[float, float]:
    """A natural time 1/ω [s] and a size of u [rad] of a drive."""
    time = math.sqrt(float(coefficients(drive).gamma[-1]) / drive.coupling_stiffness)
    return time, abs(drive.input_speed) * time


def _case(rng, family: CaseFamily, group: CaseGroup, level: float, drive: RigidParameters, start=None) -> Case:
    """Start anywhere on either side of θ′ = 0 and N = 0, and run for some turns of the slow oscillation."""
    time, size = _scales(drive)
    if start is None:
        start = (size * rng.uniform(-5, 5), drive.input_speed * rng.uniform(-5, 5))
    duration = 2 * math.pi * time * rng.uniform(0.3, 4.0)
    return Case(family, group, level, drive, tuple(map(float, start)), min(duration, _MOST_TURNS / _fastest(drive)))


def _fastest(drive: RigidParameters) -> float:
    """Frequency [turns/s] of the fastest oscillation under either law; judges follow it turn by turn."""
    c = coefficients(drive)
    squares = [float(drive.coupling_stiffness / x) - (float(c.damping[s]) / (2 * x)) ** 2 for s, x in
               ((s, float(c.gamma[s])) for s in c.gamma) if x > 0]  # fmt: skip
    return math.sqrt(max([*squares, 0.0])) / (2 * math.pi) or 1e-300


def _critical_mass(rng) -> Case:
    drive = _some_drive(rng, friction_coefficient=rng.uniform(0.11, 0.5))
    level = rng.uniform(-12, -1)
    mass = critical_mass(drive) * (1 + sign(rng) * 10.0**level)
    return _case(rng, CaseFamily.CRITICAL_MASS, CaseGroup.ONLY, level, drive.replace(mass=mass))


def _friction(rng) -> Case:
    drive = _some_drive(rng)
    group = (CaseGroup.ZERO, CaseGroup.TAN_LEAD, CaseGroup.COT_LEAD)[rng.integers(3)]
    level = rng.uniform(-15, -1)
    tan = math.tan(drive.lead_angle)
    if group == CaseGroup.ZERO:
        level = level if rng.random() < 0.9 else -math.inf
        value = 10.0**level
    elif group == CaseGroup.TAN_LEAD:
        value = tan * (1 + sign(rng) * 10.0**level)
    else:
        # Closer, Γ₋ is so large that slip changes θ′ by less than the last digit of w = θ′ − Ω.
        level = max(level, -13.0)
        value = (1 - 10.0**level) / tan
    return _case(rng, CaseFamily.FRICTION, group, level, drive.replace(friction_coefficient=value))


def _input_speed(rng) -> Case:
    level = rng.uniform(-9, 6)
    drive = _some_drive(rng, input_speed=sign(rng) * 10.0**level)
    return _case(rng, CaseFamily.INPUT_SPEED, CaseGroup.ONLY, level, drive)


THRESHOLDS: dict[CaseGroup, tuple[Callable[[RigidParameters], float], dict[str, float]]] = {
    CaseGroup.ONSET_FORCE: (thresholds.onset_force, {"translation_damping": 1e3}),
    CaseGroup.STICK_FORCE: (thresholds.stick_force, {"translation_damping": 1e3}),
    CaseGroup.DETACH_FORCE: (thresholds.detach_force, {"translation_damping": 1e3}),
    CaseGroup.GLOBAL_STABILITY_FORCE: (thresholds.global_stability_force, {"mass": 11.0, "support_damping": 1e-3}),
}


def threshold(group: CaseGroup) -> tuple[float, RigidParameters]:
    """Return a threshold of the axial force [N] and the drive of the chapter that has it."""
    compute, changes = THRESHOLDS[group]
    drive = RigidParameters.of(changes)
    return compute(drive), drive


def _axial_force(rng) -> Case:
    group = (CaseGroup.ZERO, *THRESHOLDS)[rng.integers(1 + len(THRESHOLDS))]
    if group == CaseGroup.ZERO:
        level = rng.uniform(-15, -1) if rng.random() < 0.7 else -math.inf
        drive = _some_drive(rng, axial_force=sign(rng) * 10.0**level)
    else:
        level = rng.uniform(-10, -1)
        force, drive = threshold(group)
        drive = drive.replace(axial_force=force * (1 + sign(rng) * 10.0**level))
    return _case(rng, CaseFamily.AXIAL_FORCE, group, level, drive)


def _support_damping(rng) -> Case:
    level = rng.uniform(-12, 15) if rng.random() < 0.9 else -math.inf
    return _case(rng, CaseFamily.SUPPORT_DAMPING, CaseGroup.ONLY, level, _some_drive(rng, support_damping=10.0**level))


def _translation_damping(rng) -> Case:
    level = rng.uniform(-9, 15) if rng.random() < 0.9 else -math.inf
    drive = _some_drive(rng, translation_damping=10.0**level)
    return _case(rng, CaseFamily.TRANSLATION_DAMPING, CaseGroup.ONLY, level, drive)


def _time_span(rng) -> Case:
    level = rng.uniform(-9, 0)
    case = _case(rng, CaseFamily.TIME_SPAN, CaseGroup.ONLY, level, _some_drive(rng))
    return case._replace(duration=10.0**level)


def _start(rng) -> Case:
    drive = _some_drive(rng)
    _, size = _scales(drive)
    c = coefficients(drive)
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    u, w = size * rng.uniform(-5, 5), drive.input_speed * rng.uniform(-5, 5)
    rest = -drive.input_speed
    group = CaseGroup(rng.integers(CaseGroup.ON_SPEED_ZERO, CaseGroup.FAR_AWAY + 1))
    small = 1e-8 * rng.uniform(0.5, 1)
    start = {
        CaseGroup.ON_SPEED_ZERO: (u, rest),
        CaseGroup.ON_CONTACT_ZERO: (-(q_0 + q_w * w) / q_u, w),
        CaseGroup.ON_CORNER: (-(q_0 + q_w * rest) / q_u, rest),
        CaseGroup.ON_EQUILIBRIUM: (0.0, 0.0),
        CaseGroup.NEAR_EQUILIBRIUM: (small * u, small * w),
        CaseGroup.FAR_AWAY: (u / small, w / small),
    }[group]
    return _case(rng, CaseFamily.START, group, 0.0, drive, start)


def _double_rate(rng) -> Case:
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
    group = CaseGroup.LAW_PLUS if law > 0 else CaseGroup.LAW_MINUS
    damped = drive.replace(support_damping=critical * (1 + sign(rng) * 10.0**level))
    return _case(rng, CaseFamily.DOUBLE_RATE, group, level, damped)


def _random(rng) -> Case:
    drive = RigidParameters.of(rigid_values(rng))
    return _case(rng, CaseFamily.RANDOM, CaseGroup.ONLY, math.log10(drive.mass), drive)


_FAMILIES: dict[CaseFamily, Callable[[np.random.Generator], Case]] = {
    CaseFamily.CONTACT: cases_four_states.contact,
    CaseFamily.CRITICAL_MASS: _critical_mass,
    CaseFamily.FRICTION: _friction,
    CaseFamily.INPUT_SPEED: _input_speed,
    CaseFamily.AXIAL_FORCE: _axial_force,
    CaseFamily.SUPPORT_DAMPING: _support_damping,
    CaseFamily.TRANSLATION_DAMPING: _translation_damping,
    CaseFamily.TIME_SPAN: _time_span,
    CaseFamily.START: _start,
    CaseFamily.DOUBLE_RATE: _double_rate,
    CaseFamily.RANDOM: _random,
    CaseFamily.SUPPORT: cases_four_states.support,
    CaseFamily.NUT: cases_four_states.nut,
}
