"""Figure 8.9: trajectories below and above the critical mass, and how the cycle depends on the axial force."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) and (b) as phase planes, and (c) amplitude and impact speed of (b) against the axial force."""
    figure = style.new_figure(style.DOUBLE, 3.7)
    *planes, last = figure.subplots(1, 3)
    for index, axes in enumerate(planes):
        case = dataset.isel(case=index)
        relation = "<" if float(case.mass) < float(dataset.critical_mass) else ">"
        drawing.draw_motions(axes, case)
        drawing.draw_cycle(axes, case)
        drawing.mark_origin(axes)
        drawing.widen(axes, case)
        left, right = axes.get_xlim()
        axes.set_xlim(left, right + 0.35 * (right - left))  # room for words beyond the line
        drawing.draw_lines(axes, case)
        drawing.draw_arrows(axes, case)
        _name_sides(axes, index == 0)
        drawing.label_axes(axes, dataset)
        axes.locator_params(axis="x", nbins=3)
        axes.set_title(f"({'ab'[index]}) $m$ = {drawing.number(case.mass)} kg ${relation} m_\\mathrm{{cr}}$")
    _over_force(last, dataset)
    style.state_values(figure, dataset)
    drawing.legend(figure, planes, 4)
    return figure


def _name_sides(axes: Axes, both: bool) -> None:
    """Name the sides of the line N = 0, which is steep: beyond m_cr forward slip has N < 0 only."""
    axes.text(0.4, 0.35, "$N < 0$", transform=axes.transAxes, ha="center")
    axes.text(0.98, 0.75, "$N > 0$" if both else "no\nsolution", transform=axes.transAxes, ha="right", va="center")


def _over_force(axes: Axes, dataset: xr.Dataset) -> None:
    """Amplitude (left) and impact speed (right) of the cycle in (b); the dot is the force of (b)."""
    force = dataset.swept_axial_force
    (amplitude,) = axes.plot(force, dataset.swept_amplitude, color=style.BLUE)
    axes.set(
        title="(c) cycle of (b) against $R$",
        xlabel="Axial force " + style.label(force, " ").strip(),
        ylabel=style.label(dataset.swept_amplitude, "amplitude of $u$"),
        ylim=(0, None),
        xlim=(0, None),
    )
    axes.plot(dataset.axial_force, dataset.amplitude[1, 0, 0], "o", color=style.BLUE)
    axes.yaxis.label.set_color(amplitude.get_color())
    axes.tick_params(axis="y", which="both", right=False)
    right = axes.twinx()
    right.plot(force, dataset.impact_speed, color=style.VERMILION, linestyle="--")
    right.set_ylabel(style.label(dataset.impact_speed, "impact speed"))
    right.set_ylim(0, -2.2 * float(dataset.stop_velocity[1]))
    right.yaxis.label.set_color(style.VERMILION)
