"""Rotating nut (Sect. 5.8): the kinematic constraint (8.33)."""

from typing import Any

from lsvib.models.drive import NutDrive
from lsvib.models.mechanics import Polynomial
from lsvib.stability import conditions
from lsvib.stability.stability_of_models import condition, quantity


def said(drive: NutDrive, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    """Return conditions and quantities of a drive; arguments as the folder says."""
    inertia = conditions.kinematic_inertia(drive.exact(), law)
    return {
        "conditions": {"kinematic_constraint": condition(negative_effective_inertia=-float(inertia))},
        "quantities": {
            "kinematic_inertia": quantity(inertia, "kg m2"),
            "effective_screw_inertia": quantity(conditions.effective_screw_inertia(drive.exact()), "kg m2"),
            "kinematic_mass": quantity(conditions.kinematic_mass(drive) if law > 0 else None, "kg"),
        },
    }
