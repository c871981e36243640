"""Figure 8.8: eigenvalues of the steady sliding against the translating mass, and the critical mass Γ₊ = 0."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import printed, spans
from lsvib.datasets.attributes import CRITICAL_MASS, Variables, axis, drive_parameters, variable
from lsvib.datasets.checks import Check
from lsvib.errors import InputError
from lsvib.models import chapter
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.numbers import bisected
from lsvib.stability.conditions import critical_mass
from lsvib.stability.linear import eigenvalue_pair


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute both eigenvalues over the mass, the critical mass, and where the spectrum loses stability.

    c_x = 0. The masses crowd towards m_cr, where the eigenvalues diverge.
    """
    drive = RigidDrive.of(settings["drive"])
    critical = critical_mass(drive)
    if critical is None:
        raise InputError("The drive is not self-locking (mu <= tan lambda), so it has no critical mass.")
    # Im² ε = k/Γ − C²/4Γ² of (8.18) vanishes at Γ = C²/4k, where both meet, and is largest, k²/C², at Γ = C²/2k.
    square = drive.support_damping**2 / drive.coupling_stiffness
    # Γ₊ = I (1 − m/m_cr)
    meeting, peak = (critical * (1 - inertia / drive.screw_inertia) for inertia in (square / 4, square / 2))
    mass = _masses(settings["mass"], critical, [meeting, peak])
    dampings = np.array(settings["dampings"], dtype=float)
    losses = [_loss_of_stability(drive.replace(support_damping=float(c)), critical) for c in dampings]
    lost = "mass at which the real part of an eigenvalue becomes positive"
    return xr.Dataset(
        _spectrum(drive, mass) | {"loss_of_stability": variable("swept_support_damping", losses, "kg", lost, "$m$")},
        coords={
            **axis("mass", mass),
            **drive_parameters(drive, axes=("mass",), no_effect=("input_speed", "axial_force"), printed=("Sect. 8.6",)),
            "eigenvalue": variable("eigenvalue", np.array([1, 2]), "1", "index of the eigenvalue", "$i$"),
            **axis("swept_support_damping", dampings),
            "critical_mass": ((), critical, CRITICAL_MASS),
            "meeting_mass": variable((), meeting, "kg", "mass at which both eigenvalues meet and turn real", "$m$"),
            "peak_mass": variable((), peak, "kg", "mass of the largest imaginary part of an eigenvalue", "$m$"),
            "printed_critical_mass": printed.variable(chapter.THRESHOLDS["critical_mass"], "critical mass"),
        },
        attrs={
            "title": "Figure 8.8: eigenvalues of the steady sliding against the translating mass",
            "source": "lsvib, eigenvalues in closed form (8.18), effective inertia in 50-digit arithmetic",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6, Fig. 8.8",
        },
    )


def _spectrum(drive: RigidDrive, mass: np.ndarray) -> Variables:
    """Both eigenvalues and the effective inertia that decides on them, over the mass [kg]."""
    inertia = np.array([_inertia(drive, m) for m in mass])
    pair = eigenvalue_pair(inertia, drive.support_damping, drive.coupling_stiffness)
    dims, words = ("eigenvalue", "mass"), "part of the eigenvalue"
    return {
        "eigenvalue_real_part": variable(dims, pair.real.T, "s-1", f"real {words}", r"Re $\varepsilon$"),
        "eigenvalue_imaginary_part": variable(dims, pair.imag.T, "rad s-1", f"imaginary {words}", r"Im $\varepsilon$"),
        "effective_inertia_plus": variable("mass", inertia, "kg m2", "effective inertia of law +", r"$\Gamma_+$"),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical mass, and that the spectrum loses stability there and nowhere else, at any damping."""
    critical = float(dataset.critical_mass)
    largest = dataset.eigenvalue_real_part.max("eigenvalue")
    below = bool((largest.where(dataset.mass < critical, drop=True) < 0).all())
    heavy = dataset.eigenvalue_real_part.where(dataset.mass > critical, drop=True)
    saddle = bool((heavy.prod("eigenvalue") < 0).all())
    losses = dataset.loss_of_stability.values
    worst = float(losses[np.argmax(np.abs(losses - critical))])
    peak = float(dataset.eigenvalue_imaginary_part.max())
    ratio = peak * float(dataset.support_damping) / float(dataset.coupling_stiffness)
    oscillating = dataset.mass.values[(dataset.eigenvalue_imaginary_part != 0).any("eigenvalue").values]
    meeting = float(dataset.meeting_mass)
    return [
        printed.check("Critical mass, root of Γ₊(m) = 0", chapter.THRESHOLDS["critical_mass"], critical),
        Check.exact(
            f"Mass at which the spectrum loses stability, worst of {losses.size} dampings",
            "eqs 8.18, 8.20",
            critical,
            worst,
            "kg",
        ),
        Check.holds(
            "The imaginary parts peak at k / C_0 and are zero before m_cr, from where C_0² = 4 k Γ_0 on",
            "eq. 8.18, Fig. 8.8",
            f"largest one {peak:.8g} rad/s at {float(dataset.peak_mass):.6g} kg, zero from {meeting:.6g} kg on",
            abs(ratio - 1) < 1e-6 and bool((oscillating < meeting * (1 + 1e-12)).all()) and meeting < critical,
        ),
        Check.holds(
            "Below m_cr both eigenvalues have a negative real part",
            "Sect. 8.6.1, Fig. 8.8",
            f"largest real part {float(largest.where(dataset.mass < critical).max()):.4g} 1/s",
            below,
        ),
        Check.holds(
            "Above m_cr one eigenvalue is positive and the other negative",
            "Sect. 8.6.1, Fig. 8.8",
            f"smallest positive one {float(heavy.max('eigenvalue').min()):.4g} 1/s",
            saddle,
        ),
    ]


def _inertia(drive: RigidDrive, mass: float) -> float:
    """Effective inertia Γ₊ [kg m²] at a mass [kg]; it vanishes at m_cr, so 50 digits are used and rounded once."""
    return float(coefficients(drive.replace(mass=float(mass))).gamma[1])


def _loss_of_stability(drive: RigidDrive, critical: float) -> float:
    """Smallest mass [kg] with an eigenvalue of positive real part, by bisection around m_cr to the last bit."""

    def unstable(mass: float) -> bool:
        pair = eigenvalue_pair(_inertia(drive, mass), drive.support_damping, drive.coupling_stiffness)
        return pair.real.max() >= 0

    return bisected(unstable, critical / 2, 3 * critical / 2)


def _masses(span: Mapping[str, Any], critical: float, marks: list[float]) -> np.ndarray:
    """Masses [kg] of a span without m_cr: evenly spaced ones, ever closer ones on its two sides, the marks."""
    near = critical * np.geomspace(1e-6, 0.1, span["count"] // 4)
    mass = np.unique(np.concatenate([spans.even(span), critical - near, critical + near, marks]))
    return mass[(mass >= span["start"]) & (mass <= span["stop"]) & (mass != critical)]
