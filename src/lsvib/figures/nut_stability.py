"""Rotating nut: critical mass against the inertia of the nut, and the stability map."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import phase, style

_KINEMATIC = "#F7D9C4"
_MARKS = 12  # masses by eigenvalues that are marked along the curve


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the critical mass over the inertia of the nut and (b) the classes over that and the friction."""
    figure = style.new_figure(style.DOUBLE, 3.3)
    mass, plane = figure.subplots(1, 2)
    _critical_mass(mass, dataset)
    patches = _map(plane, dataset)
    phase.legend(figure, [mass, plane], 3, patches)
    return figure


def _critical_mass(axes: Axes, dataset: xr.Dataset) -> None:
    rigid = float(dataset.critical_mass)
    axes.plot(dataset.nut_inertia, dataset.critical_mass_with_nut, color=style.BLUE, label="(8.33)")
    some = dataset.isel(nut_inertia=np.linspace(0, dataset.sizes["nut_inertia"] - 1, _MARKS).astype(int))
    axes.plot(
        some.nut_inertia, some.critical_mass_with_nut_by_eigenvalues, "o", color=style.VERMILION, label="by eigenvalues"
    )
    axes.axhline(rigid, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.text(float(dataset.nut_inertia[0]) * 1.3, rigid, f"rigid: {rigid:.3f} kg", color=style.GREY, fontsize=6.5,
              va="bottom")  # fmt: skip
    axes.axvline(float(dataset.screw_inertia), color=style.BLACK, linewidth=0.6, linestyle=":")
    axes.text(float(dataset.screw_inertia), 0.04, " $I_2 = I$", fontsize=6.5, transform=axes.get_xaxis_transform())
    axes.set(
        xscale="log",
        title=rf"(a) critical mass, $\mu$ = {phase.number(dataset.drawn_friction_coefficient)}",
        xlabel=style.label(dataset.nut_inertia),
        ylabel="Critical mass $m_\\mathrm{cr}$ [kg]",
        ylim=(0, 1.15 * rigid),
    )


def _map(axes: Axes, dataset: xr.Dataset) -> list[Patch]:
    codes = {name: value for value, name in style.flag_names(dataset.stability).items()}
    kinematic = (dataset.stability == codes["kinematic"]).T
    colours = ListedColormap(["#FFFFFF", _KINEMATIC])
    axes.pcolormesh(dataset.friction_coefficient, dataset.nut_inertia, kinematic, cmap=colours, rasterized=True)
    axes.plot(dataset.friction_coefficient, dataset.boundary_nut_inertia, color=style.BLUE)
    tangent = float(np.tan(dataset.lead_angle))
    axes.axvline(tangent, color=style.BLACK, linewidth=0.6, linestyle=":")
    axes.text(tangent, 0.92, r"$\tan\lambda$ ", fontsize=6.5, ha="right", transform=axes.get_xaxis_transform())
    axes.set(
        yscale="log",
        title=f"(b) classes, $m$ = {phase.number(dataset.mass)} kg",
        xlabel=style.label(dataset.friction_coefficient),
        ylabel=style.label(dataset.nut_inertia),
        ylim=(float(dataset.nut_inertia[0]), float(dataset.nut_inertia[-1])),
    )
    edge = {"edgecolor": style.GREY, "linewidth": 0.5}
    return [
        Patch(facecolor=_KINEMATIC, label="kinematic constraint", **edge),
        Patch(facecolor="#FFFFFF", label="stable", **edge),
    ]
