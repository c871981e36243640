"""Where a motion with more than two states goes whose returns hardly move: leaps, by returns or by amplitudes.

A drive with little damping may need 10⁹ events before it settles. Two kinds of leaps shorten that.

* By returns: where the states at successive returns to a section have the same events between them and differ by nearly
  the same step Δ each, with a change of step Δ′ from one to the next, the state L returns later is taken to be
  y + L Δ + L (L + 1) Δ′ / 2, with L so small that neither y nor Δ changes by more than a part of itself.
* By amplitudes: where a second oscillation, of a frequency of its own, keeps returns from being alike, the amplitudes
  of the oscillators of the mode in which the motion is for most of the time have a trend over many turns. The
  amplitudes are then extrapolated in the same way and the phases are left.

After each leap the motion is followed until what was only extrapolated has died away, before the next step is measured.
This is numerical certainty, not a proof: what a narrow attractor would hold in between is leapt over.

A motion without any trend over many events, that comes to no cycle, *recurs*: it is quasi-periodic or chaotic.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from lsvib.analysis.return_map import section_key
from lsvib.core.modal import ModalFlow
from lsvib.core.planar import ALPHA, BETA
from lsvib.core.status import Status
from lsvib.models.automaton import Automaton
from lsvib.models.motion import Motion, follow

_CALL = 10  # events that take as long as one call of the engine from Python
_RETURNS = 8  # followed before a step is measured
_ALIKE = 3  # of them, the last ones, with the same events
_LONGEST = 4000  # events in a return
_CHANGE = 0.2  # part by which a step may change in a leap: a second-order extrapolation is then right to 1 %
_PART = 0.3  # part of its size by which a coordinate or an amplitude may change in a leap
_WORTH = 16  # returns that a leap must save: twice those that it costs
_STILL = 1e-14  # step, in sizes of the motion, that is rounding
_SHORTER = 0.25  # factor after a leap beyond which the events of a return are others
_MOST_LEAPS = 30  # in a row, before it is asked whether the motion has come near a cycle
_BETWEEN = 500  # events after leaps by returns
_FIRST_WINDOW, _LAST_WINDOW = 2000, 64_000  # events over which a trend of amplitudes is measured
_STEADY = 0.3  # spread of a trend over the quarters of a window, relative to it
_NO_TREND = 3e-3  # of an amplitude, in a window, that is none, at most;
_TREND_NOISE = 3.0  # and in units of its own spread
_LEAST = -2.0  # logarithm of what is left, at least, of an amplitude that falls faster than another
_BLANKS = 2  # windows without a trend in a row, after which a motion recurs
_QUARTERS = 4  # of a window, which a leap must be longer than


class Recurrence(NamedTuple):
    """A motion without trend: its last state (n)."""

    state: np.ndarray


Ended = TypeVar("Ended")


def pursue(motion: Motion, work: int, ended: Callable[[Motion], Ended | None]) -> Ended | Recurrence | None:
    """Follow and extrapolate a motion until ``ended`` says where it is; None if ``work`` does not suffice.

    Arguments: a part of the motion, at whose end it goes on; work [events], a call of the engine counting as some;
    ``ended`` is asked about parts of the motion. Raises ``EngineError`` where the engine does.
    """
    automaton, window, blank = motion.automaton, _FIRST_WINDOW, 0
    while work > 0:
        found = ended(motion)
        if found is not None:
            return found
        leap = _by_returns(motion)
        work -= leap.work
        if leap.moved:
            motion = follow(automaton, leap.state, math.inf, mode=leap.mode, max_events=_BETWEEN)
            work -= _BETWEEN
            continue
        motion = follow(automaton, motion.end_state, math.inf, mode=motion.end_mode, max_events=window)
        work -= window + _CALL
        trend = _trend(motion) if motion.time.size == window else None
        if trend is None:
            window = min(2 * window, _LAST_WINDOW)
        elif trend.consistent:
            state, mode = _extrapolated(automaton, motion, trend)
            motion, blank = follow(automaton, state, math.inf, mode=mode, max_events=window), 0
            work -= window + _CALL
        elif trend.none and window == _LAST_WINDOW:
            blank += 1
            if blank == _BLANKS:
                return Recurrence(motion.end_state)
        else:
            window, blank = min(2 * window, _LAST_WINDOW), 0
    return None


class _Leap(NamedTuple):
    """Where leaps by returns have led: state (n) and mode, whether they have led anywhere, and the work."""

    state: np.ndarray
    mode: int
    moved: bool
    work: int


def _by_returns(motion: Motion) -> _Leap:
    """Leap along the section of a motion's rarest events as far as that goes."""
    key = section_key(motion)
    here, mode, work, last = motion.end_state, motion.end_mode, 0, None
    if key is None:
        return _Leap(here, mode, False, work)
    place, leap = motion.after[(motion.kind == key[0]) & (motion.mode == key[1])][-1], 0.0
    for _ in range(_MOST_LEAPS):
        states, patterns, sizes, events = _returns(motion.automaton, key, place)
        work += events
        if len(states) <= _RETURNS or any(one != patterns[-1] for one in patterns[-_ALIKE:]):
            if last is None or leap * _SHORTER < _WORTH:
                break
            leap *= _SHORTER
            place = last.after(leap)
            continue
        here, mode, size = states[-1], key[1], np.max(sizes[-_ALIKE:], axis=0)
        step = states[-1] - states[-2]
        last, earlier = _Step(here, step, step - (states[-2] - states[-3])), last
        length, change = np.abs(step / size).max(), np.abs(last.bend / size).max()
        leap = min(_CHANGE * length / max(change, _STILL), _PART / max(length, _STILL))
        if length < _STILL or leap < _WORTH:
            return _Leap(here, mode, earlier is not None, work)
        place = last.after(leap)
    return _Leap(here, mode, last is not None, work)


class _Step(NamedTuple):
    """State (n) at a return, the step to it and the change of that step."""

    state: np.ndarray
    step: np.ndarray
    bend: np.ndarray

    def after(self, returns: float) -> np.ndarray:
        """Return the state so many returns later, extrapolated."""
        return self.state + returns * self.step + 0.5 * returns * (returns + 1) * self.bend


def _returns(automaton: Automaton, key: tuple[int, int], state: np.ndarray):
    """Follow some returns: the states (n) at them, the modes of each and the sizes (n) on it, and the work."""
    states, patterns, sizes, work = [state], [], [], 0
    for _ in range(_RETURNS):
        motion = follow(automaton, states[-1], math.inf, mode=key[1], stop=key, max_events=_LONGEST)
        work += motion.time.size + _CALL
        if motion.status != Status.STOP_EVENT:
            break
        states.append(motion.end_state)
        patterns.append(motion.mode.tobytes())
        sizes.append(np.maximum(np.abs(motion.after).max(axis=0), np.finfo(float).tiny))
    return states, patterns, sizes, work


class _Trend(NamedTuple):
    """Trend of the logarithms of the amplitudes (p) over a quarter of a window, and its change to the next."""

    mode: int
    step: np.ndarray
    bend: np.ndarray
    consistent: bool
    none: bool


def _trend(motion: Motion) -> _Trend | None:
    """Trend of the amplitudes of the oscillators of a mode; None if the mode has none or one of them is zero."""
    flow = motion.automaton.tables.flow
    if not isinstance(flow, ModalFlow):
        return None
    modes, _, _, durations = motion.arcs()
    home = int(np.argmax(np.bincount(modes[:-1], weights=durations[:-1], minlength=len(flow.pairs))))
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
    quarters = np.array([np.log(part).mean(axis=0) / 2 for part in np.array_split(squares, _QUARTERS)])
    steps = np.diff(quarters, axis=0)
    step, spread = steps.mean(axis=0), np.ptp(steps, axis=0)
    leading = int(np.argmax(np.abs(step)))
    full = np.zeros(flow.pairs[home])
    bend = full.copy()
    steady = spread <= _STEADY * np.abs(step)
    full[turning] = np.where(steady, step, 0.0)
    bend[turning] = np.where(steady, (steps[-1] - steps[0]) / (_QUARTERS - 2), 0.0)
    none = bool((np.abs(step) <= np.minimum(_NO_TREND, _TREND_NOISE * spread)).all())
    return _Trend(home, full, bend, bool(steady[leading]) and not none, none)


def _extrapolated(automaton: Automaton, motion: Motion, trend: _Trend) -> tuple[np.ndarray, int | None]:
    """State after a leap along a trend, whose mode the state says; the motion's last state if the leap is not worth."""
    moving = trend.step != 0
    sizes, bends = np.abs(trend.step[moving]), np.abs(trend.bend[moving])
    leap = min(_PART / sizes.min(), _PART / max(trend.step.max(), _STILL), _CHANGE * (sizes / (bends + _STILL)).min())
    if leap <= _QUARTERS:
        return motion.end_state, motion.end_mode
    flow, home = automaton.tables.flow, trend.mode
    modal = flow.to_modal[home, :, :-1] @ motion.end_state + flow.to_modal[home, :, -1]
    factors = np.exp(np.clip(leap * trend.step + 0.5 * leap * (leap + 1) * trend.bend, _LEAST, _PART))
    modal[: 2 * factors.size] *= np.repeat(factors, 2)
    return flow.from_modal[home, :, :-1] @ modal + flow.from_modal[home, :, -1], None
