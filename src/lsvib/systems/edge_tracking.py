"""Repelling cycles of any model on the edge of a basin, found by edge tracking.

docs/cycles.md says how. This is a search, not a proof: an edge may hold several cycles, or none, because the motion
jumps where it touches a surface.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from lsvib.errors import EngineError
from lsvib.systems.attractor import Attractor, SteadyState, steady_state
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, Events
from lsvib.systems.motion import Budget, Motion, follow
from lsvib.systems.section import Section, section_key, size_of

_FINEST = 1e-12  # distance, in sizes of the motion, beyond which halving meets the rounding of the motions
_PARTED = 1e-2  # distance at which two motions no longer follow the edge
_WORK = 10_000  # of an ending, in units of one event: some hundred returns and a slow approach; and of two side by side

StateEnding = tuple[np.ndarray, SteadyState]
Solver = Callable[[Section], Any]  # returns the repelling cycle near the origin of a section, or None


def edge_cycles(automaton: Automaton, endings: Sequence[StateEnding], solver: Solver) -> Iterator[Any]:
    """Yield, for each two attractors that starts reach, the cycle on the edge between their basins, or None.

    ``endings``: starts (n) and what their motions end on; those that are unresolved take no part.
    """
    groups: list[list[StateEnding]] = []
    for state, steady in endings:
        if steady.label == Attractor.UNRESOLVED:
            continue
        group = next((group for group in groups if alike(steady, group[0][1])), None)
        if group is None:
            groups.append(group := [])
        group.append((state, steady))
    size = np.abs([state for state, _ in endings]).max(axis=0, initial=np.finfo(float).tiny)
    for first, second in combinations(groups, 2):
        pairs = [(one, other) for one, _ in first for other, _ in second]
        one, other = min(pairs, key=lambda pair: float(np.abs((pair[0] - pair[1]) / size).max()))
        yield _cycle_between(automaton, one, other, first[0][1], solver)


def alike(one: SteadyState, other: SteadyState) -> bool:
    """Whether two motions end on the same attractor, as far as label and period tell; all neutral ones are one."""
    if one.label != other.label:
        return False
    cycles = one.orbit is not None and other.orbit is not None and one.label != Attractor.NEUTRAL_FAMILY
    return not cycles or one.same_period(other)


def _cycle_between(automaton: Automaton, low: np.ndarray, high: np.ndarray, ending: SteadyState, solver: Solver) -> Any:
    """The cycle on the edge between two starts (n), of which the first has this ending; None if none is found."""

    def on_first_side(state: np.ndarray) -> bool:
        return alike(steady_state(automaton, state, mode=mode, max_events=_WORK), ending)

    mode: int | None = None
    size = np.maximum(np.abs(low), np.abs(high))
    for _ in range(8):  # attempts of Newton's method: four on the first line, the others from later events
        # Two states come together by ten halvings between two attempts, or until these meet rounding.
        end = max(1e-3 * _distance(low, high, size), _FINEST)
        while _distance(low, high, size) > end:
            middle = 0.5 * (low + high)
            if (middle == low).all() or (middle == high).all():
                break
            low, high = (middle, high) if on_first_side(middle) else (low, middle)
        finest = _distance(low, high, size) <= _FINEST
        both = _side_by_side(automaton, low, high, mode)
        if both is None and finest:
            return None
        if both is None:
            continue
        motion, gaps, others = both
        for section in _sections(motion, gaps):
            cycle = solver(section)
            if cycle is not None:
                return cycle
        if finest:
            # distance at which they are taken up again: eight digits were gained on the way
            later = int(np.searchsorted(gaps, 1e-4))
            if later in (0, len(gaps)):
                return None
            low, high, mode = motion.after[later], others[later], int(motion.mode[later])
            size = np.abs(motion.after).max(axis=0)
    return None


def _distance(one: np.ndarray, other: np.ndarray, size: np.ndarray) -> Any:
    return np.max(np.abs(one - other) / np.where(size == 0, 1.0, size), axis=-1)


def _side_by_side(
    automaton: Automaton, low: np.ndarray, high: np.ndarray, mode: int | None
) -> tuple[Motion, np.ndarray, np.ndarray] | None:
    """Follow two motions while they have the same events and stay together.

    Returns the first one as far as that goes, the largest distance up to each event, and the second one's states (k,
    n); None if they part at once.
    """
    try:
        one, other = (
            follow(automaton, state, np.inf, mode=mode, max_events=2000, budget=Budget(_WORK)) for state in (low, high)
        )
    except EngineError:
        return None
    count = min(one.time.size, other.time.size)
    same = (one.kind[:count] == other.kind[:count]) & (one.mode[:count] == other.mode[:count])
    same &= one.kind[:count] != ACCUMULATION_KIND
    count = int(np.argmin(same)) if not same.all() else count
    size = np.abs(one.after[:count]).max(axis=0, initial=0.0)
    gaps = np.maximum.accumulate(_distance(one.after[:count], other.after[:count], size))
    count = int(np.searchsorted(gaps, _PARTED))
    if count == 0:
        return None
    together = {name: getattr(one, name)[:count] for name in Events._fields}
    return replace(one, **together), gaps[:count], other.after[:count]


def _sections(motion: Motion, gaps: np.ndarray) -> Iterator[Section]:
    """Sections along an edge, for the numbers of returns that a period may have.

    They lie where the motion is on the edge to some digits, and where it parts from the other.
    """
    key = section_key(motion)
    if key is None:
        return
    met = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    size, points = size_of(motion), motion.after[met]
    longest = float(np.diff(motion.time[met], prepend=0.0).max())
    # distance at which they are still on the edge, to so many digits
    for last in sorted({max(int(np.searchsorted(gaps[met], near)) - 1, 0) for near in (1e-5, _PARTED)}):
        earlier = range(1, min(4, last) + 1)  # most returns to the section in a period that are tried
        changes = {r: float(np.max(np.abs(points[last] - points[last - r]) / size)) for r in earlier}
        for returns in sorted(changes, key=lambda r: changes[r]) or [1]:
            # a return may take so many times the longest one on the edge
            yield Section(motion.automaton, key, points[last], size, returns, 4.0 * longest)
