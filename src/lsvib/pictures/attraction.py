"""Map of regions of attraction: the attractor as colour, the time until it is reached as shade."""

import numpy as np
import xarray as xr

from lsvib.answers.attributes import flag_names
from lsvib.errors import InputError
from lsvib.pictures import drawing, style

COLOURS: dict[str, str] = {
    "steady sliding": style.SKY,
    "stick slip cycle": style.GREEN,
    "sprag slip cycle": style.ORANGE,
    "other cycle": style.PURPLE,
    "neutral family": style.BLUE,
    "unbounded": style.GREY,
    "rest": style.YELLOW,
    "unresolved": style.BLACK,
}


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the map of u and w, if there is one, with the lines Q = 0 and θ′ = 0, the boundary if known, and cycles.

    Raises ``InputError`` for a map of other coordinates.
    """
    if "label" in dataset and not {"u", "w"} <= set(dataset.label.dims):
        raise InputError("only maps of u and w can be drawn.")
    figure = style.new_figure(style.DOUBLE, 3.8)
    axes = figure.add_subplot()
    first = draw_map(axes, dataset) if "label" in dataset else ()
    if "boundary_u" in dataset:
        boundary = dataset.boundary_u, dataset.boundary_w
        axes.plot(*boundary, color=style.BLACK, linewidth=0.9, label="exact boundary")
    for index in range(dataset.sizes.get("cycle", 0)):
        one = dataset.isel(cycle=index)
        repels = "attracting" in one and not one.attracting
        look = (style.VERMILION, 1.4, "cycle that does not attract") if repels else (style.BLUE, 1.4)
        drawing.draw_cycle(axes, one, *look)
    drawing.mark_origin(axes)
    if first:
        axes.axis(_limits(dataset))
    if "contact_line_angle" in dataset:
        drawing.draw_lines(axes, dataset, style.VERMILION, "$Q = 0$")
    drawing.label_axes(axes, dataset)
    return style.legend(figure, [axes], 3, first)


def draw_map(axes: style.Axes, dataset: xr.Dataset) -> tuple[object, ...]:
    """Draw the cells, the paler the longer it takes within a region; returns patches for the legend."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    label = dataset.label.transpose("w", "u")
    time = dataset.settling_time.transpose(*label.dims).values if "settling_time" in dataset else None
    image, patches = np.ones((*label.shape, 3)), []
    fractions = dict(zip(dataset.attractor.values.tolist(), dataset.fraction.values.tolist(), strict=True))
    for value, name in flag_names(label).items():
        here = label.values == value
        if not here.any():
            continue
        words, share = f"{name.replace(' cycle', '')}: {100 * fractions[value]:.2f} %", np.full(here.sum(), 0.8)
        if time is not None and np.isfinite(time[here]).any():
            low, high = np.nanmin(time[here]), np.nanmax(time[here])
            # The palest shade has 0.35 of a colour.
            shade = 1 - 0.65 * ((time[here] - low) / (high - low) if high > low else 0 * time[here])
            share = np.where(np.isfinite(shade), shade, share)
            words += f", palest {high:.2g} {dataset.settling_time.attrs['units']}"
        image[here] = 1 - share[:, None] * (1 - np.array(to_rgb(COLOURS[name])))
        patches.append(Patch(color=COLOURS[name], label=words))
    axes.imshow(image, origin="lower", extent=_limits(dataset), aspect="auto", interpolation="nearest", zorder=0)
    return tuple(patches)


def _limits(dataset: xr.Dataset) -> tuple[float, float, float, float]:
    """The outer edges of the cells: left, right, bottom, top."""
    u, w = dataset.u, dataset.w
    across, up = (0.5 * float(x.attrs["cell_width"]) for x in (u, w))
    return float(u[0]) - across, float(u[-1]) + across, float(w[0]) - up, float(w[-1]) + up
