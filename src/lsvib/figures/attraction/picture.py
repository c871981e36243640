"""Draw a map of regions of attraction: the attractor as colour, the time until it is reached as shade."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import drawing, style

COLOURS = {
    "steady sliding": style.SKY,
    "stick slip cycle": style.GREEN,
    "sprag slip cycle": style.ORANGE,
    "other cycle": style.PURPLE,
    "neutral family": style.BLUE,
    "unbounded": style.GREY,
    "rest": style.YELLOW,
    "unresolved": style.BLACK,
}
_PALEST = 0.35  # share of a colour in the palest shade


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the map of two coordinates with the lines Q = 0 and θ′ = 0, the boundary if known, and the attractors."""
    figure = style.new_figure(style.SINGLE * 1.35, 4.2)
    axes = figure.add_subplot()
    first = draw_map(axes, dataset)
    draw_boundary(axes, dataset)
    for index in range(dataset.sizes.get("cycle", 0)):
        drawing.draw_cycle(axes, dataset.isel(cycle=index), style.BLUE, 1.4)
    drawing.mark_origin(axes)
    axes.axis(_limits(dataset))
    if "contact_line_angle" in dataset:
        drawing.draw_lines(axes, dataset, style.VERMILION, "$Q = 0$")
    drawing.label_axes(axes, dataset)
    drawing.state_given(figure, dataset)
    drawing.legend(figure, [axes], 2, first)
    return figure


def draw_map(axes: Axes, dataset: xr.Dataset) -> list[Patch]:
    """Draw the cells; returns patches for the legend."""
    label = dataset.label.transpose("velocity_deviation", "angle_deviation")
    image = np.ones((*label.shape, 3))
    share = _shares(dataset)
    names, patches = style.flag_names(label), []
    fractions = dict(zip(dataset.attractor.values.tolist(), dataset.fraction.values.tolist(), strict=True))
    for value, name in names.items():
        here = label.values == value
        if here.any():
            colour = np.array(to_rgb(COLOURS[name]))
            image[here] = 1 - share[here][:, None] * (1 - colour)
            part = f"{100 * fractions[int(value)]:.2f} %"
            later = _latest(dataset, here)
            patches.append(Patch(color=COLOURS[name], label=f"{name.replace(' cycle', '')}: {part}{later}"))
    axes.imshow(image, origin="lower", extent=_limits(dataset), aspect="auto", interpolation="nearest", zorder=0)
    return patches


def _latest(dataset: xr.Dataset, here: np.ndarray) -> str:
    """The longest time in a region, which has the palest shade."""
    if "settling_time" not in dataset:
        return ""
    time = dataset.settling_time.transpose("velocity_deviation", "angle_deviation").values[here]
    return f", palest {np.nanmax(time):.2g} {dataset.settling_time.attrs['units']}" if np.isfinite(time).any() else ""


def _shares(dataset: xr.Dataset) -> np.ndarray:
    """How much of its colour each cell gets: within a region, the longer it takes, the paler."""
    label = dataset.label.transpose("velocity_deviation", "angle_deviation").values
    share = np.full(label.shape, 0.8)
    if "settling_time" not in dataset:
        return share
    time = dataset.settling_time.transpose("velocity_deviation", "angle_deviation").values
    for value in np.unique(label):
        here = (label == value) & np.isfinite(time)
        if here.any():
            low, high = time[here].min(), time[here].max()
            share[here] = 1 - (1 - _PALEST) * ((time[here] - low) / (high - low) if high > low else 0)
    return share


def draw_boundary(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the exact boundary, if the dataset has it."""
    if "boundary_angle" in dataset:
        axes.plot(
            dataset.boundary_angle, dataset.boundary_velocity, color=style.BLACK, linewidth=0.9, label="exact boundary"
        )


def _limits(dataset: xr.Dataset) -> tuple[float, float, float, float]:
    edges = []
    for name in ("angle_deviation", "velocity_deviation"):
        half = 0.5 * dataset[name].attrs["cell_width"]
        edges += [float(dataset[name][0]) - half, float(dataset[name][-1]) + half]
    return tuple(edges)
