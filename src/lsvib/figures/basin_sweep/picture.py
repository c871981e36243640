"""The basin of steady sliding: three kinds of boundary, and its size along four sweeps."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_KINDS = {  # what bounds the basin: colour, words
    "none": (style.BLACK, "no boundary: globally stable"),
    "touching motion": (style.BLUE, "bounded by the motion that touches $N = 0$, and by $N = 0$"),
    "touching slip": (style.ORANGE, "bounded by the slip from $\\dot\\theta = 0$ that touches $N = 0$"),
    "cycle": (style.PURPLE, "bounded by a cycle that repels"),
}
_PALE = "#CFE3F1"
_THRESHOLDS = {  # symbol, variable, decimals
    "axial_force": ("$R$", "global_stability_force", 2),
    "support_damping": ("$10^3\\,c$", "", 3),
    "mass": ("$m_\\mathrm{cr}$", "critical_mass", 3),
    "friction_coefficient": ("$\\mu_\\mathrm{cr}$", "critical_friction_of_rigid_drive", 4),
}
_SWEEPS = {
    "axial_force": "axial force",
    "support_damping": "support damping",
    "mass": "mass",
    "friction_coefficient": "friction",
}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the basins of the cases above, and the fraction of the window that belongs to the basin below."""
    figure = style.new_figure(style.DOUBLE, 6.0)
    rows = figure.subfigures(2, 1, height_ratios=(1.0, 1.05))
    above = rows[0].subplots(1, dataset.sizes["case"])
    for index, axes in enumerate(np.atleast_1d(above)):
        _basin(axes, dataset.isel(case=index), "abc"[index])
    below = rows[1].subplots(1, len(_SWEEPS), sharey=True)
    for index, (axes, name) in enumerate(zip(below, _SWEEPS, strict=True)):
        _sweep(axes, dataset, name, "defg"[index])
    drawing.legend(rows[0], np.atleast_1d(above), 4)
    drawing.legend(rows[1], below, 2)
    style.state_values(figure, dataset)
    return figure


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
        label="exact boundary, colours as below",
        zorder=2,
    )
    drawing.mark_origin(axes)
    axes.set(xlim=case.case_angle.values, ylim=case.case_velocity.values)
    drawing.draw_lines(axes, case)
    axes.set_xlabel(style.label(case.boundary_angle, "deviation"))
    axes.set_ylabel(style.label(case.boundary_velocity, "rate"), labelpad=1)
    axes.locator_params(nbins=5)
    damping = f"$c$ = {drawing.number(case.case_support_damping)} {style.unit(case.case_support_damping.units)[1:-1]}"
    axes.set_title(f"({letter}) $R$ = {drawing.number(case.case_axial_force)} N,\n{damping}", fontsize=7)
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
        axes.plot(values[k : k + 2], fraction[k : k + 2], color=style.GREY, linewidth=0.8, linestyle=":",
                  label="jump of the fraction")  # fmt: skip
    axes.axvline(float(dataset[name]), color=style.GREY, linewidth=0.9, linestyle=(0, (5, 2)), label="drive of (a)")
    label = style.label(dataset[f"swept_{name}"], " ").strip()
    scale = 1.0
    if name == "support_damping":
        scale = 1e3
        axes.xaxis.set_major_formatter(lambda value, _: f"{scale * value:g}")
        label = label.replace("[", "[10⁻³ ")
    axes.set(yscale="log", title=f"({letter}) {_SWEEPS[name]}", xlabel=label)
    axes.margins(x=0)
    axes.set_ylim(None, 1.6)
    _threshold(axes, dataset, name, scale)
    if letter == "d":
        axes.set_ylabel("Fraction of the window")


def _threshold(axes: Axes, dataset: xr.Dataset, name: str, scale: float) -> None:
    """Mark where global stability begins or ends: a root in closed form, over the damping the change of the basin."""
    symbol, known, digits = _THRESHOLDS[name]
    if known:
        place = float(dataset[known])
    else:
        kinds = dataset[f"boundary_kind_{name}"]
        stable = kinds.values == drawing.code(kinds, "none")
        place = float(dataset[f"swept_{name}"].values[stable].min(initial=np.inf))
    if not axes.get_xlim()[0] <= place <= axes.get_xlim()[1]:
        return
    axes.axvline(
        place, color=style.VERMILION, linewidth=0.9, linestyle=(0, (2, 1.5)), label="limit of global stability"
    )
    value = f"{scale * place:.{digits}f}".replace("-", "−")
    left, right = axes.get_xlim()
    own = float(dataset[name])
    beside = max(place, own) if abs(own - place) < 0.2 * (right - left) else place  # right of both lines if close
    late = beside > 0.5 * (left + right)
    axes.text(beside, 0.06, f" {symbol} = {value} ", color=style.VERMILION, fontsize=6.5, va="bottom",
              ha="right" if late else "left", transform=axes.get_xaxis_transform())  # fmt: skip
