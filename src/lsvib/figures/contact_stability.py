"""Stability of steady sliding with compliant threads: critical mass over the contact, growth rates, least damping."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_COLOURS = (style.VERMILION, style.ORANGE, style.BLUE, style.BLACK, style.GREEN, style.PURPLE)
_LINEAR = 10.0  # growth rates below this [1/s] are drawn on a linear scale


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the critical mass, (b, c) the growth rate of both masses and (d) the least contact damping."""
    figure = style.new_figure(style.DOUBLE, 5.6)
    mass, heavy, light, least = figure.subplots(2, 2).ravel()
    _critical_mass(mass, dataset)
    for axes, k, letter in ((heavy, 0, "b"), (light, 1, "c")):
        _growth(axes, dataset.isel(mass=k), letter, float(dataset.critical_mass))
    for k, value in enumerate(dataset.unstable_contact_stiffness.values):
        heavy.axvline(value, color=_COLOURS[k], linewidth=0.6, linestyle=":")
    _least(least, dataset)
    mass.legend(loc="upper left", fontsize=6.5)
    heavy.legend(loc="lower right", fontsize=6.5)
    heavy.set_ylim(-_LINEAR)
    return figure


def _power(value: float) -> str:
    exponent = np.log10(value) if value else 0.0
    return f"$10^{{{exponent:.0f}}}$" if value and np.isclose(exponent, round(exponent)) else phase.number(value)


def _critical_mass(axes: Axes, dataset: xr.Dataset) -> None:
    rigid = float(dataset.critical_mass)
    for k, colour in zip(range(dataset.sizes["curve_contact_stiffness"]), _COLOURS, strict=False):
        curve = dataset.isel(curve_contact_stiffness=k)
        name = f"$k_c$ = {_power(float(curve.curve_contact_stiffness))} N m⁻¹"
        axes.plot(curve.curve_contact_damping, curve.curve_critical_mass, color=colour, label=name)
    axes.plot(dataset.contact_damping, dataset.critical_mass_with_contact, "o", color=style.PURPLE, zorder=4,
              label="contacts of Figs 8.10, 8.13")  # fmt: skip
    for damping, stiffness, value in zip(
        *(dataset[name].values for name in ("contact_damping", "contact_stiffness", "critical_mass_with_contact")),
        strict=True,
    ):
        words = f"{value:.2f} kg at $k_c$ = {_power(stiffness)}"
        top = value > 0.99 * rigid  # on the line of the rigid drive: written above it
        place, side = ((0, 5), "center") if top else ((4, -9), "left")
        axes.annotate(words, (damping, value), place, textcoords="offset points", fontsize=6, ha=side)
    axes.axhline(rigid, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.text(1.5, rigid, f"rigid: {rigid:.3f} kg", fontsize=6.5, va="top", color=style.GREY)
    axes.set(
        xscale="log",
        title="(a) critical mass; steady sliding is lost above",
        xlabel=style.label(dataset.curve_contact_damping),
        ylabel="Critical mass $m_\\mathrm{cr}$ [kg]",
        ylim=(0, 1.75 * rigid),
    )


def _growth(axes: Axes, dataset: xr.Dataset, letter: str, rigid: float) -> None:
    for k, colour in zip(range(dataset.sizes["growth_contact_damping"]), _COLOURS, strict=False):
        curve = dataset.isel(growth_contact_damping=k)
        axes.plot(curve.growth_contact_stiffness, curve.growth_rate, color=colour,
                  label=f"$c_c$ = {_power(float(curve.growth_contact_damping))} N s m⁻¹")  # fmt: skip
    axes.axhline(0, color=style.BLACK, linewidth=0.5)
    sign = ">" if float(dataset.mass) > rigid else "<"
    axes.set_yscale("symlog", linthresh=_LINEAR)
    axes.set(
        xscale="log",
        title=f"({letter}) growth rate, $m$ = {phase.number(dataset.mass)} kg {sign} rigid $m_\\mathrm{{cr}}$",
        xlabel=style.label(dataset.growth_contact_stiffness),
        ylabel="Largest real part [s⁻¹]",
    )


def _least(axes: Axes, dataset: xr.Dataset) -> None:
    axes.plot(dataset.growth_contact_stiffness, dataset.least_contact_damping, color=style.BLUE)
    axes.fill_between(
        dataset.growth_contact_stiffness,
        dataset.least_contact_damping,
        axes.get_ylim()[1] * 3,
        color=style.SKY,
        alpha=0.3,
    )
    axes.fill_between(
        dataset.growth_contact_stiffness, *dataset.window_of_soft_contact.values.T, color=style.SKY, alpha=0.3
    )
    limit = float(dataset.least_contact_damping_of_stiff_contact)
    axes.axhline(limit, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.text(
        float(dataset.growth_contact_stiffness[0]) * 2,
        limit,
        f"stiff limit: {limit:.4g} N s m⁻¹",
        fontsize=6.5,
        va="top",
    )
    axes.text(0.6, 0.92, "stable", transform=axes.transAxes, fontsize=7)
    axes.text(0.05, 0.35, "stable, too", transform=axes.transAxes, fontsize=7)
    mass = phase.number(dataset.mass[1])
    axes.set(
        xscale="log",
        yscale="log",
        title=f"(d) least contact damping, $m$ = {mass} kg",
        xlabel=style.label(dataset.growth_contact_stiffness),
        ylabel="Least contact damping [N s m⁻¹]",
    )
