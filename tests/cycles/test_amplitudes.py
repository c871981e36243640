"""The amplitudes of a mode, in blocks or in modal form."""

import math

import numpy as np
import pytest
from reference.wide_scenes import scene

from lsvib.cycles.amplitudes import amplitudes_of
from lsvib.cycles.trends import extrapolated, reach, trend_of
from lsvib.engine.motion import follow

ROUNDING = 1e-9  # of the size of an oscillation: of sixteen digits the modes lose five


@pytest.mark.parametrize("in_blocks", [False, True])
@pytest.mark.parametrize("index", [6, 34])
def test_oscillators_turn_as_the_field_says(index, in_blocks):
    """The rate of a place is its derivative along the field, and that of a rate is −(α² + β²) y − 2 α y′."""
    automaton, state = scene("threads", 81, index, 0, in_blocks)
    field, found = automaton.tables.flow.field[0], amplitudes_of(automaton.tables.flow, 0)
    assert (found.beta > 0).sum() == 2
    modal, slope = found.into @ np.append(state, 1.0), found.into @ np.append(field @ np.append(state, 1.0), 0.0)
    for j in np.flatnonzero(found.beta > 0):
        alpha, beta = found.alpha[j], found.beta[j]
        (place, rate), (place_slope, rate_slope) = modal[2 * j : 2 * j + 2], slope[2 * j : 2 * j + 2]
        size = math.hypot(place, rate / beta)
        assert abs(place_slope - rate) < ROUNDING * size * beta
        assert abs(rate_slope + (alpha**2 + beta**2) * place + 2 * alpha * rate) < ROUNDING * size * beta**2


@pytest.mark.parametrize("in_blocks", [False, True])
def test_another_amplitude_leaves_the_others_and_the_phases(in_blocks):
    automaton, state = scene("threads", 83, 64, 0, in_blocks)
    found = amplitudes_of(automaton.tables.flow, 0)
    factors = np.ones(found.beta.size + found.rates.size)
    factors[0] = 0.5
    before, after = (found.into @ np.append(x, 1.0) for x in (state, found.scaled(state, factors)))
    assert after[:2] == pytest.approx(0.5 * before[:2], rel=1e-9)
    assert after[2:] == pytest.approx(before[2:], rel=1e-9)


def test_a_leap_finds_the_same_trend_in_blocks():
    """The screw vibrates a thousand times in a swing of the nut; friction slows it, and a leap goes on as foreseen."""
    found = []
    for in_blocks in (False, True):
        automaton, state = scene("threads", 83, 64, 0, in_blocks)
        first = follow(automaton, state, math.inf, max_events=3000)
        motion = follow(automaton, first.end_state, math.inf, mode=first.end_mode, max_events=11_500)
        trend = trend_of(motion)
        falls = trend.step.min()
        leap = reach(trend, 1.0)
        after = follow(automaton, extrapolated(motion, trend, leap, 1.0), math.inf, max_events=3000)
        later = trend_of(follow(automaton, after.end_state, math.inf, mode=after.end_mode, max_events=11_500))
        found.append((falls, leap, later.step.min()))
    assert found[1] == pytest.approx(found[0], rel=1e-3)
    falls, leap, later = found[0]
    assert falls < 0
    assert later == pytest.approx(falls / (1 + falls * leap), rel=0.1)  # dry friction takes as much in each swing
