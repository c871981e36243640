"""The checks of `basin_sweep`: the claims of Sect. 8.7 on the basin, and exact areas against grids."""

import numpy as np
import xarray as xr

from lsvib.basins.boundary import Boundary
from lsvib.datasets.checks import Check

_NONE = 1e-12  # error of a fraction that counts as none where its logarithm is taken


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the claims of Sect. 8.7 on the basin, and exact areas against grids."""
    return [
        *_global_stability_checks(dataset),
        *_reading_checks(dataset),
        _scaling_check(dataset),
        _grid_check(dataset),
    ]


def _global_stability_checks(dataset: xr.Dataset) -> list[Check]:
    """Check along all four sweeps that the basin is the whole plane exactly on one side of a critical value."""
    force, fraction = dataset.swept_axial_force.values, dataset.fraction_axial_force.values
    threshold = float(dataset.global_stability_force)
    beyond = force < threshold
    damping, limit = dataset.swept_support_damping.values, dataset.swept_global_stability_force.values
    stable = dataset.boundary_kind_support_damping.values == Boundary.NONE
    heaviest, roughest = (
        float(
            dataset[f"swept_{name}"]
            .values[dataset[f"boundary_kind_{name}"].values == Boundary.NONE]
            .max(initial=-np.inf)
        )
        for name in ("mass", "friction_coefficient")
    )
    return [
        Check.holds(
            "Steady sliding is globally stable exactly where -R exceeds a threshold; else its basin is a subset",
            "end of Sect. 8.7",
            f"R < {threshold:.10g} N: {int((fraction[beyond] == 1).sum())} of {int(beyond.sum())} forces; R above it: "
            f"{int((fraction[~beyond] < 1).sum())} of {int((~beyond).sum())}",
            bool((fraction[beyond] == 1).all() and (fraction[~beyond] < 1).all()) and 0 < beyond.sum() < beyond.size,
        ),
        Check.holds(
            "Over the damping, too, the basin is the whole plane exactly where R lies beyond the threshold",
            "end of Sect. 8.7",
            f"{int(stable.sum())} of {stable.size} dampings, c >= {damping[stable].min(initial=np.inf):.6g} N m s/rad",
            bool((stable == (limit > float(dataset.axial_force))).all()),
        ),
        Check.holds(
            "Over mass and friction the basin is the whole plane exactly up to the critical values, where the "
            "effective inertia of law + vanishes",
            "Sect. 8.7, eq. 8.20",
            f"m_cr = {float(dataset.critical_mass):.10g} kg, last mass with the whole plane {heaviest:.10g} kg; "
            f"mu_cr = {float(dataset.critical_friction_of_rigid_drive):.10g}, last friction {roughest:.10g}",
            _parts(dataset, "mass", "critical_mass")
            and _parts(dataset, "friction_coefficient", "critical_friction_of_rigid_drive"),
        ),
    ]


def _reading_checks(dataset: xr.Dataset) -> list[Check]:
    """Check the fractions of the window at both forces of Fig. 8.14, for the printed mass and for one beyond m_cr."""
    reading = dataset.reading_fraction.values
    return [
        Check.holds(
            "The basin can be quite small: less than 1 % of the window at the force of Fig. 8.14b",
            "Sect. 8.7",
            f"{100 * reading[1, 1]:.6g} %",
            bool(reading[1, 1] < 0.01),
        ),
        Check.holds(
            "As printed steady sliding attracts the whole window at both forces of Fig. 8.14, beyond m_cr at (a) alone",
            "Sect. 8.7, Fig. 8.14",
            f"fractions {', '.join(f'{x:.6g}' for x in reading.ravel())}",
            bool((reading[0] == 1).all() and reading[1, 0] == 1),
        ),
    ]


def _scaling_check(dataset: xr.Dataset) -> Check:
    """Check how the area of the basin grows with the force."""
    force = dataset.swept_axial_force.values
    touching = dataset.boundary_kind_axial_force.values == Boundary.TOUCHING_MOTION
    scaled = dataset.basin_area_axial_force.values[touching] / force[touching] ** 2
    spread = float(np.ptp(scaled) / scaled.max()) if scaled.size else np.nan
    return Check.holds(
        "Where a motion that touches N = 0 bounds the basin, its area grows with the square of the force, to 1e-12",
        "slip does not depend on R, so lengths are in proportion to it",
        f"relative spread of area / R^2 over {int(touching.sum())} forces {spread:.1e}",
        spread < 1e-12 and touching.sum() > 1,
    )


def _grid_check(dataset: xr.Dataset) -> Check:
    """Check the exact fractions of the cases against those which are counted on grids."""
    error = np.abs(dataset.grid_fraction - dataset.case_fraction)
    worst = float((error / dataset.grid_bound).max())
    order = [-np.polyfit(np.log(dataset.resolution), np.log(np.maximum(e, _NONE)), 1)[0] for e in error.values]
    return Check.holds(
        "The fraction counted on grids of starts tends to the exact one, at first order or better",
        "each start labelled without the boundary",
        f"errors at most {worst:.2g} of the area of the cells that the boundary cuts; fitted orders "
        f"{', '.join(f'{x:.2f}' for x in order)}",
        worst <= 1,
    )


def _parts(dataset: xr.Dataset, name: str, critical: str) -> bool:
    """Whether a critical value parts the drives whose basin is the whole plane from the others, and both exist."""
    whole = dataset[f"boundary_kind_{name}"].values == Boundary.NONE
    return bool(
        (whole == (dataset[f"swept_{name}"].values <= float(dataset[critical]))).all()
        and whole.any()
        and not whole.all()
    )
