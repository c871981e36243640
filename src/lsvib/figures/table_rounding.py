"""How far the rounding of Table 8.1 explains the distances between printed and computed thresholds."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_SYMBOLS = {
    "pitch radius": ("$r_m$", style.BLUE),
    "lead angle deg": ("$\\lambda$", style.SKY),
    "screw inertia": ("$I$", style.GREEN),
    "friction coefficient": ("$\\mu$", style.PURPLE),
    "coupling stiffness": ("$k$", style.YELLOW),
    "support damping": ("$c$", style.ORANGE),
    "input speed": ("$\\Omega$", style.GREY),
}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the distance from print of each threshold over stacked bars of what half a unit of each value changes."""
    figure = style.new_figure(style.DOUBLE, 3.0)
    panels = figure.subplots(1, 2, sharey=True)
    names = list(style.flag_names(dataset.threshold).values())
    parameters = {name: value for value, name in style.flag_names(dataset.parameter).items()}
    place = np.arange(len(names))[::-1]
    for axes, digits, words in zip(panels, (0, 1), ("(a) three digits", "(b) one or two digits"), strict=True):
        width = 100 * dataset.print_half_unit.values
        axes.barh(place, width, color="#FFFFFF", edgecolor=style.BLACK, linewidth=0.5, hatch="....", label="own print")
        for name, (symbol, colour) in _SYMBOLS.items():
            column = dataset.sel(parameter=parameters[name])
            if int(column.one_digit) != digits:
                continue
            change = 100 * np.abs(column.relative_change.values)
            axes.barh(place, change, left=width, color=colour, label=f"half a unit of {symbol}")
            width = width + change
        residual = 100 * np.abs(dataset.print_residual.values)
        axes.plot(residual, place, "D", color=style.VERMILION, markersize=5, label="printed less computed, size",
                  clip_on=False)  # fmt: skip
        axes.set(title=words, xlabel="Part of the threshold [%]", xlim=(0, 1.15 * max(residual.max(), width.max())))
    panels[0].set_yticks(place, names)
    phase.legend(figure, list(panels), 5)
    return figure
