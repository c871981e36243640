"""Figure 8.12: effect of the support damping on amplitude, mean coupling deflection and mean contact force."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_RULES = {
    "contact sign": (style.BLUE, "-", "resumes by the sign of the contact force"),
    "at once": (style.ORANGE, (0, (4, 2)), "resumes at once, as in the chapter"),
}
_PANELS = (  # variable, title, word on the axis
    ("amplitude", "amplitude", "amplitude of $u$"),
    ("mean_deflection", "mean deflection", "mean deflection"),
    ("mean_normal_force", "mean force", "mean force"),
)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the three quantities under both rules of resuming, below close to the dampings at which they differ."""
    figure = style.new_figure(style.DOUBLE, 4.9)
    panels = figure.subplots(2, 3)
    limit = float(dataset.resting_support_damping)
    near = dataset.isel(support_damping=dataset.support_damping.values <= 2 * limit)
    for column, (name, title, word) in enumerate(_PANELS):
        whole, close = panels[:, column]
        _curves(whole, dataset, name, 1e3)
        _curves(close, near, name, 1e6)
        close.axvline(limit * 1e6, color=style.BLACK, linewidth=0.8, linestyle=":",
                      label=f"$c$ = {limit * 1e6:.3g} × 10⁻⁶ N m s rad⁻¹, below which the screw rests")  # fmt: skip
        for axes, power, letter, part in ((whole, "⁻³", "abc", dataset), (close, "⁻⁶", "def", near)):
            axes.set(
                title=f"({letter[column]}) {title}" + (", small $c$" if axes is close else ""),
                xlabel=f"Damping $c$ [10{power} N m s rad⁻¹]",
                ylabel=style.label(dataset[name], word),
            )
            axes.set_xlim(0, float(part.support_damping[-1]) * (1e3 if axes is whole else 1e6))
            axes.locator_params(nbins=5)
        if name == "mean_normal_force":
            whole.plot(dataset.support_damping * 1e3, dataset.mean_impulsive_force[0], color=style.GREY, linewidth=1.0,
                       label="part from impulses")  # fmt: skip
            whole.set_ylim(0, None)
    style.state_values(figure, dataset)
    drawing.legend(figure, [panels[0, 2], panels[1, 0]], 2)
    return figure


def _curves(axes: Axes, dataset: xr.Dataset, name: str, scale: float) -> None:
    """Draw a quantity under both rules; without damping the second rule has no motion that resumes at once."""
    for index, rule in style.flag_names(dataset.rule).items():
        colour, dashes, words = _RULES[rule]
        curve = dataset.sel(rule=index)
        if rule == "at once":
            curve = curve.isel(support_damping=dataset.support_damping.values > 0)
        axes.plot(curve.support_damping * scale, curve[name], color=colour, linestyle=dashes, label=words)
