"""Figure 8.15: stability of the drive with axial support as support stiffness and coefficient of friction vary."""

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import drawing, style

# Fill, hatch, words of the legend, words in the region and their place; hatching as in the chapter.
_REGIONS = {
    "stable": ("#FFFFFF", None, "stable", "stable", (0.05, 1e7)),
    "flutter": ("#CFE3F3", "////", "mode coupling (flutter)", "mode\ncoupling", (0.19, 1.2e7)),
    "divergence": (
        "#FBE3B5", "....", "third region: both modes diverge, $\\Gamma_0 < 0 < \\tilde\\Gamma_0$",
        "third\nregion", (0.247, 2.5e8),
    ),
    "kinematic constraint": (
        "#F7D9C4", "---", "primary region of the kinematic constraint, $\\tilde\\Gamma_0 < 0$",
        "primary\nkinematic\nregion", (0.343, 1e7),
    ),
}  # fmt: skip
_HATCH = "#7F8FA0"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the class map by eigenvalues, over it the boundaries in closed form and the critical friction."""
    figure = style.new_figure(style.DOUBLE * 0.8, 4.6)
    axes = figure.add_subplot()
    friction, stiffness = dataset.friction_coefficient, dataset.support_stiffness
    codes = {name: value for value, name in style.flag_names(dataset.stability).items()}
    colours = ListedColormap([_REGIONS[name][0] for name in codes])
    axes.pcolormesh(
        friction, stiffness, dataset.stability.T, cmap=colours, vmin=0, vmax=len(codes) - 1, rasterized=True
    )
    coarse = dataset.isel({name: _thinned(dataset.sizes[name]) for name in dataset.stability.dims})
    patches = []
    for name, (colour, hatch, words, name_in, place) in _REGIONS.items():
        inside = (coarse.stability == codes[name]).T.astype(float)
        if hatch and bool(inside.any()):
            places = coarse.friction_coefficient, coarse.support_stiffness
            area = axes.contourf(*places, inside, levels=[0.5, 1.5], colors="none", hatches=[hatch])
            area.set(edgecolor=_HATCH, linewidth=0)
        row = [
            float(dataset[dim].sel({dim: at}, method="nearest"))
            for dim, at in zip(dataset.stability.dims, place, strict=True)
        ]
        if int(dataset.stability.sel(dict(zip(dataset.stability.dims, row, strict=True)))) == codes[name]:
            axes.text(*place, name_in, ha="center", va="center", zorder=4,
                      bbox={"facecolor": colour, "linewidth": 0, "pad": 1.5})  # fmt: skip
        patches.append(Patch(facecolor=colour, hatch=hatch, edgecolor=_HATCH, linewidth=0.5, label=words))
    for boundary, dashes in ((dataset.lower_boundary, "-"), (dataset.upper_boundary, "--")):
        name = f"{boundary.attrs['long_name'].split()[0]} branch of (8.29)"
        axes.plot(
            dataset.boundary_friction_coefficient,
            boundary,
            color=style.BLUE,
            linestyle=dashes,
            linewidth=1.4,
            label=name,
        )
    critical = float(dataset.critical_friction)
    words = rf"$\mu_\mathrm{{kc}}$ = {critical:.4f}"
    axes.axvline(critical, color=style.VERMILION, linewidth=1.4, label=words)
    printed = float(dataset.printed_critical_friction)
    axes.axvline(printed, **style.PRINTED, label=rf"$\mu_\mathrm{{kc}}$ = {printed:g}, as printed")
    axes.set(
        xlabel=style.label(friction),
        ylabel=style.label(stiffness),
        yscale="log",
        xlim=(friction[0], friction[-1]),
        ylim=(np.min(stiffness), np.max(stiffness)),
    )
    style.state_values(figure, dataset)
    drawing.legend(figure, [axes], 2, patches)
    return figure


def _thinned(count: int) -> np.ndarray:
    """Indices of at most 250 of ``count`` values, both ends included: enough for hatching."""
    return np.unique(np.linspace(0, count - 1, 250).astype(int))
