"""Figure 8.8: eigenvalues of the steady sliding against the translating mass, and the critical mass Γ₊ = 0."""

from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Gt
from pydantic import Field

from lsvib.datasets import spans
from lsvib.datasets.analysis import analyse, value
from lsvib.datasets.attributes import CRITICAL_MASS, axis, drive_parameters, variable
from lsvib.datasets.checks import Check
from lsvib.figures import style
from lsvib.figures.common import EIGENVALUE, about, printed
from lsvib.figures.settings import Damping, DriveFigure, PositiveSpan, Values, several
from lsvib.models import chapter
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.numbers import bisected
from lsvib.stability.spectrum import eigenvalue_pair

CAPTION = """\
Eigenvalues (8.18) of the steady sliding against the translating mass: (a) real and (b) imaginary parts, and, not in the
chapter, (c), (d) close to the critical mass. The imaginary parts peak and return to zero before the critical mass,
where both eigenvalues meet and turn real; beyond it the effective inertia is negative and one eigenvalue is positive.
Real parts diverge there; (a) cuts them, (c) is logarithmic.
"""

_CRITICAL = {"color": style.BLACK, "linewidth": 0.8, "linestyle": ":", "label": r"critical mass $m_\mathrm{cr}$"}


class Settings(DriveFigure):
    engine = ()
    unused = ("input_speed", "mass", "translation_damping", "axial_force")

    mass: PositiveSpan = Field(description="Translating mass [kg].")
    dampings: several(
        Annotated[Damping, Gt(0)], 1, None, "Support dampings at which the loss of stability is located [N m s/rad]."
    )


def analysis(settings: Values) -> xr.Dataset:
    """Analyse the drive: its critical mass."""
    return analyse([Drive.of(settings["drive"])], [("kinematic_constraint", "mass")])


def build(settings: Values, analysis: xr.Dataset) -> xr.Dataset:
    """Compute both eigenvalues over the mass, the critical mass, and where the spectrum loses stability; c_x = 0."""
    drive = Drive.of(settings["drive"])
    critical = value(analysis.kinematic_constraint_mass)
    # Im² ε = k/Γ − C²/4Γ² of (8.18) vanishes at Γ = C²/4k, where both meet, and is largest, k²/C², at Γ = C²/2k.
    square = drive.support_damping**2 / drive.coupling_stiffness
    # Γ₊ = I (1 − m/m_cr)
    meeting, peak = (critical * (1 - inertia / drive.screw_inertia) for inertia in (square / 4, square / 2))
    span, near = settings["mass"], critical * np.geomspace(1e-6, 0.1, settings["mass"]["count"] // 4)
    mass = np.unique(np.concatenate([spans.even(span), critical - near, critical + near, [meeting, peak]]))
    mass = mass[(mass >= span["start"]) & (mass <= span["stop"]) & (mass != critical)]

    def eigenvalues(masses: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Γ₊, which vanishes at m_cr, so that 50 digits are used and rounded once, and both eigenvalues."""
        inertia = np.array([float(coefficients(drive.replace(mass=float(m))).gamma[1]) for m in masses])
        return inertia, eigenvalue_pair(inertia, damping, drive.coupling_stiffness)

    def grows(m: float, damping: float) -> bool:
        return bool(eigenvalues(np.array([m]), damping)[1].real.max() >= 0)

    dampings = np.array(settings["dampings"], dtype=float)
    # By bisection around m_cr to the last bit.
    losses = [bisected(lambda m, c=c: grows(m, c), critical / 2, critical * 3 / 2) for c in dampings.tolist()]
    lost = "mass at which the real part of an eigenvalue becomes positive"
    inertia, pair = eigenvalues(mass, drive.support_damping)
    dims, real, imaginary = ("eigenvalue", "mass"), "real part of the eigenvalue", "imaginary part of the eigenvalue"
    return xr.Dataset(
        {
            "eigenvalue_real_part": variable(dims, pair.real.T, "s-1", real, r"Re $\varepsilon$"),
            "eigenvalue_imaginary_part": variable(dims, pair.imag.T, "rad s-1", imaginary, r"Im $\varepsilon$"),
            "effective_inertia_plus": variable("mass", inertia, "kg m2", "effective inertia of law +", r"$\Gamma_+$"),
            "loss_of_stability": variable("swept_support_damping", losses, "kg", lost, "$m$"),
        },
        coords={
            **axis("mass", mass),
            **drive_parameters(drive, axes=("mass",), no_effect=("input_speed", "axial_force"), printed=("Sect. 8.6",)),
            "eigenvalue": EIGENVALUE,
            **axis("swept_support_damping", dampings),
            "critical_mass": ((), critical, CRITICAL_MASS),
            "meeting_mass": variable((), meeting, "kg", "mass at which both eigenvalues meet and turn real", "$m$"),
            "peak_mass": variable((), peak, "kg", "mass of the largest imaginary part of an eigenvalue", "$m$"),
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
    critical, meeting = float(dataset.critical_mass), float(dataset.meeting_mass)
    light = dataset.eigenvalue_real_part.where(dataset.mass < critical, drop=True)
    heavy = dataset.eigenvalue_real_part.where(dataset.mass > critical, drop=True)
    losses, peak = dataset.loss_of_stability.values, float(dataset.eigenvalue_imaginary_part.max())
    ratio = peak * float(dataset.support_damping) / float(dataset.coupling_stiffness)
    oscillating = dataset.mass.values[(dataset.eigenvalue_imaginary_part != 0).any("eigenvalue").values]
    peaks = abs(ratio - 1) < 1e-6 and (oscillating < meeting * (1 + 1e-12)).all() and meeting < critical
    return [
        Check.of("fig8_08.critical_mass", critical),
        Check.of("fig8_08.spectrum", losses, expected=critical, count=losses.size),
        Check.that("fig8_08.peak", peaks, peak=peak, mass=dataset.peak_mass, meeting=meeting),
        Check.that("fig8_08.below", (light < 0).all(), light=light),
        Check.that("fig8_08.above", (heavy.prod("eigenvalue") < 0).all(), growth=heavy.max("eigenvalue")),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw real and imaginary parts against the mass, (a) and (b), and close to the critical mass, (c) and (d)."""
    figure = style.new_figure(style.DOUBLE, 5.0)
    panels = figure.subplots(2, 2)
    critical, largest = float(dataset.critical_mass), float(dataset.eigenvalue_imaginary_part.max())
    printed, meeting, peak = (
        (float(dataset[name]) / critical - 1) * 1e3 for name in ("printed_critical_mass", "meeting_mass", "peak_mass")
    )
    titles = {"real": ("(a) real parts, cut above and below", "(c) ours: real parts"),
              "imaginary": ("(b) imaginary parts", "(d) ours: imaginary parts")}  # fmt: skip
    for (word, (title, near)), (whole, close) in zip(titles.items(), panels.T, strict=True):
        variable = dataset[f"eigenvalue_{word}_part"]
        _plot(whole, dataset, dataset.mass, variable, title)
        whole.axvline(critical, **_CRITICAL)
        # Half height in largest imaginary parts: real ones diverge and are cut here.
        whole.set(xlabel=style.label(dataset.mass), xlim=(0, dataset.mass[-1]), ylim=(-1.15 * largest, 1.15 * largest))
        _plot(close, dataset, (dataset.mass / critical - 1) * 1e3, variable, f"{near} near $m_\\mathrm{{cr}}$")
        close.axvline(0, **_CRITICAL)
        close.axvline(printed, **style.PRINTED, label=f"printed: {float(dataset.printed_critical_mass):.2f} kg")
        close.axvline(meeting, color=style.GREY, linewidth=0.8, linestyle=(0, (6, 2, 1, 2)),
                      label=r"eigenvalues meet, $C_0^2 = 4 k \Gamma_0$")  # fmt: skip
        close.set(xlabel=r"$(m - m_\mathrm{cr}) / m_\mathrm{cr}$ [‰]", xlim=(-16.0, 6.0))
    panels[0, 1].text(1.07 * critical, 0.85 * 1.15 * largest, f"$m_\\mathrm{{cr}}$ = {critical:.3f} kg", va="top")
    panels[1, 0].set_yscale("symlog", linthresh=100.0)
    panels[1, 1].set_ylim(-1.3 * largest, 1.3 * largest)
    unit = style.unit(dataset.eigenvalue_imaginary_part.attrs["units"])[1:-1]
    panels[1, 1].text(peak, 1.05 * largest, f"{largest:.0f} {unit}", ha="center", va="bottom")
    return style.legend(figure, panels[:, 0], 5)


def _plot(axes: style.Axes, dataset: xr.Dataset, abscissa: xr.DataArray, variable: xr.DataArray, title: str) -> None:
    """Draw both eigenvalues; each in two pieces, because no line may join the two sides of the pole."""
    below = dataset.mass < dataset.critical_mass
    for index, colour, dashes in ((1, style.BLUE, "-"), (2, style.VERMILION, (0, (4, 2)))):
        part = variable.sel(eigenvalue=index)
        axes.plot(abscissa[below], part[below], color=colour, linestyle=dashes, label=f"$\\varepsilon_{index}$")
        axes.plot(abscissa[~below], part[~below], color=colour, linestyle=dashes)
    axes.axhline(0, color=style.GREY, linewidth=0.6, zorder=0)
    name = variable.attrs["long_name"].partition(" of ")[0]  # an axis has no room for "of the eigenvalue"
    axes.set(title=title, ylabel=style.label(variable, name))
