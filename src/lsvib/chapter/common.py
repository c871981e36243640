"""What figures share: the parts of a figure, the attributes of its dataset, and small computations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lsvib.answers import spans
from lsvib.answers.attributes import Variable, variable
from lsvib.chapter.checks import Check
from lsvib.chapter.settings import FigureSettings, Values
from lsvib.drives.chapter import claims
from lsvib.drives.drive import Drive
from lsvib.stability.boundaries import stable_set

if TYPE_CHECKING:
    from lsvib.systems.attractor import SteadyState as SteadyState
    from lsvib.systems.motion import Motion as Motion
else:  # names for annotations, which load no engine
    Motion = SteadyState = Any


@dataclass(frozen=True)
class Figure:
    """One of several figures of a module, under its name: what a module that is one figure has under these names."""

    Settings: type[FigureSettings]
    CAPTION: str
    build: Callable[[Values], xr.Dataset]
    checks: Callable[[xr.Dataset], list[Check]]
    draw: Callable[[xr.Dataset], Any]


EIGENVALUE = variable("eigenvalue", np.array([1, 2]), "1", "index of the eigenvalue", "$i$")
# The critical mass with contact as a variable: unit, words, symbol.
CRITICAL_MASS_WITH_CONTACT = (
    "kg", "mass at which steady sliding with the contact becomes unstable", r"$m_\mathrm{cr}$",
)  # fmt: skip


def about(module: str | None, source: str, places: str, **more: str) -> dict[str, str]:
    """Return the attributes of a dataset: the title of its ``module``'s docstring, the ``places`` that it is about."""
    title, references = (module or "").partition("\n")[0].rstrip("."), f"doi:10.1007/978-1-4419-1752-2_8, {places}"
    return {"title": title, "source": f"lsvib, {source}", "references": references, **more}


def printed(id: str, words: str) -> Variable:
    """Return the number of a claim of the chapter, whose ``words`` say what it is, as a variable without dimensions."""
    claim = claims()[id]
    return variable((), claim.value, claim.unit, f"{words}, as printed", relative_tolerance=claim.tolerance)


def thinned(dataset: xr.Dataset, most: int) -> xr.Dataset:
    """Return the map ``stability`` with what else lies over its axes, at ``most`` rows and columns at the most."""
    return dataset.isel({name: spans.evenly_chosen(dataset.sizes[name], most) for name in dataset.stability.dims})


def over_map(dataset: xr.Dataset, drive: Values) -> dict[str, Any]:
    """Return parameters with those of the axes of the map ``stability`` in place, the first down, the second across."""
    down, across = dataset.stability.dims
    return {**drive, down: dataset[down].values[:, None], across: dataset[across].values}


def critical_mass_with_contact(drive: Drive) -> float:
    """Return the mass [kg] at which the contact of a drive loses its stability, all below it stable; NaN if at none."""
    found = stable_set(drive, "mass")
    return float(found.intervals[0][1]) if found and found.changes and found.intervals else np.nan


def bisected(turned: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return where conditions turn true between ``low``, where they are not, and ``high``, each to the last bit."""
    while ((low < (middle := (low + high) / 2)) & (middle < high)).any():
        passed = turned(middle)
        low, high = np.where(passed, low, middle), np.where(passed, middle, high)
    return high


def spread(values: np.ndarray) -> float:
    """Return the range of values over the largest of them [1]; infinite, which no check passes, if that is not > 0."""
    return float(np.ptp(values) / values.max()) if values.size and values.max() > 0 else np.inf
