"""Positive real roots of a polynomial with rational coefficients, isolated with certainty by Sturm's theorem."""

import math
from fractions import Fraction
from itertools import pairwise

from lsvib.steady_sliding.characteristic import Polynomial

# Relative width to which a root is found, far below the spacing of doubles, 2⁻⁵²: no double lies between two roots that
# are closer than SAME, and they count as one.
_WIDTH = Fraction(1, 2**90)
SAME = 4 * _WIDTH


def positive_roots(p: Polynomial, limit: Fraction) -> list[Fraction]:
    """Distinct roots in (0, limit] in ascending order, each to a relative 2⁻⁹⁰.

    Arguments: coefficients, highest power first, not all zero; end of the interval.
    """
    p = trimmed(p)
    while p[-1] == 0:  # roots at zero
        p = p[:-1]
    if len(p) == 1:
        return []
    p, _ = divided(p, greatest_common_divisor(p, derivative(p)))
    chain = [_integers(p), _integers(derivative(p))]
    while rest := divided(chain[-2], chain[-1])[1]:
        chain.append(_integers(tuple(-x for x in rest)))
    found, open_ends = [], [(Fraction(0), _changes(chain, Fraction(0)), limit, _changes(chain, limit))]
    while open_ends:
        low, before, high, after = open_ends.pop()
        if before == after:
            continue
        if high - low <= _WIDTH * high:
            found.append((low + high) / 2)
            continue
        middle = _middle(low, high)
        between = _changes(chain, middle)
        open_ends += [(middle, between, high, after), (low, before, middle, between)]
    return found


def greatest_common_divisor(p: Polynomial, q: Polynomial) -> Polynomial:
    """Greatest common divisor of two polynomials that are not zero, with integer coefficients."""
    while q:
        p, q = q, divided(p, q)[1]
    return tuple(Fraction(x) for x in _integers(p))


def divided(p: Polynomial, q: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Quotient and remainder of two polynomials."""
    rest, result = [Fraction(x) for x in p], []
    for i in range(len(p) - len(q) + 1):
        result.append(rest[i] / q[0])
        for j, x in enumerate(q):
            rest[i + j] -= result[-1] * x
    return tuple(result), trimmed(tuple(rest[len(result) :]))


def trimmed(p: Polynomial) -> Polynomial:
    """Return a polynomial without its leading zeros; the zero polynomial becomes empty."""
    start = next((i for i, x in enumerate(p) if x != 0), len(p))
    return tuple(p[start:])


def derivative(p: Polynomial) -> Polynomial:
    """Derivative of a polynomial."""
    return tuple(x * power for x, power in zip(p, range(len(p) - 1, 0, -1), strict=False))


def _integers(p: Polynomial) -> Polynomial:
    """The polynomial times a positive number, with coprime integer coefficients."""
    common = math.lcm(*(Fraction(x).denominator for x in p))
    whole = [int(x * common) for x in p]
    divisor = math.gcd(*whole)
    return tuple(x // divisor for x in whole)


def _changes(chain: list[Polynomial], place: Fraction) -> int:
    """Number of sign changes along a Sturm chain at a place."""
    signs = [sign for p in chain if (sign := _sign(p, place))]
    return sum(a != b for a, b in pairwise(signs))


def _sign(p: Polynomial, place: Fraction) -> int:
    """Sign of a polynomial with integer coefficients at a rational place, in integers alone."""
    numerator, denominator, value, power = place.numerator, place.denominator, 0, 1
    for x in p:
        value = value * numerator + x * power
        power *= denominator
    return (value > 0) - (value < 0)


def _middle(low: Fraction, high: Fraction) -> Fraction:
    """A place strictly between both: a power of two while the ends differ in size, else the arithmetic mean."""
    if low == 0:
        # Squaring reaches a root of any size in a few steps.
        return Fraction(1) if high > 1 else high**2 / 4
    if high > 4 * low:
        sizes = [x.numerator.bit_length() - x.denominator.bit_length() for x in (low, high)]
        power = Fraction(2) ** (sum(sizes) // 2)
        if low < power < high:
            return power
    return (low + high) / 2
