"""Rotating nut: critical mass against the inertia of the nut (Remark 8.6), and the stability map of (8.33)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import spans
from lsvib.datasets.attributes import (
    CRITICAL_MASS,
    Variables,
    axis,
    drive_parameters,
    flagged,
    origin_of,
    parameter,
    variable,
)
from lsvib.datasets.checks import Check
from lsvib.datasets.spans import evenly_chosen
from lsvib.errors import InputError
from lsvib.models.drive import NutDrive
from lsvib.numbers import bisected
from lsvib.stability.conditions import critical_mass, effective_screw_inertia, kinematic_inertia, kinematic_mass
from lsvib.stability.linear import (
    UndampedClass,
    determinant,
    eigenvalues,
    nut_model,
    reciprocal_squares,
    undamped_class,
    values_of,
)

_LAW = 1  # R Ω > 0
_SAME = 1e-9  # relative distance from (8.33) within which rounding may decide
_CLOSE = 0.01  # to the rigid drive, with the heaviest nut
_SAMPLES = 40  # columns, and rows, of the map that are compared with damping
_PARAMETERS = (
    *("mass", "screw_inertia", "pitch_radius", "lead_angle", "coupling_stiffness", "support_damping"),
    *("translation_damping", "nut_stiffness", "nut_damping"),
)


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the critical mass over the inertia of the nut, in closed form and by eigenvalues, and the class map.

    ``settings``: see ``Settings``; c_x = 0, and the mass of ``drive`` is that of the map. Raises ``InputError``.
    """
    drive = NutDrive.of(settings["drive"])
    rigid = critical_mass(drive)
    if rigid is None:
        raise InputError("The drive is not self-locking (mu <= tan lambda), so it has no critical mass.")
    inertia = spans.logarithmic(settings["nut_inertia"])
    friction = spans.even(settings["friction_coefficient"])
    drive.replace(friction_coefficient=float(friction.max()))  # refuses what is beyond cot λ
    edge = _boundary_friction(drive, inertia)
    from_which_on = "friction coefficient from which on (8.33) holds, missing if from none"
    own, drawn = drive.friction_coefficient, "drawn_friction_coefficient"
    origin = origin_of("friction_coefficient", own)
    return xr.Dataset(
        _critical_masses(drive, inertia, rigid) | _class_map(drive, friction, inertia),
        coords={
            "critical_friction_with_nut": variable("nut_inertia", edge, "1", from_which_on, r"$\mu$"),
            **axis("nut_inertia", inertia),
            **axis("friction_coefficient", friction),
            "critical_mass": ((), rigid, CRITICAL_MASS),
            drawn: ((), own, parameter(drawn, origin, comment="of the critical masses")),
            **drive_parameters(
                drive,
                axes=("nut_inertia", "friction_coefficient"),
                printed=("Sect. 8.6",),
                no_effect=("input_speed", "axial_force", "slide_friction", "bearing_friction"),
            ),
        },
        attrs={
            "title": "Stability of steady sliding with a rotating nut",
            "source": "lsvib, generalised eigenvalues of the matrices of Sect. 8.8.2, condition (8.33) in closed form",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.8.2, eq. 8.33, Remarks 8.5 and 8.6; docs/lemmas.md",
            "comment": "R Omega > 0; the dampings enter only where a check repeats the classes with damping",
        },
    )


def _critical_masses(drive: NutDrive, inertia: np.ndarray, rigid: float) -> Variables:
    """Critical mass [kg] over the inertia of the nut [kg m²], both ways; that of the rigid drive bounds it."""
    nuts = [drive.replace(nut_inertia=float(value)) for value in inertia]
    closed, passing = [kinematic_mass(nut) for nut in nuts], [_by_eigenvalues(nut, rigid) for nut in nuts]
    found = {
        "critical_mass_with_nut": (closed, "in closed form"),
        "critical_mass_with_nut_by_eigenvalues": (passing, "where an eigenvalue 1/omega^2 passes through zero"),
    }
    return {
        name: variable("nut_inertia", masses, "kg", f"critical mass, {words}", r"$m_\mathrm{cr}$")
        for name, (masses, words) in found.items()
    }


def _class_map(drive: NutDrive, friction: np.ndarray, inertia: np.ndarray) -> Variables:
    """Class of the steady sliding over friction coefficient and inertia of the nut [kg m²], and where (8.33) begins."""
    grid = {**dict(drive), "friction_coefficient": friction[:, None], "nut_inertia": inertia}
    kinds, dims = undamped_class(nut_model(grid, _LAW)), ("friction_coefficient", "nut_inertia")
    begins = "inertia of the nut at which (8.33) begins to hold, missing if at none"
    return {
        "stability": flagged(dims, kinds, "class of the steady sliding", UndampedClass, comment="undamped"),
        "boundary_nut_inertia": variable(dims[0], _boundary(drive, friction), "kg m2", begins, "$I_2$"),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the map against (8.33) and det M_0, with damping too, and the critical mass against Remark 8.6."""
    drive = {name: float(dataset[name]) for name in _PARAMETERS}
    grid = {
        **drive,
        "friction_coefficient": dataset.friction_coefficient.values[:, None],
        "nut_inertia": dataset.nut_inertia.values,
    }
    clear = np.abs(kinematic_inertia(grid, _LAW)) > _SAME * effective_screw_inertia(grid)
    return [
        *_class_checks(dataset, grid, clear),
        _damping_check(dataset, drive, clear),
        *_boundary_checks(dataset, drive, clear),
        *_critical_mass_checks(dataset, drive),
    ]


def _class_checks(dataset: xr.Dataset, grid: Mapping[str, Any], clear: np.ndarray) -> list[Check]:
    """Check the classes against (8.33) and the printed inertia matrix, where rounding does not decide (``clear``)."""
    kinds = dataset.stability.values
    kinematic = kinds == UndampedClass.KINEMATIC_CONSTRAINT
    wrong = int(np.sum(clear & (kinematic != (kinematic_inertia(grid, _LAW) < 0))))
    other = int(np.sum(~kinematic & (kinds != UndampedClass.STABLE)))
    opposite = np.sum(clear & ((determinant(nut_model(grid, _LAW).mass) < 0) != kinematic))
    return [
        Check.holds(
            "The class by eigenvalues is kinematic exactly where (8.33) holds",
            "eq. 8.33",
            f"{wrong} exceptions among {int(clear.sum())} points, {int(kinematic.sum())} of them kinematic",
            wrong == 0 and bool(kinematic.any() and not kinematic.all()),
        ),
        Check.holds(
            "Steady sliding is lost neither by flutter nor by divergence",
            "Sect. 8.8.2",
            f"{other} of {kinds.size} points",
            other == 0,
        ),
        Check.without_exception(
            "(8.33) is det M_0 < 0, the printed inertia matrix", "Remark 8.5, eq. 8.33", opposite, clear.sum()
        ),
    ]


def _damping_check(dataset: xr.Dataset, drive: Mapping[str, float], clear: np.ndarray) -> Check:
    """Check at evenly chosen points that damping does not change the classes."""
    rows, columns = (evenly_chosen(dataset.sizes[name], _SAMPLES) for name in dataset.stability.dims)
    part = dataset.isel(friction_coefficient=rows, nut_inertia=columns)
    own = {
        **drive,
        "friction_coefficient": part.friction_coefficient.values[:, None],
        "nut_inertia": part.nut_inertia.values,
    }
    grows = eigenvalues(nut_model(own, _LAW))[..., -1].real > 0
    compared = clear[np.ix_(rows, columns)]
    differ = compared & (grows != (part.stability.values == UndampedClass.KINEMATIC_CONSTRAINT))
    claim = "With damping of screw and nut the real parts of LAPACK's eigenvalues give the same classes"
    return Check.without_exception(claim, "Sect. 8.8.2, docs/lemmas.md", differ.sum(), compared.sum())


def _boundary_checks(dataset: xr.Dataset, drive: Mapping[str, float], clear: np.ndarray) -> list[Check]:
    """Check both closed forms of the boundary (8.33): over the friction coefficient and over the nut's inertia."""
    kinematic = dataset.stability.values == UndampedClass.KINEMATIC_CONSTRAINT
    side = np.sum(clear & (kinematic == _stable_side(dataset)))
    edge = dataset.critical_friction_with_nut.values
    on_edge = {**drive, "friction_coefficient": edge, "nut_inertia": dataset.nut_inertia.values}
    left = float(np.nanmax(np.abs(kinematic_inertia(on_edge, _LAW)) / effective_screw_inertia(on_edge)))
    return [
        Check.without_exception(
            "The boundary in closed form parts the classes at every friction coefficient", "eq. 8.33", side, clear.sum()
        ),
        Check.holds(
            "On the boundary over the inertia of the nut (8.33) is an equality, to 1e-12 of the effective inertia",
            "eq. 8.33",
            f"largest remainder {left:.1e} at {int(np.isfinite(edge).sum())} of {edge.size} inertias",
            left < 1e-12,
        ),
    ]


def _critical_mass_checks(dataset: xr.Dataset, drive: Mapping[str, float]) -> list[Check]:
    """Check the critical mass against Remark 8.6, by eigenvalues, and for a light and a heavy nut."""
    inertia, rigid = dataset.nut_inertia.values, float(dataset.critical_mass)
    own, theirs = dataset.critical_mass_with_nut.values, dataset.critical_mass_with_nut_by_eigenvalues.values
    factor = own / rigid * (drive["screw_inertia"] + inertia) / inertia
    return [
        Check.exact(
            "Critical mass over that of the rigid drive times I_2 / (I + I_2), worst inertia of the nut",
            "Remark 8.6",
            1.0,
            float(factor[np.argmax(np.abs(factor - 1))]),
        ),
        Check.within(
            "Critical mass by eigenvalues over that in closed form, worst inertia of the nut",
            "eq. 8.33",
            1.0,
            float((theirs / own)[np.argmax(np.abs(theirs / own - 1))]),
            1e-9,
            "1",
            "an eigenvalue that passes through zero, in doubles",
        ),
        Check.holds(
            f"A nut that turns lowers the critical mass, the more the lighter it is; a heavy one hardly, "
            f"less than {_CLOSE:.0%}",
            "Remark 8.6",
            f"from {own[0]:.3g} kg to {own[-1]:.5g} kg, rigid {rigid:.5g} kg",
            bool((np.diff(own) > 0).all()) and own[-1] < rigid < own[-1] * (1 + _CLOSE),
        ),
    ]


def _by_eigenvalues(drive: NutDrive, rigid: float) -> float:
    """Mass [kg] at which the product of both 1/ω² changes its sign, by bisection; between zero and the rigid one."""

    def lost(mass: float) -> bool:
        squares = reciprocal_squares(nut_model({**dict(drive), "mass": mass}, _LAW))
        return not np.prod(np.sign(squares.real)) > 0

    return bisected(lost, 0.0, rigid)


def _boundary(drive: NutDrive, friction: np.ndarray) -> np.ndarray:
    """I_2 = I q / (I − q) [kg m²] with q = ξ₊ tan λ m r_m², where I_eff = q; NaN unless 0 < q < I."""
    p = values_of({**dict(drive), "friction_coefficient": friction}, _LAW)
    q = p.factor * p.tan_lead * p.mass * p.pitch_radius**2
    gamma = p.screw_inertia - q
    with np.errstate(divide="ignore"):
        return np.where((q > 0) & (gamma > 0), p.screw_inertia * q / gamma, np.nan)


def _boundary_friction(drive: NutDrive, inertia: np.ndarray) -> np.ndarray:
    """μ = (ξ + tan λ) / (1 − ξ tan λ) with ξ = I_eff / (tan λ m r_m²), where I_eff = q; NaN if not below cot λ."""
    tangent = np.tan(drive.lead_angle)
    xi = effective_screw_inertia({**dict(drive), "nut_inertia": inertia}) / (
        tangent * drive.mass * drive.pitch_radius**2
    )
    below = (xi * tangent < 1) & ((xi + tangent) * tangent < 1 - xi * tangent)
    with np.errstate(divide="ignore"):
        return np.where(below, (xi + tangent) / (1 - xi * tangent), np.nan)


def _stable_side(dataset: xr.Dataset) -> np.ndarray:
    """Points that the boundary says are stable: beyond it; where there is none, all without self-locking."""
    boundary = dataset.boundary_nut_inertia.values[:, None]
    locking = (dataset.friction_coefficient.values > np.tan(float(dataset.lead_angle)))[:, None]
    return np.where(np.isnan(boundary), ~locking, dataset.nut_inertia.values > boundary)
