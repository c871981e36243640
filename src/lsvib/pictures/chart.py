"""Sweep over two parameters: the behaviour as colour, the exact curves on top, each with its name."""

from collections.abc import Iterator
from typing import Any

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
    "even speed": ("steady from rest", "-"),
}
_OTHERS = (style.GREEN, style.ORANGE, style.SKY, style.PURPLE, style.BLUE, style.YELLOW, style.VERMILION, style.WINE)


def looks(kinds: xr.DataArray) -> dict[str, tuple[str, str]]:
    """Return colour and words of the legend by kind; kinds without a look of their own have a colour each, in turn."""
    return {name: LOOKS.get(name, (_OTHERS[k % 8], name)) for k, name in enumerate(flag_names(kinds).values())}


def kinds(dataset: xr.Dataset) -> xr.DataArray:
    """Return what drives do, or of a sweep from a start what its motions end on."""
    return dataset["behaviour"] if "behaviour" in dataset else dataset["attractor"]


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw a sweep over two parameters with its curves."""
    figure = style.new_figure(style.DOUBLE, 4.3)
    axes, found = figure.add_subplot(), kinds(dataset)
    down, across = map(str, found.dims)
    found = found.sortby([down, across])
    for axis, values in (("x", found[across].values), ("y", found[down].values)):
        axes.set(**{f"{axis}scale": "log" if _in_ratios(values) else "linear"})
        if values.size > 1:
            axes.set(**{f"{axis}lim": values[[0, -1]]})
    style.frame(axes, "", dataset[across], dataset[down])
    names, own = flag_names(found), looks(found)
    colours = {name: colour for name, (colour, _) in own.items()}
    drawing.regions(axes, _edges(found[across].values), _edges(found[down].values), found, colours, zorder=0)
    shares = {name: 100 * float((found == kind).mean()) for kind, name in names.items()}
    entries = [(own[name][0], None, f"{own[name][1]}: {share:.1f} %") for name, share in shares.items() if share]
    patches = drawing.patches(entries, style.GREY)
    style.laid_out(style.legend(figure, [], 2, patches))
    if "boundary_name" in dataset and (left := _curves(axes, dataset, across, down)):
        figure.legends[0].remove()
        style.legend(figure, [], 2, [*patches, *left])
    return figure


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


def _curves(axes: style.Axes, dataset: xr.Dataset, across: str, down: str) -> list[Any]:
    """Draw the exact curves, each with its name beside it; returns lines for a legend of those without room for it."""
    from matplotlib import patheffects

    halo: dict[str, Any] = {"path_effects": [patheffects.withStroke(linewidth=2.2, foreground="white")]}
    names, lines, left = flag_names(dataset.boundary_name), dict[str, list[Any]](), list[Any]()
    for number in np.unique(dataset.boundary_line.values):
        part = dataset.isel(boundary_point=dataset.boundary_line.values == number)
        name = names[int(part.boundary_name[0])]
        words, dashes = _CURVES.get(name, (name, "-"))
        points = part[f"boundary_{across}"], part[f"boundary_{down}"]
        look = {"color": style.BLACK, "linewidth": 1.1, "linestyle": dashes, "zorder": 2, **halo}
        lines.setdefault(words, []).extend(axes.plot(*points, **look))
    for words, own in lines.items():
        look = {"ha": "center", "va": "center", "fontsize": 7.5, "zorder": 3, **halo}
        if not drawing.write(axes, words, _along(axes, own), **look):
            left += own
            for line in own:
                line.set(color=_OTHERS[len(left) % len(_OTHERS)], label=words)
    return left


def _along(axes: style.Axes, lines: list[Any]) -> Iterator[tuple[float, float, float]]:
    """Places beside lines, above and below each, from its middle outwards."""
    for line in lines:
        path = axes.transData.transform(line.get_xydata())
        way = np.append(0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T)))
        for share in (0.5 + side * aside for aside in np.linspace(0, 0.48, 25) for side in (1, -1)):
            first, last = np.transpose([np.interp(share * way[-1] + np.array([-12, 12]), way, x) for x in path.T])
            angle = np.arctan2(*(last - first)[::-1])
            for side in (10, -10):  # so far that the line, and one on it, is clear of words of this size
                place = (first + last) / 2 + side * np.array([-np.sin(angle), np.cos(angle)])
                yield *axes.transData.inverted().transform(place), 90 - (90 - np.degrees(angle)) % 180
