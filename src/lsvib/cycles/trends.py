"""The trend of the amplitudes of a motion over many turns, and leaps along it.

A motion with more than two states is seen in the oscillators of the mode in which it is longest, of all modes that have
some. The logarithms of their amplitudes, at events, have means over the quarters of a window. Where friction takes
energy from a fast vibration, how much it takes depends on where the slow one is within its turn: so the quarters are
whole turns of the slowest oscillation, where the window has four, and the ends of a quarter count little in its mean.
The trend is extrapolated; the phases stay as they are.

What creeps to an equilibrium without turning, such as a damped nut under friction, may carry the amplitudes with it.
Its distance from the equilibrium of the mode has a trend of its own, as long as it creeps more slowly than a quarter,
and is extrapolated beside them, at most to where its trend would turn back.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lsvib.cycles.return_map import conserves
from lsvib.engine.kernels.columns import ALPHA, BETA
from lsvib.engine.kernels.tables import ModalFlow
from lsvib.engine.motion import Motion

QUARTERS = 4  # parts of a window that a trend is measured from; a leap must be longer than the window
_CHANGE = 0.2  # part of itself by which a trend may change in a leap
_PART = 0.7  # change of the logarithm of an amplitude that one leap may make
_OFF = 0.015  # error that a leap may make in the logarithm of an amplitude, even if the amplitude hardly changes
_STEADY = 0.3  # spread of a trend over the quarters of a window, relative to it
# A trend of an amplitude counts as none if it is below both of these: a relative change in a quarter of a window, and
# a multiple of its own spread.
_NO_TREND = 3e-3
_NOISE = 3.0
_HIDDEN = 0.1  # part of the error of a step above which the damping of an amplitude itself may be what is seen
_BACK = 0.05  # part of the change that a leap has made with which amplitudes have come back
_CREEPS = 0.5  # largest change of a logarithm in a quarter with which a coordinate creeps
_LEAST = -2.0  # least change of the logarithm of an amplitude in a leap, for one that falls faster than the others
_SCATTERED = 3  # windows in a row over which amplitudes that scatter show no trend
_FEWEST = 8  # events in a quarter of so much time; else the quarters have equal numbers of events
# Change of the logarithm of an amplitude in an event that is rounding, and change of its trend that is.
_ROUNDING, _STRAIGHT = 1e-15, 1e-14
# The same where nothing damps: only friction that turns its sense, or rest, can change an amplitude for good, and less
# than this in a quarter is rounding, or where in its turn the slow swing was at the events of a window.
_CONSERVED = 1e-10
_STILL = 1e-12  # added to a change that divides: a trend that is as small is leapt along as far as any may be


class Trend(NamedTuple):
    """Trend of the logarithms of the amplitudes over a quarter of a window, and its change to the next.

    ``step`` and ``bend`` (p + s) are those of all pairs of the mode, ``pairs`` in number, and then of its singles; zero
    where there is none. ``quarters`` (4, t) are the logarithms of the pairs that turn, ``turning`` (t); ``own`` (t), by
    how much they would fall in a quarter without events; ``turns``, how often the slowest of them does in the window;
    ``moves``, whether a coordinate drifts.
    """

    mode: int
    step: np.ndarray
    bend: np.ndarray
    consistent: bool
    none: bool
    moves: bool
    quarters: np.ndarray
    own: np.ndarray
    turning: np.ndarray
    turns: float
    pairs: int

    def continues(self, before: "Trend | None") -> bool:
        """Whether it is that before a leap, in windows of any length."""
        if before is None or before.mode != self.mode:
            return False
        one, other = (t.step / np.abs(t.step).max() for t in (before, self))
        return bool(np.abs(one - other).max() <= _STEADY)

    def turns_back(self, before: "Trend | None") -> bool:
        """Whether the amplitude with the largest trend before a leap has one of the other sign after it."""
        if before is None or before.mode != self.mode:
            return False
        largest = int(np.argmax(np.abs(before.step)))
        return bool(before.step[largest] * self.step[largest] < 0)

    def came_back(self, before: "Trend | None", leap: float) -> bool:
        """Whether amplitudes are what they were before a leap of so many quarters, which should have changed them.

        What is attracted by them, such as a torus, has no trend: its turns went into the windows alike.
        """
        if before is None or before.mode != self.mode:
            return False
        foreseen = leap * np.abs(before.step[before.turning])
        change = np.abs(self.quarters.mean(axis=0) - before.quarters.mean(axis=0))
        return bool((change[foreseen > 0] <= _BACK * foreseen[foreseen > 0]).all())


def trend_of(motion: Motion) -> Trend | None:
    """Return the trend of the amplitudes of the oscillators of a mode; None without oscillators or if one is zero."""
    flow = motion.automaton.tables.flow
    if not isinstance(flow, ModalFlow):
        return None
    modes, _, _, durations = motion.arcs()
    turns = [(flow.oscillators[mode, :pairs, BETA] > 0).any() for mode, pairs in enumerate(flow.pairs)]
    shares = np.where(turns, np.bincount(modes[:-1], weights=durations[:-1], minlength=len(flow.pairs)), -1.0)
    home = int(np.argmax(shares))
    rows = flow.oscillators[home, : flow.pairs[home]]
    turning = np.flatnonzero(rows[:, BETA] > 0)
    if turning.size == 0:
        return None
    states = np.column_stack([motion.after, np.ones(motion.time.size)])
    modal = states @ flow.to_modal[home].T
    place, rate = modal[:, 2 * turning], modal[:, 2 * turning + 1]
    across = (rate + rows[turning, ALPHA] * place) / rows[turning, BETA]
    squares = place * place + across * across
    if not (squares > 0).all():
        return None
    turn, span = 2 * math.pi / float(rows[turning, BETA].min()), motion.end_time - motion.start_time
    windows, least = _quarters(motion, turn), _CONSERVED if conserves(motion.automaton) else 0.0
    quarters, step, bends, spread = _over_quarters(0.5 * np.log(squares), windows)
    rounding = max(_ROUNDING * motion.time.size, least)
    steady = (np.abs(step) > rounding) & (spread <= _STEADY * np.abs(step))
    pairs, creeping = int(flow.pairs[home]), _creeping(flow, home, modal, span / QUARTERS)
    all_steps, all_bends = np.zeros((2, pairs + int(flow.singles[home])))
    all_steps[turning] = np.where(steady, step, 0.0)
    all_bends[turning] = np.where(steady & (np.abs(bends) > _STRAIGHT), bends, 0.0)
    _, creep, bent, wander = _over_quarters(np.log(np.abs(modal[:, 2 * pairs + creeping])), windows)
    creeps = (creep != 0) & (wander <= _STEADY * np.abs(creep))
    all_steps[pairs + creeping] = np.where(creeps, creep, 0.0)
    all_bends[pairs + creeping] = np.where(creeps, bent, 0.0)
    moves = _moves(motion.after, least)
    own = rows[turning, ALPHA] * span / QUARTERS
    level = (np.abs(step) <= np.maximum(np.minimum(_NO_TREND, _NOISE * spread), least)) & ~_may_die(step, own, spread)
    none = not moves and bool(level.all())
    # The amplitude of a part that is shaken now and then scatters; it has no trend, nor does it hide that of others.
    scatters = np.abs(step) <= np.maximum(spread, rounding)
    consistent = bool((creeps.any() or steady.any()) and (steady | scatters).all()) and not none
    return Trend(home, all_steps, all_bends, consistent, none, moves, quarters, own, turning, span / turn, pairs)


def _over_quarters(
    logarithms: np.ndarray, windows: Sequence[tuple[slice, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the means of logarithms (k, t) over quarters (4, t), their mean step, its bend, and the steps' spread."""
    quarters = np.array([np.average(logarithms[part], axis=0, weights=weights) for part, weights in windows])
    steps = np.diff(quarters, axis=0)
    return quarters, steps.mean(axis=0), (steps[-1] - steps[0]) / (QUARTERS - 2), np.ptp(steps, axis=0)


def _creeping(flow: ModalFlow, home: int, modal: np.ndarray, quarter: float) -> np.ndarray:
    """Return which singles of a mode may creep to their equilibrium, by their modal coordinates (k, q) at events.

    Their rate is slower than a quarter of a window [s], and their sign stays.
    """
    singles = modal[:, 2 * flow.pairs[home] :][:, : flow.singles[home]]
    rates, pushes = (table[home, : flow.singles[home]] for table in (flow.rates, flow.pushes))
    slow = (-_CREEPS < rates * quarter) & (rates < 0) & (pushes == 0)
    return np.flatnonzero(slow & ((singles > 0).all(axis=0) | (singles < 0).all(axis=0)))


def _may_die(step: np.ndarray, own: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Whether steps (t) of amplitudes may be nothing but their own damping, for all that their errors tell.

    Events may add so little to a swing that is hardly damped that its decay is hidden by what scatters. Where they
    move an amplitude by far more than it would fall, they decide what becomes of it.
    """
    return (own > _HIDDEN * error) & (np.abs(step + own) <= error)


def no_trend(windows: list[Trend]) -> bool:
    """Whether amplitudes that scatter have no trend over many windows that follow each other: a line through all."""
    if len(windows) < _SCATTERED:
        return False
    own = np.mean([window.own for window in windows], axis=0)
    return _level(np.concatenate([window.quarters for window in windows]), own)


def stays(parts: Sequence[Motion]) -> bool:
    """Whether over long parts of a motion that follow each other neither amplitudes nor coordinates have a trend.

    A line through all of them tells, since what scatters over the quarters of one part may seem to drift.
    """
    trends = [trend_of(part) for part in parts]
    first, windows = trends[0], [trend for trend in trends if trend is not None and not trend.consistent]
    if first is None or len(windows) < len(parts) or any(trend.mode != first.mode for trend in windows):
        return False
    means = np.array([quarter.mean(axis=0) for part in parts for quarter in np.array_split(part.after, QUARTERS)])
    swing = np.ptp(np.concatenate([part.after for part in parts]), axis=0)
    return no_trend(windows) and _level(means / np.where(swing == 0, 1.0, swing), np.zeros(swing.size))


def _level(rows: np.ndarray, own: np.ndarray) -> bool:
    """Whether lines through the columns of rows (k, t) rise by hardly anything and by less than their errors."""
    place = np.arange(len(rows)) - 0.5 * (len(rows) - 1)
    slope = place @ rows / (place @ place)
    rest = rows - rows.mean(axis=0) - place[:, None] * slope
    error = _NOISE * np.sqrt((rest**2).sum(axis=0) / ((len(rows) - 2) * (place @ place)))
    return bool((np.abs(slope) <= np.minimum(_NO_TREND, error)).all()) and not _may_die(slope, own, error).any()


def _quarters(motion: Motion, turn: float) -> list[tuple[slice, np.ndarray]]:
    """Return the events of each quarter of a motion, and their weights in a mean.

    The quarters are whole turns [s] of the slowest oscillation, if so many are there, and their ends count little:
    where the motion is within a turn decides how large the forces are, and so how fast the other amplitudes fall.
    """
    span = motion.end_time - motion.start_time
    whole = math.floor(span / (QUARTERS * turn)) * QUARTERS * turn
    ends = motion.end_time - (whole or span) * np.linspace(1.0, 0.0, QUARTERS + 1)
    at, place = np.searchsorted(motion.time, ends), motion.time
    if not (np.diff(at) > _FEWEST).all():
        place = np.arange(motion.time.size + 0.5)
        ends = np.linspace(-0.5, motion.time.size - 0.5, QUARTERS + 1)
        at = np.searchsorted(place, ends)
    found = []
    for one, other, start, end in zip(at[:-1], at[1:], ends[:-1], ends[1:], strict=True):
        found.append((slice(one, other), np.sin(np.pi * (place[one:other] - start) / (end - start)) ** 2))
    return found


def _moves(states: np.ndarray, least: float) -> bool:
    """Whether a coordinate of states (k, n) drifts, such as the angle while the motor winds the coupling up.

    A drift of less than ``least`` of its swing in a quarter is none.
    """
    changes = np.diff([part.mean(axis=0) for part in np.array_split(states, QUARTERS)], axis=0)
    error = np.maximum(_NOISE * np.ptp(changes, axis=0), least * np.ptp(states, axis=0))
    return bool((np.abs(changes.mean(axis=0)) > error).any())


def reach(trend: Trend, trust: float) -> float:
    """Return how far a leap along a trend may go, in quarters of its window.

    ``trust``: how often the trend's own change, which scatters, may exceed what it should be.
    """
    moving = trend.step != 0
    sizes, bends = np.abs(trend.step[moving]), np.abs(trend.bend[moving])
    steady = np.maximum(trust * _CHANGE * sizes / (bends + _STILL), np.sqrt(2 * _OFF / (bends + _STILL**2)))
    creeps, bent = trend.step[trend.pairs :], trend.bend[trend.pairs :]
    ends = np.abs(creeps[creeps * bent < 0] / bent[creeps * bent < 0])  # there the coordinate would turn back
    farthest = min(-_LEAST / max(np.abs(creeps).max(initial=0.0), _STILL), ends.min(initial=np.inf))
    return min(_PART / sizes.min(), _PART / max(trend.step.max(), _STILL), steady.min(), farthest)


def extrapolated(motion: Motion, trend: Trend, leap: float, trust: float) -> np.ndarray:
    """Return the state after a leap of so many quarters along a trend."""
    flow, home = motion.automaton.tables.flow, trend.mode
    modal = flow.to_modal[home, :, :-1] @ motion.end_state + flow.to_modal[home, :, -1]
    change = leap * trend.step
    if trust == 1.0:
        change = change + 0.5 * leap * (leap + 1) * trend.bend
    factors = np.exp(np.clip(change, _LEAST, _PART))
    modal[: 2 * trend.pairs] *= np.repeat(factors[: trend.pairs], 2)
    modal[2 * trend.pairs : factors.size + trend.pairs] *= factors[trend.pairs :]
    return flow.from_modal[home, :, :-1] @ modal + flow.from_modal[home, :, -1]
