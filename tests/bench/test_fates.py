"""The judge of fates: where motions of random drives end, by patience and by theory."""

import math

import numpy as np
import pytest
from judge import command, long_run
from judge.fate import fate
from judge.linear_judge import rates
from judge.second_opinions import watch
from judge.wide_drives import wide_drive

from references import rigid_digits
from lsvib.drives.parameters import RigidParameters

SEED = 7
CHAPTER = {  # what the chapter's drives do, by the figures
    "steady_sliding": ({"mass": 10.0}, (1e-3, 0.0)),
    "sprag_slip_cycle": ({"mass": 11.0}, (1e-3, 0.0)),
    "stick_slip_cycle": ({"translation_damping": 1e3, "axial_force": 40.0}, (1e-3, 0.0)),
    "other_cycle": ({"translation_damping": 1e3, "axial_force": 25.0}, (1e-3, 0.0)),
    "neutral_family": ({"support_damping": 0.0}, (1e-3, 0.0)),
}
WITHOUT_EDGES = {  # drives whose fate only patience shows: the return map drifts by a part in 10⁵ to 10¹² in a turn
    (1, 25, 1): "steady_sliding",
    (1, 27, 1): "steady_sliding",
    (1, 53, 1): "steady_sliding",
    (1, 168, 3): "steady_sliding",
    (1, 219, 1): "steady_sliding",
    (1, 24, 3): "neutral_family",
}


@pytest.mark.parametrize("name", CHAPTER)
def test_the_fates_of_the_chapters_drives(name):
    """The judge of fates sees in the chapter's drives what its figures show."""
    changes, start = CHAPTER[name]
    assert fate(watch.constants(dict(RigidParameters.of(changes))), *start).name == name


@pytest.mark.parametrize("key", WITHOUT_EDGES)
def test_slow_drifts_are_followed_to_their_end(key):
    """A drift that takes millions of turns is leapt over, and where it ends is known."""
    seed, index, start = key
    wide = wide_drive("rigid", seed, index, command.STARTS)
    assert fate(watch.constants(dict(wide.drive)), *wide.starts[start]).name == WITHOUT_EDGES[key]


def test_a_small_undamped_motion_does_not_come_to_rest():
    """R = 0 and no damping: a start at 1e-10 of the drive's size stays on its closed orbit."""
    drive = RigidParameters.of(axial_force=0.0, support_damping=0.0, translation_damping=0.0, mass=5.0)
    constants = watch.constants(dict(drive))
    start = 1e-10 * constants.scale, 1e-10 * constants.speed
    assert fate(constants, *start).name == "neutral_family"


def test_a_faint_damping_is_none_only_without_dampers():
    """Pairs of doubles lose a damping by 1e-23 1/s beside rates of 1e6 1/s, and called the motion neutral (82/25)."""
    wide = wide_drive("threads", 82, 25, command.STARTS)
    damping = -float(min(rate.real for rate in rates(wide) if abs(rate) < 10))
    assert damping == pytest.approx(1.0517e-23, rel=1e-4)
    assert long_run.fate(wide, 0, *long_run.constants_of(wide)).name == "steady_sliding"
    undamped = wide._replace(drive=type(wide.drive).of({**dict(wide.drive), "contact_damping": 0.0}))
    lasting = next(rate for rate in rates(undamped) if abs(rate) < 10)
    assert long_run._growth(undamped, lasting, max(map(abs, rates(undamped)))) == 0


def test_a_drift_that_fades_into_rounding_does_not_turn_back():
    """Seizures move u by 2e-5 rad and less of 1.8e8 rad, always the same way: 40 digits show no cycle (9901/1942)."""
    drive = {**dict(wide_drive("rigid", 9901, 1942, 16).drive), "axial_force": 0.10404606403887738}
    start = (-176392941.47735777, -drive["input_speed"])
    found = fate(watch.constants(drive), *start)
    assert (found.name, found.reason) == ("unknown", "a drift that fades into rounding")
    ends = [
        rigid_digits.simulate(drive, start[0] + offset, start[1], 3e-9, dps=50).events for offset in (0.0, 1e-3, 1e-2)
    ]
    assert all(float(event.u_after) > start[0] for events in ends for event in events)


def test_starts_that_soon_settle_are_those_that_the_judge_of_fates_sees_settle():
    """What is told of many starts at once is what is told of each."""
    told = 0
    for index in range(12):
        wide = wide_drive("rigid", SEED, index, 20)
        constants = watch.constants(dict(wide.drive))
        for start in wide.starts[watch.come_to_rest(constants, wide.starts)]:
            told += 1
            assert fate(constants, *start).name == "steady_sliding"
    assert told > 40


def test_nothing_is_unbounded_by_energy():
    """The bound of the module ``fate``: far out, a turn of the undamped drive loses energy by the threads alone."""
    drive = RigidParameters.of(support_damping=0.0, translation_damping=0.0, mass=5.0)
    c = watch.constants(dict(drive))
    times, kinds, modes = np.empty(9), np.empty(9, dtype=np.int64), np.empty(9, dtype=np.int64)
    states = np.empty((9, 2))
    watch.watch(c, 1e6, -c.speed, watch.ANYWHERE, math.inf, False, times, kinds, modes, states)
    stopped = np.abs(states[kinds != watch.CONTACT_REVERSAL, 0])
    assert (np.diff(stopped) < 0).all()
