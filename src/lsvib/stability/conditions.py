"""The linear stability of one drive, and the chapter's conditions in closed form (eqs 8.18–8.33).

All of it is read off one polynomial (:mod:`lsvib.stability.spectrum`), with coefficients p_n of the powers of s: of the
rigid drive det(M s² + C s + K) is Γ_0 s² + (C_0 + S) s + k, with the damping S by the slope of friction; that of
compliant threads, with β = cos λ (cos λ + s_0 μ sin λ), stands in docs/lemmas.md.
"""

import math
from typing import Any

from flint import fmpq, fmpq_poly

from lsvib.drives import friction, mechanics
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import Coefficients, LinearParts, Polynomial
from lsvib.results import Condition, Quantity, StabilityReport
from lsvib.stability.boundaries import place_values, stable_set
from lsvib.stability.spectrum import enclosed, parts_of, polynomial, spectrum, steady_law
from lsvib.systems.exact.arithmetic import many_digits


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
        sloped = {"negative_total_damping": -polynomial(d, c.steady_law)[1]}
    found = {
        "negative_damping": _condition(**both, negative_effective_damping=-c.damping[1], **sloped),
        "kinematic_constraint": _condition(**both, negative_effective_inertia=-c.gamma[1]),
    }
    if sloped:
        found["falling_friction"] = _condition(negative_damping_by_slope=-damping_by_slope(drive), **sloped)
    return found


def damping_by_slope(drive: Drive) -> Any:
    """Return S [N m s/rad], which the slope of friction in steady sliding adds to C_0 of the rigid drive."""
    with many_digits():
        parts = parts_of(drive.exact(), steady_law(drive))
        return parts.sloped / parts.excess


def unstable_contact_stiffness(drive: Drive) -> float | None:
    """Contact stiffness k_c [N/m] beyond which p_2 < 0, so that steady sliding is unstable (Lemma 8.1).

    k_c = max[0, (c c_x + m k + β c_c C_0) / (β |Γ_0|)]: sufficient, whatever the contact damping. None unless Γ_0 < 0.
    """
    rest, rise = _in(drive, contact_stiffness=fmpq_poly([0, 1]))[2]
    return max(0.0, float(-rest / rise)) if rise < 0 else None


def least_damping_of_stiff_contact(drive: Drive) -> float | None:
    """Contact damping c_c [N s/m] above which steady sliding stays stable as k_c → ∞; None unless Γ_0 > 0 and C_0 > 0.

    c_c = max[0, (I m C_0 − (I c_x + m c) Γ_0) / (β Γ_0²)], from the Routh–Hurwitz condition p_3 Γ_0 > I m C_0 that is
    left in the limit. With a constant friction coefficient the numerator is c m (I − Γ_0) − I² c_x. With less damping
    a contact that is stiff enough flutters, although the rigid drive (8.13) is stable. The least damping at the drive's
    own k_c (:mod:`lsvib.stability.boundaries`) may be many times larger.
    """
    _, _, (_, inertia), (_, damping), _ = _in(drive, contact_stiffness=fmpq_poly([0, 1]))
    if not (inertia > 0 and damping > 0):
        return None
    (whole, _), (rest, rise), *_ = _in(drive, contact_damping=fmpq_poly([0, 1]))
    return max(0.0, float((whole * damping - rest * inertia) / (rise * inertia)))


def _in(drive: Drive, **unknown: fmpq_poly) -> list[tuple[fmpq, fmpq]]:
    """Each coefficient of the polynomial of compliant threads as a + b x of one parameter x of the contact: (a, b)."""
    values, tangent = enclosed(drive)[0]
    parts = LinearParts.of({**values, **unknown}, steady_law(drive), tangent)
    return [(p[0], p[1]) for p in (fmpq_poly([0]) + x for x in parts.polynomial())]


def stability(drive: Drive) -> StabilityReport:
    """Return the linear stability of the steady sliding of a drive of any model.

    The class is that of :func:`~lsvib.stability.spectrum.spectrum`. Of the rigid drive (eqs 8.18–8.21) the conditions
    are those of :func:`conditions`; with a negative effective inertia steady sliding is unstable by Lemma 8.1, whatever
    its eigenvalues. Of the others (Sects 5.5, 5.6, 5.8 and their combinations) ``divergence`` holds if a real
    eigenvalue is positive, ``flutter`` if a complex pair grows, and the other conditions say why. Raises ``InputError``
    for a contact that carries no force.
    """
    law = steady_law(drive)
    kind, values, polynomial = spectrum(drive, law)
    details = _of_rigid(drive) if drive.rigid else _of_parts(drive, law, polynomial, values)
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


def _of_rigid(drive: Drive) -> dict[str, Any]:
    """Of the rigid drive (Sects 5.3, 8.5, 8.6): what eqs (8.18) to (8.21) say of it."""
    c: Coefficients = mechanics.coefficients(drive)
    found = {}
    for name, by_law, unit in (("inertia", c.gamma, "kg m2"), ("damping", c.damping, "N m s rad-1")):
        for word, s in (("plus", 1), ("minus", -1)):
            found[f"effective_{name}_{word}"] = _quantity(by_law[s], unit)
    found["steady_deflection"] = _quantity(c.deflection, "rad")
    if friction.depends_on_speed(drive):
        found["steady_friction"] = _quantity(drive.exact().steady_friction, "1")
        found["damping_by_slope"] = _quantity(damping_by_slope(drive), "N m s rad-1")
    return {"conditions": conditions(drive), "quantities": found, "paradox_region": c.paradox}


def _of_parts(drive: Drive, law: int, polynomial: Polynomial, values: list[complex]) -> dict[str, Any]:
    """Of any other drive: how it grows, and the kinematic constraint (eqs 8.20, 8.28, 8.33; Lemma 8.1)."""
    with many_digits():
        parts = parts_of(drive.exact(), law)
        turning, along = (
            mechanics.together(*(above[0] / below[0] for above, below in these))
            for these in (parts.turning, parts.along)
        )
        inertia = turning - parts.h / parts.g * along
    soft = {"negative_coefficient_of_s2": -polynomial[-3]} if "threads" in drive.parts else {}
    critical = {
        unknown: next(iter(place_values(drive, "kinematic_constraint", unknown)), None) if law > 0 else None
        for unknown in ("mass", "friction_coefficient")
    }
    conditions = {
        "kinematic_constraint": _condition(negative_effective_inertia=-inertia, **soft),
        "divergence": _condition(growth_rate=_growth(values, real=True)),
        "flutter": _condition(growth_rate=_growth(values)),
    }
    quantities = {
        "effective_inertia": _quantity(inertia, "kg m2"),
        "effective_screw_inertia": _quantity(turning, "kg m2"),
        "effective_mass": _quantity(along, "kg"),
        "critical_mass": _quantity(critical["mass"], "kg"),
        "critical_friction": _quantity(critical["friction_coefficient"], "1"),
    }
    if drive.parts == ("threads",):
        # whether this very contact lacks damping (Sect. 5.5), and what Lemma 8.1 says of it
        with many_digits():
            rigid = parts.stiff()
            damping = rigid.polynomial()[1] / rigid.excess
        damped = stable_set(drive, "contact_damping")
        least = damped.intervals[0][0] if damped and damped.intervals else None
        missing = None if least is None else least - fmpq(*drive.contact_damping.as_integer_ratio())
        conditions["contact_flutter"] = _condition(missing_contact_damping=missing, growth_rate=_growth(values))
        quantities |= {
            "effective_damping": _quantity(damping, "N m s rad-1"),
            "unstable_contact_stiffness": _quantity(unstable_contact_stiffness(drive), "N m-1"),
            "least_contact_damping": _quantity(least, "N s m-1"),
            "least_damping_of_stiff_contact": _quantity(least_damping_of_stiff_contact(drive), "N s m-1"),
        }
    return {"conditions": conditions, "quantities": quantities}
