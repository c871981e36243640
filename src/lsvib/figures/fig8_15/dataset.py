"""Figure 8.15: instability regions of the drive with axial support over friction coefficient and support stiffness."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import printed, spans
from lsvib.datasets.attributes import Variables, axis, drive_parameters, flagged, variable
from lsvib.errors import InputError
from lsvib.figures.fig8_15.checks import DAMPINGS, checks
from lsvib.models import chapter
from lsvib.models.drive import SupportDrive
from lsvib.stability import conditions
from lsvib.stability.conditions import critical_friction
from lsvib.stability.linear import UndampedClass, support_model, undamped_class

__all__ = ["build", "checks"]

_LAW = 1  # R Ω > 0


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the undamped class map by eigenvalues, flutter boundaries in closed form, critical friction both ways."""
    drive = SupportDrive.of({"screw_mass": settings["screw_mass"], **settings["drive"]})
    friction = spans.even(settings["friction_coefficient"])
    stiffness = spans.logarithmic(settings["support_stiffness"])
    drive.replace(friction_coefficient=float(friction.max()))  # refuses what is beyond cot λ
    critical = critical_friction(drive, drive.screw_mass)
    if critical is None:
        raise InputError("No friction coefficient below cot(lead_angle) makes the reduced inertia vanish.")
    curve = _curve(friction, float(np.tan(drive.lead_angle)), critical)
    dims = ("friction_coefficient", "support_stiffness")
    grid = {**dict(drive), "friction_coefficient": friction[:, None], "support_stiffness": stiffness}
    kinds = undamped_class(support_model(grid, _LAW))
    by_eigenvalues = conditions.critical_friction_by_eigenvalues(drive)
    passing = "friction coefficient where an eigenvalue 1/omega^2 passes through zero"
    return xr.Dataset(
        {
            "stability": flagged(dims, kinds, "class of the steady sliding", UndampedClass),
            **_boundaries(drive, curve),
            "critical_friction": variable((), critical, "1", "critical friction coefficient, closed form", r"$\mu$"),
            "critical_friction_by_eigenvalues": variable((), by_eigenvalues, "1", passing, r"$\mu$"),
        },
        coords={
            **axis("friction_coefficient", friction),
            **axis("support_stiffness", stiffness),
            "printed_critical_friction": printed.variable(
                chapter.THRESHOLDS["critical_friction"], "critical friction coefficient"
            ),
            **axis("boundary_friction_coefficient", curve),
            **_parameters(drive),
        },
        attrs={
            "title": "Figure 8.15: instability regions over friction coefficient and axial support stiffness, undamped",
            "source": "lsvib, generalised eigenvalues of (8.23), boundaries (8.29) in closed form",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.8.1, Fig. 8.15",
            "comment": "R Omega > 0; undamped",
        },
    )


def _boundaries(drive: SupportDrive, friction: np.ndarray) -> Variables:
    """Both boundaries of mode coupling (8.29) at some friction coefficients."""
    branches = conditions.flutter_boundaries({**dict(drive), "friction_coefficient": friction}, _LAW)
    return {
        f"{which}_boundary": variable(
            "boundary_friction_coefficient", branches[:, k], "N m-1", f"{which} boundary of mode coupling", "$k_1$"
        )
        for k, which in enumerate(("lower", "upper"))
    }


def _parameters(drive: SupportDrive) -> Variables:
    """The parameters of the undamped drive; some have a comment, because the text names a table that is missing."""
    parameters = drive_parameters(
        drive.replace(**dict.fromkeys(DAMPINGS, 0.0)),
        axes=("friction_coefficient", "support_stiffness"),
        printed=("Fig. 8.15", "Sect. 8.8.1"),
        assumed=("coupling_stiffness",),
        no_effect=("input_speed", "axial_force", "slide_friction", "bearing_friction"),
    )
    # The text names Table 7.1, which is not in the chapter.
    for name in ("pitch_radius", "lead_angle", "screw_inertia"):
        parameters[name][2]["comment"] = "the text names Table 7.1; with these the printed critical friction comes out"
    parameters["coupling_stiffness"][2]["comment"] = (
        "Table 7.1 is not in the chapter; both branches of (8.29) are in proportion to it"
    )
    return parameters


def _curve(friction: np.ndarray, start: float, stop: float) -> np.ndarray:
    """Friction coefficients from start to stop, both included, crowded at both ends, and those of the map between."""
    crowded = start + (stop - start) * (1 - np.cos(np.linspace(0, np.pi, 801))) / 2
    return np.unique(np.concatenate([crowded, friction[(friction > start) & (friction < stop)]]))
