"""Factors of a matrix's characteristic polynomial, of degree one or two, and the projectors on their subspaces."""

from collections.abc import Callable
from itertools import pairwise, product
from operator import mul
from typing import Any

import mpmath

from lsvib.engine.exact.polynomials import inverse_modulo, modulo, multiplied

# Relative sizes that only rounding can have, by the number of digits in use. _TINY is for rates: two that coincide may
# differ by the root of the rounding of these digits, or of the 50 of the coefficients. _ROUNDING is for projectors.
_TINY = {60: mpmath.mpf(10) ** -25, 120: mpmath.mpf(10) ** -40}
_ROUNDING = {60: mpmath.mpf(10) ** -35, 120: mpmath.mpf(10) ** -40}
SLOW = 10  # a single rate that is so many times smaller than all larger ones may have its equilibrium far away
APART = 0.25  # relative distance of two real rates from which on each is carried alone


def _tiny() -> mpmath.mpf:
    return _TINY[mpmath.mp.dps]


def _factors(rates, once: bool) -> list[list]:
    """Real factors of the characteristic polynomial, coefficients from the highest power; one factor for all zeros.

    ``once``: one factor, too, for all rates that coincide, so that the product is the minimal polynomial if no chain
    comes with them.
    """
    largest = max(abs(rate) for rate in rates)
    if largest == 0:
        return [[mpmath.mpf(1), mpmath.mpf(0)]]
    zeros = [rate for rate in rates if abs(rate) <= _tiny() * largest]
    moving = [rate for rate in rates if abs(rate) > _tiny() * largest]
    upper = [rate for rate in moving if mpmath.im(rate) > _tiny() * abs(rate)]
    real = sorted((mpmath.re(r) for r in moving if abs(mpmath.im(r)) <= _tiny() * abs(r)), reverse=True)
    if once:
        upper, real = _distinct(upper), _distinct(real)
    factors = [[mpmath.mpf(1), -2 * mpmath.re(rate), abs(rate) ** 2] for rate in upper]
    while len(real) > 1:  # the two closest, relative to their size, belong together; far ones lose digits in a pair
        gaps = [(a - b) / max(abs(a), abs(b)) for a, b in pairwise(real)]
        k = gaps.index(min(gaps))
        if gaps[k] > APART:
            break
        a, b = real.pop(k), real.pop(k)
        factors.append([mpmath.mpf(1), -(a + b), a * b])
    factors += [[mpmath.mpf(1), -rate] for rate in real]
    return factors + ([[mpmath.mpf(1), mpmath.mpf(0)]] if zeros else [])


def _distinct(rates: list) -> list:
    found: list = []
    for rate in rates:
        if all(abs(rate - other) > _tiny() * abs(rate) for other in found):
            found.append(rate)
    return found


def subspaces(matrix, scale) -> list[tuple[list, mpmath.matrix, bool]]:
    """Factors of the characteristic polynomial, each with the projector on its subspace, and whether it is slow.

    Arguments: matrix (n, n), sizes of the coordinates (n). Raises ``ArithmeticError`` if rates coincide with a chain
    that no factor of degree two holds.
    """
    rates = mpmath.eig(matrix, left=False, right=False)
    for once in (True, False):
        factors = _factors(rates, once)
        try:
            projectors = [
                projector(factors, k, lambda factor: _polynomial(factor, matrix), mul) for k in range(len(factors))
            ]
        except ZeroDivisionError:  # a rate in two factors
            continue
        if _carried(matrix, factors, projectors, scale):
            return [(f, p, _slow(f, rates)) for f, p in zip(factors, projectors, strict=True)]
    raise ArithmeticError("rates of a mode coincide, with a chain")


def projector(factors: list, k: int, polynomial: Callable[[list], Any], product: Callable[[Any, Any], Any]) -> Any:
    """Return the projector on the subspace of a factor.

    ``polynomial`` of the matrix, by its coefficients; ``product`` of two matrices: in any kind of number.
    """
    others, remainder = None, [1]  # the product of the others, and what it leaves modulo this factor
    for j, other in enumerate(factors):
        if j != k:
            others = polynomial(other) if others is None else product(others, polynomial(other))
            remainder = modulo(multiplied(remainder, other), factors[k])
    inverse = polynomial(inverse_modulo(remainder, factors[k]))
    return inverse if others is None else product(inverse, others)


def _slow(factor, rates) -> bool:
    larger = [abs(rate) for rate in rates if abs(rate) > (1 + _tiny()) * abs(factor[1])]
    return len(factor) == 2 and bool(larger) and min(larger) > SLOW * abs(factor[1])


def _carried(matrix, factors: list, projectors: list, scale: list) -> bool:
    """True if each factor is zero on its subspace – no chain is left out – and the projectors add up to one."""
    total = sum(projectors[1:], projectors[0]) - mpmath.eye(matrix.rows)
    if _size(total, scale) > _ROUNDING[mpmath.mp.dps] * max(_size(p, scale) for p in projectors):
        return False
    powers = [_size(power, scale) for power in (matrix * matrix, matrix, mpmath.eye(matrix.rows))]
    for factor, projector in zip(factors, projectors, strict=True):
        terms = sum(abs(a) * power for a, power in zip(reversed(factor), reversed(powers), strict=False))
        if _size(_polynomial(factor, matrix) * projector, scale) > _ROUNDING[mpmath.mp.dps] * terms * _size(
            projector, scale
        ):
            return False
    return True


def _size(matrix, scale: list) -> mpmath.mpf:
    """Largest element of a matrix of coordinates in units of their sizes."""
    return max(abs(matrix[i, j]) * scale[j] / scale[i] for i, j in product(range(matrix.rows), range(matrix.cols)))


def _polynomial(coefficients, matrix):
    lead, *others = coefficients
    result = lead * (matrix if others else mpmath.eye(matrix.rows))
    for k, coefficient in enumerate(others):
        result = result * matrix if k else result
        for i in range(matrix.rows):
            result[i, i] += coefficient
    return result
