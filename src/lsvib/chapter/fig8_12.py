"""Figure 8.12: amplitude, mean deflection and mean contact force of the sprag–slip cycle against the damping."""

from itertools import product

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import phase_plane, spans
from lsvib.answers.attributes import drive_parameters, named, start_state, variable, varied
from lsvib.chapter import newton
from lsvib.chapter.checks import Check, each, every, near
from lsvib.chapter.common import about
from lsvib.chapter.settings import DriveFigure, Span, State, Values
from lsvib.drives.drive import Drive
from lsvib.drives.names import RULES, MotionMode
from lsvib.errors import InputError
from lsvib.numbers import bisected
from lsvib.pictures import style

CAPTION = """\
Sprag–slip cycle against support damping c: (a) amplitude, (b) mean deflection of the coupling and (c) mean contact
force, with the contribution of the seizure impulses. Both resume rules give these curves, except below 31 × 10⁻⁶ N m
s/rad, where the screw rests after a seizure.
"""

_QUANTITIES = {
    "amplitude": ("rad", "amplitude of the steady vibration, half its peak-to-peak", ""),
    "mean_deflection": ("rad", "mean coupling deflection", r"$\langle z \rangle$"),
    "mean_normal_force": ("N", "mean magnitude of the normal force, impulses included", r"$\langle |N| \rangle$"),
    "mean_impulsive_force": ("N", "part of the mean normal force that comes from impulses", ""),
    "mean_axial_contact_force": ("N", "mean axial contact force, impulses included", ""),
    "mean_contact_torque": ("N m", "mean contact torque on the screw, impulses included", ""),
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
    shape, cycles = (len(RULES), damping.size), []
    values, labels = np.full((*shape, len(_QUANTITIES)), np.nan), np.empty(shape)  # NaN where there is no cycle
    for (i, rule), (j, c) in product(enumerate(RULES), enumerate(damping.tolist())):
        own = drive.replace(support_damping=c)
        steady = phase_plane.reached(own, start, rule)
        labels[i, j], values[i, j, 0] = steady.label, steady.amplitude
        if steady.orbit is not None:
            values[i, j, 1:] = mean_load(own, steady.orbit)
        cycles += [steady] if i == 0 else []
    return xr.Dataset(
        {name: variable(dims, values[..., k], *words) for k, (name, words) in enumerate(_QUANTITIES.items())}
        | {"attractor": phase_plane.attractors(dims, labels)}
        | phase_plane.cycle_curves(("support_damping",), cycles, 120),  # so many give a mean to 1e-4
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
        raise InputError(f"support_damping: the screw still rests at stop = {largest:g}; give a larger stop.")
    return bisected(lambda damping: not rests(damping), 0.0, largest) if rests(0.0) else 0.0


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that every drive vibrates, the trends over the damping, and means by quadratures and balances of momentum.

    Over a cycle the momenta of screw and nut do not change.
    """
    limit, amplitude = float(dataset.resting_support_damping), dataset.amplitude
    force, damping = dataset.mean_normal_force.values, dataset.support_damping.values
    deflection, damped, slips = np.abs(dataset.mean_deflection.values), damping > 0, damping >= limit
    gap = np.abs(amplitude[0] / amplitude[1] - 1)[slips]
    ratio, later = deflection[0, -1] / deflection[0, 0], deflection[1, damped]
    axial = dataset.mean_axial_contact_force / float(dataset.axial_force)
    coupling = dataset.coupling_stiffness * dataset.mean_deflection + dataset.support_damping * dataset.input_speed
    return [
        newton.cycle_check(dataset, "Fig. 8.12", amplitude=amplitude[0]),
        *_mean_checks(dataset.isel(rule=0)),
        Check.that("fig8_12.sprag_slip", cycles=every(named(dataset.attractor, "sprag slip cycle"))),
        Check.that("fig8_12.amplitude", steps=each(np.diff(amplitude), "<", 0), amplitude=amplitude[0],
                   less=1 - amplitude[0, -1] / amplitude[0, 0]),
        Check.that("fig8_12.deflection", steps=each(np.diff(deflection[0]), ">", 0),
                   steps_at_once=each(np.diff(later), ">", 0), deflection=deflection[0], first=later[0],
                   least=damping[damped][0]),
        Check.that("fig8_12.considerable", ratio=each(ratio, ">", 2), more=ratio - 1),
        Check.that("fig8_12.force", steps=each(np.diff(force[0, slips]), ">", 0), slips=force[0, slips], limit=limit,
                   steps_at_once=each(np.diff(force[1, damped]), ">", 0), first=force[1, damped][0],
                   steps_with_rest=each(np.diff(force[0, damping <= limit]), "<", 0), force=force[0]),
        Check.that("fig8_12.rules", gap=each(gap, "<", 1e-12), limit=limit),
        Check.of("fig8_12.axial_balance", axial, expected=1.0),
        Check.of("fig8_12.torque_balance", -dataset.mean_contact_torque / coupling, expected=1.0),
    ]  # fmt: skip


def _mean_checks(dataset: xr.Dataset) -> list[Check]:
    """Check mean forces by quadratures of the samples of the cycles, and which of these rest."""
    cycles = newton.cycle_motion(dataset)
    force, speed = abs(cycles.normal_force), cycles.w + cycles.input_speed
    steps, earlier = cycles.time - cycles.time.shift(sample=1), speed.shift(sample=1)
    fall = (earlier - speed).where(steps == 0, 0)  # of θ′, in seizures
    arm = cycles.mass * cycles.pitch_radius - cycles.screw_inertia / cycles.pitch_radius
    impulsive = (np.sin(cycles.lead_angle) * arm * fall).sum("sample") / steps.sum("sample")
    normal = ((force + force.shift(sample=1)) / 2 * steps).sum("sample") / steps.sum("sample") + impulsive
    rests = ((speed == 0) & (earlier == 0) & (steps > 0)).any("sample")
    return [
        Check.that("fig8_12.means", normal_force=near(dataset.mean_normal_force, normal, 1e-3),
                   impulses=near(dataset.mean_impulsive_force, impulsive, 1e-3)),
        Check.that("fig8_12.rests", cycles=every(rests == (dataset.support_damping < dataset.resting_support_damping))),
    ]  # fmt: skip


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
