"""The limit process: deviations from the rigid drive on every branch, their orders, and the other limits."""

from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_ERRORS = {  # colour, words, mark
    "motion_distance": (style.BLUE, "distance", "o"),
    "rest_error": (style.GREEN, "time at rest", "s"),
    "impulse_error": (style.ORANGE, "impulse", "^"),
    "period_error": (style.PURPLE, "period", "D"),
}
_VISCOUS, _RATIO, _ELASTIC = "viscous", "damping ratio", "elastic"
_FAMILIES = {_VISCOUS: (style.BLUE, "o"), _RATIO: (style.SKY, "s"), _ELASTIC: (style.GREY, "D")}
_AT_ONCE = style.VERMILION
_SMALL = 6.5  # size of words within a panel [pt]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the viscous limit, (b) its orders and (c) the others branch by branch; (d) to (f) over the stiffness."""
    figure = style.new_figure(style.DOUBLE, 8.6)
    branches, curves = figure.subfigures(2, 1, height_ratios=(2.7, 1))
    distance, orders, others = branches.subplots(3, 1, sharex=True, height_ratios=(1.4, 1, 1))
    errors, rests, rebound = curves.subplots(1, 3)
    families = {name: dataset.sel(family=value) for value, name in style.flag_names(dataset.family).items()}
    _distances(distance, families[_VISCOUS])
    _orders(orders, families[_VISCOUS])
    _others(others, families)
    for axes in (distance, orders, others):
        _separate(axes, dataset)
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=_SMALL, handletextpad=0.3)
    _name_branches(others, distance, dataset)
    _errors(errors, families[_VISCOUS])
    _rests(rests, families)
    _rebound(rebound, families)
    for axes in (errors, rests, rebound):
        axes.set(xscale="log", yscale="log", xlabel="Contact stiffness $k_c$ [N m⁻¹]")
        axes.set_xlim(float(dataset.contact_stiffness[0]), float(dataset.contact_stiffness[-1]))
    style.state_values(figure, dataset)
    return figure


def _places(dataset: xr.Dataset) -> np.ndarray:
    return np.arange(dataset.sizes["branch"])


def _distances(axes: Axes, viscous: xr.Dataset) -> None:
    """A column for each branch: the softest contact on top, the stiffest below; crosses where the rules differ."""
    count = viscous.sizes["contact_stiffness"]
    for k in range(count):
        shade = 0.85 * (1 - k / max(1, count - 1))  # paler the softer
        colour = tuple(shade + (1 - shade) * part for part in (0.0, 0.447, 0.698))
        stiffness = drawing.number(viscous.contact_stiffness[k])
        axes.plot(_places(viscous), viscous.motion_distance[:, k, 0], "o", color=colour, markeredgecolor=style.BLUE,
                  markeredgewidth=0.4, markersize=3.2, label=f"$k_c$ = {stiffness} N m⁻¹")  # fmt: skip
    differ = viscous.rules_differ.values == 1
    axes.plot(_places(viscous)[differ], viscous.motion_distance[:, -1, 1][differ], "x", color=_AT_ONCE, markersize=4.5,
              label="stiffest contact against\nthe other rule, at once")  # fmt: skip
    axes.set(yscale="log", ylabel="Distance to the\nrigid motion")
    axes.set_title("(a) viscous limit, each column a branch", pad=14)


def _orders(axes: Axes, viscous: xr.Dataset) -> None:
    """Fitted orders with their standard errors, branch by branch."""
    for k, (name, (colour, words, mark)) in enumerate(_ERRORS.items()):
        order, error = viscous[f"{name}_order"], viscous[f"{name}_order_error"]
        if "rule" in order.dims:
            order, error = order.isel(rule=0), error.isel(rule=0)
        axes.errorbar(_places(viscous) + 0.18 * (k - 1.5), order, error, color=colour, fmt=mark, markersize=2.5,
                      linewidth=0.6, label=words)  # fmt: skip
    axes.set(title="(b) viscous limit, fitted orders", ylabel="Order in $1/k_c$")


def _others(axes: Axes, families: dict[str, xr.Dataset]) -> None:
    """Distances at the stiffest contact in the three families."""
    for name, (colour, mark) in _FAMILIES.items():
        words = {_VISCOUS: "viscous", _RATIO: "fixed damping ratio", _ELASTIC: "elastic"}[name]
        axes.plot(_places(families[name]), families[name].motion_distance[:, -1, 0], mark, color=colour, markersize=3.2,
                  label=words)  # fmt: skip
    stiffest = drawing.number(families[_VISCOUS].contact_stiffness[-1])
    axes.set(
        yscale="log", title=f"(c) three limits at $k_c$ = {stiffest} N m⁻¹", ylabel="Distance to the\nrigid motion"
    )


def _separate(axes: Axes, dataset: xr.Dataset) -> None:
    """Thin lines between the drives."""
    for place in _changes(dataset)[1:-1]:
        axes.axvline(place - 0.5, color=style.GREY, linewidth=0.6)
    axes.set_xlim(-0.7, dataset.sizes["branch"] - 0.3)
    axes.tick_params(axis="x", length=0)
    axes.grid(axis="x", linewidth=0.3, color="#D8D8D8")
    axes.set_axisbelow(True)


def _changes(dataset: xr.Dataset) -> list[int]:
    """First branch of each drive, and the number of branches."""
    drive = np.stack([dataset.axial_force.values, dataset.support_damping.values])
    return [0, *(np.flatnonzero((np.diff(drive, axis=1) != 0).any(axis=0)) + 1).tolist(), dataset.sizes["branch"]]


def _name_branches(bottom: Axes, top: Axes, dataset: xr.Dataset) -> None:
    """Sign of the impact and number of the region below each column, the drive above each group of columns."""
    signs = {1: "+", -1: "−", 0: ""}
    names = [
        f"{signs[int(sign)]}{int(region)}" if sign else "cyc."
        for sign, region in zip(dataset.impact_sign.values, dataset.region.values, strict=True)
    ]
    bottom.set_xticks(_places(dataset), names, fontsize=_SMALL, rotation=90)
    bottom.set_xlabel(
        "Branch: sign of $N$ in the impact; torque after it 1 above the band of rest, 2 in it with $Q < 0$, "
        "3 with $Q > 0$, 4 below it; cycle",
        fontsize=_SMALL,
    )
    first = _changes(dataset)
    for start, stop in pairwise(first):
        force, damping = (drawing.number(dataset[name][start]) for name in ("axial_force", "support_damping"))
        top.text((start + stop - 1) / 2, 1.02, f"$R$ = {force} N, $c$ = {damping}", ha="center", va="bottom",
                 fontsize=_SMALL, transform=top.get_xaxis_transform())  # fmt: skip


def _errors(axes: Axes, viscous: xr.Dataset) -> None:
    """Range over the branches of each error."""
    for name, (colour, _, mark) in _ERRORS.items():
        values = np.abs(viscous[name].isel(rule=0) if "rule" in viscous[name].dims else viscous[name])
        values = values / viscous.rigid_duration if name == "rest_error" else values
        values = values.where(values > 0).transpose("branch", "contact_stiffness")
        low, middle, high = (getattr(values, part)("branch", skipna=True) for part in ("min", "median", "max"))
        axes.fill_between(viscous.contact_stiffness, low, high, color=colour, alpha=0.18, linewidth=0)
        axes.plot(viscous.contact_stiffness, middle, mark + "-", color=colour, linewidth=1.0, markersize=2.5)
    _slope(axes, viscous)
    axes.set(title="(d) viscous limit: median, range", ylabel="Relative error")
    axes.text(0.04, 0.04, "colours and marks of (b)", fontsize=_SMALL, transform=axes.transAxes)


def _slope(axes: Axes, viscous: xr.Dataset) -> None:
    """A triangle of order one."""
    right = float(viscous.contact_stiffness[-1]) / 2
    left, top = right / 100, 1.0
    axes.plot([left, right, right, left], [top, top, top / 100, top], color=style.BLACK, linewidth=0.7, zorder=3)
    axes.text(right / 1.5, top / 1.6, "order 1", ha="right", va="top", fontsize=_SMALL)


def _rests(axes: Axes, families: dict[str, xr.Dataset]) -> None:
    """Range over the branches of the number of rests after an impact."""
    for name, (colour, mark) in reversed(_FAMILIES.items()):
        impacts = families[name].impact_sign.values != 0
        rests = families[name].rests[impacts]
        rests = rests.where(rests > 0)
        ends = [getattr(rests, part)("branch", skipna=True) for part in ("min", "max")]
        stiffness = families[name].contact_stiffness
        axes.fill_between(stiffness, *ends, color=colour, alpha=0.18, linewidth=0)
        for end in ends:
            axes.plot(stiffness, end, mark + "-", color=colour, linewidth=0.8, markersize=2.5)
    axes.set(title="(e) rests after an impact: range", ylabel="Number of rests")


def _rebound(axes: Axes, families: dict[str, xr.Dataset]) -> None:
    for name in (_RATIO, _VISCOUS):
        colour, mark = _FAMILIES[name]
        axes.plot(
            families[name].contact_stiffness, families[name].rebound_force, mark + "-", color=colour, markersize=2.5
        )
    forces = np.unique(np.abs(families[_VISCOUS].axial_force.values))
    for force in forces:
        axes.axhline(force, color=style.BLACK, linewidth=0.7, linestyle=":")
    words = " and ".join(f"{force:g}" for force in forces)
    axes.annotate(f"$|R|$ = {words} N", (0.03, forces[-1]), (0, 3), xycoords=axes.get_yaxis_transform(),
                  textcoords="offset points", fontsize=_SMALL)  # fmt: skip
    axes.set(title="(f) force of the rebound", ylabel="Force [N]")
