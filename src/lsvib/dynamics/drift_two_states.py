"""The end of a motion with two states whose returns hardly move, found by leaps along its return map.

The return map P of a line that the motion crosses again and again is monotone while the events of a return stay the
same, because motions in a plane do not cross. The motion then drifts in the direction of f(y) = P(y) − y, past every y
up to the first zero of f, or until the events of a return change. Between two places f is replaced by its Chebyshev
interpolant. If the whole interpolant is well above its error, which its last coefficients show, f has no zero there,
and the motion passes from one place to the other, however many returns that takes.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from lsvib.dynamics.poincare_map import Section

_NODES = 17  # of an interpolant; a drift with fewer than a few turning points is resolved by them
_TAIL = 4  # number of last coefficients whose size is taken for the error of the interpolant
_SAFE = 8.0  # distance of the interpolant from zero, in units of that error, that counts as different from zero
_SAMPLES = 200  # places at which the interpolant is evaluated: a polynomial of degree 16 turns far less often
_FIRST = 64.0  # length of the first leap, in returns
_LONGER = 4.0  # factor from one leap to the next
_NEARER = 0.7  # part of the distance to zero that a leap may take: f changes on the scale of that distance
_SHORTER = 0.125  # factor after a leap that was too long
_LEAPS = 80  # most leaps in one drift; two dozen of them cross ten decades
_SHORTEST = 8.0  # shortest leap, in returns: fewer returns are followed instead
_STALLS = 8  # most leaps in one drift that are too short: beyond, f is near its rounding or changes its sign too often
_HALVINGS = 80  # most halvings of an interval; its ends are neighbouring doubles before, unless one of them is zero
_WIDEST = 0.25  # half width of an interval that is called a cycle, in distances from zero
_FINE = 16.0  # size of f, in units of its rounding, below which a line with a finer scale is taken,
_FAR = 0.25  # once the drift has come this far, in scales of the line
FEW = 32.0  # returns within which a target counts as reached straight
_NEARLY = 1e-3  # part of the way that is left out before a target, because f vanishes there
_EDGE = 0.25  # width, in returns, to which the place is found at which the events of a return change

_PLACES = chebyshev.chebpts1(_NODES)  # in [−1, 1]
_TO_WEIGHTS = np.linalg.inv(chebyshev.chebvander(_PLACES, _NODES - 1))  # from values there to Chebyshev coefficients
_TO_SAMPLES = chebyshev.chebvander(np.linspace(-1, 1, _SAMPLES), _NODES - 1)


class End(IntEnum):
    """How a drift ends."""

    CLOSES = 0  # a zero of f, where a cycle passes
    LEAVES = 1  # a place beyond which the events of a return change
    SHRINKS = 2  # the returns are so short that a line with a finer scale is needed
    GROWS = 3  # as far away as was asked for


class Drift(NamedTuple):
    """Where a drift ends, at ``place`` on the line, and why; ``beyond`` is a place on the other side of a zero of f."""

    place: float
    beyond: float
    end: End


def far_drift(section: Section) -> tuple[Section, Drift | None]:
    """Follow the drift of a motion from the origin of a line, on finer and finer lines where the returns shrink.

    Returns the last line and the drift on it: it SHRINKS only if it cannot be followed on a finer line.
    """
    end = drift(section)
    while end is not None and end.end == End.SHRINKS:
        finer = section.finer(end.place)
        after = None if finer is None else drift(finer, length=_FAR * finer.distance(0.0))
        if after is None:
            break
        section, end = finer, after
    return section, end


def drift(section: Section, farthest: float = math.inf, length: float | None = None) -> Drift | None:
    """Follow the drift of a motion from y = 0 on a section of one dimension; None if that is impossible.

    It is followed up to |y| = ``farthest``, with a first leap of ``length``. It is impossible if f is zero to rounding,
    or if its zeros and turning points lie too close for ``_LEAPS`` leaps.
    """
    first = section.return_from(0.0)
    if first.events is None or abs(first.excess) <= _rounding(0.0):
        return None
    way, here, stalls = np.sign(first.excess), 0.0, 0
    length = _FIRST * abs(first.excess) if length is None else length
    for _ in range(_LEAPS):
        if abs(here) > farthest:
            return Drift(here, here, End.GROWS)
        step = abs(section.return_from(here).excess)
        # A line's zero is no special place if the drift there does not fade.
        distance = max(section.distance(here), section.distance(0.0) * min(1.0, step / abs(first.excess)))
        length = min(length, max(_NEARER * distance, _FIRST * step))
        there = here + way * length
        if step < _FINE * _rounding(here) and abs(here) > _FAR:
            return Drift(here, here, End.SHRINKS)
        if section.return_from(there).events != first.events:
            there = _last_same(section, here, there, first.events, step)
            if abs(there - here) <= step:
                return Drift(here, there, End.LEAVES)
        outcome = _passes(section, here, there, way, first.events)
        if outcome is None:
            length *= _SHORTER
            if length < _SHORTEST * step:
                stalls += 1
                if stalls > _STALLS:
                    return None
                last, here, length = here, here + section.return_from(here).excess, _SHORTEST * step
                if section.return_from(here).events != first.events:
                    return Drift(last, here, End.LEAVES)
        elif outcome == there and way * section.return_from(there).excess <= 0:  # a zero behind the last node
            length *= _SHORTER
        elif outcome == there:
            here, length = there, length * _LONGER
        else:
            return Drift(*_closer(section, here, outcome, way), End.CLOSES)
    return None


def goes_straight(section: Section, target: float) -> bool:
    """Whether the motion from y = 0 drifts to y = ``target``, near a zero of f, and f has no other zero before.

    A target that is only a few returns away counts as reached: a motion that converges fast is that near to it.
    """
    first = section.return_from(0.0)
    if abs(target) <= FEW * abs(first.excess):
        return True
    nearly = target - math.copysign(FEW * abs(section.return_from(target).excess) + _NEARLY * abs(target), target)
    return _passes(section, 0.0, nearly, math.copysign(1.0, target), first.events) == nearly


def reach_back(section: Section) -> float:
    """Return a place as far back as possible from which all motions drift to y = 0."""
    first = section.return_from(0.0)
    way, here, length = np.sign(first.excess), 0.0, _FIRST * abs(first.excess)
    for _ in range(_LEAPS):
        step = abs(section.return_from(here).excess)
        if not length > _SHORTEST * step:
            break
        there = here - way * length
        if section.return_from(there).events != first.events:
            there = _last_same(section, here, there, first.events, step)
        if there == here:
            break
        if _passes(section, here, there, way, first.events) == there:
            here, length = there, length * _LONGER
        else:
            length *= _SHORTER
    return here


def _closer(section: Section, here: float, there: float, way: float) -> tuple[float, float]:
    """Halve an interval, at whose ends f points inwards, until rounding of f or of y ends it."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (here + there)
        excess = way * section.return_from(middle).excess
        if middle in (here, there) or not abs(excess) > _rounding(middle):
            break
        here, there = (middle, there) if excess > 0 else (here, middle)
    return here, there


def enclosure(section: Section) -> tuple[float, float] | None:
    """Return an interval about y = 0 into which its ends return, beyond doubt, by the same events; else None.

    P is monotone, so every motion from it tends to a cycle in it: however faint the damping is, that is a proof.
    """
    widest, clear = _WIDEST * section.distance(0.0), _SAFE * section.grain(np.zeros(1)) * _rounding(0.0)
    width = min(np.finfo(float).eps, widest)
    while True:
        left, right = (section.return_from(side * width) for side in (-1, 1))
        if left.events is not None and left.events == right.events and left.excess > clear and right.excess < -clear:
            return -width, width
        if width >= widest:
            return None
        width = min(_LONGER * width, widest)


def _rounding(place: float) -> float:
    """Return the size of f below which it is rounding: the rounding of the line's coordinate."""
    return 8 * np.finfo(float).eps * max(1.0, abs(place))


def _last_same(section: Section, here: float, there: float, events, step: float) -> float:
    """Return the farthest place from ``here`` towards ``there`` with the same events, to a part of a return."""
    for _ in range(_HALVINGS):
        if abs(there - here) <= _EDGE * step:
            break
        middle = 0.5 * (here + there)
        if middle in (here, there):
            break
        if section.return_from(middle).events == events:
            here = middle
        else:
            there = middle
    return here


def _passes(section: Section, here: float, there: float, way: float, events) -> float | None:
    """Return ``there`` if f has one sign up to it, a place beyond the first zero if not, None if that is unclear."""
    places = here + 0.5 * (_PLACES + 1) * (there - here)
    found = section.returns_from(places)
    if any(one.events != events for one in found):
        return None
    values = way * np.array([one.excess for one in found])
    weights = _TO_WEIGHTS @ values
    error = _SAFE * np.abs(weights[-_TAIL:]).max() + _rounding(there)
    samples = _TO_SAMPLES @ weights
    negative = np.flatnonzero(values < -error)
    if negative.size:
        before = samples[: max(1, int(_SAMPLES * 0.5 * (_PLACES[negative[0]] + 1)))]
        # There is one change of sign: f is above the error, then falls within it, then is below it.
        undecided = np.flatnonzero(before <= error)
        falls = np.diff(before[max(0, undecided[0] - 1) :]) if undecided.size else np.array([-1.0])
        return float(places[negative[0]]) if (falls < 0).all() else None
    return there if samples.min() > error else None
