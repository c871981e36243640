"""Figure 8.7: the four sectors of the phase plane in the Painlevé region, without a solution or with two."""

from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import phase_plane, spans
from lsvib.answers.attributes import flagged, named, variable
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, never, some
from lsvib.chapter.common import about
from lsvib.chapter.contact_force import Existence, existence
from lsvib.chapter.settings import PhasePlane, Span, Values
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.names import RULES, Event, MotionMode
from lsvib.pictures import drawing, style

CAPTION = """\
The four sectors of the phase plane in the region of Painlevé's paradoxes: no solution in the hatched sectors, two
solutions in the others. The lines mark zero contact force and zero speed of the screw; the labels give the signs of
both, first for law −, under which the screw slips. Not in the chapter's figure: the motions, each drawn to the end of
the first seizure that follows slip, from which it continues to the limit cycle. One seizes at its start, so far to the
right that the coupling holds the screw: it rests (green bar) while the input keeps turning and u falls at the rate Ω,
until the screw can slip forwards again.
"""

_SECTORS = {"inconsistent": ("#F7D9C4", "////", "no solution"), "indeterminate": ("#FFFFFF", None, "two solutions")}
_HATCH = "#C9A58C"


class Settings(PhasePlane):
    angle: Span = Field(description="Deviation u [rad].")
    velocity: Span = Field(description="Rate of the deviation w [rad/s].")


def build(settings: Values) -> xr.Dataset:
    """Compute the existence map, motions from each sector and their rests after a seizure; R > 0, Ω > 0, Γ₊ < 0."""
    drive = Drive.of(settings["drive"])
    angle, velocity = spans.even(settings["angle"]), spans.even(settings["velocity"])
    kinds = existence(drive, *np.meshgrid(angle, velocity, indexing="ij"))
    plane, xi = ("grid_u", "grid_w"), coefficients(drive).xi
    equilibrium = drive.pitch_radius * float(xi[1] - xi[-1]) * drive.axial_force / drive.coupling_stiffness
    rests = np.empty((len(settings["starts"]), len(RULES)))
    for k, (start, rule) in enumerate(product(settings["starts"], RULES)):
        motion = phase_plane.followed(drive, start, settings["duration"], rule)
        modes, *_, durations = motion.arcs()
        first = np.flatnonzero(motion.kind == Event.SEIZURE)[:1] + 1  # of a start that does not seize, none
        rests.flat[k] = durations[first][motion.automaton.codes[modes[first]] == MotionMode.REST].sum()
    planes = phase_plane.portraits(settings, [drive], (), ("Sect. 8.6",)).assign_coords(
        {"equilibrium_angle": variable((), equilibrium, "rad", "equilibrium of law -", "$u_0$")}
        | phase_plane.grid_axes(angle, velocity)
    )
    return planes.assign(
        {
            "existence": flagged(plane, kinds, "solutions for the contact force", Existence),
            "rest_after_seizure": variable(("start", "rule"), rests, "s", "time at rest after the first seizure"),
        }
    ).assign_attrs(
        about(__doc__, "existence of the contact force (8.5) and exact event-driven motion", "Sect. 8.6, Fig. 8.7")
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the map by signs alone, the motions of each sector, and what follows a seizure.

    Also the signs of N by (8.3) where there is no solution, and the slip under law − as far as it goes.
    """
    p, stop = dataset.isel(case=0), float(dataset.stop_velocity[0])
    sense = np.sign(p.input_speed + p.grid_w)
    beyond = np.sign(_beyond_line(dataset, dataset.grid_u, dataset.grid_w)).values
    signed = beyond * np.sign(dataset.grid_w - stop).values
    none, two, edge = (named(dataset.existence, word) for word in ("inconsistent", "indeterminate", "boundary"))
    regular = ~edge & (signed != 0)
    u, w = dataset.u.values[0, :, 0], dataset.w.values[0, :, 0]
    signs = np.sign(w - stop)
    inconsistent, first = np.sign(_beyond_line(dataset, u, w)) == signs, p.isel(event=0)
    seized = named(first.event_kind, "seizure") & (first.event_time.values == 0)
    slips = np.where(signs > 0, MotionMode.SLIP_FORWARD_NEGATIVE, MotionMode.SLIP_BACKWARD_POSITIVE)
    follows = dataset["mode"].values[0, :, 0] == slips
    seizes, rest = named(p.event_kind, "seizure"), dataset.rest_after_seizure.values
    released = (np.cumsum(seizes, axis=1) == 1) & seizes & named(p.event_kind.shift(event=-1, fill_value=-1), "release")
    lasts = (p.event_time.shift(event=-1) - p.event_time).where(released, 0).sum("event").values
    virtual = float(_beyond_line(dataset, float(dataset.equilibrium_angle), 0.0))
    lead = p.pitch_radius * np.tan(p.lead_angle) * p.mass
    q = lead * (p.coupling_stiffness * p.grid_u + p.support_damping * p.grid_w)
    q = (q + printed_laws.inertia(p, 1) * p.axial_force) * sense  # c_x = 0, s_0 = +1
    plus, minus = ((np.sign(q / printed_laws.inertia(p, s) / printed_laws.lever(p, s)) * s).values for s in (1, -1))
    law, offset = printed_laws.laws(p), p.u - p.equilibrium_angle
    energy = printed_laws.inertia(p, -1) * p.w**2 + p.coupling_stiffness * offset**2
    within = (law < 0) & (law.shift(sample=1) < 0) & (p.time > p.time.shift(sample=1))
    falls = (energy < energy.shift(sample=1)).values[within.values]
    return [
        *newton.portrait_checks(dataset, "Fig. 8.7"),
        Check.that("fig8_07.existence", states_without_solution=every(none[regular & (signed > 0)]),
                   states_with_two=every(two[regular & (signed < 0)])),
        Check.that("fig8_07.seizes", starts=every(seized[inconsistent]),
                   impulses=every((first.event_sign.values == signs)[inconsistent])),
        Check.that("fig8_07.slips", starts=every(follows[~inconsistent]), seizures=never(seized[~inconsistent])),
        Check.that("fig8_07.may_rest", rests_at_once=some(rest[seized].min(axis=1) > 0),
                   times=every(np.isclose(rest[:, 0], lasts, rtol=1e-9, atol=0)),
                   rests=[f"{1e3 * x:.3g} ms" for x in rest[seized].min(axis=1)]),
        Check.that("fig8_07.opposite", forces_by_law_plus=every(plus[none] < 0),
                   forces_by_law_minus=every(minus[none] < 0), none=none),
        Check.that("fig8_07.falls", steps=every(falls)),
        Check.that("fig8_07.cut_short", virtual=each(virtual, ">", 0)),
    ]  # fmt: skip


def _beyond_line(dataset: xr.Dataset, u: Any, w: Any) -> Any:
    """Distance [rad] of states beyond the line N = 0; it has the sign of Q."""
    return u - (float(dataset.contact_line_angle[0]) + float(dataset.contact_line_slope[0]) * w)


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the map, hatched without solution, the lines, motions up to their first seizure, the cycle.

    At each corner stand the signs of θ′ and of the contact forces that solve in the sector there.
    """
    figure = style.new_figure(style.DOUBLE, 4.6)
    axes = figure.add_subplot()
    case = dataset.isel(case=0)
    # Of each motion what comes before the end of the first seizure into which it slips, and its jump.
    end = case.event_time.where(named(case.event_kind, "seizure") & (case.event_time > 0), np.inf).min("event")
    kept = {name: case[name].where(case.time <= end) for name in ("u", "w")}
    case = case.assign(kept | {"event_kind": case.event_kind.where(case.event_time <= end, -1)})
    u, w = dataset.grid_u, dataset.grid_w
    colour, hatch, _ = _SECTORS["inconsistent"]
    inside = named(dataset.existence, "inconsistent").T.astype(float)
    drawing.hatched(axes, u, w, inside, hatch, _HATCH, [colour], zorder=0)
    drawing.draw_cycle(axes, case, width=1.1)
    drawing.draw_motions(axes, case)
    drawing.mark_origin(axes)
    axes.plot(float(dataset.equilibrium_angle), 0, "*", color=style.BLACK, markersize=8,
              label="$u_0$, equilibrium of law −")  # fmt: skip
    axes.set(xlim=u[[0, -1]], ylim=w[[0, -1]])
    drawing.draw_lines(axes, case)
    drawing.draw_arrows(axes, case)
    two = named(dataset.existence, "indeterminate")
    for i, j in product((0, -1), repeat=2):
        signs = "><" if float(w[j]) > float(dataset.stop_velocity[0]) else "<>"
        words = rf"$\dot\theta {signs[0]} 0$: no $N$"
        if two[i, j]:  # law s holds where N θ′ has the sign s
            words = rf"$\dot\theta {signs[0]} 0$: $N {signs[1]} 0$ by law −" + f"\n($N {signs[0]} 0$ by law +)"
        axes.text(0.015 if i == 0 else 0.985, 0.02 if j == 0 else 0.98, words,
                  transform=axes.transAxes, ha="left" if i == 0 else "right", va="bottom" if j == 0 else "top",
                  bbox={"facecolor": "white", "linewidth": 0, "pad": 1.5}, fontsize=7, zorder=4)  # fmt: skip
    drawing.label_axes(axes, dataset)
    return style.legend(figure, [axes], 4, drawing.patches(_SECTORS.values(), _HATCH))
