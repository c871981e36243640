"""Checks of the portraits of the contact force that figures 8.1 and 8.2 share: the energy integral, and Newton's laws.

They read the variables of :mod:`lsvib.figures.common.contact_portraits`.
"""

import numpy as np
import xarray as xr

from lsvib.datasets.checks import Check

_ROUNDING = 1e-12  # Γ₊ is a difference of numbers of one size


def energy(case: xr.Dataset, force: xr.DataArray, rate: xr.DataArray) -> xr.DataArray:
    """Energy integral of (8.11) at χ and its rate, without contact damping, in the scales of law −; 0 at the origin."""
    return _potential(case, force) + rate**2 / 2


def saddle_energy(case: xr.Dataset) -> float:
    """Energy integral at the saddle."""
    return float(_potential(case, case.equilibrium_contact_force.sel(law=1)))


def energy_spread(case: xr.Dataset) -> float:
    """Largest spread of the energy along a motion, relative to the largest of its two parts on the way."""
    parts = _potential(case, case.contact_force), case.contact_force_rate**2 / 2
    total = sum(parts)
    size = xr.concat([abs(part) for part in parts], "part").max(["part", "sample"])
    return float(((total.max("sample") - total.min("sample")) / size).max())


def _potential(case: xr.Dataset, force: xr.DataArray) -> xr.DataArray:
    """Potential of x″: −ρ² x²/2 − x/Γ₋ on the side of law +, x²/2 − x/Γ₋ on that of law −."""
    plus, minus = (case.effective_inertia_of_law.sel(law=law, drop=True) for law in (1, -1))
    x = xr.where(force * case.law_side.sel(law=1, drop=True) > 0, force / case.force_scale, force)
    stiffness = xr.where(x * case.law_side.sel(law=1, drop=True) > 0, case.force_scale * plus / minus, 1.0)
    return stiffness * x**2 / 2 - x / minus


def energy_check(dataset: xr.Dataset) -> Check:
    """Check that the energy integral is constant along the motions of the case without contact damping, the first."""
    spread = energy_spread(dataset.isel(case=0))
    return Check.holds(
        "Along each motion without contact damping the energy integral of (8.11) is constant, to 1e-12",
        "eqs 8.11, 8.12",
        f"largest spread {spread:.1e} of the larger of potential and kinetic part",
        spread < 1e-12,
    )


def newton_checks(dataset: xr.Dataset) -> list[Check]:
    """Check equilibria and eigenvalues against Newton's laws, of which the closed forms (8.11), (8.12) make no use."""
    gap = float(np.abs(dataset.equilibrium_contact_force / dataset.equilibrium_contact_force_by_newton - 1).max())
    first, second = (
        dataset.scaled_eigenvalue_real_part.isel(eigenvalue=k)
        + 1j * dataset.scaled_eigenvalue_imaginary_part.isel(eigenvalue=k)
        for k in (0, 1)
    )
    off = [
        np.abs(first + second - dataset.jacobian_trace) / np.abs(first),
        np.abs(first * second / dataset.jacobian_determinant - 1),
    ]
    return [
        Check.holds(
            "The equilibria are the zeros of N″ by the two equations of motion, to 1e-12",
            "eqs 8.6, 8.7, 8.11",
            f"largest relative difference {gap:.1e}",
            gap <= _ROUNDING,
        ),
        Check.holds(
            "The eigenvalues of each law are those of the Jacobian of N″ by the two equations of motion, to 1e-12",
            "eqs 8.6, 8.7, 8.12",
            f"their sum differs from its trace by {float(off[0].max()):.1e} of them, their product from its "
            f"determinant by {float(off[1].max()):.1e}",
            all(float(x.max()) <= _ROUNDING for x in off),
        ),
    ]
