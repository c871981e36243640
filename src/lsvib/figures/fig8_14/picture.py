"""Figure 8.14: trajectories under a negative axial force, both readings of the mass; seizures that accumulate."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_RULES = {  # colour, dashes, mark, words
    "contact sign": (style.BLUE, "-", "s", "by the sign of the contact force"),
    "at once": (style.ORANGE, "-", "o", "at once, as in the chapter"),
}
_STARTS = {  # mark and colour of a start of the grid by its attractor
    "steady sliding": (".", style.GREEN, "start that steady sliding attracts"),
    "sprag slip cycle": ("x", style.GREY, "start that the cycle attracts"),
}
_ROOM = 0.06  # beyond the grid of starts, in its width


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw four phase planes, printed mass above, one beyond m_cr below, and seizures at the corner of (c) and (d)."""
    figure = style.new_figure(style.DOUBLE, 8.4)
    above, below = figure.subfigures(2, 1, height_ratios=(2.3, 1))
    panels = above.subplots(2, 2, sharex=True, sharey=True).ravel()
    for index, axes in enumerate(panels):
        case = dataset.isel(case=index)
        _starts(axes, case)
        drawing.draw_motions(axes, case, widths=drawing.OVERLAID)
        drawing.draw_cycle(axes, case)
        drawing.mark_origin(axes)
        note = "as printed" if index < 2 else "$m > m_\\mathrm{cr}$"
        force, mass = drawing.number(case.axial_force), drawing.number(case.mass)
        axes.set_title(f"({'abcd'[index]}) $R$ = {force} N, $m$ = {mass} kg, {note}")
    _widen(panels[0], dataset)
    for index, axes in enumerate(panels):
        drawing.draw_lines(axes, dataset.isel(case=index))
        drawing.guide(axes, dataset.isel(case=index))
        drawing.label_axes(axes, dataset)
        axes.label_outer()
    close, distance = below.subplots(1, 2)
    _close_up(close, dataset.isel(case=2))
    _distances(distance, dataset)
    drawing.legend(above, panels, 4)
    drawing.legend(below, [distance], 3)
    style.state_values(figure, dataset)
    return figure


def _starts(axes: Axes, case: xr.Dataset) -> None:
    """Mark each start of the grid by the attractor of its motion."""
    w, u = np.meshgrid(case.grid_velocity_deviation, case.grid_angle_deviation)
    for value, name in style.flag_names(case.grid_attractor).items():
        here = case.grid_attractor.values == value
        if here.any():
            mark, colour, words = _STARTS.get(name, ("+", style.PURPLE, f"start that leads to {name}"))
            axes.plot(u[here], w[here], mark, color=colour, markersize=3, markeredgewidth=0.7, label=words, zorder=1)


def _widen(axes: Axes, dataset: xr.Dataset) -> None:
    """Set limits around the grid of starts, in which all motions begin."""
    for limits, name in ((axes.set_xlim, "grid_angle_deviation"), (axes.set_ylim, "grid_velocity_deviation")):
        low, high = float(dataset[name].min()), float(dataset[name].max())
        limits(low - _ROOM * (high - low), high + _ROOM * (high - low))


def _close_up(axes: Axes, case: xr.Dataset) -> None:
    """The motion close to the corner of N = 0 and θ′ = 0 under both rules, up to where the screw leaves rest."""
    corner, stop = float(case.corner_angle), float(case.stop_velocity)
    paths: list[drawing.DrawnLine] = []
    for index, rule in style.flag_names(case.rule).items():
        colour, dashes, mark, _ = _RULES[rule]
        part = case.sel(rule=index)
        u, w = part.slip_angle.values, part.slip_velocity.values
        width = 2.6 if rule == "contact sign" else 1.0
        axes.plot(u, w, color=colour, linestyle=dashes, linewidth=width)
        ends = corner + part.seizure_distance.values
        axes.plot(ends, np.full(ends.shape, stop), mark, color=colour, markersize=4, markerfacecolor="white", zorder=3)
        paths.append((u, w, None))
    reach = 1.15 * float(case.seizure_distance[0, 1])  # from the second seizure on
    depth = reach / -float(case.contact_line_slope)
    axes.set(xlim=(corner - 0.35 * reach, corner + reach), ylim=(stop - 1.05 * depth, stop + 0.12 * depth))
    drawing.draw_lines(axes, case)
    axes.annotate("corner", (corner, stop), (-10, -30), textcoords="offset points", ha="right",
                  arrowprops={"arrowstyle": "-", "linewidth": 0.6})  # fmt: skip
    axes.locator_params(nbins=5)
    axes.set_title("(e) corner of (c): reverse slips, seizures")
    drawing.label_axes(axes, case)


def _distances(axes: Axes, dataset: xr.Dataset) -> None:
    """Distance of each seizure from the corner, for the motions of (c) and (d), with the ratio in the limit."""
    for case, letter in ((2, "c"), (3, "d")):
        part = dataset.isel(case=case)
        for index, rule in style.flag_names(dataset.rule).items():
            colour, _, mark, words = _RULES[rule]
            found = part.sel(rule=index).seizure_distance.values
            found = found[np.isfinite(found)]
            size = 7 if rule == "contact sign" else 3.5
            axes.plot(np.arange(found.size) + 1, found, mark, color=colour, markersize=size, markerfacecolor="white",
                      label=f"motion resumes {words}")  # fmt: skip
        number, ratio = np.arange(1, found.size + 1), float(part.seizure_ratio)
        middle = found.size // 2
        axes.plot(number, found[middle] * ratio ** (number - 1 - middle), color=style.BLACK, linewidth=0.7,
                  label=r"falls with $c a / (k \Omega + c a)$")  # fmt: skip
        place, side = ((6, 0), "left") if letter == "c" else ((-6, -4), "right")
        axes.annotate(f"({letter}) ratio {ratio:.4f}", (number[middle], found[middle]), place, ha=side,
                      textcoords="offset points")  # fmt: skip
    axes.set(yscale="log", title="(f) distance of the seizures from the corner", xlabel="Number of the seizure")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_ylabel(style.label(dataset.seizure_distance, "distance"))
