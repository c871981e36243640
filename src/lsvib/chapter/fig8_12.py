"""Figure 8.12: amplitude, mean deflection and mean contact force of the sprag–slip cycle against the damping."""

from itertools import product

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import phase_plane, spans
from lsvib.answers.attributes import drive_parameters, named, start_state, variable, varied
from lsvib.chapter.checks import Check
from lsvib.chapter.common import about
from lsvib.chapter.settings import DriveFigure, Span, State, Values
from lsvib.drives.drive import Drive
from lsvib.drives.names import RULES, MotionMode
from lsvib.errors import InputError
from lsvib.numbers import bisected
from lsvib.pictures import style

CAPTION = """\
Sprag–slip cycle over the support damping c: (a) amplitude, (b) mean deflection of the coupling and (c) mean contact
force, with the contribution of the seizure impulses. Both resume rules give these lines; they differ only below the
damping at which the screw begins to rest, 31 × 10⁻⁶ N m s/rad.
"""

_QUANTITIES = {
    "amplitude": ("rad", "amplitude of the steady vibration, half its peak-to-peak", ""),
    "mean_deflection": ("rad", "mean coupling deflection", r"$\langle z \rangle$"),
    "mean_normal_force": ("N", "mean magnitude of the normal force, impulses included", r"$\langle |N| \rangle$"),
    "mean_impulsive_force": ("N", "part of the mean normal force that comes from impulses", ""),
    "mean_axial_contact_force": ("N", "mean axial contact force, impulses included", ""),
    "mean_contact_torque": ("N m", "mean contact torque on the screw, impulses included", ""),
    "mean_coupling_torque": ("N m", "mean coupling torque less the mean damping torque", ""),
}
_PANELS = (  # variable, title, word on the axis
    ("amplitude", "amplitude", "amplitude of $u$"),
    ("mean_deflection", "mean deflection", "mean deflection"),
    ("mean_normal_force", "mean force", "mean force"),
)


class Settings(DriveFigure):
    unused = ("support_damping",)

    support_damping: Span = Field(description="c [N m s/rad], from zero or more.")
    start: State


def build(settings: Values) -> xr.Dataset:
    """Compute the cycle's amplitude and means over the damping, under both rules; closer where they differ."""
    from lsvib.dynamics.impulses import mean_load

    drive, start = Drive.of(settings["drive"]), settings["start"]
    wanted = spans.even(settings["support_damping"])
    limit = _resting_damping(drive, start, float(wanted.max()))
    damping = np.unique(np.concatenate([wanted, limit * np.linspace(0, 1, 13)]))
    damping = damping[damping >= wanted.min()]
    dims, resting = ("rule", "support_damping"), "damping below which the screw rests after a seizure"
    shape = len(RULES), damping.size
    values, labels = np.full((*shape, len(_QUANTITIES)), np.nan), np.empty(shape)  # NaN where there is no cycle
    for (i, rule), (j, c) in product(enumerate(RULES), enumerate(damping.tolist())):
        own = drive.replace(support_damping=c)
        steady = phase_plane.reached(own, start, rule)
        labels[i, j], values[i, j, 0] = steady.label, steady.amplitude
        if steady.orbit is not None:
            values[i, j, 1:-1] = load = mean_load(own, steady.orbit)
            values[i, j, -1] = -own.coupling_stiffness * load[0] - c * own.input_speed
    return xr.Dataset(
        {name: variable(dims, values[..., k], *words) for k, (name, words) in enumerate(_QUANTITIES.items())}
        | {"attractor": phase_plane.attractors(dims, labels)},
        coords={
            **varied(support_damping=damping),
            "rule": phase_plane.RULE,
            "resting_support_damping": variable((), limit, "N m s rad-1", resting, "$c$"),
            **drive_parameters(drive, axes=("support_damping",), printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(start, "of the motions whose cycles are found"),
        },
        attrs=about(__doc__, "exact means over the cycle of the exact event-driven motion", "Sect. 8.6.1, Fig. 8.12"),
    )


def _resting_damping(drive: Drive, start: Values, largest: float) -> float:
    """Smallest damping [N m s/rad] up to ``largest`` whose cycle has no rest, by bisection to the last bit."""

    def rests(damping: float) -> bool:
        orbit = phase_plane.reached(drive.replace(support_damping=damping), start).orbit
        return orbit is None or bool((orbit.automaton.codes[orbit.arcs()[0]] == MotionMode.REST).any())

    if rests(largest):
        raise InputError(f"support_damping: the screw still rests at the stop, {largest:g}; give a larger one.")
    return bisected(lambda damping: not rests(damping), 0.0, largest) if rests(0.0) else 0.0


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that every drive vibrates, the trends over the damping, and both balances of momentum over a cycle."""
    limit, amplitude = float(dataset.resting_support_damping), dataset.amplitude.values
    force, damping = dataset.mean_normal_force.values, dataset.support_damping.values
    deflection, damped, slips = np.abs(dataset.mean_deflection.values), damping > 0, damping >= limit
    lowest, gap = damping[np.argmin(force[0])], float(np.max(np.abs(amplitude[0] / amplitude[1] - 1)[slips]))
    less = 1 - amplitude[0, -1] / amplitude[0, 0]
    ratio, later = deflection[0, -1] / deflection[0, 0], deflection[1, damped]
    axial = dataset.mean_axial_contact_force / float(dataset.axial_force)
    torque = dataset.mean_contact_torque / dataset.mean_coupling_torque
    grows = (np.diff(deflection[0]) > 0).all() and (np.diff(later) > 0).all()
    rises = (np.diff(force[:, slips]) > 0).all() and slips.sum() > 1
    first = {"first": later[0], "least": damping[damped][0]}
    return [
        Check.everywhere("fig8_12.sprag_slip", named(dataset.attractor, "sprag slip cycle")),
        Check.that("fig8_12.amplitude", (np.diff(amplitude) < 0).all(), amplitude=amplitude[0], less=less),
        Check.that("fig8_12.deflection", grows, deflection=deflection[0], **first),
        Check.that("fig8_12.considerable", ratio > 2, more=ratio - 1),
        Check.that("fig8_12.force", rises, slips=force[0, slips], limit=limit, force=force[0], lowest=lowest),
        Check.that("fig8_12.rules", gap < 1e-12, gap=gap, limit=limit),
        Check.of("fig8_12.axial_balance", axial, expected=1.0),
        Check.of("fig8_12.torque_balance", torque, expected=1.0),
    ]


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the three quantities under the rule of the contact sign."""
    figure = style.new_figure(style.DOUBLE, 2.6)
    panels, damping = figure.subplots(1, 3), dataset.support_damping * 1e3
    panels[2].plot(damping, dataset.mean_impulsive_force[0], color=style.GREY, label="part from impulses")
    for axes, letter, (name, title, word) in zip(panels, "abc", _PANELS, strict=True):
        axes.plot(damping, dataset[name][0], color=style.BLUE)
        ylabel = style.label(dataset[name], word)
        style.frame(axes, f"({letter}) {title}", "Damping $c$ [10⁻³ N m s rad⁻¹]", ylabel, xlim=damping[[0, -1]])
    panels[2].set_ylim(0, None)
    panels[2].legend()
    return figure
