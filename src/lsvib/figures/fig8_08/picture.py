"""Figure 8.8: evolution of the eigenvalues as the translating mass is varied."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_LIMIT = 1.15  # half height of the overviews, in largest imaginary parts: real ones diverge and are cut here
_CLOSE = (-16.0, 6.0)  # range of the close-ups [per mille of the critical mass]
_CRITICAL = {"color": style.BLACK, "linewidth": 0.8, "linestyle": ":", "label": r"critical mass $m_\mathrm{cr}$"}
_LINEAR = 100.0  # the close-up of the real parts is logarithmic beyond this [1/s]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw real and imaginary parts against the mass, (a) and (b), and close to the critical mass, (c) and (d)."""
    figure = style.new_figure(style.DOUBLE, 5.0)
    (real, imaginary), (close_real, close_imaginary) = figure.subplots(2, 2)
    critical = float(dataset.critical_mass)
    printed, meeting, peak = (
        (float(dataset[name]) / critical - 1) * 1e3 for name in ("printed_critical_mass", "meeting_mass", "peak_mass")
    )
    largest = float(dataset.eigenvalue_imaginary_part.max())
    for axes, title, variable in (
        (real, "(a) real parts, cut above and below", dataset.eigenvalue_real_part),
        (imaginary, "(b) imaginary parts", dataset.eigenvalue_imaginary_part),
    ):
        _plot(axes, dataset, dataset.mass, variable)
        axes.axvline(critical, **_CRITICAL)
        axes.set(title=title, xlabel=style.label(dataset.mass), ylabel=_name(variable))
        axes.set(xlim=(0, dataset.mass[-1]), ylim=(-_LIMIT * largest, _LIMIT * largest))
    imaginary.text(1.07 * critical, 0.85 * _LIMIT * largest, f"$m_\\mathrm{{cr}}$ = {critical:.3f} kg", va="top")
    for axes, title, variable in (
        (close_real, "(c) real parts near $m_\\mathrm{cr}$", dataset.eigenvalue_real_part),
        (close_imaginary, "(d) imaginary parts near $m_\\mathrm{cr}$", dataset.eigenvalue_imaginary_part),
    ):
        _plot(axes, dataset, (dataset.mass / critical - 1) * 1e3, variable)
        axes.axvline(0, **_CRITICAL)
        axes.axvline(printed, **style.PRINTED, label=f"printed: {float(dataset.printed_critical_mass):.2f} kg")
        axes.axvline(meeting, color=style.GREY, linewidth=0.8, linestyle=(0, (6, 2, 1, 2)),
                     label=r"eigenvalues meet, $C_0^2 = 4 k \Gamma_0$")  # fmt: skip
        axes.set(title=title, xlabel=r"$(m - m_\mathrm{cr}) / m_\mathrm{cr}$ [‰]", ylabel=_name(variable), xlim=_CLOSE)
    close_real.set_yscale("symlog", linthresh=_LINEAR)
    close_imaginary.set_ylim(-1.3 * largest, 1.3 * largest)
    unit = style.unit(dataset.eigenvalue_imaginary_part.attrs["units"])[1:-1]
    close_imaginary.text(peak, 1.05 * largest, f"{largest:.0f} {unit}", ha="center", va="bottom")
    style.state_values(figure, dataset)
    drawing.legend(figure, [real, close_real], 5)
    return figure


def _name(variable: xr.DataArray) -> str:
    """Return a label without "of the eigenvalue", for which an axis has no room."""
    return style.label(variable, variable.attrs["long_name"].partition(" of ")[0])


def _plot(axes: Axes, dataset: xr.Dataset, abscissa: xr.DataArray, variable: xr.DataArray) -> None:
    """Draw both eigenvalues; each in two pieces, because no line may join the two sides of the pole."""
    below = dataset.mass < dataset.critical_mass
    for index, colour, dashes in ((1, style.BLUE, "-"), (2, style.VERMILION, (0, (4, 2)))):
        part = variable.sel(eigenvalue=index)
        axes.plot(abscissa[below], part[below], color=colour, linestyle=dashes, label=f"$\\varepsilon_{index}$")
        axes.plot(abscissa[~below], part[~below], color=colour, linestyle=dashes)
    axes.axhline(0, color=style.GREY, linewidth=0.6, zorder=0)
