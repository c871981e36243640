"""What figures 8.10 and 8.13 and the limit process are made of: cycles of compliant threads, and their impacts."""

import math

import numpy as np
import pytest
from references.parts import threads_drive

from lsvib.contact import stiff_limit
from lsvib.contact.stiff_limit import Region
from lsvib.dynamics.attractor import Attractor, orbit_extremes, steady_state
from lsvib.dynamics.impulses import seizure_impulses
from lsvib.engine.motion import follow
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.mechanism import seated_state
from lsvib.models.model import automaton_of
from lsvib.models.names import Event

VISCOUS = threads_drive(mass=11.0, axial_force=50.0)


@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e10])
def test_steady_state_is_where_the_motion_ends(stiffness):
    """A hundred time constants k_c / c_c = 1 1/s of creep later the motion itself is on the orbit."""
    drive = VISCOUS.replace(contact_stiffness=stiffness, contact_damping=stiffness)
    automaton = automaton_of(drive)
    cycle = steady_state(automaton, seated_state(drive, 0.003, 0.0))
    assert cycle.label == Attractor.SPRAG_SLIP_CYCLE
    motion = follow(automaton, seated_state(drive, 0.003, 0.0), 40.0)
    kind, mode = cycle.orbit.kind[-1], cycle.orbit.mode[-1]
    section = (motion.kind == kind) & (motion.mode == mode)
    last = motion.after[section][-1]
    np.testing.assert_allclose(last, cycle.state, rtol=1e-7)
    assert np.diff(motion.time[section])[-1] == pytest.approx(cycle.period, rel=1e-9)


def test_the_peak_of_the_contact_force_is_where_the_screw_stops():
    automaton = automaton_of(VISCOUS)
    cycle = steady_state(automaton, seated_state(VISCOUS, 0.003, 0.0)).orbit
    row = automaton.observables["normal_force"]
    (stop,) = cycle.after[cycle.kind == Event.STICK]
    assert orbit_extremes(cycle, row)[1] == pytest.approx(float(row[0, :-1] @ stop), rel=1e-12)


@pytest.mark.parametrize("changes", [{"mass": 9.0}, {"translation_damping": 1.0}, {"axial_force": -500.0}])
def test_limit_process_refuses_drives_that_it_does_not_fit(changes):
    drive = Drive.of({"mass": 15.0, "axial_force": 60.0, "support_damping": 2e-3} | changes)
    with pytest.raises(InputError, match=r"needs a drive with|reaches no cycle"):
        list(stiff_limit.branches(drive, 80.0, 1e-3, [0.1, -20.0]))


def test_impulse_is_the_integral_of_the_contact_force():
    base = Drive.of(mass=15.0, axial_force=60.0, support_damping=2e-3)
    drive = base.replace(contact_stiffness=1e8, contact_damping=1e8)
    impact = next(stiff_limit.impacts(base, 80.0))
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, impact.u, impact.w), 1e-3)
    release = motion.time[np.flatnonzero(motion.kind == Event.RELEASE)[0]]
    times = np.linspace(0.0, release, 2_000_001)
    force = automaton.observe("normal_force", *motion.at(times))
    integral = float(np.sum(0.5 * (force[1:] + force[:-1])) * times[1])
    impulse = stiff_limit.impact_impulse(drive, motion)
    assert impulse == pytest.approx(integral, rel=2e-4)  # the static force during the rest is left out of the impulse
    assert impulse == pytest.approx(float(seizure_impulses(base, 80.0).normal), rel=1e-3)


@pytest.mark.parametrize(("stiffness", "axial_force"), [(1e12, 25.0), (1e13, 40.0), (1e14, 60.0)])
def test_rebound_force_of_an_overdamped_contact(stiffness, axial_force):
    """How far N of the standing screw falls below its static value after a forward impact, by the formula (ζ = 20).

    The static value is that of the balance at rest, N = R cos λ − T_r sin λ / r_m; R keeps the contact closed. What an
    axial force gives to N is cos λ of it. 3 %: the formula leaves out that law + makes the contact stiffer than rest
    does, by cos λ (cos λ + μ sin λ) = 1.012, and that the slow part loses 3 ln(4ζ²) / (4ζ²) = 1.4 % until the fast one,
    4ζ² times as fast, is gone.
    """
    base = Drive.of(mass=15.0, axial_force=axial_force, support_damping=2e-3)
    damping, speed = 40 * math.sqrt(stiffness * base.mass), 80.0
    drive = base.replace(contact_stiffness=stiffness, contact_damping=damping)
    (impact,) = (
        x for x in stiff_limit.impacts(base, speed) if x.sign > 0 and x.region == Region.IN_BAND_FORCE_POSITIVE
    )
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, impact.u, impact.w), 7e-4)
    (stop,) = np.flatnonzero(motion.kind == Event.STICK)
    assert stop == motion.kind.size - 1  # it stands until the end
    times = motion.time[stop] + np.geomspace(1e-12, motion.end_time - motion.time[stop], 20_001)[:-1]
    states, modes = motion.at(times)
    force = automaton.observe("normal_force", states, modes)
    torque = automaton.observe("coupling_torque", states, modes)
    static = axial_force * math.cos(drive.lead_angle) - torque * math.sin(drive.lead_angle) / drive.pitch_radius
    fall = (static - force) / math.cos(drive.lead_angle)
    assert abs(fall[-1]) < 0.02 * fall.max() < 0.02 * axial_force
    nut = drive.pitch_radius * math.tan(drive.lead_angle) * speed
    assert fall.max() == pytest.approx(drive.mass**2 * nut * stiffness**2 / damping**3, rel=0.03)
