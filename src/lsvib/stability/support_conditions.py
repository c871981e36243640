"""Axial support: the printed polynomial (8.23), conditions (8.24)–(8.28), and boundaries (8.29)–(8.32) in closed form.

Functions take the ``DriveValues`` of a drive (:mod:`lsvib.stability.linear`) and the law s = ±1. With
χ = ξ_s r_m² tan λ, S = m + m_1 and m̃ = m m_1 / S the printed quantities are Γ_0 = I − m χ and Γ̃_0 = I − m̃ χ.
"""

import math
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models import mechanics
from lsvib.models.drive import SupportDrive
from lsvib.numbers import bisected
from lsvib.stability.linear import DriveValues, UndampedClass, reciprocal_squares, support_model, values_of


def characteristic_polynomial(drive: DriveValues, law: int) -> tuple[Any, Any, Any]:
    """Return a_4, a_2, a_0 of det(K − ω² M) = a_4 ω⁴ + a_2 ω² + a_0 as printed below eq. 8.23, undamped (SI units)."""
    p = values_of(drive, law)
    with many_digits():
        lever = p.factor * p.pitch_radius**2 * p.tan_lead
        total = p.mass + p.screw_mass
        return (
            p.screw_inertia * total - p.mass * p.screw_mass * lever,
            -p.coupling_stiffness * total - p.support_stiffness * (p.screw_inertia - lever * p.mass),
            p.coupling_stiffness * p.support_stiffness,
        )


def printed_class(drive: DriveValues, law: int) -> NDArray[np.int8]:
    """Class (:class:`UndampedClass`) by the printed conditions (8.24) to (8.26).

    a_4 < 0 is kinematic, a_2² < 4 a_0 a_4 flutter, a_4 > 0 with a_2 > 0 divergence; flutter where the last two hold.
    """
    a_4, a_2, a_0 = characteristic_polynomial(drive, law)
    conditions = [a_4 < 0, a_2**2 - 4 * a_0 * a_4 < 0, (a_4 > 0) & (a_2 > 0)]
    kinds = [UndampedClass.KINEMATIC_CONSTRAINT, UndampedClass.FLUTTER, UndampedClass.DIVERGENCE]
    return np.select(np.broadcast_arrays(*conditions), kinds, UndampedClass.STABLE).astype(np.int8)


def reduced_mass(drive: DriveValues) -> Any:
    """Return m̃ = m m_1 / (m + m_1) [kg]."""
    p = values_of(drive, 1)
    with many_digits():
        return p.mass * p.screw_mass / (p.mass + p.screw_mass)


def reduced_inertia(drive: DriveValues, law: int) -> Any:
    """Return Γ̃_0 = I − ξ_s tan λ m̃ r_m² [kg m²] (eqs 8.27, 8.28)."""
    p = values_of(drive, law)
    with many_digits():
        return mechanics.effective_inertia(p.screw_inertia, reduced_mass(drive), p.pitch_radius, p.tan_lead, p.factor)


def effective_inertia(drive: DriveValues, law: int) -> Any:
    """Return Γ_0 = I − ξ_s tan λ m r_m² [kg m²], which steady sliding needs positive as k_1 → ∞ (eq. 8.20)."""
    p = values_of(drive, law)
    with many_digits():
        return mechanics.effective_inertia(p.screw_inertia, p.mass, p.pitch_radius, p.tan_lead, p.factor)


def boundary_coefficients(drive: DriveValues, law: int) -> tuple[Any, Any, Any]:
    """Return b_1, b_2, b_3 of the flutter boundary b_1 k_1² + b_2 k k_1 + b_3 k² = 0 as printed (eq. 8.29)."""
    p = values_of(drive, law)
    turned = p.factor * p.mass * p.pitch_radius**2 * p.tan_lead
    return (
        (p.screw_inertia - turned) ** 2,
        2 * (p.screw_mass * (turned - p.screw_inertia) - p.mass * (turned + p.screw_inertia)),
        (p.mass + p.screw_mass) ** 2,
    )


def flutter_boundaries(drive: DriveValues, law: int) -> NDArray[np.float64]:
    """Support stiffness k_1 [N/m] on both branches of the flutter boundary (8.29), the lower one first, last axis.

    With A² = S Γ̃_0 and B² = m² χ the coefficients of (8.29) are −b_2 = 2 (A² + B²), b_2² − 4 b_1 b_3 = 16 A² B² and
    S Γ_0 = A² − B², so the branches are perfect squares,

        k_1 = k [S / (A + B)]²   and   k_1 = k [(A + B) / Γ_0]²,

    without any subtraction but that inside Γ_0 and Γ̃_0. They are real and positive exactly if ξ_0 ≥ 0 and Γ̃_0 ≥ 0
    (8.32), NaN elsewhere; the upper one is infinite where Γ_0 = 0. They meet at μ = tan λ in k_1 = k S / I and on the
    kinematic boundary Γ̃_0 = 0 in k_1 = k S² m̃ / (m² I). The upper one is a boundary of stability only where Γ_0 > 0:
    beyond it, where Γ_0 < 0, both modes diverge (8.25).
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        p = values_of(drive, law)
        total = p.mass + p.screw_mass
        lever = p.factor * p.pitch_radius**2 * p.tan_lead
        both = np.sqrt(total * reduced_inertia(drive, law)) + p.mass * np.sqrt(lever)
        branches = (total / both, both / effective_inertia(drive, law))
        return np.stack([p.coupling_stiffness * branch**2 for branch in branches], axis=-1)


def exact_flutter_boundaries(drive: SupportDrive, law: int) -> tuple[arb | None, arb | None]:
    """Return :func:`flutter_boundaries` of one drive [N/m] from balls, None where there is none.

    In doubles Γ_0 and Γ̃_0 lose, next to where they vanish, all digits that the stiffness is printed with.
    """
    d = drive.exact()
    p = values_of(d, law)
    with many_digits():
        reduced, whole = reduced_inertia(d, law), effective_inertia(d, law)
        lever = p.factor * p.pitch_radius**2 * p.tan_lead
        if lever < 0 or reduced < 0:
            return None, None
        total = p.mass + p.screw_mass
        both = (total * reduced).sqrt() + p.mass * lever.sqrt()
        upper = None if whole == 0 else p.coupling_stiffness * (both / whole) ** 2
        return p.coupling_stiffness * (total / both) ** 2, upper


def critical_friction_by_eigenvalues(drive: SupportDrive) -> float | None:
    """Friction coefficient μ_kc at which an eigenvalue of K⁻¹ M passes through zero, by bisection to the last bit.

    That 1/ω² belongs to the undamped model (8.23) under law +; it has a simple root where ω² has a pole, and it
    decreases as ξ₊ grows with μ. Returns None if it does not change its sign below cot λ. Independent of the closed
    form :func:`lsvib.stability.conditions.critical_friction`.
    """
    largest = math.nextafter(1 / math.tan(drive.lead_angle), 0)

    def turned(coefficient: float) -> bool:
        model = support_model({**dict(drive), "friction_coefficient": coefficient}, 1)
        return bool(np.prod(np.sign(reciprocal_squares(model).real)) < 0)

    return bisected(turned, 0.0, largest) if turned(largest) else None
