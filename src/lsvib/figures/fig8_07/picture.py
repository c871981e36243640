"""Figure 8.7: sectors of the phase plane without a solution or with two, in the Painlevé region."""

from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import drawing, style

_SECTORS = {"inconsistent": ("#F7D9C4", "no solution", "////"), "indeterminate": ("#FFFFFF", "two solutions", None)}

_HATCH = "#C9A58C"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the map (hatched: no solution), the lines, a motion from each sector, the cycle, the equilibrium of law −.

    Motions are drawn up to the first seizure into which they slip; the cycle shows how each goes on.
    """
    figure = style.new_figure(style.DOUBLE * 0.72, 4.4)
    axes = figure.add_subplot()
    case = _until_seizure(dataset.isel(case=0))
    patches = []
    for name, (colour, words, hatch) in _SECTORS.items():
        inside = (dataset.existence == drawing.code(dataset.existence, name)).T.astype(float)
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
    drawing.draw_cycle(axes, case, width=1.1)
    drawing.draw_motions(axes, case)
    drawing.mark_origin(axes)
    axes.plot(
        float(dataset.equilibrium_angle), 0, "*", color=style.BLACK, markersize=8, label="$u_0$, equilibrium of law −"
    )
    axes.set(xlim=dataset.grid_angle_deviation[[0, -1]], ylim=dataset.grid_velocity_deviation[[0, -1]])
    drawing.draw_lines(axes, case)
    drawing.draw_arrows(axes, case)
    _name_sectors(axes, dataset)
    drawing.label_axes(axes, dataset)
    style.state_values(figure, dataset)
    drawing.legend(figure, [axes], 3, patches)
    return figure


def _until_seizure(case: xr.Dataset) -> xr.Dataset:
    """Leave of each motion what comes before the end of the first seizure into which it slips, and its jump."""
    seizures = drawing.events(case, "seizure") & (case.event_time > 0)
    end = case.event_time.where(seizures, np.inf).min("event")
    kept = {name: case[name].where(case.time <= end) for name in ("angle_deviation", "velocity_deviation")}
    none = drawing.code(case.event_kind, "none")
    return case.assign(kept | {"event_kind": case.event_kind.where(case.event_time <= end, none)})


def _name_sectors(axes: Axes, dataset: xr.Dataset) -> None:
    """Write into each sector, at its corner of the picture, the signs of θ′ and of the contact forces that solve."""
    names = style.flag_names(dataset.existence)
    for i, j in product((0, -1), repeat=2):
        direction = 1 if float(dataset.grid_velocity_deviation[j]) > float(dataset.stop_velocity[0]) else -1
        words = [rf"$\dot\theta {_relation(direction)} 0$: no $N$"]
        if names[int(dataset.existence[i, j])] == "indeterminate":  # law s holds where N θ′ has the sign s
            words = [rf"$\dot\theta {_relation(direction)} 0$: $N {_relation(-direction)} 0$ by law −"]
            words.append(f"($N {_relation(direction)} 0$ by law +)")
        axes.text(
            0.015 if i == 0 else 0.985,
            0.02 if j == 0 else 0.98,
            "\n".join(words),
            transform=axes.transAxes,
            ha="left" if i == 0 else "right",
            va="bottom" if j == 0 else "top",
            bbox={"facecolor": "white", "linewidth": 0, "pad": 1.5},
            fontsize=7,
            zorder=4,
        )


def _relation(sign: int) -> str:
    return ">" if sign > 0 else "<"
