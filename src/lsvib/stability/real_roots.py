"""Roots of polynomials with rational coefficients, isolated with certainty by FLINT."""

from collections.abc import Iterator
from fractions import Fraction

from flint import acb, arb, ctx, fmpq, fmpq_poly

from lsvib.stability.spectrum import Polynomial

# Relative width to which a root is found, far below the spacing of doubles, 2⁻⁵²: no double lies between two roots that
# are closer than SAME, and they count as one.
_BITS = 100
SAME = Fraction(4, 2**90)


def positive_roots(p: Polynomial, limit: Fraction) -> list[Fraction]:
    """Distinct roots in (0, limit] in ascending order, each to a relative 2⁻⁹⁰.

    Arguments: coefficients, highest power first, not all zero; end of the interval.
    """
    with ctx.workprec(_BITS):
        roots = [root for root, _ in flint_polynomial(p).complex_roots()]
    found = (fraction(root.real) for root in roots if root.imag == 0)
    return sorted(root for root in found if 0 < root <= limit)


def flint_polynomial(p: Polynomial) -> fmpq_poly:
    """Return a polynomial of FLINT from its coefficients, highest power first."""
    return fmpq_poly([fmpq(x.numerator, x.denominator) for x in reversed(p)])


def fraction(ball: arb) -> Fraction:
    """Return the midpoint of a ball."""
    mantissa, exponent = ball.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def trimmed(p: Polynomial) -> Polynomial:
    """Return a polynomial without its leading zeros; the zero polynomial becomes empty."""
    start = next((i for i, x in enumerate(p) if x != 0), len(p))
    return tuple(p[start:])


def all_roots(p: Polynomial) -> list[tuple[Fraction, Fraction]]:
    """Return all roots, those that coincide as often as they do: real and imaginary part, each to a relative 2⁻⁹⁰.

    A part is zero where it is exactly zero. Real ones are isolated by FLINT; imaginary ones are the roots that the
    parts of the polynomial of even and of odd powers share, in s².
    """
    both = flint_polynomial(p)
    even, odd = (fmpq_poly(both.coeffs()[k::2]) for k in (0, 1))
    shared = even.gcd(odd)
    rest, _ = divmod(both, fmpq_poly([c for x in shared.coeffs() for c in (x, 0)]))
    bits = _BITS
    while True:
        with ctx.workprec(bits):
            found = [*_signed_roots(shared), *(root for root, n in rest.complex_roots() for _ in range(int(n)))]
        if all(_fine(part) for root in found for part in (root.real, root.imag)):
            return [(fraction(root.real), fraction(root.imag)) for root in found]
        bits *= 2


def _signed_roots(squares: fmpq_poly) -> Iterator[acb]:
    """Yield both square roots of each root of a polynomial; a part that vanishes is exactly zero."""
    for square, count in squares.complex_roots():
        root = square.sqrt()
        if square.imag == 0:
            root = acb(0, (-square.real).sqrt()) if square.real < 0 else acb(square.real.sqrt())
        yield from [root, -root] * int(count)


def _fine(part: arb) -> bool:
    """Whether a ball is narrow beside its number, or exactly zero."""
    return part == 0 or float(part.rad() / abs(part.mid())) < 2.0**-90
