"""Cases of friction laws: steep and slow transitions, friction that vanishes, slip that just touches zero, parts."""

import math

import numpy as np
from flint import arb, arb_mat, ctx
from references.drives import decades, drive_with_parts, heaviest, random_drive, sign, uniform
from references.series import SPARE, TERMS, Arc, Series

from benchmarks.sweeps.families import Case, CaseFamily
from lsvib.drives.drive import Drive

_MOST = 10.0  # of static over kinetic friction
_FASTEST = 10.0  # sliding speed, in those of steady sliding, up to which a growing law stays out of the Painlevé region
_STEPS = 30  # of a series, backwards from a touch
_BOUND = {"support": "slide_friction", "threads": "slide_friction", "nut": "bearing_friction"}  # no law goes with these


def _law(rng, drive: Drive, level: float) -> dict[str, float]:
    """Friction that rises to rest, over a speed of 10^level of that of steady sliding, by Stribeck or at once."""
    mu = drive.friction_coefficient
    top = mu * min(_MOST, 0.99 / (mu * math.tan(drive.lead_angle))) ** rng.uniform(0, 1)
    share = rng.choice((1.0, rng.uniform(0.01, 0.99)))
    return {
        "static_friction_coefficient": top if share < 1 else 0.0,
        "stribeck_rise": share * (top - mu),
        "stribeck_speed": 10.0**level * sliding(drive),
        "stribeck_exponent": int(rng.integers(1, 3)),
    }


def sliding(drive: Drive) -> float:
    """Sliding speed of steady sliding [m/s]."""
    return drive.pitch_radius * abs(drive.input_speed) / math.cos(drive.lead_angle)


def _sloped(rng, drive: Drive) -> Drive:
    """The drive with a law that grows on, or falls to zero at ten times the speed of steady sliding or more, or not."""
    mu, speed = drive.friction_coefficient, sliding(drive)
    slope = mu / speed * rng.choice((0.0, -decades(rng, -2, -1), decades(rng, -2, 0)))
    if slope > 0:  # what follows where friction grows into the Painlevé region is not determined
        most = dict(drive) | {"friction_coefficient": mu + drive.stribeck_rise + slope * _FASTEST * speed}
        drive = drive.replace(mass=min(drive.mass, 0.9 * heaviest(most, drive.screw_inertia)))
    return drive.replace(friction_slope=slope)


def _turn(drive: Drive) -> float:
    """Period [s] of the screw on its coupling."""
    return math.tau * math.sqrt(drive.screw_inertia / drive.coupling_stiffness)


def _case(rng, family: CaseFamily, level: float, drive: Drive, start=None) -> Case:
    """Start anywhere on either side of θ′ = 0 and N = 0, and run for some turns of the slow oscillation."""
    if start is None:
        size = abs(drive.input_speed) * _turn(drive) / math.tau
        start = (size * rng.uniform(-5, 5), drive.input_speed * rng.uniform(-5, 5))
    return Case(family, level, drive, tuple(map(float, start)), _turn(drive) * rng.uniform(0.3, 3.0))


def friction_law(rng) -> Case:
    """Transition speeds of 1e-6 to 10 Ω, static friction of 1 to 10 times the kinetic one, slopes of either sign."""
    drive, level = random_drive(rng, mass=uniform(0.5, 30.0)), rng.uniform(-6, 1)
    return _case(rng, CaseFamily.FRICTION_LAW, level, _sloped(rng, drive.replace(**_law(rng, drive, level))))


def vanishing_friction(rng) -> Case:
    """A slope at which friction of steady sliding is zero but for 10^level of the kinetic one, or would be negative."""
    drive, level = random_drive(rng, mass=uniform(0.5, 30.0)), rng.uniform(-15, -0.3)
    slope = -drive.friction_coefficient / sliding(drive) * (1 + sign(rng) * 10.0**level)
    law = _law(rng, drive, rng.uniform(-3, 0)) if rng.random() < 0.5 else {}
    return _case(rng, CaseFamily.VANISHING_FRICTION, level, drive.replace(friction_slope=slope, **law))


def grazing(rng) -> Case:
    """A start from which slip just touches θ′ = 0, found backwards from there, moved by 10^level of itself."""
    drive, level = random_drive(rng, axial_force=sign(rng) * decades(rng, 1.3, 2.5)), rng.uniform(-7, -1)
    drive = _sloped(rng, drive.replace(**_law(rng, drive, rng.uniform(-1.5, 1))))
    slow = dict(drive) | {"friction_coefficient": drive.friction_coefficient + drive.stribeck_rise}
    drive = drive.replace(mass=min(drive.mass, 0.9 * heaviest(slow, drive.screw_inertia)))
    u, w = before_touch(drive, _turn(drive) * rng.uniform(0.1, 0.6))
    return _case(rng, CaseFamily.GRAZING, level, drive, (u * (1 + sign(rng) * 10.0**level), w))


def before_touch(drive: Drive, duration: float) -> tuple[float, float]:
    """State so long before θ′ and θ″ are zero at once, or as long as the contact force keeps its sign."""
    laws = Series(drive)
    with ctx.workdps(laws.digits + SPARE):
        p, side, far = laws.p, 1 if drive.axial_force > 0 else -1, _FASTEST * abs(drive.input_speed)
        mode = {"slip": laws.sense, "contact": side}
        wound = -laws.lever(laws.sense * side, laws.mu(arb(0))) * p["axial_force"] / p["coupling_stiffness"]
        place = arb_mat([[x] for x in (wound, arb(0), p["input_speed"], arb(0), arb(0), arb(1))])
        for _ in range(_STEPS):
            arc = Arc(laws, place, mode)
            places = [one.mid() for one in arc.coefficients(place, TERMS)[0]]
            step = -min(arc.step(places), duration / _STEPS)
            before = sum((one * arb(step) ** k for k, one in enumerate(places)), 0 * place).mid()
            if min(arc.exactly(k, before) for k in range(len(arc.form.margins))) <= 0 or abs(laws.speed(before)) > far:
                break
            place = before
        u, w = (np.array(place.entries()[: laws.size]) - laws.steady).astype(float)
    return u, w


def law_and_parts(rng) -> Case:
    """Any parts, with a motor in half of the cases or a collar in some, and friction of guide and bearing."""
    collar = rng.random() < 0.2
    drive, start = drive_with_parts(int(rng.integers(2**31)), collar=collar, motor=not collar and rng.random() < 0.5)
    level = rng.uniform(-6, 1)
    dropped = {_BOUND[part]: 0.0 for part in drive.parts if part in _BOUND}
    plain = dict.fromkeys(("friction_slope", "stribeck_rise", "static_friction_coefficient"), 0.0)
    drive = drive.replace(**plain, **dropped)
    return Case(
        CaseFamily.LAW_AND_PARTS, level, drive.replace(**_law(rng, drive, level)), tuple(map(float, start)), 0.05
    )
