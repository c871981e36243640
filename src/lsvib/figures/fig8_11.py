"""Figure 8.11: effect of the support damping on the sprag–slip cycle."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import arrows, phase, style

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.PURPLE)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the limit cycle of each damping with its own line N = 0, on which its seizure starts."""
    figure = style.new_figure(style.DOUBLE * 0.72, 4.3)
    axes = figure.add_subplot()
    coloured = list(zip(dataset.case.values, _COLOURS, strict=False))
    for index, colour in coloured:
        case = dataset.sel(case=index)
        damping = f"$c$ = {phase.number(case.support_damping)} {style.unit(case.support_damping.attrs['units'])[1:-1]}"
        phase.draw_cycle(axes, case, colour, name=damping)
        seized = phase.cycle_jumps(case)
        phase.mark_seizures(axes, case.cycle_angle.values[seized], case.cycle_velocity.values[seized], colour)
    phase.mark_origin(axes)
    axes.margins(0.08)
    axes.autoscale_view()
    for index, colour in coloured:
        phase.draw_lines(axes, dataset.sel(case=index), colour, "$N = 0$, same colour")
    _guide(axes, dataset, coloured)
    phase.label_axes(axes, dataset)
    style.state_values(figure, dataset)
    phase.legend(figure, [axes], 3)
    return figure


def _guide(axes, dataset: xr.Dataset, coloured) -> None:
    """An arrow of time on each cycle, and the side of each line N = 0 on which the screw slips forward."""
    lines: list[arrows.Line] = []
    for index, colour in coloured:
        case = dataset.sel(case=index)
        after = np.flatnonzero(phase.cycle_jumps(case)) + 1
        u, w = (np.insert(x, after[after < x.size], np.nan) for x in (case.cycle_angle.values, case.cycle_velocity.values))
        lines.append((u, w, colour))
    arrows.draw_arrows(axes, lines)
    axes.text(0.42, 0.5, "$N < 0$ left of the line:\nslip", transform=axes.transAxes, ha="center", va="center")
    axes.text(0.9, 0.87, "no solution\nright of it:\nseizure", transform=axes.transAxes, ha="center", va="center")
