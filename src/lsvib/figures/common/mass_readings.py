"""The coefficients that Sect. 8.5.1 prints, for both readings of the mass.

The text states m = 1 kg, but the effective inertias that it prints are those of m = 8 kg; its dampings hold for any
mass, and the thresholds of figure 8.6 belong to the stated one.
"""

from collections.abc import Sequence

import xarray as xr

from lsvib.datasets import phase_plane, printed
from lsvib.datasets.attributes import variable
from lsvib.datasets.checks import Check
from lsvib.models import chapter
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.stability import force_thresholds


def variables(drives: Sequence[RigidDrive]) -> phase_plane.Variables:
    """Return effective coefficients under both laws, and the two upper thresholds, along ``reading_mass``."""
    exact = [coefficients(d) for d in drives]
    variables = {}
    for law, sign, symbol in ((1, "plus", "+"), (-1, "minus", "-")):
        of_law = f"of law {symbol}"
        inertia, damping = [float(c.gamma[law]) for c in exact], [float(c.damping[law]) for c in exact]
        variables[f"reading_effective_inertia_{sign}"] = variable(
            "reading_mass", inertia, "kg m2", f"effective inertia {of_law}", f"$\\Gamma_{symbol}$"
        )
        variables[f"reading_effective_damping_{sign}"] = variable(
            "reading_mass", damping, "N m s rad-1", f"effective damping {of_law}", f"$C_{symbol}$"
        )
    for name in ("stick_force", "detach_force"):
        forces, words = [getattr(force_thresholds, name)(d) for d in drives], f"{name.replace('_', ' ')} for this mass"
        variables[f"reading_{name}"] = variable("reading_mass", forces, "N", words, "$R$")
    return variables


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the printed values: C± do not depend on the mass; Γ± as printed do not belong to the stated one."""
    result = []
    stated = float(dataset.mass)
    printed_for = float(dataset.reading_mass.values[dataset.reading_mass.values != stated][0])
    ours, theirs = dataset.sel(reading_mass=stated), dataset.sel(reading_mass=printed_for)
    for law, sign, symbol in ((-1, "minus", "₋"), (1, "plus", "₊")):
        words = f"Effective damping C{symbol}, of any mass"
        result.append(printed.check(words, chapter.EFFECTIVE_DAMPING[law], ours[f"reading_effective_damping_{sign}"]))
    for law, sign, symbol in ((-1, "minus", "₋"), (1, "plus", "₊")):
        words = (
            f"Effective inertia Γ{symbol} as printed, read as that of m = {printed_for:g} kg "
            f"(with the stated m = {stated:g} kg it is {float(ours[f'reading_effective_inertia_{sign}']):.3g} kg m2)"
        )
        result.append(printed.check(words, chapter.EFFECTIVE_INERTIA[law], theirs[f"reading_effective_inertia_{sign}"]))
    stick = float(theirs.reading_stick_force), float(theirs.reading_detach_force)
    expected = chapter.THRESHOLDS["stick_force"].value, chapter.THRESHOLDS["detach_force"].value
    result.append(
        Check.holds(
            f"The thresholds of Fig. 8.6 are not those of m = {printed_for:g} kg (more than 2 % off)",
            "Sect. 8.5.1, Fig. 8.6",
            f"m = {printed_for:g} kg gives {stick[0]:.2f} N and {stick[1]:.2f} N",
            all(abs(s / p - 1) > 0.02 for s, p in zip(stick, expected, strict=True)),
        )
    )
    return result
