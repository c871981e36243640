"""The characteristic polynomial of steady sliding, its signs and roots, for every drive.

It is det(M s² + C s + K) of the matrices that the chapter prints; :class:`lsvib.drives.mechanics.LinearParts` makes it
from the parts of a drive, times a positive factor, in any one arithmetic: balls or doubles of a drive, arrays of many,
power series, rational numbers, polynomials in an unknown. Its coefficients are polynomials in every parameter and in t
= tan λ, and nothing cancels in them but what the physics subtracts. Coulomb friction F_0 and T_0 is constant in steady
sliding, so it shifts the equilibrium – and may turn the sign of N – but is not in it. The state matrix, for comparison,
is what Newton's laws of the drive say in slip (:mod:`lsvib.drives.mechanism`).

A double is a rational number and t is transcendental for every double λ > 0 (Lindemann), so a polynomial in t with
rational coefficients vanishes only if it vanishes for every t. A sign is therefore certain if it is the same at both
ends of a narrow enclosure of t: zero at both ends means zero identically, and otherwise more digits separate them. All
is done in rational numbers and balls of FLINT. Where friction depends on the sliding speed, 1 / cos λ and the
exponential of the law are enclosed like t, and the class is taken if it is the same at both ends.
"""

from collections.abc import Iterator, Mapping
from enum import IntEnum
from functools import cache
from typing import Any

import numpy as np
from flint import acb, arb, ctx, fmpq, fmpq_poly
from numpy.typing import ArrayLike, NDArray

from lsvib.drives import friction
from lsvib.drives.drive import PARTS, Drive, ExactParameters, require_direction
from lsvib.drives.mechanics import LinearParts, Polynomial, net_force
from lsvib.errors import InputError
from lsvib.systems.exact.arithmetic import many_digits

LEAST = fmpq(1, 2**400)  # beyond all quotients of parameters
SAME = fmpq(1, 2**88)  # relative: no double lies between two roots that are closer, so they count as one

DriveValues = Drive | ExactParameters | Mapping[str, ArrayLike]
"""A drive in doubles, the same in balls (``drive.exact()``), or its keys with arrays that broadcast."""


class UndampedClass(IntEnum):
    """Class of the steady sliding of a drive with two coordinates; the values are the ``int8`` flags of datasets."""

    STABLE = 0  # no eigenvalue in the right half plane; without damping, all frequencies real
    DIVERGENCE = 1  # a growing motion without oscillation, although the mass matrix has a positive determinant
    FLUTTER = 2  # growing oscillation; without damping, mode coupling
    KINEMATIC_CONSTRAINT = 3  # det M ≤ 0: the constraint turns an inertia negative (Painlevé's paradoxes)


def steady_law(drive: Drive) -> int:
    """Return the law s_0 of steady sliding (:func:`sliding_law`); ``InputError`` if the contact carries no force.

    Without friction both laws are one, and it is 1.
    """
    law = sliding_law(drive)
    if law or not (drive.friction_coefficient or drive.collar_friction or friction.depends_on_speed(drive)):
        return law or 1
    raise InputError("axial_force balances damping and friction exactly, so the contact carries no force.")


def sliding_law(drive: Drive) -> int:
    """Law s_0 = sgn(N_0 Ω) of steady sliding, N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω − F_0 sgn Ω (eq. 8.15).

    F_0 is the friction of the slide where there is one. Zero if the contact carries no force.
    """
    require_direction(drive)
    sense, d = 1 if drive.input_speed > 0 else -1, drive.exact()
    with many_digits():
        force = net_force(vars(d), d.tan_lead, sense)
    return sense * (int(force > 0) - int(force < 0))


def parts_of(drive: DriveValues, law: int) -> LinearParts:
    """Return what the polynomial of steady sliding under law s = ±1 is made of, in the arithmetic of the parameters."""
    if isinstance(drive, ExactParameters):
        return LinearParts.of(vars(drive), law, drive.tan_lead)
    values = {key: np.asarray(value, dtype=float) for key, value in dict(drive).items()}
    return LinearParts.of(values, law, np.tan(values["lead_angle"]))


def polynomial(drive: DriveValues, law: int) -> Polynomial:
    """Return the coefficients of det(M s² + C s + K), highest power first, in the arithmetic of the parameters."""
    with many_digits():
        parts = parts_of(drive, law)
        return tuple(x / parts.excess for x in parts.polynomial())


def state_matrices(values: Mapping[str, ArrayLike], law: int) -> NDArray[np.float64]:
    """Return the state matrices (..., n, n) in slip under law s = ±1 with constant friction, by Newton's laws.

    ``values``: the keys of drives with the same parts, with arrays that broadcast to (...); others than those of parts
    are as in Table 8.1 if they are not given. The state is that of motions (:mod:`lsvib.drives.mechanism`). An entry of
    which doubles do not hold 1e-13 is not a number.
    """
    from lsvib.drives.many import ManyDrives  # of grids alone
    from lsvib.drives.mechanism import Mechanism

    shape = np.broadcast_shapes(*map(np.shape, values.values()))
    given = {key: np.broadcast_to(value, shape).ravel() for key, value in values.items()}
    drives = ManyDrives({**dict(Drive()), **given})
    parts = tuple(part for part, (first, *_) in PARTS.items() if first in values)
    d = drives.doubles(np.arange(drives.size), np.longdouble)
    mechanism = Mechanism(d, parts, d.steady_friction)
    rows = mechanism.solve(1, law, (1,) * len(mechanism.own)).field
    columns = [np.broadcast_to(np.asarray(x, dtype=float), (drives.size,)) for row in rows for x in row[:-1]]
    return np.stack(columns, axis=-1).reshape(*shape, len(rows), len(rows))


def eigenvalues(values: Mapping[str, ArrayLike], law: int) -> NDArray[np.complex128]:
    """Eigenvalues [1/s] in ascending real part, shape (..., n), by LAPACK; arguments of :func:`state_matrices`."""
    found = np.linalg.eigvals(state_matrices(values, law)).astype(complex)
    return np.take_along_axis(found, np.argsort(found.real, axis=-1), axis=-1)


def eigenvalue_pair(inertia: ArrayLike, damping: ArrayLike, stiffness: ArrayLike) -> NDArray[np.complex128]:
    """Eigenvalues of Γ_0 ü + C_0 u̇ + k u = 0 at the origin (8.18), to full precision also where they nearly coincide.

    Arguments: effective inertia Γ_0 [kg m²], effective damping C_0 [N m s/rad], stiffness k [N m/rad]; of any sign;
    shapes that broadcast. Returns complex numbers [1/s] of the broadcast shape with a last axis of two, in ascending
    real part, then ascending imaginary part. The larger root is formed without subtraction and the other one from the
    product k/Γ_0. Where Γ_0 = 0 the motion is of first order: −k/C_0 first, then NaN, as there is no second eigenvalue.
    """
    gamma, c, k = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (inertia, damping, stiffness)))
    # The rounding errors of both products are added back, so nearly equal roots keep their digits.
    (square, of_square), (product, of_product) = _rounded_product(c, c), _rounded_product(4 * k, gamma)
    discriminant = (square - product) + (of_square - of_product)
    sign = np.where(c < 0, -1.0, 1.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        q = -(c + sign * np.sqrt(discriminant.astype(complex))) / 2
        first = np.where(gamma == 0, np.nan, q / gamma)
        # q vanishes only with C_0 = 0 and k Γ_0 = 0, where both eigenvalues are zero.
        second = np.where(discriminant < 0, first.conj(), np.where(q == 0, 0.0, k / q))
    return np.sort(np.stack([first, second], axis=-1), axis=-1)


def _rounded_product(a: Any, b: Any) -> tuple[Any, Any]:
    """The rounded product of doubles and what its rounding has cut off, by Dekker's splitting (1971)."""
    (a_high, a_low), (b_high, b_low) = (
        (t - (t - x), x - (t - (t - x))) for x, t in ((a, 134217729 * a), (b, 134217729 * b))
    )
    p = a * b
    return p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low


def reciprocal_squares(values: Mapping[str, ArrayLike], law: int) -> NDArray[np.complex128]:
    """Return 1/ω² of det(K − ω² M) = 0 [s²] of drives with two coordinates, both roots along a new last axis.

    They are the eigenvalues of K⁻¹ M; damping plays no part. As det K > 0 in every drive, 1/ω² stays finite where an
    inertia vanishes and ω² passes through infinity (eq. 8.27): a real one then changes its sign in a simple root.
    """
    undamped = {key: 0.0 if key.endswith("_damping") else value for key, value in values.items()}
    a_4, _, minus_a_2, _, a_0 = polynomial(undamped, law)
    return eigenvalue_pair(a_0, -minus_a_2, a_4)


def undamped_class(values: Mapping[str, ArrayLike], law: int) -> NDArray[np.int8]:
    """Return the :class:`UndampedClass` of M q″ + K q = 0 by its eigenvalues 1/ω², point by point; det K > 0."""
    squares = reciprocal_squares(values, law)
    # det K > 0, so the product of both 1/ω² has the sign of det M: it is negative for exactly one negative 1/ω².
    complex_pair = squares[..., 0].imag != 0
    lower, upper = squares[..., 0].real, squares[..., 1].real
    kinds = [UndampedClass.FLUTTER, UndampedClass.STABLE, UndampedClass.DIVERGENCE]
    return np.select([complex_pair, lower > 0, upper < 0], kinds, UndampedClass.KINEMATIC_CONSTRAINT).astype(np.int8)


def _beside(number: arb, digits: int) -> tuple[fmpq, ...]:
    """Rationals just below and just above a number, a relative 10^−digits apart from it."""
    return tuple((number.mid() * (1 + side * arb(10) ** -digits)).mid().fmpq() for side in (-1, 1))


def enclosed(drive: Drive, digits: int = 100) -> tuple[tuple[dict[str, fmpq], fmpq], ...]:
    """Return the parameters as rationals and tan λ, twice: all that is no rational just below and above its value.

    That is tan λ, and ``secant`` and what :func:`lsvib.drives.friction.decays` gives beside the parameters.
    """
    values = {key: fmpq(*value.as_integer_ratio()) for key, value in drive}
    with ctx.workdps(digits + 10):
        sine, cosine = arb(drive.lead_angle).sin_cos()
        secant = 1 / cosine
        left = friction.decays(drive.exact(), arb(drive.pitch_radius) * abs(arb(drive.input_speed)) * secant)
        # What is left of a rise may have no end of digits; so little of it counts only where nothing else does.
        ends = {name: _beside(x, digits) if x > LEAST else (LEAST**3, LEAST) for name, x in left.items()}
        ends["secant"], tangents = _beside(secant, digits), _beside(sine * secant, digits)
        return tuple(({**values, **{name: end[k] for name, end in ends.items()}}, tangents[k]) for k in (0, 1))


def spectrum(drive: Drive, law: int) -> tuple[str, list[complex], Polynomial]:
    """Class, eigenvalues [1/s] in ascending real part, and det(M s² + C s + K) of the steady sliding of a drive.

    Of the rigid drive (8.18) the class is ``stable_node``, ``stable_focus``, ``centre``, ``unstable_focus``,
    ``unstable_node`` or ``saddle``. Of a drive of more bodies it is ``stable`` (asymptotically), ``neutral`` (no
    eigenvalue to the right of the imaginary axis, simple ones on it, as without damping), ``kinematic_constraint`` (det
    M < 0), else ``divergence`` or ``flutter`` by whether the eigenvalue that grows fastest is real. Signs are certain,
    eigenvalues rounded once. Raises ``InputError`` where μ is below cot λ only by the rounding of cot λ to a double.
    """
    digits = 100
    parameters, tangent = enclosed(drive, digits)[1]
    if friction.steady(parameters, tangent)[0] * tangent >= 1:
        raise InputError(f"friction_coefficient = {drive.friction_coefficient!r} is not below cot(lead_angle).")
    # The class depends on signs of polynomials in tan λ alone, so enough digits give the same one at both ends; where
    # one vanishes to some 80 digits, four times as many.
    while True:
        parts, other = (LinearParts.of(values, law, t) for values, t in enclosed(drive, digits))
        exact = parts.polynomial()
        if (kind := _class(exact)) == _class(other.polynomial()):
            break
        digits *= 4
    roots = (complex(float(root.real), float(root.imag)) for root in _all_roots(exact))
    values = sorted(roots, key=lambda z: (z.real, z.imag))
    if kind == "unstable":
        kind = "divergence" if values[-1].imag == 0 else "flutter"
    return kind, values, tuple(p / fmpq(parts.excess) for p in exact)


def hurwitz(p: tuple[Any, ...], order: int = 3, same: bool = False) -> Any:
    """Hurwitz determinant of a polynomial, highest power first: its entry i, j is the coefficient 2 j − i, from 1 on.

    Of a quartic that of order 3 is (p_3 p_2 − p_4 p_1) p_1 − p_3² p_0, and zero where s and −s are both roots, as that
    of order n − 1 is of any degree n. With ``same`` all its terms count with one sign.
    """

    turned = 1 if same else -1
    if order == 3:
        first, second, third, fourth, fifth, sixth = (*p, 0)[:6]
        inner = third * fourth + turned * second * fifth
        return second * inner + turned * first * fourth**2 + sixth * first * second

    @cache
    def minor(column: int, rows: tuple[int, ...]) -> Any:
        if not rows:
            return 1
        total: Any = 0
        for k, row in enumerate(rows):
            if 0 <= (place := 2 * column - row) < len(p):
                total = total + turned**k * p[place] * minor(column + 1, rows[:k] + rows[k + 1 :])
        return total

    return minor(1, tuple(range(1, order + 1)))


def margins(p: Polynomial, neutral: bool) -> Iterator[Any]:
    """Yield numbers that are all positive exactly where steady sliding is stable; p_0 always is.

    Those are the coefficients and the Hurwitz determinants of odd order (Liénard and Chipart). Without damping
    (``neutral``) they are those for which no motion grows and all frequencies are real and distinct: with two of them
    p_4, p_2 and p_2² − 4 p_4 p_0; with more those of q(s²) + s q′(s²), whose even and odd parts interlace just then
    (Hermite and Biehler), of the polynomial q(s²). The last ones take most of the work.
    """
    order = len(p) - 1
    if neutral and order == 4:
        yield from (p[0], p[2], p[2] ** 2 - 4 * p[0] * p[4])
        return
    if neutral and order > 4:
        p = interlaced(p)
    yield from p[:1] if neutral and order == 2 else p[:-1]
    yield from (hurwitz(p, k) for k in range(3, order, 2))


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
            return "saddle"
        if damping == 0:
            return "centre"
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


def positive_roots(p: Any, limit: fmpq) -> list[fmpq]:
    """Distinct roots in (0, limit] of a polynomial that is not zero, in ascending order, each to a relative 2⁻⁹⁰."""
    with ctx.workprec(100):
        roots = [root.real.mid().fmpq() for root, _ in p.complex_roots() if root.imag == 0]
    return sorted(root for root in roots if 0 < root <= limit)


def _all_roots(p: Polynomial) -> list[acb]:
    """All roots, those that coincide as often as they do, each part to a relative 2⁻⁹⁰, or exactly zero."""
    both = fmpq_poly(list(reversed(p)))
    # Imaginary ones are those that the parts of even and of odd powers share, in s²; FLINT isolates the real ones.
    shared: Any = fmpq_poly(both.coeffs()[::2]).gcd(fmpq_poly(both.coeffs()[1::2]))
    rest: Any = both // fmpq_poly([c for x in shared.coeffs() for c in (x, 0)])
    bits = 100
    while True:
        with ctx.workprec(bits):
            found = [root for root, n in rest.complex_roots() for _ in range(n)]
            for square, n in shared.complex_roots():  # a part that vanishes is exactly zero
                root = square.sqrt()
                if square.imag == 0:
                    root = acb(0, (-square.real).sqrt()) if square.real < 0 else acb(square.real.sqrt())
                found += [root, -root] * n
        if all(part == 0 or part.rel_accuracy_bits() >= 90 for root in found for part in (root.real, root.imag)):
            return found
        bits *= 2
