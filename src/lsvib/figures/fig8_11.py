"""Figure 8.11: effect of the support damping on the sprag–slip cycle."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.PURPLE)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the limit cycle of each damping with its own line N = 0, on which its seizure starts."""
    figure = style.new_figure(style.DOUBLE * 0.72, 4.0)
    axes = figure.add_subplot()
    for index, colour in zip(dataset.case.values, _COLOURS, strict=False):
        case = dataset.sel(case=index)
        damping = f"$c$ = {phase.number(case.support_damping)} {style.unit(case.support_damping.attrs['units'])[1:-1]}"
        phase.draw_cycle(axes, case, colour, name=damping)
        seized = phase.cycle_jumps(case)
        phase.mark_seizures(axes, case.cycle_angle.values[seized], case.cycle_velocity.values[seized], colour)
    phase.mark_origin(axes)
    axes.margins(0.08)
    axes.autoscale_view()
    for index, colour in zip(dataset.case.values, _COLOURS, strict=False):
        phase.draw_lines(axes, dataset.sel(case=index), colour, "$N = 0$, same colour")
    phase.label_axes(axes, dataset)
    phase.legend(figure, [axes], 3)
    return figure
