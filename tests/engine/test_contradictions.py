"""Where surfaces meet, rounding may make two judgements contradict each other; once the motion was refused there."""

import math

import numpy as np
import pytest
from judge.long_run import constants_of, fate
from references.wide_drives import wide_drive
from references.wide_scenes import scene

from benchmarks.sweeps.case_judge import allowed_residual
from benchmarks.sweeps.energy_balance import balance
from lsvib.cycles.attractors import steady_state
from lsvib.drives.registry import find_model
from lsvib.engine.kernels import event_loop
from lsvib.engine.motion import follow


@pytest.mark.parametrize(("index", "start"), [(28, 3), (46, 2)])
def test_a_corner_without_axial_force_is_passed(index, start):
    """The threads seize where torque and contact force are zero: rest has no room, and slip began and stopped at once.

    No event is told twice at one instant, and the energy of the motion balances.
    """
    wide = wide_drive("nut", 71, index, 4)
    assert wide.drive.axial_force == 0
    motion = follow(*scene("nut", 71, index, start), math.inf, max_events=200)
    steps = np.stack([np.diff(motion.time), np.diff(motion.mode), np.diff(motion.kind)])
    assert (steps != 0).any(axis=0).all()
    drawn = balance(motion, wide.drive, wide.physics)
    assert drawn.residual <= allowed_residual(drawn.rounding)


@pytest.mark.parametrize(
    ("index", "state", "mode"),
    [
        (5, (-90.56203431083108, 221.94342535227997, -7.0053803197316, 0.1652314871640499), 0),
        (18, (-7.998934290841737, 120.08542158069365, -3.731262135050716e-12, -1.935590412927013e-05), 3),
        (18, (-80.32141914016333, 120.08536479684813, -3.655509430837227e-11, -7.613974965181569e-05), 3),
    ],
)
def test_a_motion_goes_on_from_the_instant_of_a_release(index, state, mode):
    """The threads have just let go: the slip has no acceleration yet, and rounding seemed to stop it."""
    automaton, _ = scene("nut", 71 if index == 5 else 72, index, 0)
    motion = follow(automaton, state, math.inf, mode=mode, max_events=2 * event_loop.MANY)
    assert motion.time[0] > 0


def test_a_motion_that_was_cut_there_is_followed_to_its_end():
    """By leaps, whose parts begin at releases."""
    wide = wide_drive("nut", 72, 18, 4)
    found = steady_state(*scene("nut", 72, 18, 1))
    assert found.label.name.lower() == fate(wide, 1, *constants_of(wide)).name == "steady_sliding"


def test_a_slip_that_begins_without_acceleration_is_not_stopped_by_the_rounding_of_its_time():
    """The threads let go of a nut that a heavy damper holds; its acceleration is that of a release 2·10⁻¹¹ s too early.

    Slip seemed to stop at once, again and again, and began 1.9·10⁻⁷ s late, after what was taken for an accumulation.
    Time of the release: the reference with 40 digits.
    """
    wide = wide_drive("support", 903, 226, 32)
    automaton = find_model("support").build(wide.drive, wide.physics, "contact_sign")
    motion = follow(automaton, wide.starts[31], 0.2, max_events=3)
    assert motion.time[-1] == pytest.approx(0.0930100229432725, rel=1e-14)
    assert follow(automaton, wide.starts[31], 0.2, max_events=60).time.tolist() == motion.time.tolist()
