"""The chapter's closed-form conditions (8.19), (8.20), (8.21), and the critical values that follow from them."""

import math

from flint import arb

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models import mechanics
from lsvib.models.drive import Drive, RigidDrive
from lsvib.models.mechanics import coefficients


def conditions(drive: RigidDrive) -> dict[str, dict[str, object]]:
    """Evaluate the instability conditions of a drive.

    Returns, by name, the margins of the inequalities (each holds where positive; SI units) and whether all ``hold``:
    ``negative_damping`` (8.19): μ − tan λ, N_0 Ω (by its sign as R̃ Ω), ξ₊ r_m² tan λ c_x − c;
    ``negative_inertia`` (8.20): −Γ_0;
    ``paradox`` (8.21): μ − tan λ, R̃ Ω, ξ₊ tan λ m r_m² − I.
    """
    c = coefficients(drive)
    d = drive.exact()
    with many_digits():
        both = {
            "self_locking": d.friction_coefficient - d.tan_lead,
            "force_with_motion": c.net_force * d.input_speed,
        }
        margins = {
            "negative_damping": {**both, "negative_effective_damping": -c.damping[1]},
            "negative_inertia": {"negative_effective_inertia": -c.gamma[c.steady_law]},
            "paradox": {**both, "negative_effective_inertia": -c.gamma[1]},
        }
    return {
        name: {"margins": {k: float(v) for k, v in parts.items()}, "hold": all(v > 0 for v in parts.values())}
        for name, parts in margins.items()
    }


def critical_mass(drive: RigidDrive) -> float | None:
    """Mass [kg] at which Γ₊ = 0, m_cr = I / (ξ₊ tan λ r_m²) (eq. 8.20); None if the drive is not self-locking."""
    d = drive.exact()
    with many_digits():
        xi = mechanics.friction_factor(d.friction_coefficient, d.tan_lead, 1)
        if xi <= 0:
            return None
        return float(d.screw_inertia / (xi * d.tan_lead * d.pitch_radius**2))


def critical_friction(drive: Drive, screw_mass: float = math.inf) -> float | None:
    """Friction coefficient at which Γ̃_0 = I − ξ₊ tan λ m̃ r_m² = 0, m̃ = m m_1 / (m + m_1) (eqs 8.27, 8.28).

    Arguments: drive (its own friction coefficient plays no part); screw mass m_1 [kg] of the model with axial support,
    infinite for the rigid drive, m̃ = m and Γ₊ = 0.
    Returns μ_kc = (ξ + tan λ) / (1 − ξ tan λ) with ξ = I / (tan λ m̃ r_m²), or None if no μ below cot λ reaches it.
    """
    d = drive.exact()
    with many_digits():
        mass = d.mass if math.isinf(screw_mass) else d.mass * arb(screw_mass) / (d.mass + arb(screw_mass))
        xi = d.screw_inertia / (d.tan_lead * mass * d.pitch_radius**2)
        # ξ₊ grows with μ and reaches (cot λ − tan λ) / 2 at the end of the valid range.
        if xi * d.tan_lead >= 1 or (xi + d.tan_lead) * d.tan_lead >= 1 - xi * d.tan_lead:
            return None
        return float((xi + d.tan_lead) / (1 - xi * d.tan_lead))
