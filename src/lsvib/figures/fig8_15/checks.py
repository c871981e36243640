"""The checks of figure 8.15: the critical friction, the classes by printed conditions and by LAPACK, the boundaries."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import printed
from lsvib.datasets.checks import Check
from lsvib.datasets.spans import evenly_chosen
from lsvib.models import chapter
from lsvib.models.drive import RigidDrive
from lsvib.stability import conditions
from lsvib.stability.conditions import critical_mass
from lsvib.stability.linear import UndampedClass, eigenvalues, support_model, values_of

_LAW = 1  # R Ω > 0
_SAME = 1e-9  # relative distance from a boundary within which rounding may decide the class
_SAMPLES = 100  # columns, and rows, of the map that are compared with LAPACK
_GROWS = 1e-7  # real part of a growing eigenvalue, relative; LAPACK keeps 1.5e-8 where two coincide
_PARAMETERS = ("mass", "screw_mass", "screw_inertia", "pitch_radius", "lead_angle", "coupling_stiffness")
DAMPINGS = ("support_damping", "translation_damping", "axial_support_damping")


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical friction, the classes by the printed conditions and by LAPACK, and the boundaries."""
    drive = {name: float(dataset[name]) for name in _PARAMETERS}
    grid = {
        **drive,
        "friction_coefficient": dataset.friction_coefficient.values[:, None],
        "support_stiffness": dataset.support_stiffness.values,
    }
    a_4, a_2, a_0 = conditions.characteristic_polynomial(grid, _LAW)
    discriminant, size = a_2**2 - 4 * a_0 * a_4, a_2**2 + 4 * a_0 * np.abs(a_4)
    inertia = drive["screw_inertia"] * (drive["mass"] + drive["screw_mass"])
    clear = (np.abs(discriminant) > _SAME * size) & (np.abs(a_4) > _SAME * inertia)
    return [
        *_critical_friction_checks(dataset),
        *_class_checks(dataset, drive, grid, clear),
        _overlap_check(dataset, a_4, discriminant),
        _region_check(dataset, grid, clear),
        *_branch_checks(dataset, drive),
        _necessary_check(dataset, drive),
        _reduced_mass_check(dataset, drive),
    ]


def _critical_friction_checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical friction against print and eigenvalues, and that it alone bounds the kinematic region."""
    critical = float(dataset.critical_friction)
    kinematic = dataset.stability.values == UndampedClass.KINEMATIC_CONSTRAINT
    right = kinematic == (dataset.friction_coefficient.values > critical)[:, None]
    return [
        printed.check(
            "Critical friction coefficient, root of Γ̃_0(μ) = 0", chapter.THRESHOLDS["critical_friction"], critical
        ),
        Check.exact(
            "Friction coefficient at which the eigenvalue 1/ω² passes through zero",
            "eqs 8.23, 8.27",
            critical,
            float(dataset.critical_friction_by_eigenvalues),
        ),
        Check.holds(
            "The kinematic boundary is the vertical line at the critical friction, at every support stiffness",
            "Sect. 8.8.1, Fig. 8.15",
            f"{int(np.sum(~right))} exceptions among {right.size} points",
            bool(right.all() and kinematic.any()),
        ),
    ]


def _class_checks(
    dataset: xr.Dataset, drive: Mapping[str, float], grid: Mapping[str, Any], clear: np.ndarray
) -> list[Check]:
    """Check the classes by the printed conditions and by LAPACK, where rounding does not decide (``clear``)."""
    wrong = int(np.sum(clear & (conditions.printed_class(grid, _LAW) != dataset.stability.values)))
    differ, compared = _against_lapack(dataset, drive, clear)
    return [
        Check.holds(
            "The classes by eigenvalues are those of the printed conditions (8.24) to (8.26)",
            "eqs 8.24 to 8.26",
            f"{wrong} exceptions among {int(clear.sum())} points; {int((~clear).sum())} within rounding of a boundary",
            wrong == 0 and bool(clear.mean() > 0.99),
        ),
        Check.without_exception(
            "LAPACK's eigenvalues of the state matrix give the same classes", "eq. 8.23", differ, compared
        ),
    ]


def _overlap_check(dataset: xr.Dataset, a_4: np.ndarray, discriminant: np.ndarray) -> Check:
    """Check by the signs of a_4 and of the discriminant of (8.24) that no point is in two regions."""
    kinds = dataset.stability.values
    flutter, kinematic = kinds == UndampedClass.FLUTTER, kinds == UndampedClass.KINEMATIC_CONSTRAINT
    both = int(np.sum((discriminant < 0) & kinematic) + np.sum((a_4 < 0) & flutter))
    return Check.holds(
        "The regions of mode coupling and of the kinematic constraint do not overlap, and neither is empty",
        "Lemma 8.2, Fig. 8.15",
        f"{both} points in both, {int(flutter.sum())} and {int(kinematic.sum())} in one",
        both == 0 and bool(flutter.any() and kinematic.any()),
    )


def _region_check(dataset: xr.Dataset, grid: Mapping[str, Any], clear: np.ndarray) -> Check:
    """Check that the closed boundaries enclose the region of mode coupling, and that divergence lies beyond them."""
    kinds, stiffness = dataset.stability.values, dataset.support_stiffness.values
    kinematic = kinds == UndampedClass.KINEMATIC_CONSTRAINT
    lower, upper = (
        dataset[name].reindex(boundary_friction_coefficient=dataset.friction_coefficient.values).values[:, None]
        for name in ("lower_boundary", "upper_boundary")
    )
    between = (stiffness > lower) & (stiffness < upper)
    divergence = (stiffness > upper) & (conditions.effective_inertia(grid, _LAW) < 0)
    expected = np.select([between, divergence], [UndampedClass.FLUTTER, UndampedClass.DIVERGENCE], UndampedClass.STABLE)
    off = int(np.sum(clear & ~kinematic & (kinds != expected)))
    return Check.holds(
        "Mode coupling lies between both closed branches, and divergence beyond the upper one where Γ_0 < 0",
        "eqs 8.25, 8.29",
        f"{off} exceptions among {int((clear & ~kinematic).sum())} points; "
        f"{int(np.sum(kinds == UndampedClass.DIVERGENCE))} of divergence",
        off == 0,
    )


def _branch_checks(dataset: xr.Dataset, drive: Mapping[str, float]) -> list[Check]:
    """Check both branches against the quadratic equation (8.29), and where they exist."""
    residual = _residual(dataset, drive)
    friction = dataset.friction_coefficient.values
    odd, real, rewritten = _real_branches(dataset, {**drive, "friction_coefficient": friction})
    return [
        Check.holds(
            "Both branches satisfy the printed quadratic equation (8.29), to 1e-11 of its largest term",
            "eq. 8.29",
            f"largest remainder {residual:.1e}",
            residual < 1e-11,
        ),
        Check.holds(
            "(8.30) and (8.31) hold together exactly where (8.32) does, and there both branches are finite; the "
            "printed form of (8.30) is equal to it, to 1e-12",
            "eqs 8.30, 8.31, 8.32",
            f"{odd} exceptions among {friction.size} friction coefficients; {real} of "
            f"{dataset.sizes['boundary_friction_coefficient']} places with both branches; the printed form differs by "
            f"{rewritten:.1e} of b_2²",
            odd == 0 and real == dataset.sizes["boundary_friction_coefficient"] and rewritten < 1e-12,
        ),
    ]


def _necessary_check(dataset: xr.Dataset, drive: Mapping[str, float]) -> Check:
    """Check the two necessary conditions of the kinematic constraint, μ > tan λ and R Ω > 0."""
    friction = dataset.friction_coefficient.values
    kinematic = dataset.stability.values == UndampedClass.KINEMATIC_CONSTRAINT
    early = int(kinematic[friction <= np.tan(drive["lead_angle"])].sum())
    own = {**drive, "friction_coefficient": friction}
    against = min(np.min(conditions.effective_inertia(own, -_LAW)), np.min(conditions.reduced_inertia(own, -_LAW)))
    return Check.holds(
        "The two necessary conditions of the kinematic constraint are μ > tan λ and R Ω > 0: it is active at no "
        "smaller μ, and under law −, whose effective inertia is positive, at none",
        "eq. 8.21, Remark 8.2, Sect. 8.9",
        f"{early} points of the region at μ <= tan λ; smallest effective inertia of law − {against:.3g} kg m2",
        early == 0 and against >= drive["screw_inertia"],
    )


def _reduced_mass_check(dataset: xr.Dataset, drive: Mapping[str, float]) -> Check:
    """Check Remark 8.3: with the critical friction the rigid drive's critical mass is m m_1 / (m + m_1)."""
    reduced_mass = drive["mass"] * drive["screw_mass"] / (drive["mass"] + drive["screw_mass"])
    locked = RigidDrive.of(
        {name: drive[name] for name in _PARAMETERS if name != "screw_mass"},
        friction_coefficient=float(dataset.critical_friction),
    )
    return Check.exact(
        "The rigid drive with the critical friction has the reduced mass as its critical mass",
        "Remark 8.3",
        reduced_mass,
        critical_mass(locked) or np.nan,
        "kg",
    )


def _real_branches(dataset: xr.Dataset, own: Mapping[str, Any]) -> tuple[int, int, float]:
    """Exceptions to (8.30) ∧ (8.31) ⇔ (8.32), places of two finite branches, and the distance of (8.30) from its form.

    ``own``: parameters with the friction coefficients of the map. Where (8.30) is zero to rounding it does not count.
    """
    b_1, b_2, b_3 = conditions.boundary_coefficients(own, _LAW)
    p = values_of(own, _LAW)
    lever, total = p.factor * p.pitch_radius**2 * p.tan_lead, p.mass + p.screw_mass
    discriminant = b_2**2 - 4 * b_1 * b_3
    reduced = conditions.reduced_inertia(own, _LAW)
    form = 16 * lever * p.mass**2 * total * reduced
    clear = np.abs(discriminant) > _SAME * b_2**2
    together = (discriminant >= 0) & (b_2 < 0)
    odd = int(np.sum(clear & (together != ((reduced >= 0) & (p.factor > 0)))))
    finite = np.isfinite(dataset.lower_boundary.values) & ~np.isnan(dataset.upper_boundary.values)
    return odd, int(finite.sum()), float(np.max(np.abs(discriminant - form) / b_2**2))


def _residual(dataset: xr.Dataset, drive: Mapping[str, float]) -> float:
    """Largest remainder [1] of (8.29) on both branches, relative to its largest term."""
    own = {**drive, "friction_coefficient": dataset.boundary_friction_coefficient.values}
    b_1, b_2, b_3 = conditions.boundary_coefficients(own, _LAW)
    k = drive["coupling_stiffness"]
    terms = [
        np.stack([b_1 * branch**2, b_2 * k * branch, b_3 * k**2 * np.ones_like(branch)])
        for branch in (dataset.lower_boundary.values, dataset.upper_boundary.values)
    ]
    return float(max(np.max(np.abs(term.sum(axis=0)) / np.abs(term).max(axis=0)) for term in terms))


def _against_lapack(dataset: xr.Dataset, drive: Mapping[str, float], clear: np.ndarray) -> tuple[int, int]:
    """Number of points with another class by LAPACK's eigenvalues of the state matrix, and of points compared."""
    rows, columns = (evenly_chosen(dataset.sizes[name], _SAMPLES) for name in dataset.stability.dims)
    part = dataset.isel(friction_coefficient=rows, support_stiffness=columns)
    own = {
        **drive,
        **dict.fromkeys(DAMPINGS, 0.0),
        "friction_coefficient": part.friction_coefficient.values[:, None],
        "support_stiffness": part.support_stiffness.values,
    }
    values = eigenvalues(support_model(own, _LAW))
    limit = _GROWS * np.abs(values).max(axis=-1)
    growing = (values.real > limit[..., None]).sum(axis=-1)
    oscillates = np.abs(values[..., -1].imag) > limit
    theirs = np.select(
        [growing == 0, oscillates, growing == 1],
        [UndampedClass.STABLE, UndampedClass.FLUTTER, UndampedClass.KINEMATIC_CONSTRAINT],
        UndampedClass.DIVERGENCE,
    )
    compared = clear[np.ix_(rows, columns)]
    return int(np.sum(compared & (theirs != part.stability.values))), int(compared.sum())
