"""Figure 8.9: trajectories below and above the critical mass, and how the cycle depends on the axial force."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import phase, style


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) and (b) as phase planes, and (c) amplitude and impact speed of (b) against the axial force."""
    figure = style.new_figure(style.DOUBLE, 3.3)
    *planes, last = figure.subplots(1, 3)
    for index, axes in enumerate(planes):
        case = dataset.isel(case=index)
        relation = "<" if float(case.mass) < float(dataset.critical_mass) else ">"
        phase.draw_motions(axes, case)
        phase.draw_cycle(axes, case)
        phase.mark_origin(axes)
        phase.widen(axes, case)
        phase.draw_lines(axes, case)
        phase.label_axes(axes, dataset)
        axes.set_title(f"({'ab'[index]}) $m$ = {phase.number(case.mass)} kg ${relation} m_\\mathrm{{cr}}$")
    (amplitude,) = last.plot(dataset.swept_axial_force, dataset.swept_amplitude, color=style.BLUE)
    last.set(
        title="(c) cycle of (b) against $R$",
        xlabel=style.label(dataset.swept_axial_force),
        ylabel=style.label(dataset.swept_amplitude, "amplitude of $u$"),
        ylim=(0, None),
        xlim=(0, None),
    )
    last.plot(dataset.axial_force, dataset.amplitude[1, 0, 0], "o", color=style.BLUE)
    last.yaxis.label.set_color(amplitude.get_color())
    last.tick_params(axis="y", which="both", right=False)
    right = last.twinx()
    right.plot(dataset.swept_axial_force, dataset.impact_speed, color=style.VERMILION, linestyle="--")
    right.set_ylabel(style.label(dataset.impact_speed, "impact speed"))
    right.set_ylim(0, -2.2 * float(dataset.stop_velocity[1]))
    right.yaxis.label.set_color(style.VERMILION)
    phase.legend(figure, planes, 4)
    return figure
