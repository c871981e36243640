"""Eigenvalues and class of the steady sliding of one drive, decided with certainty and rounded once.

The class follows from exact signs of the characteristic polynomial, the eigenvalues from roots in as many digits as
their real parts need to show their signs. So both agree, however far apart the rates lie. Whole grids are the matter of
:mod:`lsvib.stability.linear` and :mod:`lsvib.stability.linear`.
"""

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from flint import arb

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models.drive import Drive, RigidDrive
from lsvib.models.mechanics import Coefficients
from lsvib.stability.linear import Stability, routh_hurwitz
from lsvib.stability.spectrum import Polynomial, all_roots, hurwitz, settled

# Below this share of its first term a sum has lost so many digits that exact signs must decide.
_CLEAR = 1e-25
_SMALLEST = 5e-324  # A rate that is not zero must not be rounded to zero, because its sign decides on stability.


def rigid_spectrum(drive: RigidDrive, c: Coefficients) -> tuple[Stability, list[complex]]:
    """Class and both eigenvalues [1/s] of a rigid drive (8.18) with coefficients ``c``, in ascending real part.

    Γ_0 is never exactly zero and C_0 only without any damping, as tan λ is transcendental.
    """
    law = c.steady_law
    inertia, damping, stiffness = p = c.gamma[law], c.damping[law], arb(drive.coupling_stiffness)
    with many_digits():
        discriminant = damping**2 - 4 * inertia * stiffness
        sums = ((inertia, drive.screw_inertia), (damping, drive.support_damping), (discriminant, damping**2))
        if all(abs(total) >= _CLEAR * arb(part) for total, part in sums):
            return _rigid_class(p), _rounded(_pair(*p, discriminant))
    kind, exact = settled(drive, law, _rigid_class)
    return kind, _rounded(all_roots(exact))


def spectrum(drive: Drive, law: int) -> tuple[str, list[complex], Polynomial]:
    """Class, four eigenvalues [1/s] in ascending real part, and characteristic polynomial of a drive of two bodies.

    The class is ``stable`` (asymptotically), ``neutral`` (no eigenvalue to the right of the imaginary axis, simple ones
    on it, as without damping), ``kinematic`` (det M < 0), else ``divergence`` or ``flutter`` by whether the eigenvalue
    that grows fastest is real. The polynomial is that of :mod:`lsvib.stability.spectrum`.
    """
    kind, exact = settled(drive, law, _class)
    values = _rounded(all_roots(exact))
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
        return "kinematic_constraint"
    if routh_hurwitz(p):
        return "stable"
    if p_3 == 0 == p_1:
        return "neutral" if min(neutral_margins(p)) > 0 else "unstable"
    # With ω² = p_1/p_3 the polynomial is (s² + ω²)(p_4 s² + p_3 s + p_0/ω²) if the Hurwitz determinant vanishes.
    return "neutral" if hurwitz(p) == 0 and p_3 > 0 and p_1 > 0 else "unstable"


def _pair(a: arb, b: arb, c: arb, discriminant: arb) -> list[tuple[arb, arb]]:
    """Real and imaginary parts of the roots of a s² + b s + c in balls; a part that is zero is exactly zero."""
    root = abs(discriminant).sqrt()
    if discriminant < 0:
        real, half = -b / (2 * a), root / abs(2 * a)
        return [(real, -half), (real, half)]
    larger = -(b + (root if b >= 0 else -root)) / 2
    return [(larger / a, arb(0)), (c / larger, arb(0))]


def _rounded(roots: Iterable[tuple[Any, Any]]) -> list[complex]:
    """Eigenvalues, given by real and imaginary parts, as doubles in ascending real, then imaginary part."""
    values = [complex(_double(real), _double(imaginary)) for real, imaginary in roots]
    return sorted(values, key=lambda z: (z.real, z.imag))


def _double(x: Fraction | arb) -> float:
    value = float(x)
    return (_SMALLEST if x > 0 else -_SMALLEST) if value == 0 != x else value
