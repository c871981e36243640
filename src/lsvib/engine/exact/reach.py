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
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from flint import acb, arb, arb_mat, fmpq_poly

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.exact.field import Field, balls, homogeneous, identity, rates_of, rational

SWINGS = 100  # swings of the coupling in a horizon; a size that takes longer to reach does not count
_NOTHING = 1e-35  # relative size of a rate that is zero but for the rounding of the coefficients
_GAP = 4.0  # ratio of two rates that are separated: e⁻⁴ of the faster part is left after a time unit of the slower one
_LEFT = 1e-6  # radius of an element of a projector, in sizes of the coordinates, that leaves it a size


def slow_reaches(field: Field, horizon: float) -> list[tuple[float, np.ndarray]]:
    """Return the horizon [s] and then the times [s] of all slower rates, with the sizes that are reached by then."""
    with many_digits():
        sizes = [float(abs(rate)) for rate in rates_of(balls(field.matrix()))]
    times = [horizon, *(1 / size for size in sizes if _NOTHING * max(sizes) < size < 1 / horizon)]
    return [(time, reached(field, time).sizes) for time in sorted(times)]


def reached(field: Field, horizon: float) -> Field:
    """Return the field with the sizes that its coordinates reach within a time ``horizon`` [s]."""
    with many_digits():
        most = np.ones(len(field.alive))
        for state in _reached_states(homogeneous(field), horizon):
            rows = np.abs(np.array([[float(x) for x in row] for row in state.tolist()]))
            most = np.maximum(most, rows[:-1].sum(axis=1))
    wider = field.sizes.copy()
    wider[field.alive] *= most
    return replace(field, sizes=wider)


def _reached_states(matrix: arb_mat, horizon: float) -> Iterator[arb_mat]:
    """Yield matrices that make of a start the states that it reaches before the horizon [s], by gaps in the rates."""
    rates = sorted(rates_of(matrix), key=_size)
    least = max(1 / horizon, _NOTHING * max(float(abs(x).upper()) for x in matrix.entries()))
    gaps = [k for k in range(1, len(rates)) if _size(rates[k]) > max(_GAP * _size(rates[k - 1]), least)]
    for first, last in zip([0, *gaps], [*gaps, len(rates)], strict=True):
        slow, group, fast = rates[:first], rates[first:last], rates[last:]
        if fast and (projector := _projector(matrix, slow + group, fast)) is not None:
            yield projector
        if (projector := _projector(matrix, group, slow + fast)) is None:
            continue
        if _size(group[-1]) > least:
            yield matrix * projector * (1 / abs(group[-1]))
        elif horizon < math.inf:
            yield (matrix * projector * arb(horizon)).exp() * projector


def _size(rate: acb) -> float:
    return float(abs(rate))


def _projector(matrix: arb_mat, group: list[acb], others: list[acb]) -> arb_mat | None:
    """Return the projector on the subspace of some rates, whatever chains they have; None if no digit is left of it.

    With the polynomials p and q of both parts and u p + v q = 1 it is v q of the matrix.
    """
    if not others:
        return identity(matrix.nrows())
    own, rest = _polynomial(group), _polynomial(others)
    common, _, inverse = own.xgcd(rest)
    if common.degree() > 0:
        return None
    found = arb_mat(matrix.nrows(), matrix.nrows())
    for coefficient in reversed((inverse * rest).coeffs()):
        found = found * matrix + identity(matrix.nrows()) * arb(coefficient)
    return found if max(float(x.rad()) for x in found.entries()) < _LEFT else None


def _polynomial(rates: list[acb]) -> fmpq_poly:
    """Return the real polynomial with these rates, those of a complex pair both among them."""
    found = fmpq_poly([1])
    for rate in rates:
        if float(rate.imag) > 0:
            found *= fmpq_poly([rational(abs(rate) ** 2), -2 * rational(rate.real), 1])
        elif float(rate.imag) == 0:
            found *= fmpq_poly([-rational(rate.real), 1])
    return found
