"""The region of attraction of a compliant contact tends to that of the rigid drive as the contact stiffens."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from lsvib.basins.cells import Mapper
from lsvib.basins.exact_basin import Basin, basin
from lsvib.basins.grid import Grid
from lsvib.basins.mapper import mapper
from lsvib.contact.limit_process import fitted_order
from lsvib.cycles.attractors import Attractor
from lsvib.data import phase_plane
from lsvib.data.attraction_map import axis_coordinate, grid_window
from lsvib.data.attributes import flagged, variable, yes_no
from lsvib.data.checks import Check
from lsvib.data.parameter_origins import axis, drive_parameters
from lsvib.drives.parameters import RigidParameters, ThreadsParameters
from lsvib.errors import InputError

_HALVINGS = 40  # of a ray, until its boundary is known to 1e-12 of its length
_SMALL = 0.01  # displacements above it are left out of the order: they are no longer in proportion
_TIME = 1.0  # damping over stiffness of the contact [s]
_ARC = 200  # samples of an arc of the exact boundary
_EXACT = 1e-9  # of a ray: the label changes on the exact boundary; bisection goes to 1e-12, followed motions less far


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compare planar slices (seated contact) with the map of the rigid drive.

    ``settings``: see ``Settings``; on each ray, from steady sliding to an ellipse within the box, the boundary is found
    by bisection. Raises ``InputError``, also if a ray ends within the basin.
    """
    drive, grid = RigidParameters.of(settings["drive"]), Grid.of(settings["grid"])
    stiffness = np.array(settings["stiffnesses"], dtype=float)
    angle = 2 * np.pi * (np.arange(settings["rays"]) + 0.5) / settings["rays"]
    ends = np.array(
        [0.5 * (grid.x.stop - grid.x.start) * np.cos(angle), 0.5 * (grid.y.stop - grid.y.start) * np.sin(angle)]
    )
    rigid = mapper(drive)
    compliant = [
        mapper(ThreadsParameters.of({**dict(drive), "contact_stiffness": k, "contact_damping": _TIME * k}), "threads")
        for k in stiffness
    ]
    radius = _boundary(rigid, ends)
    displacement = np.array([_boundary(mapped, ends) / radius - 1 for mapped in compliant])
    exact, crossing = basin(drive), f"the exact boundary crosses the ray there, to {_EXACT:g} of it"
    return xr.Dataset(
        _maps(grid, rigid, compliant)
        | _displacements(stiffness, displacement)
        | phase_plane.curve("boundary", "boundary_point", exact.line(grid_window(grid), _ARC), "on the exact boundary")
        | _on_rays(np.array([radius, *((displacement + 1) * radius)])[:, None] * ends)
        | {"on_exact_boundary": yes_no("ray", _crossed(exact, radius, ends), crossing)},
        coords={
            **axis("contact_stiffness", stiffness),
            **axis("contact_damping", _TIME * stiffness, "contact_stiffness"),
            **drive_parameters(drive, printed=("Fig. 8.14", "Sect. 8.6")),
            "ray": variable("ray", angle, "rad", "direction of the ray, in halves of the box"),
            "angle_deviation": axis_coordinate(grid.x),
            "velocity_deviation": axis_coordinate(grid.y),
        },
        attrs={
            "title": "Region of attraction as the contact stiffens",
            "source": "lsvib, exact event-driven motion from the middle of every cell, and bisection along rays",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sects 5.5 and 8.7",
        },
    )


def _maps(grid: Grid, rigid: Mapper, compliant: Sequence[Mapper]) -> phase_plane.Variables:
    """The attractor of each cell, of the rigid drive and with each contact, and how many cells differ."""
    plane = ("velocity_deviation", "angle_deviation")
    label, *labels = (mapped.cells(grid, quantities=("label",))["label"] for mapped in (rigid, *compliant))
    different, words = [np.mean(other != label) for other in labels], "whose attractor is not the rigid drive's"
    return {
        "rigid_attractor": flagged(plane, label, f"{phase_plane.ATTRACTOR}, of the rigid drive", Attractor),
        "attractor": flagged(("contact_stiffness", *plane), labels, phase_plane.ATTRACTOR, Attractor),
        "different": variable("contact_stiffness", different, "1", f"fraction of the cells {words}"),
    }


def _displacements(stiffness: np.ndarray, displacement: np.ndarray) -> phase_plane.Variables:
    """How far the boundary of each contact [N/m] lies from that of the rigid drive, relative (contact stiffness, ray).

    Over all rays the root mean square; the order in which that falls with the stiffness, from those that are small.
    """
    typical = np.sqrt(np.mean(displacement**2, axis=1))
    order, error = fitted_order(stiffness, np.where(typical < _SMALL, typical, np.nan))
    words = "displacement of the boundary along a ray, relative to the rigid drive's"
    mean = "root mean square displacement of the boundary"
    return {
        "displacement": variable(("contact_stiffness", "ray"), displacement, "1", words),
        "typical_displacement": variable("contact_stiffness", typical, "1", mean),
        "order": variable((), order, "1", "order of the displacement in one over the stiffness"),
        "order_error": variable((), error, "1", "standard error of the order"),
    }


def _on_rays(points: np.ndarray) -> phase_plane.Variables:
    """The states (drive, u and w, ray) at which the label changes; the first drive is rigid, others have contacts."""
    angle, velocity = "deviation at which the label", "rate at which the label"
    rigid, compliant = "of the rigid drive changes on a ray", "changes on a ray"
    dims = ("contact_stiffness", "ray")
    return {
        "rigid_ray_angle": variable("ray", points[0, 0], "rad", f"{angle} {rigid}", "$u$"),
        "rigid_ray_velocity": variable("ray", points[0, 1], "rad s-1", f"{velocity} {rigid}", r"$\dot u$"),
        "ray_angle": variable(dims, points[1:, 0], "rad", f"{angle} {compliant}", "$u$"),
        "ray_velocity": variable(dims, points[1:, 1], "rad s-1", f"{velocity} {compliant}", r"$\dot u$"),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that the slices tend to the rigid map, in first order, no cell left open, and the exact boundary."""
    stiffness, typical = dataset.contact_stiffness.values, dataset.typical_displacement.values
    order = float(dataset.order)
    unresolved = int((dataset.attractor == Attractor.UNRESOLVED).sum())
    return [
        Check.holds(
            "The region of attraction of the compliant contact tends to that of the rigid drive",
            "Sects 5.5, 8.7",
            f"boundary displaced by {typical[0]:.2g} at {stiffness[0]:.0e} N/m and by {typical[-1]:.2g} at "
            f"{stiffness[-1]:.0e} N/m, order {order:.3f} ± {float(dataset.order_error):.3f}; {unresolved} unresolved",
            bool((np.diff(typical) < 0).all() and order > 0.9 and unresolved == 0),
        ),
        Check.everywhere(
            "The labels of the rigid drive change on the exact boundary of its basin, to 1e-9 of every ray",
            "Sect. 8.7, docs/basin.md",
            dataset.on_exact_boundary == 1,
            "rays",
        ),
    ]


def _crossed(exact: Basin, radius: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Whether the exact boundary lies between two points of each ray, closely before and behind ``radius``."""
    pairs = [(part * (1 - _EXACT) * end, part * (1 + _EXACT) * end) for part, end in zip(radius, ends.T, strict=True)]
    return np.array([exact.contains(low) and not exact.contains(high) for low, high in pairs], dtype=np.int8)


def _boundary(mapped: Mapper, ends: np.ndarray) -> np.ndarray:
    """Parts (n) of rays from steady sliding to ``ends`` (u and w, n) at which the label changes, by bisection."""

    def inside(part: np.ndarray) -> np.ndarray:
        return mapped.labels_of(*(part * ends)) == Attractor.STEADY_SLIDING

    low, high = np.zeros(ends.shape[1]), np.ones(ends.shape[1])
    beyond = int(inside(high).sum())
    if beyond:
        raise InputError(
            f"grid: {beyond} of {high.size} rays end within the basin of steady sliding, whose boundary they are to "
            "cross; widen u or w."
        )
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        attracted = inside(middle)
        low, high = np.where(attracted, middle, low), np.where(attracted, high, middle)
    return 0.5 * (low + high)
