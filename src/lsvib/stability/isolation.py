"""All roots of a function of one positive number between two ends, each isolated with certainty, in balls.

Where the sliding speed changes, an exponential of it is in the equations, so that they are no polynomials. On a box of
the half-width r about its middle m the function is a Taylor polynomial of h = x − m, |h| <= r, whose coefficients are
those of m, but for the last one, which is that of the whole box. Where this holds no zero there is no root; where its
derivative has none there is one exactly if the ends of the box differ in sign; other boxes are halved.
"""

from collections.abc import Callable
from typing import Any

from flint import arb, arb_poly, arb_series, fmpq

from lsvib.errors import NoThreshold
from lsvib.stability.solve import bracketed_root

_ORDER = 12  # of the polynomial: next to a double root, or where large terms cancel, boxes may still be wide
_MOST = 4000  # boxes, some seconds
_CLOSE = 1e-29  # relative error of a root

Function = Callable[[Any], Any]
"""A function of a ball or a power series; it returns a number of the same kind, or a constant."""


def isolated_roots(function: Function, low: fmpq, high: fmpq) -> list[fmpq] | None:
    """Return all roots between ``low`` > 0 and ``high``, ascending; None if the function does not depend on x.

    To be called with many digits. Raises ``NoThreshold`` where they cannot be told apart.
    """

    def value(x: Any) -> arb:
        return arb(function(arb(x)))

    span = (arb(high) / arb(low)).log()
    if all(_series(function, (arb(low) * (span * n / 64).exp()).mid(), 1)[1].contains(0) for n in range(65)):
        return None
    boxes, start, roots = [], low, []
    while start < high:
        boxes.append((start, min(2 * start, high)))
        start = 2 * start
    boxes.reverse()
    for _ in range(_MOST):
        if not boxes:
            return roots
        a, b = boxes.pop()
        if not value(_box(a, b)).contains(0):  # as where all terms have one sign
            continue
        whole, slope = _over(function, a, b)
        if not whole.contains(0):
            continue
        if not slope.contains(0):
            ends = value(a) * value(b)
            if ends < 0:
                roots.append(arb(bracketed_root(value, arb(a), arb(b), _CLOSE)).mid().fmpq())
            if ends != 0:  # for certain
                continue
        boxes += [((a + b) / 2, b), (a, (a + b) / 2)]
    raise NoThreshold("two roots of an equation of the threshold lie too close together to be told apart.")


def _series(function: Function, x: arb, order: int) -> list[arb]:
    """The Taylor coefficients at a ball, up to an order."""
    found = arb_series(function(arb_series([x, 1], prec=order + 1)), prec=order + 1)
    return [found[k] for k in range(order + 1)]


def _box(a: fmpq, b: fmpq) -> arb:
    middle = arb((a + b) / 2)
    return arb(middle.mid(), arb((b - a) / 2).abs_upper() + middle.rad())


def _over(function: Function, a: fmpq, b: fmpq) -> tuple[arb, arb]:
    """Enclosures of the values and of the derivative between two numbers."""
    terms = [*_series(function, arb((a + b) / 2), _ORDER - 1), _series(function, _box(a, b), _ORDER)[-1]]
    h, polynomial = arb(0, arb((b - a) / 2).abs_upper()), arb_poly(terms)
    return polynomial(h), polynomial.derivative()(h)
