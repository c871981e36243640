"""Rotating nut (Sect. 5.8): the kinematic constraint (8.33)."""

from typing import Any

from lsvib.models.drive import NutDrive
from lsvib.models.linear_parts import Polynomial
from lsvib.stability import nut_conditions
from lsvib.stability.stability_of_models import condition, quantity


def said(drive: NutDrive, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    """Return conditions and quantities of a drive; arguments as the folder says."""
    inertia = nut_conditions.kinematic_inertia(drive.exact(), law)
    return {
        "conditions": {"kinematic": condition(negative_effective_inertia=-float(inertia))},
        "quantities": {
            "kinematic_inertia": quantity(inertia, "kg m2"),
            "effective_screw_inertia": quantity(nut_conditions.effective_screw_inertia(drive.exact()), "kg m2"),
            "kinematic_mass": quantity(nut_conditions.kinematic_mass(drive) if law > 0 else None, "kg"),
        },
    }
