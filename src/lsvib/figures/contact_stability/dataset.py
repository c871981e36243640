"""Critical mass of the drive with compliant threads over its contact, and the growth rates of Lemma 8.1."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import spans
from lsvib.datasets.attributes import (
    CRITICAL_MASS,
    Variables,
    axis,
    drive_parameters,
    labels,
    origin_of,
    variable,
    yes_no,
)
from lsvib.errors import InputError
from lsvib.figures.common.compliant_cycles import CRITICAL_MASS_WITH_CONTACT
from lsvib.figures.contact_stability.checks import checks
from lsvib.models.drive import ThreadsDrive
from lsvib.models.mechanics import coefficients
from lsvib.stability.boundaries import stable_set
from lsvib.stability.conditions import (
    LARGEST_MASS,
    critical_mass,
    critical_mass_of_contact,
    least_damping_of_stiff_contact,
    stable_masses,
    unstable_contact_stiffness,
)
from lsvib.stability.linear import eigenvalues, threads_model

__all__ = ["build", "checks"]

_LAW = 1  # R Ω > 0
_CONTACT = ("contact_stiffness", "contact_damping")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the critical mass over the contact and for some contacts, and growth rates over the contact stiffness.

    ``settings``: see ``Settings``; c_x = 0, R Ω > 0. Raises ``InputError``.
    """
    drive = ThreadsDrive.of(settings["drive"])
    rigid = critical_mass(drive)
    heavy, light = settings["masses"]
    if rigid is None or not light < rigid < heavy:
        raise InputError(f"masses = {[heavy, light]} do not lie above and below the critical mass of the rigid drive.")
    along, stiffness = (spans.logarithmic(settings[name]) for name in ("contact_damping", "stiffness"))
    curves, dampings = np.array(settings["stiffnesses"], float), np.array(settings["dampings"], float)
    contacts = [drive.replace(**contact) for contact in settings["contacts"]]
    critical = [critical_mass_of_contact(d) for d in contacts]
    return xr.Dataset(
        _curves(drive, curves, along)
        | {"critical_mass_with_contact": variable("contact", critical, *CRITICAL_MASS_WITH_CONTACT)}
        | _growth_rates(drive, heavy, light, dampings, stiffness)
        | _limits(drive, heavy, light),
        coords={
            **axis("curve_contact_stiffness", curves),
            **axis("curve_contact_damping", along),
            **labels("contact", contacts, _CONTACT),
            **drive_parameters(
                contacts,
                "contact",
                along=_CONTACT,
                axes=("mass",),
                printed=("Sect. 8.6", "Sect. 8.6.1"),
                no_effect=("axial_force", "input_speed"),
            ),
            **axis("mass", [heavy, light], origin=origin_of("mass", [heavy, light], ("Sect. 8.6.1",))),
            **axis("growth_contact_damping", dampings),
            **axis("growth_contact_stiffness", stiffness),
            "critical_mass": ((), rigid, CRITICAL_MASS),
        },
        attrs={
            "title": "Stability of steady sliding with compliant threads: critical mass, growth rates and Lemma 8.1",
            "source": "lsvib, characteristic polynomial in rational numbers, eigenvalues by LAPACK",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Lemma 8.1, Sects 8.2, 8.6.1; docs/lemmas.md",
            "comment": "R Omega > 0",
        },
    )


def _curves(drive: ThreadsDrive, curves: np.ndarray, along: np.ndarray) -> Variables:
    """Masses between which steady sliding is stable, over contact stiffness k_c [N/m] and damping c_c [N s/m]."""
    found = [
        [stable_masses(drive.replace(contact_stiffness=float(k), contact_damping=float(c))) for c in along]
        for k in curves
    ]
    grid = np.array([[intervals[0][1] if intervals else np.nan for intervals in row] for row in found])
    again = np.array([[intervals[1][0] if len(intervals) > 1 else np.nan for intervals in row] for row in found])
    dims, lost = ("curve_contact_stiffness", "curve_contact_damping"), np.where(grid < LARGEST_MASS, grid, np.nan)
    words = "mass from which on steady sliding is stable again, missing if from none"
    return {
        "curve_critical_mass_with_contact": variable(dims, lost, *CRITICAL_MASS_WITH_CONTACT),
        "stable_again": variable(dims, again, "kg", words),
        "stable_at_every_mass": yes_no(dims, grid >= LARGEST_MASS, "steady sliding is stable at every mass"),
    }


def _growth_rates(
    drive: ThreadsDrive, heavy: float, light: float, dampings: np.ndarray, stiffness: np.ndarray
) -> Variables:
    """Growth rates of two masses [kg] over the contact stiffness, and where Lemma 8.1 and damping decide."""
    drives = [[drive.replace(mass=m, contact_damping=c) for c in dampings] for m in (heavy, light)]
    models = [[threads_model({**dict(d), "contact_stiffness": stiffness}, _LAW) for d in row] for row in drives]
    growth = [[eigenvalues(model)[:, -1].real for model in row] for row in models]
    stable = [stable_set(drive.replace(mass=light, contact_stiffness=k), "contact_damping") for k in stiffness]
    dampings_of = [[(float(a), float(b)) for a, b in found.intervals] for found in stable]
    window = np.array([row[0] if len(row) > 1 else (np.nan, np.nan) for row in dampings_of])
    above = [unstable_contact_stiffness(drive.replace(mass=heavy, contact_damping=c)) for c in dampings]
    damping, stiff = "growth_contact_damping", "growth_contact_stiffness"
    largest, proved = "largest real part of the eigenvalues", "contact stiffness beyond which Lemma 8.1 is proved"
    enough = "contact damping above which the smaller mass is stable for all"
    fewer = "ends of an interval of smaller dampings at which it is stable, too"
    return {
        "growth_rate": variable(("mass", damping, stiff), growth, "s-1", largest, r"max Re $s$"),
        "unstable_contact_stiffness": variable(damping, above, "N m-1", proved, "$k_c$"),
        "least_contact_damping": variable(stiff, [row[-1][0] for row in dampings_of], "N s m-1", enough, "$c_c$"),
        "window_of_soft_contact": variable((stiff, "end"), window, "N s m-1", fewer, "$c_c$"),
    }


def _limits(drive: ThreadsDrive, heavy: float, light: float) -> Variables:
    """What the growth rates of two masses [kg] tend to for a stiff contact, and the scale of Lemma 8.1."""
    gamma = {mass: float(coefficients(drive.replace(mass=mass)).gamma[_LAW]) for mass in (heavy, light)}
    beta = float(np.cos(drive.lead_angle) ** 2 * (1 + drive.friction_coefficient * np.tan(drive.lead_angle)))
    lever = beta * abs(gamma[heavy]) / (drive.screw_inertia * heavy)
    elastic = drive.support_damping / 2 * (1 / gamma[light] - 1 / drive.screw_inertia)
    least = least_damping_of_stiff_contact(drive.replace(mass=light))
    return {
        "least_contact_damping_of_stiff_contact": variable(
            (), least, "N s m-1", "its limit for a stiff contact", "$c_c$"
        ),
        "elastic_growth_limit": variable(
            (), elastic, "s-1", "limit of the growth rate of the smaller mass for a stiff elastic contact"
        ),
        "growth_scale": variable(
            (), lever, "kg-1", "beta |Gamma_0| / (I m) of the larger mass, to which its growth rates are scaled"
        ),
    }
