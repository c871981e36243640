"""The field x′ = A x + b of a mode in balls: its rates, and the subspaces of A.

The characteristic polynomial is split into factors of degree one or two, with a projector on the subspace of each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from flint import acb, arb, arb_mat, arb_poly, fmpq_poly

from lsvib.systems.exact.arithmetic import Row

WORST_CONDITION = 1e6  # rounding grows by so much at most: 1e-9 of the sizes of the coordinates
# Relative sizes that only the rounding of coefficients of 50 digits can have: of a rate, and of the distance of two
# rates, which is the root of that.
_NOTHING, _SAME = 1e-40, 1e-24
_LEFT = 1e-35  # of the terms of a product of projectors that is zero: rounding
SLOW = 10  # a single rate that is so many times smaller than all larger ones may have its equilibrium far away
APART = 0.25  # relative distance of two real rates from which on each is carried alone


@dataclass(frozen=True)
class Field:
    """The field of a mode.

    ``rows`` of A and b (n, n + 1), balls or floats; typical ``sizes`` of the coordinates (n); ``kept``, the
    coordinates that do not change in the mode, with their values.
    """

    rows: Sequence[Row]
    sizes: np.ndarray
    kept: Mapping[int, arb | float]

    @classmethod
    def of(cls, rows: Sequence[Row], sizes: Sequence[float], kept: Mapping[int, arb | float] | None = None) -> "Field":
        """Make a field; a size that has underflown is the least double."""
        positive = np.maximum(np.asarray(sizes, dtype=float), np.finfo(float).tiny)
        return cls(tuple(tuple(row) for row in rows), positive, dict(kept or {}))

    @property
    def alive(self) -> list[int]:
        """Return the coordinates that may change."""
        return [i for i in range(len(self.rows)) if i not in self.kept]

    def push(self) -> list[arb]:
        """Return b of the coordinates that may change, with the share of those that do not."""
        own = ((self.rows[i][-1], self.rows[i]) for i in self.alive)
        return [arb(last) + sum((arb(row[j]) * arb(x) for j, x in self.kept.items()), arb(0)) for last, row in own]

    def scale(self) -> list[float]:
        """Return the sizes of the coordinates that may change."""
        return [float(self.sizes[i]) for i in self.alive]


def amplification(out: np.ndarray, into: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return the largest amplification of rounding into other coordinates and back, max_i Σ_j |V_ij| (|W| x)_j / x_i.

    Arguments: V (..., n, p), W (..., p, n + 1), the last for constants, sizes x (..., n).
    """
    given = np.append(sizes, np.ones((*sizes.shape[:-1], 1)), axis=-1)[..., None]
    with np.errstate(all="ignore"):
        found: np.ndarray = ((np.abs(out) @ (np.abs(into) @ given))[..., 0] / sizes).max(axis=-1)
    return found


class Subspace(NamedTuple):
    """A factor of the characteristic polynomial, the projector on its subspace, and whether a single rate is slow."""

    factor: list[arb]  # from the highest power, which is one
    projector: arb_mat
    slow: bool

    @property
    def rank(self) -> int:
        """Return the number of its dimensions."""
        return round(sum(float(self.projector[i, i]) for i in range(self.projector.nrows())))


def subspaces(matrix: arb_mat, scale: list[float]) -> list[Subspace]:
    """Return the factors of the characteristic polynomial with the projectors on their subspaces.

    Arguments: matrix (n, n), sizes of the coordinates (n). Raises ``ArithmeticError`` if rates coincide with a chain
    that no factor of degree two holds.
    """
    # Those of the midpoint of its characteristic polynomial, whose roots FLINT isolates exactly, without their radii; a
    # coefficient that holds zero is zero, so that several rates of zero stay together.
    exact: Any = fmpq_poly([0 if x.contains(0) else x.mid().fmpq() for x in matrix.charpoly().coeffs()])
    rates = [acb(root.real.mid(), root.imag.mid()) for root, count in exact.complex_roots() for _ in range(count)]
    factors = _factors(rates)
    found = [_projector(matrix, factors, k) for k in range(len(factors))]
    if not _carried(matrix, factors, found, scale):
        raise ArithmeticError("rates of a mode coincide, with a chain")
    return [Subspace(f, p, _slow(f, rates)) for f, p in zip(factors, found, strict=True)]


def _factors(rates: list[acb]) -> list[list[arb]]:
    """Real factors of the characteristic polynomial, coefficients from the highest power; one factor for all zeros."""
    sizes = [float(abs(rate)) for rate in rates]
    moving = [rate for rate, size in zip(rates, sizes, strict=True) if size > _NOTHING * max(sizes)]
    upper = [rate for rate in moving if float(rate.imag) > _SAME * float(abs(rate))]
    upper.sort(key=lambda rate: float(rate.imag))
    real = [rate.real for rate in moving if abs(float(rate.imag)) <= _SAME * float(abs(rate))]
    real.sort(key=float, reverse=True)
    factors = [[arb(1), -2 * rate.real, abs(rate) ** 2] for rate in upper]
    while len(real) > 1:  # the two closest, relative to their size, belong together; far ones lose digits in a pair
        gaps = [abs(float((a - b) / (a if abs(a) > abs(b) else b))) for a, b in pairwise(real)]
        k = gaps.index(min(gaps))
        if gaps[k] > APART:
            break
        a, b = real.pop(k), real.pop(k)
        factors.append([arb(1), -(a + b), a * b])
    factors += [[arb(1), -rate] for rate in real]
    return factors + ([[arb(1), arb(0)]] if len(moving) < len(rates) else [])


def _projector(matrix: arb_mat, factors: list[list[arb]], k: int) -> arb_mat:
    """Return the projector on the subspace of a factor: the product of the others times its inverse modulo this one."""
    own, others, rest = arb_poly(factors[k][::-1]), arb_mat(matrix.nrows(), matrix.nrows(), 1), arb_poly([1])
    for j, other in enumerate(factors):
        if j != k:
            others = others * _polynomial(other, matrix)
            rest = rest * arb_poly(other[::-1]) % own
    b, a = rest[0], rest[1]
    if len(factors[k]) == 2:
        return _polynomial([1 / b], matrix) * others
    _, a1, a0 = factors[k]  # (a s + b)(c s + d) = 1 modulo s² + a₁ s + a₀
    norm = b * b - a * b * a1 + a * a * a0
    return _polynomial([-a / norm, (b - a * a1) / norm], matrix) * others


def _polynomial(coefficients: Row, matrix: arb_mat) -> arb_mat:
    found = arb_mat(matrix.nrows(), matrix.nrows())
    for coefficient in coefficients:
        found = found * matrix + arb_mat(matrix.nrows(), matrix.nrows(), 1) * arb(coefficient)
    return found


def _slow(factor: list[arb], rates: list[acb]) -> bool:
    size = abs(float(factor[1]))
    larger = [float(abs(rate)) for rate in rates if float(abs(rate)) > (1 + _SAME) * size]
    return len(factor) == 2 and bool(larger) and min(larger) > SLOW * size


def _carried(matrix: arb_mat, factors: list[list[arb]], projectors: list[arb_mat], scale: list[float]) -> bool:
    """True if each factor is zero on its subspace – no chain is left out – and these are projectors, in all one.

    Of two equal pairs without a chain, which rounding sets apart, each has half of the identity.
    """
    one = arb_mat(matrix.nrows(), matrix.nrows(), 1)
    sizes = [_size_of(projector, scale) for projector in projectors]
    if not _size_of(sum(projectors, -one), scale) <= _LEFT * max(sizes):
        return False
    powers = [_size_of(power, scale) for power in (one, matrix, matrix * matrix)]
    for factor, projector, size in zip(factors, projectors, sizes, strict=True):
        terms = sum(abs(float(a)) * power for a, power in zip(reversed(factor), powers, strict=False))
        if not _size_of(_polynomial(factor, matrix) * projector, scale) <= _LEFT * terms * size:
            return False
        if not _size_of(projector * projector - projector, scale) <= _LEFT * size * size:
            return False
    return True


def _size_of(matrix: arb_mat, scale: list[float]) -> float:
    """Return the largest element of a matrix of coordinates, in units of their sizes, radii included."""
    n = range(matrix.nrows())
    # What a rate in two factors leaves is not a number, which the largest of some numbers must not hide.
    return float(np.max([float(abs(matrix[i, j]).upper()) * scale[j] / scale[i] for i in n for j in n]))
