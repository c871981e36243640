"""Equations of Sects 8.1 to 8.4 as they are printed, in doubles from a dataset's parameters, against its motions."""

from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import named
from lsvib.chapter.checks import Check


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


def steady_checks(p: xr.Dataset) -> list[Check]:
    """Check value and sign of the contact force, and the deflection, at the end of motions that settle."""
    law = np.sign(net_force(p) * p.input_speed)
    force = net_force(p) / lever(p, law)
    load = damping(p, law) * p.input_speed + p.pitch_radius * factor(p, law) * p.axial_force
    expected = (
        ("printed_laws.force", p.normal_force, force),
        ("printed_laws.deflection", p.coupling_deflection, -load / p.coupling_stiffness),
    )
    checks = []
    for id, values, end in expected:
        gap = float(abs(values.isel(sample=-1) / end - 1).max())
        checks.append(Check.that(id, gap < 1e-3, end=end.values.flat[0], gap=gap))
    return checks


def stationary_check(p: xr.Dataset) -> Check:
    """Check that the contact force of the motions, (8.3), is a zero of the right-hand side of (8.7)."""
    law, tan, rate = laws(p), np.tan(p.lead_angle), p.input_speed + p.w
    torque = -p.coupling_stiffness * p.coupling_deflection - p.support_damping * rate
    push = p.axial_force - p.translation_damping * p.pitch_radius * tan * rate
    terms = [
        -lever(p, law) * inertia(p, law) * p.normal_force,
        p.screw_inertia * push,
        -p.pitch_radius * tan * p.mass * torque,
    ]
    worst = float((abs(sum(terms)) / sum(map(abs, terms))).where(law != 0).max())
    return Check.that("printed_laws.stationary", worst < 1e-12, worst=worst, slips=law != 0)
