"""Axial support (Sect. 5.6): the kinematic constraint, and mode coupling of the undamped drive (8.29)."""

from typing import Any

from lsvib.models.drive import SupportDrive
from lsvib.models.mechanics import Polynomial
from lsvib.stability import conditions
from lsvib.stability.conditions import critical_friction
from lsvib.stability.spectrum import neutral_margins, scale, spectrum
from lsvib.stability.stability_of_models import condition, quantity

_UNDAMPED = dict.fromkeys(("support_damping", "translation_damping", "axial_support_damping"), 0.0)


def said(drive: SupportDrive, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    """Return conditions and quantities of a drive, and the same ``without_damping``; arguments as the folder says."""
    inertia = conditions.reduced_inertia(drive.exact(), law)
    undamped = drive.replace(**_UNDAMPED)
    undamped_class, _, undamped_polynomial = spectrum(undamped, law)
    a_4, minus_a_2, discriminant = neutral_margins(tuple(p / scale(drive, law) for p in undamped_polynomial))
    lower, upper = conditions.exact_flutter_boundaries(drive, law)
    return {
        "conditions": {"kinematic_constraint": condition(negative_reduced_inertia=-float(inertia))},
        "quantities": {
            "reduced_inertia": quantity(inertia, "kg m2"),
            "reduced_mass": quantity(conditions.reduced_mass(drive.exact()), "kg"),
            "kinematic_friction": quantity(critical_friction(drive, drive.screw_mass) if law > 0 else None, "1"),
        },
        "without_damping": {
            "class": undamped_class,
            "conditions": {
                "divergence": condition(positive_a_4=a_4, positive_a_2=-minus_a_2),
                "mode_coupling": condition(negative_discriminant=-discriminant),
            },
            "quantities": {
                "lower_flutter_stiffness": quantity(lower, "N m-1"),
                "upper_flutter_stiffness": quantity(upper, "N m-1"),
            },
        },
    }
