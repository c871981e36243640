"""Figure 8.6: amplitude of the steady vibration against the axial force, with phase portraits as insets."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from lsvib.figures import drawing, style

_REGIMES = {
    "steady sliding": (style.BLACK, "no vibration"),
    "slip cycle": (style.BLUE, "cycle of pure slip"),
    "stick slip with contact reversal": (style.ORANGE, "stick–slip, reaches $N = 0$"),
    "stick slip in contact": (style.VERMILION, "stick–slip, $N > 0$"),
}
_THRESHOLDS = {"onset_force": "onset", "stick_force": "stick", "detach_force": "detach"}
# Where the curve leaves room for insets, as fractions of the axes: left, bottom, width, height.
_PLACES = ((0.085, 0.17, 0.21, 0.30), (0.085, 0.61, 0.235, 0.33), (0.735, 0.20, 0.245, 0.38))

_THIN = (0.6, 0.6, 0.6, 0.6)  # widths of the motions in the small insets, in points


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the amplitude curve by regimes, the three thresholds and the inset portraits."""
    figure = style.new_figure(style.DOUBLE, 4.2)
    axes = figure.add_subplot()
    names = style.flag_names(dataset.regime)
    for value, name in names.items():
        if name in _REGIMES:
            colour, words = _REGIMES[name]
            inside = dataset.regime == value
            curve = dataset.swept_axial_force[inside], dataset.swept_amplitude[inside]
            axes.plot(*curve, color=colour, linewidth=2.2, label=words)
    top = 1.12 * float(dataset.swept_amplitude.max())
    words = ", ".join(f"{float(dataset[f'printed_{name}']):g}" for name in _THRESHOLDS)
    for name, word in _THRESHOLDS.items():
        force = float(dataset[name])
        axes.axvline(force, color=style.GREY, linewidth=0.8, linestyle=":", zorder=0)
        axes.axvline(float(dataset[f"printed_{name}"]), **style.PRINTED, zorder=0, label=f"printed: {words} N")
        axes.text(force, top, f"{word} {force:.2f} N", ha="center", va="bottom")
    axes.set(
        xlabel=style.label(dataset.swept_axial_force),
        ylabel=style.label(dataset.swept_amplitude, "amplitude of $u$"),
        xlim=(float(dataset.swept_axial_force[0]), float(dataset.swept_axial_force[-1])),
        ylim=(-0.02 * top, top),
    )
    marks = {"color": "white", "markeredgecolor": style.BLACK, "markersize": 4.5, "zorder": 4}
    # xarray's own interpolation needs scipy, which the package does not.
    curve = np.interp(dataset.axial_force, dataset.swept_axial_force, dataset.swept_amplitude, np.nan, np.nan)
    axes.plot(dataset.axial_force, curve, "o", **marks, label="force of a phase portrait")
    insets = [axes.inset_axes(place) for place in _PLACES[: dataset.sizes["case"]]]
    for small, index in zip(insets, dataset.case.values, strict=True):
        _inset(small, dataset.sel(case=index))
    for left, bottom, width, height in _PLACES[: len(insets)]:
        axes.add_patch(Rectangle((left - 0.055, bottom - 0.085), width + 0.06, height + 0.14, color="white", zorder=2,
                                 transform=axes.transAxes))  # fmt: skip
    style.state_values(figure, dataset)
    drawing.legend(figure, [axes, *insets], 4)
    return figure


def _inset(small: Axes, case: xr.Dataset) -> None:
    """Draw the phase portrait of one force."""
    drawing.draw_motions(small, case, widths=_THIN)
    drawing.draw_cycle(small, case, width=1.4)
    drawing.mark_origin(small)
    drawing.widen(small, case, 0.2)
    drawing.draw_lines(small, case)
    drawing.guide(small, case, size=7.5)
    small.locator_params(nbins=4)
    title = small.set_title(f"$R$ = {drawing.number(case.axial_force)} N", fontsize=7, pad=4)
    title.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0})
    small.tick_params(labelsize=6.5, pad=1.5)
    small.set_xlabel(f"$u$ {style.unit(case.angle_deviation.attrs['units'])}", fontsize=7, labelpad=0)
    small.set_ylabel(f"$\\dot u$ {style.unit(case.velocity_deviation.attrs['units'])}", fontsize=7, labelpad=0)
