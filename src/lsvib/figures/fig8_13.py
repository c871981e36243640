"""Figure 8.13: with softer contacts the motion is smoother, and the coupling deflection turns positive in sprag."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import newton, phase_plane, spans
from lsvib.datasets.attributes import Variables, drive_parameters, start_state, variable, varied
from lsvib.datasets.checks import Check
from lsvib.errors import InputError
from lsvib.figures import drawing, style
from lsvib.figures.common import CRITICAL_MASS_WITH_CONTACT, SteadyState, about, critical_mass_with_contact, named
from lsvib.figures.fig8_10 import compliant_cycle, cycle_curves, cycle_motion
from lsvib.figures.settings import Contact, DriveFigure, PositiveSpan, Samples, State, Values, several
from lsvib.models import chapter
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.numbers import bisected

CAPTION = """\
Softer contacts (assumed values): (a) cycles, (b) coupling deflection; not in the chapter, (c) its largest value over
stiffness and damping of the contact, a cell for each contact computed, zero on the black line, and (d) the shortest
time of the trajectory, Ω over the largest acceleration, each contact of (a) on the line of its own stiffness. The
drives have the same mass, 11 kg, but stand at different distances beyond their thresholds: steady sliding is lost at
9.65, 7.44 and 3.77 kg with these contacts, at 10.11 kg with a rigid one (see contact_stability). In (c) and (d) it is
the contact damping c_c that decides; the stiffness matters where it is large.
"""

_CONTACT = ("contact_stiffness", "contact_damping")
_NUMBERS = {
    "attractor": ("1", "attractor that the motion reaches"),
    "largest_deflection": ("rad", "largest coupling deflection on the cycle", "$z$"),
    "sprag_deflection": ("rad", "largest coupling deflection during sprag", "$z$"),
    "largest_acceleration": ("rad s-2", "largest angular acceleration on the cycle", r"$|\ddot\theta|$"),
    "period": ("s", "period of the steady vibration", "$T$"),
    "period_residual": ("1", "relative change of the section state over a period"),
}
_COLOURS = (style.BLUE, style.ORANGE, style.VERMILION, style.GREEN)


class Settings(DriveFigure):
    engine = ("planar", "modal")
    contacts: several(Contact, 2, 4, "Contacts whose cycles are drawn, the stiffest first.")
    start: State
    samples: Samples
    contact_stiffness: PositiveSpan = Field(description="k_c [N/m] of the grid, spaced logarithmically.")
    contact_damping: PositiveSpan = Field(description="c_c [N s/m] of the grid, spaced logarithmically.")


def build(settings: Values) -> xr.Dataset:
    """Compute the cycles of a few contacts, and over a grid of contacts where the deflection turns positive."""
    drive, start = Drive.of(chapter.PARTS["threads"] | settings["drive"]), settings["start"]
    stiffness, damping = (spans.logarithmic(settings[key]) for key in _CONTACT)
    contacts = [drive.replace(**contact) for contact in settings["contacts"]]
    cycles = [compliant_cycle(contact, start) for contact in contacts]
    steady, critical = float(coefficients(drive).deflection), [critical_mass_with_contact(c) for c in contacts]
    return xr.Dataset(
        cycle_curves(("contact",), cycles, settings["samples"])
        | cycle_curves((), [phase_plane.reached(drive, start)], settings["samples"], "rigid_cycle")
        | _table("", ("contact",), _NUMBERS, [_numbers(steady) for steady in cycles])
        | _grid(drive, start, stiffness, damping),
        coords={
            **drive_parameters(contacts, "contact", along=_CONTACT, printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(start, "with a seated contact: of the motions whose cycles are found"),
            "critical_mass_with_contact": variable("contact", critical, *CRITICAL_MASS_WITH_CONTACT),
            **varied(grid_contact_stiffness=stiffness, grid_contact_damping=damping),
            "steady_deflection": variable((), steady, "rad", "coupling deflection in steady sliding", "$z_0$"),
        },
        attrs=about(__doc__, "exact event-driven motion with four states", "Sect. 8.6.1, Fig. 8.13"),
    )


def _grid(drive: Drive, start: Values, stiffness: np.ndarray, damping: np.ndarray) -> Variables:
    """Numbers of the cycles over a grid of contacts, and the largest damping at which the deflection turns positive."""

    def numbers(k: float, c: float) -> list[float]:
        return _numbers(compliant_cycle(drive.replace(contact_stiffness=k, contact_damping=c), start))

    largest, same = list(_NUMBERS).index("largest_deflection"), "the largest deflection does not change its sign"
    grid = np.array([[numbers(k, c) for c in damping] for k in stiffness])
    limits, ends = [], []
    for k, row in zip(stiffness, grid[..., largest], strict=True):
        turns = np.flatnonzero((row[:-1] > 0) & (row[1:] <= 0))
        if turns.size == 0:
            raise InputError(f"contact_damping: {same} over the grid; widen it.")
        between = damping[turns[-1] : turns[-1] + 2].tolist()
        limits.append(bisected(lambda c, k=k: numbers(k, c)[largest] <= 0, *between, 1e-9))
        ends.append(numbers(k, limits[-1])[largest])
    dims, below = ("grid_contact_stiffness", "grid_contact_damping"), "below which the deflection turns positive"
    return {
        **_table("grid_", dims, ("attractor", "largest_deflection", "largest_acceleration"), grid),
        "boundary_contact_damping": variable(dims[0], limits, "N s m-1", f"contact damping {below}", "$c_c$"),
        "boundary_deflection": variable(dims[0], ends, "rad", "largest coupling deflection at that damping", "$z$"),
    }


def _numbers(steady: SteadyState) -> list[float]:
    """The values of ``_NUMBERS`` of one attractor; without a cycle all but the first are nan."""
    from lsvib.dynamics.attractor import orbit_extremes

    if steady.orbit is None:
        return [steady.label] + [np.nan] * (len(_NUMBERS) - 1)
    automaton = steady.orbit.automaton
    deflection = automaton.observables["coupling_deflection"]
    sprags = np.isin(automaton.codes, automaton.sprag_codes)
    return [
        steady.label,
        steady.extremes(deflection)[1],
        orbit_extremes(steady.orbit, deflection, sprags)[1],
        max(map(abs, steady.extremes(automaton.tables.flow.field[:, 1]))),
        steady.period,
        steady.residual,
    ]


def _table(prefix: str, dims: tuple[str, ...], names: Iterable[str], rows: Any) -> Variables:
    """Some of the numbers of ``_numbers``, from rows of any depth, as variables."""
    found = dict(zip(_NUMBERS, np.moveaxis(np.array(rows, dtype=float), -1, 0), strict=True))
    table = {f"{prefix}{name}": variable(dims, found[name], *_NUMBERS[name]) for name in names}
    return table | {f"{prefix}attractor": phase_plane.attractors(dims, found["attractor"])}


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that softer contacts give smoother cycles, and where the deflection turns positive."""
    deflection, sprag = dataset.largest_deflection.values, dataset.sprag_deflection.values
    fastest, critical = dataset.largest_acceleration.values, dataset.critical_mass_with_contact.values
    sprags, residual = named(dataset.attractor, "sprag slip cycle"), float(dataset.period_residual.max())
    limit, edge = dataset.boundary_contact_damping.values, float(np.abs(dataset.boundary_deflection).max())
    grid, above = dataset.grid_largest_deflection.values, dataset.grid_contact_damping.values > limit[:, None]
    negative, positive = grid[above] < 0, grid[np.arange(len(limit)), above.argmax(axis=1) - 1] > 0  # next below
    stiffness, mass = dataset.grid_contact_stiffness.values, float(dataset.mass)
    bounded = edge <= 1e-10 and negative.all() and positive.all()
    sides = {"limit": limit, "stiffness": stiffness, "edge": edge, "negative": negative, "positive": positive}
    lasts = {"sprag": sprag[-1], "whole": deflection[-1]}
    during = sprag[-1] > 0 and abs(sprag[-1] - deflection[-1]) <= 1e-12
    below = (critical < mass).all() and (np.diff(critical) < 0).all()
    return [
        newton.laws_check(cycle_motion(dataset), "Sect. 8.6.1, Fig. 8.13", "cycle"),
        newton.laws_check(cycle_motion(dataset, "rigid_cycle"), "Sect. 8.6.1, Fig. 8.13", "cycle of the rigid drive"),
        Check.that("fig8_13.repeats", sprags.all() and residual <= 1e-9, sprags=sprags, residual=residual),
        Check.that("fig8_13.critical_mass", below, mass=mass, critical=critical),
        Check.that("fig8_13.smoother", (np.diff(fastest) < 0).all(), times=1e6 * float(dataset.input_speed) / fastest),
        Check.that("fig8_13.positive", deflection[-1] > 0 > deflection[:-1].max(), largest=deflection),
        Check.that("fig8_13.during_sprag", during, **lasts),
        Check.that("fig8_13.boundary", bounded, **sides),
        Check.everywhere("fig8_13.sweep", named(dataset.grid_attractor, "sprag slip cycle")),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the cycles, (b) z over a period, (c) the largest z and (d) the shortest time against the contact.

    A period in (b) lasts from one standstill of the screw to the next.
    """
    figure = style.new_figure(style.DOUBLE, 6.0)
    plane, deflection, grid, shortest = figure.subplots(2, 2).ravel()
    cycles: list[drawing.DrawnLine] = []
    steady = float(dataset.steady_deflection)
    for one, colour, dashes in _contacts(dataset):
        stiffness, damping = (style.number(one[name]) for name in _CONTACT)
        critical = f"$m_\\mathrm{{cr}}$ = {float(one.critical_mass_with_contact):.2f} kg"
        time, angle = one.cycle_time.values, one.cycle_angle.values
        cycles.append((angle, one.cycle_velocity.values, colour))
        plane.plot(*cycles[-1][:2], color=colour, linestyle=dashes,
                   label=f"$k_c$ = {stiffness} N m⁻¹, $c_c$ = {damping} N s m⁻¹, {critical}")  # fmt: skip
        lowest = np.argmin(angle)
        turned = np.concatenate([time[lowest:] - time[lowest], time[:lowest] + time[-1] - time[lowest]])
        deflection.plot(turned / float(one.period), np.roll(angle, -lowest) + steady, color=colour, linestyle=dashes)
    plane.plot(dataset.rigid_cycle_angle, dataset.rigid_cycle_velocity, color=style.BLACK, linewidth=0.9,
               linestyle=(0, (4, 2)), label="rigid drive")  # fmt: skip
    plane.axvline(-steady, color=style.GREEN, linewidth=0.9, linestyle=":")
    plane.text(-steady, 0.45, " $z = 0$", color=style.GREEN, fontsize=7, transform=plane.get_xaxis_transform())
    plane.locator_params(axis="x", nbins=5)
    drawing.mark_origin(plane)
    plane.margins(0.06)
    drawing.arrows(plane, cycles)
    labels = style.label(dataset.cycle_angle, "deviation"), style.label(dataset.cycle_velocity, "rate")
    style.frame(plane, "(a) phase plane", *labels)
    deflection.axhline(0, color=style.GREEN, linewidth=0.9, linestyle=":")
    words = "Time after the smallest $z$ / period", "Coupling deflection $z$ [rad]"
    style.frame(deflection, "(b) coupling deflection over a period", *words, xlim=(0, 1))
    _map(figure, grid, dataset)
    _shortest(shortest, dataset)
    return style.legend(figure, [plane, deflection], 2)


def _contacts(dataset: xr.Dataset) -> list[tuple[xr.Dataset, str, Any]]:
    """The contacts that are drawn, each with its colour and dashes."""
    contacts = (dataset.isel(contact=k) for k in dataset.contact.values)
    return list(zip(contacts, _COLOURS, ("-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), (0, (1, 1))), strict=False))


def _map(figure: style.Figure, axes: style.Axes, dataset: xr.Dataset) -> None:
    """Largest deflection of each contact of the grid, a cell around it, with the line on which it vanishes."""
    damping, stiffness = dataset.grid_contact_damping.values, dataset.grid_contact_stiffness.values
    largest = np.nanmax(np.abs(dataset.grid_largest_deflection.values))
    mesh = axes.pcolormesh(damping, stiffness, dataset.grid_largest_deflection, cmap="RdBu_r", vmin=-largest,
                           vmax=largest, edgecolors="white", linewidth=0.3, shading="nearest")  # fmt: skip
    axes.plot(dataset.boundary_contact_damping, stiffness, "-|", color=style.BLACK, markersize=5)
    axes.annotate("$z = 0$", (float(dataset.boundary_contact_damping[0]), stiffness[0]), (5, 2), fontsize=7,
                  textcoords="offset points")  # fmt: skip
    style.frame(axes, "(c) ours: largest deflection", dataset.grid_contact_damping, dataset.grid_contact_stiffness,
                xscale="log", yscale="log")  # fmt: skip
    for one, colour, _ in _contacts(dataset):
        if float(one.contact_damping) >= damping[0] and float(one.contact_stiffness) >= stiffness[0]:
            axes.plot(one.contact_damping, one.contact_stiffness, "o", color=colour, mec=style.BLACK, clip_on=False,
                      zorder=4)  # fmt: skip
    figure.colorbar(mesh, ax=axes, pad=0.02).set_label("Largest $z$ [rad]")


def _shortest(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Shortest time over the contact damping, with lines for the stiffnesses of the contacts drawn and the stiffest."""
    speed, stiffness = abs(float(dataset.input_speed)), dataset.grid_contact_stiffness.values
    rows: dict[int, tuple[str, Any]] = {len(stiffness) - 1: (style.PURPLE, (0, (1, 1)))}
    for one, colour, dashes in _contacts(dataset):
        rows |= {
            int(row): (colour, dashes) for row in np.flatnonzero(np.isclose(stiffness, float(one.contact_stiffness)))
        }
        axes.plot(one.contact_damping, 1e6 * speed / one.largest_acceleration, "o", color=colour, mec=style.BLACK,
                  zorder=3)  # fmt: skip
    # The solid line lies below those that nearly coincide with it.
    for row, (colour, dashes) in sorted(rows.items(), reverse=True):
        curve = dataset.isel(grid_contact_stiffness=row)
        name = f"$k_c$ = {style.number(curve.grid_contact_stiffness)} N m⁻¹"
        shortest = 1e6 * speed / curve.grid_largest_acceleration
        axes.plot(curve.grid_contact_damping, shortest, color=colour, linestyle=dashes, label=name)
    style.frame(axes, "(d) ours: shortest time", dataset.grid_contact_damping, r"$\Omega\, /\, \max|\ddot\theta|$ [µs]",
                xscale="log", yscale="log")  # fmt: skip
    axes.legend(loc="lower left")
