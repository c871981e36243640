"""Figure 8.15: stability of the drive with axial support as support stiffness and coefficient of friction vary."""

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import phase, style

# Fill, hatch and words; slanted and horizontal hatching as in the chapter.
_REGIONS = {
    "stable": ("#FFFFFF", None, "stable"),
    "flutter": ("#CFE3F3", "////", "mode coupling (flutter)"),
    "divergence": ("#FBE3B5", "....", "divergence ($\\Gamma_0 < 0$)"),
    "kinematic": ("#F7D9C4", "---", "kinematic constraint"),
}
_HATCH = "#7F8FA0"


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the class map by eigenvalues, over it the boundaries in closed form and the critical friction."""
    figure = style.new_figure(style.DOUBLE * 0.72, 3.9)
    axes = figure.add_subplot()
    friction, stiffness = dataset.friction_coefficient, dataset.support_stiffness
    codes = {name: value for value, name in style.flag_names(dataset.stability).items()}
    colours = ListedColormap([_REGIONS[name][0] for name in codes])
    axes.pcolormesh(
        friction, stiffness, dataset.stability.T, cmap=colours, vmin=0, vmax=len(codes) - 1, rasterized=True
    )
    coarse = dataset.isel({name: _thinned(dataset.sizes[name]) for name in dataset.stability.dims})
    patches = []
    for name, (colour, hatch, words) in _REGIONS.items():
        inside = (coarse.stability == codes[name]).T.astype(float)
        if hatch and bool(inside.any()):
            places = coarse.friction_coefficient, coarse.support_stiffness
            area = axes.contourf(*places, inside, levels=[0.5, 1.5], colors="none", hatches=[hatch])
            area.set(edgecolor=_HATCH, linewidth=0)
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
    mass, screw, stiff = (phase.number(dataset[name]) for name in ("mass", "screw_mass", "coupling_stiffness"))
    axes.set(
        title=f"$m$ = {mass} kg, $m_1$ = {screw} kg, $k$ = {stiff} N m rad⁻¹ (assumed)",
        xlabel=style.label(friction),
        ylabel=style.label(stiffness),
        yscale="log",
        xlim=(friction[0], friction[-1]),
        ylim=(np.min(stiffness), np.max(stiffness)),
    )
    phase.legend(figure, [axes], 3, patches)
    return figure


def _thinned(count: int) -> np.ndarray:
    """Indices of at most 250 of ``count`` values, both ends included: enough for hatching."""
    return np.unique(np.linspace(0, count - 1, 250).astype(int))
