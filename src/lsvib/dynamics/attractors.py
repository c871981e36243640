"""The attractor that a motion of any model reaches.

A motion *settles* if the engine proves that no guard can fire again, so that it stays in one linear mode for ever.
Otherwise its events recur, and their return map decides (:mod:`lsvib.dynamics.poincare_map`): the motion has reached its
cycle when the map returns the same state to rounding; if the motion converges slowly, the map is solved for the fixed
point that it approaches. No waiting time enters.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from lsvib.dynamics import drift_two_states
from lsvib.dynamics.attractor import (
    Attractor,
    Doubt,
    Passage,
    SteadyState,
    arc_integrals,
    orbit_extremes,
    out_of_range,
)
from lsvib.dynamics.more_states import CHUNK, LONG, at_equilibrium, of_more_states
from lsvib.dynamics.poincare_map import Section
from lsvib.dynamics.recurrences import FEWEST, cycle_through, recurrence, watched
from lsvib.dynamics.settling import settled
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import DivergenceError, EngineError

__all__ = ["Attractor", "Doubt", "Passage", "SteadyState", "arc_integrals", "orbit_extremes", "steady_state"]

_LONGER = 8  # factor from one attempt to leap over returns to the next
_MORE_PATIENCE = 1000.0  # time that a return after a leap may take, in times of the longest return seen


def steady_state(
    automaton: Automaton,
    state: ArrayLike,
    *,
    mode: int | None = None,
    max_events: int = 300_000,
    patience: int = LONG,
) -> SteadyState:
    """Find the attractor of the motion of any model from ``state`` (n), in ``mode`` if given.

    ``max_events`` bounds the work: it is a number of events with two states, and with more the budget in units of one
    ordinary event (:class:`lsvib.engine.motion.Budget`). ``patience`` is the number of events after which returns that
    hardly move are leapt over, with two states.

    The search ends in one of the following ways.

    * The model vouches that areas never grow (``Automaton.contracts``). Then a closed orbit cannot lie where areas
      shrink, and a motion cannot spiral outwards; so all motions end in steady sliding, or without damping in the
      neutral oscillations that never pass θ′ = 0.
    * The motion settles (:func:`lsvib.dynamics.settling.settled`): steady sliding, rest, neutral oscillations, or
      unbounded.
    * The section state repeats after 1 to 64 returns, or the map of 1 to 8 returns has an attracting fixed point. The
      cycle is called sprag–slip if it sprags, stick–slip if it rests, and other cycle if it does neither; a fixed point
      at the origin is steady sliding. With more than two states a cycle that nothing damps is one of a neutral family.
    * A motion of compliant threads, or of a part of a drive, such as slip without rest, leaves the range of numbers:
      unbounded.
    * ``max_events`` are spent, or the engine cannot decide the next event: unresolved. This happens to motions that
      move by less than their last digits from turn to turn, and to motions whose cycle attracts slowly and has more
      than 8 returns, or a return map without a derivative.
    * Before that, with two states: the motion has drifted towards a place on a line from both sides of which returns
      come nearer, beyond doubt, although P(y) = y is lost in rounding there. Then there is a cycle, and its numbers are
      known to ``enclosure`` only.
    """
    start = np.array(state, dtype=float)
    if mode is None and at_equilibrium(automaton, start):
        return SteadyState(Attractor.STEADY_SLIDING, start)
    if start.size > 2:
        return of_more_states(automaton, start, mode, Budget(max_events))
    return _steady_state(automaton, start, mode, max_events, patience, True)


def _steady_state(
    automaton: Automaton, state: np.ndarray, mode: int | None, max_events: int, patience: int, twice: bool
) -> SteadyState:
    """Search as :func:`steady_state`; with ``twice``, two motions must end alike where a drift leaves its line."""
    if automaton.contracts and (automaton.tables.flow[:, layout.ALPHA] > 0).any():
        return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(state))
    used, chunk, faint = 0, min(CHUNK, patience), None
    while used < max_events:
        try:
            motion = follow(automaton, state, math.inf, mode=mode, max_events=chunk)
        except DivergenceError:
            return out_of_range(automaton, state)
        except EngineError as error:
            return SteadyState.unresolved(state, error)
        if motion.status == Status.SETTLED:
            return settled(automaton, motion)
        if automaton.contracts or _only_touches(motion):
            return _neutral(automaton, motion)
        used += motion.time.size
        if used >= patience:
            patience *= _LONGER
            slow, enclosed = _slow_end(automaton, motion, max_events - used, twice)
            if slow is not None:
                return slow
            faint = enclosed or faint
        cycle = recurrence(automaton, motion)
        if cycle is not None:
            return cycle
        chunk = min(2 * chunk, max(max_events - used, 1))
        state, mode = motion.end_state, motion.end_mode
    return faint or SteadyState.unresolved(state, Doubt.EVENT_BUDGET)


def _slow_end(
    automaton: Automaton, motion: Motion, left: int, twice: bool
) -> tuple[SteadyState | None, SteadyState | None]:
    """Find by leaps the end of a motion whose returns to a line hardly move along it; None if that is not known.

    ``left`` events may follow. Where the drift leaves the line, the motion is somewhere between two returns; with
    ``twice`` the motion from the last return and the one from half a return further must end alike. The second result
    is a cycle that attracts so faintly that its place is known to lie in an interval only.
    """
    seen = watched(motion)
    if seen is None or len(seen.points) < FEWEST:
        return None, None
    key, points, size, patience = seen.key, seen.points, seen.size, _MORE_PATIENCE * seen.longest
    section = Section(automaton, key, points[-1], size, 1, patience)
    if section.dimension != 1:
        return None, None
    first = section
    section, end = drift_two_states.far_drift(first)
    if end is None:
        return None, None
    came_from = first.state(np.array([drift_two_states.reach_back(first)]))
    place, beyond = (section.state(np.array([y])) for y in (end.place, end.beyond))
    passage, faint = Passage(key[1], np.array([came_from, place])), None
    if end.end == drift_two_states.End.CLOSES:
        there = section.at(beyond, section.size)
        fixed = there.fixed_point(place[None])
        found = None if fixed is None else cycle_through(there, fixed)
        faint = _faint(section, beyond) if found is None else None
    elif end.end == drift_two_states.End.SHRINKS:
        found = _steady_state(automaton, place, key[1], left, LONG, twice)
        found = (_faint(section, place) if found.label == Attractor.UNRESOLVED else None) or found
    else:
        between = section.state(np.array([end.place + 0.5 * section.return_from(end.place).excess]))
        found = _steady_state(automaton, place, key[1], left, LONG, False)
        if twice and found.label != _steady_state(automaton, between, key[1], left, LONG, False).label:
            return SteadyState.unresolved(place, Doubt.ROUNDING), None
    found, faint = (one and replace(one, passages=(passage, *one.passages)) for one in (found, faint))
    return found, faint


def _faint(section: Section, near: np.ndarray) -> SteadyState | None:
    """Return the cycle near a state of a line that a motion drifts to from both sides, however slowly."""
    there = section.at(near, np.maximum(section.size, np.abs(near)))
    ends = drift_two_states.enclosure(there)
    fixed = None if ends is None else there.between(*ends)
    return None if fixed is None else cycle_through(there, fixed)


def _only_touches(motion: Motion) -> bool:
    """Whether the later half of a planar motion's events are touches of guards in one undamped mode."""
    half = motion.time.size // 2
    flow = motion.automaton.tables.flow
    touches = isinstance(flow, np.ndarray) and bool((motion.kind[half:] == GRAZE_KIND).all())
    return touches and flow[motion.end_mode, layout.ALPHA] == 0 and flow[motion.end_mode, layout.BETA] > 0


def _neutral(automaton: Automaton, motion: Motion) -> SteadyState:
    """Return the neutral oscillation of a motion without damping after many events, with one period as its orbit.

    If the motion only touches a guard, rounding decides whether there is an event; the period is one turn of the mode.
    """
    state, mode = motion.end_state, motion.end_mode
    if _only_touches(motion):
        orbit = follow(automaton, state, 2 * math.pi / automaton.tables.flow[mode, layout.BETA], mode=mode)
    else:
        own = np.flatnonzero(~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND)))[-1]
        state, mode, kind = motion.after[own], int(motion.mode[own]), int(motion.kind[own])
        orbit = follow(automaton, state, math.inf, mode=mode, stop=(kind, mode), max_events=CHUNK)
    size = np.maximum(np.abs(motion.after).max(axis=0), np.finfo(float).tiny)
    residual = float(np.max(np.abs(orbit.end_state - state) / size))
    return SteadyState(Attractor.NEUTRAL_FAMILY, state, orbit, 1, residual, math.nan, 1.0)
