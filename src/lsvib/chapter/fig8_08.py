"""Figure 8.8: eigenvalues of steady sliding against the translating mass, and the critical mass, where Γ₊ = 0."""

from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Gt
from pydantic import Field

from lsvib.answers import spans
from lsvib.answers.analysis import analyse, value
from lsvib.answers.attributes import CRITICAL_MASS, drive_parameters, variable, varied
from lsvib.chapter import printed_laws
from lsvib.chapter.checks import Check, each, near
from lsvib.chapter.common import EIGENVALUE, about, bisected, printed
from lsvib.chapter.settings import Damping, DriveFigure, PositiveSpan, Values, several
from lsvib.drives import chapter
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.pictures import style
from lsvib.stability.spectrum import eigenvalue_pair

CAPTION = """\
Eigenvalues (8.18) of steady sliding against the translating mass: (a) real and (b) imaginary parts. Just below the
critical mass the imaginary parts return to zero, where both eigenvalues meet and become real; above it the effective
inertia is negative and one eigenvalue is positive. At the critical mass the real parts diverge; (a) cuts them off.
"""

_CRITICAL = {"color": style.BLACK, "linewidth": 0.8, "linestyle": ":", "label": r"critical mass $m_\mathrm{cr}$"}


class Settings(DriveFigure):
    engine = ()
    unused = ("input_speed", "mass", "translation_damping", "axial_force")

    mass: PositiveSpan = Field(description="Translating mass [kg].")
    dampings: list[Annotated[Damping, Gt(0)]] = several(
        1, None, "Support dampings at which the loss of stability is located [N m s/rad]."
    )


def analysis(settings: Values) -> xr.Dataset:
    """Analyse the drive: its critical mass."""
    return analyse([Drive.of(settings["drive"])], [("kinematic_constraint", "mass")])


def build(settings: Values, analysis: xr.Dataset) -> xr.Dataset:
    """Compute both eigenvalues over the mass, the critical mass, and where the spectrum loses stability; c_x = 0."""
    drive = Drive.of(settings["drive"])
    critical = value(analysis.kinematic_constraint_mass)
    span, near = settings["mass"], critical * np.geomspace(1e-6, 0.1, settings["mass"]["count"] // 4)
    mass = np.unique(np.concatenate([spans.even(span), critical - near, critical + near]))
    mass = mass[(mass >= span["start"]) & (mass <= span["stop"]) & (mass != critical)]

    def eigenvalues(masses: np.ndarray, damping: float | np.ndarray) -> np.ndarray:
        """Both, by Γ₊, which vanishes at m_cr, so that many digits are used and rounded once."""
        inertia = np.array([float(coefficients(drive.replace(mass=float(m))).gamma[1]) for m in masses])
        return eigenvalue_pair(inertia, damping, drive.coupling_stiffness)

    dampings = np.array(settings["dampings"], dtype=float)
    around = (np.full(dampings.size, critical * part) for part in (0.5, 1.5))
    losses = bisected(lambda m: eigenvalues(m, dampings).real.max(axis=-1) >= 0, *around)
    lost = "mass at which the real part of an eigenvalue becomes positive"
    pair = eigenvalues(mass, drive.support_damping)
    dims, real, imaginary = ("eigenvalue", "mass"), "real part of the eigenvalue", "imaginary part of the eigenvalue"
    return xr.Dataset(
        {
            "eigenvalue_real_part": variable(dims, pair.real.T, "s-1", real, r"Re $\varepsilon$"),
            "eigenvalue_imaginary_part": variable(dims, pair.imag.T, "rad s-1", imaginary, r"Im $\varepsilon$"),
            "loss_of_stability": variable("swept_support_damping", losses, "kg", lost, "$m$"),
        },
        coords={
            **varied(mass=mass, swept_support_damping=dampings),
            **drive_parameters(drive, axes=("mass",), no_effect=("input_speed", "axial_force"), printed=("Sect. 8.6",)),
            "eigenvalue": EIGENVALUE,
            "critical_mass": ((), critical, CRITICAL_MASS),
            "printed_critical_mass": printed(chapter.THRESHOLDS["critical_mass"], "critical mass"),
        },
        attrs=about(
            __doc__,
            "eigenvalues in closed form (8.18), effective inertia in 50-digit arithmetic",
            "Sect. 8.6, Fig. 8.8",
        ),
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical mass, and that the spectrum loses stability there and nowhere else, at any damping."""
    critical, losses = float(dataset.critical_mass), dataset.loss_of_stability.values
    light = dataset.eigenvalue_real_part.where(dataset.mass < critical, drop=True)
    heavy = dataset.eigenvalue_real_part.where(dataset.mass > critical, drop=True)
    pair, inertia = (
        dataset.eigenvalue_real_part + 1j * dataset.eigenvalue_imaginary_part,
        printed_laws.inertia(dataset, 1),
    )
    off = dataset.coupling_stiffness / pair.prod("eigenvalue").real - inertia
    gap, total = abs(off / dataset.screw_inertia), pair.sum("eigenvalue").real
    return [
        Check.of("fig8_08.critical_mass", critical),
        Check.of("fig8_08.spectrum", losses, expected=critical, count=losses.size),
        Check.that("fig8_08.below", largest=each(light, "<", 0), gap=each(gap, "<", 1e-9), light=light,
                   sum=near(total, -dataset.support_damping / inertia, 1e-6)),  # c_x = 0
        Check.that("fig8_08.above", product=each(heavy.prod("eigenvalue"), "<", 0), growth=heavy.max("eigenvalue")),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw real and imaginary parts, (a) and (b), each in two pieces, as no line may join the two sides of the pole."""
    figure = style.new_figure(style.DOUBLE, 2.9)
    panels, below = figure.subplots(1, 2), dataset.mass < dataset.critical_mass
    critical, largest = float(dataset.critical_mass), float(dataset.eigenvalue_imaginary_part.max())
    # Half height in largest imaginary parts: real ones diverge and are cut here.
    limits = {"xlim": (0, dataset.mass[-1]), "ylim": (-1.15 * largest, 1.15 * largest)}
    titles = {"real": "(a) real parts, cut off above and below", "imaginary": "(b) imaginary parts"}
    for (word, title), axes in zip(titles.items(), panels, strict=True):
        for index, colour, dashes in ((1, style.BLUE, "-"), (2, style.VERMILION, (0, (4, 2)))):
            part = dataset[f"eigenvalue_{word}_part"].sel(eigenvalue=index)
            axes.plot(dataset.mass[below], part[below], color=colour, linestyle=dashes, label=f"$\\varepsilon_{index}$")
            axes.plot(dataset.mass[~below], part[~below], color=colour, linestyle=dashes)
        axes.axhline(0, color=style.GREY, linewidth=0.6, zorder=0)
        axes.axvline(critical, **_CRITICAL)
        style.frame(axes, title, dataset.mass, style.label(part, f"{word} part"), **limits)
    words = f"$m_\\mathrm{{cr}}$ = {critical:.3f} kg,\nprinted: {float(dataset.printed_critical_mass):.2f} kg"
    panels[1].text(1.07 * critical, largest, words, va="top")
    return style.legend(figure, panels[:1], 3)
