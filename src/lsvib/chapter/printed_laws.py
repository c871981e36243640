"""Equations of Sects 8.1 to 8.4 as printed, from a dataset's parameters, for comparison with its motions."""

from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import named
from lsvib.chapter.checks import Check, each


def factor(p: Any, law: Any) -> Any:
    """Return ξ of a law [1] (8.4)."""
    friction, tangent = law * p.friction_coefficient, np.tan(p.lead_angle)
    return (friction - tangent) / (1 + friction * tangent)


def inertia(p: Any, law: Any) -> Any:
    """Return Γ of a law [kg m²] (8.4)."""
    return p.screw_inertia - p.mass * p.pitch_radius**2 * np.tan(p.lead_angle) * factor(p, law)


def damping(p: Any, law: Any) -> Any:
    """Return C of a law [N m s/rad] (8.13)."""
    return p.support_damping - factor(p, law) * p.pitch_radius**2 * np.tan(p.lead_angle) * p.translation_damping


def critical_mass(p: Any) -> Any:
    """Return the mass [kg] at which Γ₊ of (8.4) vanishes (8.20)."""
    return p.screw_inertia / (p.pitch_radius**2 * np.tan(p.lead_angle) * factor(p, 1))


def net_force(p: Any) -> Any:
    """Return R − r_m tan λ c_x Ω [N], the numerator of (8.15)."""
    return p.axial_force - p.pitch_radius * np.tan(p.lead_angle) * p.translation_damping * p.input_speed


def lever(p: Any, law: Any) -> Any:
    """Return cos λ + s μ sin λ [1]."""
    return np.cos(p.lead_angle) + law * p.friction_coefficient * np.sin(p.lead_angle)


def laws(dataset: xr.Dataset) -> xr.DataArray:
    """Return the law of each sample of the motions, 0 at rest."""
    plus = named(dataset["mode"], "slip forward positive", "slip backward negative")
    minus = named(dataset["mode"], "slip forward negative", "slip backward positive")
    return dataset["mode"].copy(data=1 * plus - minus)


def steady_deflection(p: Any) -> Any:
    """Return z_0 [rad] (8.14)."""
    law = np.sign(net_force(p) * p.input_speed)
    load = damping(p, law) * p.input_speed + p.pitch_radius * factor(p, law) * p.axial_force
    return -load / p.coupling_stiffness


def steady_checks(p: xr.Dataset) -> list[Check]:
    """Check value and sign of the contact force, and the deflection, at the end of motions that settle."""
    force = net_force(p) / lever(p, np.sign(net_force(p) * p.input_speed))
    checks = []
    for id, values, end in (
        ("printed_laws.force", p.normal_force, force),
        ("printed_laws.deflection", p.coupling_deflection, steady_deflection(p)),
    ):
        gap = abs(values.isel(sample=-1) / end - 1)
        checks.append(Check.that(id, gap=each(gap, "<", 1e-3), end=end.values.flat[0]))
    return checks


def drift(p: Any, deflection: Any, speed: Any) -> tuple[Any, Any]:
    """Return both parts of W = I P − m r_m tan λ T [N kg m²], with which N changes its sign (8.7), (8.17)."""
    lead, torque = p.pitch_radius * np.tan(p.lead_angle), -p.coupling_stiffness * deflection - p.support_damping * speed
    return p.screw_inertia * (p.axial_force - p.translation_damping * lead * speed), -lead * p.mass * torque


def stationary_check(p: xr.Dataset) -> Check:
    """Check that the contact force of the motions, (8.3), is a zero of the right-hand side of (8.7)."""
    law = laws(p)
    parts = drift(p, p.coupling_deflection, p.input_speed + p.w)
    terms = [-lever(p, law) * inertia(p, law) * p.normal_force, *parts]
    worst = (abs(sum(terms)) / sum(map(abs, terms))).where(law != 0).max()
    return Check.that("printed_laws.stationary", worst=each(worst, "<", 1e-12), slips=law != 0)
