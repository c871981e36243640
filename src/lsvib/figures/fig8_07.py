"""Figure 8.7: the four sectors of the phase plane in the Painlevé region, without a solution or with two."""

import math
from itertools import product

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.contact.contact_force import Existence, existence
from lsvib.datasets import newton, phase_plane, spans
from lsvib.datasets.attributes import flagged, variable
from lsvib.datasets.checks import Check
from lsvib.figures import drawing, style
from lsvib.figures.common import about, named
from lsvib.figures.settings import PhasePlane, Span, Values
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.models.rigid import MotionMode, rigid_automaton

CAPTION = """\
The four sectors of the phase plane in the region of Painlevé's paradoxes: no solution in the hatched sectors, two
solutions in the others. The lines are zero contact force and zero velocity of the screw; the words give the signs of
both, those of law − first, under which motions slip. Not in the chapter's figure: the motions, each drawn up to the end
of the first seizure into which it slips, whence it goes on to the limit cycle. One seizes at its start so far to the
right that the coupling holds the screw: it rests, the green bar, while the input turns on, u falling at the rate Ω,
until the screw can slip forwards again.
"""

_SECTORS = {"inconsistent": ("#F7D9C4", "no solution", "////"), "indeterminate": ("#FFFFFF", "two solutions", None)}
_HATCH = "#C9A58C"


class Settings(PhasePlane):
    angle: Span = Field(description="Deviation u [rad].")
    velocity: Span = Field(description="Rate of the deviation w [rad/s].")


def build(settings: Values) -> xr.Dataset:
    """Compute the existence map, motions from each sector, and where the flow of law −1 leads; R > 0, Ω > 0, Γ₊ < 0."""
    drive = RigidDrive.of(settings["drive"])
    angle, velocity = spans.even(settings["angle"]), spans.even(settings["velocity"])
    kinds = existence(drive, *np.meshgrid(angle, velocity, indexing="ij"))
    plane, xi = ("grid_angle_deviation", "grid_velocity_deviation"), coefficients(drive).xi
    equilibrium = drive.pitch_radius * float(xi[1] - xi[-1]) * drive.axial_force / drive.coupling_stiffness
    u, w = np.array([_end_of_flow(drive, start) for start in settings["starts"]]).T
    ended = "at which the flow of law - ends, if nothing stops it"
    planes = phase_plane.portraits(settings, [drive], (), ("Sect. 8.6",)).assign_coords(
        equilibrium_angle=variable((), equilibrium, "rad", "equilibrium of the equation of law -", "$u_0$"),
        **phase_plane.grid_axes(angle, velocity),
    )
    return planes.assign(
        {
            "existence": flagged(plane, kinds, "solutions for the contact force", Existence),
            "law_minus_angle": variable("start", u, "rad", f"deviation {ended}", "$u$"),
            "law_minus_velocity": variable("start", w, "rad s-1", f"rate {ended}", r"$\dot u$"),
        }
    ).assign_attrs(
        about(__doc__, "existence of the contact force (8.5) and exact event-driven motion", "Sect. 8.6, Fig. 8.7")
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the map by signs alone, the motions of each sector, and where the flow of law −1 leads."""
    stop, place = float(dataset.stop_velocity[0]), "Sect. 8.6, Fig. 8.7"
    q = np.sign(_beyond_line(dataset, dataset.grid_angle_deviation, dataset.grid_velocity_deviation)).values
    signed = q * np.sign(dataset.grid_velocity_deviation - stop).values
    none, two, edge = (named(dataset.existence, word) for word in ("inconsistent", "indeterminate", "boundary"))
    regular = ~edge & (signed != 0)
    wrong = int(np.sum(~np.where(signed > 0, none, two) & regular))
    u, w = dataset.angle_deviation.values[0, :, 0], dataset.velocity_deviation.values[0, :, 0]
    signs = np.sign(w - stop)
    inconsistent = np.sign(_beyond_line(dataset, u, w)) == signs
    first = dataset.isel(case=0, event=0)
    seized = named(first.event_kind, "seizure") & (first.event_time.values == 0)
    impulse = seized & (first.event_sign.values == signs)
    slips = np.where(signs > 0, MotionMode.SLIP_FORWARD_NEGATIVE, MotionMode.SLIP_BACKWARD_POSITIVE)
    follows = (dataset["mode"].values[0, :, 0] == slips) & ~seized
    gap = np.abs(dataset.law_minus_angle.values / float(dataset.equilibrium_angle) - 1).max()
    leftover = np.abs(dataset.law_minus_velocity.values).max()
    virtual = float(_beyond_line(dataset, float(dataset.equilibrium_angle), 0.0))
    return [
        newton.laws_check(dataset, "Fig. 8.7"),
        Check.holds(
            "The existence analysis finds no solution where sgn Q = sgn θ' and two where they differ, nowhere else",
            f"{place}, eq. 8.5",
            f"{wrong} exceptions among {regular.sum()} states; {none.sum()} without a solution, {two.sum()} with two",
            wrong == 0 and none.any() and two.any() and regular.mean() > 0.9,
        ),
        Check.holds(
            "A motion that starts in a sector without a solution seizes at once, with an impulse of the sign of θ'",
            place,
            f"{(impulse & inconsistent).sum()} of {inconsistent.sum()} starts",
            impulse[inconsistent].all() and inconsistent.any(),
        ),
        Check.holds(
            "A motion that starts in a sector with two solutions slips under law -1",
            place,
            f"{(follows & ~inconsistent).sum()} of {(~inconsistent).sum()} starts",
            follows[~inconsistent].all() and not inconsistent.all(),
        ),
        Check.holds(
            "The flow of law -1 converges to u_0 = r_m (xi_+ - xi_-) R / k, to 1e-12",
            "Sect. 8.6",
            f"u_0 = {float(dataset.equilibrium_angle):.9g} rad, relative distance {gap:.1e}, rate {leftover:.1e} rad/s",
            gap < 1e-12 and leftover < 1e-9,
        ),
        Check.holds(
            "u_0 lies beyond the line N = 0, in a sector without a solution: every motion towards it is cut short",
            place,
            f"{virtual:.4g} rad beyond the line",
            virtual > 0,
        ),
    ]


def _beyond_line(dataset: xr.Dataset, u, w):
    """Distance [rad] of states beyond the line N = 0; it has the sign of Q."""
    return u - (float(dataset.contact_line_angle[0]) + float(dataset.contact_line_slope[0]) * w)


def _end_of_flow(drive: RigidDrive, start: Values) -> np.ndarray:
    """State in which the closed-form flow of law −1 ends, guards left out."""
    from lsvib.engine.kernels import flow_planar, layout

    automaton = rigid_automaton(drive)
    mode = int(np.flatnonzero(automaton.codes == MotionMode.SLIP_FORWARD_NEGATIVE)[0])
    row = automaton.tables.flow[mode]
    slowest = row[layout.ALPHA] if row[layout.BETA] > 0 else -row[layout.R1]
    state = np.array([start["u"], start["w"]])
    end = 60.0 / slowest if slowest > 0 else math.inf  # e⁻⁶⁰ of the start is left
    flow_planar.advance(automaton.tables.flow, mode, state, end, state)
    return state


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the map, hatched without solution, the lines, motions up to their first seizure, the cycle."""
    from matplotlib.patches import Patch

    figure = style.new_figure(style.DOUBLE, 4.2)
    axes = figure.add_subplot()
    case, patches = _until_seizure(dataset.isel(case=0)), []
    u, w = dataset.grid_angle_deviation, dataset.grid_velocity_deviation
    for name, (colour, words, hatch) in _SECTORS.items():
        if hatch:
            inside = named(dataset.existence, name).T.astype(float)
            drawing.hatched(axes, u, w, inside, hatch, _HATCH, [colour], zorder=0)
        patches.append(Patch(facecolor=colour, hatch=hatch, edgecolor=_HATCH, linewidth=0.5, label=words))
    drawing.draw_cycle(axes, case, width=1.1)
    drawing.draw_motions(axes, case)
    drawing.mark_origin(axes)
    axes.plot(float(dataset.equilibrium_angle), 0, "*", color=style.BLACK, markersize=8,
              label="$u_0$, equilibrium of law −")  # fmt: skip
    axes.set(xlim=u[[0, -1]], ylim=w[[0, -1]])
    drawing.draw_lines(axes, case)
    drawing.draw_arrows(axes, case)
    _name_sectors(axes, dataset)
    drawing.label_axes(axes, dataset)
    return style.legend(figure, [axes], 1, patches, "outside right upper")


def _until_seizure(case: xr.Dataset) -> xr.Dataset:
    """Leave of each motion what comes before the end of the first seizure into which it slips, and its jump."""
    seizures = named(case.event_kind, "seizure") & (case.event_time > 0)
    end = case.event_time.where(seizures, np.inf).min("event")
    kept = {name: case[name].where(case.time <= end) for name in ("angle_deviation", "velocity_deviation")}
    return case.assign(kept | {"event_kind": case.event_kind.where(case.event_time <= end, -1)})


def _name_sectors(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Write into each sector, at its corner of the picture, the signs of θ′ and of the contact forces that solve."""
    two = named(dataset.existence, "indeterminate")
    for i, j in product((0, -1), repeat=2):
        signs = "><" if float(dataset.grid_velocity_deviation[j]) > float(dataset.stop_velocity[0]) else "<>"
        words = rf"$\dot\theta {signs[0]} 0$: no $N$"
        if two[i, j]:  # law s holds where N θ′ has the sign s
            words = rf"$\dot\theta {signs[0]} 0$: $N {signs[1]} 0$ by law −" + f"\n($N {signs[0]} 0$ by law +)"
        axes.text(0.015 if i == 0 else 0.985, 0.02 if j == 0 else 0.98, words,
                  transform=axes.transAxes, ha="left" if i == 0 else "right", va="bottom" if j == 0 else "top",
                  bbox={"facecolor": "white", "linewidth": 0, "pad": 1.5}, fontsize=7, zorder=4)  # fmt: skip
