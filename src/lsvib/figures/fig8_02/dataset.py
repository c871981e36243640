"""Figure 8.2: phase portrait of the contact force in the inconsistent case, without and with contact damping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact.contact_force import ForceOutcome, Paradox
from lsvib.datasets.checks import Check
from lsvib.figures.common import contact_portrait_checks, contact_portraits


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the portrait; settings as :func:`lsvib.figures.common.contact_portraits.portrait`, contact dampings 0 and
    > 0."""
    return contact_portraits.portrait(settings, Paradox.INCONSISTENT).assign_attrs(
        title="Figure 8.2: phase portrait of the contact force, inconsistent case",
        source="lsvib, closed-form flow of the contact force (8.12) with exact changes of the law",
        references="doi:10.1007/978-1-4419-1752-2_8, Sect. 8.2, Fig. 8.2",
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that nothing is in equilibrium and that every contact force ends growing in the first quadrant."""
    growing = dataset.grid_outcome == ForceOutcome.PLUS_INFINITY
    last = [x.values[..., -2:] for x in (dataset.contact_force, dataset.contact_force_rate)]
    rising = [(x[..., 1] > x[..., 0]) & (x[..., 0] > 0) for x in last]
    drawn = rising[0] & rising[1] & (dataset.start_outcome.values == ForceOutcome.PLUS_INFINITY)
    rate = dataset.scaled_eigenvalue_real_part.sel(law=1).max("eigenvalue").values[:, None]
    saddle = float(dataset.equilibrium_contact_force.sel(law=1))
    slope = last[1][..., 1] / ((last[0][..., 1] - saddle) / float(dataset.force_scale))
    gap = np.abs(slope / rate - 1).max()
    return [
        *contact_portrait_checks.newton_checks(dataset),
        Check.holds(
            "The equilibria 1/Γ₊ and 1/Γ₋ both lie on the side of the other law: there is no solution",
            "Sect. 8.2, Fig. 8.2",
            f"{', '.join(f'{x:.4g}' for x in dataset.equilibrium_contact_force.values)} 1/(kg m²), signs of the sides "
            f"{dataset.law_side.values.tolist()}",
            bool((dataset.equilibrium_contact_force * dataset.law_side < 0).all()),
        ),
        Check.everywhere(
            "Every start ends growing in the first quadrant, without contact damping and with it",
            "Sect. 8.2, Fig. 8.2",
            growing,
            "starts",
        ),
        Check.everywhere(
            "The drawn motions end in the first quadrant, force and rate both rising",
            "Sect. 8.2, Fig. 8.2",
            drawn,
            "motions",
        ),
        Check.holds(
            "The drawn motions end in exponential growth at the positive eigenvalue of law +, to 1 %",
            "eq. 8.12",
            f"rate over distance from 1/Γ₊ deviates by at most {gap:.2%} of it",
            bool(gap < 0.01),
        ),
        contact_portrait_checks.energy_check(dataset),
    ]
