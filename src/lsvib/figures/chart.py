"""Chart over two parameters: what the drive does as colour, the exact curves on top, each with its name.

The rule `chart` of the workflow makes its dataset (:mod:`lsvib.datasets.sweep`).
"""

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.figures import drawing, style
from lsvib.figures.common import flag_names
from lsvib.figures.settings import Cells, FigureSettings

CAPTION = """\
What the drive does over two of its parameters, by up to three motions in each cell, with the exact curves that divide
it. Sects 8.5 to 8.7 give single values of these curves.
"""
# Light where nothing vibrates, so that the eye goes to what does; distinct for the colour-blind and in grey.
_LOOKS = {  # colour, and words of the legend
    "no vibration": ("#F4F4F4", "no vibration"),
    "pure slip": (style.YELLOW, "slip cycle"),
    "stick slip": (style.GREEN, "stick–slip"),
    "stick slip with contact reversal": (style.SKY, "stick–slip, $N$ reverses"),
    "sprag slip": (style.ORANGE, "sprag–slip"),
    "coexistence": (style.WINE, "steady sliding beside a cycle"),
    "vibration from rest": (style.PURPLE, "steady sliding, a cycle from rest"),
    "neutral": (style.BLUE, "neutral oscillations"),
    "unresolved": (style.BLACK, "unresolved"),
}
_CURVES = {  # words on a curve, where they are not its name, and how it is drawn
    "onset": (r"onset, $\tilde R = 0$", "-"),
    "kinematic constraint": (r"kinematic constraint, $\Gamma_+ = 0$", (0, (5, 1.5))),
    "negative damping": (r"negative damping, $C_+ = 0$", (0, (1.5, 1))),
    "even speed": ("even from rest", "-"),
}


class ParameterCells(Cells):
    """Cells along a parameter [SI unit], of equal width; of the stiffness and damping of a contact of equal ratio."""

    parameter: str = Field(description="Name of the parameter; lsvib checks it and its range.")


class Settings(FigureSettings):
    drive: dict[str, float] = Field(description="Changes of the drive of Table 8.1; lsvib checks keys and ranges.")
    x: ParameterCells = Field(description="Along the columns.")
    y: ParameterCells = Field(description="Along the rows.")


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the chart with its curves."""
    figure = style.new_figure(style.DOUBLE, 4.3)
    axes = figure.add_subplot()
    down, across = dataset.label.dims
    x, y = dataset[across], dataset[down]
    colours = {name: colour for name, (colour, _) in _LOOKS.items()}
    drawing.regions(axes, drawing.edges(x), drawing.edges(y), dataset.label, colours, zorder=0)
    for variable, scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        if "cell_ratio" in variable.attrs:
            scale("log")
    axes.set(
        xlim=drawing.edges(x)[[0, -1]], ylim=drawing.edges(y)[[0, -1]], xlabel=style.label(x), ylabel=style.label(y)
    )
    if "boundary_name" in dataset:
        _curves(axes, dataset, across, down)
    shares = {int(kind): float(part) for kind, part in zip(dataset.behaviour, dataset.fraction, strict=True)}
    kinds = ((shares[kind], *_LOOKS[name]) for kind, name in flag_names(dataset.label).items())
    looks = ((colour, None, f"{words}: {100 * share:.1f} %") for share, colour, words in kinds if share)
    return style.legend(figure, [], 2, drawing.patches(looks, style.GREY))


def _curves(axes: style.Axes, dataset: xr.Dataset, across: str, down: str) -> None:
    """Draw the exact curves, and write its name on the longest line of each."""
    from matplotlib import patheffects

    halo = {"path_effects": [patheffects.withStroke(linewidth=2.2, foreground="white")]}
    names, longest = flag_names(dataset.boundary_name), {}
    for number in np.unique(dataset.boundary_line.values):
        part = dataset.isel(boundary_point=dataset.boundary_line.values == number)
        name = names[int(part.boundary_name[0])]
        points = np.column_stack([part[f"boundary_{across}"], part[f"boundary_{down}"]])
        dashes = _CURVES.get(name, (name, "-"))[1]
        axes.plot(*points.T, color=style.BLACK, linewidth=1.1, linestyle=dashes, zorder=2, **halo)
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
        axes.annotate(_CURVES.get(name, (name,))[0], ends[0], fontsize=7.5, rotation=angle, rotation_mode="anchor",
                      ha="center", va="bottom", zorder=3, **halo)  # fmt: skip
