"""Draw how the region of attraction tends to the rigid drive's as the contact stiffens."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_SHOWN = 2  # stiffnesses whose boundary is drawn; the others' cover it


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the boundaries of steady sliding, rigid and compliant; (b) their distance against the stiffness."""
    figure = style.new_figure(style.DOUBLE, 3.3)
    plane, distance = figure.subplots(1, 2)
    u, w = dataset.angle_deviation, dataset.velocity_deviation
    plane.contourf(u, w, dataset.rigid_label == 0, levels=[0.5, 1.5], colors=[style.SKY], alpha=0.5)
    plane.plot([], [], "s", color=style.SKY, alpha=0.5, markersize=7, label="steady sliding, rigid contact")
    colours = (style.VERMILION, style.BLACK)
    for index, colour in zip(range(min(_SHOWN, dataset.sizes["contact_stiffness"])), colours, strict=False):
        compliant = dataset.isel(contact_stiffness=index)
        plane.contour(u, w, compliant.label == 0, levels=[0.5], colors=[colour], linewidths=0.9)
        plane.plot(
            [], [], color=colour, linewidth=0.9, label=f"$k_c$ = {phase.number(compliant.contact_stiffness)} N/m"
        )
    phase.mark_origin(plane)
    phase.label_axes(plane, dataset)
    plane.set_title("(a) boundary")
    stiffness, typical = dataset.contact_stiffness.values, dataset.typical_displacement.values
    distance.loglog(stiffness, typical, "o-", color=style.BLUE, label="displacement of the boundary, r.m.s.")
    distance.loglog(stiffness, np.where(dataset.different > 0, dataset.different, np.nan), "s", color=style.GREEN,
                    label="fraction of cells that differ")  # fmt: skip
    line = typical[-1] * (stiffness / stiffness[-1]) ** -float(dataset.order)
    name = f"order {float(dataset.order):.3f} ± {float(dataset.order_error):.3f}"
    distance.loglog(stiffness, line, "--", color=style.GREY, label=name)
    distance.set_xlabel(style.label(dataset.contact_stiffness))
    distance.set_ylabel("Distance from the rigid drive")
    distance.set_title("(b) convergence")
    phase.legend(figure, [plane, distance], 3)
    return figure
