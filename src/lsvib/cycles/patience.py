"""Follow a motion with more than two states over times that take the search for events too long."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lsvib.cycles.quiet import beats, quiet_until
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import dispatch
from lsvib.engine.kernels.status import Status
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Budget, Motion, enter, follow
from lsvib.errors import BeatError, EndlessSearchError, UndecidedError, WorkSpentError

_EACH = 90.0  # work of an event, at most as a rule; so a search is left before it has taken all steps that it may
# Events of the first search in blocks, and of that after one that took too long; each further one has twice as many, up
# to the second number: a search that finds no more events takes in vain what all of them may take.
FEW, _MANY = 16, 512
_FIRST = 2000.0  # more work of some events after which quiet times are looked for
_SEARCH = 90_000.0  # work of a search over a short time after which it is held to be endless
# Part of all these works in blocks, times what a step takes there: quiet times are looked for after as many steps as
# ever.
_IN_BLOCKS = 0.2
_MORE = 4.0  # factor of work where events have cost more than was foreseen: a quarter of all is spent in vain at most
# The first search after a quiet time is so long, in times of the fastest rate. `quiet_until` gives up where it would
# take steps below eight of them; the search gets some way beyond that.
_TURNS = 30.0
# The longest one, likewise. Where a guard is zero for good, as N is once all has died away without load, no time is
# quiet; then the next search is over all times, and may find that the motion has settled.
_FOREVER = 1e30
# A state that is smaller after a quiet time has died away: below 1e-308 doubles lose their last places one by one.
_NOTHING = 1e-290


def follow_patiently(
    automaton: Automaton,
    state: np.ndarray,
    t_end: float,
    *,
    mode: int | None,
    stop: tuple[int, int] = (-1, -1),
    max_events: int,
    budget: Budget,
) -> Motion:
    """Follow a motion; arguments, result and errors as of :func:`lsvib.engine.motion.follow`.

    Where a search takes long, times that are surely quiet are left out (:func:`lsvib.cycles.quiet.quiet_until`), in
    turn with searches over short times, each twice as long as the last one until a time is quiet again. Raises
    ``EndlessSearchError`` where neither finds the next event, ``BeatError`` where there must be one nevertheless.
    """
    if mode is None:
        mode, state = enter(automaton, state)
    in_blocks = isinstance(automaton.tables.flow, BlockFlow)
    part = _IN_BLOCKS * automaton.effort if in_blocks else 1.0
    pieces: list[Motion] = []
    time, count, reach, most = 0.0, 0, math.inf, FEW if in_blocks else _MANY
    while True:
        here, most = min(max_events - count, most), min(2 * most, _MANY)
        work = ((_FIRST if reach == math.inf else _SEARCH) + _EACH * here) * part
        left = max(t_end - time, 0.0)  # the sum of times may have been rounded beyond the end
        piece = _searched(automaton, state, min(left, reach), mode, stop, here, work, budget)
        found, last = piece.time.size, left <= reach
        pieces.append(_begun_at(piece, time))
        time, count, state, mode = pieces[-1].end_time, count + found, piece.end_state, piece.end_mode
        over = last if piece.status == Status.TIME_REACHED else count == max_events
        if over or piece.status not in (Status.TIME_REACHED, Status.EVENTS_FULL, Status.WORK_SPENT):
            return _joined(pieces, piece.status)
        if found and piece.status != Status.WORK_SPENT:
            reach = math.inf
            continue
        if piece.status == Status.WORK_SPENT and not found and reach < math.inf:
            kind = BeatError if beats(automaton, mode, state) else EndlessSearchError
            raise kind("the search for the next event takes more work than is allowed.")
        quiet, most = quiet_until(automaton, mode, state, budget), FEW
        if quiet == t_end - time == math.inf:
            return _joined(pieces, Status.SETTLED)
        quiet = min(quiet, t_end - time)
        if quiet > 0:  # else rounding would move the state off the surface that it has just met
            there = np.empty_like(state)
            dispatch.advance(automaton.tables.flow, mode, state, quiet, there)
            if np.abs(there).max() < _NOTHING:
                there[:] = 0.0
            state, time = there, time + quiet
        fastest = float(np.abs(np.linalg.eigvals(automaton.tables.flow.field[mode][:, :-1])).max())
        if fastest == 0 and quiet == 0 and not found:  # no time is short in a mode without any rate
            raise EndlessSearchError("the search for the next event takes more work than is allowed.")
        waits = quiet == 0 and not found and reach < math.inf  # an event has led to a mode with times of its own
        reach = 2 * reach if waits else _TURNS / fastest if fastest else math.inf
        if reach * fastest > _FOREVER:
            reach = math.inf


def _searched(
    automaton: Automaton,
    state: np.ndarray,
    t_end: float,
    mode: int,
    stop: tuple[int, int],
    max_events: int,
    work: float,
    budget: Budget,
) -> Motion:
    """Follow a motion with so much work of a budget; a search that does not end has taken all of it.

    Where the events found have cost more than that, they are looked for again with more of it.
    """
    while True:
        part = Budget(min(budget.left, work))
        before, whole = part.left, part.left == budget.left
        try:
            return follow(automaton, state, t_end, mode=mode, stop=stop, max_events=max_events, budget=part)
        except UndecidedError:
            still = follow(automaton, state, 0.0, mode=mode)
            return replace(still, status=Status.WORK_SPENT)
        except WorkSpentError:
            if whole:
                raise
            work *= _MORE
        finally:
            budget.spend(before - part.left)


def in_a_row(parts: Sequence[Motion]) -> Motion:
    """Return one motion for several that follow each other, each of which begins at 0."""
    starts = np.cumsum([0.0, *(part.end_time for part in parts)])
    return _joined([_begun_at(part, start) for part, start in zip(parts, starts, strict=False)], parts[-1].status)


def _begun_at(piece: Motion, time: float) -> Motion:
    """Return a motion that begins at 0 as one that begins at a time [s]; most do begin at 0, and a copy takes long."""
    if time == 0.0:
        return piece
    return replace(piece, start_time=time, time=piece.time + time, end_time=piece.end_time + time)


def _joined(pieces: Sequence[Motion], status: Status) -> Motion:
    """Return one motion for several that follow each other."""
    if len(pieces) == 1:
        return pieces[0] if pieces[0].status == status else replace(pieces[0], status=status)
    columns = {
        name: np.concatenate([getattr(piece, name) for piece in pieces])
        for name in ("time", "kind", "sign", "mode", "before", "after")
    }
    last = pieces[-1]
    ends = {"end_time": last.end_time, "end_mode": last.end_mode, "end_state": last.end_state}
    return replace(pieces[0], status=status, **columns, **ends)
