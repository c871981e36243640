"""Friction laws of the threads and the effective coefficients that follow from them.

Plain arithmetic only, so that the same lines serve floats, numpy arrays, balls and power series (``flint``).
Symbols follow the chapter: ``law`` is s = sgn(θ̇)·sgn(N) = ±1, ``tan_lead`` is tan λ.
"""

from typing import Any


def friction_factor(friction_coefficient: Any, tan_lead: Any, law: Any) -> Any:
    """Friction factor of the threads, ξ_s = (s μ − tan λ) / (1 + s μ tan λ) (eqs 5.11, 8.4).

    Arguments: friction coefficient μ [1], tan λ [1], law s = ±1 (scalars or arrays). Returns ξ_s [1], same shape.
    """
    return (law * friction_coefficient - tan_lead) / (1 + law * friction_coefficient * tan_lead)


def effective_inertia(screw_inertia: Any, mass: Any, pitch_radius: Any, tan_lead: Any, factor: Any) -> Any:
    """Effective inertia Γ_s = I − ξ_s tan λ m r_m² [kg m²] (eq. 8.2); ``factor`` is ξ_s [1]."""
    return screw_inertia - factor * tan_lead * mass * pitch_radius**2


def effective_damping(
    support_damping: Any, translation_damping: Any, pitch_radius: Any, tan_lead: Any, factor: Any
) -> Any:
    """Effective damping C_s = c − ξ_s r_m² tan λ c_x [N m s/rad] (below eq. 8.13); ``factor`` is ξ_s [1]."""
    return support_damping - factor * tan_lead * translation_damping * pitch_radius**2
