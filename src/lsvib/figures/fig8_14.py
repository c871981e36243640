"""Figure 8.14: trajectories under a negative axial force, for both readings of the mass."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import phase, style


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw four phase planes: the printed mass above, the one beyond the critical mass below; (a) left, (b) right."""
    figure = style.new_figure(style.DOUBLE, 5.6)
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
    for index, axes in enumerate(panels):
        case = dataset.isel(case=index)
        phase.draw_motions(axes, case, widths=phase.OVERLAID)
        phase.draw_cycle(axes, case)
        phase.mark_origin(axes)
        note = " (as printed)" if index < 2 else ""
        force, mass = phase.number(case.axial_force), phase.number(case.mass)
        axes.set_title(f"({'ab'[index % 2]}) $R$ = {force} N, $m$ = {mass} kg{note}")
    phase.widen(panels[0], dataset.isel(case=0))
    for index, axes in enumerate(panels):
        phase.draw_lines(axes, dataset.isel(case=index))
        phase.label_axes(axes, dataset)
        axes.label_outer()
    phase.legend(figure, panels, 4)
    return figure
