r"""How far the coordinates of a mode get in a motion that starts with the sizes that a model calls typical.

A model can only guess the size of, say, the mismatch of its threads. If rates lie many decades apart, the motion soon
takes a coordinate far beyond that guess, and digits that seem lost by the guess do not matter. Let Π_k be the projector
on the k slowest rates of the homogeneous field of (x, 1). Once all faster parts have died away, or within half a turn
of them if they do not, the state is Π_k (x, 1). So the size that a coordinate has in the motion is

    x* = max( x, |Π_k| (x, 1) ),      over all k for which this state is reached before the horizon.

Rates next to each other (``_GAP``) cannot be separated in this way. But a group of such rates, of which the fastest is
ω, turns the state within its own subspace by about a radian in a time 1/ω: with the projector Π on the group and the
field H of (x, 1), a coordinate also has the size |H Π / ω| (x, 1). So what a large rate of the nut is given as typical
makes of its angle counts as typical, too. Nor can rates be separated that are slower than the horizon T. They make
|exp(H Π T)| (x, 1) of the state: a coupling that is wound up at rest loads the contact long before the nut has swung.

A part that is slower than the horizon has changed little by then, and a coordinate that is small beside such parts is
moved by their change alone (:mod:`lsvib.engine.kernels.flow_modal`). So digits are lost by what has changed until some
time, beside the sizes that are reached then: at the horizon, and at the time of each rate that is slower.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import mpmath
import numpy as np

from lsvib.engine.exact.field import Field, homogeneous

_DIGITS = 150  # with rates thirty decades apart, a product of four of their differences leaves 30 digits
SWINGS = 100  # swings of the coupling in a horizon; a size that takes longer to reach does not count
_SAME = mpmath.mpf(10) ** -35  # relative size of a rate that is zero but for the rounding of the coefficients
_GAP = 4.0  # ratio of two rates that are separated: e⁻⁴ of the faster part is left after a time unit of the slower one


def slow_reaches(field: Field, horizon: float) -> list[tuple[float, np.ndarray]]:
    """Return the horizon [s] and then the times [s] of all slower rates, with the sizes that are reached by then."""
    with mpmath.workdps(_DIGITS):
        rates = mpmath.eig(field.reduced()[0], left=False, right=False)
        least = _SAME * max(abs(rate) for rate in rates)
        times = [horizon, *(1 / abs(rate) for rate in rates if least < abs(rate) < 1 / mpmath.mpf(horizon))]
    return [(float(time), reached(field, float(time)).sizes) for time in sorted(times)]


def reached(field: Field, horizon: float) -> Field:
    """Return the field with the sizes that its coordinates reach within a time ``horizon`` [s]."""
    with mpmath.workdps(_DIGITS):
        matrix, push, sizes = field.reduced()
        most = [mpmath.mpf(1)] * len(sizes)
        for state in _reached_states(homogeneous(matrix, push, sizes), horizon):
            most = [max(known, sum(map(abs, state[i, :]))) for i, known in enumerate(most)]
        wider = field.sizes.copy()
        for i, place in enumerate(field.alive):
            wider[place] *= float(most[i])
    return replace(field, sizes=wider)


def _reached_states(matrix, horizon: float):
    """Yield matrices that make of a start the states that it reaches before the horizon [s], by gaps in the rates."""
    rates = sorted([*mpmath.eig(matrix[:-1, :-1], left=False, right=False), mpmath.mpf(0)], key=abs)
    least = max(1 / mpmath.mpf(horizon), _SAME * mpmath.mnorm(matrix, mpmath.inf))
    gaps = [k for k in range(1, len(rates)) if abs(rates[k]) > max(_GAP * abs(rates[k - 1]), least)]
    for first, last in zip([0, *gaps], [*gaps, len(rates)], strict=True):
        slow, group, fast = rates[:first], rates[first:last], rates[last:]
        try:
            if fast:
                part = _part_of(matrix, slow + group, fast)
                yield part.out * part.into
            if abs(group[-1]) > least:
                part = _part_of(matrix, group, slow + fast)
                yield part.out * part.matrix * part.into / abs(group[-1])
            elif horizon < math.inf:
                part = _part_of(matrix, group, slow + fast)
                yield part.out * mpmath.expm(part.matrix * horizon) * part.into
        except ZeroDivisionError:  # no digit is left of this projector, so nothing is told from it
            continue


class _Part(NamedTuple):
    """The part of a matrix that belongs to a group of rates: rows that lead into it, columns that lead back."""

    matrix: mpmath.matrix  # (d, d)
    into: mpmath.matrix  # (d, p + 1), of coordinates in units of their sizes
    out: mpmath.matrix  # (p + 1, d)


def _part_of(matrix, group, others) -> _Part:
    """Return the part of a group of rates of a matrix (p + 1, p + 1), in the digits of the context.

    The product of the factors of all other rates spans the invariant subspaces of the group, whatever chains it has.
    Raises ``ZeroDivisionError`` if the digits leave none of it.
    """
    product = mpmath.eye(matrix.rows)
    for rate in others:
        factor = matrix - rate * mpmath.eye(matrix.rows)
        product = product * (factor / mpmath.mnorm(factor, mpmath.inf))
    product = product.apply(mpmath.re)
    columns, rows = _basis(product, len(group)), _basis(product.T, len(group)).T
    rows = (rows * columns) ** -1 * rows
    return _Part(rows * matrix * columns, rows, columns)


def _basis(matrix, count: int) -> mpmath.matrix:
    """Orthonormal basis of the space that the columns of a matrix of rank ``count`` span, the longest ones first."""
    left = [matrix[:, j] for j in range(matrix.cols)]
    found = mpmath.zeros(matrix.rows, count)
    for k in range(count):
        longest = max(left, key=mpmath.norm)
        unit = longest / mpmath.norm(longest)
        found[:, k] = unit
        left = [column - unit * (unit.T * column)[0] for column in left]
    return found
