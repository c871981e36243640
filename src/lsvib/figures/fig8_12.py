"""Figure 8.12: effect of the support damping on amplitude, mean coupling deflection and mean contact force."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_RULES = {
    "contact sign": (style.BLUE, "-", "resumes by the sign of the contact"),
    "at once": (style.ORANGE, (0, (4, 2)), "resumes at once"),
}
# Variable, title, place of the close-up as fractions of the axes.
_PANELS = (
    ("vibration_amplitude", "(a) amplitude of $u$", (0.50, 0.50, 0.44, 0.42)),
    ("mean_deflection", "(b) mean deflection", (0.26, 0.13, 0.40, 0.36)),
    ("mean_normal_force", "(c) mean contact force", (0.54, 0.24, 0.42, 0.30)),
)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the three quantities under both rules of resuming, with close-ups of the dampings at which they differ."""
    figure = style.new_figure(style.DOUBLE, 3.1)
    panels = figure.subplots(1, 3)
    for axes, (name, title, place) in zip(panels, _PANELS, strict=True):
        _curves(axes, dataset, name)
        axes.set(
            title=title,
            xlabel=style.label(dataset.damping, "damping"),
            ylabel=style.label(dataset[name], "amplitude of $u$" if name == "vibration_amplitude" else None),
            xlim=(0, float(dataset.damping[-1])),
        )
        if name == "mean_normal_force":
            axes.plot(
                dataset.damping, dataset.mean_impulsive_force[0], color=style.GREY, linewidth=1.0, label="part from impulses"
            )
            axes.set(ylim=(0, None), ylabel="Mean $|N|$ [N], impulses included")
        if name == "mean_deflection":
            axes.set(ylabel=r"Mean deflection $\langle z \rangle$ [rad]")
        _close_up(axes.inset_axes(place), dataset, name)
    phase.legend(figure, panels, 3)
    return figure


def _curves(axes: Axes, dataset: xr.Dataset, name: str) -> None:
    for index, rule in style.flag_names(dataset.rule).items():
        colour, dashes, words = _RULES[rule.replace("_", " ")]
        axes.plot(dataset.damping, dataset[name].sel(rule=index), color=colour, linestyle=dashes, label=words)


def _close_up(small: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the curve around the damping below which the screw rests after a seizure."""
    limit = float(dataset.resting_damping)
    near = dataset.isel(damping=dataset.damping.values <= 2 * limit)
    for index, rule in style.flag_names(dataset.rule).items():
        colour, dashes, _ = _RULES[rule]
        small.plot(near.damping * 1e6, near[name].sel(rule=index), color=colour, linestyle=dashes)
    small.axvline(limit * 1e6, color=style.BLACK, linewidth=0.7, linestyle=":")
    small.set_xlabel(r"$c$ [$10^{-6}$ N m s/rad]", fontsize=6, labelpad=0)
    small.locator_params(nbins=3)
    small.tick_params(labelsize=6, pad=1.5)
