"""What follows a reverse slip that ends in a seizure, R < 0, is decided by the coupling torque (docs/physics.md)."""

import numpy as np
import pytest
from references.parts import threads_drive

from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.model import automaton_of
from lsvib.models.names import Event
from lsvib.models.rigid import MotionMode, rigid_automaton
from lsvib.stability.conditions import critical_value

FIG_8_14 = {"mass": 11.0, "support_damping": 1e-3}


def after_reverse_slips(drive: Drive, start, duration: float) -> list[tuple[int, int]]:
    """For each seizure of a reverse slip: T_r below (−1), in (0) or above (1) the band, and the mode after."""
    automaton = rigid_automaton(drive)
    motion = follow(automaton, start, duration, max_events=50)
    c = coefficients(drive)
    ends = sorted(float(c.xi[law]) * drive.pitch_radius * drive.axial_force for law in (1, -1))
    found = []
    for kind, sign, mode, after in zip(motion.kind, motion.sign, motion.mode, motion.after, strict=True):
        if (kind, sign) == (Event.SEIZURE, -1):
            torque = -drive.coupling_stiffness * (after[0] + float(c.deflection))
            found.append((int(torque > ends[1]) - int(torque < ends[0]), int(automaton.codes[mode])))
    return found


def test_the_motion_of_figure_8_14_has_three_in_a_row():
    for force in (-50.0, -10.0):
        drive = Drive.of(**FIG_8_14, axial_force=force)
        assert after_reverse_slips(drive, [0.30, -80.0], 0.01) == [
            (-1, MotionMode.SLIP_BACKWARD_POSITIVE),
            (-1, MotionMode.SLIP_BACKWARD_POSITIVE),
            (0, MotionMode.REST),
        ]


def test_in_the_band_one_rest_below_it_another_reverse_slip_above_it_slip_forward():
    random = np.random.default_rng(814)
    expected = {-1: MotionMode.SLIP_BACKWARD_POSITIVE, 0: MotionMode.REST, 1: MotionMode.SLIP_FORWARD_NEGATIVE}
    counts = dict.fromkeys(expected, 0)
    for _ in range(400):
        drive = Drive.of(
            friction_coefficient=random.uniform(0.12, 0.6),
            support_damping=10 ** random.uniform(-6, -2),
            axial_force=-(10 ** random.uniform(-1, 3)),
            input_speed=10 ** random.uniform(0, 3),
        )
        drive = drive.replace(mass=critical_value(drive, "mass") * random.uniform(1.01, 10))
        start = [10 ** random.uniform(-3, 0), -drive.input_speed * (1 + 10 ** random.uniform(-2, 1))]
        for side, mode in after_reverse_slips(drive, start, 0.05):
            counts[side] += 1
            assert mode == expected[side]
    assert min(counts.values()) > 10, counts


@pytest.mark.parametrize("force", [-50.0, -10.0])
def test_compliant_threads_do_the_same(force):
    """In the viscous limit the motion with three reverse slips is that of the rigid drive; the distance falls."""
    drive = Drive.of(**FIG_8_14, axial_force=force)
    times = np.linspace(0.0, 0.0045, 300)
    rigid = follow(rigid_automaton(drive), [0.30, -80.0], times[-1]).at(times)[0][:, 0]
    largest = []
    for stiffness in (1e8, 1e9, 1e10):
        compliant = threads_drive(dict(drive), contact_stiffness=stiffness, contact_damping=stiffness)
        motion = follow(automaton_of(compliant), [0.30, -80.0, 0.0, 0.0], times[-1])
        largest.append(np.abs(motion.at(times)[0][:, 0] - rigid).max() / np.ptp(rigid))
    assert largest[0] > 3 * largest[1] > 9 * largest[2]
    assert largest[2] < 1e-3
