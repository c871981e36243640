"""All roots of a function of one positive number between two ends, each isolated with certainty, in balls.

Where the sliding speed changes, an exponential of it is in the equations, so that they are no polynomials. On a box, a
ball about its middle m, the values lie within f(m) + f′(box) (box − m). Where that holds no zero there is no root;
where f′ has none there is one exactly if the ends differ in sign; other boxes are halved.
"""

from collections.abc import Callable
from typing import Any

from flint import arb, arb_series, fmpq

from lsvib.errors import NoThreshold
from lsvib.stability.solve import bracketed_root

_MOST = 30_000  # boxes, some seconds
_CLOSE = 1e-29  # relative error of a root

Function = Callable[[Any], Any]
"""A function of a ball or a power series of two terms; it returns a number of the same kind, or a constant."""


def isolated_roots(function: Function, low: fmpq, high: fmpq) -> list[fmpq] | None:
    """Return all roots between ``low`` > 0 and ``high``, ascending; None if the function does not depend on x.

    To be called with many digits. Raises ``NoThreshold`` where they cannot be told apart.
    """

    def linear(x: arb) -> tuple[arb, arb]:
        """Return the value and the derivative."""
        series = arb_series(function(arb_series([x, 1], prec=2)), prec=2)
        return series[0], series[1]

    def value(x: Any) -> arb:
        return arb(function(arb(x)))

    span = (arb(high) / arb(low)).log()
    if all(linear((arb(low) * (span * n / 64).exp()).mid())[1].contains(0) for n in range(65)):
        return None
    boxes, waiting, roots = [], low, []
    while waiting < high:
        boxes.append((waiting, min(2 * waiting, high)))
        waiting = 2 * waiting
    boxes.reverse()
    for _ in range(_MOST):
        if not boxes:
            return roots
        a, b = boxes.pop()
        middle = (a + b) / 2
        half = arb((b - a) / 2)
        slope = linear(arb(arb(middle).mid(), half.abs_upper()))[1]
        if not (value(middle) + slope * arb(0, half.abs_upper())).contains(0):
            continue
        if not slope.contains(0):
            before, after = value(a), value(b)
            if (before > 0 and after < 0) or (before < 0 and after > 0):
                roots.append(arb(bracketed_root(value, arb(a), arb(b), _CLOSE)).mid().fmpq())
                continue
            if (before > 0 and after > 0) or (before < 0 and after < 0):
                continue
        boxes += [(middle, b), (a, middle)]
    raise NoThreshold("two roots of an equation of the threshold lie too close together to be told apart.")
