"""Linearised equations of motion in steady sliding, their eigenvalues and classes, whole grids at once.

The rigid drive reads Γ_0 u″ + C_0 u′ + k u = 0. Compliant threads, axial support and rotating nut have two coordinates
q and read M q″ + C q′ + K q = 0. With a screw that turns at θ′, a nut at x, and the contact force N of law s
(μ_s = s μ, Sect. 5.3), Newton's laws are

    I θ″ = T + a N            a = r_m (sin λ − μ_s cos λ) = −r_m ξ_s b
    m x″ = P − b N            b = cos λ + μ_s sin λ

with T = k (Ω t − θ) − c θ′ and P = R − c_x x′. The models differ in what ties x to θ. Coulomb friction F_0 and T_0 is
constant in steady sliding, so it shifts the equilibrium – and may turn the sign of N – but is in no matrix. Where μ
depends on the sliding speed v = r_m θ′ / cos λ, it is that of steady sliding here, and a change of v by v′ changes
friction by ν v′ with ν = |N_0| dμ/dv, which has the lever r_m cos λ against the screw and the share sin λ against the
nut.

The entries are plain arithmetic: they serve floats, numpy arrays that broadcast and balls (Arb) alike. The class of one
drive, decided with certainty, is the matter of :mod:`lsvib.stability.spectrum`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import ArrayLike, NDArray

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.errors import InputError
from lsvib.models import friction, mechanics
from lsvib.models.drive import Drive, ExactParameters

TwoByTwo = tuple[tuple[Any, Any], tuple[Any, Any]]
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
    """Class of the steady sliding of a model with two coordinates; the values are the ``int8`` flags of datasets."""

    STABLE = 0  # no eigenvalue in the right half plane; without damping, all frequencies real
    DIVERGENCE = 1  # a growing motion without oscillation, although the mass matrix has a positive determinant
    FLUTTER = 2  # growing oscillation; without damping, mode coupling
    KINEMATIC_CONSTRAINT = 3  # det M ≤ 0: the constraint turns an inertia negative (Painlevé's paradoxes)


@dataclass(frozen=True)
class LinearModel:
    """M q″ + C q′ + K q = 0 with two coordinates; each entry of a matrix is a float, an array or a ball."""

    mass: TwoByTwo
    damping: TwoByTwo
    stiffness: TwoByTwo

    def polynomial(self) -> tuple[Any, Any, Any, Any, Any]:
        """Return the coefficients of det(M s² + C s + K), highest power first, in the arithmetic of the entries."""
        m, c, k = self.mass, self.damping, self.stiffness
        with many_digits():
            return determinant(m), _mixed(m, c), determinant(c) + _mixed(m, k), _mixed(c, k), determinant(k)

    def jacobian(self) -> NDArray[np.float64]:
        """Return the state matrix of [q_1, q_1′, q_2, q_2′], shape (..., 4, 4) for entries that broadcast to (...)."""
        rate, place = _solved(self.mass, self.damping), _solved(self.mass, self.stiffness)
        shape = np.broadcast_shapes(*(np.shape(x) for matrix in (rate, place) for row in matrix for x in row))
        jacobian = np.zeros((*shape, 4, 4))
        for i in (0, 1):
            jacobian[..., 2 * i, 2 * i + 1] = 1.0
            for j in (0, 1):
                jacobian[..., 2 * i + 1, 2 * j] = -place[i][j]
                jacobian[..., 2 * i + 1, 2 * j + 1] = -rate[i][j]
        return jacobian


def steady_law(drive: Drive) -> int:
    """Return the law s_0 of steady sliding (:func:`sliding_law`); ``InputError`` if the contact carries no force."""
    if law := sliding_law(drive):
        return law
    raise InputError("axial_force balances damping and friction exactly, so the contact carries no force.")


def sliding_law(drive: Drive) -> int:
    """Law s_0 = sgn(N_0 Ω) of steady sliding, N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω − F_0 sgn Ω (eq. 8.15).

    F_0 is the friction of the slide where there is one. Zero if the contact carries no force.
    """
    sense = 1 if drive.input_speed > 0 else -1
    d = drive.exact()
    with many_digits():
        # The friction first: it can balance R but for a drag that is far smaller. Balls of no radius subtract exactly.
        rest = d.axial_force - sense * getattr(d, "slide_friction", arb(0))
        force = rest - d.pitch_radius * d.tan_lead * d.translation_damping * d.input_speed
    return sense * (int(force > 0) - int(force < 0))


def threads_model(drive: DriveValues, law: int) -> LinearModel:
    """Linearised drive with compliant threads (Sect. 5.5, eqs 8.6, 8.7), coordinates q = (z, e).

    x = r_m tan λ θ + e; the contact is compressed by δ = e cos λ and carries N = k_c δ + c_c δ′. Hence

        I z″ + c z′ + k z − a cos λ (k_c e + c_c e′) = 0
        m (r_m tan λ z″ + e″) + c_x (r_m tan λ z′ + e′) + b cos λ (k_c e + c_c e′) = 0

    and det(M s² + C s + K) = (I s² + c s + k)(m s² + c_x s) + b cos λ (k_c + c_c s)(Γ_s s² + C_s s + k): the last
    factor is the rigid drive (8.13). The slope of friction adds r_m² ν z′ to the first equation and r_m tan λ ν z′ to
    the second. The state matrix is that of [z, θ′, e, e′].

    Arguments: drive with ``contact_stiffness`` k_c [N/m] and ``contact_damping`` c_c [N s/m]; law s = ±1. Units of the
    first equation [N m], of the second [N].
    """
    p = values_of(drive, law)
    with many_digits():
        lead = p.pitch_radius * p.tan_lead
        b = p.cos_lead * (1 + law * p.steady_friction * p.tan_lead)
        a = -p.pitch_radius * p.factor * b
        stiffness, damping = p.cos_lead * p.contact_stiffness, p.cos_lead * p.contact_damping
        return LinearModel(
            mass=((p.screw_inertia, 0), (p.mass * lead, p.mass)),
            damping=(
                (p.support_damping + p.slope, -a * damping),
                (p.translation_damping * lead + p.slope_on_nut, p.translation_damping + b * damping),
            ),
            stiffness=((p.coupling_stiffness, -a * stiffness), (0, b * stiffness)),
        )


def support_model(drive: DriveValues, law: int) -> LinearModel:
    """Linearised drive with a compliant axial support (Sect. 5.6; M and K of eq. 8.23), coordinates q = (θ, x_1).

    The screw of mass m_1 can shift by x_1 against k_1 and c_1: x = r_m tan λ θ + x_1 and
    m_1 x_1″ = b N − k_1 x_1 − c_1 x_1′. With b N = R − c_x x′ − m x″ from the nut and a/b = −r_m ξ_s,

        (I − ξ_s m r_m² tan λ) θ″ − ξ_s r_m m x_1″ + (c − ξ_s c_x r_m² tan λ) θ′ − ξ_s r_m c_x x_1′ + k θ = 0
        m r_m tan λ θ″ + (m + m_1) x_1″ + c_x r_m tan λ θ′ + (c_x + c_1) x_1′ + k_1 x_1 = 0

    The slope of friction adds r_m² ν (1 − ξ_s tan λ) θ′ to the first equation.
    Arguments as :func:`threads_model`, with ``screw_mass`` m_1 [kg], ``support_stiffness`` k_1 [N/m] and
    ``axial_support_damping`` c_1 [N s/m] (not the c_1 of eq. 8.15, which is c_x).
    """
    p = values_of(drive, law)
    with many_digits():
        lead, lever = p.pitch_radius * p.tan_lead, p.factor * p.pitch_radius
        return LinearModel(
            mass=((p.screw_inertia - lever * lead * p.mass, -lever * p.mass), (lead * p.mass, p.mass + p.screw_mass)),
            damping=(
                (
                    p.support_damping - lever * lead * p.translation_damping + p.sloped,
                    -lever * p.translation_damping,
                ),
                (lead * p.translation_damping, p.translation_damping + p.axial_support_damping),
            ),
            stiffness=((p.coupling_stiffness, 0), (0, p.support_stiffness)),
        )


def nut_model(drive: DriveValues, law: int) -> LinearModel:
    """Linearised drive whose nut can rotate (Sect. 5.8, matrices above eq. 8.33), coordinates q = (θ, θ_2).

    x = r_m tan λ (θ − θ_2), I_2 θ_2″ = −k_2 θ_2 − c_2 θ_2′ − a N. With χ = ξ_s r_m² tan λ all three matrices are
    symmetric: M = diag(I, I_2) − m χ D, C = diag(c, c_2) − c_x χ D, K = diag(k, k_2), D = [[1, −1], [−1, 1]]. (The
    chapter prints them for c_x = 0.) The slope of friction adds r_m² ν (1 − ξ_s tan λ) D to C, as the threads slip at
    θ′ − θ_2′.

    Arguments as :func:`threads_model`, with ``nut_inertia`` I_2 [kg m²], ``nut_stiffness`` k_2 [N m/rad] and
    ``nut_damping`` c_2 [N m s/rad].
    """
    p = values_of(drive, law)
    with many_digits():
        lever = p.factor * p.pitch_radius**2 * p.tan_lead
        mass, damping = lever * p.mass, lever * p.translation_damping - p.sloped
        return LinearModel(
            mass=((p.screw_inertia - mass, mass), (mass, p.nut_inertia - mass)),
            damping=((p.support_damping - damping, damping), (damping, p.nut_damping - damping)),
            stiffness=((p.coupling_stiffness, 0), (0, p.nut_stiffness)),
        )


def determinant(a: TwoByTwo) -> Any:
    """Determinant of a 2 × 2 matrix, in the arithmetic of its entries."""
    return a[0][0] * a[1][1] - a[0][1] * a[1][0]


def _mixed(a: TwoByTwo, b: TwoByTwo) -> Any:
    """Term of det(A + B) that is linear in both A and B."""
    return a[0][0] * b[1][1] + a[1][1] * b[0][0] - a[0][1] * b[1][0] - a[1][0] * b[0][1]


def _solved(a: TwoByTwo, b: TwoByTwo) -> TwoByTwo:
    """A⁻¹ B by Cramer's rule."""
    det = determinant(a)
    first = tuple((a[1][1] * b[0][j] - a[0][1] * b[1][j]) / det for j in (0, 1))
    second = tuple((a[0][0] * b[1][j] - a[1][0] * b[0][j]) / det for j in (0, 1))
    return first, second


def values_of(drive: DriveValues, law: int) -> SimpleNamespace:
    """Return the parameters as attributes, with sin λ, cos λ, tan λ and, as ``factor``, ξ_s of the law s = ±1.

    ``steady_friction`` is μ in steady sliding; its slope over the speed gives the dampings ``slope``, r_m² ν,
    ``slope_on_nut``, r_m tan λ ν, and ``sloped``, r_m² ν (1 − ξ_s tan λ) = r_m² ν (1 + tan² λ) / (1 + s μ tan λ).
    """
    if isinstance(drive, ExactParameters):
        p = SimpleNamespace(**vars(drive))
    else:
        p = SimpleNamespace(**{key: np.asarray(value, dtype=float) for key, value in dict(drive).items()})
        p.sin_lead, p.cos_lead, p.tan_lead = (f(p.lead_angle) for f in (np.sin, np.cos, np.tan))
    p.steady_friction, p.slope, p.slope_on_nut, p.sloped = p.friction_coefficient, 0, 0, 0
    with many_digits():
        moves = friction.moves(vars(p))
        if moves:
            p.steady_friction, rate = friction.steady(vars(p), p.tan_lead)
        p.factor = mechanics.friction_factor(p.steady_friction, p.tan_lead, law)
        if moves:
            force = mechanics.carried(vars(p), p.tan_lead, law)
            geometry = p.pitch_radius, p.cos_lead, p.tan_lead
            p.sloped = mechanics.damping_by_slope(rate, force, p.steady_friction, *geometry, law)
            p.slope = p.sloped * (1 + law * p.steady_friction * p.tan_lead) / (1 + p.tan_lead**2)
            p.slope_on_nut = p.slope * p.tan_lead / p.pitch_radius
    return p


def eigenvalue_pair(inertia: ArrayLike, damping: ArrayLike, stiffness: ArrayLike) -> NDArray[np.complex128]:
    """Eigenvalues of Γ_0 ü + C_0 u̇ + k u = 0 at the origin (8.18), to full precision also where they nearly coincide.

    Arguments: effective inertia Γ_0 [kg m²], effective damping C_0 [N m s/rad], stiffness k [N m/rad]; of any
    sign; shapes that broadcast. Returns complex numbers [1/s] of the broadcast shape with a last axis of
    two, in ascending real part, then ascending imaginary part. The larger root is formed without subtraction and the
    other one from the product k/Γ_0. Where Γ_0 = 0 the motion is of first order: −k/C_0 first, then NaN, as there is no
    second eigenvalue.
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


def reciprocal_squares(model: LinearModel) -> NDArray[np.complex128]:
    """Return 1/ω² of det(K − ω² M) = 0 [s²], both roots along a new last axis; damping plays no part.

    They are the eigenvalues of K⁻¹ M. As det K > 0 in every model here, 1/ω² stays finite where an inertia vanishes and
    ω² passes through infinity (eq. 8.27): a real one then changes its sign in a simple root.
    """
    a_4, _, minus_a_2, _, a_0 = LinearModel(model.mass, ((0, 0), (0, 0)), model.stiffness).polynomial()
    return eigenvalue_pair(a_0, -minus_a_2, a_4)


def undamped_class(model: LinearModel) -> NDArray[np.int8]:
    """Return the :class:`UndampedClass` of M q″ + K q = 0 by its eigenvalues 1/ω², point by point; det K > 0."""
    squares = reciprocal_squares(model)
    # det K > 0, so the product of both 1/ω² has the sign of det M: it is negative for exactly one negative 1/ω².
    complex_pair = squares[..., 0].imag != 0
    lower, upper = squares[..., 0].real, squares[..., 1].real
    kinds = [UndampedClass.FLUTTER, UndampedClass.STABLE, UndampedClass.DIVERGENCE]
    return np.select([complex_pair, lower > 0, upper < 0], kinds, UndampedClass.KINEMATIC_CONSTRAINT).astype(np.int8)


def eigenvalues(model: LinearModel) -> NDArray[np.complex128]:
    """Eigenvalues [1/s] of M q″ + C q′ + K q = 0, shape (..., 4), by LAPACK on the balanced state matrix.

    In ascending real part; they are those of :meth:`LinearModel.jacobian`. det M must not vanish.
    """
    values = np.linalg.eigvals(model.jacobian()).astype(complex)
    return np.take_along_axis(values, np.argsort(values.real, axis=-1), axis=-1)


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
