"""The end of a motion with more than two states whose returns hardly move, by leaps.

A drive with little damping may need 10⁹ events before it settles. Two kinds of leaps shorten this.

* By returns: while returns to a section have the same events, the return map P is smooth. With its derivative P′ at y
  and the step Δ from there, the state L returns later is y + (1 + P′ + … + P′^(L−1)) Δ; this is exact if P is linear. L
  is doubled from leap to leap as long as the steps that are found after a leap are those that were foreseen.
* By amplitudes: a second oscillation with a frequency of its own may keep returns from being alike. Then the amplitudes
  of the oscillators have a trend over many turns, and are extrapolated (:mod:`lsvib.cycles.trends`).

Those that leave out more events for the same work are preferred.

Leaps by returns whose steps shrink, as foreseen, until nothing moves any more have come to a cycle, however little it
attracts in one return.

After each leap the motion is followed until errors of the extrapolation have died away, before the next step is
measured. This is numerical evidence, not a proof: a narrow attractor on the way may be leapt over.

A motion that has no trend over many events – neither an amplitude nor, such as while the motor winds the coupling up, a
coordinate –, and comes to no cycle, *recurs*: it is quasi-periodic or chaotic. Fewer events tell it where nothing
damps: slip preserves volumes, so that no amplitude dies away by itself. A motion about N = 0 without load that is
damped does not recur: all that it meets passes through zero, so that it grows or shrinks, however slowly.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from lsvib.cycles.cones import Dwindling, keeps_proportion
from lsvib.cycles.patience import follow_patiently
from lsvib.cycles.recurrences import CORNERS, cycle_through, long_cycle
from lsvib.cycles.return_map import FixedPoint, ReturnSection, conserves, largest
from lsvib.cycles.return_section import section_key
from lsvib.cycles.steady_states import Attractor, SteadyState
from lsvib.cycles.trends import QUARTERS, Trend, extrapolated, no_trend, reach, trend_of
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import Budget, Motion
from lsvib.errors import DivergenceError, WorkSpentError
from lsvib.numbers import LARGEST_START

_RETURNS = 8  # returns that are followed before a step is measured
_ALIKE = 3  # number of the last of these returns that must have the same events
_LONGEST = 4000  # most events in a return
_CHANGE = 0.2  # part of its way by which a leap may be wrong
_MORE_TRUST = 4.0  # factor by which leaps may get longer if the trend after a leap is that before it
_WAY = 2.0  # longest way of a leap, in sizes of the motion: once across a swing
_FADING = 0.9  # part of an earlier size that still counts: a coordinate that swings slowly is zero now and then
# A leap has 2^doublings returns, each one doubling more than the last: so many before the first, and at least. One leap
# costs about sixteen returns.
_FIRST_DOUBLINGS, _LEAST_DOUBLINGS = 6, 5
_FEWER = 2  # doublings that are taken off after a leap that was too long
_GONE = 0.1  # what is left, at most, of a part that has died away in a leap
_DIES = 1e-6  # least decay in a return of such a part: well beyond the rounding of P′, so that it is damped indeed
_CORRECTIONS = 2  # returns after a leap that put such parts to rest, each leaving a small share of what was left
_STILL = 1e-12  # a step of this size, in sizes of the motion, is not leapt: a cycle may touch a guard
_MOST_LEAPS = 30  # leaps in a row, after which the motion may have come near a cycle
_CLOSING = 3  # leaps in a row whose steps shrink before nothing moves, which show that a cycle attracts
_LEFT = 1e-3  # most that may be left of the way to it, in sizes of the cycle
_ATTRACTS = 1e-11  # least distance of a multiplier from one: beyond the rounding of P′, which leaves 1e-13 to 1e-12
_SELDOM = 3  # leaps by returns after which a cycle is looked for again
_BETWEEN = 500  # events that are followed after leaps by returns
_FIRST_WINDOW, LAST_WINDOW = 2000, 64_000  # events over which a trend of amplitudes is measured
_CONSERVED_WINDOW = 8000  # the longest one where nothing damps: then no amplitude dies away by itself
_CONSERVED_TURNS = 400  # turns of the slowest oscillation in a window that is long enough then, whatever its events
_MOVES = 12  # leaps by returns in a row after which a trend is looked for all the same: they may lead nowhere
# Attempts to measure a trend, by their number, at which the longest window is followed instead if the motion rests.
_LONG_LOOKS = (6, 18, 54)
_BLANKS = 2  # windows without a trend in a row, after which a motion recurs
# Events of the window for each unit of work of a leap by amplitudes: it takes more than one window.
_PER_EVENT = 0.4
_WHOLE = 4.2  # turns of the slowest oscillation in a window, so that its quarters are whole turns


class Recurrence(NamedTuple):
    """A motion without trend: its last state (n)."""

    state: np.ndarray


Ended = TypeVar("Ended")


class Course:
    """How far a motion has been followed: its last part, ``motion``, and whether leaps have led there, ``leapt``."""

    def __init__(self, motion: Motion) -> None:
        self.motion, self.leapt = motion, False


def pursue(
    course: Course, budget: Budget, ended: Callable[[Motion], Ended | None]
) -> Ended | SteadyState | Recurrence | None:
    """Follow and extrapolate a motion until ``ended`` names its end; returns that end.

    Arguments: a course of the motion, which goes on from its end; the work that it may take; ``ended``, which is asked
    about parts of the motion. The end is None if the budget does not suffice. Raises ``EngineError`` where the engine
    does. It is one loop: which leap comes next depends on how far those of both kinds have led.
    """
    motion, automaton, window, blank = course.motion, course.motion.automaton, _FIRST_WINDOW, 0
    before, trust, moves, looks, gain, rows, seen = None, 1.0, 0, 0, 1.0, 0, list[Trend]()
    conserved, quarters, dwindling = conserves(automaton), 0.0, Dwindling(automaton)
    longest = _CONSERVED_WINDOW if conserved else LAST_WINDOW
    while budget.left > 0:
        course.motion = motion
        if dwindling.done(motion):
            return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(motion.end_state))
        # While leaps move the motion a cycle is seldom near, and looking for one costs more than a leap.
        found = ended(motion) if moves % _SELDOM == 0 or motion.status == Status.SETTLED else None
        if found is not None:
            return found
        # Where leaps by amplitudes go farther for their work, those by returns are seldom tried.
        skipped = rows % _SELDOM > 0
        leap = _Leap(motion.end_state, motion.end_mode, False, 0.0) if skipped else _by_returns(motion, budget)
        pays = leap.gain > gain
        moves = moves + 1 if pays else 0
        course.leapt |= leap.moved
        if leap.moved:
            motion = follow_patiently(
                automaton, leap.state, math.inf, mode=leap.mode, max_events=_BETWEEN, budget=budget
            )
            if leap.cycle is not None:
                return ended(motion) or leap.cycle
            if pays and moves % _MOVES:
                continue
        # Leaps that go on and on over rests, while the contact rattles, may go around a longer cycle.
        looks += 1
        around = looks in _LONG_LOOKS and _rests(motion)
        look = longest if around else window
        motion = follow_patiently(
            automaton, motion.end_state, math.inf, mode=motion.end_mode, max_events=look, budget=budget
        )
        trend = trend_of(motion) if motion.time.size == look else None
        if look == longest:
            found = long_cycle(motion, budget)
            if found is not None:
                return found
        wanted = 2 * window
        if trend is not None and _WHOLE * window <= trend.turns * longest:
            wanted = max(wanted, math.ceil(_WHOLE * window / trend.turns))
        longer = min(wanted, longest) if conserved or not pays else window
        if trend is None or not trend.consistent:
            rows = 0
        if trend is None:
            window = longer
        elif trend.consistent and not (window == longest and trend.came_back(before, quarters)):
            if conserved and window < longest and trend.turns_back(before):
                window, before = longer, None  # too short for where in its turn a swing is: this is no trend
                continue
            trust = trust * _MORE_TRUST if trend.continues(before) else 1.0
            quarters, before, blank, seen = reach(trend, trust), trend, 0, []
            rows = rows + 1 if quarters > QUARTERS else 0
            if rows == 0:
                window = longer
                continue
            found = ended(motion)  # a leap would throw it off a cycle that it comes to slowly
            if found is not None:
                return found
            course.leapt, gain = True, max(1.0, _PER_EVENT * quarters / QUARTERS)
            state = extrapolated(motion, trend, quarters, trust)
            if not np.abs(state).max() < LARGEST_START:
                raise DivergenceError("the motion grows without bound: leaps lead beyond the range of numbers.")
            after = max(_BETWEEN, window // QUARTERS)
            motion = follow_patiently(automaton, state, math.inf, mode=None, max_events=after, budget=budget)
        elif not trend.moves and (_swings(trend, window) if conserved else _long(motion, window)):
            seen = [*seen, trend] if seen and seen[-1].mode == trend.mode else [trend]
            blank = blank + 1 if trend.none or trend.consistent else 0
            if blank == _BLANKS or no_trend(seen):
                return Recurrence(motion.end_state)
        else:
            window, blank = longer, 0
    return None


def _long(motion: Motion, window: int) -> bool:
    """Whether a window is so long that a damped motion without a trend in it recurs."""
    return window == LAST_WINDOW and not keeps_proportion(motion)


def _swings(trend: Trend, window: int) -> bool:
    """Whether a window is so long that a motion that nothing damps recurs without a trend in it."""
    return window == _CONSERVED_WINDOW or (trend.none and trend.turns > _CONSERVED_TURNS)


def _rests(motion: Motion) -> bool:
    """Whether a motion comes to rest."""
    return bool(np.isin(motion.automaton.codes[motion.mode], motion.automaton.rest_codes).any())


class _Leap(NamedTuple):
    """The result of leaps by returns: state (n), mode, whether the motion has moved, and the cycle that it is on.

    ``gain``: number of events that they have left out, for each unit of work.
    """

    state: np.ndarray
    mode: int
    moved: bool
    gain: float
    cycle: SteadyState | None = None


def _by_returns(motion: Motion, budget: Budget) -> _Leap:
    """Leap along the section of a motion's rarest events as far as that goes."""
    key = section_key(motion)
    here, mode, moved, last, doublings = motion.end_state, motion.end_mode, False, None, _FIRST_DOUBLINGS
    left, left_out = budget.left, 0
    if key is None:
        return _Leap(here, mode, moved, 0.0)
    seen = (motion.kind == key[0]) & (motion.mode == key[1])
    place, longest = motion.after[seen][-1], np.diff(motion.time[seen]).max(initial=0.0)
    size, pattern, steps = np.zeros_like(place), None, list[float]()
    for _ in range(_MOST_LEAPS):
        states, patterns, sizes = _returns(motion.automaton, key, place, budget)
        alike = len(states) > _RETURNS and all(one == (pattern or patterns[-1]) for one in patterns[-_ALIKE:])
        if not (alike and (last is None or last.foresaw(states, doublings))):
            doublings -= _FEWER
            if last is None or doublings < _LEAST_DOUBLINGS:
                break
            place = last.corrected(last.after(doublings), doublings)
            continue
        left_out += 0 if last is None else len(patterns[-1]) // motion.mode.itemsize << doublings
        here, mode, moved, pattern = states[-1], key[1], last is not None, patterns[-1]
        size = np.maximum(np.max(sizes[-_ALIKE:], axis=0), _FADING * size)
        scale = np.where(size == 0, 1.0, size)  # a coordinate that is zero at every event may have any scale
        section = ReturnSection(motion.automaton, key, here, scale, 1, longest, budget)
        last = _Linear.at(section, states)
        steps.append(last.length(last.step))
        doublings = last.most(doublings + 1)
        if doublings < _LEAST_DOUBLINGS:
            return _Leap(here, mode, moved, left_out / (left - budget.left), _closed(last, steps))
        place = last.corrected(last.after(doublings), doublings)
    return _Leap(here, mode, moved, left_out / (left - budget.left))


class _Linear(NamedTuple):
    """The return map near a place: its derivative (d, d) on a section, and the last step (d) there.

    Where the map has no derivative, because a motion beside does not come back, it is taken to shift all places alike.
    """

    section: ReturnSection
    slopes: np.ndarray
    step: np.ndarray

    @classmethod
    def at(cls, section: ReturnSection, states: list[np.ndarray]) -> "_Linear":
        """Linearise at the last state, the origin of ``section``."""
        slopes, _ = section.slopes(np.zeros(section.dimension))
        if not np.isfinite(slopes).all():
            slopes = np.eye(section.dimension)
        return cls(section, slopes, slopes @ -section.place(states[-2]))

    def _ahead(self, doublings: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the way (d) of 2^doublings returns, and the step (d) after them."""
        total, power = np.eye(len(self.slopes)), self.slopes
        with np.errstate(over="ignore", invalid="ignore"):  # the caller refuses a way that is too long or not a number
            for _ in range(doublings):
                total, power = total + power @ total, power @ power
            return total @ self.step, power @ self.step

    def length(self, place: np.ndarray) -> float:
        """Return the size of a step (d) on the section, in sizes of the motion; infinite where it left the numbers."""
        if not np.isfinite(place).all():
            return math.inf
        return float((np.abs(self.section.directions) @ np.abs(place) / self.section.size).max(initial=0.0))

    def most(self, doublings: int) -> int:
        """Return how often, at most ``doublings`` times, the returns may be doubled before the way is too long."""
        if not self.length(self.step) > _STILL:
            return 0
        while doublings > 0 and not self.length(self._ahead(doublings)[0]) <= _WAY:
            doublings -= 1
        return doublings

    def after(self, doublings: int) -> np.ndarray:
        """Return the state (n) 2^doublings returns later."""
        return self.section.state(self._ahead(doublings)[0])

    def corrected(self, state: np.ndarray, doublings: int) -> np.ndarray:
        """Return a state after a leap with the parts that have died away in it at rest where it has led to.

        The fixed point of such a part moves with the others, by more than the derivative before the leap tells; what is
        left of it would hide the steps of the others. Each return tells where it lies.
        """
        with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
            values, vectors = np.linalg.eig(self.slopes)
            rates = np.log(np.abs(values))
            gone = (rates < -_DIES) & (rates * 2.0**doublings < math.log(_GONE))
        if gone.any() and not (gone.all() or conserves(self.section.automaton)) and np.isfinite(state).all():
            for _ in range(_CORRECTIONS):
                back = self.section.come_back(state)
                if back is None:
                    break
                step = self.section.place(back.end_state) - self.section.place(state)
                try:
                    parts = np.linalg.solve(vectors, step)[gone] / (1 - values[gone])
                except np.linalg.LinAlgError:
                    break
                state = self.section.state(self.section.place(state) + (vectors[:, gone] @ parts).real)
        return state

    def foresaw(self, states: list[np.ndarray], doublings: int) -> bool:
        """Whether the steps after a leap show that its error is a small part of its way.

        A step that is off by ε along an eigenvector of P′ with the multiplier λ belongs to a place that is off by
        ε / (1 − λ), but not by more than ε times the number of returns.
        """
        way, step = self._ahead(doublings)
        with np.errstate(over="ignore", invalid="ignore"):  # slopes across a touched surface may be huge
            expected = np.linalg.matrix_power(self.slopes, _RETURNS - 1) @ step
        if not np.isfinite(expected).all():
            return False
        gap = self.section.place(states[-1]) - self.section.place(states[-2]) - expected
        values, vectors = np.linalg.eig(self.slopes)
        try:
            parts = np.linalg.solve(vectors, gap)
        except np.linalg.LinAlgError:
            return False
        parts = parts / np.maximum(np.abs(1 - values), 0.5**doublings)
        return self.length(np.abs(vectors * parts).sum(axis=1)) <= _CHANGE * self.length(way)


def _closed(last: _Linear, steps: list[float]) -> SteadyState | None:
    """Return the cycle at which leaps have ended, if their ``steps`` have shrunk and hardly any way is left to it.

    A step may have shrunk to rounding far from a cycle that attracts faintly; the way is what the steps add up to.
    """
    shrinks = len(steps) > _CLOSING and all(one > other for one, other in pairwise(steps[-1 - _CLOSING :]))
    multiplier, section = largest(last.slopes), last.section
    small = np.abs(section.origin / section.size).max() < CORNERS[1]  # steady sliding itself
    if small or not (shrinks and steps[-1] <= _STILL and abs(multiplier) < 1 - _ATTRACTS):
        return None
    found = cycle_through(section, FixedPoint(section.origin, multiplier, math.nan))
    if found is None or found.orbit is None:
        return None
    way = np.abs(section.directions @ np.linalg.lstsq(np.eye(len(last.step)) - last.slopes, last.step, rcond=None)[0])
    return found if (way <= _LEFT * np.abs(found.orbit.after).max(axis=0)).all() else None


def _returns(automaton: Automaton, key: tuple[int, int], state: np.ndarray, budget: Budget):
    """Follow some returns; return the states (n) at them, and modes and sizes (n) of each return."""
    states, patterns, sizes = [state], [], []
    for _ in range(_RETURNS):
        part = Budget(budget.left / _RETURNS)  # a return that takes more leaves no work for the others
        given = part.left
        try:
            motion = follow_patiently(
                automaton, states[-1], math.inf, mode=key[1], stop=key, max_events=_LONGEST, budget=part
            )
        except WorkSpentError:
            break
        finally:
            budget.spend(given - max(part.left, 0.0))
        if motion.status != Status.STOP_EVENT:
            break
        states.append(motion.end_state)
        patterns.append(motion.mode.tobytes())
        sizes.append(np.abs(motion.after).max(axis=0))
    return states, patterns, sizes
