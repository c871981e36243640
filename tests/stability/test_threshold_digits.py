"""Thresholds solved for any parameter: 13 digits, derivatives, and motions on both sides, of random drives.

Reference values and derivatives, by differences, have 40 digits (``references/threshold_digits.py``). Two kinds of
cycles end at the force of global stability (docs/basin.md), one with rest and one without, where the map of seizures
has the slope 1.

What the forces divide the motions of charts show (``answers/test_charts.py``); of global stability it is asked here,
too, up to 1e-9 beside it: motions from all over the plane, from the end of rest and from the cycle without rest settle,
or one of them does not.
"""

import math
from contextlib import suppress
from functools import partial

import numpy as np
import pytest
from mpmath import mp, mpf
from references import threshold_digits
from references.drives import DRIVES as KINDS
from references.drives import LIKE_PARTS, LIKE_TABLE_8_1, PARADOX, about, decades, drawn, one_of, rigid_values, times
from references.threshold_digits import WORK, gap, root

from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.names import Event
from lsvib.dynamics.boundary import Boundary, basin
from lsvib.errors import EngineError, InputError, NoThreshold
from lsvib.stability.force_thresholds import threshold_force, widest_return
from lsvib.stability.motion_equations import Return
from lsvib.stability.slip import SlipDrive, half_return, leaving
from lsvib.stability.threshold import _start, solve_threshold
from lsvib.systems.attractor import Attractor, steady_state
from lsvib.systems.kernels.layout import Status
from lsvib.systems.motion import follow

DRIVES = 8  # of each threshold
SLOPES = 2  # of these whose derivatives are compared
VALUE, SLOPE = mpf("1e-13"), mpf("1e-9")
_STEP = mpf(10) ** -14  # of a central difference, relative: its square is far below SLOPE, 40 digits far below it


@pytest.fixture(autouse=True)
def _forty_digits():
    with mp.workdps(threshold_digits.WORK):
        yield


def random_drive(rng: np.random.Generator, name: str) -> Drive:
    """A rigid drive like the chapter's, every parameter up to a factor of two away, where a threshold may be."""
    negative = name in ("onset", "stick", "detach")
    values = drawn(
        rng, LIKE_TABLE_8_1, coupling_stiffness=about(1.0), input_speed=times(about(40.0), one_of(-1, 1)),
        support_damping=about(2e-4 if negative else 1.5e-3),
        mass=about(1.0 if negative else 15.0), axial_force=about(30.0),
        translation_damping=about(1e3) if negative else times(about(10.0), one_of(0, 1)),
    )  # fmt: skip
    values["axial_force"] *= np.sign(values["input_speed"]) * (1 if negative else -1)
    return Drive.of(values)


def accepted(name: str, unknown: str, count: int, draw=random_drive):
    """Drives that have a threshold, with its solutions for one parameter, and how many slopes to ask for."""
    rng, found = np.random.default_rng([count, len(unknown)]), 0
    while found < count:
        drive = draw(rng, name)
        try:
            solution = solve_threshold(drive, name, unknown)
        except InputError:
            continue
        found += 1
        assert solution.solutions
        yield rng, drive, solution, 2 if found <= SLOPES else 0


def hint(name: str, drive: Drive):
    """Where the references look for the root of a motion: nearly, and nothing that counts in the result."""
    if name in ("onset", "kinematic_constraint", "negative_damping"):
        return ()
    time = _start(name, drive)[1].times[0]
    if name != "stick":
        return (float(time),)
    forward = SlipDrive.of(drive)
    slip, height = forward.slip(1), forward.inertia[1]
    return (float(leaving(slip, forward.contact, height, half_return(slip, height, time)[0])[1]),)


def judged(name, drive, solved, solution, rng, slopes):
    """Value and some derivatives of a solution against the reference."""
    unknown = solved.unknown
    near = hint(name, drive.replace(**{unknown: solution.value}))

    def truth(values, guess):
        return threshold_digits.root(lambda x: threshold_digits.gap(which, {**values, unknown: x}, near), guess)

    which = name
    if name == "onset":  # by the equation that it is
        which = {"R̃": "onset", "Γ₊": "kinematic_constraint", "C₊": "negative_damping"}[solution.equation.split(" ")[0]]
    if name == "global_stability" and "dh/dτ" in solution.equation:
        which = "fold"
    compared(drive, solved, solution, truth, rng, slopes)


def compared(drive, solved, solution, truth, rng, slopes):
    """Value, enclosure and some derivatives of a solution against a function of (parameters, guess)."""
    values = dict(drive)
    exact = truth(values, solution.value)
    assert abs(solution.value - exact) <= VALUE * abs(exact)
    assert solution.enclosure[0] <= exact <= solution.enclosure[1]
    others = [key for key, value in values.items() if key != solved.unknown and value]
    for key in rng.choice(others, slopes, replace=False):
        step = abs(mpf(values[key])) * _STEP
        ends = [truth({**values, key: values[key] + sign * step}, exact) for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step)
        found = solution.derivatives[key].value
        assert solution.derivatives[key].low <= found <= solution.derivatives[key].high
        assert abs(found - slope) <= SLOPE * abs(slope) + mpf("1e-14") * abs(exact / values[key]), key


@pytest.mark.parametrize(
    ("name", "unknown"),
    [
        *((name, "axial_force") for name in ("onset", "stick", "detach", "global_stability")),
        *(("onset", "friction_coefficient"), ("kinematic_constraint", "lead_angle")),
        ("negative_damping", "pitch_radius"),
    ],
)
def test_thirteen_digits_and_derivatives(name, unknown):
    for rng, drive, found, slopes in accepted(name, unknown, DRIVES):
        for solution in found.solutions:
            judged(name, drive, found, solution, rng, slopes)


def two_bodies(model: str):
    """Draws drives of a model with two bodies, about as stiff as those of the chapter."""

    def draw(rng, name):
        values = drawn(
            rng, LIKE_TABLE_8_1, input_speed=about(40.0), support_damping=about(2e-4), mass=about(5.0),
            axial_force=about(30.0), translation_damping=times(about(5.0), one_of(0, 1)),
        )  # fmt: skip
        return KINDS[model].of(values | drawn(rng, LIKE_PARTS[model]))

    return draw


@pytest.mark.parametrize(
    ("model", "name", "unknown"),
    [
        ("threads", "flutter", "mass"),
        ("support", "flutter", "support_stiffness"),
        ("support", "kinematic_constraint", "friction_coefficient"),
        ("nut", "flutter", "translation_damping"),
    ],
)
def test_thirteen_digits_of_drives_with_two_bodies(model, name, unknown):
    """A growth rate passes zero, or the contact force has no bound, by the state matrix of Newton's laws."""
    for rng, drive, found, slopes in accepted(name, unknown, DRIVES, two_bodies(model)):
        for solution in found.solutions:

            def truth(values, guess, words=solution.equation):
                at = partial(threshold_digits.growth, model) if "Hurwitz" in words else None
                if words.startswith("R"):
                    at = threshold_digits.net_force
                at = at or partial(threshold_digits.jam, model)
                return threshold_digits.root(lambda x: at({**values, unknown: x}), guess)

            compared(drive, found, solution, truth, rng, slopes)


# Rest before slip forward and backward, slip on the way to Q = 0, far away on either side.
STARTS = [(0.1, 0.0), (0.0, -40.0), (-0.3, 30.0), (0.3, -90.0), (0.04, -40.0), (0.0, 500.0)]


def exact_force(cycle: str, drive: Drive, time: float, guess: float):
    """Axial force [N] at which a cycle ends, with 40 digits; ``time`` [s]: about how long its slip lasts."""
    with mp.workdps(WORK):
        return root(lambda force: gap(cycle, {**dict(drive), "axial_force": force}, (time,)), guess)


@pytest.mark.parametrize("speed", [40.0, -40.0])
def test_limit_cycle_right_up_to_the_threshold(speed):
    """m = 11 kg, c = 1e-3, c_x = 0: one cycle from 10 N to 1e-8 short of the threshold, the origin 1e-8 beyond it."""
    drive = PARADOX.replace(input_speed=speed)
    limit = threshold_force(drive, "global_stability")
    for share in (*np.linspace(0.3, 0.9, 7), *(1 - 10.0**-n for n in (3, 6, 8)), *(1 + 10.0**-n for n in (8, 5, 2))):
        automaton = automaton_of(drive.replace(axial_force=share * limit))
        ends = [steady_state(automaton, start) for start in math.copysign(1, speed) * np.array(STARTS)]
        label = Attractor.SPRAG_SLIP_CYCLE if share < 1 else Attractor.STEADY_SLIDING
        assert {end.label for end in ends} == {label}, share
        if share < 1:  # one and the same cycle, to rounding
            periods = [cycle.period / cycle.returns for cycle in ends]
            np.testing.assert_allclose(periods, periods[0], rtol=1e-12)


def in_cycle(made: SlipDrive) -> float:
    """Deflection [rad] at which the last cycle without rest seizes; nan if there is none."""
    return float(Return(made, widest_return(made)[1]).x)


@pytest.mark.parametrize("speed", [40.0, -40.0])
def test_forces_with_the_motion(speed):
    """c_x = 2000: every R < 0 is globally stable, and none is from 30.8 N (31.4 N with rest) to the onset, 40.4 N."""
    drive = PARADOX.replace(translation_damping=2000.0, input_speed=speed)
    forward = drive.replace(input_speed=40.0)
    assert exact_force("global_stability", forward, 0.016, 31.0) == pytest.approx(31.431833502858915, rel=1e-13)
    expected = float(exact_force("fold", forward, 0.01651, 31.0))
    limit = threshold_force(drive, "global_stability")
    assert limit == pytest.approx(math.copysign(expected, speed), rel=1e-13)
    inside = in_cycle(SlipDrive.of(drive))
    starts = [(math.copysign(1, speed) * u, math.copysign(1, speed) * w) for u, w in [*STARTS, (inside, -40.0)]]
    for share, stable in ((1 - 1e-6, True), (0.5, True), (-1.0, True), (1 + 1e-6, False), (1.2, False)):
        automaton = automaton_of(drive.replace(axial_force=share * limit))
        motions = [follow(automaton, start, math.inf, max_events=5000) for start in starts]
        assert all(motion.status == Status.SETTLED for motion in motions) == stable, share


def test_light_drives_are_globally_stable_without_translation_damping():
    """Γ₊ > 0, c_x = 0: steady sliding attracts everything under either sign of R, as docs/basin.md proves."""
    generator = np.random.default_rng(6)
    for _ in range(40):
        drive = Drive.of(
            mass=generator.uniform(0.1, 10.1),
            support_damping=10 ** generator.uniform(-5, -2),
            axial_force=generator.choice([-1, 1]) * 10 ** generator.uniform(-2, 3),
        )
        assert basin(drive).boundary == Boundary.NONE


def test_none_is_globally_unstable_where_every_force_against_the_motion_is_stable():
    drive = PARADOX.replace(translation_damping=2000.0, support_damping=0.1)
    assert all(basin(drive.replace(axial_force=-r)).boundary == Boundary.NONE for r in (1e-6, 1e-3, 1.0, 1e3))


def wide_drive(rng) -> Drive:
    """Draw a drive with Γ₊ < 0 at any distance from zero."""
    while True:
        values = {key: value for key, value in rigid_values(rng).items() if key != "axial_force"}
        lead = values["lead_angle"]
        tan, mu = math.tan(lead), values["friction_coefficient"]
        arm, damping = values["pitch_radius"] ** 2 * tan, values["translation_damping"]
        plus, minus = ((mu - tan) / (1 + mu * tan), (mu + tan) / (1 - mu * tan))
        values["screw_inertia"] = plus * arm * values["mass"] * (1 - decades(rng, -4, 0))
        # Damping ratios from weak to overdamped.
        inertia = values["screw_inertia"] + minus * arm * values["mass"]
        damping = abs(values["support_damping"] + minus * arm * damping)
        values["coupling_stiffness"] = (damping / decades(rng, -3, 1)) ** 2 / inertia if inertia > 0 else 0.0
        try:
            return Drive.of(values)
        except InputError:
            continue


def starts(rng, made: SlipDrive, force: float, count: int):
    """Starts (Ω > 0): the end of rest, the cycle without rest, others on θ′ = 0 left of the former, and anywhere."""
    speed, first = float(made.speed), float(made.damping[-1] * made.speed / made.stiffness)
    slip_time = float((made.inertia[-1] / made.stiffness) ** 0.5)
    released = first - max(force, 0.0) * float(made.radius * (made.xi[1] - made.xi[-1]) / made.stiffness)
    yield released, -speed
    if made.contact[1] > 0:
        x = in_cycle(made)
        if math.isfinite(x):
            yield x, -speed
    size = max(abs(released), speed * slip_time)
    for _ in range(count):
        yield released - size * decades(rng, -5, 2), -speed
        size_now, angle = size * decades(rng, -2, 1), rng.uniform(0, 2 * math.pi)
        yield size_now * math.cos(angle), size_now / slip_time * math.sin(angle)


def settles(drive, force, start, made, sign, count=20_000) -> bool | None:
    """Whether a motion settles; None if unknown.

    Overdamped slip may seize a million times on its way. It counts as settling if u moves one way only: backward slip
    moves left until it rests; so does slip that seizes while u falls; other slip moves right, to smaller turns.
    """
    try:
        motion = follow(automaton_of(drive.replace(axial_force=force)), start, math.inf, max_events=count)
    except EngineError:
        return None
    if motion.status == Status.SETTLED:
        return True
    if set(motion.kind[-500:].tolist()) != {Event.SEIZURE}:
        return False
    steps = np.diff(sign * motion.after[-500:, 0])
    backward = sign * motion.end_state[0] > float(made.damping[-1] * made.speed / made.stiffness)
    return bool((steps < 0).all() if backward or made.outward <= 0 else (steps > 0).all())


def judge_global(rng, drive):
    made, sign = SlipDrive.of(drive), math.copysign(1.0, drive.input_speed)
    threshold = sign * threshold_force(drive, "global_stability")
    onset = float(made.onset)
    assert threshold < onset or onset == 0 > threshold
    below = [(side, threshold + side * abs(threshold) * 10.0**-n) for n in range(1, 10) for side in (-1, 1)]
    below += [(-1, onset - (onset - threshold) * factor) for factor in (2.0, 10.0)]
    below += [(1, onset - (onset - threshold) * share) for share in (0.5, 0.01, rng.random())]
    for side, force in below:
        if not (abs(force) < 1e12 and force < onset * (1 - 1e-12) + 0.0) or force == threshold:
            continue
        found = [settles(drive, sign * force, (sign * u, sign * w), made, sign) for u, w in starts(rng, made, force, 2)]
        if side < 0:
            assert False not in found, force
        else:
            assert False in found, force


def test_global_stability_of_random_drives():
    rng, judged = np.random.default_rng(11), 0
    for _ in range(12):
        drive = wide_drive(rng)
        with suppress(NoThreshold):
            threshold_force(drive, "global_stability")
            judge_global(rng, drive)
            judged += 1
    assert judged > 3
