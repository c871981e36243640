"""Figure 8.3: stability regions of the steady sliding in the (Γ_0, C_0) plane."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from lsvib.figures import style

# Stable classes in blues and greens, unstable ones in warm colours; order of the flags.
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
    """Draw the class map, the node–focus boundary C_0² = 4kΓ_0 and the chapter's drives."""
    figure = style.new_figure(style.DOUBLE * 0.72, 3.7)
    axes = figure.add_subplot()
    names = style.flag_names(dataset.stability)
    colours = ListedColormap([_COLOURS[name] for name in names.values()])
    norm = BoundaryNorm([value - 0.5 for value in names] + [len(names) - 0.5], len(names))
    axes.pcolormesh(
        dataset.effective_inertia,
        dataset.effective_damping,
        dataset.stability.T,
        cmap=colours,
        norm=norm,
        shading="nearest",
        rasterized=True,
    )
    for sign in (1, -1):
        curve = axes.plot(
            dataset.node_focus_inertia, sign * dataset.node_focus_damping, color=style.BLACK, linewidth=1.0
        )
    curve[0].set_label(r"$C_0^2 = 4 k \Gamma_0$")
    axes.axvline(0, color=style.BLACK, linewidth=1.0)
    axes.plot([0, dataset.effective_inertia[-1]], [0, 0], color=style.BLACK, linewidth=1.0)
    _name_regions(axes, dataset)
    for index, marker in zip(dataset.case.values, "osD^v", strict=False):
        case = dataset.sel(case=index)
        name = f"$m$ = {float(case.mass):g} kg, $c_x$ = {float(case.translation_damping):g} N s m⁻¹"
        axes.plot(
            case.case_effective_inertia,
            case.case_effective_damping,
            marker,
            color=style.BLUE,
            markeredgecolor="white",
            label=name,
        )
    axes.set(
        xlabel=style.label(dataset.effective_inertia),
        ylabel=style.label(dataset.effective_damping),
        xlim=(dataset.effective_inertia[0], dataset.effective_inertia[-1]),
        ylim=(dataset.effective_damping[0], dataset.effective_damping[-1]),
    )
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


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
