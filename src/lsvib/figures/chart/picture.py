"""Draw a chart: what the drive does as colour, the exact curves on top, each with its name."""

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures.drawing import style

# Light where nothing vibrates, so that the eye goes to what does; told apart by the colour-blind and in grey.
COLOURS = {
    "unresolved": style.BLACK,
    "no vibration": "#F4F4F4",
    "pure slip": style.YELLOW,
    "stick slip": style.GREEN,
    "stick slip with contact reversal": style.SKY,
    "sprag slip": style.ORANGE,
    "coexistence": style.PURPLE,
    "neutral": style.BLUE,
}
_WORDS = {
    "no vibration": "no vibration",
    "pure slip": "slip cycle",
    "stick slip": "stick–slip",
    "stick slip with contact reversal": "stick–slip, $N$ reverses",
    "sprag slip": "sprag–slip",
    "coexistence": "steady sliding beside a cycle",
    "neutral": "neutral oscillations",
    "unresolved": "unresolved",
}
_CURVES = {  # words on a curve, and how it is drawn
    "onset": (r"onset, $\tilde R = 0$", "-"),
    "stick": ("stick", "-"),
    "detach": ("detach", "-"),
    "global stability": ("global stability", "-"),
    "kinematic": (r"kinematic, $\Gamma_+ = 0$", (0, (5, 1.5))),
    "negative damping": (r"negative damping, $C_+ = 0$", (0, (1.5, 1))),
    "flutter": ("flutter", "-"),
}
_HALO = [patheffects.withStroke(linewidth=2.2, foreground="white")]
_SHORTEST = 0.12  # length of a line, in widths of the picture, that a name has room on
_CLOSE = 0.045  # distance of two names, in widths of the picture, that would cover each other


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the chart with its curves, and below it the values of the drive."""
    figure = style.new_figure(style.SINGLE * 1.5, 4.3)
    axes = figure.add_subplot()
    down, across = dataset.label.dims
    x, y = dataset[across], dataset[down]
    names = style.flag_names(dataset.label)
    _cells(axes, dataset, names)
    for variable, scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        if "cell_ratio" in variable.attrs:
            scale("log")
    axes.set(xlim=_edges(x)[[0, -1]], ylim=_edges(y)[[0, -1]], xlabel=style.label(x), ylabel=style.label(y))
    if "boundary_name" in dataset:
        _curves(axes, dataset, across, down)
    shares = {int(kind): float(part) for kind, part in zip(dataset.behaviour, dataset.fraction, strict=True)}
    patches = [
        Patch(facecolor=COLOURS[name], edgecolor=style.GREY, linewidth=0.4, label=f"{_WORDS[name]}: {shares[kind]:.1%}")
        for kind, name in names.items()
        if shares[kind]
    ]
    given = [
        variable for variable in dataset.variables.values() if variable.attrs.get("origin", "").startswith("given")
    ]
    style.write_below(figure, style.enumeration("", [style.amount(xr.DataArray(variable)) for variable in given]))
    figure.legend(handles=patches, loc="outside upper center", ncols=2)
    return figure


def _cells(axes: Axes, dataset: xr.Dataset, names: dict[int, str]) -> None:
    """Paint every cell in the colour of what the drive does there."""
    kinds = sorted(names)
    down, across = dataset.label.dims
    axes.pcolormesh(
        _edges(dataset[across]),
        _edges(dataset[down]),
        dataset.label.values,
        cmap=ListedColormap([COLOURS[names[kind]] for kind in kinds]),
        norm=BoundaryNorm(np.array([*kinds, kinds[-1] + 1]) - 0.5, len(kinds)),
        rasterized=True,
        zorder=0,
    )


def _edges(axis: xr.DataArray) -> np.ndarray:
    """Edges of the cells of an axis."""
    if "cell_ratio" in axis.attrs:
        half = float(axis.attrs["cell_ratio"]) ** 0.5
        return np.append(axis.values / half, axis.values[-1] * half)
    half = 0.5 * float(axis.attrs["cell_width"])
    return np.append(axis.values - half, axis.values[-1] + half)


def _curves(axes: Axes, dataset: xr.Dataset, across: str, down: str) -> None:
    """Draw the exact curves, and write its name on the longest line of each."""
    names = style.flag_names(dataset.boundary_name)
    axes.figure.canvas.draw()  # so that places on the picture are known
    taken: list[np.ndarray] = []
    for kind in np.unique(dataset.boundary_name.values):
        words, dashes = _CURVES[names[int(kind)]]
        here = dataset.isel(boundary_point=dataset.boundary_name.values == kind)
        lines = []
        for number in np.unique(here.boundary_line.values):
            part = here.isel(boundary_point=here.boundary_line.values == number)
            points = np.column_stack([part[f"boundary_{across}"], part[f"boundary_{down}"]])
            axes.plot(*points.T, color=style.BLACK, linewidth=1.1, linestyle=dashes, path_effects=_HALO, zorder=2)
            lines.append(points)
        _write_on(axes, lines, words, taken)


def _write_on(axes: Axes, lines: list[np.ndarray], words: str, taken: list[np.ndarray]) -> None:
    """Write words along the longest of some lines, where no others are near; a line that is too short gets none."""
    width = axes.bbox.width
    shown = [axes.transData.transform(line) for line in lines]
    lengths = [np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))]) / width for line in shown]
    best = int(np.argmax([length[-1] for length in lengths]))
    line, length = shown[best], lengths[best]
    if length[-1] < _SHORTEST:
        return
    for share in (0.5, 0.3, 0.7, 0.2, 0.8, 0.4, 0.6):
        ends = [
            np.array([np.interp(share * length[-1] + d, length, line[:, i]) for i in (0, 1)]) for d in (-0.04, 0.04)
        ]
        middle = 0.5 * (ends[0] + ends[1])
        if all(np.hypot(*(middle - other)) > 5 * _CLOSE * width for other in taken):
            break
    taken.append(middle)
    slope = np.degrees(np.arctan2(*(ends[1] - ends[0])[::-1]))
    slope = (slope + 90) % 180 - 90  # never upside down
    axes.annotate(
        words, axes.transData.inverted().transform(middle), rotation=slope, rotation_mode="anchor", ha="center",
        va="bottom", fontsize=6.5, xytext=(-np.sin(np.radians(slope)) * 2, np.cos(np.radians(slope)) * 2),
        textcoords="offset points", path_effects=_HALO, zorder=3,
    )  # fmt: skip
