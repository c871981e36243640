"""Where motions end up: labels, residual and multiplier of a cycle, in all models, slow cycles above all.

For a cycle of pure slip the multiplier of the return map is known from elsewhere. The field is continuous across Q = 0,
so by Liouville's formula it is exp ∮ div = exp(−Σ a₁ τ) over the arcs of the cycle. Tolerance 1e-12: the
library takes the multiplier from an exact product over some events.

Fixed points repeat to 1e-12 of the size of the motion: rounding of one period, a few events long. The rate at which a
motion comes closer must be that of the largest multiplier to 10 %: the distance is not in proportion to its power where
others still count, and a complex pair makes it oscillate.

Labels of drives such as catalogues offer are held against where the motion itself has come much later: near the
equilibrium, or the orbit. A motion that attracts slowly still has most of its first distance left, so that a tenth of
it must be gone; and 1e-3 of the size of the motion is where the points of an orbit lie.
"""

import math

import numpy as np
import pytest
from references.comparisons import liouville
from references.drives import DRIVES, OFFERED, catalogue_drive
from references.known import NEGATIVE_DAMPING, PARADOX

from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import model_of
from lsvib.drives.names import Event
from lsvib.errors import WorkSpentError
from lsvib.stability.force_thresholds import threshold_force
from lsvib.systems.attractor import Attractor, Doubt, SteadyState, steady_state
from lsvib.systems.cycles import observable_integrals
from lsvib.systems.kernels import attractor as rule
from lsvib.systems.kernels import flow_planar, layout
from lsvib.systems.motion import Budget, Motion, follow


def attractor(drive, start=(0.05, 5.0), **options):
    return steady_state(automaton_of(drive, **options), start)


@pytest.mark.parametrize("force", [20.3, 22.0, 25.0, 30.0, 34.0, 35.0])
@pytest.mark.parametrize("side", [1, -1])
def test_pure_slip_cycle(force, side):
    """Fig. 8.6 between onset and stick: one cycle, in proportion to R̃, with Liouville's multiplier."""
    drive = NEGATIVE_DAMPING.replace(axial_force=side * force, input_speed=side * 40.0)
    cycle = attractor(drive, (side * 0.002, 0.0))
    assert cycle.label == Attractor.OTHER_CYCLE
    assert not np.isin(cycle.orbit.kind, (Event.STICK, Event.SEIZURE)).any()
    assert cycle.multiplier == pytest.approx(liouville(cycle), abs=1e-12)
    assert 0 < cycle.multiplier < 1
    assert cycle.residual <= 16 * flow_planar.EPS
    onset = threshold_force(NEGATIVE_DAMPING, "onset")
    reference = attractor(NEGATIVE_DAMPING.replace(axial_force=25.0), (0.002, 0.0))
    # R̃ = R − onset is formed in double here: eps · 20 N / R̃.
    rounding = 100 * flow_planar.EPS * onset / (force - onset)
    assert cycle.amplitude / (force - onset) == pytest.approx(reference.amplitude / (25 - onset), rel=rounding + 1e-13)
    assert cycle.period == pytest.approx(reference.period, rel=1e-13, abs=0)


@pytest.mark.parametrize("force", [36.0, 40.0, 46.0, 47.0, 60.0])
def test_stick_slip_is_superstable(force):
    """Rest ends in the same state whatever came before: the multiplier is 0, and the state repeats to the last bit."""
    cycle = attractor(NEGATIVE_DAMPING.replace(axial_force=force))
    assert cycle.label == Attractor.STICK_SLIP_CYCLE
    assert (cycle.multiplier, cycle.residual, cycle.orbit.kind[-1]) == (0.0, 0.0, Event.RELEASE)  # on two surfaces
    # Constant amplitude once N = 0 is no longer reached, at 46.2 N; the tolerance is rounding.
    last = attractor(NEGATIVE_DAMPING.replace(axial_force=200.0))
    assert (abs(cycle.amplitude / last.amplitude - 1) <= 1e-13) == (force > 46.2)


def test_sprag_slip_of_both_kinds():
    """Seizure followed by slip at once depends on where it seized; seizure followed by rest does not."""
    at_once = attractor(PARADOX, (0.1, 0.0))
    assert at_once.label == Attractor.SPRAG_SLIP_CYCLE
    assert 0 < abs(at_once.multiplier) < 1
    resting = attractor(PARADOX.replace(axial_force=-32.7), (0.1, 0.0))
    assert resting.label == Attractor.SPRAG_SLIP_CYCLE
    assert resting.multiplier == 0.0
    assert Event.RELEASE in resting.orbit.kind


@pytest.mark.parametrize("drive", [Drive(), NEGATIVE_DAMPING.replace(axial_force=18), PARADOX.replace(axial_force=-50)])
def test_steady_sliding_attracts(drive):
    found = attractor(drive)
    assert found.label == Attractor.STEADY_SLIDING
    assert (found.orbit, found.amplitude) == (None, 0.0)
    assert math.isnan(found.period)
    assert found.state.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("force", [18.0, 25.0, 40.0])
def test_steady_sliding_itself_stays(force):
    """Exactly on the equilibrium nothing ever happens, stable or not."""
    assert attractor(NEGATIVE_DAMPING.replace(axial_force=force), (0.0, 0.0)).label == Attractor.STEADY_SLIDING


def test_undamped_slip_is_one_of_a_neutral_family():
    """c = c_x = 0 within N > 0 and θ′ > 0: an ellipse, period 2π √(Γ₊/k), multiplier 1."""
    drive = Drive.of(support_damping=0.0)
    found = attractor(drive, (0.01, 5.0))
    assert found.label == Attractor.NEUTRAL_FAMILY
    assert found.multiplier == 1.0
    row = automaton_of(drive).tables.flow[found.orbit.start_mode]
    assert found.period == pytest.approx(2 * math.pi / row[layout.BETA], rel=4 * flow_planar.EPS)
    assert found.amplitude == pytest.approx(math.hypot(0.01, 5.0 / row[layout.BETA]), rel=1e-14)


@pytest.mark.parametrize(("mass", "damping", "force"), [(8, 3e3, 1e3), (10, 1e3, 1e3), (5, 1e4, 5e3), (10, 3e3, 5e3)])
def test_unbounded(mass, damping, force):
    """Without rest, slip grows for ever where law + feeds in more than law − takes out (Γ₊ small, C₊ negative).

    In the last two C₊ < −2 √(k Γ₊): an unstable node, which is left for ever without meeting Q = 0 again.
    """
    drive = Drive.of(mass=mass, translation_damping=damping, axial_force=force)
    assert steady_state(automaton_of(drive, rest=False), (0.05, 5.0)).label == Attractor.UNBOUNDED


@pytest.mark.parametrize("start", [(0.05, 5.0), (0.0, -40.0), (-0.2, 100.0)])
def test_without_net_force(start):
    """R̃ = 0 (R = c_x = 0): the contact carries no steady force, and the damped drive comes to its equilibrium u = 0."""
    found = attractor(Drive.of(axial_force=0.0), start)
    assert found.label == Attractor.STEADY_SLIDING
    assert abs(found.state[0]) <= 1e-15


def test_extremes_and_means_against_samples():
    """Closed-form extremes and means against 20 000 samples of the orbit (trapezium rule)."""
    cycle = attractor(NEGATIVE_DAMPING.replace(axial_force=30.0))
    times = np.linspace(0.0, cycle.period, 20_001)
    states, modes = cycle.orbit.at(times)
    automaton = cycle.orbit.automaton
    force, torque = (automaton.observe(name, states, modes) for name in ("normal_force", "coupling_torque"))
    # Between samples an extremum hides by (h/2)²/2 of the curvature: 1e-8 of the swing; the kink at N = 0 costs h².
    ends = cycle.extremes(automaton.observables["normal_force"])
    assert ends == pytest.approx((force.min(), force.max()), rel=1e-6)
    assert 2 * cycle.amplitude == pytest.approx(np.ptp(states[:, 0]), rel=1e-6)
    over_arcs = observable_integrals(cycle.orbit, ("coupling_torque", "normal_force"))
    assert over_arcs[:, 0].sum() == pytest.approx(cycle.period * np.mean(torque[:-1]), rel=1e-6)
    assert np.abs(over_arcs[:, 1]).sum() == pytest.approx(cycle.period * np.mean(np.abs(force[:-1])), rel=1e-6)


def test_the_rule_is_compiled_once_for_all_kinds_of_flow():
    """One compiled version after labels of a rigid drive, of compliant threads, and under a friction law."""
    law = {"stribeck_rise": 0.02, "stribeck_speed": 0.01}
    for more in ({}, {"contact_stiffness": 1e6, "contact_damping": 1e4}, law):
        drive = Drive.of(mass=2.0, **more)
        assert drive.steady_state({"u": 0.05, "w": 5.0}).label != Attractor.UNRESOLVED
    drive.sweep(axial_force=[40.0, 50.0])
    assert len(rule.end_of.overloads) == 1


SUPPORT = {
    "mass": 1.6, "friction_coefficient": 0.304, "axial_force": -156.0, "input_speed": -56.5,
    "support_damping": 8.64e-5, "screw_mass": 13.4, "support_stiffness": 3.38e6, "bearing_friction": 1.08e-3,
}  # fmt: skip
NUT = {
    "mass": 17.1, "friction_coefficient": 0.223, "axial_force": 155.0, "input_speed": 8.17,
    "support_damping": 6.93e-4, "translation_damping": 66.7, "nut_inertia": 1.66e-5, "nut_stiffness": 0.0739,
}  # fmt: skip
SPRAG = {
    "mass": 21.1, "friction_coefficient": 0.347, "axial_force": 1.04, "input_speed": 37.7,
    "support_damping": 1.86e-5, "screw_mass": 7.48, "support_stiffness": 1.37e4, "bearing_friction": 2.47e-3,
}  # fmt: skip
THREADS = {"mass": 11.0, "axial_force": 50.0}
ELASTIC = {
    "mass": 15.0, "axial_force": 60.0, "support_damping": 1e-4, "contact_stiffness": 1e7, "contact_damping": 0.0,
}  # fmt: skip


def build(model: str, parameters: dict, u: float, w: float):
    drive = DRIVES[model](parameters)
    return automaton_of(drive), model_of(drive).initial_state(drive, {"u": u, "w": w})


@pytest.mark.parametrize(
    ("model", "parameters", "start", "label", "window"),
    [
        ("support", SUPPORT, (-0.0193, 0.138), Attractor.STICK_SLIP_CYCLE, (6000, 12000)),  # real, 0.9987
        ("support", SPRAG, (-0.148, 20.8), Attractor.SPRAG_SLIP_CYCLE, (100_000, 160_000)),  # complex, |.| = 0.99996
        ("threads", THREADS, (0.003, 0.0), Attractor.SPRAG_SLIP_CYCLE, (100, 300)),  # the creep of the contact
    ],
)
def test_motion_approaches_the_cycle_at_the_rate_of_its_multiplier(model, parameters, start, label, window):
    automaton, state = build(model, parameters, *start)
    cycle = steady_state(automaton, state)
    assert cycle.label == label
    assert cycle.residual <= 1e-12
    assert 0.9 < cycle.multiplier < 1
    events = (window[1] + 1) * max(cycle.orbit.time.size, 1) * 2
    motion = follow(automaton, state, math.inf, max_events=events)
    points = motion.after[(motion.kind == cycle.orbit.kind[-1]) & (motion.mode == cycle.orbit.mode[-1])]
    far = np.abs((points - cycle.state) / np.abs(motion.after).max(axis=0)).max(axis=1)
    count = 30  # returns over which a complex pair turns at least once
    first, last = (np.log(far[n : n + count]).mean() for n in window)
    assert (last - first) / (window[1] - window[0]) == pytest.approx(math.log(cycle.multiplier), rel=0.1)


@pytest.mark.parametrize(
    ("model", "parameters", "start", "returns"),
    [("threads", ELASTIC, (0.1, -20.0), 3), ("nut", NUT, (0.0289, 16.2), 21)],
)
def test_the_cycle_is_that_of_the_motion_though_others_attract(model, parameters, start, returns):
    """Cycles of fewer (nut) or more returns (elastic contact) attract, too; a hundred periods later it is this one."""
    automaton, state = build(model, parameters, *start)
    cycle = steady_state(automaton, state)
    assert cycle.returns == returns
    motion = follow(automaton, state, 100 * cycle.period)
    points = motion.after[(motion.kind == cycle.orbit.kind[-1]) & (motion.mode == cycle.orbit.mode[-1])]
    far = np.abs(points[-returns:] - cycle.state).max(axis=1)
    assert far.min() <= 1e-9 * np.abs(cycle.state).max()


def test_the_period_is_the_shortest():
    """A complex pair near the third roots of one: three returns come nearest, but one is the period."""
    parameters = {
        "support_damping": 0.0, "nut_damping": 0.0,
        "mass": 2.316488574, "friction_coefficient": 0.3730940239, "axial_force": 139.5779178,
        "input_speed": 21.1421218, "translation_damping": 133.2130792, "nut_inertia": 1.289840457e-05,
        "nut_stiffness": 4.943884351,
    }  # fmt: skip
    cycle = steady_state(*build("nut", parameters, -0.0783490385, 43.85294688))
    assert cycle.label == Attractor.STICK_SLIP_CYCLE
    assert (cycle.returns, cycle.orbit.time.size) == (1, 2)


def test_chaos_is_unresolved():
    """Two motions that start 1e-9 apart are far apart after 1000 events, and there is no cycle to find."""
    parameters = {
        "mass": 9.98, "friction_coefficient": 0.393, "axial_force": 6.3, "input_speed": -19.3,
        "screw_mass": 6.02, "support_stiffness": 2.4e7, "translation_damping": 215.0,
    }  # fmt: skip
    automaton, state = build("support", parameters, 0.108, -46.9)
    ends = [follow(automaton, state * (1 + h), math.inf, max_events=1000).end_state for h in (0.0, 1e-9)]
    apart = np.abs(ends[1] - ends[0]).max() / np.abs(ends[0]).max()
    assert apart > 1e-3
    assert steady_state(automaton, state, max_events=5000).label == Attractor.UNRESOLVED


def test_undamped_oscillation_that_settles_is_not_steady_sliding():
    undamped = {"mass": 5.0, "axial_force": 100.0, "screw_mass": 5.0, "support_damping": 0.0}
    automaton, state = build("support", undamped, 1e-4, 0.0)
    assert steady_state(automaton, state).label == Attractor.NEUTRAL_FAMILY  # of two frequencies
    damped, state = build("support", undamped | {"support_damping": 1e-3, "axial_support_damping": 500.0}, 1e-4, 0.0)
    assert steady_state(damped, state).label == Attractor.STEADY_SLIDING


def test_where_nothing_damps_there_is_no_region_to_settle_in():
    """Where a rise of friction has faded, rounding decided on the sign of eigenvalues, and Lyapunov's equation on S."""
    law = {"friction_coefficient": 0.1, "stribeck_rise": 0.05, "stribeck_speed": 1e-3, "axial_force": 34.0}
    motor = {"motor_inertia": 5e-6, "integral_gain": 19.127555772777217, "speed_gain": 0.0, "support_damping": 0.0}
    for mass in np.linspace(1.0, 4.0, 60):
        drive = Drive(**law, **motor, mass=mass, coupling_stiffness=10.0, input_speed=62.83185307179586)
        assert (automaton_of(drive).tables.flow.settled_level <= 0).all()


def test_amplitude_is_half_the_width_of_the_cycle_in_every_model():
    """Of samples, taken again beside the extrema, since u turns there at once: 1e-9 s at 10 rad/s are 1e-6 of it."""
    for model, parameters, start in (("threads", THREADS, (0.003, 0.0)), ("nut", NUT, (0.0289, 16.2))):
        cycle = steady_state(*build(model, parameters, *start))
        times, step = np.linspace(0, cycle.period, 20_001, retstep=True)
        angles = cycle.orbit.at(times)[0][:, 0]
        ends = []
        for place in (angles.argmin(), angles.argmax()):
            near = np.clip(times[place] + np.linspace(-step, step, 20_001), 0, cycle.period)
            ends.append(cycle.orbit.at(near)[0][:, 0])
        assert cycle.amplitude == pytest.approx(0.5 * (ends[1].max() - ends[0].min()), rel=1e-6)


CYCLES = (Attractor.STICK_SLIP_CYCLE, Attractor.SPRAG_SLIP_CYCLE, Attractor.OTHER_CYCLE)


def distances(found: SteadyState, motion: Motion, size: np.ndarray) -> tuple[float, float]:
    """Largest distance from an attractor, in sizes of the motion, over the motion's first and last hundredth."""
    points = found.state[None]
    if found.orbit is not None:
        points = np.vstack([found.orbit.after, found.orbit.at(np.linspace(0, found.period, 2000))[0]])
    times = motion.end_time * np.array([np.linspace(0, 0.01, 100), np.linspace(0.99, 1, 100)])
    first, last = (
        max(np.abs((points - state) / size).max(axis=1).min() for state in motion.at(part)[0]) for part in times
    )
    return float(first), float(last)


@pytest.mark.parametrize("model", OFFERED)
def test_motions_of_catalogue_drives_end_where_their_labels_say(model):
    unresolved, held = 0, 0
    for index in range(5):
        drive, starts = catalogue_drive(model, 32, index)
        automaton = automaton_of(drive)
        horizon = 20_000 * math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
        for start in starts:
            found = steady_state(automaton, start)
            if found.label == Attractor.UNRESOLVED:
                unresolved += 1
                assert found.doubt in (Doubt.EVENT_BUDGET, Doubt.RECURRENT, Doubt.WORK_BUDGET)
                continue
            assert found.label in (Attractor.STEADY_SLIDING, *CYCLES)
            if found.orbit is not None:
                assert found.residual <= 1e-9
                assert abs(found.multiplier) < 1
            try:
                motion = follow(automaton, start, horizon, budget=Budget(2e5))
            except WorkSpentError:
                continue
            size = np.abs(np.vstack([start, motion.end_state, motion.after[:1000]])).max(axis=0)
            first, last = distances(found, motion, size)
            assert last <= max(0.9 * first, 1e-3)
            held += 1
    assert unresolved <= 2
    assert held >= 10
