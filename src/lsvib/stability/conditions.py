"""The chapter's conditions in closed form, and the linear stability of one drive of any model (eqs 8.18–8.33).

Functions of ``DriveValues`` (:mod:`lsvib.stability.linear`) and a law s = ±1 serve whole grids, and one drive in balls.
With χ = ξ_s r_m² tan λ and S = m + m_1 the inertia of a drive with a rigid support is Γ_0 = I − m χ, and with a
compliant one Γ̃_0 = I − m̃ χ. Of compliant threads, with Γ_0 and C_0 of the steady law and β = cos λ (cos λ + s_0 μ sin
λ), the characteristic polynomial of a constant friction coefficient has the coefficients

    p_4 = I m,   p_3 = I c_x + m c + β c_c Γ_0,   p_2 = c c_x + m k + β (k_c Γ_0 + c_c C_0),
    p_1 = c_x k + β (k_c C_0 + c_c k),   p_0 = β k_c k.
"""

import math
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models import friction, mechanics
from lsvib.models.drive import Drive
from lsvib.numbers import bisected
from lsvib.results import Condition, Quantity, StabilityReport, UndampedStability
from lsvib.stability.boundaries import places, stable_set
from lsvib.stability.linear import DriveValues, UndampedClass, reciprocal_squares, steady_law, values_of
from lsvib.stability.spectrum import Polynomial, margins, spectrum

LARGEST_MASS = 1e9  # kg, the end of the range of the mass


def screw_inertia(drive: DriveValues) -> Any:
    """Return I_eff [kg m²]: I, or I I_2 / (I + I_2) where the nut may turn, which is less (Remark 8.6)."""
    p = values_of(drive, 1)
    with many_digits():
        return mechanics.together(p.screw_inertia, getattr(p, "nut_inertia", None))


def mass(drive: DriveValues) -> Any:
    """Return m_eff [kg]: m, or m̃ = m m_1 / (m + m_1) with an axial support."""
    p = values_of(drive, 1)
    with many_digits():
        return mechanics.together(p.mass, getattr(p, "screw_mass", None))


def effective_inertia(drive: DriveValues, law: int, rigid: bool = False) -> Any:
    """Return I_eff − ξ_s tan λ m_eff r_m² [kg m²] (eqs 8.2, 8.20, 8.28, 8.33); ``rigid``: Γ_s, as if no part complied.

    With rigid threads steady sliding is unstable where it is negative under the law that holds: det M < 0.
    """
    p = values_of(drive, law)
    with many_digits():
        inertia, moved = (p.screw_inertia, p.mass) if rigid else (screw_inertia(drive), mass(drive))
        return mechanics.effective_inertia(inertia, moved, p.pitch_radius, p.tan_lead, p.factor)


def effective_damping(drive: DriveValues, law: int) -> Any:
    """Return C_s = c − ξ_s tan λ c_x r_m² [N m s/rad] of the rigid drive (eq. 8.19)."""
    p = values_of(drive, law)
    with many_digits():
        return mechanics.effective_damping(
            p.support_damping, p.translation_damping, p.pitch_radius, p.tan_lead, p.factor
        )


def conditions(drive: Drive) -> dict[str, Condition]:
    """Return the instability conditions of a rigid drive; margins in SI units.

    ``negative_damping`` (8.19): μ − tan λ, N_0 Ω (by its sign as R̃ Ω), −C₊; ``kinematic_constraint`` (8.21): μ − tan λ,
    R̃ Ω, −Γ₊, which hold exactly where Γ_0 < 0 (8.20), as Γ₋ > 0. Where friction depends on the speed, μ is that of
    steady sliding, its slope damps by S, and what is negative must be C_0 + S as well; ``falling_friction`` then is S
    and C_0 + S negative.
    """
    c, d = mechanics.coefficients(drive), drive.exact()
    with many_digits():
        both = {"self_locking": d.steady_friction - d.tan_lead, "force_with_motion": c.net_force * d.input_speed}
    sloped = {}
    if friction.depends_on_speed(drive):
        with many_digits():
            by_slope = damping_by_slope(d, c.steady_law)
            sloped = {"negative_total_damping": -(c.damping[c.steady_law] + by_slope)}
    found = {
        "negative_damping": _condition(**both, negative_effective_damping=-c.damping[1], **sloped),
        "kinematic_constraint": _condition(**both, negative_effective_inertia=-c.gamma[1]),
    }
    if sloped:
        found["falling_friction"] = _condition(negative_damping_by_slope=-by_slope, **sloped)
    return found


def damping_by_slope(drive: DriveValues, law: int) -> Any:
    """Return S [N m s/rad], which the slope of friction in steady sliding adds to C_s of the rigid drive."""
    return values_of(drive, law).sloped


def critical_value(drive: Drive, unknown: str) -> float | None:
    """Return the value [SI unit] of a parameter at which the kinematic constraint begins, Γ₊ = 0 or Γ̃₊ = 0, or None.

    The threshold ``kinematic_constraint`` of a drive of any model, its value alone. The critical mass of a rigid drive
    is m_cr = I / (ξ₊ tan λ r_m²) (eq. 8.20), and smaller by the factor I_2 / (I + I_2) where the nut turns (8.33); the
    critical friction with axial support is μ_kc (8.27, 8.28). A drive that is not self-locking has no critical mass.
    """
    found = places(drive, "kinematic_constraint", unknown)
    return float(found[0].value) if found else None


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

    a_4 < 0 is the kinematic constraint, a_2² < 4 a_0 a_4 flutter, a_4 > 0 with a_2 > 0 divergence; flutter where the
    last two hold.
    """
    a_4, a_2, a_0 = characteristic_polynomial(drive, law)
    holds = [a_4 < 0, a_2**2 - 4 * a_0 * a_4 < 0, (a_4 > 0) & (a_2 > 0)]
    kinds = [UndampedClass.KINEMATIC_CONSTRAINT, UndampedClass.FLUTTER, UndampedClass.DIVERGENCE]
    return np.select(np.broadcast_arrays(*holds), kinds, UndampedClass.STABLE).astype(np.int8)


def boundary_coefficients(drive: DriveValues, law: int) -> tuple[Any, Any, Any]:
    """Return b_1, b_2, b_3 of the flutter boundary b_1 k_1² + b_2 k k_1 + b_3 k² = 0 as printed (eq. 8.29)."""
    p = values_of(drive, law)
    turned = p.factor * p.mass * p.pitch_radius**2 * p.tan_lead
    return (
        (p.screw_inertia - turned) ** 2,
        2 * (p.screw_mass * (turned - p.screw_inertia) - p.mass * (turned + p.screw_inertia)),
        (p.mass + p.screw_mass) ** 2,
    )


def flutter_boundaries(drive: DriveValues, law: int) -> NDArray[Any]:
    """Support stiffness k_1 [N/m] on both branches of the flutter boundary (8.29), the lower one first, last axis.

    With A² = S Γ̃_0 and B² = m² χ the coefficients of (8.29) are −b_2 = 2 (A² + B²), b_2² − 4 b_1 b_3 = 16 A² B² and
    S Γ_0 = A² − B², so the branches are perfect squares,

        k_1 = k [S / (A + B)]²   and   k_1 = k [(A + B) / Γ_0]²,

    without any subtraction but that inside Γ_0 and Γ̃_0. They are real and positive exactly if ξ_0 ≥ 0 and Γ̃_0 ≥ 0
    (8.32), NaN elsewhere; the upper one is infinite where Γ_0 = 0. They meet at μ = tan λ in k_1 = k S / I and on the
    kinematic constraint Γ̃_0 = 0 in k_1 = k S² m̃ / (m² I). The upper one is a boundary of stability only where Γ_0 > 0:
    beyond it, where Γ_0 < 0, both modes diverge (8.25).
    """
    p = values_of(drive, law)
    with many_digits(), np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        total, lever = p.mass + p.screw_mass, p.factor * p.pitch_radius**2 * p.tan_lead
        both = np.sqrt(total * effective_inertia(drive, law)) + p.mass * np.sqrt(lever)
        branches = total / both, both / effective_inertia(drive, law, rigid=True)
        return np.stack([p.coupling_stiffness * branch**2 for branch in branches], axis=-1)


def critical_friction_by_eigenvalues(drive: Drive) -> float | None:
    """Friction coefficient μ_kc at which an eigenvalue of K⁻¹ M passes through zero, by bisection to the last bit.

    That 1/ω² belongs to the undamped model (8.23) under law +; it has a simple root where ω² has a pole, and it
    decreases as ξ₊ grows with μ. Returns None if it does not change its sign below cot λ. Independent of
    :func:`critical_value`.
    """
    largest = math.nextafter(1 / math.tan(drive.lead_angle), 0)

    def turned(coefficient: float) -> bool:
        squares = reciprocal_squares({**dict(drive), "friction_coefficient": coefficient}, 1)
        return bool(np.prod(np.sign(squares.real)) < 0)

    return bisected(turned, 0.0, largest) if turned(largest) else None


def _contact_terms(drive: Drive) -> tuple[Any, Any, Any, Any]:
    """Parameters of a drive in balls, Γ_0 [kg m²], C_0 [N m s/rad] and β [1] of its steady law.

    The slope of friction damps the screw alone by r_m² ν, with which ``support_damping`` is given here, and the rigid
    drive by S, which is in C_0.
    """
    law = steady_law(drive)
    d = values_of(drive.exact(), law)
    beta = d.cos_lead * (d.cos_lead + law * d.steady_friction * d.sin_lead)
    damping = effective_damping(drive.exact(), law) + d.sloped
    d.support_damping = d.support_damping + d.slope
    return d, effective_inertia(drive.exact(), law), damping, beta


def unstable_contact_stiffness(drive: Drive) -> float | None:
    """Contact stiffness k_c [N/m] beyond which p_2 < 0, so that steady sliding is unstable (Lemma 8.1).

    k_c = max[0, (c c_x + m k + β c_c C_0) / (β |Γ_0|)]: sufficient, whatever the contact damping. None unless Γ_0 < 0.
    """
    with many_digits():
        d, gamma, damping, beta = _contact_terms(drive)
        if not gamma < 0:
            return None
        rest = d.support_damping * d.translation_damping + d.mass * d.coupling_stiffness
        return max(0.0, float((rest + beta * d.contact_damping * damping) / (beta * -gamma)))


def least_damping_of_stiff_contact(drive: Drive) -> float | None:
    """Contact damping c_c [N s/m] above which steady sliding stays stable as k_c → ∞; None unless Γ_0 > 0 and C_0 > 0.

    c_c = max[0, (I m C_0 − (I c_x + m c) Γ_0) / (β Γ_0²)], from the Routh–Hurwitz condition p_3 Γ_0 > I m C_0 that is
    left in the limit. With a constant friction coefficient the numerator is c m (I − Γ_0) − I² c_x. With less damping
    a contact that is stiff enough flutters, although the rigid drive (8.13) is stable. The least damping at the drive's
    own k_c (:mod:`lsvib.stability.boundaries`) may be many times larger.
    """
    with many_digits():
        d, gamma, damping, beta = _contact_terms(drive)
        if not (gamma > 0 and damping > 0):
            return None
        if friction.depends_on_speed(drive):
            excess = d.screw_inertia * (d.mass * damping - d.translation_damping * gamma)
            excess -= d.mass * d.support_damping * gamma
        else:  # without a difference of large terms
            excess = d.support_damping * d.mass * (d.screw_inertia - gamma) - d.screw_inertia**2 * d.translation_damping
        return max(0.0, float(excess / (beta * gamma**2)))


def stable_masses(drive: Drive) -> list[tuple[float, float]]:
    """Intervals of masses [kg] at which steady sliding with the contact of a drive is stable, ascending, up to 1e9 kg.

    As a rule there is one, from zero to the critical mass. A soft contact with little damping keeps steady sliding
    stable at every mass, or again beyond a large one: the nut is then too heavy to follow the screw.
    """
    found = stable_set(drive, "mass")
    return [(float(a), float(b)) for a, b in found.intervals] if found else []


def critical_mass_of_contact(drive: Drive) -> float:
    """Mass [kg] at which steady sliding with the contact of a drive loses its stability, all masses below it stable.

    Exact and rounded once; NaN if no mass is stable, or every one.
    """
    found = stable_set(drive, "mass")
    return float(found.intervals[0][1]) if found and found.changes and found.intervals else math.nan


def stability(drive: Drive) -> StabilityReport:
    """Return the linear stability of the steady sliding of a drive of any model.

    Of the rigid drive (eqs 8.18–8.21) the class is one of :class:`~lsvib.stability.linear.Stability`, in lower case,
    and the conditions are those of :func:`conditions`. With a negative effective inertia steady sliding is unstable by
    Lemma 8.1, whatever its eigenvalues. Of the others (Sects 5.5, 5.6, 5.8 and their combinations) the class is that of
    :func:`~lsvib.stability.spectrum.spectrum`; ``divergence`` holds if a real eigenvalue is positive, ``flutter`` if a
    complex pair grows, and the other conditions say why. What the chapter says of the undamped drive with axial support
    (eqs 8.23–8.32) stands apart, under ``without_damping``. Raises ``InputError`` for a contact that carries no force.
    """
    law = steady_law(drive)
    kind, values, polynomial = spectrum(drive, law)
    details = _of_rigid(drive, law) if drive.rigid else _of_parts(drive, law, polynomial, values)
    return StabilityReport(
        parts=drive.parts,
        stable=kind.startswith("stable"),
        kind=kind,
        eigenvalues=tuple(values),
        steady_law=law,
        characteristic_polynomial=tuple(float(p) for p in polynomial),
        **details,
    )


def _growth(values: list[complex], real: bool = False) -> float | None:
    """Growth rate of flutter, or of divergence by ``real`` eigenvalues [1/s]; None if nothing grows."""
    return max((x.real for x in values if x.real > 0 and (x.imag == 0) == real), default=None)


def _condition(**numbers: Any) -> Condition:
    """A condition by its margins, missing ones left out: it holds if all of them exist and are positive."""
    known = {name: float(value) for name, value in numbers.items() if value is not None}
    return Condition(all(value is not None and value > 0 for value in numbers.values()), known)


def _quantity(value: Any, unit: str) -> Quantity:
    """A quantity; without a value where there is none, and where it is beyond the range of doubles."""
    number = None if value is None else float(value)
    return Quantity(number if number is None or math.isfinite(number) else None, unit)


def _of_rigid(drive: Drive, law: int) -> dict[str, Any]:
    """Of the rigid drive (Sects 5.3, 8.5, 8.6): what eqs (8.18) to (8.21) say of it."""
    c, found = mechanics.coefficients(drive), {}
    for name, by_law, unit in (("inertia", c.gamma, "kg m2"), ("damping", c.damping, "N m s rad-1")):
        for word, s in (("plus", 1), ("minus", -1)):
            found[f"effective_{name}_{word}"] = _quantity(by_law[s], unit)
    found["steady_deflection"] = _quantity(c.deflection, "rad")
    if friction.depends_on_speed(drive):
        found["steady_friction"] = _quantity(drive.exact().steady_friction, "1")
        found["damping_by_slope"] = _quantity(damping_by_slope(drive.exact(), law), "N m s rad-1")
    return {"conditions": conditions(drive), "quantities": found, "paradox_region": c.paradox}


def _of_parts(drive: Drive, law: int, polynomial: Polynomial, values: list[complex]) -> dict[str, Any]:
    """Of any other drive: how it grows, and the kinematic constraint (eqs 8.20, 8.28, 8.33; Lemma 8.1)."""
    d = drive.exact()
    inertia = effective_inertia(d, law)
    soft = {"negative_coefficient_of_s2": -polynomial[-3]} if "threads" in drive.parts else {}
    conditions = {
        "kinematic_constraint": _condition(negative_effective_inertia=-inertia, **soft),
        "divergence": _condition(growth_rate=_growth(values, real=True)),
        "flutter": _condition(growth_rate=_growth(values)),
    }
    quantities = {
        "effective_inertia": _quantity(inertia, "kg m2"),
        "effective_screw_inertia": _quantity(screw_inertia(d), "kg m2"),
        "effective_mass": _quantity(mass(d), "kg"),
        "critical_mass": _quantity(critical_value(drive, "mass") if law > 0 else None, "kg"),
        "critical_friction": _quantity(critical_value(drive, "friction_coefficient") if law > 0 else None, "1"),
    }
    if drive.parts == ("threads",):
        conditions["contact_flutter"], more = _of_threads(drive, values)
        quantities |= more
    undamped = _undamped(drive, law) if drive.parts == ("support",) else None
    return {"conditions": conditions, "quantities": quantities, "without_damping": undamped}


def _of_threads(drive: Drive, values: list[complex]) -> tuple[Condition, dict[str, Quantity]]:
    """Of compliant threads (Sect. 5.5): whether this very contact lacks damping; what Lemma 8.1 says of it."""
    with many_digits():
        _, _, damping, _ = _contact_terms(drive)
    damped = stable_set(drive, "contact_damping")
    least = damped.intervals[0][0] if damped and damped.intervals else None
    missing = None if least is None else least - fmpq(*drive.contact_damping.as_integer_ratio())
    return _condition(missing_contact_damping=missing, growth_rate=_growth(values)), {
        "effective_damping": _quantity(damping, "N m s rad-1"),
        "unstable_contact_stiffness": _quantity(unstable_contact_stiffness(drive), "N m-1"),
        "least_contact_damping": _quantity(least, "N s m-1"),
        "least_damping_of_stiff_contact": _quantity(least_damping_of_stiff_contact(drive), "N s m-1"),
    }


def _undamped(drive: Drive, law: int) -> UndampedStability:
    """Of a drive with axial support (Sect. 5.6) without any damping: mode coupling and divergence (8.24 to 8.29)."""
    undamped = drive.replace(support_damping=0.0, translation_damping=0.0, axial_support_damping=0.0)
    kind, _, polynomial = spectrum(undamped, law, level=True)
    a_4, minus_a_2, discriminant = margins(polynomial, neutral=True)
    # in doubles Γ_0 and Γ̃_0 lose all digits next to where they vanish
    lower, upper = flutter_boundaries(drive.exact(), law)
    return UndampedStability(
        kind=kind,
        conditions={
            "divergence": _condition(positive_a_4=a_4, positive_a_2=-minus_a_2),
            "mode_coupling": _condition(negative_discriminant=-discriminant),
        },
        quantities={
            "lower_flutter_stiffness": _quantity(lower, "N m-1"),
            "upper_flutter_stiffness": _quantity(upper, "N m-1"),
        },
    )
