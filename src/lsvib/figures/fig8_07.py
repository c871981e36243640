"""Figure 8.7: sectors of the phase plane without a solution or with two, in the Painlevé region."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import phase, style

_SECTORS = {"inconsistent": ("#F7D9C4", "no solution", "////"), "indeterminate": ("#FFFFFF", "two solutions", None)}

_HATCH = "#C9A58C"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the map (hatched: no solution), the lines, a motion from each sector, and the equilibrium of law −1."""
    figure = style.new_figure(style.DOUBLE * 0.72, 4.2)
    axes = figure.add_subplot()
    case = dataset.isel(case=0)
    names = {name: value for value, name in style.flag_names(dataset.existence).items()}
    patches = []
    for name, (colour, words, hatch) in _SECTORS.items():
        inside = (dataset.existence == names[name]).T.astype(float)
        if hatch:
            area = axes.contourf(
                dataset.grid_angle_deviation,
                dataset.grid_velocity_deviation,
                inside,
                levels=[0.5, 1.5],
                colors=[colour],
                hatches=[hatch],
                zorder=0,
            )
            area.set(edgecolor=_HATCH, linewidth=0)
        patches.append(Patch(facecolor=colour, hatch=hatch, edgecolor=_HATCH, linewidth=0.5, label=words))
    phase.draw_motions(axes, case, widths=phase.OVERLAID)
    phase.mark_origin(axes)
    axes.plot(
        float(dataset.equilibrium_angle), 0, "*", color=style.BLACK, markersize=8, label="$u_0$, equilibrium of law −1"
    )
    axes.set(xlim=_ends(dataset.grid_angle_deviation), ylim=_ends(dataset.grid_velocity_deviation))
    phase.draw_lines(axes, case)
    phase.label_axes(axes, dataset)
    phase.legend(figure, [axes], 3, patches)
    return figure


def _ends(axis: xr.DataArray) -> np.ndarray:
    return axis.values[[0, -1]]
