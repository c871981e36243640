"""Figure 8.9: trajectories (a) below and (b) above the critical mass, and the effect of the axial force on (b)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import CRITICAL_MASS, axis, drive_parameters, flagged, labels, variable
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.dynamics.impulses import seizure_speeds
from lsvib.errors import InputError
from lsvib.models.drive import RigidDrive
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.conditions import critical_mass

_SWEEP = "of the last case with another axial force, from the first start"


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute both phase planes, the critical mass and the sensitivity of case (b) to R, which the text leaves out."""
    drive = RigidDrive.of(settings["drive"])
    drives = [drive.replace(**changes) for changes in settings["cases"]]
    critical = critical_mass(drive)
    if critical is None:
        raise InputError("The drive is not self-locking (mu <= tan lambda), so it has no critical mass.")
    forces = spans.even(settings["axial_force"])
    return xr.Dataset(
        phase_plane.portraits(drives, settings["starts"], settings["duration"], settings["samples"])
        | _sensitivity(drives[-1], forces, settings["starts"][0]),
        coords={
            **labels("case", drives, ("mass",)),
            **drive_parameters(drives, along=("mass",), printed=("Sect. 8.6", "Sect. 8.6.1")),
            **phase_plane.rule_coordinate(),
            **axis("swept_axial_force", forces),
            "critical_mass": ((), critical, CRITICAL_MASS),
        },
        attrs={
            "title": "Figure 8.9: trajectories below and above the critical mass",
            "source": "lsvib, exact event-driven motion and its return map",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6.1, Fig. 8.9",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the signs of Γ₊, where the motions end, and that the choice of R does not decide it."""
    gamma, mass, critical = dataset.effective_inertia_plus.values, dataset.mass.values, float(dataset.critical_mass)
    light, heavy = dataset.attractor.values
    amplitude = dataset.amplitude.values[1].ravel()
    spread = float(np.ptp(amplitude) / amplitude.max()) if amplitude.max() > 0 else np.inf
    labels = dataset.swept_attractor.values
    forces = dataset.swept_axial_force.values
    speed = dataset.impact_speed.values / float(-dataset.stop_velocity[1])
    swing = float(np.ptp(speed) / (speed.max() + speed.min()))
    return [
        Check.holds(
            "The critical mass lies between the masses of (a) and (b), and Γ₊ changes sign there",
            "Sect. 8.6.1, eq. 8.20",
            f"Γ₊ = {gamma[0]:.3g} kg m2 at {mass[0]:g} kg, {gamma[1]:.3g} kg m2 at {mass[1]:g} kg; "
            f"m_cr = {critical:.4f} kg",
            bool(gamma[0] > 0 > gamma[1] and mass[0] < critical < mass[1]),
        ),
        Check.everywhere(
            "(a) below the critical mass every motion decays to the origin",
            "Sect. 8.6.1, Fig. 8.9a",
            light == Attractor.STEADY_SLIDING,
        ),
        Check.holds(
            "(b) above the critical mass every motion ends on one sprag-slip cycle, under either rule of resuming",
            "Sect. 8.6.1, Fig. 8.9b",
            f"{int((heavy == Attractor.SPRAG_SLIP_CYCLE).sum())} of {heavy.size}, amplitude {amplitude[0]:.6g} rad, "
            f"relative spread {spread:.1e}",
            bool((heavy == Attractor.SPRAG_SLIP_CYCLE).all()) and spread < 1e-12,
        ),
        Check.holds(
            "The axial force, which the text leaves out, changes neither the kind of motion in (b) nor, by 2 %, "
            "the impact speed that the peak force is proportional to",
            "Sect. 8.6.1, Figs 8.9b, 8.10b",
            f"R from {forces[0]:g} to {forces[-1]:g} N: sprag-slip, "
            f"impact speed {speed.min():.4g} to {speed.max():.4g} times Ω, but amplitude "
            f"{dataset.swept_amplitude.values.max():.3g} down to {dataset.swept_amplitude.values.min():.3g} rad",
            bool((labels == Attractor.SPRAG_SLIP_CYCLE).all()) and swing < 0.02,
        ),
    ]


def _sensitivity(drive: RigidDrive, forces: np.ndarray, start: Mapping[str, float]) -> phase_plane.Variables:
    rows = []
    for force in forces:
        pushed = drive.replace(axial_force=float(force))
        steady = steady_state(rigid_automaton(pushed), [start["u"], start["w"]])
        speeds = np.empty(0) if steady.orbit is None else np.abs(seizure_speeds(pushed, steady.orbit))
        rows.append((steady.label, steady.amplitude, speeds.max() if speeds.size else np.nan))
    (label, amplitude, speed), dim = np.array(rows, dtype=float).T, "swept_axial_force"
    return {
        "swept_attractor": flagged(dim, label, phase_plane.ATTRACTOR, Attractor, comment=_SWEEP),
        "swept_amplitude": variable(dim, amplitude, "rad", phase_plane.AMPLITUDE, comment=_SWEEP),
        "impact_speed": variable(dim, speed, "rad s-1", "screw speed before a seizure", r"$\dot\theta$"),
    }
