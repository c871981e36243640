"""Compliant threads (Sect. 5.5): Lemma 8.1, and the least damping of the contact."""

from fractions import Fraction
from typing import Any

from lsvib.models.drive import ThreadsDrive
from lsvib.models.mechanics import Polynomial, coefficients
from lsvib.stability import boundaries, conditions
from lsvib.stability.stability_of_models import condition, quantity


def said(drive: ThreadsDrive, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    """Return conditions and quantities of a drive; arguments as the folder says."""
    c = coefficients(drive)
    damped = boundaries.stable_set(drive, "contact_damping").intervals
    least = damped[0][0] if damped else None
    missing = None if least is None else least - Fraction(drive.contact_damping)
    return {
        "conditions": {
            # Lemma 8.1 at the stiffness of this very contact: p_2 < 0.
            "negative_inertia": condition(
                negative_effective_inertia=-float(c.gamma[law]), negative_coefficient_of_s2=-polynomial[2]
            ),
            "contact_flutter": condition(missing_contact_damping=missing, growth_rate=flutter),
        },
        "quantities": {
            "effective_inertia": quantity(c.gamma[law], "kg m2"),
            "effective_damping": quantity(c.damping[law], "N m s rad-1"),
            "unstable_contact_stiffness": quantity(conditions.unstable_contact_stiffness(drive), "N m-1"),
            "least_contact_damping": quantity(least, "N s m-1"),
            "least_damping_of_stiff_contact": quantity(conditions.least_damping_of_stiff_contact(drive), "N s m-1"),
        },
    }
