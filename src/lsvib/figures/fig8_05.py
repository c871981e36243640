"""Figure 8.5: phase plane as in figure 8.4 but with N_0 Ω < 0: the origin is stable."""

import xarray as xr

from lsvib.datasets import newton
from lsvib.datasets.checks import Check
from lsvib.figures import drawing, fig8_04, printed_laws
from lsvib.figures.common import about, named
from lsvib.figures.settings import PhasePlane, Values

CAPTION = """\
Phase plane of the rigid drive under negative effective damping (8.19) with a contact force against the direction of
motion (N_0 Ω < 0). Steady sliding, the origin, is stable. Arrows point along time.
"""

Settings = PhasePlane
draw = drawing.single


def build(settings: Values) -> xr.Dataset:
    """Compute the phase plane."""
    return fig8_04.build(settings).assign_attrs(about(__doc__, fig8_04.SOURCE, "Sect. 8.5, Fig. 8.5"))


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that only the second condition of (8.19) fails, and that the origin attracts."""
    others = float(dataset.margin_self_locking[0]), float(dataset.margin_negative_effective_damping[0])
    second = float(dataset.margin_force_with_motion[0])
    growth = dataset.eigenvalue_real_part.values[0]
    settled = named(dataset.attractor, "steady sliding")
    return [
        newton.laws_check(dataset, "Fig. 8.5"),
        Check.of("fig8_05.second_fails", fig8_04.margins_text(dataset), second < 0 < min(others)),
        Check.of("fig8_05.stable", f"real parts {growth[0]:.4g} and {growth[1]:.4g} 1/s", growth.max() < 0),
        Check.everywhere("fig8_05.settles", settled),
        *printed_laws.steady_checks(dataset),
    ]
