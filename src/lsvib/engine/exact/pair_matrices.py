"""Matrices of numbers of many drives at once: pairs of doubles, or plain numbers where all drives have the same.

An integer zero is zero by the structure of the model, and whatever it multiplies costs nothing.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lsvib.engine.exact.pair_arrays import Pairs

Matrix = list[list[Any]]


def high(x: Any, size: int) -> np.ndarray:
    """Return the doubles (k) of a number, a new array."""
    return x.high.copy() if isinstance(x, Pairs) else np.full(size, float(x))


def is_zero(x: Any) -> bool:
    """Return whether a number is zero for every drive, by the structure of the model."""
    return not isinstance(x, Pairs) and not x


def plain(x: Any) -> Any:
    """Return a number as it is, or an integer zero if it is exactly zero for every drive."""
    if isinstance(x, Pairs):
        return x if x.high.any() or x.bound.any() else 0
    return x or 0


def times(x: Any, y: Any) -> Any:
    """Return a product, the integer zero if a factor is."""
    return 0 if is_zero(x) or is_zero(y) else x * y


def over(x: Any, y: Any) -> Any:
    """Return a quotient, the integer zero if the numerator is."""
    return 0 if is_zero(x) else x / y


def summed(terms: Sequence[Any]) -> Any:
    """Return a sum that leaves out what is zero by structure."""
    total: Any = 0
    for one in terms:
        if not is_zero(one):
            total = one if is_zero(total) else total + one
    return total


def dot(left: Sequence[Any], right: Sequence[Any]) -> Any:
    """Return the sum of the products of two rows."""
    return summed([times(x, y) for x, y in zip(left, right, strict=True)])


def product(left: Matrix, right: Matrix) -> Matrix:
    """Return the product of two matrices."""
    return [[dot(row, column) for column in zip(*right, strict=True)] for row in left]


def polynomial(coefficients: Sequence[Any], matrix: Matrix, square: Matrix) -> Matrix:
    """Return a polynomial of degree two at most, from the highest power, of a matrix."""
    *upper, last = coefficients
    powers = [square, matrix][2 - len(upper) :]
    n = len(matrix)
    return [
        [
            summed([*(times(a, power[i][j]) for a, power in zip(upper, powers, strict=True)), last if i == j else 0])
            for j in range(n)
        ]
        for i in range(n)
    ]


def picked(candidates: Sequence[Any], chosen: np.ndarray, unsafe: np.ndarray) -> Any:
    """Return for each drive one of several numbers, by its place (k)."""
    if all(map(is_zero, candidates)):
        return 0
    found = [np.zeros(unsafe.size) for _ in range(3)]
    for place, one in enumerate(candidates):
        here = chosen == place
        if not here.any():
            continue
        parts = (one.high, one.low, one.bound) if isinstance(one, Pairs) else (float(one), 0.0, 0.0)
        for mine, theirs in zip(found, parts, strict=True):
            mine[here] = theirs[here] if isinstance(theirs, np.ndarray) else theirs
    return Pairs(*found, unsafe)
