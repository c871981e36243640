"""How far the rounding of Table 8.1 explains the distances between printed and computed thresholds."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_SYMBOLS = {
    "pitch radius": ("$r_m$", style.BLUE),
    "lead angle deg": ("$\\lambda$", style.SKY),
    "screw inertia": ("$I$", style.GREEN),
    "friction coefficient": ("$\\mu$", style.PURPLE),
    "coupling stiffness": ("$k$", style.YELLOW),
    "support damping": ("$c$", style.ORANGE),
    "input speed": ("$\\Omega$", style.GREY),
}
_DIGITS = 5  # of a computed threshold


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the distance from print of each threshold over stacked bars of what half a unit of each value changes."""
    figure = style.new_figure(style.DOUBLE, 3.4)
    panels = figure.subplots(1, 2, sharey=True)
    names = list(style.flag_names(dataset.threshold).values())
    parameters = {name: value for value, name in style.flag_names(dataset.parameter).items()}
    place = np.arange(len(names))[::-1]
    titles = ("(a) rounding of the values with three digits", "(b) of those with one or two")
    edge = {"edgecolor": style.BLACK, "linewidth": 0.5}
    for axes, digits, words in zip(panels, (0, 1), titles, strict=True):
        width = 100 * dataset.print_half_unit.values
        axes.barh(place, width, color="#FFFFFF", hatch="....", label="half a unit of the threshold itself", **edge)
        for name, (symbol, colour) in _SYMBOLS.items():
            column = dataset.sel(parameter=parameters[name])
            if int(column.one_digit) != digits:
                continue
            change = 100 * np.abs(column.relative_change.values)
            axes.barh(place, change, left=width, color=colour, label=f"of {symbol}", **edge)
            width = width + change
        residual = 100 * np.abs(dataset.print_residual.values)
        axes.plot(residual, place, "D", color=style.VERMILION, markersize=5, markeredgecolor="#FFFFFF",
                  markeredgewidth=0.6, label="size of printed less computed", clip_on=False, zorder=3)  # fmt: skip
        axes.set(title=words, xlabel="Part of the threshold [%]", xlim=(0, 1.08 * max(residual.max(), width.max())))
        axes.tick_params(axis="y", length=0)
    panels[0].set_yticks(place, [_words(dataset, name) for name in names])
    drawing.legend(figure, list(panels), 5)
    return figure


def _words(dataset: xr.Dataset, name: str) -> str:
    """Name of a threshold with its printed and its computed value."""
    printed, computed = (dataset[f"{kind}_{name.replace(' ', '_')}"] for kind in ("printed", "computed"))
    unit = style.unit(computed.attrs["units"]).strip("[]")
    digits = _decimals(dataset, name)
    return f"{name}\n{float(printed):.{digits}f} {unit} ({float(computed):.{_DIGITS}g})"


def _decimals(dataset: xr.Dataset, name: str) -> int:
    """Decimals that a threshold is printed with, by half a unit of its last digit."""
    value = next(k for k, word in style.flag_names(dataset.threshold).items() if word == name)
    computed = float(dataset[f"computed_{name.replace(' ', '_')}"])
    half = float(dataset.print_half_unit.sel(threshold=value)) * computed
    return max(0, round(-np.log10(2 * half)))
