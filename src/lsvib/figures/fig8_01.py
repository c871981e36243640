"""Figure 8.1: phase portrait of the contact force in the indeterminate case, without and with contact damping."""

import numpy as np
import xarray as xr

from lsvib.contact.contact_force import Paradox
from lsvib.datasets.checks import Check
from lsvib.figures import contact_portraits
from lsvib.figures.common import about, named
from lsvib.figures.settings import ContactPortrait, Values

CAPTION = """\
Phase portrait of the contact force while the threads are stiff, in the indeterminate case and with the screw turning
forwards, (a) without and (b), not in the chapter, with contact damping. Abscissa: the chapter's force χ (8.8);
ordinate: its rate, scaled alike on both sides. Law + has a saddle where the contact force is positive, law − a centre
or a focus where it is negative; the saddle's stable manifold separates contact forces that stay bounded from those that
grow without bound. In (a) part of the unstable manifold lies on it. Arrows point along time.
"""

Settings = ContactPortrait
draw = contact_portraits.draw


def build(settings: Values) -> xr.Dataset:
    """Compute the portrait, :func:`lsvib.figures.contact_portraits.portrait`, with contact dampings 0 and > 0."""
    portrait = contact_portraits.portrait(settings, Paradox.INDETERMINATE)
    return portrait.assign_attrs(about(__doc__, contact_portraits.SOURCE, "Sect. 8.2, Fig. 8.1, Remark 8.1"))


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check saddle and centre, both outcomes and what decides between them, and the focus under contact damping."""
    elastic, damped = dataset.isel(case=0), dataset.isel(case=1)
    inside = contact_portraits.within_separatrix(elastic)
    bounded, unbounded = (named(elastic.grid_outcome, word) for word in ("bounded", "minus infinity"))
    last = dataset.contact_force.values[named(dataset.start_outcome, "minus infinity")][:, -1]
    parts = dataset.scaled_eigenvalue_real_part, dataset.scaled_eigenvalue_imaginary_part
    (real, imaginary), (growth, frequency) = ([part.sel(law=law) for part in parts] for law in (1, -1))
    ends = damped.contact_force.values[named(damped.start_outcome, "bounded"), -1]
    # e⁻⁸ of a start is left where the motions end.
    gap = float(np.abs(ends * float(damped.effective_inertia_of_law.sel(law=-1)) - 1).max(initial=0.0))
    return [
        *contact_portraits.newton_checks(dataset),
        Check.of(
            "fig8_01.two_solutions",
            ", ".join(f"{float(x):.4g}" for x in dataset.equilibrium_contact_force) + " 1/(kg m²)",
            (dataset.equilibrium_contact_force * dataset.law_side > 0).all(),
        ),
        Check.of(
            "fig8_01.saddle",
            f"eigenvalues {real.values.round(4).tolist()}",
            (real.prod("eigenvalue") < 0).all() and (imaginary == 0).all(),
        ),
        Check.of(
            "fig8_01.centre",
            f"eigenvalues ±{abs(float(frequency[0, 0])):.4g}i",
            (growth[0] == 0).all() and (frequency[0] != 0).all(),
        ),
        contact_portraits.energy_check(dataset),
        Check.without_exception("fig8_01.loop", (bounded != inside).sum(), bounded.size, "starts"),
        Check.of(
            "fig8_01.outcomes",
            f"{bounded.sum()} and {unbounded.sum()} of {bounded.size} starts",
            bounded.any() and unbounded.any() and (bounded | unbounded).all(),
        ),
        Check.everywhere("fig8_01.unbounded", last < float(dataset.grid_contact_force.min())),
        contact_portraits.growth_check(dataset, "minus infinity"),
        Check.of(
            "fig8_01.focus",
            f"eigenvalues {float(growth[1, 0]):.4g} ± {abs(float(frequency[1, 0])):.4g}i",
            (growth[1] < 0).all() and (frequency[1] != 0).all(),
        ),
        Check.of(
            "fig8_01.settles", f"{ends.size} motions, largest relative distance {gap:.1e}", ends.size and gap < 0.01
        ),
    ]
