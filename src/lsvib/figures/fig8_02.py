"""Figure 8.2: phase portrait of the contact force in the inconsistent case, without and with contact damping."""

import xarray as xr

from lsvib.contact.contact_force import Paradox
from lsvib.datasets.checks import Check
from lsvib.figures import contact_portraits
from lsvib.figures.common import about, named
from lsvib.figures.settings import ContactPortrait, Values

CAPTION = """\
Phase portrait of the contact force while the threads are stiff, in the inconsistent case and with the screw turning
forwards, (a) without and (b), not in the chapter, with contact damping. Both equilibria lie where the other law holds,
so there is no solution; every contact force ends growing in the first quadrant along the unstable manifold of the
virtual saddle. Arrows point along time.
"""

Settings = ContactPortrait
draw = contact_portraits.draw


def build(settings: Values) -> xr.Dataset:
    """Compute the portrait, :func:`lsvib.figures.contact_portraits.portrait`, with contact dampings 0 and > 0."""
    portrait = contact_portraits.portrait(settings, Paradox.INCONSISTENT)
    return portrait.assign_attrs(about(__doc__, contact_portraits.SOURCE, "Sect. 8.2, Fig. 8.2"))


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that nothing is in equilibrium and that every contact force ends growing in the first quadrant."""
    equilibria = dataset.equilibrium_contact_force
    last = [x.values[..., -2:] for x in (dataset.contact_force, dataset.contact_force_rate)]
    rising = [(x[..., 1] > x[..., 0]) & (x[..., 0] > 0) for x in last]
    return [
        *contact_portraits.newton_checks(dataset),
        Check.of(
            "fig8_02.no_solution",
            f"{', '.join(f'{x:.4g}' for x in equilibria.values)} 1/(kg m²), signs of the sides "
            f"{dataset.law_side.values.tolist()}",
            (equilibria * dataset.law_side < 0).all(),
        ),
        Check.everywhere("fig8_02.every_start", named(dataset.grid_outcome, "plus infinity"), "starts"),
        Check.everywhere(
            "fig8_02.drawn", rising[0] & rising[1] & named(dataset.start_outcome, "plus infinity"), "motions"
        ),
        contact_portraits.growth_check(dataset, "plus infinity"),
        contact_portraits.energy_check(dataset),
    ]
