"""Figure 8.4: phase plane under negative damping with N_0 Ω > 0: the origin is unstable, a limit cycle attracts."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor
from lsvib.figures.common.negative_damping import MARGINS, margins_text, plane, radii


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the phase plane; the first start lies inside the limit cycle, the others outside."""
    return plane(settings, "8.4", "contact force along the motion")


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check (8.19), that the origin repels, and that one limit cycle attracts from inside and outside."""
    holds = all(float(dataset[f"margin_{key}"][0]) > 0 for key in MARGINS)
    growth = dataset.eigenvalue_real_part.values[0]
    first, last = radii(dataset)
    amplitudes = dataset.amplitude.values[0].ravel()
    cycles = bool((dataset.attractor.values == Attractor.OTHER_CYCLE).all())
    spread = float(np.ptp(amplitudes) / amplitudes.max()) if amplitudes.max() > 0 else np.inf
    inside, outside = first[0] < amplitudes[0], bool((first[1:] > amplitudes[0]).all())
    return [
        Check.holds("The three conditions of negative damping hold", "eq. 8.19", margins_text(dataset), holds),
        Check.holds(
            "The origin is unstable by its eigenvalues",
            "eq. 8.18, Fig. 8.4",
            f"real parts {growth[0]:.4g} and {growth[1]:.4g} 1/s",
            bool(growth.max() > 0),
        ),
        Check.holds(
            "The exact motion that starts near the origin leaves it",
            "Sect. 8.5, Fig. 8.4",
            f"largest |u| grows from {first[0]:.4g} to {last[0]:.4g} rad",
            bool(last[0] > first[0]),
        ),
        Check.holds(
            "A pure-slip limit cycle attracts from inside and from outside, the same one to 1e-12",
            "Sect. 8.5, Fig. 8.4",
            f"amplitude {amplitudes[0]:.9g} rad, relative spread {spread:.1e} over {amplitudes.size} motions",
            cycles and spread < 1e-12 and inside and outside and first.size > 1,
        ),
    ]
