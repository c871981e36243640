"""Phase plane under negative effective damping (Sect. 8.5), which figures 8.4 and 8.5 show for two axial forces."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import drive_parameters, labels, variable
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.stability.conditions import conditions
from lsvib.stability.linear import eigenvalue_pair

MARGINS = {  # the inequalities of (8.19): unit and wording; each holds where its margin is positive
    "self_locking": ("1", "margin of self-locking, mu - tan(lambda)"),
    "force_with_motion": ("N rad s-1", "margin of a contact force along the motion, by net force times input speed"),
    "negative_effective_damping": ("N m s rad-1", "margin of a negative effective damping of law +"),
}


def plane(settings: Mapping[str, Any], figure: str, what: str) -> xr.Dataset:
    """Compute the phase plane of one drive, the margins of (8.19) and the eigenvalues of its origin.

    Arguments: ``settings`` with ``drive``, ``starts``, ``duration`` [s], ``samples``; the figure's number; its subject.
    """
    drive = RigidDrive.of(settings["drive"])
    c = coefficients(drive)
    inertia, damping = float(c.gamma[c.steady_law]), float(c.damping[c.steady_law])
    margins = conditions(drive)["negative_damping"]["margins"]
    pair = eigenvalue_pair(inertia, damping, drive.coupling_stiffness)
    return xr.Dataset(
        phase_plane.portraits([drive], settings["starts"], settings["duration"], settings["samples"])
        | {f"margin_{key}": variable("case", [margins[key]], *words) for key, words in MARGINS.items()}
        | {
            "eigenvalue_real_part": variable(
                ("case", "eigenvalue"), pair.real[None], "s-1", "real part of the eigenvalue", r"Re $\varepsilon$"
            )
        },
        coords={
            **labels("case", [drive], ()),
            **drive_parameters([drive], printed=("Sect. 8.5.1",)),
            **phase_plane.rule_coordinate(),
            "eigenvalue": variable("eigenvalue", np.array([1, 2]), "1", "index of the eigenvalue", "$i$"),
        },
        attrs={
            "title": f"Figure {figure}: phase plane under negative damping, {what}",
            "source": "lsvib, exact event-driven motion; eigenvalues in closed form (8.18)",
            "references": f"doi:10.1007/978-1-4419-1752-2_8, Sect. 8.5, Fig. {figure}",
        },
    )


def margins_text(dataset: xr.Dataset) -> str:
    """Return the margins of (8.19) for the text of a check."""
    return ", ".join(
        f"{key.replace('_', ' ')} {float(dataset[f'margin_{key}'][0]):.3g} {dataset[f'margin_{key}'].attrs['units']}"
        for key in MARGINS
    )


def radii(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return each motion's largest |u| [rad] in the first and in the last fifth of the time."""
    u = np.abs(dataset.angle_deviation.values[0])
    time = dataset.time.values[0]
    fifth = time[:, -1:] / 5
    first = np.where(time <= fifth, u, 0).max(axis=1)
    return first, np.where(time >= 4 * fifth, u, 0).max(axis=1)
