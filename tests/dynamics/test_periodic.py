"""Cycles of all models and their branches: multipliers against 40 digits and Liouville's formula, work, folds."""

import json
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf
from references import drives, rigid_digits
from references.comparisons import liouville
from references.drives import drawn, nut_drive, one_of, power, support_drive, threads_drive, times, uniform
from references.known import NEAR_FOLD, NEGATIVE_DAMPING, PARADOX, REPELLING_SLIP
from references.sizes import sizes

import lsvib
from lsvib.answers.cycles import branch_dataset, branch_json
from lsvib.drives.model import model_of, seated_state
from lsvib.dynamics.cycles import Cycle, random_starts
from lsvib.errors import EngineError
from lsvib.stability.force_thresholds import threshold_force
from lsvib.systems.attractor import Attractor, steady_state
from lsvib.systems.cycles import cycle_of, cycle_on
from lsvib.systems.kernels.layout import GRAZE_KIND
from lsvib.systems.section import Section

SLIP = NEGATIVE_DAMPING.replace(axial_force=25)
SUPPORTED = support_drive(mass=15, support_damping=5e-4, support_stiffness=1e5, axial_support_damping=1e4)


@pytest.mark.parametrize(
    ("values", "count"),
    [
        ({"coupling_stiffness": 1e15, "mass": 417797362.8, "input_speed": 1e-12, "axial_force": 1e12}, None),
        ({"support_damping": 1e-30, "mass": 1e9, "input_speed": 1e9, "axial_force": 1e-18}, 1),
        ({"coupling_stiffness": 1e-21, "input_speed": 1e-12, "axial_force": 1e-12, "mass": 4e-3}, None),
        ({"screw_inertia": 1e-30, "coupling_stiffness": 1e15, "translation_damping": 1.89, "input_speed": 1e-12}, None),
    ],
)
def test_values_near_the_ends_of_the_range_of_doubles(values, count):
    """Each ended in a warning of numpy, of a square that underflowed, a long rest or a small size."""
    found = lsvib.Drive(**values).cycles()
    assert count is None or len(found.cycles) == count


def test_a_rounding_beyond_all_numbers_tells_nothing():
    """The square of what a derivative lost on its way overflowed, and so ended in a warning."""
    drive = nut_drive(
        coupling_stiffness=0.005240167794227031, mass=7065.260294182241, nut_inertia=1.9182556659413114e-06,
        friction_coefficient=0.27323027649478554, input_speed=-40, axial_force=1e-18,
    )  # fmt: skip
    with pytest.raises(EngineError, match=r"all 104 starts are unresolved"):
        drive.cycles()


def by_differences(drive, x):
    """Derivative of the map from θ′ = 0 at u = x to the next seizure, by central differences with 40 digits."""
    step, ends = mpf(10) ** -12, []
    with mp.workdps(40):
        for sign in (1, -1):
            events = rigid_digits.simulate(dict(drive), mpf(float(x)) + sign * step, -drive.input_speed, 0.1).events
            assert events[0].kind == "seizure"
            ends.append(events[0].u_after)
        return float((ends[0] - ends[1]) / (2 * step))


@pytest.mark.parametrize("force", [-18.3754, -18.37, -18.36, -15.0])
def test_multipliers_of_cycles_of_seizures_are_those_of_40_digits(force):
    """Attracting ones, and repelling ones where there are any."""
    drive = NEAR_FOLD.replace(axial_force=force)
    cycles = drive.cycles().cycles
    assert [cycle.attracting for cycle in cycles] == ([True, False] if force < -18.3 else [True])
    for cycle in cycles:
        reference = by_differences(drive, cycle.state[0])
        error = abs(cycle.multipliers[0].real - reference)
        assert error <= 1e-9
        assert error <= cycle.multiplier_error + 1e-15
        assert cycle.repelling is (reference > 1)


@pytest.mark.parametrize("drive", sizes([REPELLING_SLIP], [SLIP, SLIP.replace(axial_force=30)]))
def test_multiplier_of_slip_is_that_of_liouville(drive):
    """Where no rest and no seizure is, the multiplier is exp(−Σ a₁ τ): areas on both sides of Q = 0 join smoothly."""
    (cycle,) = [cycle for cycle in drive.cycles().cycles if cycle.label == Attractor.OTHER_CYCLE]
    expected = liouville(cycle)
    assert cycle.multipliers[0].real == pytest.approx(expected, rel=1e-12)
    assert abs(cycle.multipliers[0].real - expected) <= 2 * cycle.multiplier_error


FOUND = [
    (NEAR_FOLD, {"u": -0.1, "w": -40.0}),
    (SLIP, {"u": 0.01, "w": 0.0}),
    (SLIP.replace(axial_force=40), {"u": 0.01, "w": 0.0}),
    (threads_drive(mass=11, axial_force=50), {"u": 0.01, "w": 0.0}),
    (
        threads_drive(translation_damping=1e3, axial_force=25, contact_stiffness=1e6, contact_damping=1e3),
        {"u": 0.01, "w": 0.0},
    ),
    (nut_drive(mass=9, support_damping=1e-3), {"u": 0.01, "w": 0.0}),
    (SUPPORTED, {"u": 0.02, "w": 0.0}),
    (SUPPORTED.replace(screw_mass=40.0), {"u": 0.02, "w": 0.0}),
]


def other_sections(cycle):
    """Sections of the same cycle at its other events."""
    orbit = cycle.orbit
    for key in set(zip(orbit.kind.tolist(), orbit.mode.tolist(), strict=True)) - {cycle.section.key}:
        here = np.flatnonzero((orbit.kind == key[0]) & (orbit.mode == key[1]))
        if key[0] != GRAZE_KIND:
            origin = orbit.after[here[0]]
            yield Section(orbit.automaton, key, origin, cycle.section.size, here.size, 2 * cycle.period)


@pytest.mark.parametrize(("drive", "initial"), FOUND, ids=lambda value: getattr(value, "model", ""))
def test_work_balances_and_multipliers_do_not_depend_on_where_a_period_begins(drive, initial):
    """Motor and load put in what friction, dampers and impacts take out; each is formed from another law."""
    steady = steady_state(drive.automaton(), model_of(drive).initial_state(drive, initial))
    cycle = Cycle.of(drive, cycle_of(steady))
    work = cycle.work
    assert min(work.friction, work.damping) > 0
    assert work.impacts >= 0
    events = cycle.to_json()["itinerary"]
    assert (work.impacts > 0) == any("normal_impulse" in event for event in events)
    assert events[-1]["time"] == pytest.approx(cycle.period, rel=1e-15, abs=0)
    assert abs(work.balance) <= 1e-12
    assert cycle.amplitude == pytest.approx(steady.amplitude, rel=1e-9)
    json.dumps(cycle.to_json(), allow_nan=False)
    assert drive.input_speed * cycle.means["coupling_torque"] * cycle.period == pytest.approx(work.motor, rel=1e-12)
    seen = 0
    for section in other_sections(cycle):
        again = cycle_on(section, "start")
        if again is None:
            continue
        seen += 1
        error = cycle.multiplier_error + again.multiplier_error
        assert abs(cycle.leading - again.leading) <= max(2 * error, 1e-15)
    assert seen or len(cycle.itinerary) == 1


def test_a_cycle_without_derivative_is_written_without_multipliers():
    (cycle,) = SLIP.cycles().cycles
    written = replace(cycle, multipliers=np.array([complex(math.nan)]), multiplier_error=math.nan).to_json()
    assert (written["stability"], written["label"]) == ("not known", "other_cycle")
    assert json.loads(json.dumps(written, allow_nan=False))["multipliers"] == [None]


def test_no_cycle_is_proved_where_steady_sliding_is_globally_stable():
    assert "globally stable" in NEAR_FOLD.replace(axial_force=-18.376).cycles().proved
    assert "slip contracts" in lsvib.Drive(mass=8).cycles().proved
    assert not lsvib.Drive(mass=8).cycles().cycles


def test_undamped_oscillations_are_a_family():
    found = lsvib.Drive(mass=1, support_damping=0).cycles()
    assert (len(found.cycles), len(found.families)) == (0, 1)


def rigid(rng):
    values = drawn(
        rng, mass=power(0, 1.3), translation_damping=times(power(1, 4), one_of(0, 1)), support_damping=power(-5, -2),
        axial_force=uniform(-60, 60), input_speed=one_of(-40, 40),
    )  # fmt: skip
    return lsvib.Drive(**values), rng.uniform((-0.3, -120), (0.3, 120), (20, 2))


def behind_a_motor(rng):
    parts = [(), ("support",), ("nut",), ("support", "nut"), ("threads",)][rng.integers(5)]
    own = {name: draw for part in parts for name, draw in drives.OWN[part].items()}
    low = {"screw_inertia": power(-6, -5), "support_damping": power(-5.5, -4), "static": uniform(1.1, 1.9)}
    values = drawn(rng, drives.POSSIBLE | drives.MOTOR | own | low)
    values["static_friction_coefficient"] = values.pop("static") * values["friction_coefficient"]
    drive = lsvib.Drive(**values)
    size = np.abs(random_starts(drive)).mean(axis=0)
    return drive, rng.normal(size=(200, size.size)) * size * 4.0 ** rng.uniform(-1, 1, (200, 1))


MOTORS = [(behind_a_motor, seed) for seed in (24, 26, 32, 38, 72, 73)]  # from nine starts one was missed of each
SLOW, SEARCH = [*((rigid, seed) for seed in range(3)), *MOTORS[1:]], [(behind_a_motor, seed) for seed in range(104)]


@pytest.mark.parametrize("case", sizes(MOTORS[:1], SLOW, SEARCH))
def test_no_cycle_is_missed_that_three_starts_in_a_hundred_end_on(case):
    draw, seed = case
    drive, starts = draw(np.random.default_rng(seed))
    listed, missed = [cycle.period for cycle in drive.cycles().cycles if cycle.attracting], Counter()
    for start in starts:
        steady = steady_state(drive.automaton(), start, max_events=10_000)
        if steady.orbit is not None and steady.label != Attractor.NEUTRAL_FAMILY:
            missed[f"{steady.period:.5g}"] += not any(abs(own - steady.period) <= 1e-6 * own for own in listed)
    assert max(missed.values(), default=0) <= 0.03 * len(starts)


def gaps_to_the_rigid_multiplier(rigid, stiffnesses):
    """How far the multiplier of slip is from that of the rigid drive, with k_c = c_c."""
    (limit,) = [cycle for cycle in rigid.cycles().cycles if cycle.attracting]
    found = []
    for stiffness in stiffnesses:
        drive = threads_drive(rigid, contact_stiffness=stiffness, contact_damping=stiffness)
        cycle = cycle_of(steady_state(drive.automaton(), seated_state(drive, *map(float, limit.state))))
        contact, slip, trivial = cycle.multipliers
        # The contact relaxes at the rate k_c / c_c = 1/s, which has no rigid counterpart.
        assert contact.real == pytest.approx(math.exp(-cycle.period), abs=300 / stiffness)
        assert abs(trivial) <= 1e-12
        found.append(abs(slip.real - limit.multipliers[0].real))
    return np.array(found)


@pytest.mark.parametrize("drive", sizes([SLIP], [SLIP.replace(mass=2.0, axial_force=27.0)]))
def test_compliant_multipliers_of_slip_tend_to_the_rigid_one_with_order_one(drive):
    stiffnesses = np.array([1e7, 1e8, 1e9])
    gaps = gaps_to_the_rigid_multiplier(drive, stiffnesses)
    order = -np.polyfit(np.log(stiffnesses), np.log(gaps), 1)[0]
    assert order == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("drive", [PARADOX, lsvib.Drive(mass=14, support_damping=5e-4, axial_force=-5)])
def test_with_seizures_the_order_is_one_but_for_a_logarithm(drive):
    """The gap is (a + b ln κ) / κ, as a seizure takes a time of ln κ / κ: times κ it grows alike with each power."""
    stiffnesses = np.array([1e8, 1e9, 1e10])
    first, second = np.diff(gaps_to_the_rigid_multiplier(drive, stiffnesses) * stiffnesses)
    assert first > 0
    assert second == pytest.approx(first, rel=0.02)


THREADS = threads_drive(REPELLING_SLIP, contact_stiffness=1e8, contact_damping=1e5)
SUPPORT = support_drive(REPELLING_SLIP, support_stiffness=1e8, axial_support_damping=1e4)
NUT = nut_drive(REPELLING_SLIP, nut_inertia=1e-2, nut_stiffness=1e4, nut_damping=1.0)
FOLDING = threads_drive(NEAR_FOLD, contact_stiffness=1e8, contact_damping=1e8)


def across(cycle):
    """States beside a cycle on both sides, along the direction in which it repels."""
    values, vectors = np.linalg.eig(cycle.section.derivative(cycle.orbit)[0])
    direction = vectors[:, np.argmax(np.abs(values))].real
    place = cycle.section.place(cycle.state)
    return [cycle.section.state(place + step * direction) for step in (-1e-6, 1e-6)]


@pytest.mark.parametrize("drive", [THREADS, SUPPORT, NUT, FOLDING], ids=["threads", "support", "nut", "near a fold"])
def test_the_cycle_on_the_edge_parts_the_basins(drive):
    """It repels along one direction; on one side of it motions end in steady sliding, on the other in the cycle."""
    found = drive.cycles()
    attracting, repelling = found.cycles
    assert attracting.attracting
    assert repelling.repelling
    assert repelling.found_by == "edge of a basin"
    assert repelling.residual < 1e-12
    assert np.sum(np.abs(repelling.multipliers) > 1) == 1
    assert "the edge between their two basins, with a cycle on it" in found.searched
    mode = repelling.section.key[1]
    ends = [steady_state(drive.automaton(), state, mode=mode) for state in across(repelling)]
    assert {end.label for end in ends} == {Attractor.STEADY_SLIDING, attracting.label}
    assert abs(repelling.work.balance) < 1e-10


@pytest.mark.parametrize("damping", sizes([2e-3], [5e-3]))
def test_fold_is_the_threshold_of_global_stability(damping):
    """The attracting branch turns into the repelling one at the force that the closed form gives, to rounding."""
    drive = NEAR_FOLD.replace(support_damping=damping)
    threshold = threshold_force(drive, "global_stability")
    drive = drive.replace(axial_force=threshold * (1 - 3e-4))
    attracting, repelling = drive.cycles().cycles
    branch = drive.follow(attracting, "axial_force", (threshold * 1.01, threshold * (1 - 4e-4)))
    assert branch.folds == [pytest.approx(threshold, rel=1e-14)]
    sides = [point.cycle.attracting for point in branch.points]
    assert sides == sorted(sides)  # repelling ones, then attracting ones, one change between
    assert {True, False} == set(sides)
    assert max(point.cycle.residual for point in branch.points) < 1e-13
    back = drive.follow(repelling, "axial_force", (threshold * 1.01, threshold * (1 - 4e-4)))
    assert back.folds == [pytest.approx(branch.folds[0], rel=1e-14)]


@pytest.mark.slow
def test_amplitude_over_force_has_the_thresholds_of_figure_8_6():
    """From onset, where the cycle vanishes, over the first rest to the last contact reversal."""
    (cycle,) = SLIP.cycles().cycles
    branch = SLIP.follow(cycle, "axial_force", (20.0, 50.0))
    known = {name: threshold.value for name, threshold in SLIP.thresholds().items()}
    first, *changes, last = branch.changes
    assert (first.kind, first.what) == ("end", "it shrinks to nothing")
    assert first.value == pytest.approx(known["onset"], abs=1e-4)
    assert [change.kind for change in changes] == ["itinerary", "itinerary"]
    assert changes[0].value == pytest.approx(known["stick"], rel=1e-9)
    assert "stick into rest" in changes[0].what
    assert changes[1].value == pytest.approx(known["detach"], rel=1e-9)
    assert changes[1].what.startswith("loses contact reversal")
    assert (last.kind, last.value) == ("end", 50.0)
    assert not branch.folds


PULLED = {  # by a spring, as a drive with hardly any lead
    "pitch_radius": 1, "lead_angle": 1e-6, "mass": 1e-18, "axial_force": 1, "screw_inertia": 1, "coupling_stiffness": 2,
    "support_damping": 0.4, "friction_coefficient": 1.000002000002, "static_friction_coefficient": 1.500003250004875,
    "input_speed": 0.1,
}  # fmt: skip
STRIBECK = {  # a block whose friction is 2 + 4 exp(−10 v) + 0.2 v N, published
    "pitch_radius": 1, "lead_angle": 1e-6, "mass": 1e-18, "axial_force": 1000, "screw_inertia": 0.538,
    "friction_coefficient": 0.002, "stribeck_rise": 0.004, "stribeck_speed": 0.1, "friction_slope": 0.0002,
    "input_speed": 0.22, "coupling_stiffness": 6957, "support_damping": 5.746,
}  # fmt: skip
SPRAG = {"mass": 15, "axial_force": 100, "support_damping": 2e-4}  # of which the cycle goes on without rest
SEAT = {"friction": "powered_seat", "axial_force": 95}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "parameter", "spans", "kind", "value", "tolerance"),
    [
        (PULLED, "input_speed", [(0.02, 0.4), (0.09, 0.19)], "end", 0.181127006942085, 1e-12),
        (SPRAG, "support_damping", [(1e-4, 4e-4)], "itinerary", 2.5264368463058756e-4, 1e-12),
        (STRIBECK, "input_speed", [(0.1, 0.4)], "fold", 0.27178904290785, 1e-8),  # the lead changes it by 3e-9
        pytest.param(SEAT, "axial_force", [(60, 200)], "fold", 72.575, 1e-5, marks=pytest.mark.search),  # three digits
    ],
)
def test_stick_slip_ends_where_its_slip_just_comes_to_rest(values, parameter, spans, kind, value, tolerance):
    """w = −Ω with w′ = 0 after release, in 16 digits by another program; the same for every range that is asked for.

    Where friction falls with speed alone the branch turns there, and goes on as pure slip to the onset.
    """
    drive, found = lsvib.Drive.of(values), []
    (cycle,) = (cycle for cycle in drive.cycles().cycles if cycle.attracting)
    for span in spans:
        changes = drive.follow(cycle, parameter, span).changes
        rests = [change for change in changes if "rest" in change.what]
        found += [change.value for change in changes if change.value == rests[0].value and change.kind == kind]
        if values is STRIBECK:
            onset = [change.value for change in changes if change.what == "it shrinks to nothing"]
            assert onset == [pytest.approx(abs(drive.thresholds(parameter)["onset"].value), rel=1e-7)]
    assert found == [pytest.approx(value, rel=tolerance)] * len(spans)
    assert max(found) - min(found) <= 1e-14 * abs(value)


def test_branch_is_written():
    branch = NEAR_FOLD.follow(NEAR_FOLD.cycles().cycles[0], "axial_force", (-18.38, -18.36), points=30)
    data = branch_dataset(branch)
    assert data.sizes["point"] == len(branch.points)
    assert data.axial_force.units == "N"
    assert json.loads(json.dumps(branch_json(branch)))["changes"][0]["kind"] == "end"
