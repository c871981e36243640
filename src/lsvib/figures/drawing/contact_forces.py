"""Draw phase portraits of the contact force from the variables of ``lsvib.figures.common.contact_portraits``."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_BASIN = "#DCEBF7"
_PATCH = {"facecolor": "#FFFFFFC0", "linewidth": 0, "pad": 1.0}
_STAY, _GROW = style.BLUE, style.VERMILION
# Branches of the saddle's manifolds: unstable ones first, each to the own and to the other side.
_UNSTABLE = slice(0, 2)
_STABLE_OWN, _STABLE_OTHER = 2, 3


def portrait(dataset: xr.Dataset, force_signs: tuple[str, str], columns: int) -> Figure:
    """Draw a panel for each contact damping; ``force_signs``: left and right of χ = 0; ``columns`` of the legend."""
    figure = style.new_figure(style.DOUBLE, 3.35)
    panels = figure.subplots(1, dataset.sizes["case"], sharey=True)
    limits = [dataset[name].values[[0, -1]] for name in ("grid_contact_force", "grid_contact_force_rate")]
    for axes, letter, case in zip(panels, "ab", (dataset.isel(case=i) for i in dataset.case.values), strict=True):
        _lines(axes, case)
        motions = [case.isel(start=index) for index in dataset.start.values]
        colours = [_motion(axes, motion) for motion in motions]
        _equilibria(axes, case)
        axes.axvline(0, color=style.GREY, linewidth=0.9, zorder=1)
        damping = float(case.contact_damping_ratio)
        words = f"contact damping, $\\zeta$ = {damping:.2g}" if damping else "elastic contact"
        axes.set_title(f"({letter}) {words}", y=1.0, pad=13)  # clear of the power of ten
        axes.set(xlabel=style.label(case.contact_force), xlim=limits[0], ylim=limits[1])
        paths = [
            (m.contact_force.values, m.contact_force_rate.values, c) for m, c in zip(motions, colours, strict=True)
        ]
        drawing.draw_arrows(axes, [*paths, *_manifolds(case), (np.zeros(2), limits[1], None)])
        for x, align, text in ((-0.02, "right", force_signs[0]), (0.02, "left", force_signs[1])):
            place = (x * np.ptp(limits[0]), limits[1][0] + 0.03 * np.ptp(limits[1]))
            axes.text(*place, text, ha=align, va="bottom", bbox=_PATCH, zorder=4)
    panels[0].set_ylabel(style.label(dataset.contact_force_rate, "rate"))
    style.state_values(figure, dataset)
    drawing.legend(figure, panels, columns)
    return figure


def _lines(axes: Axes, case: xr.Dataset) -> None:
    """Draw the manifolds of the saddle and what they enclose, or the unstable one that every motion approaches."""
    if "manifold_force" in case:
        x, y = case.manifold_force.values, case.manifold_force_rate.values
        rim = [np.concatenate([z[_STABLE_OTHER], z[_STABLE_OWN][::-1]]) for z in (x, y)]
        axes.fill(*rim, color=_BASIN, linewidth=0, label="contact force stays bounded", zorder=0)
        axes.plot(x[2:].T, y[2:].T, color=style.BLACK, linewidth=1.5, zorder=2.4)
        axes.plot(x[_UNSTABLE].T, y[_UNSTABLE].T, color=style.BLACK, linewidth=1.0, linestyle=(0, (4, 2)), zorder=2.5)
        axes.plot([], [], color=style.BLACK, linewidth=1.5, label="stable manifold of the saddle")
        axes.plot([], [], color=style.BLACK, linewidth=1.0, linestyle=(0, (4, 2)), label="unstable manifold")
        return
    slope = float(case.scaled_eigenvalue_real_part.sel(law=1).max()) / float(case.force_scale)
    x = np.array([0.0, float(case.grid_contact_force[-1])])
    y = slope * (x - float(case.equilibrium_contact_force.sel(law=1)))
    axes.plot(x, y, color=style.BLACK, linewidth=1.0, linestyle=(0, (4, 2)), label="asymptote from the virtual saddle")


def _manifolds(case: xr.Dataset) -> list[drawing.DrawnLine]:
    """Return the manifolds of the saddle in the direction of time; they are stored outwards from it."""
    if "manifold_force" not in case:
        return []
    x, y = case.manifold_force.values, case.manifold_force_rate.values
    outwards = [(x[k], y[k], style.BLACK) for k in range(_STABLE_OWN)]
    return outwards + [(x[k, ::-1], y[k, ::-1], style.BLACK) for k in (_STABLE_OWN, _STABLE_OTHER)]


def _motion(axes: Axes, motion: xr.Dataset) -> str:
    """Draw a motion from its start; return its colour."""
    x, y = motion.contact_force.values, motion.contact_force_rate.values
    stays = style.flag_names(motion.start_outcome)[int(motion.start_outcome)] == "bounded"
    colour, name = (_STAY, "bounded") if stays else (_GROW, "growing without bound")
    axes.plot(x, y, color=colour, linewidth=1.0, label=name, zorder=2)
    axes.plot(
        x[0], y[0], "o", color=colour, markerfacecolor="white", markersize=3.2, label="start", zorder=3, clip_on=False
    )
    return colour


def _equilibria(axes: Axes, case: xr.Dataset) -> None:
    """Mark the equilibria; open where the law does not hold, so that they are none."""
    for law, marker, inverse in ((1, "X", r"1/\Gamma_+"), (-1, "D", r"1/\Gamma_-")):
        x = float(case.equilibrium_contact_force.sel(law=law))
        real = x * float(case.law_side.sel(law=law)) > 0
        kind = "saddle" if law > 0 else "centre or focus"
        name = f"{kind} ${inverse}$" + ("" if real else ", virtual")
        axes.plot(
            x,
            0,
            marker,
            color=style.GREEN,
            markerfacecolor=style.GREEN if real else "white",
            markersize=6,
            linestyle="none",
            label=name,
            zorder=5,
        )
