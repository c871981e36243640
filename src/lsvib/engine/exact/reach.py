r"""How far the coordinates of a mode get in a motion that starts with the sizes that a model calls typical.

A model can only guess the size of, say, the mismatch of its threads; where rates lie many decades apart the motion
soon takes a coordinate far beyond the guess, and digits that only the guess would miss are not missed. With Π_k the
projector on the k slowest rates of the homogeneous field of (x, 1), the state is Π_k (x, 1) once all faster ones have
died away (or, if they do not, within half a turn of them). So the size that a coordinate has in the motion is

    x* = max( x, |Π_k| (x, 1) ),      over all k for which that is so before the horizon.

Rates next to each other (``_GAP``) and rates slower than the horizon cannot be told apart in this way.
"""

from dataclasses import replace

import mpmath

from lsvib.engine.exact.block_form import block_of
from lsvib.engine.exact.field import Field

_DIGITS = 150  # rates thirty decades apart, in a product of four differences, leave 30
SWINGS = 100  # of the coupling: what a motion does not show in that time is not taken for granted
_SAME = mpmath.mpf(10) ** -35  # relative size of a rate that only rounding of the coefficients parts from zero
_GAP = 4.0  # from one rate to the next faster one that outlives it: e⁻⁴ is left of it after a unit of the slower one's


def reached(field: Field, horizon: float) -> Field:
    """Return the field with the sizes that its coordinates reach within a time ``horizon`` [s]."""
    with mpmath.workdps(_DIGITS):
        matrix, push, sizes = field.reduced()
        n = len(sizes)
        extended = mpmath.zeros(n + 1)
        for i in range(n):
            for j in range(n):
                extended[i, j] = matrix[i, j] * sizes[j] / sizes[i]
            extended[i, n] = push[i] / sizes[i]
        most = [mpmath.mpf(1)] * n
        for projector in _slow_projectors(extended, horizon):
            for i in range(n):
                most[i] = max(most[i], sum(abs(projector[i, j]) for j in range(n + 1)))
        wider = field.sizes.copy()
        for i, place in enumerate(field.alive):
            wider[place] *= float(most[i])
    return replace(field, sizes=wider)


def _slow_projectors(matrix, horizon: float):
    """Yield the projectors on the slowest rates, for each gap in the rates that shows before the horizon [s]."""
    rates = sorted([*mpmath.eig(matrix[:-1, :-1], left=False, right=False), mpmath.mpf(0)], key=abs)
    least = max(1 / mpmath.mpf(horizon), _SAME * mpmath.mnorm(matrix, mpmath.inf))
    for k in range(1, len(rates)):
        slow, fast = rates[:k], rates[k:]
        if abs(fast[0]) > max(_GAP * abs(slow[-1]), least):
            block = block_of(matrix, slow, fast)
            yield block.out * block.into
