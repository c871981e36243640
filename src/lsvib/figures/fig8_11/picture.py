"""Figure 8.11: effect of the support damping on the sprag–slip cycle."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.PURPLE)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the limit cycle of each damping with its own line N = 0, on which its seizure starts."""
    figure = style.new_figure(style.DOUBLE * 0.72, 4.3)
    axes = figure.add_subplot()
    coloured = list(zip(dataset.case.values, _COLOURS, strict=False))
    for index, colour in coloured:
        case = dataset.sel(case=index)
        damping = (
            f"$c$ = {drawing.number(case.support_damping)} {style.unit(case.support_damping.attrs['units'])[1:-1]}"
        )
        drawing.draw_cycle(axes, case, colour, name=damping)
        seized = drawing.cycle_jumps(case)
        drawing.mark_seizures(axes, case.cycle_angle.values[seized], case.cycle_velocity.values[seized], colour)
    drawing.mark_origin(axes)
    axes.margins(0.08)
    axes.autoscale_view()
    left, right = axes.get_xlim()
    axes.set_xlim(left, right + 0.2 * (right - left))  # room for words beyond the lines
    for index, colour in coloured:
        drawing.draw_lines(axes, dataset.sel(case=index), colour, "$N = 0$, same colour")
    _guide(axes, dataset, coloured)
    drawing.label_axes(axes, dataset)
    style.state_values(figure, dataset)
    drawing.legend(figure, [axes], 3)
    return figure


def _guide(axes: Axes, dataset: xr.Dataset, coloured) -> None:
    """An arrow of time on each cycle, and the side of each line N = 0 on which the screw slips forward."""
    lines: list[drawing.DrawnLine] = []
    for index, colour in coloured:
        case = dataset.sel(case=index)
        after = np.flatnonzero(drawing.cycle_jumps(case)) + 1
        after = after[after < case.sizes["sample"]]
        u, w = (np.insert(case[name].values, after, np.nan) for name in ("cycle_angle", "cycle_velocity"))
        lines.append((u, w, colour))
    drawing.draw_arrows(axes, lines)
    axes.text(0.38, 0.5, "$N < 0$ left of\neach line: slip", transform=axes.transAxes, ha="center", va="center")
    axes.text(0.98, 0.96, "right of each line\nno solution: seizure", transform=axes.transAxes, ha="right", va="top")
