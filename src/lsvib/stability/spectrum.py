"""Characteristic polynomial, eigenvalues and class of the steady sliding of one drive, with certainty, for every model.

Each model states its polynomial (:class:`lsvib.models.mechanics.LinearParts` has the parts that all are made of). It
is det(M s² + C s + K) of :mod:`lsvib.stability.linear` times a positive factor, g = 1 + s_0 μ tan λ or, with compliant
threads, 1 + tan² λ. Its coefficients are polynomials in every parameter and in t = tan λ, and nothing cancels in them
but what the physics subtracts.

A double is a rational number and t is transcendental for every double λ > 0 (Lindemann), so a polynomial in t with
rational coefficients vanishes only if it vanishes for every t. A sign is therefore certain if it is the same at both
ends of a narrow enclosure of t: zero at both ends means zero identically, and otherwise more digits separate them. All
is done in rational numbers and balls of FLINT. Where friction depends on the sliding speed, 1 / cos λ and the
exponential of the law are enclosed like t, and the class is taken if it is the same at both ends.
"""

from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import Any

from flint import acb, arb, ctx, fmpq, fmpq_poly

from lsvib.errors import InputError
from lsvib.models import friction
from lsvib.models.drive import PARTS, Drive
from lsvib.models.mechanics import LinearParts
from lsvib.stability.linear import Stability, hurwitz

LEAST = fmpq(1, 2**400)  # beyond all quotients of parameters
SAME = fmpq(1, 2**88)  # relative: no double lies between two roots that are closer, so they count as one

Polynomial = tuple[Any, ...]
"""Coefficients, highest power first; rational numbers, or polynomials in an unknown parameter."""


def polynomial(values: Mapping[str, Any], law: int, tan_lead: Any, level: bool = False) -> Polynomial:
    """Return the coefficients of the characteristic polynomial, highest power first (SI units).

    They are those of det(M s² + C s + K) times ``LinearParts.excess``. Arguments: parameters of the drive, law s = ±1
    and tan λ, in any one arithmetic: floats, rationals (:func:`enclosed`), polynomials in an unknown, balls or power
    series; ``level`` leaves out the slope of friction.
    """
    parts = LinearParts.of(values, law, tan_lead)
    return (parts.level() if level else parts).polynomial()


def _beside(number: arb, digits: int) -> tuple[fmpq, ...]:
    """Rationals just below and just above a number, a relative 10^−digits apart from it."""
    return tuple((number.mid() * (1 + side * arb(10) ** -digits)).mid().fmpq() for side in (-1, 1))


def sliding_law_values(drive: Drive, digits: int = 100) -> tuple[dict[str, fmpq], ...]:
    """Return ``secant`` and ``decay`` of :func:`lsvib.models.friction.steady_sum` just below and above their values."""
    with ctx.workdps(digits + 10):
        secant, left = 1 / arb(drive.lead_angle).cos(), arb(1)
        if drive.stribeck_speed:
            d = SimpleNamespace(stribeck_speed=arb(drive.stribeck_speed), stribeck_exponent=drive.stribeck_exponent)
            left = friction.decay(d, arb(drive.pitch_radius) * abs(arb(drive.input_speed)) * secant)
        # What is left of a rise may have no end of digits; so little of it counts only where nothing else does.
        decays = _beside(left, digits) if left > LEAST else (LEAST**3, LEAST)
        pairs = zip(_beside(secant, digits), decays, strict=True)
        return tuple({"secant": secant, "decay": decay} for secant, decay in pairs)


def enclosed(drive: Drive, digits: int = 100) -> tuple[tuple[dict[str, fmpq], fmpq], ...]:
    """Return the parameters as rationals and tan λ, twice: all that is no rational just below and above its value."""
    values = {key: fmpq(*value.as_integer_ratio()) for key, value in drive}
    with ctx.workdps(digits + 10):
        ends = _beside(arb(drive.lead_angle).tan(), digits)
    if not friction.moves(values):
        return tuple((values, t) for t in ends)
    return tuple((values | law, t) for law, t in zip(sliding_law_values(drive, digits), ends, strict=True))


def spectrum(drive: Drive, law: int, level: bool = False) -> tuple[str, list[complex], Polynomial]:
    """Class, eigenvalues [1/s] in ascending real part, and det(M s² + C s + K) of the steady sliding of a drive.

    Of the rigid drive (8.18) the class is one of :class:`~lsvib.stability.linear.Stability`, in lower case. Of a drive
    of two bodies it is ``stable`` (asymptotically), ``neutral`` (no eigenvalue to the right of the imaginary axis,
    simple ones on it, as without damping), ``kinematic_constraint`` (det M < 0), else ``divergence`` or ``flutter`` by
    whether the eigenvalue that grows fastest is real. Signs are certain, eigenvalues rounded once. ``level`` leaves out
    the slope of friction. Raises ``InputError`` where μ is below cot λ only by the rounding of cot λ to a double.
    """
    digits = 100
    parameters, tangent = enclosed(drive, digits)[1]
    if friction.steady(parameters, tangent)[0] * tangent >= 1:
        raise InputError(f"friction_coefficient = {drive.friction_coefficient!r} is not below cot(lead_angle).")
    # The class depends on signs of polynomials in tan λ alone, so enough digits give the same one at both ends; where
    # one vanishes to some 80 digits, four times as many.
    while True:
        exact, other = (polynomial(values, law, t, level) for values, t in enclosed(drive, digits))
        if (kind := _class(exact)) == _class(other):
            break
        digits *= 4
    roots = (complex(float(root.real), float(root.imag)) for root in _all_roots(exact))
    values = sorted(roots, key=lambda z: (z.real, z.imag))
    if kind == "unstable":
        kind = "divergence" if values[-1].imag == 0 else "flutter"
    parameters, tangent = enclosed(drive)[0]
    parts = LinearParts.of(parameters, law, tangent)
    factor = fmpq((parts.level() if level else parts).excess)
    return kind, values, tuple(p / factor for p in exact)


def margins(p: Polynomial, neutral: bool) -> Polynomial:
    """Return numbers that are all positive exactly where steady sliding is stable; p_0 always is.

    Those are the coefficients and the Hurwitz determinants of odd order (Liénard and Chipart). Without damping
    (``neutral``) they are those for which no motion grows and all frequencies are real and distinct: with two of them
    p_4, p_2 and p_2² − 4 p_4 p_0; with more those of q(s²) + s q′(s²), whose even and odd parts interlace just then
    (Hermite and Biehler), of the polynomial q(s²).
    """
    order = len(p) - 1
    if neutral and order == 4:
        return p[0], p[2], p[2] ** 2 - 4 * p[0] * p[4]
    if neutral and order > 4:
        p = interlaced(p)
    if order == 2:
        return p[:1] if neutral else p[:2]
    return (*p[:-1], *(hurwitz(p, k) for k in range(3, order, 2)))


def interlaced(p: Polynomial) -> Polynomial:
    """Return q(s²) + s q′(s²) of the even part q(s²) of a polynomial, highest power first."""
    half = (len(p) - 1) // 2
    return tuple(x for k, even in enumerate(p[::2]) for x in (even, (half - k) * even))[:-1]


def undamped(drive: Drive, key: str = "") -> bool:
    """Whether nothing damps the drive, whatever the parameter ``key`` is: stability is then neutral stability.

    The slope of friction damps as well, or the opposite.
    """
    if friction.depends_on_speed(drive) or key in friction.OF_SPEED:
        return False
    dampings = ["support_damping", "translation_damping", *(PARTS[part][-1] for part in drive.parts)]
    return key not in dampings and not any(getattr(drive, name) for name in dampings)


def _class(p: Polynomial) -> str:
    """The class by exact signs; ``unstable`` stands for divergence and flutter. p_0 > 0 and p_n ≠ 0 in every drive."""
    if len(p) == 3:
        inertia, damping, stiffness = p
        if inertia < 0:
            return Stability.SADDLE.name.lower()
        if damping == 0:
            return Stability.CENTRE.name.lower()
        shape = "focus" if damping**2 < 4 * inertia * stiffness else "node"
        return f"{'stable' if damping > 0 else 'unstable'}_{shape}"
    if p[0] < 0:
        return "kinematic_constraint"
    *coefficients, last = margins(p, False)
    if min(coefficients) > 0 < last:
        return "stable"
    if not any(p[1::2]):
        return "neutral" if min(margins(p, True)) > 0 else "unstable"
    # The last determinant vanishes with a pair of imaginary roots, beside which nothing grows where the others do not.
    return "neutral" if min(coefficients) > 0 == last else "unstable"


def positive_roots(p: fmpq_poly, limit: fmpq) -> list[fmpq]:
    """Distinct roots in (0, limit] of a polynomial that is not zero, in ascending order, each to a relative 2⁻⁹⁰."""
    with ctx.workprec(100):
        roots = [root.real.mid().fmpq() for root, _ in p.complex_roots() if root.imag == 0]
    return sorted(root for root in roots if 0 < root <= limit)


def _all_roots(p: Polynomial) -> list[acb]:
    """All roots, those that coincide as often as they do, each part to a relative 2⁻⁹⁰, or exactly zero."""
    both = fmpq_poly(list(reversed(p)))
    # Imaginary ones are those that the parts of even and of odd powers share, in s²; FLINT isolates the real ones.
    shared = fmpq_poly(both.coeffs()[::2]).gcd(fmpq_poly(both.coeffs()[1::2]))
    rest, _ = divmod(both, fmpq_poly([c for x in shared.coeffs() for c in (x, 0)]))
    bits = 100
    while True:
        with ctx.workprec(bits):
            found = [*_signed_roots(shared), *(root for root, n in rest.complex_roots() for _ in range(int(n)))]
        if all(part == 0 or part.rel_accuracy_bits() >= 90 for root in found for part in (root.real, root.imag)):
            return found
        bits *= 2


def _signed_roots(squares: fmpq_poly) -> Iterator[acb]:
    """Yield both square roots of each root of a polynomial; a part that vanishes is exactly zero."""
    for square, count in squares.complex_roots():
        root = square.sqrt()
        if square.imag == 0:
            root = acb(0, (-square.real).sqrt()) if square.real < 0 else acb(square.real.sqrt())
        yield from [root, -root] * int(count)
