"""Figure 8.13: cycles with softer contacts, the coupling deflection along them, and where it turns positive."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from lsvib.figures import drawing, style

_COLOURS = (style.BLUE, style.ORANGE, style.VERMILION, style.GREEN)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the cycles, (b) z over a period, (c) the largest z and (d) the shortest time against the contact."""
    figure = style.new_figure(style.DOUBLE, 6.0)
    panels = figure.subplots(2, 2)
    plane, deflection, grid, shortest = panels.ravel()
    _plane(plane, dataset)
    _deflection(deflection, dataset)
    _map(figure, grid, dataset)
    _shortest(shortest, dataset)
    style.state_values(figure, dataset)
    drawing.legend(figure, [plane, deflection], 2)
    return figure


def _name(dataset: xr.Dataset, index: int) -> str:
    stiffness, damping = (dataset[f"contact_{word}"].values[index] for word in ("stiffness", "damping"))
    critical = float(dataset.critical_mass_with_contact[index])
    words = f", $m_\\mathrm{{cr}}$ = {critical:.2f} kg"
    return f"$k_c$ = {drawing.power(stiffness)} N m⁻¹, $c_c$ = {drawing.power(damping)} N s m⁻¹{words}"


def _plane(axes: Axes, dataset: xr.Dataset) -> None:
    axes.plot(dataset.rigid_cycle_angle, dataset.rigid_cycle_velocity, color=style.BLACK, linewidth=0.9,
              linestyle=(0, (4, 2)), label="rigid drive")  # fmt: skip
    cycles: list[drawing.DrawnLine] = []
    for k, colour in zip(range(dataset.sizes["contact"]), _COLOURS, strict=False):
        cycles.append((dataset.cycle_angle.values[k], dataset.cycle_velocity.values[k], colour))
        axes.plot(*cycles[-1][:2], color=colour, label=_name(dataset, k))
    axes.axvline(-float(dataset.steady_deflection), color=style.GREEN, linewidth=0.9, linestyle=":")
    axes.text(-float(dataset.steady_deflection), 0.45, " $z = 0$", color=style.GREEN, fontsize=7,
              transform=axes.get_xaxis_transform())  # fmt: skip
    axes.locator_params(axis="x", nbins=5)
    drawing.mark_origin(axes)
    axes.margins(0.06)
    drawing.draw_arrows(axes, cycles)
    axes.set(
        title="(a) phase plane",
        xlabel=style.label(dataset.cycle_angle, "deviation"),
        ylabel=style.label(dataset.cycle_velocity, "rate"),
    )


def _deflection(axes: Axes, dataset: xr.Dataset) -> None:
    """The coupling deflection from one standstill of the screw to the next."""
    steady = float(dataset.steady_deflection)
    for k, colour in zip(range(dataset.sizes["contact"]), _COLOURS, strict=False):
        time, angle = dataset.cycle_time.values[k], dataset.cycle_angle.values[k]
        lowest = np.argmin(angle)
        period = float(dataset.period[k])
        turned = np.concatenate([time[lowest:] - time[lowest], time[:lowest] + time[-1] - time[lowest]])
        axes.plot(turned / period, np.concatenate([angle[lowest:], angle[:lowest]]) + steady, color=colour)
    axes.axhline(0, color=style.GREEN, linewidth=0.9, linestyle=":")
    axes.set(
        title="(b) coupling deflection over a period",
        xlabel="Time after the smallest $z$ / period",
        ylabel="Coupling deflection $z$ [rad]",
        xlim=(0, 1),
    )


def _map(figure: Figure, axes: Axes, dataset: xr.Dataset) -> None:
    """Largest deflection of each contact of the grid, a cell around it, with the line on which it vanishes."""
    damping, stiffness = dataset.grid_contact_damping.values, dataset.grid_contact_stiffness.values
    largest = np.nanmax(np.abs(dataset.grid_largest_deflection.values))
    mesh = axes.pcolormesh(
        _edges(damping), _edges(stiffness), dataset.grid_largest_deflection, cmap="RdBu_r", vmin=-largest,
        vmax=largest, edgecolors="white", linewidth=0.3,
    )  # fmt: skip
    axes.plot(dataset.boundary_contact_damping, stiffness, "-|", color=style.BLACK, markersize=5)
    axes.annotate("$z = 0$", (float(dataset.boundary_contact_damping[0]), stiffness[0]), (5, 2), fontsize=7,
                  textcoords="offset points")  # fmt: skip
    axes.set(xscale="log", yscale="log", title="(c) largest deflection: $c_c$ decides its sign")
    axes.set(xlabel=style.label(dataset.grid_contact_damping), ylabel=style.label(dataset.grid_contact_stiffness))
    inside = (dataset.contact_damping >= damping[0]) & (dataset.contact_stiffness >= stiffness[0])
    for k in np.flatnonzero(inside.values)[: len(_COLOURS)]:
        axes.plot(dataset.contact_damping[k], dataset.contact_stiffness[k], "o", color=_COLOURS[k],
                  markeredgecolor=style.BLACK, clip_on=False, zorder=4)  # fmt: skip
    bar = figure.colorbar(mesh, ax=axes, pad=0.02)
    bar.set_label("Largest $z$ [rad]")


def _edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells around values that are spaced logarithmically."""
    middle = np.sqrt(values[1:] * values[:-1])
    return np.concatenate([[values[0] ** 2 / middle[0]], middle, [values[-1] ** 2 / middle[-1]]])


def _shortest(axes: Axes, dataset: xr.Dataset) -> None:
    """Shortest time of the trajectory against the contact damping: each contact drawn lies on the line of its own k_c.

    A contact whose stiffness is not one of the grid has no line; the stiffest contact of the grid is drawn beside.
    """
    speed, stiffness = abs(float(dataset.input_speed)), dataset.grid_contact_stiffness.values
    rows = {len(stiffness) - 1: style.PURPLE}
    for k, colour in zip(range(dataset.sizes["contact"]), _COLOURS, strict=False):
        own = float(dataset.contact_stiffness[k])
        rows |= {int(row): colour for row in np.flatnonzero(np.isclose(stiffness, own))}
        axes.plot(dataset.contact_damping[k], 1e6 * speed / dataset.largest_acceleration[k], "o", color=colour,
                  markeredgecolor=style.BLACK, zorder=3)  # fmt: skip
    dashes = ("-", (0, (5, 1.5)), (0, (2, 1)), (0, (5, 1.5, 1, 1.5)))  # lines that nearly coincide are all seen
    for (row, colour), dash in zip(sorted(rows.items()), dashes, strict=False):
        curve = dataset.isel(grid_contact_stiffness=row)
        name = f"$k_c$ = {drawing.power(float(curve.grid_contact_stiffness))} N m⁻¹"
        shortest = 1e6 * speed / curve.grid_largest_acceleration
        axes.plot(curve.grid_contact_damping, shortest, color=colour, linestyle=dash, label=name)
    axes.set(
        xscale="log",
        yscale="log",
        title="(d) shortest time: $c_c$ decides it, too",
        xlabel=style.label(dataset.grid_contact_damping),
        ylabel=r"$\Omega\, /\, \max|\ddot\theta|$ [µs]",
    )
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_yticks([50, 100, 200, 500, 1000], ["50", "100", "200", "500", "1000"])
    axes.legend(loc="lower left", fontsize=6.5)
