"""Figure 8.8: evolution of the eigenvalues as the translating mass is varied."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import style

_LIMIT = 4000.0  # the eigenvalues diverge at the critical mass; the overview is cut here [1/s]
_CLOSE = 5.0  # half width of the close-up [per mille of the critical mass]
_LINEAR = 100.0  # the close-up is logarithmic beyond this [1/s]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) real and (b) imaginary parts against the mass, and (c) the real parts close to the critical mass."""
    figure = style.new_figure(style.DOUBLE, 2.7)
    real, imaginary, close = figure.subplots(1, 3)
    critical, printed = float(dataset.critical_mass), float(dataset.printed_critical_mass)
    _plot(real, dataset, dataset.mass, dataset.eigenvalue_real_part)
    _plot(imaginary, dataset, dataset.mass, dataset.eigenvalue_imaginary_part)
    for axes, title, variable in (
        (real, "(a) real parts", dataset.eigenvalue_real_part),
        (imaginary, "(b) imaginary parts", dataset.eigenvalue_imaginary_part),
    ):
        axes.axvline(critical, color=style.BLACK, linewidth=0.8, linestyle=":")
        axes.axvline(printed, **style.PRINTED)
        axes.set(
            title=title,
            xlabel=style.label(dataset.mass),
            ylabel=style.label(variable),
            xlim=(0, dataset.mass[-1]),
            ylim=(-_LIMIT, _LIMIT),
        )
    real.legend(loc="upper left")
    imaginary.text(critical * 1.05, 0.9 * _LIMIT, f"$m_\\mathrm{{cr}}$ =\n{critical:.3f} kg", va="top")
    _plot(close, dataset, (dataset.mass / critical - 1) * 1e3, dataset.eigenvalue_real_part)
    close.axvline(0, color=style.BLACK, linewidth=0.8, linestyle=":")
    aside = (printed / critical - 1) * 1e3
    close.axvline(aside, **style.PRINTED)
    close.text(aside - 0.2, 0.97, f"{printed:.2f} kg,\nprinted", ha="right", va="top", clip_on=True,
               transform=close.get_xaxis_transform())  # fmt: skip
    close.set_yscale("symlog", linthresh=_LINEAR)
    close.set(
        title="(c) real parts near $m_\\mathrm{cr}$",
        xlabel=r"$(m - m_\mathrm{cr}) / m_\mathrm{cr}$ [‰]",
        ylabel=style.label(dataset.eigenvalue_real_part),
        xlim=(-_CLOSE, _CLOSE),
    )
    return figure


def _plot(axes: Axes, dataset: xr.Dataset, abscissa: xr.DataArray, variable: xr.DataArray) -> None:
    """Draw both eigenvalues; each in two pieces, because no line may join the two sides of the pole."""
    below = dataset.mass < dataset.critical_mass
    for index, colour, dashes in ((1, style.BLUE, "-"), (2, style.VERMILION, (0, (4, 2)))):
        part = variable.sel(eigenvalue=index)
        axes.plot(abscissa[below], part[below], color=colour, linestyle=dashes, label=f"$\\varepsilon_{index}$")
        axes.plot(abscissa[~below], part[~below], color=colour, linestyle=dashes)
    axes.axhline(0, color=style.GREY, linewidth=0.6, zorder=0)
