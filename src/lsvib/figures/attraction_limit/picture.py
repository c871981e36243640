"""Draw how the region of attraction tends to the rigid drive's as the contact stiffens."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures.drawing import phase_planes, style

_MARKS = (("o", style.VERMILION), ("x", style.BLACK), ("^", style.GREEN), ("s", style.PURPLE))


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the exact rigid boundary and points of the compliant ones, (b) their displacement, (c) convergence."""
    figure = style.new_figure(style.DOUBLE, 3.6)
    plane, rays, distance = figure.subplots(1, 3)
    _plane(plane, dataset)
    _rays(rays, dataset)
    _convergence(distance, dataset)
    ratio = float(dataset.contact_damping[0] / dataset.contact_stiffness[0])
    style.state_values(figure, dataset, rest=f"Varied: $k_c$, with $c_c$ = {ratio:g} s · $k_c$. Otherwise Table 8.1.")
    phase_planes.legend(figure, [plane, rays, distance], 3)
    return figure


def _plane(axes: Axes, dataset: xr.Dataset) -> None:
    u, w = dataset.boundary_angle.values, dataset.boundary_velocity.values
    axes.fill(u, w, color=style.SKY, alpha=0.4, linewidth=0, label="steady sliding attracts, rigid contact")
    axes.plot(u, w, color=style.BLUE, linewidth=1.2, label="exact boundary, rigid contact")
    softest = dataset.isel(contact_stiffness=0)
    axes.plot(softest.ray_angle, softest.ray_velocity, "o", color=_MARKS[0][1], markersize=3, zorder=3)
    phase_planes.mark_origin(axes)
    phase_planes.label_axes(axes, dataset)
    axes.locator_params(axis="x", nbins=5)
    axes.set_title("(a) boundary")


def _rays(axes: Axes, dataset: xr.Dataset) -> None:
    """Displacement of each boundary along the rays, of which (a) shows that of the softest contact."""
    angle = np.degrees(dataset.ray.values)
    for index, (mark, colour) in zip(range(dataset.sizes["contact_stiffness"]), _MARKS, strict=False):
        compliant = dataset.isel(contact_stiffness=index)
        stiffness = phase_planes.number(compliant.contact_stiffness)
        outward = compliant.displacement.values
        axes.plot(angle, np.abs(outward), color=colour, linewidth=0.4)
        for sign, face in ((1, colour), (-1, "white")):
            here = np.sign(outward) == sign
            axes.plot(angle[here], np.abs(outward[here]), mark, color=colour, markerfacecolor=face, markersize=3.2,
                      label=f"$k_c$ = {stiffness} N m⁻¹" if sign == 1 else None)  # fmt: skip
    if (dataset.displacement < 0).any():
        axes.plot([], [], "o", color=style.GREY, markerfacecolor="white", markersize=3.2, label="open: inwards")
    axes.set(
        yscale="log",
        title="(b) displacement along rays",
        xlabel="Direction, box as a square [°]",
        ylabel="Displacement / length",
        xlim=(0, 360),
    )
    axes.set_xticks([0, 90, 180, 270, 360])


def _convergence(axes: Axes, dataset: xr.Dataset) -> None:
    stiffness, typical = dataset.contact_stiffness.values, dataset.typical_displacement.values
    axes.loglog(stiffness, typical, "o-", color=style.BLUE, label="root mean square of (b)")
    axes.loglog(stiffness, np.where(dataset.different > 0, dataset.different, np.nan), "s", color=style.ORANGE,
                label="fraction of cells of a grid that differ")  # fmt: skip
    line = typical[-1] * (stiffness / stiffness[-1]) ** -float(dataset.order)
    name = f"order {float(dataset.order):.3f} ± {float(dataset.order_error):.3f}"
    axes.loglog(stiffness, line, "--", color=style.GREY, label=name)
    axes.set_xlabel(style.label(dataset.contact_stiffness, "contact stiffness"))
    axes.set_ylabel("Distance from the rigid drive")
    axes.set_title("(c) convergence")
