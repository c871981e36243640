"""Steady sliding linearised: its state matrix, eigenvalues and classes, whole grids at once.

The state matrix is what Newton's laws of the drive say in slip (:mod:`lsvib.models.mechanism`); the polynomial is that
of :class:`lsvib.models.mechanics.LinearParts`, det(M s² + C s + K) of the matrices that the chapter prints. Coulomb
friction F_0 and T_0 is constant in steady sliding, so it shifts the equilibrium – and may turn the sign of N – but is
in neither. The class of one drive, decided with certainty, is the matter of :mod:`lsvib.stability.spectrum`.
"""

from collections.abc import Mapping
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.errors import InputError
from lsvib.models import friction, mechanics
from lsvib.models.drive import PARTS, Drive, ExactParameters

DriveValues = Drive | ExactParameters | Mapping[str, ArrayLike]
"""A drive in doubles, the same in balls (``drive.exact()``), or its keys with arrays that broadcast."""


class Stability(IntEnum):
    """Class of the steady sliding of the rigid drive by its eigenvalues; the values are ``int8`` flags of datasets."""

    STABLE_NODE = 0
    STABLE_FOCUS = 1
    CENTRE = 2
    UNSTABLE_FOCUS = 3
    UNSTABLE_NODE = 4
    SADDLE = 5
    DEGENERATE = 6


class UndampedClass(IntEnum):
    """Class of the steady sliding of a drive with two coordinates; the values are the ``int8`` flags of datasets."""

    STABLE = 0  # no eigenvalue in the right half plane; without damping, all frequencies real
    DIVERGENCE = 1  # a growing motion without oscillation, although the mass matrix has a positive determinant
    FLUTTER = 2  # growing oscillation; without damping, mode coupling
    KINEMATIC_CONSTRAINT = 3  # det M ≤ 0: the constraint turns an inertia negative (Painlevé's paradoxes)


def steady_law(drive: Drive) -> int:
    """Return the law s_0 of steady sliding (:func:`sliding_law`); ``InputError`` if the contact carries no force."""
    if law := sliding_law(drive):
        return law
    raise InputError("axial_force balances damping and friction exactly, so the contact carries no force.")


def sliding_law(drive: Drive) -> int:
    """Law s_0 = sgn(N_0 Ω) of steady sliding, N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω − F_0 sgn Ω (eq. 8.15).

    F_0 is the friction of the slide where there is one. Zero if the contact carries no force.
    """
    sense, d = 1 if drive.input_speed > 0 else -1, drive.exact()
    with many_digits():
        force = mechanics.net_force(vars(d), d.tan_lead, sense)
    return sense * (int(force > 0) - int(force < 0))


def state_matrices(values: Mapping[str, ArrayLike], law: int) -> NDArray[np.float64]:
    """Return the state matrices (..., n, n) in slip under law s = ±1 with constant friction, by Newton's laws.

    ``values``: the keys of drives with the same parts, with arrays that broadcast to (...); others than those of parts
    are as in Table 8.1 if they are not given. The state is that of motions (:mod:`lsvib.models.mechanism`). An entry of
    which doubles do not hold 1e-13 is not a number.
    """
    from lsvib.models.many import ManyDrives  # of grids alone
    from lsvib.models.mechanism import Mechanism

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


def polynomial(drive: DriveValues, law: int) -> tuple[Any, ...]:
    """Return the coefficients of det(M s² + C s + K), highest power first, in the arithmetic of the parameters."""
    p = values_of(drive, law)
    with many_digits():
        parts = mechanics.LinearParts.of(vars(p), law, p.tan_lead)
        return tuple(x / parts.excess for x in parts.polynomial())


def values_of(drive: DriveValues, law: int) -> SimpleNamespace:
    """Return the parameters as attributes, with sin λ, cos λ, tan λ, and ξ_s of the law s = ±1 as ``factor``.

    Of a drive with a collar s μ_b r_b / r_m is added to it.

    ``steady_friction`` is μ in steady sliding, and ν = |N_0| dμ/dv how it changes with the sliding speed v = r_m θ′ /
    cos λ; that gives the dampings ``slope``, r_m² ν, of the screw alone, and ``sloped``, r_m² ν (1 + tan² λ) / (1 + s μ
    tan λ), of the rigid drive.
    """
    if isinstance(drive, ExactParameters):
        p = SimpleNamespace(**vars(drive))
    else:
        p = SimpleNamespace(**{key: np.asarray(value, dtype=float) for key, value in dict(drive).items()})
        p.sin_lead, p.cos_lead, p.tan_lead = (f(p.lead_angle) for f in (np.sin, np.cos, np.tan))
    p.steady_friction, p.slope, p.sloped = p.friction_coefficient, 0, 0
    with many_digits():
        moves = friction.moves(vars(p))
        if moves:
            p.steady_friction, rate = friction.steady(vars(p), p.tan_lead)
        p.factor = mechanics.friction_factor(p.steady_friction, p.tan_lead, law) + law * friction.collar(p)
        if moves:
            force = mechanics.carried(vars(p), p.tan_lead, law)
            geometry = p.pitch_radius, p.cos_lead, p.tan_lead
            p.sloped = mechanics.damping_by_slope(rate, force, p.steady_friction, *geometry, law)
            p.slope = p.sloped * (1 + law * p.steady_friction * p.tan_lead) / (1 + p.tan_lead**2)
    return p


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
        root = np.sqrt(np.abs(discriminant))
        q = -(c + sign * root) / 2
        first = q / gamma
        # q vanishes only with C_0 = 0 and k Γ_0 = 0, where both eigenvalues are zero.
        second = np.where(q == 0, 0.0, k / q)
        pair = np.stack([np.fmin(first, second) + 0j, np.fmax(first, second) + 0j], axis=-1)
        centre = -c / (2 * gamma)
        half = np.abs(root / (2 * gamma))
        focus = np.stack([centre - 1j * half, centre + 1j * half], axis=-1)
        flat = np.stack([-k / c + 0j, np.full_like(c, np.nan) + 0j], axis=-1)
    pair = np.where((discriminant < 0)[..., None], focus, pair)
    return np.where((gamma == 0)[..., None], flat, pair)


def stability_class(inertia: ArrayLike, damping: ArrayLike, stiffness: ArrayLike) -> NDArray[np.int8]:
    """Class of the steady sliding (:class:`Stability`) by its eigenvalues (8.18); arguments of :func:`eigenvalue_pair`.

    k > 0. A pair that coincides counts as a node, Γ_0 = 0 as degenerate.
    """
    pair = eigenvalue_pair(inertia, damping, stiffness)
    low, high = pair[..., 0], pair[..., 1]
    oscillates = high.imag != 0
    first_of = {
        Stability.DEGENERATE: np.isnan(high.real),
        Stability.STABLE_FOCUS: oscillates & (high.real < 0),
        Stability.UNSTABLE_FOCUS: oscillates & (high.real > 0),
        Stability.CENTRE: oscillates,
        Stability.STABLE_NODE: high.real < 0,
        Stability.UNSTABLE_NODE: low.real > 0,
    }
    return np.select([*first_of.values()], [*first_of], Stability.SADDLE).astype(np.int8)


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

    def minor(column: int, rows: tuple[int, ...]) -> Any:
        """The determinant of some rows, from a column on."""
        if not rows:
            return 1
        total: Any = 0
        for k, row in enumerate(rows):
            if 0 <= (place := 2 * column - row) < len(p):
                total = total + turned**k * p[place] * minor(column + 1, rows[:k] + rows[k + 1 :])
        return total

    return minor(1, tuple(range(1, order + 1)))


def routh_hurwitz(p: tuple[Any, ...]) -> bool:
    """Whether all roots of p_4 s⁴ + … + p_0, p_4 > 0, have negative real parts; in balls only where it is certain."""
    with many_digits():
        return all(x > 0 for x in (*p[1:], hurwitz(p)))
