"""The rates of one mode of many drives, enclosed, and which of them are carried together.

Rates come from doubles by Newton's method: a disc of radius n |p / p′| around any number holds a root of a polynomial p
of degree n, and it holds just one if it is far from all others.
"""

from functools import cache
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np

from lsvib.engine.exact.factors import APART, SLOW
from lsvib.engine.exact.pair_arrays import Pairs
from lsvib.engine.exact.pair_matrices import Matrix, high, is_zero, summed, times

_NEWTONS = 5  # steps; each doubles the digits of a rate, of which LAPACK leaves three at least
_SEPARATE = 1e-10  # relative distance of two rates from which on they count as simple: half of their digits are left
_ZERO_RATE = 1e-20  # a rate that is smaller, relative to the largest one, may be rounding of zero
CLEAR = 1e-9  # relative distance of two doubles, of rounding 1e-15 and some digits, whose order is certain


class Rates(NamedTuple):
    """Rates that are not zero: real and imaginary parts of up to n, and how many zeros there are by structure.

    ``parts[j]`` are two ``Pairs`` (k); the imaginary part is exactly zero where the rate is real.
    """

    parts: list[tuple[Pairs, Pairs]]
    zeros: int

    def at(self, members: np.ndarray, unsafe: np.ndarray) -> "Rates":
        """Return the rates of some drives (j, indices), with a record of what is unsafe of its own."""
        return Rates([(x.at(members, unsafe), y.at(members, unsafe)) for x, y in self.parts], self.zeros)

    def doubles(self) -> np.ndarray:
        """Return the rates (k, n) as complex doubles."""
        return np.stack([x.high + 1j * y.high for x, y in self.parts], axis=1)


def rates_of(matrix: Matrix, unsafe: np.ndarray) -> Rates:
    """Return the rates of A, the upper of two complex ones before the lower, as LAPACK has them; marks what is unsafe.

    A row of zeros is a rate of zero; no other rate may be zero.
    """
    n = len(matrix)
    moving = [i for i in range(n) if not all(map(is_zero, matrix[i]))]
    inner = [[matrix[i][j] for j in moving] for i in moving]
    table = np.stack([np.stack([high(x, unsafe.size) for x in row], axis=-1) for row in inner], axis=-2)
    unsafe |= ~np.isfinite(table).all(axis=(1, 2))
    table[unsafe] = np.eye(len(moving))
    start = np.linalg.eigvals(table).astype(complex)
    coefficients = _characteristic(inner, unsafe)
    parts = [_enclosed(coefficients, start[:, j], unsafe) for j in range(len(moving))]
    rates = Rates(parts, n - len(moving))
    values = rates.doubles()
    size = np.abs(values)
    unsafe |= ~(size > _ZERO_RATE * size.max(axis=1, keepdims=True)).all(axis=1)
    for i, j in combinations(range(len(moving)), 2):
        distance = np.abs(values[:, i] - values[:, j])
        radius = parts[i][0].bound + parts[j][0].bound
        unsafe |= ~((distance > _SEPARATE * (size[:, i] + size[:, j])) & (distance > 4.0 * radius))
    return rates


def _characteristic(matrix: Matrix, unsafe: np.ndarray) -> list[Any]:
    """Coefficients of det(s − A), from the highest power, by principal minors."""
    n = len(matrix)

    @cache
    def minor(rows: tuple[int, ...], cols: tuple[int, ...]) -> Any:
        """Return a minor, expanded along its first row."""
        if not rows:
            return 1
        terms = []
        for place, column in enumerate(cols):
            x = matrix[rows[0]][column]
            if is_zero(x):
                continue
            rest = times(x, minor(rows[1:], (*cols[:place], *cols[place + 1 :])))
            terms.append(-rest if place % 2 else rest)
        return summed(terms)

    found: list[Any] = [1]
    for order in range(1, n + 1):
        total = summed([minor(chosen, chosen) for chosen in combinations(range(n), order)])
        found.append(-total if order % 2 else total)
    return [x if isinstance(x, Pairs) else Pairs.exactly(np.full(unsafe.size, float(x)), unsafe) for x in found]


def _enclosed(coefficients: list[Pairs], start: np.ndarray, unsafe: np.ndarray) -> tuple[Pairs, Pairs]:
    """Improve a root (k) of a polynomial, real where its imaginary part is zero, and enclose it."""
    size = len(coefficients) - 1
    derivative = [(size - j) * x.high for j, x in enumerate(coefficients[:-1])]
    x, y = Pairs.exactly(start.real.copy(), unsafe), Pairs.exactly(start.imag.copy(), unsafe)
    real = start.imag == 0.0
    for _ in range(_NEWTONS):
        up, across = _at(coefficients, x, y)
        z = x.high + 1j * y.high
        slope = np.zeros_like(z)
        for one in derivative:
            slope = slope * z + one
        step = (up.high + 1j * across.high) / slope
        x, y = _moved(x, step.real, unsafe), _moved(y, np.where(real, 0.0, step.imag), unsafe)
    up, across = _at(coefficients, x, y)
    steep, turned = _at([x * (size - j) for j, x in enumerate(coefficients[:-1])], x, y)
    value = np.abs(up.high) + up.bound + np.abs(across.high) + across.bound
    slope = np.maximum(np.abs(steep.high), np.abs(turned.high)) - (steep.bound + turned.bound)
    radius = np.where(slope > 0, 1.001 * size * value / slope, np.inf)  # 1.001 pays for the rounding of doubles
    return Pairs(x.high, x.low, radius, unsafe), Pairs(y.high, y.low, np.where(real, 0.0, radius), unsafe)


def _moved(x: Pairs, step: np.ndarray, unsafe: np.ndarray) -> Pairs:
    """Return x − step as numbers that are what they are."""
    there = x - Pairs.exactly(step, unsafe)
    return Pairs(there.high, there.low, np.zeros_like(there.high), unsafe)


def _at(coefficients: list[Pairs], x: Pairs, y: Pairs) -> tuple[Pairs, Pairs]:
    """Real and imaginary part of a polynomial at x + i y."""
    real, imaginary = coefficients[0], coefficients[0] * 0
    for one in coefficients[1:]:
        real, imaginary = real * x - imaginary * y + one, real * y + imaginary * x
    return real, imaginary


class Pattern(NamedTuple):
    """Which rates make which factors, by their places among the rates: upper ones of complex pairs, pairs of real ones,
    single ones; and which of the single ones are slow."""

    upper: tuple[int, ...]
    together: tuple[tuple[int, int], ...]
    alone: tuple[int, ...]
    slow: tuple[bool, ...]


def patterns_of(rates: Rates) -> list[Pattern | None]:
    """Return how the rates of each drive (k) are taken together; None where it is unsafe."""
    unsafe, values = rates.parts[0][0].unsafe, rates.doubles()
    return [None if bad else _pattern(row) for bad, row in zip(unsafe.tolist(), values.tolist(), strict=True)]


def _pattern(rates: list[complex]) -> Pattern | None:
    upper = tuple(j for j, rate in enumerate(rates) if rate.imag > 0)
    real = sorted((j for j, rate in enumerate(rates) if rate.imag == 0), key=lambda j: -rates[j].real)
    if 2 * len(upper) + len(real) != len(rates):
        return None
    together, sizes = [], [abs(rate) for rate in rates]
    while len(real) > 1:
        gaps = [(rates[a].real - rates[b].real) / max(sizes[a], sizes[b]) for a, b in pairwise(real)]
        k = gaps.index(min(gaps))
        if any(i != k and abs(gap - gaps[k]) <= CLEAR for i, gap in enumerate(gaps)) or abs(gaps[k] - APART) < CLEAR:
            return None
        if gaps[k] > APART:
            break
        a, b = real.pop(k), real.pop(k)
        together.append((a, b))
    slow = []
    for j in real:
        if any(i != j and abs(size - sizes[j]) <= CLEAR * size for i, size in enumerate(sizes)):
            return None
        least = min((size for size in sizes if size > sizes[j]), default=0.0)
        if abs(least - SLOW * sizes[j]) <= CLEAR * least:
            return None
        slow.append(least > SLOW * sizes[j])
    return Pattern(upper, tuple(together), tuple(real), tuple(slow))
