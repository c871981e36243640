"""The datasets of the figures: on draft settings every check passes, and each fails once its data are spoiled."""

import numpy as np
import pytest
from references.figure_checks import dataset_of, draft, figure_tests, scale, set_to

from lsvib.basins.exact_basin import Boundary
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.cycles.impulses import mean_load, seizure_impulses
from lsvib.data import phase_plane
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import EventKind, rigid_automaton
from lsvib.engine.motion import follow
from lsvib.errors import InputError
from lsvib.figures.basin_sweep import dataset as basin_sweep
from lsvib.figures.fig8_06 import dataset as fig8_06

SPRAG_DRIVE = {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}


SPOILERS = {
    "fig8_04": {
        "three conditions": set_to("margin_force_with_motion", -1.0),
        "unstable by its eigenvalues": set_to("eigenvalue_real_part", -1.0),
        "leaves it": scale("angle_deviation", 0.0, 0, 0, slice(500, None)),
        "limit cycle attracts": scale("amplitude", 1 + 1e-9, 0, 0, 1),
    },
    "fig8_05": {
        "only the second": set_to("margin_force_with_motion", 1.0),
        "stable by its eigenvalues": set_to("eigenvalue_real_part", 1.0),
        "approaches the origin": set_to("angle_deviation", 1.0, 0, 1, slice(-5, None)),
        "settles on the origin": set_to("attractor", Attractor.OTHER_CYCLE, 0, 1, 0),
    },
    "fig8_06": {
        "Tangent of the lead angle": scale("lead_tangent", 1.001),
        "self-locking": set_to("friction_coefficient", 0.09),
        "sets in": scale("onset_force", 1.02),
        "first touches rest": scale("stick_force", 1.03),
        "no longer reaches": scale("detach_force", 1.05),
        "amplitude is zero": set_to("swept_amplitude", 1e-12, 3),
        "straight line": scale("swept_amplitude", 1 + 1e-6, 15),
        "is constant": scale("swept_amplitude", 1 + 1e-9, -1),
        "changes kind": set_to("regime", 0, 20),
        "line of rest": set_to("smallest_velocity", -40.0, 15),
        "origin is stable": set_to("attractor", Attractor.OTHER_CYCLE, 0, 0, 0),
        "pure-slip limit cycle": set_to("attractor", Attractor.STICK_SLIP_CYCLE, 1, 0, 0),
        "stick-slip cycle attracts": set_to("attractor", Attractor.OTHER_CYCLE, 2, 0, 1),
        "damping C₋": scale("reading_effective_damping_minus", 1.02),
        "damping C₊": scale("reading_effective_damping_plus", 0.95),
        "inertia Γ₋": scale("reading_effective_inertia_minus", 0.99),
        "inertia Γ₊": scale("reading_effective_inertia_plus", 0.99),
        "are not those of m = 8": set_to("reading_stick_force", 34.6),
    },
    "fig8_07": {
        "existence analysis": set_to("existence", 1, 10, 10),
        "seizes at once": set_to("event_sign", -1, 0, 0, 0),
        "slips under law -1": set_to("mode", 4, 0, 2, 0),
        "converges to u_0": scale("law_minus_angle", 1 + 1e-9, 0),
        "beyond the line": scale("contact_line_angle", 100.0),
    },
    "fig8_09": {
        "critical mass lies between": scale("effective_inertia_plus", -1.0, 0),
        "decays to the origin": set_to("attractor", Attractor.SPRAG_SLIP_CYCLE, 0, 1, 0),
        "one sprag-slip cycle": scale("amplitude", 1 + 1e-9, 1, 1, 1),
        "axial force, which the text leaves out": scale("impact_speed", 0.9, 0),
    },
    "fig8_11": {
        "sprag-slip cycle at each": set_to("attractor", Attractor.STEADY_SLIDING, 0, 0, 0),
        "amplitude falls": scale("amplitude", 2.0, 2, 0, 0),
        "starts on the line": scale("contact_line_angle", 1 + 1e-9),
        "both rules": scale("amplitude", 1 + 1e-15, 1, 1, 0),
    },
    "fig8_12": {
        "sprag-slip cycle for every": set_to("attractor", Attractor.STICK_SLIP_CYCLE, 1, 3),
        "amplitude falls": scale("amplitude", 2.0, 1, -1),
        "mean deflection": scale("mean_deflection", 0.5, 0, -1),
        "mean of |N|": scale("mean_normal_force", 0.5, 0, -1),
        "Without rest both rules": scale("amplitude", 1 + 1e-9, 1, -1),
        "axial contact force": scale("mean_axial_contact_force", 1 + 1e-9, 0, 5),
        "contact torque": scale("mean_contact_torque", 1 + 1e-9, 0, 5),
    },
    "fig8_14": {
        "printed corner": scale("corner_angle", 1 + 1e-9, 2),
        "up to the corner": set_to("corner_attractor", Attractor.SPRAG_SLIP_CYCLE, 2, 1, 7),
        "printed mass has": scale("effective_inertia_plus", -1.0, 0),
        "(a) m = 10 kg": set_to("event_kind", EventKind.STICK, 0, 0),
        "(a) m = 11 kg": set_to("attractor", Attractor.SPRAG_SLIP_CYCLE, 2, 1, 1),
        "(b) m = 10 kg": set_to("grid_attractor", Attractor.SPRAG_SLIP_CYCLE, 1, 0, 0),
        "(b) m = 11 kg": scale("amplitude", 1 + 1e-9, 3, 1, 0),
        "threshold of global stability lies": scale("global_stability_force", 2.0),
        "leaves rest changes": set_to("bracket_attractor", Attractor.STEADY_SLIDING, 0, 1),
        "seizures accumulate in the corner": scale("seizure_distance", 1.001, 2, 1, 8),
        "in finite time": scale("seizure_time", 1.001, 3, 1, 5),
        "rest after a few seizures": set_to("seizure_distance", 1e-3, 2, 0),
    },
    "basin_sweep": {
        "globally stable exactly": set_to("fraction_axial_force", 0.5, 0),
        "Over the damping": set_to("boundary_kind_support_damping", Boundary.CYCLE, -1),
        "Over mass and friction": scale("critical_mass", 1.01),
        "quite small": set_to("reading_fraction", 0.02, 1, 1),
        "As printed steady sliding": set_to("reading_fraction", 0.99, 0, 1),
        "square of the force": scale("basin_area_axial_force", 1 + 1e-9, -1),
        "counted on grids": set_to("grid_fraction", 0.9, 0, -1),
    },
}
test_checks_pass, test_check_fails, test_is_drawn = figure_tests(SPOILERS)


def test_backward_the_thresholds_have_another_order_and_the_checks_fail():
    """Ω < 0: no force lies between onset and stick as they are ordered forward."""
    settings = draft("fig8_06")
    backward = {**settings["drive"], "input_speed": -40.0}
    dataset = fig8_06.build(settings | {"drive": backward, "axial_force": {"start": -60.0, "stop": 0.0, "count": 5}})
    failed = {check.claim for check in fig8_06.checks(dataset) if not check.passed}
    assert any("straight line" in claim for claim in failed)


def test_a_sweep_without_the_motion_that_touches_fails_its_check():
    dataset = set_to("boundary_kind_axial_force", Boundary.NONE)(dataset_of("basin_sweep"))
    assert any("square of the force" in c.claim and not c.passed for c in basin_sweep.checks(dataset))


def test_samples_hold_every_event_before_and_after():
    motion = follow(rigid_automaton(RigidParameters.of(SPRAG_DRIVE)), [-0.25, 60.0], 0.1)
    times, states, modes = phase_plane.sample(motion, 500)
    assert times.size == 500
    assert (np.diff(times) >= 0).all()
    assert (times[0], times[-1]) == (0.0, 0.1)
    assert motion.automaton.codes[modes].dtype == np.int8
    for time, before, after in zip(motion.time, motion.before, motion.after, strict=True):
        at = states[times == time]
        assert (at[0] == before).all()
        assert (at[-1] == after).all()
    exact, _ = motion.at(times)
    smooth = ~np.isin(times, motion.time)
    np.testing.assert_array_equal(states[smooth][:-1], exact[smooth][:-1])


def test_too_few_samples_are_refused():
    motion = follow(rigid_automaton(RigidParameters.of(SPRAG_DRIVE)), [-0.25, 60.0], 1.0)
    with pytest.raises(InputError, match="samples = 100 is outside the allowed range samples >= "):
        phase_plane.sample(motion, 100)


@pytest.mark.parametrize("speed", [80.0, -25.0])
def test_seizure_impulses_stop_screw_and_nut(speed):
    drive = RigidParameters.of(SPRAG_DRIVE)
    impulses = seizure_impulses(drive, speed)
    sine, cosine = np.sin(drive.lead_angle), np.cos(drive.lead_angle)
    tangential = (float(impulses.axial) - float(impulses.normal) * cosine) / sine
    # m Δx′ and I Δθ′ of the stop, from the two impulses of the contact
    assert float(impulses.normal) * cosine + tangential * sine == pytest.approx(
        drive.mass * drive.pitch_radius * np.tan(drive.lead_angle) * speed, rel=1e-12
    )
    assert drive.pitch_radius * (tangential * cosine - float(impulses.normal) * sine) == pytest.approx(
        drive.screw_inertia * speed, rel=1e-10
    )
    # beyond the critical mass friction is strong enough to lock the contact, and the impulse has the sign of θ′
    assert abs(tangential / float(impulses.normal)) < drive.friction_coefficient
    assert np.sign(impulses.normal) == np.sign(speed)


@pytest.mark.parametrize("force", [-10.0, 50.0])
@pytest.mark.parametrize("damping", [1e-5, 1e-3])
def test_mean_load_balances_the_momenta(force, damping):
    drive = RigidParameters.of(mass=11, axial_force=force, support_damping=damping)
    steady = steady_state(rigid_automaton(drive), [0.1, 0.0])
    load = mean_load(drive, steady.orbit)
    assert load.axial == pytest.approx(force, rel=1e-12)
    assert load.torque == pytest.approx(
        -drive.coupling_stiffness * load.deflection - damping * drive.input_speed, rel=1e-12
    )
    assert 0 < load.impulsive < load.normal
