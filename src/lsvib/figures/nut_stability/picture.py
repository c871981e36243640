"""Rotating nut: critical mass against the inertia of the nut, and the stability map."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import drawing, style

_KINEMATIC = "#F7D9C4"
_MARKS = 12  # masses by eigenvalues that are marked along the curve
_SMALL = 6.5  # size of words within a panel [pt]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the critical mass over the inertia of the nut and (b) the classes over that and the friction."""
    figure = style.new_figure(style.DOUBLE, 3.5)
    mass, plane = figure.subplots(1, 2)
    _critical_mass(mass, dataset)
    patches = _map(plane, dataset)
    style.state_values(figure, dataset)
    drawing.legend(figure, [mass, plane], 4, patches)
    return figure


def _critical_mass(axes: Axes, dataset: xr.Dataset) -> None:
    rigid = float(dataset.critical_mass)
    axes.plot(dataset.nut_inertia, dataset.critical_mass_with_nut, color=style.BLUE, label="boundary by (8.33)")
    some = dataset.isel(nut_inertia=np.linspace(0, dataset.sizes["nut_inertia"] - 1, _MARKS).astype(int))
    axes.plot(some.nut_inertia, some.critical_mass_with_nut_by_eigenvalues, "o", color=style.VERMILION, zorder=3,
              label="by eigenvalues", clip_on=False)  # fmt: skip
    axes.fill_between(dataset.nut_inertia, dataset.critical_mass_with_nut, 1.15 * rigid, color=_KINEMATIC, linewidth=0)
    axes.axhline(rigid, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.annotate(f"nut that cannot turn: {rigid:.3f} kg", (0.03, rigid), (0, 3), color="#505050", fontsize=_SMALL,
                  xycoords=axes.get_yaxis_transform(), textcoords="offset points")  # fmt: skip
    axes.axvline(float(dataset.screw_inertia), 0, 0.82, color=style.BLACK, linewidth=0.6, linestyle=":")
    axes.text(float(dataset.screw_inertia), 0.06, " $I_2 = I$", fontsize=_SMALL, transform=axes.get_xaxis_transform())
    axes.set(
        xscale="log",
        title=rf"(a) critical mass, $\mu$ = {drawing.number(dataset.drawn_friction_coefficient)}",
        xlabel=style.label(dataset.nut_inertia),
        ylabel="Critical mass $m_\\mathrm{cr}$ [kg]",
        ylim=(0, 1.15 * rigid),
        xlim=(float(dataset.nut_inertia[0]), float(dataset.nut_inertia[-1])),
    )


def _map(axes: Axes, dataset: xr.Dataset) -> list[Patch]:
    kinematic = (dataset.stability == drawing.code(dataset.stability, "kinematic constraint")).T
    colours = ListedColormap(["#FFFFFF", _KINEMATIC])
    axes.pcolormesh(dataset.friction_coefficient, dataset.nut_inertia, kinematic, cmap=colours, rasterized=True)
    axes.plot(dataset.critical_friction_with_nut, dataset.nut_inertia, color=style.BLUE)
    tangent = float(np.tan(dataset.lead_angle))
    axes.axvline(tangent, color=style.BLACK, linewidth=0.6, linestyle=":")
    axes.text(tangent, 0.94, r"$\mu = \tan\lambda$ ", fontsize=_SMALL, ha="right", va="top",
              transform=axes.get_xaxis_transform())  # fmt: skip
    drawn = float(dataset.drawn_friction_coefficient)
    axes.axvline(drawn, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.text(drawn, 0.94, rf" {drawn:g} of (a)", color="#505050", fontsize=_SMALL, va="top",
              transform=axes.get_xaxis_transform())  # fmt: skip
    axes.set(
        yscale="log",
        title=f"(b) classes, $m$ = {drawing.number(dataset.mass)} kg",
        xlabel=style.label(dataset.friction_coefficient),
        ylabel=style.label(dataset.nut_inertia),
        xlim=(float(dataset.friction_coefficient[0]), float(dataset.friction_coefficient[-1])),
        ylim=(float(dataset.nut_inertia[0]), float(dataset.nut_inertia[-1])),
    )
    edge = {"edgecolor": style.GREY, "linewidth": 0.5}
    return [
        Patch(facecolor=_KINEMATIC, label="unstable: kinematic constraint", **edge),
        Patch(facecolor="#FFFFFF", label="stable", **edge),
    ]
