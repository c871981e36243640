"""Products and remainders of polynomials, coefficients from the highest power, in any kind of number."""

from collections.abc import Sequence
from typing import Any


def multiplied(left: Sequence[Any], right: Sequence[Any]) -> list[Any]:
    """Return the product of two polynomials."""
    result: list[Any] = [0] * (len(left) + len(right) - 1)
    for i, x in enumerate(left):
        for j, y in enumerate(right):
            result[i + j] += x * y
    return result


def modulo(polynomial: Sequence[Any], factor: Sequence[Any]) -> list[Any]:
    """Return what is left of a polynomial after division by a factor, whose first coefficient is one."""
    polynomial = list(polynomial)
    while len(polynomial) >= len(factor):
        lead = polynomial.pop(0)
        for i, coefficient in enumerate(factor[1:]):
            polynomial[i] -= lead * coefficient
    return polynomial


def inverse_modulo(remainder: Sequence[Any], factor: Sequence[Any]) -> list[Any]:
    """Return the inverse of a polynomial of lower degree modulo the factor."""
    remainder = [0] * (len(factor) - 1 - len(remainder)) + list(remainder)
    if len(factor) == 2:
        return [1 / remainder[0]]
    a, b = remainder  # (a s + b)(c s + d) = 1 modulo s² + a₁ s + a₀
    _, a1, a0 = factor
    norm = b * b - a * b * a1 + a * a * a0
    return [-a / norm, (b - a * a1) / norm]
