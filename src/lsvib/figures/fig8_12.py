"""Figure 8.12: effect of the support damping on amplitude, mean coupling deflection and mean contact force."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_RULES = {
    "contact sign": (style.BLUE, "-", "resumes by the sign of the contact force"),
    "at once": (style.ORANGE, (0, (4, 2)), "resumes at once"),
}
# Variable, title, word on the axis, place of the close-up as fractions of the axes.
_PANELS = (
    ("amplitude", "(a) amplitude", "amplitude of $u$", (0.46, 0.50, 0.44, 0.42)),
    ("mean_deflection", "(b) mean deflection", "mean deflection", (0.25, 0.13, 0.27, 0.28)),
    ("mean_normal_force", "(c) mean contact force", "mean normal force", (0.55, 0.13, 0.38, 0.22)),
)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the three quantities under both rules of resuming, with close-ups of the dampings at which they differ."""
    figure = style.new_figure(style.DOUBLE, 3.1)
    panels = figure.subplots(1, 3)
    for axes, (name, title, word, place) in zip(panels, _PANELS, strict=True):
        _curves(axes, dataset, name)
        axes.set(
            title=title,
            xlabel=style.label(dataset.support_damping, "damping"),
            ylabel=style.label(dataset[name], word),
            xlim=(0, float(dataset.support_damping[-1])),
        )
        axes.locator_params(axis="x", nbins=2)
        if name == "mean_normal_force":
            impulsive = dataset.mean_impulsive_force[0]
            axes.plot(dataset.support_damping, impulsive, color=style.GREY, linewidth=1.0, label="part from impulses")
            axes.set_ylim(0, None)
        _close_up(axes.inset_axes(place), dataset, name)
    phase.legend(figure, panels, 3)
    return figure


def _curves(axes: Axes, dataset: xr.Dataset, name: str, scale: float = 1.0) -> None:
    """Draw a quantity under both rules; without damping the second rule has no motion that resumes at once."""
    for index, rule in style.flag_names(dataset.rule).items():
        colour, dashes, words = _RULES[rule]
        curve = dataset.sel(rule=index)
        if rule == "at once":
            curve = curve.isel(support_damping=dataset.support_damping.values > 0)
        axes.plot(curve.support_damping * scale, curve[name], color=colour, linestyle=dashes, label=words)


def _close_up(small: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the curves around the damping below which the screw rests after a seizure."""
    limit = float(dataset.resting_support_damping)
    _curves(small, dataset.isel(support_damping=dataset.support_damping.values <= 2 * limit), name, scale=1e6)
    small.axvline(limit * 1e6, color=style.BLACK, linewidth=0.7, linestyle=":")
    small.set_xlabel(r"$c$ [$10^{-6}$ N m s rad⁻¹]", fontsize=6, labelpad=0)
    small.locator_params(nbins=3)
    small.tick_params(labelsize=6, pad=1.5)
