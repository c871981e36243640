"""The rigid drive (Sects 5.3, 8.5, 8.6): what eqs (8.18) to (8.21) say of it."""

from typing import Any

from lsvib.errors import InputError
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.stability.conditions import conditions
from lsvib.stability.linear import Stability
from lsvib.stability.spectrum import rigid_spectrum


def stability(drive: RigidDrive) -> dict[str, Any]:
    """Return the table of :func:`lsvib.stability.stability_table.stability_table` of a rigid drive."""
    c = coefficients(drive)
    if c.net_force == 0:
        raise InputError(
            "axial_force balances the translation damping exactly, so the contact carries no force and no law holds."
        )
    kind, pair = rigid_spectrum(drive, c)
    return {
        "stable": kind in (Stability.STABLE_NODE, Stability.STABLE_FOCUS),
        "class": kind.name.lower(),
        "eigenvalues": [{"real": x.real, "imaginary": x.imag} for x in pair],
        "steady_law": c.steady_law,
        "effective_inertia": {"plus": float(c.gamma[1]), "minus": float(c.gamma[-1]), "unit": "kg m2"},
        "effective_damping": {"plus": float(c.damping[1]), "minus": float(c.damping[-1]), "unit": "N m s rad-1"},
        "steady_deflection": {"value": float(c.deflection), "unit": "rad"},
        "paradox_region": c.paradox,
        "conditions": conditions(drive),
    }
