"""Figures 8.10 and 8.13 and the limit process: every check passes and fails on spoiled data; what they are made of."""

import math

import numpy as np
import pytest
from references.figure_checks import dataset_of, draft, figure_tests, scale, set_to

from lsvib.contact import limit_process
from lsvib.contact.limit_process import BranchFamily, Region
from lsvib.cycles.attractors import Attractor, orbit_extremes, steady_state
from lsvib.cycles.curve_distance import Orbit, farthest
from lsvib.cycles.impulses import seizure_impulses
from lsvib.data.writer import read_dataset, write_dataset
from lsvib.drives.parameters import RigidParameters, ThreadsParameters
from lsvib.drives.rigid import EventKind, rigid_automaton
from lsvib.drives.threads import ThreadsEvent, seated_state, threads_automaton
from lsvib.engine.motion import follow
from lsvib.errors import InputError
from lsvib.figures.fig8_10 import dataset as fig8_10
from lsvib.figures.fig8_10.picture import draw
from lsvib.figures.limit_process.dataset import BranchVerdict

SPOILERS = {
    "fig8_10": {
        "Peak of the contact force": scale("peak_normal_force", 1.03),
        "within 2 % of 320 kN": scale("swept_peak_normal_force", 1.03, -1),
        "within 2 % of the rigid one": scale("orbit_distance", 1.3),
        "repeats to 1e-9": set_to("swept_attractor", Attractor.STICK_SLIP_CYCLE, 0),
        "Largest sample of N(t)": scale("normal_force", 1 - 1e-5),
    },
    "fig8_13": {
        "different distances beyond": set_to("critical_mass_with_contact", 12.0, 0),
        "repeats to 1e-9": set_to("period_residual", 1e-8, 1),
        "smoother": scale("largest_acceleration", 100.0, -1),
        "becomes positive with the softest": set_to("largest_deflection", 1e-3, 0),
        "during sprag": scale("sprag_deflection", 1 - 1e-9, -1),
        "bounds the positive deflections": scale("boundary_contact_damping", 0.3, 1),
        "Every contact of the sweep": set_to("grid_attractor", Attractor.STEADY_SLIDING, 0, 0),
    },
    "limit_process": {
        "converges to the rigid one under the rule contact_sign": set_to("rule_followed", BranchVerdict.AT_ONCE, 0, 0),
        "errors of rest, impulse and period": set_to("impulse_error_order", 0.7, 0, 3),
        "rules of resuming part": set_to("rule_followed", BranchVerdict.BOTH),
        "time that an impact takes": scale("stop_time", 100.0, 1, 0, -1),
        "on no branch": set_to("rule_followed", BranchVerdict.CONTACT_SIGN, 2, 5),
        "chain of short rests": set_to("rests", 1, 2, 0, -1),
        "overdamped contact": set_to("impulse_error", 1e-3, 1, 0, -1),
    },
}
test_checks_pass, test_check_fails, test_is_drawn = figure_tests(SPOILERS)
VISCOUS = ThreadsParameters.of(mass=11.0, axial_force=50.0)


def test_without_a_cycle_checks_fail_and_the_rest_is_drawn(tmp_path):
    """Below the critical mass nothing sprags: no peak, no period."""
    settings = draft("fig8_10")
    dataset = fig8_10.build(settings | {"drive": {**settings["drive"], "mass": 9.0}})
    assert not any(check.passed for check in fig8_10.checks(dataset))
    write_dataset(dataset, tmp_path / "a.nc")
    draw(read_dataset(tmp_path / "a.nc")).draw_without_rendering()


def test_farthest_point_from_a_polygon():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert farthest(np.array([[0.5, 0.25], [2.0, 1.0], [-3.0, -4.0]]), square) == 5.0
    assert farthest(np.array([[0.5, 0.0]]), square) == 0.0


def test_distance_of_shifted_cycles_is_the_shift():
    cycle = steady_state(threads_automaton(VISCOUS), seated_state(VISCOUS, 0.003, 0.0))
    orbit = Orbit.of(cycle.orbit, (cycle.amplitude, VISCOUS.input_speed))
    shift = np.array([0.01, 0.0])
    shifted = Orbit(orbit.scales, orbit.polygon + shift, orbit.points + shift)
    assert orbit.distance(orbit) < 1e-5
    assert orbit.distance(shifted) == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e10])
def test_steady_state_is_where_the_motion_ends(stiffness):
    """A hundred time constants k_c / c_c = 1 1/s of creep later the motion itself is on the orbit."""
    drive = VISCOUS.replace(contact_stiffness=stiffness, contact_damping=stiffness)
    automaton = threads_automaton(drive)
    cycle = steady_state(automaton, seated_state(drive, 0.003, 0.0))
    assert cycle.label == Attractor.SPRAG_SLIP_CYCLE
    motion = follow(automaton, seated_state(drive, 0.003, 0.0), 40.0)
    kind, mode = cycle.orbit.kind[-1], cycle.orbit.mode[-1]
    section = (motion.kind == kind) & (motion.mode == mode)
    last = motion.after[section][-1]
    np.testing.assert_allclose(last, cycle.state, rtol=1e-7)
    assert np.diff(motion.time[section])[-1] == pytest.approx(cycle.period, rel=1e-9)


def test_the_peak_of_the_contact_force_is_where_the_screw_stops():
    automaton = threads_automaton(VISCOUS)
    cycle = steady_state(automaton, seated_state(VISCOUS, 0.003, 0.0)).orbit
    row = automaton.observables["normal_force"]
    (stop,) = cycle.after[cycle.kind == ThreadsEvent.STICK]
    assert orbit_extremes(cycle, row)[1] == pytest.approx(float(row[0, :-1] @ stop), rel=1e-12)


@pytest.mark.parametrize(("force", "damping"), [(60.0, 1e-4), (60.0, 2e-3), (-20.0, 1e-4), (-20.0, 2e-3)])
def test_impacts_seize_at_once_with_the_sign_they_name(force, damping):
    drive = RigidParameters.of(mass=15.0, axial_force=force, support_damping=damping)
    found = list(limit_process.impacts(drive, 80.0))
    assert len(found) >= 6
    for impact in found:
        motion = follow(rigid_automaton(drive), [impact.u, impact.w], 1e-6)
        assert (motion.time[0], motion.kind[0], motion.sign[0]) == (0.0, EventKind.SEIZURE, impact.sign)


def test_all_sixteen_branches_are_reached():
    found = dataset_of("limit_process")
    rows = zip(np.sign(found.axial_force.values), found.impact_sign.values, found.region.values, strict=True)
    assert len({row for row in rows if row[2] != Region.CYCLE}) == 16


@pytest.mark.parametrize("changes", [{"mass": 9.0}, {"translation_damping": 1.0}, {"axial_force": -500.0}])
def test_limit_process_refuses_drives_that_it_does_not_fit(changes):
    drive = RigidParameters.of({"mass": 15.0, "axial_force": 60.0, "support_damping": 2e-3} | changes)
    with pytest.raises(InputError, match=r"needs a drive with|reaches no cycle"):
        list(limit_process.branches(drive, 80.0, 1e-3, [0.1, -20.0]))


def test_impulse_is_the_integral_of_the_contact_force():
    base = RigidParameters.of(mass=15.0, axial_force=60.0, support_damping=2e-3)
    drive = limit_process.stiffened(base, BranchFamily.VISCOUS, 1e8, 2.0)
    impact = next(limit_process.impacts(base, 80.0))
    automaton = threads_automaton(drive)
    motion = follow(automaton, seated_state(drive, impact.u, impact.w), 1e-3)
    release = motion.time[np.flatnonzero(motion.kind == ThreadsEvent.RELEASE)[0]]
    times = np.linspace(0.0, release, 2_000_001)
    force = automaton.observe("normal_force", *motion.at(times))
    integral = float(np.sum(0.5 * (force[1:] + force[:-1])) * times[1])
    impulse = limit_process.impact_impulse(drive, motion)
    assert impulse == pytest.approx(integral, rel=2e-4)  # the static force during the rest is left out of the impulse
    assert impulse == pytest.approx(float(seizure_impulses(base, 80.0).normal), rel=1e-3)


def test_orders_are_recovered_from_powers():
    stiffness = np.geomspace(1e5, 1e9, 9)
    order, error = limit_process.fitted_order(stiffness, 3 * stiffness**-0.75)
    assert order == pytest.approx(0.75, abs=1e-12)
    assert error < 1e-12
    noisy = stiffness**-1.0 * np.where(np.arange(9) % 2, 1.1, 1 / 1.1)
    order, error = limit_process.fitted_order(stiffness, noisy)
    assert abs(order - 1) < 3 * error < 0.1
    assert math.isnan(limit_process.fitted_order(stiffness[:3], np.array([1.0, np.nan, 0.1]))[0])


@pytest.mark.parametrize(("stiffness", "axial_force"), [(1e12, 25.0), (1e13, 40.0), (1e14, 60.0)])
def test_rebound_force_of_an_overdamped_contact(stiffness, axial_force):
    """How far N of the standing screw falls below its static value after a forward impact, by the formula (ζ = 20).

    The static value is that of the balance at rest, N = R cos λ − T_r sin λ / r_m; R keeps the contact closed. What an
    axial force gives to N is cos λ of it. 3 %: the formula leaves out that law + makes the contact stiffer than rest
    does, by cos λ (cos λ + μ sin λ) = 1.012, and that the slow part loses 3 ln(4ζ²) / (4ζ²) = 1.4 % until the fast one,
    4ζ² times as fast, is gone.
    """
    base = RigidParameters.of(mass=15.0, axial_force=axial_force, support_damping=2e-3)
    drive, speed = limit_process.stiffened(base, BranchFamily.DAMPING_RATIO, stiffness, 20.0), 80.0
    (impact,) = (
        x for x in limit_process.impacts(base, speed) if x.sign > 0 and x.region == Region.IN_BAND_FORCE_POSITIVE
    )
    automaton = threads_automaton(drive)
    motion = follow(automaton, seated_state(drive, impact.u, impact.w), 7e-4)
    (stop,) = np.flatnonzero(motion.kind == ThreadsEvent.STICK)
    assert stop == motion.kind.size - 1  # it stands until the end
    times = motion.time[stop] + np.geomspace(1e-12, motion.end_time - motion.time[stop], 20_001)[:-1]
    states, modes = motion.at(times)
    force = automaton.observe("normal_force", states, modes)
    torque = automaton.observe("coupling_torque", states, modes)
    static = axial_force * math.cos(drive.lead_angle) - torque * math.sin(drive.lead_angle) / drive.pitch_radius
    fall = (static - force) / math.cos(drive.lead_angle)
    assert abs(fall[-1]) < 0.02 * fall.max() < 0.02 * axial_force
    assert fall.max() == pytest.approx(limit_process.rebound_force(drive, speed), rel=0.03)
