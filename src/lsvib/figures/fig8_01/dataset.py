"""Figure 8.1: phase portrait of the contact force in the indeterminate case, without and with contact damping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact.contact_force import ForceOutcome, Paradox
from lsvib.data.checks import Check
from lsvib.figures.common import contact_portraits

_ENDS = 0.01  # of 1/Γ₋; e⁻⁸ of a start is left where the motions end


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the portrait; settings as :func:`lsvib.figures.common.contact_portraits.portrait`, contact dampings 0 and
    > 0."""
    return contact_portraits.portrait(settings, Paradox.INDETERMINATE).assign_attrs(
        title="Figure 8.1: phase portrait of the contact force, indeterminate case",
        source="lsvib, closed-form flow of the contact force (8.12) with exact changes of the law",
        references="doi:10.1007/978-1-4419-1752-2_8, Sect. 8.2, Fig. 8.1, Remark 8.1",
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check saddle and centre, both outcomes and what decides between them, and the focus under contact damping."""
    elastic, damped = dataset.isel(case=0), dataset.isel(case=1)
    inertia = dataset.effective_inertia_of_law
    predicted = contact_portraits.energy(
        elastic, elastic.grid_contact_force, elastic.grid_contact_force_rate
    ) < contact_portraits.saddle_energy(elastic)
    predicted = predicted & (elastic.grid_contact_force > elastic.equilibrium_contact_force.sel(law=1))
    wrong = int(((elastic.grid_outcome == ForceOutcome.BOUNDED) != predicted).sum())
    found = [int((elastic.grid_outcome == kind).sum()) for kind in (ForceOutcome.BOUNDED, ForceOutcome.MINUS_INFINITY)]
    centre = elastic.scaled_eigenvalue_real_part.sel(law=-1), elastic.scaled_eigenvalue_imaginary_part.sel(law=-1)
    focus = damped.scaled_eigenvalue_real_part.sel(law=-1), damped.scaled_eigenvalue_imaginary_part.sel(law=-1)
    bounded = damped.start_outcome.values == ForceOutcome.BOUNDED
    ends = damped.contact_force.values[bounded, -1]
    gap = float(np.abs(ends * float(inertia.sel(law=-1)) - 1).max(initial=0.0))
    unbounded = dataset.start_outcome.values == ForceOutcome.MINUS_INFINITY
    leaving = dataset.contact_force.values[unbounded][:, -1] < float(dataset.grid_contact_force.min())
    return [
        *contact_portraits.newton_checks(dataset),
        Check.holds(
            "Each equilibrium lies on the side on which its law holds: there are two solutions",
            "Sect. 8.1, Fig. 8.1",
            ", ".join(f"{float(x):.4g}" for x in dataset.equilibrium_contact_force) + " 1/(kg m²)",
            bool((dataset.equilibrium_contact_force * dataset.law_side > 0).all()),
        ),
        Check.holds(
            "The equilibrium of law + is a saddle, without contact damping and with it",
            "Sect. 8.2, eq. 8.11, Fig. 8.1",
            f"eigenvalues {dataset.scaled_eigenvalue_real_part.sel(law=1).values.round(4).tolist()}",
            bool((dataset.scaled_eigenvalue_real_part.sel(law=1).prod("eigenvalue") < 0).all())
            and bool((dataset.scaled_eigenvalue_imaginary_part.sel(law=1) == 0).all()),
        ),
        Check.holds(
            "The equilibrium of law − is a centre without contact damping",
            "Sect. 8.2, eq. 8.11, Fig. 8.1",
            f"eigenvalues ±{abs(float(centre[1][0])):.4g}i",
            bool((centre[0] == 0).all() and (centre[1] != 0).all()),
        ),
        contact_portraits.energy_check(dataset),
        Check.holds(
            "The contact force stays bounded exactly inside the loop of the saddle's separatrix",
            "Sect. 8.2, Fig. 8.1",
            f"{wrong} exceptions among {predicted.size} starts",
            wrong == 0,
        ),
        Check.holds(
            "Both outcomes occur: bounded, and unbounded towards minus infinity; no other",
            "Sect. 8.2, Fig. 8.1",
            f"{found[0]} and {found[1]} of {elastic.grid_outcome.size} starts",
            min(found) > 0 and sum(found) == elastic.grid_outcome.size,
        ),
        Check.holds(
            "Motions drawn as unbounded leave the picture towards minus infinity",
            "Sect. 8.2, Fig. 8.1",
            f"{int(leaving.sum())} of {leaving.size}",
            bool(leaving.all() and leaving.size),
        ),
        Check.holds(
            "With contact damping the equilibrium of law − is a stable focus",
            "Remark 8.1",
            f"eigenvalues {float(focus[0][0]):.4g} ± {abs(float(focus[1][0])):.4g}i",
            bool((focus[0] < 0).all() and (focus[1] != 0).all()),
        ),
        Check.holds(
            "With contact damping a bounded contact force settles on N = N₋, to 1 %",
            "Remark 8.1",
            f"{ends.size} motions, largest relative distance {gap:.1e}",
            bool(ends.size) and gap < _ENDS,
        ),
    ]
