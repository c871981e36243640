"""Arrays of numbers in about 32 digits, each with a bound of its error: the tables of many drives at once.

A number is a pair of doubles, leading part and rest (Dekker 1971; Joldes, Muller and Popescu, "Tight and rigorous error
bounds for basic building blocks of double-word arithmetic", 2017), and carries a bound of its error. Formulas written
for one number as ``Decimal`` serve arrays of such pairs as they stand:

* Rounded to double, an entry must be the same wherever in its bound the number lies (Ziv's test). The formulas in 50
  digits, whose own error is far below the bound, then round to the same double. An entry that fails the test is
  *unsafe*.
* A comparison must come out the same for all entries, so that a formula may branch; else it raises :class:`Divided`,
  and the caller (:func:`in_groups`) does the parts on their own. An entry whose bound does not decide it is unsafe.

Nothing is said about unsafe entries; the caller does them in 50 digits, one by one. They are few: at 32 digits a double
is unsafe only if two dozen digits of it cancel, or by a chance of 1e-11.
"""

from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")

_SPLIT = 134217729.0  # 2^27 + 1 cuts a double into two halves of 26 digits
# Error of one operation; proved are at most 15 · 2^-106, and the rest pays for rounding the bound.
_RELATIVE = 2.0**-100
_UP = 1.0 + 2.0**-40  # factor that pays for rounding of bounds that are sums
_UNDERFLOW = 1e-290  # error of a product of which parts may have underflown; they are below 1e-320
_REST = 2.0**-104  # of a leading part, more than the rounding of "rest ± bound"


class Divided(Exception):
    """A comparison comes out True for the entries in ``holds`` and False for the others."""

    def __init__(self, holds: np.ndarray) -> None:
        super().__init__("a comparison of many numbers does not come out the same for all of them")
        self.holds = holds


class Undecided(Exception):
    """No entry is safe any more."""


class Pairs:
    """Numbers (k) with arithmetic, comparisons and roots, as ``Decimal`` has them.

    ``high`` and ``low`` (k) add up to the number, ``bound`` (k) is that of its error; ``unsafe`` (k) is shared by all
    numbers that are formed from each other.
    """

    __slots__ = ("bound", "high", "low", "unsafe")
    __array_ufunc__ = None  # an array of doubles leaves its operations with pairs to these
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, high: np.ndarray, low: Any, bound: Any, unsafe: np.ndarray) -> None:
        self.high, self.low, self.bound, self.unsafe = high, low, bound, unsafe

    @classmethod
    def exactly(cls, values: np.ndarray, unsafe: np.ndarray) -> "Pairs":
        """Return doubles (k) as what they are."""
        values = np.asarray(values, dtype=float)
        return cls(values, np.zeros_like(values), np.zeros_like(values), unsafe)

    def at(self, entries: np.ndarray, unsafe: np.ndarray) -> "Pairs":
        """Return some of the numbers, by their indices (j), with an own record of what is unsafe (j)."""
        return Pairs(self.high[entries], self.low[entries], self.bound[entries], unsafe)

    def rounded(self) -> np.ndarray:
        """Return the numbers as doubles (k), each rounded once; records those that are unsafe."""
        slack = self.bound + np.abs(self.high) * _REST
        surely = (self.high + (self.low - slack) == self.high) & (self.high + (self.low + slack) == self.high)
        self.unsafe |= ~(surely & np.isfinite(self.high))
        return self.high

    def sqrt(self, context: Any = None) -> "Pairs":
        """Return the square roots; ``context`` is that of ``Decimal.sqrt`` and has no effect."""
        root = np.sqrt(self.high)
        square, rest = rounded_product(root, root)
        correction = ((self.high - square) - rest + self.low) / (2.0 * np.where(root == 0.0, 1.0, root))
        high, low = _quick_sum(root, correction)
        zero = (self.high == 0.0) & (self.bound == 0.0)
        lowest = np.where(zero, 1.0, self.high - 2.0 * self.bound)
        bound = self.bound / np.sqrt(lowest) * _UP + np.abs(high) * _RELATIVE + _UNDERFLOW
        return Pairs(high, low, np.where(zero, 0.0, bound), self.unsafe)

    def copy_sign(self, other: "Pairs") -> "Pairs":
        """Return the magnitudes with the signs of other numbers."""
        turned = np.where((self.high < 0) != (other._signs() < 0), -1.0, 1.0)
        return Pairs(turned * self.high, turned * self.low, self.bound, self.unsafe)

    def __neg__(self) -> "Pairs":
        return Pairs(-self.high, -self.low, self.bound, self.unsafe)

    def __abs__(self) -> "Pairs":
        turned = np.where(self.high < 0, -1.0, 1.0)
        return Pairs(turned * self.high, turned * self.low, self.bound, self.unsafe)

    def __add__(self, other: Any) -> "Pairs":
        a, b, bound = _parts(other)
        s, t = _add(self.high, self.low, a, b)
        return Pairs(s, t, (self.bound + bound) * _UP + np.abs(s) * _RELATIVE, self.unsafe)

    __radd__ = __add__

    def __sub__(self, other: Any) -> "Pairs":
        if other is self:  # zero, and no bound of errors can make it anything else
            return Pairs.exactly(np.zeros_like(self.high), self.unsafe)
        return self + (-other)

    def __rsub__(self, other: Any) -> "Pairs":
        return -self + other

    def __mul__(self, other: Any) -> "Pairs":
        if isinstance(other, int) and other in (1, -1):
            return -self if other < 0 else self
        a, b, bound = _parts(other)
        high, low = _multiply(self.high, self.low, a, b)
        return Pairs(high, low, self._bound_of_product(high, a, bound), self.unsafe)

    __rmul__ = __mul__

    def _bound_of_product(self, high: np.ndarray, a: Any, bound: Any) -> np.ndarray:
        carried = (np.abs(self.high) * bound + np.abs(a) * self.bound) * _UP + self.bound * bound
        if np.all(self.high) and np.all(a):
            return carried + np.abs(high) * _RELATIVE + _UNDERFLOW
        zero = ((self.high == 0.0) & (self.bound == 0.0)) | ((a == 0.0) & (bound == 0.0))
        return np.where(zero, 0.0, carried + np.abs(high) * _RELATIVE + _UNDERFLOW)

    def __pow__(self, power: int) -> "Pairs":
        if power != 2:
            raise ValueError("of the powers only the square is needed")
        return self * self

    def __truediv__(self, other: Any) -> "Pairs":
        return _quotient((self.high, self.low, self.bound), _parts(other), self.unsafe)

    def __rtruediv__(self, other: Any) -> "Pairs":
        return _quotient(_parts(other), _parts(self), self.unsafe)

    def _signs(self) -> np.ndarray:
        """Signs (k); records those that the bound does not decide."""
        zero = (self.high == 0.0) & (self.bound == 0.0)
        self.unsafe |= ~((np.abs(self.high) > 2.0 * self.bound) | zero)
        return np.sign(self.high)

    def _all(self, holds: np.ndarray) -> bool:
        """The outcome of a comparison for the entries that are safe; raises :class:`Divided`, :class:`Undecided`."""
        some = holds[~self.unsafe]
        if not some.size:
            raise Undecided
        if some.any() and not some.all():
            raise Divided(holds)
        return bool(some[0])

    def __bool__(self) -> bool:
        return self._all(self._signs() != 0)

    def __lt__(self, other: Any) -> bool:
        return self._all((self - other)._signs() < 0)

    def __le__(self, other: Any) -> bool:
        return self._all((self - other)._signs() <= 0)

    def __gt__(self, other: Any) -> bool:
        return self._all((self - other)._signs() > 0)

    def __ge__(self, other: Any) -> bool:
        return self._all((self - other)._signs() >= 0)

    def __eq__(self, other: object) -> bool:
        return self._all((self - other)._signs() == 0)


def exactly(number: Any) -> Any:
    """Return a number in the arithmetic of the exact tables: pairs as they are, any other as a ``Decimal``."""
    return number if isinstance(number, Pairs) else Decimal(number)


def double(number: Any) -> Any:
    """Return a number rounded to double once; of pairs, or of an array of doubles, an array."""
    if isinstance(number, Pairs):
        return number.rounded()
    return number if isinstance(number, np.ndarray) else float(number)


def doubles(numbers: Sequence[Any], shape: tuple[int, ...]) -> np.ndarray:
    """Return numbers, in a flat list, as a table of doubles; of pairs one for each entry, along the first axis."""
    if not {Pairs, np.ndarray} & set(map(type, numbers)):  # one drive, by far the most frequent
        return np.array([*map(float, numbers)]).reshape(shape)
    rounded = [double(number) for number in numbers]
    sizes = {x.size for x in rounded if isinstance(x, np.ndarray)}
    if not sizes:
        return np.array(rounded, dtype=float).reshape(shape)
    (size,) = sizes
    found = np.empty((size, len(rounded)))
    for k, column in enumerate(rounded):
        found[:, k] = column
    return found.reshape(size, *shape)


def in_groups(size: int, make: Callable[[np.ndarray], T]) -> Iterator[tuple[np.ndarray, T]]:
    """Yield groups of entries, as indices below ``size`` (j), and what ``make`` returns for each of them.

    A group for which a comparison does not come out the same for all entries is divided; one without safe entries is
    left out.
    """
    groups = [np.arange(size)]
    while groups:
        group = groups.pop()
        try:
            with np.errstate(all="ignore"):  # what overflows or divides by zero is unsafe
                made = make(group)
        except Divided as parts:
            groups += [group[~parts.holds], group[parts.holds]]
        except Undecided:
            continue
        else:
            yield group, made


def _parts(number: Any) -> tuple[Any, Any, Any]:
    """Leading part, rest and bound of the error of a number."""
    if isinstance(number, Pairs):
        return number.high, number.low, number.bound
    high = float(number)
    low = float(Decimal(number) - Decimal(high))
    return high, low, abs(high) * _RELATIVE if low else 0.0


def _sum(a: Any, b: Any) -> tuple[Any, Any]:
    """a + b and its rounding."""
    s = a + b
    z = s - a
    return s, (a - (s - z)) + (b - z)


def _quick_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """a + b and its rounding, for |a| ≥ |b|."""
    s = a + b
    return s, b - (s - a)


def rounded_product(a: Any, b: Any) -> tuple[Any, Any]:
    """Return the rounded product of doubles and what its rounding has cut off, by Dekker's splitting (1971)."""
    p = a * b
    t = _SPLIT * a
    a1 = t - (t - a)
    a2 = a - a1
    t = _SPLIT * b
    b1 = t - (t - b)
    b2 = b - b1
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


def _add(a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any]:
    """(a + b) + (c + d)."""
    s, t = _sum(a, c)
    v, w = _sum(b, d)
    s, t = _quick_sum(s, t + v)
    return _quick_sum(s, t + w)


def _multiply(a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any]:
    """(a + b) (c + d)."""
    p, e = rounded_product(a, c)
    return _quick_sum(p, e + (a * d + b * c))


def _quotient(above: tuple[Any, Any, Any], below: tuple[Any, Any, Any], unsafe: np.ndarray) -> Pairs:
    """Quotient of numbers as :func:`_parts` has them, by long division in three doubles."""
    (a, b, bound), (c, d, bound_below) = above, below
    left, digits = (a, b), []
    for _ in range(3):
        digits.append(left[0] / c)
        high, low = _multiply(digits[-1], 0.0, c, d)
        left = _add(*left, -high, -low)
    high, low = _add(*_quick_sum(digits[0], digits[1]), digits[2], 0.0)
    size = np.abs(c)
    carried = (bound + np.abs(high) * bound_below) / (size - 2.0 * bound_below)
    zero = (a == 0.0) & (bound == 0.0)
    bound = np.where(zero, 0.0, carried * _UP + np.abs(high) * _RELATIVE + _UNDERFLOW * (1.0 + 1.0 / size))
    return Pairs(high, low, np.where(size > 2.0 * bound_below, bound, np.inf), unsafe)
