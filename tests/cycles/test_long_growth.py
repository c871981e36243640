"""Motions that are told only where they have been followed for long: what they have come to has no trend."""

import math

import numpy as np
import pytest
from references.wide_scenes import scene

from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.cycles.cones import growing
from lsvib.cycles.patience import follow_patiently
from lsvib.cycles.quiet import quiet_until
from lsvib.cycles.return_map import conserves
from lsvib.cycles.trends import no_trend, stays, trend_of
from lsvib.engine.motion import Budget, follow

# The screw sticks while the support vibrates under it, and slips back once in some two thousand events: a state after
# 600 000 events of support 83/12, start 0, in the mode 10 of slip.
GROWN, GROWN_MODE = [4.358297197e-01, -1.606883098e02, 3.167224697e-09, -8.240110646e-06], 10


def parts_of(automaton, state, mode, many, events):
    """So many parts of a motion, each of so many events."""
    found = []
    for _ in range(many):
        found.append(follow(automaton, state, math.inf, mode=mode, max_events=events))
        state, mode = found[-1].end_state, found[-1].end_mode
    return found


def test_what_has_grown_has_no_trend_and_what_grows_has():
    automaton, state = scene("support", 83, 12, 0)
    assert stays(parts_of(automaton, GROWN, GROWN_MODE, 3, 64_000))
    assert not stays(parts_of(automaton, state, None, 3, 32_000))


def test_what_winds_up_does_not_stay():
    """No amplitude of the rattling contact has a trend, but the angle has."""
    automaton, start = scene("threads", 82, 50, 3)
    assert not stays(parts_of(automaton, [2.5264e8, start[1], 8.8483e-3, -2.0991e5], None, 3, 2000))


def test_motions_side_by_side_part_where_one_is_said_to_recur():
    """From slip to slip of the screw, some two thousand events, their distance grows: no cycle attracts them."""
    automaton, _ = scene("support", 83, 12, 0)
    slips = []
    for shift in (0.0, 1e-9):
        motion = follow(automaton, GROWN + shift * np.eye(4)[0], math.inf, mode=GROWN_MODE, max_events=50_000)
        twice = (motion.kind[1:] == 2) & (motion.kind[:-1] == 2) & (motion.mode[:-1] == 7)
        slips.append(motion.after[1:][twice & (motion.mode[1:] == GROWN_MODE), 0])
    gaps = np.abs(slips[0][:20] - slips[1][:20])
    assert gaps.size == 20
    assert gaps.min() < 1e-9
    assert gaps[-3:].min() > 1e-6


def test_a_swing_that_its_own_damping_may_take_away_has_a_trend():
    """It dies away by 2e-4 in a quarter of a window, as its damping tells, and its amplitude scatters by as much.

    Two windows after two leaps showed no trend, and the motion was told to recur.
    """
    automaton, state = scene("support", 71, 14, 3)
    trend = trend_of(follow(automaton, state, math.inf, max_events=4000))
    quarters = trend.quarters[:1] + 1e-4 * np.array([[0], [1], [-1], [0]]) - np.arange(4)[:, None] * trend.own
    windows = [trend._replace(quarters=quarters - k * 4 * trend.own, own=trend.own) for k in range(3)]
    assert (trend.own > 0).all()
    assert not no_trend(windows)
    assert steady_state(automaton, state, max_events=700_000).label != Attractor.RECURRENT


@pytest.mark.slow
def test_growth_that_ends_in_rattling_is_followed_to_its_end():
    """It takes 300 000 events, as many as the leaps have work for; what follows began at the start once more."""
    automaton, state = scene("support", 83, 12, 1)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.RECURRENT
    assert steady_state(automaton, state, max_events=700_000, further=False).label == Attractor.UNRESOLVED


def test_a_long_wait_after_a_few_events_takes_the_work_of_a_few_events():
    """A swing dies away for 1e8 turns before the nut slips again: a search for 4000 events spent 90 units for each."""
    automaton, _ = scene("nut", 83, 9, 2)
    state, budget = [-2.807012e01, 2.574984e02, 3.726953e-02, 1.012173e02], Budget(1.5e5)
    motion = follow_patiently(automaton, state, math.inf, mode=1, max_events=4000, budget=budget)
    assert motion.time.size == 4000
    assert np.diff(motion.time).max() > 1e7


@pytest.mark.parametrize("start", [0, 2])
def test_a_cycle_beyond_long_waits_is_told(start):
    automaton, state = scene("nut", 83, 9, start)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.STICK_SLIP_CYCLE


def test_a_rest_without_any_rate_is_quiet_until_its_guard_falls():
    """Everything rests and the motor winds the coupling up: a search in blocks takes 5000 units to find the release.

    It has fewer after a few events, and the quiet time was then asked in turns of the fastest rate, which is zero.
    """
    automaton, _ = scene("support", 84, 15, 3)
    state, mode = np.array([-0.20690549, -4.53296625, 2.89408428, 0.0]), 14
    assert not np.linalg.eigvals(automaton.tables.flow.field[mode][:, :-1]).any()
    motion = follow(automaton, state, math.inf, mode=mode, max_events=1)
    quiet = quiet_until(automaton, mode, state, Budget(1e3))
    assert quiet < motion.time[0]
    assert quiet == pytest.approx(motion.time[0], rel=1e-12)
    patient = follow_patiently(automaton, state, math.inf, mode=mode, max_events=3, budget=Budget(3e3))
    assert patient.time[0] == pytest.approx(motion.time[0], rel=1e-12)


@pytest.mark.slow
def test_what_grows_alike_far_out_grows_for_ever():
    """The threads flutter without a load: by 1.186 in a return of four events that take a millisecond each to find.

    The range of numbers ends after 17 000 events, far beyond the work that is allowed.
    """
    automaton, state = scene("threads", 84, 25, 0)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.UNBOUNDED


def test_growth_is_told_only_beyond_the_constants_of_the_drive():
    automaton, _ = scene("threads", 84, 25, 0)
    far, mode = [-1.402e13, 8.912794053462027e02, 3.600e11, 1.956e14], 0
    assert growing(follow(automaton, far, math.inf, mode=mode, max_events=64), Budget(1e6)).label == Attractor.UNBOUNDED
    near = [2.0678e5, 8.912794053462027e02, 6.2e-1, 3.2e2]
    assert growing(follow(automaton, near, math.inf, mode=mode, max_events=64), Budget(1e6)) is None


@pytest.mark.parametrize(("model", "index", "start"), [("threads", 19, 0), ("nut", 24, 3)])
def test_without_damping_a_trend_that_turns_back_is_none(model, index, start):
    """Two oscillations beat without damping, and an amplitude seems to rise or fall by 4e-8 in a short window.

    Leaps along such trends led up and down without end. Followed event by event no amplitude changes by more than
    1e-8 in tens of turns of the slow one.
    """
    automaton, state = scene(model, 84, index, start)
    assert conserves(automaton)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.RECURRENT
    later = follow(automaton, state, math.inf, max_events=4000)
    trends = [trend_of(part) for part in parts_of(automaton, later.end_state, later.end_mode, 3, 8000)]
    levels = np.array([trend.quarters.mean(axis=0) for trend in trends])
    assert trends[0].turns > 10
    assert (np.ptp(levels, axis=0) < 1e-8).all()


def test_a_leap_beyond_the_numbers_that_a_start_may_have_is_growth():
    """The contact flutters, and a leap led to an angle of 1e119 rad, which was refused as a start: a traceback."""
    automaton, state = scene("threads", 85, 28, 0)
    assert steady_state(automaton, state).label == Attractor.UNBOUNDED
