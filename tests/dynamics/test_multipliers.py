"""Exact derivatives of motions and multipliers of cycles against references in many digits, over random drives.

Of motions, against central differences with 40 digits: the step 1e-10 leaves their truncation at 1e-20 of the third
derivative; the reference has no events missed and no rounding at this size. Tolerance 1e-9 of the largest entry, as the
library promises for multipliers, and the library's own bound of its rounding, with a factor for the rounding of the
event times and states.

Of cycles, attracting and repelling ones: the reference follows a period from a place within the longest arc, and from
places beside it. The map over the period has the eigenvalues 1, along the motion, and the multipliers: no saltation
matrix and no derivative of a flow enters, and of the library only the place and the period. With four states the
tolerance is 1e-9 of the larger of 1 and the multiplier, and the library's own bound; the state of a cycle that repels
by a factor beyond 1e4 is known to rounding times that factor, and its multiplier as well.
"""

import math
from itertools import permutations

import numpy as np
import pytest
from flint import arb, ctx
from mpmath import mp, mpf
from references.drives import DRIVES, drawn, law_starts, one_of, power, threads_drive, uniform
from references.series import Series
from references.sizes import sizes

import lsvib
from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import seated_state, standing_state
from lsvib.drives.names import Event
from lsvib.errors import EngineError
from lsvib.systems.attractor import Attractor, steady_state
from lsvib.systems.cycles import cycle_of
from lsvib.systems.motion import follow
from lsvib.systems.section import Section, derivative, section_key

STEP = arb(10) ** -10
EVENTS = 7
RIGID = {
    "mass": uniform(2, 16), "support_damping": power(-4, -2.5), "translation_damping": one_of(0.0, 10.0, 1000.0),
    "axial_force": uniform(-60, 60), "input_speed": one_of(-40.0, 40.0),
}  # fmt: skip


def random_rigid(seed):
    rng = np.random.default_rng(seed)
    return Drive.of(drawn(rng, RIGID)), (float(rng.uniform(-0.2, 0.2)), float(rng.uniform(-100, 100)))


def differences(end, place, size, step):
    """The derivative of a later state by one at a place; rows, in sizes of the motion; None if that is not determined.

    ``end``: the later state, None where nothing determines that.
    """
    columns = []
    for k, unit in enumerate(size):
        beside = [[arb(x) + way * step * arb(unit) * (j == k) for j, x in enumerate(place)] for way in (1, -1)]
        ends = [end(x) for x in beside]
        if any(one is None for one in ends):
            return None
        columns.append((ends[0] - ends[1]) / (2 * step) / size)
    return np.array(columns).T


def held_by_differences(motion, start, drive):
    """Hold the derivative of a motion against differences with 40 digits.

    To the tolerance and four times the library's own bound of its rounding; returns that bound.
    """
    size, seen, laws = np.abs(np.vstack([motion.after, [start]])).max(axis=0), [], Series(drive)
    count, duration = motion.time.size, float(motion.time[-1]) * 1.01 + 1e-4

    def end(x):
        *events, _ = laws.follow(x, duration, count)[1]
        seen.append([(event.kind, event.mode) for event in events])
        return events[-1].state if seen[-1] == seen[0] and len(events) == count else None

    with ctx.workdps(60):
        reference = differences(end, start, size, STEP).astype(float)
    matrix, rounding = (part * size / size[:, None] for part in derivative(motion))
    away, largest = np.abs(matrix - reference), np.abs(reference).max()
    rows = np.abs(reference).max(axis=1, keepdims=True)
    assert (away <= 1e-9 * largest + 4 * rounding).all()
    assert (away <= 1e-7 * rows + 4 * rounding).all()
    return rounding


def qualified(motion):
    """Whether neighbours of a motion's start have the same events: it neither begins with one nor touches."""
    return motion.time.size and motion.time[0] > 0 and (motion.kind >= 2).all()


def rigid_motion(seed):
    """A random drive, and a motion of it that has events."""
    for attempt in range(50):
        drive, start = random_rigid(1000 * seed + attempt)
        motion = follow(automaton_of(drive), start, np.inf, max_events=EVENTS)
        if qualified(motion):
            return drive, start, motion
    raise AssertionError("no motion has events")


@pytest.mark.parametrize("seed", range(6))
def test_rigid_drives(seed):
    drive, start, motion = rigid_motion(seed)
    rounding = held_by_differences(motion, start, drive)
    assert (rounding <= 1e-10).all()  # so that its share of what is allowed is small


def test_compliant_threads():
    for attempt in range(50):
        rng = np.random.default_rng(attempt)
        rigid, (u, w) = random_rigid(attempt)
        stiffness = float(10 ** rng.uniform(5, 8))
        contact = {"contact_stiffness": stiffness, "contact_damping": stiffness * 10 ** rng.uniform(-3, 0)}
        drive = threads_drive(**dict(rigid), **contact)
        start = seated_state(drive, 0.1 * u, 0.1 * w)
        start[3] = 1e-6
        motion = follow(automaton_of(drive), start, np.inf, max_events=4)
        if qualified(motion):
            break
    assert qualified(motion)
    held_by_differences(motion, start, drive)


def test_a_section_with_a_coordinate_that_is_zero_throughout():
    """Its scale was zero, and the section divided by it."""
    drive = threads_drive(mass=11.0, axial_force=50.0)
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, 0.003, -20.0), np.inf, max_events=40)
    key, size = section_key(motion), np.abs(motion.after).max(axis=0)
    ours = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    origin, size = motion.after[ours[-1]].copy(), size.copy()
    origin[2] = size[2] = 0.0
    section = Section(automaton, key, origin, size, 1, 1.0)
    assert np.isfinite(section.directions).all()
    assert (section.place(origin) == 0).all()


KINDS = ("threads", "support", "nut")


# Drives of which slip that repels may bound the basin of steady sliding; and drives below or above the critical mass.
ON_AN_EDGE = {"mass": uniform(9.5, 9.95), "translation_damping": power(2.9, 3.1), "axial_force": uniform(6, 14)}
ANYWHERE = RIGID | {"mass": uniform(4, 16)}
NUT = {"nut_inertia": power(-3, -1), "nut_stiffness": power(2, 5), "nut_damping": power(-2, 1)}


def second_body(model, rng):
    if model == "threads":
        stiffness = power(6, 9)(rng)
        return {"contact_stiffness": stiffness, "contact_damping": stiffness * power(-4, -1)(rng)}
    if model == "support":
        stiffness, mass = power(7, 9)(rng), power(0, 2)(rng)
        damping = stiffness * power(-5, -3)(rng)
        return {"screw_mass": mass, "support_stiffness": stiffness, "axial_support_damping": damping}
    return drawn(rng, NUT)


def place_and_size(cycle):
    """The middle of the longest slip of a cycle, and the sizes of its coordinates."""
    modes, _, _, durations = cycle.orbit.arcs()
    slips = ~cycle.orbit.automaton.marked(cycle.orbit.automaton.codes[modes], "rest")
    arc = int(np.argmax(durations * slips))
    place = cycle.orbit.at([np.concatenate([[0.0], cycle.orbit.time])[arc] + 0.5 * durations[arc]])[0][0]
    return place, np.maximum(np.abs(cycle.orbit.after).max(axis=0), np.abs(place))


def assert_digits(cycle):
    """Hold a cycle of four states against the reference with 70 digits."""
    place, size = place_and_size(cycle)
    laws = Series(cycle.drive, digits=70)

    def end(x):
        return laws.follow(x, cycle.period, 1000)[1][-1].state

    with ctx.workdps(100), mp.workdps(70):
        gap = (end(place) - place) / size
        matrix = differences(end, place, size, arb(10) ** -30)
        rows = mp.matrix([[mpf(x.mid()) for x in row] for row in matrix])
        found = [complex(z) for z in mp.eig(rows, left=False, right=False)]
    found.remove(min(found, key=lambda z: abs(z - 1)))  # along the motion
    scale = max(1.0, *map(abs, found))
    error = min(max(abs(a - b) for a, b in zip(cycle.multipliers, order, strict=True)) for order in permutations(found))
    assert error <= max(1e-9, 1e-13 * scale) * scale, (cycle.multipliers, found)
    assert error <= cycle.multiplier_error + 1e-14 * scale
    assert cycle.attracting == (max(map(abs, found)) < 1) or cycle.neutral
    assert max(abs(float(x)) for x in gap) <= 1e-11 * scale


def cycles_of(model, seed, draws, sides):
    """Cycles of the first random drive of a seed that has them on these sides of the unit circle."""
    rng = np.random.default_rng([seed, len(model)])
    for _ in range(60):
        values = drawn(rng, draws)
        cycles = DRIVES[model](values | second_body(model, rng)).cycles().cycles
        if sides <= {cycle.attracting for cycle in cycles}:
            return cycles
    raise AssertionError("no drive has such cycles")


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS)
@pytest.mark.parametrize(("draws", "sides"), [(ON_AN_EDGE, {True, False}), (ANYWHERE, {True})], ids=["edge", "any"])
def test_cycles_of_a_drive(model, draws, sides):
    for cycle in cycles_of(model, 0, draws, sides):
        assert_digits(cycle)


BESIDE = 1e-7  # of the differences, over the size of the motion


def of_a_period(drive, cycle):
    """Return relative errors of the period and of closure, and the multiplier; None where nothing determines them."""
    (place, size), laws = place_and_size(cycle), Series(drive)

    def end(state, duration=cycle.period):
        last = laws.follow(state, duration, 1000)[1][-1]
        return last.state if last.kind == "end" else None

    with ctx.workdps(60):
        back, matrix = end(place), differences(end, place, size, arb(BESIDE))
        if back is None or matrix is None:
            return None
        gap = ((back - place) / size).astype(float)
        rate = ((end(place, 1e-9) - place) / 1e-9 / size).astype(float)
        return abs(gap @ rate) / (rate @ rate) / cycle.period, np.abs(gap).max(), float(matrix.trace() - 1)


def jams(drive, orbit):
    speeds, laws = orbit.before[orbit.kind == Event.SEIZURE, 1] + drive.input_speed, Series(drive)
    return any(abs(laws.inertia(arb(speed))) <= 1e-7 for speed in speeds)


def agrees(drive, cycle):
    """Assert that a cycle agrees with the reference; return whether that determines it."""
    found = of_a_period(drive, cycle)
    if found is None:
        return False
    late, gap, multiplier = found
    assert late <= 1e-13, drive
    assert gap <= 1e-13, drive
    # Before Γ₊ = 0 the acceleration grows to 1e8 of its size, and what rounding does to derivatives with it.
    assert abs(cycle.multiplier - multiplier) <= (1e-4 if jams(drive, cycle.orbit) else 2e-9), (drive, multiplier)
    return True


@pytest.mark.parametrize(("slope", "rise"), [(0.2, 0.016), (1.0, 0.087), (4.0, 0.284)])
@pytest.mark.parametrize("speed", [8.0, -8.0])
def test_cycles_of_pure_slip(speed, slope, rise):
    """Steady sliding where friction falls most steeply; at both ends of the vibration friction grows with the speed."""
    sliding = lsvib.Drive().pitch_radius * abs(speed) / math.cos(lsvib.Drive().lead_angle)
    drive = lsvib.Drive.of(
        friction_coefficient=0.1, stribeck_exponent=2, friction_slope=slope, stribeck_rise=rise,
        stribeck_speed=math.sqrt(2) * sliding, input_speed=speed, axial_force=math.copysign(60.0, speed),
        support_damping=2e-5, translation_damping=20.0,
    )  # fmt: skip
    cycle = steady_state(automaton_of(drive), [1e-3, 0.1 * speed])
    assert cycle.label == Attractor.OTHER_CYCLE
    assert 0.01 < cycle.multiplier < 1
    assert set(cycle.orbit.kind) == {Event.PASSAGE}
    assert agrees(drive, cycle)


def agreeing(seeds):
    """Return how many cycles of random drives agree, and how many of them have a multiplier that is not zero."""
    compared, moving = 0, 0
    for drive, start in law_starts(seeds):
        cycle = steady_state(automaton_of(drive), start)
        if cycle.orbit is not None and agrees(drive, cycle):
            compared, moving = compared + 1, moving + (abs(cycle.multiplier) > 1e-6)
    return compared, moving


@pytest.mark.parametrize("seeds", sizes([range(10)], [range(10, 30)], [range(30, 90)]), ids=len)
def test_cycles_of_random_drives(seeds):
    compared, moving = agreeing(seeds)
    assert compared >= 0.28 * len(seeds)
    assert moving >= 0.05 * len(seeds)


@pytest.mark.slow
def test_none_found_is_not_said_of_a_drive_that_cannot_be_followed():
    drive = threads_drive(stribeck_rise=0.05, stribeck_speed=0.02, input_speed=5, axial_force=50)
    with pytest.raises(
        EngineError, match=r"all 104 starts are unresolved .* reduce contact_stiffness and contact_damping"
    ):
        drive.cycles()


@pytest.mark.slow
def test_a_drive_whose_rates_lie_too_far_apart_is_refused_in_seconds():
    """One search of it would take 10¹³ steps."""
    with pytest.raises(EngineError, match=r"all 104 starts are unresolved .*took too much work"):
        lsvib.Drive(translation_damping=1e15, friction_slope=-1e-5).cycles()


@pytest.mark.parametrize("mass", [7.866124518256167, 7.473460950917817, 6.954259098269641])
def test_multiplier_where_friction_jams_the_threads(mass):
    """Rates grow without bound before a jam; the exact derivative is that of differences of the return map."""
    drive = Drive(
        coupling_stiffness=1.3913607403715653, support_damping=0.0004493480969547084, mass=mass,
        friction_coefficient=0.21350336747657733, stribeck_rise=0.070661573872125, stribeck_speed=0.14063912258280198,
        input_speed=-9.559373698209251, translation_damping=17.028530012073478, axial_force=-10.354393954278866,
    )  # fmt: skip
    cycle = cycle_of(steady_state(automaton_of(drive), standing_state(drive)))
    section, step = cycle.section, 1e-6
    here = section.place(cycle.state)
    ends = [section.place(section.come_back(section.state(here + sign * step)).end_state) for sign in (1, -1)]
    # central differences of a step of 1e-6 leave its square
    assert cycle.multipliers == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)
