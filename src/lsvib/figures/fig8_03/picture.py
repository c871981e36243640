"""Figure 8.3: stability regions of the steady sliding in the (Γ_0, C_0) plane."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from lsvib.figures import style

# Stable classes in blues and greens, unstable ones in warm colours; order of the flags.
_DRIVES = (style.BLUE, style.VERMILION, style.BLACK, style.PURPLE, style.WINE)
_INSET = (0.075, 0.125, 0.225, 0.27)  # in the saddles, the largest class
_CLOSE = 1.2  # half side of the close-up, in distances of the two drives in it
_LEAST = 0.02  # and at least this part of the whole picture
_COLOURS = {
    "stable node": "#9FD3C7",
    "stable focus": "#BFDDF2",
    "centre": style.GREY,
    "unstable focus": "#FBE3B5",
    "unstable node": "#F4B78A",
    "saddle": "#E3C3D6",
    "degenerate": style.BLACK,
}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the class map, the node–focus boundary C_0² = 4kΓ_0 and the chapter's drives, two of them enlarged."""
    figure = style.new_figure(style.DOUBLE * 0.72, 3.7)
    axes = figure.add_subplot()
    names = style.flag_names(dataset.stability)
    colours = ListedColormap([_COLOURS[name] for name in names.values()])
    norm = BoundaryNorm([value - 0.5 for value in names] + [len(names) - 0.5], len(names))
    close = axes.inset_axes(_INSET)
    for panel in (axes, close):
        panel.pcolormesh(
            dataset.effective_inertia,
            dataset.effective_damping,
            dataset.stability.T,
            cmap=colours,
            norm=norm,
            shading="nearest",
            rasterized=True,
        )
        _lines_and_drives(panel, dataset)
    _name_regions(axes, dataset)
    axes.set(
        xlabel=style.label(dataset.effective_inertia),
        ylabel=style.label(dataset.effective_damping),
        xlim=(dataset.effective_inertia[0], dataset.effective_inertia[-1]),
        ylim=(dataset.effective_damping[0], dataset.effective_damping[-1]),
    )
    _close_up(axes, close, dataset)
    style.state_values(figure, dataset)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


def _lines_and_drives(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the boundaries of the classes and the chapter's drives."""
    for sign in (1, -1):
        curve = axes.plot(
            dataset.node_focus_effective_inertia,
            sign * dataset.node_focus_effective_damping,
            color=style.BLACK,
            linewidth=1.0,
        )
    curve[0].set_label(r"$C_0^2 = 4 k \Gamma_0$")
    axes.axvline(0, color=style.BLACK, linewidth=1.0)
    axes.plot([0, dataset.effective_inertia[-1]], [0, 0], color=style.BLACK, linewidth=1.0)
    for index, marker, colour in zip(dataset.case.values, "osD^v", _DRIVES, strict=False):
        case = dataset.sel(case=index)
        name = f"$m$ = {float(case.mass):g} kg, $c_x$ = {float(case.translation_damping):g} N s m⁻¹"
        axes.plot(
            case.case_effective_inertia,
            case.case_effective_damping,
            marker,
            color=colour,
            markeredgecolor="white",
            markersize=5,
            linestyle="none",
            label=name,
            zorder=3,
        )


def _close_up(axes: Axes, close: Axes, dataset: xr.Dataset) -> None:
    """Show the surroundings of the two drives that lie closest together in the picture."""
    drives = np.stack([dataset.case_effective_inertia.values, dataset.case_effective_damping.values])
    sides = np.array([np.ptp(dataset.effective_inertia.values), np.ptp(dataset.effective_damping.values)])
    scaled = drives / sides[:, None]
    apart = np.hypot(*(scaled[:, :, None] - scaled[:, None, :]))
    pair = drives[:, np.unravel_index(np.argmin(apart + np.diag(np.full(drives.shape[1], np.inf))), apart.shape)]
    half = np.maximum(_CLOSE * np.ptp(pair, axis=1), _LEAST * sides)
    for limits, middle, width in zip((close.set_xlim, close.set_ylim), pair.mean(axis=1), half, strict=True):
        limits(middle - width, middle + width)
    close.locator_params(nbins=3)
    close.tick_params(labelsize=6.5, pad=2)
    for offset in (close.xaxis.get_offset_text(), close.yaxis.get_offset_text()):
        offset.set_fontsize(6.5)
    axes.indicate_inset_zoom(close, edgecolor=style.BLACK, linewidth=0.7)


def _name_regions(axes: Axes, dataset: xr.Dataset) -> None:
    """Write the name of each class at the centroid of its region; lines such as the centres have no region."""
    for value, name in style.flag_names(dataset.stability).items():
        inside = dataset.stability == value
        if inside.mean() > 0.01:
            axes.text(
                dataset.effective_inertia.where(inside).mean(),
                dataset.effective_damping.where(inside).mean(),
                name,
                ha="center",
            )
