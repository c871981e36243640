"""Where motions end up: labels, and the residual and multiplier of a cycle.

For a cycle of pure slip the multiplier of the return map is known from elsewhere. The field is continuous across Q = 0,
so by Liouville's formula it is exp ∮ div = exp(−Σ a₁ τ) over the arcs of the cycle. Tolerance 1e-12: the
library takes the multiplier from an exact product over some events.
"""

import math

import numpy as np
import pytest

from lsvib.dynamics.attractor import Attractor, orbit_extremes, steady_state
from lsvib.dynamics.energy import observable_integrals
from lsvib.dynamics.kernels import attractor as rule
from lsvib.engine.kernels import flow_planar, layout
from lsvib.models.drive import Drive
from lsvib.models.names import Event
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.force_thresholds import threshold_force

NEGATIVE_DAMPING = Drive.of(mass=1.0, translation_damping=1e3)
PARADOX = Drive.of(mass=11.0, support_damping=1e-3, axial_force=-10.0)


def attractor(drive, start=(0.05, 5.0), **options):
    return steady_state(rigid_automaton(drive, **options), start)


def liouville(cycle) -> float:
    modes, _, _, durations = cycle.orbit.arcs()
    return math.exp(-float(np.sum(cycle.orbit.automaton.tables.flow[modes, layout.A1] * durations)))


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
    assert cycle.amplitude / (force - onset) == pytest.approx(
        reference.amplitude / (25.0 - onset), rel=rounding + 1e-13
    )
    assert cycle.period == pytest.approx(reference.period, rel=1e-13, abs=0)


@pytest.mark.parametrize("force", [36.0, 40.0, 46.0, 47.0, 60.0])
def test_stick_slip_is_superstable(force):
    """Rest ends in the same state whatever came before: the multiplier is 0, and the state repeats to the last bit."""
    cycle = attractor(NEGATIVE_DAMPING.replace(axial_force=force))
    assert cycle.label == Attractor.STICK_SLIP_CYCLE
    assert (cycle.multiplier, cycle.residual) == (0.0, 0.0)
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


@pytest.mark.parametrize(
    "drive", [Drive(), NEGATIVE_DAMPING.replace(axial_force=18.0), PARADOX.replace(axial_force=-50.0)]
)
def test_steady_sliding_attracts(drive):
    found = attractor(drive)
    assert found.label == Attractor.STEADY_SLIDING
    assert found.orbit is None
    assert found.amplitude == 0.0
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
    row = rigid_automaton(drive).tables.flow[found.orbit.start_mode]
    assert found.period == pytest.approx(2 * math.pi / row[layout.BETA], rel=4 * flow_planar.EPS)
    assert found.amplitude == pytest.approx(math.hypot(0.01, 5.0 / row[layout.BETA]), rel=1e-14)


@pytest.mark.parametrize(("mass", "damping", "force"), [(8, 3e3, 1e3), (10, 1e3, 1e3), (5, 1e4, 5e3), (10, 3e3, 5e3)])
def test_unbounded(mass, damping, force):
    """Without rest, slip grows for ever where law + feeds in more than law − takes out (Γ₊ small, C₊ negative).

    In the last two C₊ < −2 √(k Γ₊): an unstable node, which is left for ever without meeting Q = 0 again.
    """
    drive = Drive.of(mass=mass, translation_damping=damping, axial_force=force)
    assert attractor(drive, rest=False).label == Attractor.UNBOUNDED


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
    force = cycle.orbit.automaton.observe("normal_force", states, modes)
    torque = cycle.orbit.automaton.observe("coupling_torque", states, modes)
    low, high = orbit_extremes(cycle.orbit, cycle.orbit.automaton.observables["normal_force"])
    # Between samples an extremum hides by (h/2)²/2 of the curvature: 1e-8 of the swing; the kink at N = 0 costs h².
    assert low == pytest.approx(force.min(), rel=1e-6)
    assert high == pytest.approx(force.max(), rel=1e-6)
    assert 2 * cycle.amplitude == pytest.approx(np.ptp(states[:, 0]), rel=1e-6)
    over_arcs = observable_integrals(cycle.orbit, ("coupling_torque", "normal_force"))
    assert over_arcs[:, 0].sum() == pytest.approx(cycle.period * np.mean(torque[:-1]), rel=1e-6)
    mean_of_size = cycle.period * np.mean(np.abs(force[:-1]))
    assert np.abs(over_arcs[:, 1]).sum() == pytest.approx(mean_of_size, rel=1e-6)


def test_the_rule_is_compiled_once_for_all_kinds_of_flow():
    """One compiled version after labels of a rigid drive, of compliant threads, and under a friction law."""
    for more in (
        {},
        {"contact_stiffness": 1e6, "contact_damping": 1e4},
        {"stribeck_rise": 0.02, "stribeck_speed": 0.01},
    ):
        drive = Drive.of(mass=2.0, **more)
        assert drive.steady_state({"u": 0.05, "w": 5.0}).label != Attractor.UNRESOLVED
    drive.sweep(axial_force=[40.0, 50.0])
    assert len(rule.end_of.overloads) == 1
