"""Figure 8.5: phase plane as in figure 8.4 but with N_0 Ω < 0: the origin is stable."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor
from lsvib.figures.common.negative_damping import margins_text, plane, radii


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the phase plane."""
    return plane(settings, "8.5", "contact force against the motion")


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that only the second condition of (8.19) fails, and that the origin attracts."""
    second = float(dataset.margin_force_with_motion[0])
    others = float(dataset.margin_self_locking[0]), float(dataset.margin_negative_effective_damping[0])
    growth = dataset.eigenvalue_real_part.values[0]
    first, last = radii(dataset)
    settled = dataset.attractor.values == Attractor.STEADY_SLIDING
    return [
        Check.holds(
            "Of the conditions of negative damping only the second, N_0 Ω > 0, is violated",
            "eq. 8.19, Fig. 8.5",
            margins_text(dataset),
            second < 0 < min(others),
        ),
        Check.holds(
            "The origin is stable by its eigenvalues",
            "eq. 8.18, Fig. 8.5",
            f"real parts {growth[0]:.4g} and {growth[1]:.4g} 1/s",
            bool(growth.max() < 0),
        ),
        Check.holds(
            "Every exact motion drawn approaches the origin",
            "Sect. 8.5, Fig. 8.5",
            f"largest |u| falls to {(last / first).max():.2g} of its value at worst",
            bool((last < first).all()),
        ),
        Check.everywhere("Every exact motion drawn settles on the origin", "Sect. 8.5, Fig. 8.5", settled),
    ]
