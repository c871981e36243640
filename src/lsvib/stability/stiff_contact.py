"""Compliant threads: when the stiff contact is unstable (Lemma 8.1), and when it is not; see ``docs/lemmas.md``.

With Γ_0 and C_0 of the steady law and β = cos λ (cos λ + s_0 μ sin λ), the characteristic polynomial of the model of
Sect. 5.5 (:func:`lsvib.stability.linear.threads_model`) has the coefficients

    p_4 = I m,   p_3 = I c_x + m c + β c_c Γ_0,   p_2 = c c_x + m k + β (k_c Γ_0 + c_c C_0),
    p_1 = c_x k + β (k_c C_0 + c_c k),   p_0 = β k_c k.
"""

import math

from flint import arb

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models.drive import ThreadsDrive
from lsvib.models.mechanics import coefficients
from lsvib.stability.boundaries import stable_set
from lsvib.stability.linear import steady_law

LARGEST_MASS = 1e9  # kg, the end of the range of the mass


def unstable_contact_stiffness(drive: ThreadsDrive) -> float | None:
    """Contact stiffness k_c [N/m] beyond which p_2 < 0, so that steady sliding is unstable (Lemma 8.1).

    k_c = max[0, (c c_x + m k + β c_c C_0) / (β |Γ_0|)]: sufficient, whatever the contact damping. None unless Γ_0 < 0.
    """
    d = drive.exact()
    with many_digits():
        gamma, damping, beta = _effective(drive)
        if gamma >= 0:
            return None
        rest = d.support_damping * d.translation_damping + d.mass * d.coupling_stiffness
        return max(0.0, float((rest + beta * d.contact_damping * damping) / (beta * -gamma)))


def least_damping_of_stiff_contact(drive: ThreadsDrive) -> float | None:
    """Contact damping c_c [N s/m] above which steady sliding stays stable as k_c → ∞; None unless Γ_0 > 0 and C_0 > 0.

    c_c = max[0, (c m (I − Γ_0) − I² c_x) / (β Γ_0²)], from the Routh–Hurwitz condition p_3 Γ_0 > I m C_0 that is left
    in the limit. With less damping a contact that is stiff enough flutters, although the rigid drive (8.13) is stable.
    The least damping at the drive's own k_c (:mod:`lsvib.stability.boundaries`) may be many times larger.
    """
    d = drive.exact()
    with many_digits():
        gamma, damping, beta = _effective(drive)
        if gamma <= 0 or damping <= 0:
            return None
        excess = d.support_damping * d.mass * (d.screw_inertia - gamma) - d.screw_inertia**2 * d.translation_damping
        return max(0.0, float(excess / (beta * gamma**2)))


def stable_masses(drive: ThreadsDrive) -> list[tuple[float, float]]:
    """Intervals of masses [kg] at which steady sliding with the contact of a drive is stable, ascending, up to 1e9 kg.

    As a rule there is one, from zero to the critical mass. A soft contact with little damping keeps steady sliding
    stable at every mass, or again beyond a large one: the nut is then too heavy to follow the screw.
    """
    return [(float(a), float(b)) for a, b in stable_set(drive, "mass").intervals]


def critical_mass_of_contact(drive: ThreadsDrive) -> float:
    """Mass [kg] at which steady sliding with the contact of a drive loses its stability, all masses below it stable.

    Exact and rounded once; NaN if no mass is stable, or every one.
    """
    found = stable_masses(drive)
    return found[0][1] if found and found[0][1] < LARGEST_MASS else math.nan


def _effective(drive: ThreadsDrive) -> tuple[arb, arb, arb]:
    """Γ_0 [kg m²], C_0 [N m s/rad] and β [1] of the steady law."""
    d, c, law = drive.exact(), coefficients(drive), steady_law(drive)
    with many_digits():
        beta = d.cos_lead * (d.cos_lead + law * d.friction_coefficient * d.sin_lead)
    return c.gamma[law], c.damping[law], beta
