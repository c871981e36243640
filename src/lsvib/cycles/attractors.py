"""The attractor that a motion of any model reaches; exact means and extremes over a cycle.

A motion *settles* if the engine proves that no guard can fire again, so that it stays in one linear mode for ever.
Otherwise its events recur, and their return map decides (:mod:`lsvib.cycles.return_map`): the motion has reached its
cycle when the map returns the same state to rounding; if the motion converges slowly, the map is solved for the fixed
point that it approaches. No waiting time enters.
"""

import math
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from lsvib.cycles import drifts, leaps
from lsvib.cycles.return_map import FixedPoint, ReturnSection, conserves
from lsvib.cycles.return_section import MARGIN, ROUNDING, section_key
from lsvib.cycles.settling import settles_after
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import columns, dispatch, flow_planar
from lsvib.engine.kernels.status import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Budget, Motion, enter, follow
from lsvib.errors import DivergenceError, EngineError, WorkSpentError

CHUNK = 64  # events that are looked at first; every further look takes twice as many
PERIODS = 64  # most returns to the section in a cycle that is recognised because it repeats
SOLVED = 8  # most returns to the section in a cycle that the return map is solved for
LONG = 1000  # events after which returns that hardly move are leapt over
_LONGER = 8  # factor from one such attempt to the next
_MORE_PATIENCE = 1000.0  # time that a return after a leap may take, in times of the longest return seen
REPEATS = (4 * flow_planar.EPS, 1e-10)  # relative change that is rounding: with two states, with more (modal form)
_WAY = np.linspace(0.0, 1.0, 9)  # parts of the way to a fixed point at which the events of a return are compared
_UNDAMPED = 1e-30  # damping over frequency that is zero: a mode is made from 60 digits, which leave less than that
_LATER = 37  # events after which leaps begin again; no multiple of the number of events in a usual return
FEWEST = 4  # fewest returns that show where a motion goes, unless they repeat
_APART = 0.05  # change from return to return, in sizes of the motion, with which no cycle is near after many events
_EACH = 100.0  # work of an event in blocks, at most as a rule
_SEARCH = 50_000.0  # work of some events in blocks after which a search is held to be endless
_STEPS = 8  # returns in a row that tell a drift from rounding
# A fixed point smaller than this, in scales of the motion, is the equilibrium itself, on a surface. The first number is
# for two states, the second for more, where Newton's method leaves 1e-9 over the distance of a multiplier from one.
CORNERS = (1e-9, 1e-5)


_TOUCH = 1e-6  # part of a period for which the largest of a neutral family seems to rest where it touches θ′ = 0


class Attractor(IntEnum):
    """Where a motion ends up."""

    UNRESOLVED = -1
    STEADY_SLIDING = 0
    STICK_SLIP_CYCLE = 1
    SPRAG_SLIP_CYCLE = 2
    OTHER_CYCLE = 3  # a cycle of pure slip
    UNBOUNDED = 4  # of compliant threads, and of parts of a drive; other drives have a bounded energy
    REST = 5  # at rest for ever; never the label of a drive whose motor turns, which ends every rest
    NEUTRAL_FAMILY = 6  # undamped oscillations side by side, each periodic, none attracting the others
    RECURRENT = 7  # events for ever without a period or a trend: quasi-periodic or chaotic


class Passage(NamedTuple):
    """A stretch of a line on which a ``mode`` is entered; all motions that enter the mode there have one attractor.

    ``ends`` (2, 2) are the states at the ends of the stretch.
    """

    mode: int
    ends: np.ndarray


@dataclass(frozen=True)
class SteadyState:
    """The attractor of a motion.

    ``label`` names it, and ``state`` (n) is the equilibrium or the state on the section. A cycle also has ``orbit``,
    one period as a motion from the point on the section; ``returns``, the number of returns to the section in a period;
    ``residual`` [1], the change of the section state over one period relative to the size of the motion; ``enclosure``
    [1], the half width of the interval that is proved to hold the fixed point, relative to that size (0 if the section
    state repeats to the last bit, nan if the section is not a line); and ``multiplier`` [1], the largest of the return
    map. ``passages`` are the stretches over which the motion was leapt.
    """

    label: Attractor
    state: np.ndarray
    orbit: Motion | None = None
    returns: int = 0
    residual: float = math.nan
    enclosure: float = math.nan
    multiplier: float = math.nan
    passages: tuple[Passage, ...] = ()

    @property
    def period(self) -> float:
        """Period [s]; nan for an equilibrium."""
        return self.orbit.end_time if self.orbit else math.nan

    def extremes(self, row) -> tuple[float, float]:
        """Return the extremes over the cycle of an affine function (n + 1) or an observable (m, n + 1)."""
        if self.orbit is None:
            value = float(row[:-1] @ self.state + row[-1])
            return value, value
        return orbit_extremes(self.orbit, row)

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak of u [rad]."""
        low, high = self.extremes(np.eye(1, self.state.size + 1)[0])
        return 0.5 * (high - low)


def orbit_extremes(orbit: Motion, row: np.ndarray) -> tuple[float, float]:
    """Exact extremes along a motion of an affine function (n + 1) or of an observable (modes, n + 1).

    Raises ``EngineError`` where the rates of a mode lie too far apart to isolate them.
    """
    low, high = math.inf, -math.inf
    modes, starts, _, durations = orbit.arcs()
    for mode, start, duration in zip(modes, starts, durations, strict=True):
        functional = row if row.ndim == 1 else row[mode]
        a, b = dispatch.extremes(orbit.automaton.tables.flow, mode, start, functional, duration)
        low, high = min(low, a), max(high, b)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise EngineError("the extremes of the motion cannot be isolated: the rates of a mode lie too far apart.")
    return low, high


def arc_integrals(orbit: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Exact ∫(u, w, 1) dt over each arc of a motion, shape (k, 3) [rad s, rad, s], and the arcs' modes (k).

    From the equation of motion of the mode:  a₀ ∫u = b τ − Δw − a₁ Δu;  without stiffness, as at rest, w is constant.
    """
    modes, starts, ends, durations = orbit.arcs()
    flow = orbit.automaton.tables.flow[modes]
    change = ends - starts
    a0, a1, b = flow[:, columns.A0], flow[:, columns.A1], flow[:, columns.B]
    resting = a0 == 0
    spring = (b * durations - change[:, 1] - a1 * change[:, 0]) / np.where(resting, 1.0, a0)
    drift = starts[:, 0] * durations + 0.5 * starts[:, 1] * durations**2
    return np.stack([np.where(resting, drift, spring), change[:, 0], durations], axis=1), modes


def steady_state(
    automaton: Automaton, state, *, mode: int | None = None, max_events: int = 300_000, patience: int = LONG
) -> SteadyState:
    """Find the attractor of the motion of any model from ``state`` (n), in ``mode`` if given.

    ``max_events`` bounds the work: it is a number of events with two states, and with more the budget in units of one
    ordinary event (:class:`lsvib.engine.motion.Budget`), which may be spent twice. ``patience`` is the number of events
    after which returns that hardly move are leapt over, with two states.

    The search ends in one of the following ways.

    * The model vouches that areas never grow (``Automaton.contracts``). Then a closed orbit cannot lie where areas
      shrink, and a motion cannot spiral outwards; so all motions end in steady sliding, or without damping in the
      neutral oscillations that never pass θ′ = 0.
    * The motion settles (:func:`settled`): steady sliding, rest, neutral oscillations, or unbounded.
    * The section state repeats after 1 to 64 returns, or the map of 1 to 8 returns has an attracting fixed point. The
      cycle is called sprag–slip if it sprags, stick–slip if it rests, and other cycle if it does neither; a fixed point
      at the origin is steady sliding. With more than two states a cycle that nothing damps is one of a neutral family.
    * A motion of compliant threads, or of a part of a drive, such as slip without rest, leaves the range of numbers:
      unbounded.
    * ``max_events`` are spent, or the engine cannot decide the next event: unresolved. This happens to motions without
      an attracting cycle – chaotic and quasi-periodic ones, above all where nothing damps – and to motions whose cycle
      attracts slowly, if it has a multiplier within 1e-6 of the unit circle or more than 8 returns, or if the return
      map has no derivative.
    """
    return _steady_state(automaton, np.array(state, dtype=float), mode, max_events, patience, True)


def _steady_state(
    automaton: Automaton, state: np.ndarray, mode: int | None, max_events: int, patience: int, twice: bool
) -> SteadyState:
    """Search as :func:`steady_state`; with ``twice``, two motions must end alike where a drift leaves its line."""
    if automaton.contracts and (automaton.tables.flow[:, columns.ALPHA] > 0).any():
        return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(state))
    if mode is None and _at_equilibrium(automaton, state):
        return SteadyState(Attractor.STEADY_SLIDING, state)
    if state.size > 2:
        return _of_more_states(automaton, state, mode, Budget(max_events))
    used, chunk = 0, min(CHUNK, patience)
    while used < max_events:
        try:
            motion = follow(automaton, state, math.inf, mode=mode, max_events=chunk)
        except DivergenceError:
            return SteadyState(Attractor.UNRESOLVED if automaton.passive else Attractor.UNBOUNDED, state)
        except EngineError:
            return SteadyState(Attractor.UNRESOLVED, state)
        if motion.status == Status.SETTLED:
            return settled(automaton, motion)
        if automaton.contracts or _only_touches(motion):
            return _neutral(automaton, motion)
        used += motion.time.size
        if used >= patience:
            patience *= _LONGER
            slow = _slow_end(automaton, motion, max_events - used, twice)
            if slow is not None:
                return slow
        cycle = _recurrence(automaton, motion)
        if cycle is not None:
            return cycle
        chunk = min(2 * chunk, max(max_events - used, 1))
        state, mode = motion.end_state, motion.end_mode
    return SteadyState(Attractor.UNRESOLVED, state)


def _at_equilibrium(automaton: Automaton, state: np.ndarray) -> bool:
    """Whether a motion with more than two states starts in steady sliding, to the last bit."""
    if state.size == 2 or state.any():
        return False
    return not automaton.tables.flow.field[enter(automaton, state)[0], :, -1].any()


def _of_more_states(automaton: Automaton, state: np.ndarray, mode: int | None, budget: Budget) -> SteadyState:
    """Find the attractor of a motion with more than two states; the budget may be spent twice."""

    def ended(part: Motion, apart: float = _APART) -> SteadyState | None:
        if part.status == Status.SETTLED:
            return settled(automaton, part)
        return _recurrence(automaton, part, budget, apart)

    found: SteadyState | drifts.Recurrence | None = None
    used, chunk = 0, CHUNK
    try:
        while found is None and used < LONG:
            motion = followed(automaton, state, mode, chunk, budget)
            found, state, mode = ended(motion, math.inf), motion.end_state, motion.end_mode
            used, chunk = used + motion.time.size, 2 * chunk
        if found is None:
            again = Budget(budget.left)
            found, leapt = drifts.pursue(motion, budget, ended)
            if leapt and found is not None:  # a leap loses the phase of fast oscillations
                budget = again
                later = follow(automaton, state, math.inf, mode=mode, max_events=_LATER, budget=budget)
                second, _ = drifts.pursue(later, budget, ended)
                found = found if _name(second) == _name(found) else None
    except DivergenceError:
        return SteadyState(Attractor.UNRESOLVED if automaton.passive else Attractor.UNBOUNDED, state)
    except EngineError:
        return SteadyState(Attractor.UNRESOLVED, state)
    if isinstance(found, drifts.Recurrence):
        return SteadyState(Attractor.RECURRENT, found.state)
    return found or SteadyState(Attractor.UNRESOLVED, state)


def followed(automaton: Automaton, state: np.ndarray, mode: int | None, events: int, budget: Budget) -> Motion:
    """Follow a motion over some events; one carried in blocks settles also if its rates show that it does.

    Raises what ``follow`` raises, and ``WorkSpentError`` where the search for one event has no end in sight.
    """
    if not isinstance(automaton.tables.flow, BlockFlow):
        return follow(automaton, state, math.inf, mode=mode, max_events=events, budget=budget)
    part = Budget(min(budget.left, _SEARCH + _EACH * events))
    before = part.left
    motion = follow(automaton, state, math.inf, mode=mode, max_events=events, budget=part)
    budget.spend(before - part.left)
    if motion.status != Status.WORK_SPENT:
        return motion
    time = settles_after(automaton, motion.end_mode, motion.end_state)
    if time is None and motion.time.size:
        return motion  # the next call looks at the last event alone
    if time is None:
        raise WorkSpentError("the search for the next event takes more work than is allowed.")
    last = follow(automaton, motion.end_state, time, mode=motion.end_mode, max_events=1, budget=budget)
    if last.status == Status.TIME_REACHED:
        return replace(motion, status=Status.SETTLED)
    return last


def _name(found: SteadyState | drifts.Recurrence | None) -> Attractor:
    """Return the label of a result of leaps."""
    if isinstance(found, SteadyState):
        return found.label
    return Attractor.UNRESOLVED if found is None else Attractor.RECURRENT


class _Watched(NamedTuple):
    """The states of a motion on the section of its rarest events.

    ``key`` is kind and mode of these events; ``points`` (k, n) are the states after them; ``size`` (n) is that of the
    motion; ``longest`` [s] is the longest time between two of them.
    """

    key: tuple[int, int]
    points: np.ndarray
    size: np.ndarray
    longest: float


def _watched(motion: Motion) -> _Watched | None:
    """Watch a motion on the section of its rarest events; None if it only touches guards."""
    key = section_key(motion)
    if key is None:
        return None
    watched = (motion.kind == key[0]) & (motion.mode == key[1])
    size = np.abs(motion.after).max(axis=0)
    size[size == 0] = 1.0  # a coordinate that is zero at every event may have any scale
    return _Watched(key, motion.after[watched], size, np.diff(motion.time[watched]).max(initial=0.0))


def _slow_end(automaton: Automaton, motion: Motion, left: int, twice: bool) -> SteadyState | None:
    """Find by leaps the end of a motion whose returns to a line hardly move along it; None if that is not known.

    ``left`` events may follow. Where the drift leaves the line, the motion is somewhere between two returns; with
    ``twice`` the motion from the last return and the one from half a return further must end alike.
    """
    seen = _watched(motion)
    if seen is None or len(seen.points) < FEWEST:
        return None
    key, points, size, patience = seen.key, seen.points, seen.size, _MORE_PATIENCE * seen.longest
    section = ReturnSection(automaton, key, points[-1], size, 1, patience)
    if section.dimension != 1:
        return None
    end = leaps.drift(section, 0.0)
    if end is None:
        return None
    place, beyond = (section.state(np.array([y])) for y in (end.place, end.beyond))
    came_from = section.state(np.array([leaps.reach_back(section, 0.0)]))
    passage = Passage(key[1], np.array([came_from, place]))
    if end.end == leaps.End.CLOSES:
        there = ReturnSection(automaton, key, beyond, size, 1, patience)
        fixed = there.fixed_point(place[None])
        found = None if fixed is None else _cycle(there, fixed)
    elif end.end == leaps.End.SHRINKS:
        found = _steady_state(automaton, place, key[1], left, LONG, twice)
    else:
        between = section.state(np.array([end.place + 0.5 * section.return_from(end.place).excess]))
        found = _steady_state(automaton, place, key[1], left, LONG, False)
        if twice and found.label != _steady_state(automaton, between, key[1], left, LONG, False).label:
            return SteadyState(Attractor.UNRESOLVED, place)
    return None if found is None else replace(found, passages=(passage, *found.passages))


def settled(automaton: Automaton, motion: Motion) -> SteadyState:
    """Return the attractor of a motion that never leaves its last mode.

    The mode is a sum of oscillators: one with two states, one for each pair of rates with more. The attractor is rest
    in a mode at rest; steady sliding if every excited oscillator is damped; unbounded if one of them grows; and a
    neutral family if one of them goes on for ever. The family has a period if only one does: several frequencies have
    none in common.
    """
    flow, mode, state = automaton.tables.flow, motion.end_mode, motion.end_state
    if automaton.codes[mode] in automaton.rest_codes:
        return SteadyState(Attractor.REST, state)
    if isinstance(flow, BlockFlow):  # such a mode settles only if everything that moves dies away
        field = flow.field[mode]
        return SteadyState(Attractor.STEADY_SLIDING, np.linalg.solve(field[:, :-1], -field[:, -1]))
    if isinstance(flow, np.ndarray):
        rows, equilibrium = flow[mode][None], np.array([flow[mode, columns.EQUILIBRIUM], 0.0])
        excited = np.array([(state != equilibrium).any()])
    else:
        pairs, field = flow.pairs[mode], flow.field[mode]
        rows, table = flow.oscillators[mode, :pairs], flow.to_modal[mode, : 2 * pairs + flow.singles[mode]]
        equilibrium = np.linalg.solve(field[:, :-1], -field[:, -1])
        rounding = ROUNDING * (np.abs(table[:, :-1]) @ np.abs(state) + np.abs(table[:, -1]))
        moved = np.abs(table[:, :-1] @ state + table[:, -1]) > rounding
        if (moved[2 * pairs :] & (flow.rates[mode, : flow.singles[mode]] > 0)).any():
            return SteadyState(Attractor.UNBOUNDED, state)
        excited = moved[: 2 * pairs].reshape(-1, 2).any(axis=1)
    damping = rows[:, columns.ALPHA]
    undamped = np.abs(damping) <= (ROUNDING if state.size == 2 else _UNDAMPED) * rows[:, columns.BETA]
    if (excited & ~undamped & (damping < 0)).any():
        return SteadyState(Attractor.UNBOUNDED, state)
    lasting = np.flatnonzero(excited & undamped & (rows[:, columns.BETA] > 0))
    if lasting.size == 0:
        return SteadyState(Attractor.STEADY_SLIDING, equilibrium)
    if lasting.size > 1:
        return SteadyState(Attractor.NEUTRAL_FAMILY, state, multiplier=1.0)
    orbit = follow(automaton, state, 2 * math.pi / rows[lasting[0], columns.BETA], mode=mode)
    return SteadyState(Attractor.NEUTRAL_FAMILY, state, orbit, 1, 0.0, 0.0, 1.0)


def _only_touches(motion: Motion) -> bool:
    """Whether the later half of a planar motion's events are touches of guards in one undamped mode."""
    half = motion.time.size // 2
    flow = motion.automaton.tables.flow
    touches = isinstance(flow, np.ndarray) and bool((motion.kind[half:] == GRAZE_KIND).all())
    return touches and flow[motion.end_mode, columns.ALPHA] == 0 and flow[motion.end_mode, columns.BETA] > 0


def _neutral(automaton: Automaton, motion: Motion) -> SteadyState:
    """Return the neutral oscillation of a motion without damping after many events, with one period as its orbit.

    If the motion only touches a guard, rounding decides whether there is an event; the period is one turn of the mode.
    """
    state, mode = motion.end_state, motion.end_mode
    if _only_touches(motion):
        orbit = follow(automaton, state, 2 * math.pi / automaton.tables.flow[mode, columns.BETA], mode=mode)
    else:
        own = np.flatnonzero(~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND)))[-1]
        state, mode, kind = motion.after[own], int(motion.mode[own]), int(motion.kind[own])
        orbit = follow(automaton, state, math.inf, mode=mode, stop=(kind, mode), max_events=CHUNK)
    size = np.maximum(np.abs(motion.after).max(axis=0), np.finfo(float).tiny)
    residual = float(np.max(np.abs(orbit.end_state - state) / size))
    return SteadyState(Attractor.NEUTRAL_FAMILY, state, orbit, 1, residual, math.nan, 1.0)


def _recurrence(
    automaton: Automaton, motion: Motion, budget: Budget | None = None, apart: float = math.inf
) -> SteadyState | None:
    """Return the attractor that the last events of a motion lie on or approach; None if they do not show it."""
    seen = _watched(motion)
    if seen is None:
        return None
    key, points, size, longest = seen
    changes = np.abs(points[-1] - points[-2 : -2 - PERIODS : -1]) / size
    repeats = np.flatnonzero((changes <= REPEATS[size.size > 2]).all(axis=1)) + 1
    if len(points) < FEWEST and not repeats.size:
        return None
    nearest = int(repeats[0]) if repeats.size else int(np.argmin(changes[:SOLVED].max(axis=1))) + 1
    if changes[nearest - 1].max() > apart:
        return None
    section = ReturnSection(automaton, key, points[-1], size, nearest, longest, budget)
    if repeats.size and size.size == 2:
        return _cycle(section, section.repeated())
    divisors = [returns for returns in range(1, nearest + 1) if nearest % returns == 0]
    for returns in divisors:  # a slow cycle may seem to have a multiple of its returns
        before = points[-1 - returns : len(points) // 2 : -returns][::-1]
        section = ReturnSection(automaton, key, points[-1], size, returns, longest, budget)
        found = section.fixed_point(before) if len(before) else None
        if found is None:
            continue
        if section.dimension == 1 and not leaps.goes_straight(section, float(section.place(found.state)[0])):
            continue
        if size.size > 2 and not _by_the_same_events(section, found):
            continue
        if np.abs(found.state / size).max() < CORNERS[size.size > 2]:
            if np.abs(points[-1] / size).max() < np.abs(before[-1] / size).max():
                return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(found.state))
            continue
        for fewer in divisors[: divisors.index(returns)]:  # Newton's method may miss these from afar
            there = ReturnSection(automaton, key, found.state, size, fewer, longest, budget)
            again = there.fixed_point(before)
            if again is not None and (np.abs(again.state - found.state) <= CORNERS[0] * size).all():
                return _cycle(there, again)
        return _cycle(section, found)
    if not repeats.size or _drifts(points[::-nearest]):
        return None
    found = section.repeated()
    return None if abs(found.multiplier) >= 1 - MARGIN and not found.neutral else _cycle(section, found)


def _by_the_same_events(section: ReturnSection, found: FixedPoint) -> bool:
    """Whether returns have the same events all the way from the origin of a section to a fixed point."""
    target = section.place(found.state)
    events = [section.outcome(part * target)[1] for part in _WAY]
    return events[0] is not None and all(one == events[0] for one in events)


def _drifts(states: np.ndarray) -> bool:
    """Whether states (k, n) of a section, the latest first, move in one direction by steps that do not shrink."""
    if len(states) <= _STEPS:
        return False
    size = np.maximum(np.abs(states[: _STEPS + 1]).max(axis=0), np.finfo(float).tiny)
    latest, first, all_of_them = (
        np.abs((states[i] - states[j]) / size).max() for i, j in ((0, 1), (_STEPS - 1, _STEPS), (0, _STEPS))
    )
    return bool(all_of_them > 0.5 * _STEPS * latest and latest > 0.9 * first)


def _cycle(section: ReturnSection, found: FixedPoint) -> SteadyState | None:
    """Return the cycle through a fixed point of the return map; None if its motion does not come back."""
    orbit = section.come_back(found.state)
    if orbit is None:
        return None
    automaton = orbit.automaton
    modes = automaton.codes[orbit.arcs()[0]]
    rests = np.isin(modes, automaton.rest_codes).any()
    if np.isin(orbit.kind, automaton.sprag_kinds).any() or np.isin(modes, automaton.sprag_codes).any():
        label = Attractor.SPRAG_SLIP_CYCLE
    elif found.neutral or (rests and conserves(automaton) and _only_touches_rest(orbit)):
        label = Attractor.NEUTRAL_FAMILY
    else:
        label = Attractor.STICK_SLIP_CYCLE if rests else Attractor.OTHER_CYCLE
    residual = float(np.max(np.abs(orbit.end_state - found.state) / section.size))
    return SteadyState(label, found.state, orbit, section.returns, residual, found.enclosure, found.multiplier)


def _only_touches_rest(motion: Motion) -> bool:
    """Whether a motion rests for no longer than the largest of a neutral family seems to, where it touches θ′ = 0."""
    modes, _, _, durations = motion.arcs()
    resting = np.isin(motion.automaton.codes[modes], motion.automaton.rest_codes)
    return bool(durations[resting].sum() <= _TOUCH * durations.sum())
