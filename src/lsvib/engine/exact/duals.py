r"""Numbers that carry their exact derivatives (forward differentiation), in many digits.

An equation that is written once, in plain arithmetic, gives its value and its gradient when it is handed such numbers:
(a, a′) · (b, b′) = (a b, a′ b + a b′), and so on for every operation. No difference quotient is taken anywhere.
"""

from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

from mpmath import MPContext  # type: ignore[import-untyped]  # it has no types

DIGITS = 70  # the coefficients of a drive lose up to 50 digits where they cancel; 20 are left
many: Any = MPContext()  # an own context: the precision of the global one belongs to the caller
many.dps = DIGITS
_SERIES = 12  # terms of a power series that is used below _SMALL: the next one is below 1e-90
_SMALL = 1e-6  # of √z: closed forms lose twelve of the 70 digits there, a series none


class Dual:
    """A number ``value`` with its derivatives ``slopes`` (n), all of many digits."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: Any, slopes: Sequence[Any]) -> None:
        self.value, self.slopes = value, tuple(slopes)

    def _with(self, other: Any, value: Any, here: Any, there: Any) -> "Dual":
        """Return the result of an operation: its value, and its derivatives by both operands."""
        if not isinstance(other, Dual):
            return Dual(value, [here * a for a in self.slopes])
        return Dual(value, [here * a + there * b for a, b in zip(self.slopes, other.slopes, strict=True)])

    def __add__(self, other: Any) -> "Dual":
        return self._with(other, self.value + _plain(other), 1, 1)

    def __sub__(self, other: Any) -> "Dual":
        return self._with(other, self.value - _plain(other), 1, -1)

    def __rsub__(self, other: Any) -> "Dual":
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> "Dual":
        there = _plain(other)
        return self._with(other, self.value * there, there, self.value)

    def __truediv__(self, other: Any) -> "Dual":
        there = _plain(other)
        ratio = self.value / there
        return self._with(other, ratio, 1 / there, -ratio / there)

    def __rtruediv__(self, other: Any) -> "Dual":
        ratio = _plain(other) / self.value
        return Dual(ratio, [-ratio / self.value * a for a in self.slopes])

    def __neg__(self) -> "Dual":
        return Dual(-self.value, [-a for a in self.slopes])

    def __pow__(self, power: int) -> "Dual":
        slope = power * self.value ** (power - 1)
        return Dual(self.value**power, [slope * a for a in self.slopes])

    __radd__, __rmul__ = __add__, __mul__

    def through(self, value: Any, slope: Any) -> "Dual":
        """Return a function of this number that has a ``value`` and a ``slope`` here."""
        return Dual(value, [slope * a for a in self.slopes])


def number(value: Any) -> Any:
    """Return a plain number – int, float, fraction, decimal – with many digits."""
    if isinstance(value, Fraction):
        return many.mpf(value.numerator) / value.denominator
    return many.mpf(str(value) if isinstance(value, Decimal) else value)


def variables(values: Sequence[Any]) -> list[Dual]:
    """Return independent variables with given values (n): each has the derivative 1 by itself."""
    zero, one = many.mpf(0), many.mpf(1)
    return [
        Dual(number(value), [one if i == k else zero for i in range(len(values))]) for k, value in enumerate(values)
    ]


def _plain(value: Any) -> Any:
    return value.value if isinstance(value, Dual) else number(value)


def exponential(x: Dual) -> Dual:
    """Return e^x."""
    value = many.exp(x.value)
    return x.through(value, value)


def tangent(x: Dual) -> Dual:
    """Return tan x."""
    value = many.tan(x.value)
    return x.through(value, 1 + value**2)


def cosine_of_root(z: Dual) -> Dual:
    """Return cos √z, which is cosh √−z for negative z; smooth through zero."""
    return z.through(_cosine(z.value), -_ratio(z.value) / 2)


def sine_ratio_of_root(z: Dual) -> Dual:
    """Return sin √z / √z, which is sinh √−z / √−z for negative z; smooth through zero."""
    here = z.value
    if abs(here) < _SMALL**2:
        slope = _series(here, lambda n: (-1) ** (n + 1) * many.mpf(n + 1) / many.factorial(2 * n + 3))
    else:
        slope = (_cosine(here) - _ratio(here)) / (2 * here)
    return z.through(_ratio(here), slope)


def _cosine(z: Any) -> Any:
    return many.cos(many.sqrt(z)) if z >= 0 else many.cosh(many.sqrt(-z))


def _ratio(z: Any) -> Any:
    if abs(z) < _SMALL**2:
        return _series(z, lambda n: (-1) ** n / many.factorial(2 * n + 1))
    root = many.sqrt(abs(z))
    return (many.sin(root) if z > 0 else many.sinh(root)) / root


def _series(z: Any, term: Callable[[int], Any]) -> Any:
    return many.fsum(term(n) * z**n for n in range(_SERIES))
