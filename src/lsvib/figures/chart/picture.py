"""Draw a chart: what the drive does as colour, the exact curves on top, each with its name."""

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import drawing, style

# Light where nothing vibrates, so that the eye goes to what does; distinct for the colour-blind and in grey.
_LOOKS = {  # colour, and words of the legend
    "no vibration": ("#F4F4F4", "no vibration"),
    "pure slip": (style.YELLOW, "slip cycle"),
    "stick slip": (style.GREEN, "stick–slip"),
    "stick slip with contact reversal": (style.SKY, "stick–slip, $N$ reverses"),
    "sprag slip": (style.ORANGE, "sprag–slip"),
    "coexistence": (style.PURPLE, "steady sliding beside a cycle"),
    "neutral": (style.BLUE, "neutral oscillations"),
    "unresolved": (style.BLACK, "unresolved"),
}
_CURVES = {  # words on a curve, where they are not its name, and how it is drawn
    "onset": (r"onset, $\tilde R = 0$", "-"),
    "kinematic constraint": (r"kinematic constraint, $\Gamma_+ = 0$", (0, (5, 1.5))),
    "negative damping": (r"negative damping, $C_+ = 0$", (0, (1.5, 1))),
    "stick slip birth": ("birth of stick–slip", "-"),
}
_HALO = [patheffects.withStroke(linewidth=2.2, foreground="white")]
# In widths of the picture:
_SHORTEST = 0.06  # length of a line that gets its name
_STEP = 0.004  # between points at which room for a name is looked for
_LETTER = 0.0135  # width of a letter
_HEIGHT = 0.02  # distance of the middle of a name from its line


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
    if "reading_mass" in dataset:
        _readings(axes, dataset, across)
    shares = {int(kind): float(part) for kind, part in zip(dataset.behaviour, dataset.fraction, strict=True)}
    patches = [
        Patch(facecolor=colour, edgecolor=style.GREY, linewidth=0.4, label=f"{words}: {100 * shares[kind]:.1f} %")
        for kind, (colour, words) in ((kind, _LOOKS[name]) for kind, name in names.items())
        if shares[kind]
    ]
    drawing.state_given(figure, dataset)
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
        cmap=ListedColormap([_LOOKS[names[kind]][0] for kind in kinds]),
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
    lines: dict[str, list[np.ndarray]] = {}
    for number in np.unique(dataset.boundary_line.values):
        part = dataset.isel(boundary_point=dataset.boundary_line.values == number)
        name = names[int(part.boundary_name[0])]
        points = np.column_stack([part[f"boundary_{across}"], part[f"boundary_{down}"]])
        dashes = _CURVES.get(name, (name, "-"))[1]
        axes.plot(*points.T, color=style.BLACK, linewidth=1.1, linestyle=dashes, path_effects=_HALO, zorder=2)
        lines.setdefault(name, []).append(_evenly(axes.transData.transform(points) / axes.bbox.width))
    taken: list[np.ndarray] = []
    for name, own in lines.items():
        others = [line for other, parts in lines.items() if other != name for line in parts]
        _write_on(axes, max(own, key=len), _CURVES.get(name, (name, "-"))[0], others + taken, taken)


def _readings(axes: Axes, dataset: xr.Dataset, across: str) -> None:
    """Mark the masses that the text gives for this drive where it contradicts itself: as stated, and as needed."""
    places, kinds = (style.flag_names(dataset[name]) for name in ("reading_place", "reading_kind"))
    for mass, place, kind in zip(
        dataset.reading_mass.values, dataset.reading_place.values, dataset.reading_kind.values, strict=True
    ):
        stated = kinds[int(kind)] == "as stated"
        words = f"{places[int(place)]}: {mass:g} kg {'stated' if stated else 'needed'}"
        look = {"color": style.BLACK, "linewidth": 0.7, "linestyle": "-" if stated else "--", "zorder": 1}
        upright = across == "mass"
        (axes.axvline if upright else axes.axhline)(mass, **look)
        axes.annotate(
            words, (mass, 0.02) if upright else (0.02, mass), rotation=90 if upright else 0, fontsize=5.5,
            xycoords=("data", "axes fraction") if upright else ("axes fraction", "data"), path_effects=_HALO,
            ha="right" if upright else "left", va="bottom", zorder=3,
        )  # fmt: skip


def _evenly(points: np.ndarray) -> np.ndarray:
    """Points (k, 2) along a line at equal distances of ``_STEP``."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    places = np.linspace(0, length[-1], max(2, int(length[-1] / _STEP)))
    return np.column_stack([np.interp(places, length, points[:, i]) for i in (0, 1)])


def _write_on(axes: Axes, line: np.ndarray, words: str, others: list[np.ndarray], taken: list[np.ndarray]) -> None:
    """Write words along a line, on that side and at that place of it that is farthest from all other lines and words.

    Words that stand out beyond the end of their line come second, and last those that reach beyond the axes, where the
    numbers stand. Lengths are in widths of the picture. A line that is too short gets none; ``taken`` gets the place.
    """
    half = int(0.5 * _LETTER * len(words.replace("$", "").replace("\\", "")) / _STEP) + 1
    if len(line) < _SHORTEST / _STEP:
        return
    left, top = axes.transAxes.transform([(0, 0), (1, 1)]) / axes.bbox.width
    inside = _evenly(np.array([left, (top[0], left[1]), top, (left[0], top[1]), left]))
    obstacles = np.concatenate([*others, inside])
    best, place = -np.inf, None
    for middle in range(0, len(line), 2):
        ends = line[max(0, middle - half)], line[min(len(line) - 1, middle + half)]
        along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
        along = along if along[0] > 1e-9 or (abs(along[0]) <= 1e-9 and along[1] > 0) else -along  # never upside down
        for side in (1, -1):
            shift = side * np.array([-along[1], along[0]])
            covered = line[middle] + shift * _HEIGHT + np.outer(np.linspace(-half, half, 9) * _STEP, along)
            room = np.hypot(*(obstacles[:, None] - covered).reshape(-1, 2).T).min()
            room = min(room, 2 * _HEIGHT) - 0.1 * _HEIGHT * abs(2 * middle / len(line) - 1) + 0.01 * _HEIGHT * side
            # Either outweighs all other differences of two places, and the latter the former.
            room -= 4 * _HEIGHT * (not half // 2 <= middle < len(line) - half // 2)
            room -= 8 * _HEIGHT * (not ((covered > left) & (covered < top)).all())
            if room > best:
                best, place = room, (line[middle] + shift * _HEIGHT, along, covered)
    if place is None:
        return
    taken.append(place[2])
    axes.annotate(
        words, axes.transData.inverted().transform(place[0] * axes.bbox.width), ha="center", va="center", fontsize=6.5,
        rotation=np.degrees(np.arctan2(place[1][1], place[1][0])), rotation_mode="anchor", path_effects=_HALO, zorder=3,
    )  # fmt: skip
