"""The basin of steady sliding: three kinds of boundary, and its size along four sweeps."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_KINDS = {  # what bounds the basin: colour, words
    "none": (style.BLACK, "no boundary: globally stable"),
    "touching motion": (style.BLUE, "bounded by the motion that touches $N = 0$, and $N = 0$"),
    "touching slip": (style.ORANGE, "by the slip from $\\dot\\theta = 0$ that touches $N = 0$"),
    "cycle": (style.PURPLE, "by a cycle that repels"),
}
_PALE = "#CFE3F1"
_SWEEPS = {
    "axial_force": "axial force",
    "support_damping": "support damping",
    "mass": "mass",
    "friction_coefficient": "friction",
}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the basins of the cases above, and the fraction of the window that belongs to the basin below."""
    figure = style.new_figure(style.DOUBLE, 5.4)
    rows = figure.subfigures(2, 1, height_ratios=(1.15, 1))
    above = rows[0].subplots(1, dataset.sizes["case"])
    for index, axes in enumerate(np.atleast_1d(above)):
        _basin(axes, dataset.isel(case=index), "abc"[index])
    below = rows[1].subplots(1, len(_SWEEPS), sharey=True)
    for index, (axes, name) in enumerate(zip(below, _SWEEPS, strict=True)):
        _sweep(axes, dataset, name, "defg"[index])
    rows[0].legend(*_entries(above), loc="outside upper center", ncols=4)
    rows[1].legend(*_entries(below), loc="outside upper center", ncols=2)
    return figure


def _entries(panels) -> tuple[list, list]:
    entries = {}
    for panel in np.atleast_1d(panels):
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    return list(entries.values()), list(entries.keys())


def _basin(axes: Axes, case: xr.Dataset, letter: str) -> None:
    """Shade the basin of one case, draw its boundary, N = 0 and θ′ = 0."""
    kind = style.flag_names(case.case_boundary_kind)[int(case.case_boundary_kind)]
    region = np.column_stack([case.region_angle, case.region_velocity])
    for part in np.split(region, np.flatnonzero(np.isnan(region[:, 0]))):
        part = part[np.isfinite(part[:, 0])]
        if len(part):
            axes.fill(part[:, 0], part[:, 1], color=_PALE, label="basin of steady sliding", zorder=0.5)
    axes.plot(
        case.boundary_angle,
        case.boundary_velocity,
        color=_KINDS[kind][0],
        linewidth=1.8,
        label="exact boundary (colours below)",
        zorder=2,
    )
    phase.mark_origin(axes)
    axes.set(xlim=case.case_angle.values, ylim=case.case_velocity.values)
    phase.draw_lines(axes, case)
    axes.set_xlabel(style.label(case.boundary_angle, "deviation"))
    axes.set_ylabel(style.label(case.boundary_velocity, "rate"), labelpad=1)
    axes.locator_params(nbins=5)
    damping = f"$c$ = {phase.number(case.case_support_damping)} {style.unit(case.case_support_damping.units)[1:-1]}"
    axes.set_title(f"({letter}) $R$ = {phase.number(case.case_axial_force)} N,\n{damping}", fontsize=7)
    starts = int(case.resolution[-1])
    axes.text(
        0.97,
        0.96,
        f"{100 * float(case.case_fraction):.2f} % of the panel\n"
        f"{100 * float(case.grid_fraction[-1]):.2f} % of starts\n({starts} × {starts})",
        transform=axes.transAxes,
        horizontalalignment="right",
        verticalalignment="top",
        fontsize=6,
    )


def _sweep(axes: Axes, dataset: xr.Dataset, name: str, letter: str) -> None:
    """Draw the fraction over one parameter, coloured by what bounds the basin."""
    values, fraction = dataset[f"swept_{name}"].values, dataset[f"fraction_{name}"].values
    kinds = dataset[f"boundary_kind_{name}"]
    for index, word in style.flag_names(kinds).items():
        colour, words = _KINDS[word]
        here = np.where(kinds.values == index, fraction, np.nan)
        axes.plot(values, here, color=colour, linewidth=1.8, label=words)
    changes = np.flatnonzero(np.diff(kinds.values))
    for k in changes:
        axes.plot(values[k : k + 2], fraction[k : k + 2], color=style.GREY, linewidth=0.8, linestyle=":")
    axes.axvline(float(dataset[name]), color=style.GREY, linewidth=0.8, linestyle=(0, (5, 2)))
    if name == "axial_force":
        axes.axvline(
            float(dataset.global_stability_force),
            color=style.VERMILION,
            linewidth=0.9,
            linestyle=(0, (2, 1.5)),
            label="force of global stability, a root",
        )
    label = style.label(dataset[f"swept_{name}"], " ").strip()
    if name == "support_damping":
        axes.xaxis.set_major_formatter(lambda value, _: f"{1e3 * value:g}")
        label = label.replace("[", "[10⁻³ ")
    axes.set(yscale="log", title=f"({letter}) {_SWEEPS[name]}", xlabel=label)
    axes.margins(x=0)
    axes.set_ylim(None, 1.6)
    if letter == "d":
        axes.set_ylabel("Fraction of the window")
