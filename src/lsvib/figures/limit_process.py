"""The limit process: deviations from the rigid drive over the stiffness of the contact, their orders, the rebound."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lsvib.figures import phase, style

_ERRORS = {  # colour, words, symbol
    "motion_distance": (style.BLUE, "distance in the phase plane", "o"),
    "rest_error": (style.GREEN, "time at rest / duration", "s"),
    "impulse_error": (style.ORANGE, "impulse", "^"),
    "period_error": (style.PURPLE, "period", "D"),
}
_VISCOUS, _RATIO, _ELASTIC = "viscous", "damping ratio", "elastic"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the viscous limit (a, b), its orders (c), the other limits (d), their rests (e) and their rebound (f)."""
    figure = style.new_figure(style.DOUBLE, 5.6)
    distance, errors, orders, others, rests, rebound = figure.subplots(2, 3).ravel()
    families = {name: dataset.sel(family=value) for value, name in style.flag_names(dataset.family).items()}
    viscous = families[_VISCOUS]
    _distances(distance, viscous)
    _errors(errors, viscous)
    _orders(orders, viscous)
    _others(others, families)
    _rests(rests, families)
    _rebound(rebound, families)
    for axes in (distance, errors, others, rests, rebound):
        axes.set(xscale="log", yscale="log", xlabel="Contact stiffness $k_c$ [N m⁻¹]")
        axes.set_xlim(float(dataset.contact_stiffness[0]), float(dataset.contact_stiffness[-1]))
    phase.legend(figure, [errors], 3, _handles())
    return figure


def _handles() -> list[Line2D]:
    lines = (
        (style.VERMILION, (0, (3, 1.5)), "distance under the other rule, at once"),
        (style.SKY, "-", "fixed damping ratio"),
        (style.GREY, "-", "elastic"),
    )
    return [Line2D([], [], color=colour, linestyle=dashes, label=words) for colour, dashes, words in lines]


def _lines(axes: Axes, values: xr.DataArray, colour: str, dashes="-", label: str | None = None) -> None:
    """One thin line for each branch; where an error changes its sign the line dips."""
    for k, branch in enumerate(np.abs(values.values)):
        axes.plot(values.contact_stiffness, branch, color=colour, linestyle=dashes, linewidth=0.6, alpha=0.75,
                  label=label if k == 0 else None)  # fmt: skip


def _distances(axes: Axes, viscous: xr.Dataset) -> None:
    differ = viscous.rules_differ.values == 1
    _lines(axes, viscous.motion_distance.isel(rule=0), style.BLUE)
    _lines(axes, viscous.motion_distance.isel(rule=1)[differ], style.VERMILION, (0, (3, 1.5)))
    _slope(axes, viscous, 2e-4)
    axes.set(title="(a) viscous limit: distance", ylabel="Distance to the rigid motion")


def _slope(axes: Axes, viscous: xr.Dataset, height: float) -> None:
    """A triangle of order one."""
    left, right = float(viscous.contact_stiffness[-1]) / 2000, float(viscous.contact_stiffness[-1]) / 20
    axes.plot([left, right, left], [height, height / 100, height / 100], color=style.BLACK, linewidth=0.7, zorder=3)
    axes.plot([left, left], [height, height / 100], color=style.BLACK, linewidth=0.7, zorder=3)
    axes.text(left * 1.3, height / 80, "order 1", va="bottom", fontsize=6)


def _errors(axes: Axes, viscous: xr.Dataset) -> None:
    for name, (colour, words, _) in _ERRORS.items():
        values = viscous[name].isel(rule=0) if "rule" in viscous[name].dims else viscous[name]
        values = values / viscous.rigid_duration if name == "rest_error" else values
        _lines(axes, values, colour, label=words)
    axes.set(title="(b) viscous limit: all errors", ylabel="Relative error")


def _orders(axes: Axes, viscous: xr.Dataset) -> None:
    """Fitted orders with their standard errors, branch by branch."""
    branch = np.arange(viscous.sizes["branch"]) + 1
    for name, (colour, _, symbol) in _ERRORS.items():
        order, error = viscous[f"{name}_order"], viscous[f"{name}_order_error"]
        if "rule" in order.dims:
            order, error = order.isel(rule=0), error.isel(rule=0)
        axes.errorbar(branch, order, error, color=colour, fmt=symbol, markersize=2.5, linewidth=0.6)
    axes.set(title="(c) viscous limit: orders", xlabel="Branch", ylabel="Order in $1/k_c$")


def _others(axes: Axes, families: dict[str, xr.Dataset]) -> None:
    _lines(axes, families[_ELASTIC].motion_distance.isel(rule=0), style.GREY)
    _lines(axes, families[_RATIO].motion_distance.isel(rule=0), style.SKY)
    axes.set(title="(d) other limits: distance", ylabel="Distance to the rigid motion")


def _rests(axes: Axes, families: dict[str, xr.Dataset]) -> None:
    for name, colour in ((_ELASTIC, style.GREY), (_RATIO, style.SKY), (_VISCOUS, style.BLUE)):
        impacts = families[name].impact_sign.values != 0
        rests = families[name].rests[impacts].where(families[name].rests[impacts] > 0)
        _lines(axes, rests, colour)
    axes.set(title="(e) rests after an impact", ylabel="Number of rests")


def _rebound(axes: Axes, families: dict[str, xr.Dataset]) -> None:
    for name, colour in ((_RATIO, style.SKY), (_VISCOUS, style.BLUE)):
        axes.plot(families[name].contact_stiffness, families[name].rebound_force, color=colour)
    forces = np.unique(np.abs(families[_VISCOUS].axial_force.values))
    for force in forces:
        axes.axhline(force, color=style.BLACK, linewidth=0.7, linestyle=":")
    words = " and ".join(f"{force:g}" for force in forces)
    axes.text(1.6e5, forces[-1] * 1.5, f"$|R|$ = {words} N", fontsize=6.5, va="bottom")
    axes.set(title="(f) force of the rebound", ylabel="Force [N]")
