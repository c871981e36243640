"""The one exact arithmetic: balls of FLINT (Arb), a midpoint and a radius, and what formulas need of any number.

A formula that is written once serves balls (``flint.arb``), arrays of doubles, which hold the numbers of many systems,
and power series (``flint.arb_series``), which carry derivatives. It decides by :func:`sign` alone, which is certain.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import reduce
from threading import RLock
from typing import Any

import numpy as np
from flint import arb, arb_series, ctx

from lsvib.errors import EngineError

DIGITS = 150  # with rates thirty decades apart, a product of four of their differences leaves 30 digits

Number = Any  # arb, arb_series, an array of doubles, or a float or int
Row = Sequence[Number]  # an affine function of the state, the constant last
_precision = RLock()  # FLINT has one precision for all of a process


class Divided(Exception):
    """The signs of an array of numbers (k) are not all the same; ``signs`` (k)."""

    def __init__(self, signs: np.ndarray) -> None:
        super().__init__("a decision does not come out the same for all of many numbers")
        self.signs = signs


@contextmanager
def many_digits() -> Iterator[None]:
    """Compute with balls of ``DIGITS``; the precision outside belongs to the caller."""
    with _precision, ctx.workdps(DIGITS):
        yield


def alike(*numbers: Number) -> tuple[Number, ...]:
    """Return numbers of one formula as arrays or floats if one of them is an array, as balls or series else."""
    if any(isinstance(number, np.ndarray) for number in numbers):
        return tuple(number if isinstance(number, np.ndarray) else float(number) for number in numbers)
    return tuple(arb(number) if isinstance(number, (int, float, str)) else number for number in numbers)


def sign(number: Number, parameter: str = "a parameter") -> int:
    """Return the sign of a number, or the one that all entries of an array have.

    Raises ``EngineError``, which names the ``parameter`` to change, if a ball holds zero without being zero, and
    :class:`Divided` if the signs of an array differ.
    """
    if isinstance(number, np.ndarray):
        signs = np.sign(number)
        if signs.size and not (signs == signs.flat[0]).all():
            raise Divided(signs)
        return int(signs.flat[0]) if signs.size else 0
    value = number[0] if isinstance(number, arb_series) else number
    if value > 0:
        return 1
    if value < 0:
        return -1
    if value == 0:
        return 0
    raise EngineError(
        f"{DIGITS} digits do not determine on which side of a limit the system is; change {parameter} a little."
    )


def root(number: Number) -> Number:
    """Return the square root."""
    return np.sqrt(number) if isinstance(number, (np.ndarray, float, int)) else number.sqrt()


def real_rates(alpha: Number, square: Number, delta: Number) -> tuple[Number, Number]:
    """Return the real roots r₁ ≥ r₂ of r² + 2α r + square, with (r₁ − r₂) / 2 = delta, so that nothing cancels."""
    if sign(alpha) >= 0:
        large = -alpha - delta
        return (square / large if sign(large) else large), large
    large = delta - alpha
    return large, square / large


def exponential(number: Number) -> Number:
    """Return e to the power of a number."""
    return np.exp(number) if isinstance(number, (np.ndarray, float, int, complex)) else number.exp()


def double(number: Number) -> Any:
    """Return a number rounded to double once; an array of doubles as it is."""
    return number.astype(float, copy=False) if isinstance(number, np.ndarray) else float(number)


def doubles(numbers: Sequence[Number], shape: tuple[int, ...]) -> np.ndarray:
    """Return numbers, in a flat list, as a table of doubles; of arrays one for each entry, along the first axis."""
    if np.ndarray not in map(type, numbers):
        return np.array([*map(float, numbers)]).reshape(shape)
    columns = np.broadcast_arrays(*map(double, numbers))
    return np.stack(columns, axis=-1).reshape(columns[0].size, *shape)


def added(*terms: Number, least: float = 1e13) -> Number:
    """Return the sum of terms; those that cancel leave exactly zero, for tan λ is transcendental.

    A sum of arrays of which less than ``least`` roundings is left has lost digits that count, and is not a number; one
    of at most 256 roundings, which terms that are sums bring with them, is zero. Raises ``EngineError`` if too few
    digits are left of a ball that holds zero.
    """
    total, several = terms[0], False
    for term in terms[1:]:
        if term.__class__ is not int or term:  # what is not there is the integer zero
            several = total.__class__ is not int or bool(total)
            total = total + term if several else term
    if not several:
        return total
    if total.__class__ is arb and not (total > 0 or total < 0):
        if not total.is_exact() and total.rad() > 1e-40 * max(abs(arb(x)).mid() for x in terms):
            sign(total)  # too few digits are left to show that it is zero
        return 0
    if isinstance(total, np.ndarray):
        sizes = [np.abs(term) for term in terms if term.__class__ is not int or term]
        rounding, left = reduce(np.maximum, sizes) * np.finfo(total.dtype).eps, np.abs(total)
        lost = left < least * rounding
        if lost.any():
            total = np.where(lost, np.where(left <= 256 * rounding, 0, np.nan), total)
    return total


def place_of_largest(sizes: Sequence[Any]) -> int:
    """Return the place of the largest of some doubles, or arrays of them; raises :class:`Divided` if these differ."""
    if np.ndarray not in map(type, sizes):
        return max(range(len(sizes)), key=sizes.__getitem__)
    if ((most := np.ravel(np.argmax(np.broadcast_arrays(*sizes), axis=0))) != most[0]).any():
        raise Divided(most)
    return int(most[0])


def nothing(number: Number) -> bool:
    """Whether a number is exactly zero, or all of an array are."""
    return not number.any() if isinstance(number, np.ndarray) else bool(number == 0)


def multiplied(left: Sequence[Any], right: Sequence[Any]) -> list[Any]:
    """Return the product of two polynomials."""
    result: list[Any] = [0] * (len(left) + len(right) - 1)
    for i, x in enumerate(left):
        for j, y in enumerate(right):
            result[i + j] = result[i + j] + x * y  # arrays of different shapes broadcast
    return result
