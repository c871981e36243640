"""Stability of steady sliding with compliant threads: critical mass over the contact, growth rates, least damping."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_COLOURS = (style.VERMILION, style.ORANGE, style.BLUE, style.BLACK, style.GREEN, style.PURPLE)
_DASHES = ("-", (0, (5, 1.5)), "-", (0, (5, 1.5)), "-", (0, (5, 1.5)))  # where two lines coincide both are seen
_LINEAR = 10.0  # growth rates below this [1/s] are drawn on a linear scale
_SMALL = 6.5  # size of words within a panel [pt]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the critical mass, (b, c) the growth rate of both masses and (d) the least contact damping."""
    figure = style.new_figure(style.DOUBLE, 6.2)
    mass, heavy, light, least = figure.subplots(2, 2).ravel()
    _critical_mass(mass, dataset)
    for axes, k, letter in ((heavy, 0, "b"), (light, 1, "c")):
        _growth(axes, dataset.isel(mass=k), letter, float(dataset.critical_mass))
    _proved(heavy, dataset)
    heavy.text(0.03, 0.7, "colours as in (c)", fontsize=_SMALL, transform=heavy.transAxes)
    light.legend(loc="lower left", fontsize=_SMALL)
    _least(least, dataset)
    style.state_values(figure, dataset)
    return figure


def _critical_mass(axes: Axes, dataset: xr.Dataset) -> None:
    rigid = float(dataset.critical_mass)
    for k, (colour, dashes) in enumerate(zip(_COLOURS, _DASHES, strict=True)):
        if k < dataset.sizes["curve_contact_stiffness"]:
            curve = dataset.isel(curve_contact_stiffness=k)
            name = f"$k_c$ = {drawing.power(float(curve.curve_contact_stiffness))} N m⁻¹"
            axes.plot(
                curve.curve_contact_damping,
                curve.curve_critical_mass_with_contact,
                color=colour,
                linestyle=dashes,
                label=name,
            )
    axes.plot(dataset.contact_damping, dataset.critical_mass_with_contact, "o", color=style.PURPLE, zorder=4,
              label="contacts of Figs 8.10, 8.13")  # fmt: skip
    for damping, stiffness, value in zip(
        *(dataset[name].values for name in ("contact_damping", "contact_stiffness", "critical_mass_with_contact")),
        strict=True,
    ):
        words = f"{value:.2f} kg at $k_c$ = {drawing.power(stiffness)}"
        top = value > 0.99 * rigid  # on the line of the rigid drive: written above it
        place, side = ((8, 5), "right") if top else ((4, -9), "left")
        axes.annotate(words, (damping, value), place, textcoords="offset points", fontsize=_SMALL, ha=side)
    axes.axhline(rigid, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.annotate(f"rigid contact: {rigid:.3f} kg", (0.03, rigid), (0, -3), xycoords=axes.get_yaxis_transform(),
                  textcoords="offset points", fontsize=_SMALL, va="top", color=style.GREY)  # fmt: skip
    axes.set(
        xscale="log",
        title="(a) critical mass; steady sliding is lost above",
        xlabel=style.label(dataset.curve_contact_damping),
        ylabel="Critical mass $m_\\mathrm{cr}$ [kg]",
        ylim=(0, 1.8 * rigid),
    )
    axes.legend(loc="upper left", fontsize=_SMALL)


def _growth(axes: Axes, dataset: xr.Dataset, letter: str, rigid: float) -> None:
    for k, (colour, dashes) in enumerate(zip(_COLOURS, _DASHES, strict=True)):
        if k < dataset.sizes["growth_contact_damping"]:
            curve = dataset.isel(growth_contact_damping=k)
            name = f"$c_c$ = {drawing.power(float(curve.growth_contact_damping))} N s m⁻¹"
            axes.plot(curve.growth_contact_stiffness, curve.growth_rate, color=colour, linestyle=dashes, label=name)
    axes.axhline(0, color=style.BLACK, linewidth=0.5)
    sign = ">" if float(dataset.mass) > rigid else "<"
    axes.set_yscale("symlog", linthresh=_LINEAR)
    axes.set(
        xscale="log",
        title=f"({letter}) growth rate, $m$ = {drawing.number(dataset.mass)} kg {sign} rigid $m_\\mathrm{{cr}}$",
        xlabel=style.label(dataset.growth_contact_stiffness),
        ylabel="Largest real part [s⁻¹], stable below 0",
    )


def _proved(axes: Axes, dataset: xr.Dataset) -> None:
    """Beyond the dotted stiffnesses, one for each damping, the proof of Lemma 8.1 holds."""
    for k, value in enumerate(dataset.unstable_contact_stiffness.values):
        axes.axvline(value, color=_COLOURS[k], linewidth=0.9, linestyle=":")
    axes.set_ylim(-_LINEAR)
    axes.text(0.02, 0.03, "dotted: from here on unstable by Lemma 8.1, same colour", fontsize=_SMALL,
              transform=axes.transAxes, bbox={"facecolor": "#FFFFFF", "linewidth": 0, "pad": 0.8})  # fmt: skip


def _least(axes: Axes, dataset: xr.Dataset) -> None:
    axes.plot(dataset.growth_contact_stiffness, dataset.least_contact_damping, color=style.BLUE)
    top = 100 * float(dataset.least_contact_damping.max())
    shade = {"color": style.SKY, "alpha": 0.3, "linewidth": 0}
    axes.fill_between(dataset.growth_contact_stiffness, dataset.least_contact_damping, top, **shade)
    low, high = dataset.window_of_soft_contact.values.T
    axes.fill_between(dataset.growth_contact_stiffness, low, high, **shade)
    for end in (low, high):
        axes.plot(dataset.growth_contact_stiffness, end, color=style.BLUE)
    limit = float(dataset.least_contact_damping_of_stiff_contact)
    axes.axhline(limit, color=style.GREY, linewidth=0.9, linestyle="--")
    axes.annotate(f"stiff limit: {limit / 1e3:.2f} kN s m⁻¹", (0.97, limit), (0, -3), ha="right", va="top",
                  xycoords=axes.get_yaxis_transform(), textcoords="offset points", fontsize=_SMALL)  # fmt: skip
    axes.text(0.6, 0.92, "stable", transform=axes.transAxes, va="center")
    axes.text(0.6, 0.45, "unstable", transform=axes.transAxes, va="center")
    if np.isfinite(low).any():
        inside = 3 * float(dataset.growth_contact_stiffness[0]), np.sqrt(low[0] * high[0])
        axes.annotate("stable, too", inside, (0.28, 0.26), textcoords=axes.transAxes, va="center",
                      arrowprops={"arrowstyle": "-", "linewidth": 0.6, "color": style.BLACK})  # fmt: skip
    mass = drawing.number(dataset.mass[1])
    axes.set(
        xscale="log",
        yscale="log",
        title=f"(d) contact damping at which $m$ = {mass} kg is stable",
        xlabel=style.label(dataset.growth_contact_stiffness),
        ylabel=style.label(dataset.contact_damping),
        ylim=(None, top),
    )
