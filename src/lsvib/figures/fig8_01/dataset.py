"""Figure 8.1: phase portrait of the contact force in the indeterminate case, without and with contact damping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact.contact_force import ForceOutcome, Paradox
from lsvib.datasets.checks import Check
from lsvib.figures.common import contact_portrait_checks, contact_portraits

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
    return [
        *contact_portrait_checks.newton_checks(dataset),
        *_equilibrium_checks(dataset, elastic),
        contact_portrait_checks.energy_check(dataset),
        *_outcome_checks(dataset, elastic),
        *_damping_checks(damped),
    ]


def _equilibrium_checks(dataset: xr.Dataset, elastic: xr.Dataset) -> list[Check]:
    """Check where the equilibria lie, and that one is a saddle and the other, without contact damping, a centre."""
    real, imaginary = (dataset[f"scaled_eigenvalue_{part}_part"].sel(law=1) for part in ("real", "imaginary"))
    centre = _eigenvalues_of_law_minus(elastic)
    return [
        Check.holds(
            "Each equilibrium lies on the side on which its law holds: there are two solutions",
            "Sect. 8.1, Fig. 8.1",
            ", ".join(f"{float(x):.4g}" for x in dataset.equilibrium_contact_force) + " 1/(kg m²)",
            bool((dataset.equilibrium_contact_force * dataset.law_side > 0).all()),
        ),
        Check.holds(
            "The equilibrium of law + is a saddle, without contact damping and with it",
            "Sect. 8.2, eq. 8.11, Fig. 8.1",
            f"eigenvalues {real.values.round(4).tolist()}",
            bool((real.prod("eigenvalue") < 0).all()) and bool((imaginary == 0).all()),
        ),
        Check.holds(
            "The equilibrium of law − is a centre without contact damping",
            "Sect. 8.2, eq. 8.11, Fig. 8.1",
            f"eigenvalues ±{abs(float(centre[1][0])):.4g}i",
            bool((centre[0] == 0).all() and (centre[1] != 0).all()),
        ),
    ]


def _outcome_checks(dataset: xr.Dataset, elastic: xr.Dataset) -> list[Check]:
    """Check that the loop of the separatrix decides between the two outcomes, and that both are drawn."""
    force, rate = elastic.grid_contact_force, elastic.grid_contact_force_rate
    within = contact_portrait_checks.energy(elastic, force, rate) < contact_portrait_checks.saddle_energy(elastic)
    predicted = within & (force > elastic.equilibrium_contact_force.sel(law=1))
    wrong = int(((elastic.grid_outcome == ForceOutcome.BOUNDED) != predicted).sum())
    found = [int((elastic.grid_outcome == kind).sum()) for kind in (ForceOutcome.BOUNDED, ForceOutcome.MINUS_INFINITY)]
    unbounded = dataset.start_outcome.values == ForceOutcome.MINUS_INFINITY
    leaving = dataset.contact_force.values[unbounded][:, -1] < float(dataset.grid_contact_force.min())
    return [
        Check.without_exception(
            "The contact force stays bounded exactly inside the loop of the saddle's separatrix",
            "Sect. 8.2, Fig. 8.1",
            wrong,
            predicted.size,
            "starts",
        ),
        Check.holds(
            "Both outcomes occur: bounded, and unbounded towards minus infinity; no other",
            "Sect. 8.2, Fig. 8.1",
            f"{found[0]} and {found[1]} of {elastic.grid_outcome.size} starts",
            min(found) > 0 and sum(found) == elastic.grid_outcome.size,
        ),
        Check.everywhere(
            "Motions drawn as unbounded leave the picture towards minus infinity", "Sect. 8.2, Fig. 8.1", leaving
        ),
    ]


def _damping_checks(damped: xr.Dataset) -> list[Check]:
    """Check that contact damping turns the centre into a focus, on which bounded motions settle."""
    focus = _eigenvalues_of_law_minus(damped)
    bounded = damped.start_outcome.values == ForceOutcome.BOUNDED
    ends = damped.contact_force.values[bounded, -1]
    inertia = float(damped.effective_inertia_of_law.sel(law=-1))
    gap = float(np.abs(ends * inertia - 1).max(initial=0.0))
    return [
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


def _eigenvalues_of_law_minus(case: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Real and imaginary parts of the eigenvalues at the equilibrium of law −."""
    return case.scaled_eigenvalue_real_part.sel(law=-1), case.scaled_eigenvalue_imaginary_part.sel(law=-1)
