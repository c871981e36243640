"""Eigenvalues and class of the steady sliding of one drive, decided with certainty and rounded once.

The class follows from exact signs of the characteristic polynomial, the eigenvalues from roots in as many digits as
their real parts need to show their signs. So both agree, however far apart the rates lie. Whole grids are the matter of
:mod:`lsvib.steady_sliding.eigenvalues_two_coordinates` and :mod:`lsvib.steady_sliding.eigenvalues_rigid`.
"""

import math
from collections.abc import Iterable
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import pairwise
from typing import Any

import mpmath

from lsvib.drives.coefficients import Coefficients
from lsvib.drives.parameters import DriveParameters, RigidParameters
from lsvib.engine.exact.precision import PLACES
from lsvib.steady_sliding.characteristic import DIGITS, Polynomial, hurwitz, settled
from lsvib.steady_sliding.eigenvalues_rigid import Stability
from lsvib.steady_sliding.eigenvalues_two_coordinates import routh_hurwitz
from lsvib.steady_sliding.real_roots import derivative, divided, greatest_common_divisor

# Below this share of its first term a sum has lost so many of its 50 digits that exact signs must decide.
_CLEAR = Decimal("1e-25")
_SMALLEST = 5e-324  # A rate that is not zero must not be rounded to zero, because its sign decides on stability.


def rigid_spectrum(drive: RigidParameters, c: Coefficients) -> tuple[Stability, list[complex]]:
    """Class and both eigenvalues [1/s] of a rigid drive (8.18) with coefficients ``c``, in ascending real part.

    Γ_0 is never exactly zero and C_0 only without any damping, as tan λ is transcendental.
    """
    law = c.steady_law
    inertia, damping, stiffness = p = c.gamma[law], c.damping[law], Decimal(drive.coupling_stiffness)
    with localcontext(prec=PLACES):
        discriminant = damping**2 - 4 * inertia * stiffness
        sums = ((inertia, drive.screw_inertia), (damping, drive.support_damping), (discriminant, damping**2))
        if all(abs(total) >= _CLEAR * Decimal(part) for total, part in sums):
            return _rigid_class(p), _rounded(_pair(*p, discriminant))
    kind, exact = settled(drive, law, _rigid_class)
    return kind, _rounded((z.real, z.imag) for z in _roots(exact))


def spectrum(drive: DriveParameters, law: int) -> tuple[str, list[complex], Polynomial]:
    """Class, four eigenvalues [1/s] in ascending real part, and characteristic polynomial of a drive of two bodies.

    The class is ``stable`` (asymptotically), ``neutral`` (no eigenvalue to the right of the imaginary axis, simple ones
    on it, as without damping), ``kinematic`` (det M < 0), else ``divergence`` or ``flutter`` by whether the eigenvalue
    that grows fastest is real. The polynomial is that of :mod:`lsvib.steady_sliding.characteristic`.
    """
    kind, exact = settled(drive, law, _class)
    values = _rounded((z.real, z.imag) for z in _roots(exact))
    if kind == "unstable":
        kind = "divergence" if values[-1].imag == 0 else "flutter"
    return kind, values, exact


def neutral_margins(p: Polynomial) -> tuple[Fraction, Fraction, Fraction]:
    """Return p_4, p_2, p_2² − 4 p_4 p_0: without damping all frequencies are real and distinct if all are positive."""
    p_4, _, p_2, _, p_0 = p
    return p_4, p_2, p_2**2 - 4 * p_4 * p_0


def _rigid_class(p: Polynomial) -> Stability:
    inertia, damping, stiffness = p
    if inertia < 0:
        return Stability.SADDLE
    if damping == 0:
        return Stability.CENTRE
    if damping**2 < 4 * inertia * stiffness:
        return Stability.STABLE_FOCUS if damping > 0 else Stability.UNSTABLE_FOCUS
    return Stability.STABLE_NODE if damping > 0 else Stability.UNSTABLE_NODE


def _class(p: Polynomial) -> str:
    """The class by exact signs; ``unstable`` stands for divergence and flutter. p_0 > 0 and p_4 ≠ 0 in every model."""
    p_4, p_3, _, p_1, _ = p
    if p_4 < 0:
        return "kinematic"
    if routh_hurwitz(p):
        return "stable"
    if p_3 == 0 == p_1:
        return "neutral" if min(neutral_margins(p)) > 0 else "unstable"
    # With ω² = p_1/p_3 the polynomial is (s² + ω²)(p_4 s² + p_3 s + p_0/ω²) if the Hurwitz determinant vanishes.
    return "neutral" if hurwitz(p) == 0 and p_3 > 0 and p_1 > 0 else "unstable"


def _roots(p: Polynomial) -> list[mpmath.mpc]:
    """All roots of a polynomial of degree 1 to 4 with p_0 ≠ 0; parts that vanish are exactly zero."""
    if len(p) == 2:
        with mpmath.workdps(DIGITS):
            return [mpmath.mpc(_number(-p[1] / p[0]))]
    if len(p) == 3:
        return _quadratic(p)
    if len(p) == 5:
        p_4, p_3, _, p_1, p_0 = p
        if p_3 == 0 == p_1:
            return [sign * root for square in _quadratic(p[::2]) for root in (_root_of(square),) for sign in (-1, 1)]
        if p_3 != 0 and p_1 != 0 and hurwitz(p) == 0:
            return _quadratic((p_3, Fraction(0), p_1)) + _quadratic((p_4, p_3, p_0 * p_3 / p_1))
    repeated = greatest_common_divisor(p, derivative(p))
    if len(repeated) > 1:
        return _roots(divided(p, repeated)[0]) + _roots(repeated)
    digits = DIGITS
    while (found := _simple_roots(p, digits)) is None:
        digits *= 2
    return found


def _quadratic(p: Polynomial) -> list[mpmath.mpc]:
    """Both roots of p_2 s² + p_1 s + p_0: the larger one without a subtraction, the other one from their product."""
    a, b, c = p
    with mpmath.workdps(DIGITS), localcontext(prec=DIGITS):
        exact = (Decimal(x.numerator) / x.denominator for x in (a, b, c, b * b - 4 * a * c))
        return [mpmath.mpc(_number(Fraction(x)), _number(Fraction(y))) for x, y in _pair(*exact)]


def _pair(a: Decimal, b: Decimal, c: Decimal, discriminant: Decimal) -> list[tuple[Decimal, Decimal]]:
    """Real and imaginary parts of the roots of a s² + b s + c in decimals; a part that is zero is exactly zero."""
    root = abs(discriminant).sqrt()
    if discriminant < 0:
        real, half = -b / (2 * a), root / abs(2 * a)
        return [(real, -half), (real, half)]
    larger = -(b + root.copy_sign(b)) / 2
    return [(larger / a, Decimal(0)), (c / larger, Decimal(0))]


def _root_of(square: mpmath.mpc) -> mpmath.mpc:
    """Square root with real or imaginary part exactly zero for a real square."""
    with mpmath.workdps(DIGITS):
        root = mpmath.sqrt(abs(square.real)) if square.imag == 0 else mpmath.sqrt(square)
        return mpmath.mpc(0, root) if square.imag == 0 and square.real < 0 else mpmath.mpc(root)


def _simple_roots(p: Polynomial, digits: int) -> list[mpmath.mpc] | None:
    """Roots of a polynomial without repeated ones and none on the imaginary axis, by Aberth's iteration.

    Every disc of radius n |p/p′| around a place holds a root. If with so many ``digits`` two discs touch each other, or
    one touches the imaginary axis, the result is None. Where the discs are apart a root whose disc touches the real
    axis is real, because otherwise its complex conjugate would lie in the same disc.
    """
    with mpmath.workdps(digits):
        values = [_number(x) for x in p]
        roots = _first_guess(values)
        # Some ten steps; two roots that nearly coincide take one for each binary digit that they share.
        for _ in range(4 * digits):
            moved = mpmath.mpf(0)
            for i, z in enumerate(roots):
                value, slope = _evaluated(values, z)
                if value == 0:
                    continue
                others = sum(1 / (z - other) for j, other in enumerate(roots) if j != i)
                step = 1 / (slope / value - others)
                roots[i] = z - step
                moved = max(moved, abs(step) / abs(z))
            if moved < mpmath.mpf(10) ** (10 - digits):
                break
        degree, radii = len(p) - 1, []
        for z in roots:
            value, slope = _evaluated(values, z)
            rounding = mpmath.mpf(10) ** (2 - digits) * _evaluated([abs(x) for x in values], abs(z))[0]
            if slope == 0:
                return None
            radii.append(2 * degree * (abs(value) + rounding) / abs(slope))
        pairs = [(i, j) for i in range(degree) for j in range(i)]
        apart = all(abs(roots[i] - roots[j]) > radii[i] + radii[j] for i, j in pairs)
        # 10⁻³⁰ leaves every double that is made of a real part right to its last bit.
        fine = mpmath.mpf(10) ** -30
        if not apart or any(radius > fine * abs(z.real) for z, radius in zip(roots, radii, strict=True)):
            return None
        return [mpmath.mpc(z.real) if abs(z.imag) <= r else z for z, r in zip(roots, radii, strict=True)]


def _evaluated(values: list[mpmath.mpf], z: mpmath.mpc) -> tuple[mpmath.mpc, mpmath.mpc]:
    """A polynomial and its derivative at a place."""
    value = slope = mpmath.mpf(0)
    for x in values:
        value, slope = value * z + x, slope * z + value
    return value, slope


def _first_guess(values: list[mpmath.mpf]) -> list[mpmath.mpc]:
    """Places of the size of the roots by Newton's polygon: slopes of the concave hull of log |p_i|."""
    powers = range(len(values) - 1, -1, -1)
    points = [(i, mpmath.log(abs(x))) for i, x in sorted(zip(powers, values, strict=True)) if x != 0]
    hull: list[tuple[int, mpmath.mpf]] = []
    for point in points:
        while len(hull) > 1 and _turn(hull[-2], hull[-1], point) >= 0:
            hull.pop()
        hull.append(point)
    guess = []
    for (i, low), (j, high) in pairwise(hull):
        size = mpmath.exp((low - high) / (j - i))
        # 0.7 rad keeps the places off both axes, which are lines of symmetry that the iteration would not leave.
        guess += [size * mpmath.expj(2 * mpmath.pi * n / (j - i) + 0.7) for n in range(j - i)]
    return guess


def _turn(a: tuple, b: tuple, c: tuple) -> mpmath.mpf:
    """Positive where the way from a over b to c turns to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _number(x: Fraction) -> mpmath.mpf:
    """A rational in the digits of the context."""
    return mpmath.mpf(x.numerator) / x.denominator


def _rounded(roots: Iterable[tuple[Any, Any]]) -> list[complex]:
    """Eigenvalues, given by real and imaginary parts, as doubles in ascending real, then imaginary part."""
    values = [complex(_double(real), _double(imaginary)) for real, imaginary in roots]
    return sorted(values, key=lambda z: (z.real, z.imag))


def _double(x: mpmath.mpf | Decimal) -> float:
    value = float(x)
    return math.copysign(_SMALLEST, x) if value == 0 != x else value
