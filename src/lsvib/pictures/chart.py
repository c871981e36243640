"""Sweep over two parameters: what the drive does as colour, the exact curves on top, each with its name."""

from itertools import cycle

import numpy as np
import xarray as xr

from lsvib.answers.attributes import flag_names
from lsvib.pictures import attraction, drawing, style

# Light where nothing vibrates, so that the eye goes to what does; distinct for the colour-blind and in grey.
LOOKS = {  # colour, and words of the legend
    **{name: (colour, name) for name, colour in attraction.COLOURS.items()},
    "no vibration": ("#F4F4F4", "no vibration"),
    "pure slip": (style.YELLOW, "slip cycle"),
    "stick slip": (style.GREEN, "stick–slip"),
    "stick slip with contact reversal": (style.SKY, "stick–slip, $N$ reverses"),
    "sprag slip": (style.ORANGE, "sprag–slip"),
    "coexistence": (style.WINE, "steady sliding beside a cycle"),
    "vibration from rest": (style.PURPLE, "steady sliding, a cycle from rest"),
    "neutral": (style.BLUE, "neutral oscillations"),
    "equilibrium": ("#F4F4F4", "equilibrium"),
}
_CURVES = {  # words on a curve, where they are not its name, and how it is drawn
    "onset": (r"onset, $\tilde R = 0$", "-"),
    "kinematic constraint": (r"kinematic constraint, $\Gamma_+ = 0$", (0, (5, 1.5))),
    "negative damping": (r"negative damping, $C_+ = 0$", (0, (1.5, 1))),
    "even speed": ("even from rest", "-"),
}


_OTHERS = (style.GREEN, style.ORANGE, style.SKY, style.PURPLE, style.BLUE, style.YELLOW, style.VERMILION, style.WINE)


def looks(kinds: xr.DataArray) -> dict[str, tuple[str, str]]:
    """Return colour and words of the legend by kind; kinds without a look of their own have a colour each, in turn."""
    names = flag_names(kinds).values()
    others = cycle(_OTHERS)
    return {name: LOOKS.get(name) or (next(others), name) for name in names}


def kinds(dataset: xr.Dataset) -> xr.DataArray:
    """Return what drives do, or of a sweep from a start what its motions end on."""
    return dataset["behaviour"] if "behaviour" in dataset else dataset["attractor"]


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw a sweep over two parameters with its curves."""
    figure = style.new_figure(style.DOUBLE, 4.3)
    axes, found = figure.add_subplot(), kinds(dataset)
    down, across = map(str, found.dims)
    found = found.sortby([down, across])
    for name, scale, limit, say in (
        (across, axes.set_xscale, axes.set_xlim, axes.set_xlabel),
        (down, axes.set_yscale, axes.set_ylim, axes.set_ylabel),
    ):
        values = found[name].values
        if _in_ratios(values):
            scale("log")
        if values.size > 1:
            limit(values[0], values[-1])
        say(style.label(dataset[name]))
    names, own = flag_names(found), looks(found)
    colours = {name: colour for name, (colour, _) in own.items()}
    drawing.regions(axes, _edges(found[across].values), _edges(found[down].values), found, colours, zorder=0)
    if "boundary_name" in dataset:
        _curves(axes, dataset, across, down)
    shares = {name: 100 * float((found == kind).mean()) for kind, name in names.items()}
    entries = [(own[name][0], None, f"{own[name][1]}: {share:.1f} %") for name, share in shares.items() if share]
    return style.legend(figure, [], 2, drawing.patches(entries, style.GREY))


def _in_ratios(values: np.ndarray) -> bool:
    """Whether values, at least three, have equal ratios."""
    if values.size < 3 or values[0] <= 0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6, atol=0))


def _edges(values: np.ndarray) -> np.ndarray:
    """The edges of the cells around values, half way to their neighbours."""
    if _in_ratios(values):
        return np.asarray(np.exp(_edges(np.log(values))))
    half = np.diff(values) / 2 if values.size > 1 else np.array([0.5])
    return np.concatenate([values[:1] - half[:1], values[:-1] + half[: values.size - 1], values[-1:] + half[-1:]])


def _curves(axes: style.Axes, dataset: xr.Dataset, across: str, down: str) -> None:
    """Draw the exact curves, and write its name on the longest line of each."""
    from matplotlib import patheffects

    halo = [patheffects.withStroke(linewidth=2.2, foreground="white")]
    names, longest = flag_names(dataset.boundary_name), dict[str, tuple[float, np.ndarray, np.ndarray]]()
    for number in np.unique(dataset.boundary_line.values):
        part = dataset.isel(boundary_point=dataset.boundary_line.values == number)
        name = names[int(part.boundary_name[0])]
        points = np.column_stack([part[f"boundary_{across}"], part[f"boundary_{down}"]])
        dashes = _CURVES.get(name, (name, "-"))[1]
        axes.plot(*points.T, color=style.BLACK, linewidth=1.1, linestyle=dashes, zorder=2, path_effects=halo)
        path = axes.transAxes.inverted().transform(axes.transData.transform(points))
        way = np.append(0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T)))
        if way[-1] > longest.get(name, (0.2,))[0]:  # words need a fifth of a side
            longest[name] = way[-1], way, points
    for k, (name, (length, way, points)) in enumerate(longest.items()):
        # In its middle, or before or after it, so that names on lines beside each other stand apart.
        ends = [
            [np.interp((0.5 + 0.2 * (k % 3 - 1) + aside) * length, way, x) for x in points.T] for aside in (0, 0.02)
        ]
        first, last = axes.transData.transform(ends)
        angle = np.degrees(np.arctan(np.divide(*(last - first)[::-1]))) if last[0] != first[0] else 90.0
        axes.annotate(_CURVES.get(name, (name,))[0], (*ends[0],), fontsize=7.5, rotation=angle, rotation_mode="anchor",
                      ha="center", va="bottom", zorder=3, path_effects=halo)  # fmt: skip
