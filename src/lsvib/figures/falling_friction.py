"""Chatter by falling friction: the onset over the input speed, and the vibration on both sides of it."""

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import phase_plane, spans
from lsvib.datasets.analysis import least_onset_force
from lsvib.datasets.attributes import ASSUMED, drive_parameters, named_index, parameter, variable, varied
from lsvib.datasets.checks import Check
from lsvib.figures import settings as of
from lsvib.figures import style
from lsvib.figures.common import BALANCE, about, balance_check, named
from lsvib.models import friction
from lsvib.models.drive import Drive
from lsvib.stability.threshold import solve_threshold

CAPTION = """\
The seat drive of which Table 8.1 keeps the constant part of friction, with the whole law that was identified for it
(μ falls with the sliding speed). (a) Coefficient of friction. (b) Axial force from which steady sliding is unstable:
with the law; with the constant of the chapter it is stable at every force. (c), (d) Amplitude of what motions end in,
from a start next to steady sliding and from one far away, over the force and over the input speed: where both differ,
chatter that has begun goes on although it would not begin, and stops only beyond the end of the upper branch.
"""

STARTS = ("near", "far")
# Onset forces [N] of the law at input speeds [rad/s], from the closed form C_0 + S = 0 evaluated apart from lsvib.
KNOWN = {40.0: 88.934, 10.0: 64.305, 5.0: 24.914, 2.0: 9.8556}


class Settings(of.DriveFigure):
    flows = ("taylor",)

    input_speed: of.PositiveSpan = Field(description="Input speeds of the onset, evenly spaced in logarithm [rad/s].")
    swept_input_speed: of.PositiveSpan = Field(description="Input speeds over which motions are followed [rad/s].")
    swept_axial_force: of.PositiveSpan = Field(description="Axial forces over which motions are followed [N].")
    force: of.parameter("axial_force")


def build(settings: of.Values) -> xr.Dataset:
    """Compute the coefficient and the onset over the speed, and what motions end in on both sides of it."""
    from lsvib.dynamics.energy import balance

    drive = Drive.of(settings["drive"])
    speeds = np.unique([*spans.logarithmic(settings["input_speed"]), *KNOWN])
    force, speed = spans.even(settings["swept_axial_force"]), spans.logarithmic(settings["swept_input_speed"])
    slid = [drive.replace(input_speed=at) for at in speeds.tolist()]
    onsets = [least_onset_force(one) for one in slid]
    masses = [solve_threshold(one, "kinematic_constraint").value for one in slid]
    over_force = _motions(drive, axial_force=force)
    over_speed = _motions(drive.replace(axial_force=settings["force"]), input_speed=speed)
    pushed = drive.replace(axial_force=float(force[-1]))
    far = phase_plane.reached(pushed, {"u": 0.1, "w": -drive.input_speed})
    sliding = np.geomspace(1e-4, 1.2 * drive.pitch_radius * speeds.max(), 200)
    mu = [float(friction.coefficient(drive, v)) for v in sliding.tolist()]
    dims, other = ("start", "swept_axial_force"), ("start", "swept_input_speed")
    size, over, steady = phase_plane.AMPLITUDE, ", over the input speed", "critical mass in steady sliding"
    return xr.Dataset(
        {
            "coefficient": variable("sliding_speed", mu, "1", "friction coefficient of the threads", r"$\mu$"),
            "onset_force": variable("input_speed", onsets, "N", "onset force", "$R$"),
            "steady_critical_mass": variable("input_speed", masses, "kg", steady, r"$m_\mathrm{cr}$"),
            "energy_balance": variable((), balance(pushed, far.orbit), *BALANCE),
            "attractor": phase_plane.attractors(dims, over_force.attractor),
            "amplitude": variable(dims, over_force.amplitude, "rad", size, r"$\hat u$"),
            "speed_attractor": phase_plane.attractors(other, over_speed.attractor, f"{phase_plane.ATTRACTOR}{over}"),
            "speed_amplitude": variable(other, over_speed.amplitude, "rad", f"{size}{over}", r"$\hat u$"),
        },
        coords={
            **drive_parameters(drive, axes=("input_speed",), no_effect=("axial_force",), printed=("Sect. 8.5.1",)),
            **varied(input_speed=speeds, swept_axial_force=force, swept_input_speed=speed),
            "sliding_speed": variable("sliding_speed", sliding, "m s-1", "sliding speed of the threads", "$v$"),
            "start": named_index("start", "where motions start", STARTS),
            "drawn_input_speed": ((), drive.input_speed, parameter("drawn_input_speed", ASSUMED)),
            "drawn_axial_force": ((), settings["force"], parameter("drawn_axial_force", ASSUMED)),
        },
        attrs=about(__doc__, "closed form and motions by power series", "Table 8.1, Sect. 8.5"),
    )


def _motions(drive: Drive, **swept: np.ndarray):
    """Return what motions end in, from both starts, along one parameter; arrays (start, k)."""
    from lsvib.dynamics.behaviour import near_and_far
    from lsvib.dynamics.sweep import all_endings
    from lsvib.models.many import ManyDrives

    drives = ManyDrives({**dict(drive), **swept})
    return np.stack([all_endings(drives, starts) for starts in near_and_far(drives)]).view(np.recarray)


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the onset against the closed form, and that motions change where it says."""
    onset, slides = dataset.onset_force, named(dataset.attractor, "steady sliding")
    force, speed = dataset.swept_axial_force.values, dataset.swept_input_speed.values
    begins, stops = (float(force[~row].min(initial=np.inf)) for row in slides)
    here = float(onset.sel(input_speed=dataset.drawn_input_speed))
    damping, dragged = float(dataset.support_damping), float(dataset.translation_damping)
    slow, fast = (float(speed[~row].max(initial=0.0)) for row in named(dataset.speed_attractor, "steady sliding"))
    onsets = [(at, x, onset.sel(input_speed=at)) for at, x in KNOWN.items()]
    return [
        *(Check.of("falling_friction.onset", found, expected=x, speed=at) for at, x, found in onsets),
        Check.of("falling_friction.begins", begins, expected=here, tolerance=float(np.diff(force).max()) / here),
        Check.that("falling_friction.goes_on", stops < begins, begins=begins, stops=stops),
        Check.that("falling_friction.speed", slow < fast, slow=slow, fast=fast),
        balance_check("the chatter at the largest force", dataset),
        Check.that("falling_friction.constant", damping > 0 and dragged == 0, damping=damping),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the law, the onset over the speed, and both sweeps of motions."""
    figure = style.new_figure(style.DOUBLE, 4.6)
    (law, onset), (force, speed) = figure.subplots(2, 2)
    law.plot(dataset.sliding_speed * 1e3, dataset.coefficient, color=style.BLUE, label="the law")
    constant = float(dataset.friction_coefficient)
    law.axhline(constant, **style.PRINTED, label=f"constant of Table 8.1: {constant:g}")
    coefficient = style.label(dataset.coefficient, "coefficient")
    style.frame(law, "(a) friction", "Sliding speed $v$ [mm s⁻¹]", coefficient, xscale="log")
    law.legend(loc="lower left")
    onset.plot(dataset.input_speed, dataset.onset_force, color=style.BLUE)
    top, shade = 1.2 * float(dataset.onset_force.max()), {"color": style.BLUE, "alpha": 0.15, "linewidth": 0}
    onset.fill_between(dataset.input_speed, dataset.onset_force, top, **shade)
    onset.text(0.32, 0.72, "steady sliding unstable", transform=onset.transAxes, ha="center")
    onset.text(0.75, 0.15, "stable", transform=onset.transAxes, ha="center")
    label = style.label(dataset.onset_force, "axial force")
    style.frame(onset, "(b) onset of vibration", dataset.input_speed, label, xscale="log", ylim=(0, top))
    fixed = f"$\\Omega$ = {float(dataset.drawn_input_speed):g} rad/s", f"$R$ = {float(dataset.drawn_axial_force):g} N"
    _sweep(force, dataset.swept_axial_force, dataset.amplitude, f"(c) over the force, {fixed[0]}")
    _sweep(speed, dataset.swept_input_speed, dataset.speed_amplitude, f"(d) over the speed, {fixed[1]}")
    speed.set_xscale("log")
    for axes, ticks in ((onset, (2, 5, 10, 20, 50)), (speed, (5, 10, 20, 40))):
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.set_xticks([], minor=True)
    here = float(dataset.onset_force.sel(input_speed=dataset.drawn_input_speed))
    force.axvline(here, color=style.GREY, linestyle=":", linewidth=0.8, label=f"onset, {here:.2f} N")
    return style.legend(figure, [force], 3)


def _sweep(axes: style.Axes, swept: xr.DataArray, amplitude: xr.DataArray, title: str) -> None:
    marks = (("o", style.BLUE, 3.2, "white"), ("x", style.VERMILION, 3.0, None))
    words = ("start next to steady sliding", "start far away")
    for row, (mark, colour, size, face), word in zip(amplitude, marks, words, strict=True):
        axes.plot(swept, row, mark, color=colour, markersize=size, mfc=face, mew=0.7, label=word)
    style.frame(axes, title, swept, style.label(amplitude, "amplitude"))
