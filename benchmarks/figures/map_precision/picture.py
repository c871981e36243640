"""Maps of the region of attraction: speed against wrong labels, and wrong labels against distance to the boundary."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lsvib.figures import style

_STYLES = {  # colour, dashes
    "engine": (style.BLACK, "-"),
    "rk4_coarse": (style.BLUE, "-"),
    "rk4_fine": (style.SKY, "-"),
}
_MARKERS = {"o": "circles", "s": "squares", "D": "diamonds", "^": "triangles", "v": "wedges", "P": "crosses"}  # boxes


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) wrong share against labels per second for all boxes, (b …) labels near the boundary, box by box."""
    count = dataset.sizes["box"]
    rows = (count + 2) // 2
    figure = style.new_figure(style.DOUBLE, 2.6 * rows + 0.8)
    panels = np.ravel(figure.subplots(rows, 2))
    names = dataset.method.attrs["flag_meanings"].split()
    titles = dataset.box.attrs["labels"].split("; ")
    _speed(panels[0], dataset, names)
    for k, axes in enumerate(panels[1:]):
        if k >= count:
            axes.set_visible(False)
            continue
        _near(axes, dataset.isel(box=k), names)
        axes.set_title(f"({chr(98 + k)}) {list(_MARKERS.values())[k]}: {titles[k]}", fontsize=7)
    figure.legend(handles=_handles(dataset, names), loc="outside lower center", ncols=4, fontsize=6.5)
    return figure


def _speed(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Labels per second and wrong share of each box; an arrow marks a bound, where no wrong label was seen."""
    for k, name in enumerate(names):
        method = dataset.isel(method=k)
        colour, dashes = _STYLES[name]
        for box, marker in zip(range(dataset.sizes["box"]), _MARKERS, strict=False):
            face = colour if dashes == "-" else "white"
            rate, share = 1.0 / float(method.time_per_label[box]), float(method.wrong_share[box])
            axes.plot(rate, share, marker, color=colour, mfc=face, markersize=5)
            if float(method.reach[box]) == 0.0 and int(method.wrong_cells[box]) == 0:
                axes.annotate("", (rate, share / 30), (rate, share), arrowprops={"arrowstyle": "->", "color": colour,
                              "linewidth": 0.7})  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="Labels per second, one thread [s⁻¹]", ylabel="Share of wrong labels")
    axes.set_title("(a) speed and wrong labels of all boxes", fontsize=7)
    axes.margins(0.08)
    low, high = axes.get_ylim()
    axes.set_ylim(low / 30, high)


def _near(axes: Axes, box: xr.Dataset, names: list[str]) -> None:
    for k, name in enumerate(names):
        method = box.isel(method=k)
        colour, dashes = _STYLES[name]
        width = 1.6 if name == "engine" else 1.0
        axes.plot(
            box.boundary_distance,
            method.wrong_near,
            dashes,
            color=colour,
            linewidth=width,
            zorder=3 if name == "engine" else 2,
        )
        if method.undecided_near.any():
            either = method.wrong_near + method.undecided_near
            axes.fill_between(box.boundary_distance, method.wrong_near, either, color=colour, alpha=0.15, linewidth=0)
    axes.set(xscale="log", xlabel="Distance from the boundary [widths of the box]", ylabel="Share of wrong labels")
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlim(float(box.boundary_distance[0]), float(box.boundary_distance[-1]))
    for power in (3, 6):  # maps of 10³ × 10³ and 10⁶ × 10⁶ cells
        axes.axvline(10.0**-power, color=style.GREY, linestyle=":", linewidth=0.8, zorder=0)
        words = f"cell of\n$10^{power}\\times10^{power}$"
        axes.text(1.3 * 10.0**-power, 0.99, words, fontsize=6, color=style.GREY, va="top")


def _handles(dataset: xr.Dataset, names: list[str]) -> list[Line2D]:
    labels = dataset.method.attrs["labels"].split("; ")
    handles = [
        Line2D([], [], color=_STYLES[name][0], linestyle=_STYLES[name][1], label=label)
        for name, label in zip(names, labels, strict=True)
    ]
    if dataset.undecided_near.any():
        handles.append(Line2D([], [], color=style.VERMILION, alpha=0.15, linewidth=6, label="undecided"))
    return handles
