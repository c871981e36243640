"""What happens along a branch of cycles: folds, and changes of the itinerary and of the stability."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lsvib.dynamics.branch_points import BranchEquations, Solved
from lsvib.dynamics.cycles import Cycle

_HALVINGS = 50  # more than a step needs to shrink to _NARROW
_SECANTS = 60  # more than halving alone takes from a step to rounding
_AT_FOLD = 1e-13  # part of the tangent along p that counts as none: the branch turns there
_NARROW = 1e-12  # length of the branch within which a change is located


@dataclass(frozen=True)
class Change:
    """Something happens at a ``value`` [SI unit] of the parameter, at a length ``along`` [1] of the branch.

    ``kind`` is fold, itinerary, stability, or end; ``what`` says it in words.
    """

    kind: str
    value: float
    what: str
    along: float


def changes_between(curve: BranchEquations, here: Solved, there: Solved, step: float, along: float) -> list[Change]:
    """Folds, changes of the itinerary and of stability between two points."""
    found = []
    fold = here.tangent[-1] * there.tangent[-1] < 0
    if fold:
        at, point = _zero(curve, here, step, lambda solved: float(solved.tangent[-1]))
        if point is not None:
            found.append(Change("fold", curve.value(point.z), "two cycles meet", along + at))
    before, after = Counter(here.cycle.itinerary), Counter(there.cycle.itinerary)
    if here.cycle.itinerary != there.cycle.itinerary and before != after:
        at, point = _halved(curve, here, step, lambda solved: Counter(solved.cycle.itinerary) == before)
        lost, gained = before - after, after - before
        words = [f"{verb} {_named(events)}" for verb, events in (("loses", lost), ("gains", gained)) if events]
        found.append(Change("itinerary", curve.value(point.z), " and ".join(words), along + at))
    outside = _outside(here.cycle)
    if not fold and outside != _outside(there.cycle) and not found:
        at, point = _halved(curve, here, step, lambda solved: _outside(solved.cycle) == outside)
        leading = point.cycle.multipliers[0]
        what = "a pair of multipliers" if leading.imag else f"a multiplier {'+1' if leading.real > 0 else '−1'}"
        found.append(Change("stability", curve.value(point.z), f"{what} passes the unit circle", along + at))
    return found


def _named(events: Counter[tuple[str, str]]) -> str:
    return ", ".join(f"{kind.replace('_', ' ')} into {mode.replace('_', ' ')}" for kind, mode in sorted(events))


def _outside(cycle: Cycle) -> int:
    return int(np.sum(np.abs(cycle.multipliers) > 1))


def _zero(
    curve: BranchEquations, here: Solved, step: float, function: Callable[[Solved], float]
) -> tuple[float, Solved | None]:
    """Where a function changes sign within a step along the tangent: the secant method, kept in its bracket."""
    low, high, at_low, point = 0.0, step, function(here), None
    end = curve.corrected(here.z + step * here.tangent, here.tangent)
    if end is None:
        return 0.0, None
    at_high = function(end)
    for _ in range(_SECANTS):
        middle = high - at_high * (high - low) / (at_high - at_low)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        solved = curve.corrected(here.z + middle * here.tangent, here.tangent)
        if solved is None:
            return middle, point
        point, value = solved, function(solved)
        if abs(value) <= _AT_FOLD or high - low <= _AT_FOLD:
            break
        if value * at_high < 0:
            low, at_low = high, at_high
        else:
            at_low *= 0.5  # Illinois: the end that stays counts half
        high, at_high = middle, value
        if low > high:
            low, high, at_low, at_high = high, low, at_high, at_low
    return middle, point


def _halved(curve: BranchEquations, here: Solved, step: float, holds: Callable[[Solved], bool]) -> tuple[float, Solved]:
    """The last place within a step at which a condition holds, to rounding; nearly that where points are missing."""
    low, high, point = 0.0, step, here
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        solved = curve.corrected(here.z + middle * here.tangent, here.tangent)
        if solved is not None and holds(solved):
            low, point = middle, solved
        else:
            high = middle
        if high - low <= _NARROW:
            break
    return low, point
