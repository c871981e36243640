"""Figure 8.4: phase plane under negative damping with N_0 Ω > 0: the origin is unstable, a limit cycle attracts."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from lsvib.datasets.checks import Check
from lsvib.figures import drawing, style
from lsvib.figures.common import named, spread
from lsvib.figures.common_motions import MARGINS, margins_text, negative_damping, radii
from lsvib.figures.settings import PhasePlane
from lsvib.figures.style import Figure

CAPTION = """\
Phase plane of the rigid drive under negative effective damping (8.19) with a contact force of the direction of motion
(N_0 Ω > 0). Steady sliding, the origin, is unstable, and motions from inside and from outside settle on a limit cycle.
Arrows point along time.
"""


class Settings(PhasePlane):
    """Phase plane under negative damping, contact force with the motion."""


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the phase plane; the first start lies inside the limit cycle, the others outside."""
    return negative_damping(settings, "8.4", "contact force along the motion")


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check (8.19), that the origin repels, and that one limit cycle attracts from inside and outside."""
    holds = all(float(dataset[f"margin_{key}"][0]) > 0 for key in MARGINS)
    growth, (first, last) = dataset.eigenvalue_real_part.values[0], radii(dataset)
    amplitudes = dataset.amplitude.values[0].ravel()
    around = first[0] < amplitudes[0] and (first[1:] > amplitudes[0]).all() and first.size > 1
    return [
        Check.holds("The three conditions of negative damping hold", "eq. 8.19", margins_text(dataset), holds),
        Check.holds(
            "The origin is unstable by its eigenvalues",
            "eq. 8.18, Fig. 8.4",
            f"real parts {growth[0]:.4g} and {growth[1]:.4g} 1/s",
            growth.max() > 0,
        ),
        Check.holds(
            "The exact motion that starts near the origin leaves it",
            "Sect. 8.5, Fig. 8.4",
            f"largest |u| grows from {first[0]:.4g} to {last[0]:.4g} rad",
            last[0] > first[0],
        ),
        Check.holds(
            "A pure-slip limit cycle attracts from inside and from outside, the same one to 1e-12",
            "Sect. 8.5, Fig. 8.4",
            f"amplitude {amplitudes[0]:.9g} rad, relative spread {spread(amplitudes):.1e} over {amplitudes.size} "
            "motions",
            named(dataset.attractor, "other cycle").all() and spread(amplitudes) < 1e-12 and around,
        ),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the motions from inside and outside, the limit cycle, and the lines N = 0 and θ′ = 0."""
    return drawing.single(dataset)
