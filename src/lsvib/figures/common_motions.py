"""What figures share that follow motions: Figs 8.4 and 8.5, and cycles of the drive with compliant threads."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lsvib.datasets.attributes import variable
from lsvib.datasets.parameter_origins import Variables, drive_parameters, labels
from lsvib.figures.common import EIGENVALUE, about
from lsvib.models.coefficients import coefficients
from lsvib.models.drive import RigidDrive, ThreadsDrive
from lsvib.stability.conditions import conditions
from lsvib.stability.eigenvalues_rigid import eigenvalues

if TYPE_CHECKING:
    from lsvib.dynamics.attractors import SteadyState
    from lsvib.engine.automaton import Automaton

MARGINS = {  # the inequalities of (8.19): unit and wording; each holds where its margin is positive
    "self_locking": ("1", "margin of self-locking, mu - tan(lambda)"),
    "force_with_motion": ("N rad s-1", "margin of a contact force along the motion, by net force times input speed"),
    "negative_effective_damping": ("N m s rad-1", "margin of a negative effective damping of law +"),
}


def negative_damping(settings: Mapping[str, Any], figure: str, what: str) -> xr.Dataset:
    """Compute the phase plane of one drive (Sect. 8.5), the margins of (8.19) and the eigenvalues of its origin.

    Arguments: ``settings`` as of ``PhasePlane``; the figure's number; its subject.
    """
    from lsvib.datasets import phase_plane

    drive = RigidDrive.of(settings["drive"])
    c = coefficients(drive)
    inertia, damping = float(c.gamma[c.steady_law]), float(c.damping[c.steady_law])
    margins = conditions(drive)["negative_damping"]["margins"]
    real, dims = eigenvalues(inertia, damping, drive.coupling_stiffness).real[None], ("case", "eigenvalue")
    return xr.Dataset(
        phase_plane.portraits([drive], settings["starts"], settings["duration"], settings["samples"])
        | {f"margin_{key}": variable("case", [margins[key]], *words) for key, words in MARGINS.items()}
        | {"eigenvalue_real_part": variable(dims, real, "s-1", "real part of the eigenvalue", r"Re $\varepsilon$")},
        coords={
            **labels("case", [drive], ()),
            **drive_parameters([drive], printed=("Sect. 8.5.1",)),
            **phase_plane.rule_coordinate(),
            "eigenvalue": EIGENVALUE,
        },
        attrs=about(
            f"Figure {figure}: phase plane under negative damping, {what}",
            "exact event-driven motion; eigenvalues in closed form (8.18)",
            f"Sect. 8.5, Fig. {figure}",
        ),
    )


def margins_text(dataset: xr.Dataset) -> str:
    """Return the margins of (8.19) for the text of a check."""
    found = {key.replace("_", " "): dataset[f"margin_{key}"] for key in MARGINS}
    return ", ".join(f"{words} {float(margin[0]):.3g} {margin.attrs['units']}" for words, margin in found.items())


def radii(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return each motion's largest |u| [rad] in the first and in the last fifth of the time."""
    u, time = np.abs(dataset.angle_deviation.values[0]), dataset.time.values[0]
    fifth = time[:, -1:] / 5
    return np.where(time <= fifth, u, 0).max(axis=1), np.where(time >= 4 * fifth, u, 0).max(axis=1)


def compliant_cycle(drive: ThreadsDrive, start: Mapping[str, float]) -> "tuple[Automaton, SteadyState]":
    """Return the automaton and the attractor of the motion from a seated contact at u [rad], w [rad/s]."""
    from lsvib.dynamics.attractors import steady_state
    from lsvib.models.threads import seated_state, threads_automaton

    automaton = threads_automaton(drive)
    return automaton, steady_state(automaton, seated_state(drive, start["u"], start["w"]))


def cycle_curves(dims: Sequence[str], cycles: "Sequence[SteadyState]", count: int, prefix: str = "cycle") -> Variables:
    """Return cycles as curves in the phase plane, dimensions (*dims, sample), NaN where there is none.

    Variables: ``{prefix}_time`` [s] from a point of the cycle, ``_angle`` [rad], ``_velocity`` [rad/s]; both states of
    each event are among the samples.
    """
    from lsvib.datasets import phase_plane

    curves = np.full((len(cycles), count, 3), np.nan)
    for curve, steady in zip(curves, cycles, strict=True):
        if steady.orbit is not None:
            times, states, _ = phase_plane.sample(steady.orbit, count)
            curve[:, 0], curve[:, 1:] = times, states[:, :2]
    curves, dims = curves if dims else curves[0], (*dims, f"{prefix}_sample")
    time = variable(dims, curves[..., 0], "s", "time along the cycle", "$t$")
    return {f"{prefix}_time": time, **phase_plane.curve(prefix, dims, curves[..., 1:], "on the limit cycle")}
