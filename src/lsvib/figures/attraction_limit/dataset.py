"""The region of attraction of a compliant contact tends to that of the rigid drive as the contact stiffens."""

from collections.abc import Mapping
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
from lsvib.data.attraction_map import axis_coordinate, window_of
from lsvib.data.checks import Check
from lsvib.data.parameter_origins import axis, drive_parameters
from lsvib.data.phase_plane import attributes
from lsvib.drives.parameters import RigidParameters, ThreadsParameters
from lsvib.errors import InputError

_HALVINGS = 40  # of a ray, until its boundary is known to 1e-12 of its length
_SMALL = 0.01  # displacements above it are left out of the order: they are no longer in proportion
_TIME = 1.0  # damping over stiffness of the contact [s]
_ARC = 200  # samples of an arc of the exact boundary
_EXACT = 1e-9  # of a ray: the label changes on the exact boundary; bisection goes to 1e-12, followed motions less far


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compare planar slices (seated contact) with the map of the rigid drive.

    ``settings``: ``drive``; ``grid``, the box in u and w; ``stiffnesses`` [N/m], the damping c_c being as large in
    N s/m; ``rays``, straight lines from steady sliding to an ellipse within the box, on each of which the boundary is
    found by bisection. Raises ``InputError``, also if a ray ends within the basin.
    """
    drive, grid = RigidParameters.of(settings["drive"]), Grid.of(settings["grid"])
    stiffness = np.array(settings["stiffnesses"], dtype=float)
    rigid = mapper(drive)
    label = rigid.cells(grid, quantities=("label",))["label"]
    angle = 2 * np.pi * (np.arange(settings["rays"]) + 0.5) / settings["rays"]
    ends = np.array(
        [0.5 * (grid.x.stop - grid.x.start) * np.cos(angle), 0.5 * (grid.y.stop - grid.y.start) * np.sin(angle)]
    )
    radius = _boundary(rigid, ends)
    labels, displacement = [], []
    for k in stiffness:
        compliant = mapper(
            ThreadsParameters.of({**dict(drive), "contact_stiffness": k, "contact_damping": _TIME * k}), "threads"
        )
        labels.append(compliant.cells(grid, quantities=("label",))["label"])
        displacement.append(_boundary(compliant, ends) / radius - 1)
    displacement = np.array(displacement)
    typical = np.sqrt(np.mean(displacement**2, axis=1))
    order, error = fitted_order(stiffness, np.where(typical < _SMALL, typical, np.nan))
    plane = ("velocity_deviation", "angle_deviation")
    exact = basin(drive)
    line = exact.line(window_of(grid), _ARC)
    on_rays = np.array([radius, *((displacement + 1) * radius)])[:, None] * ends
    per_ray = attributes("1", "displacement of the boundary along a ray, relative to the rigid drive's")
    return xr.Dataset(
        {
            "rigid_attractor": (plane, label, phase_plane.flag(f"{phase_plane.ATTRACTOR}, of the rigid drive",
                Attractor)),
            "attractor": (("contact_stiffness", *plane), np.array(labels), phase_plane.flag(phase_plane.ATTRACTOR,
                Attractor)),
            "different": ("contact_stiffness", [np.mean(other != label) for other in labels],
                          attributes("1", "fraction of the cells whose attractor is not the rigid drive's")),
            "displacement": (("contact_stiffness", "ray"), displacement, per_ray),
            "typical_displacement": ("contact_stiffness", typical,
                                     attributes("1", "root mean square displacement of the boundary")),
            "boundary_angle": ("boundary_point", line[:, 0],
                               attributes("rad", "deviation on the exact boundary", "$u$")),
            "boundary_velocity": ("boundary_point", line[:, 1],
                                  attributes("rad s-1", "rate of the deviation on the exact boundary",
                                             r"$\dot u$")),
            "rigid_ray_angle": ("ray", on_rays[0, 0],
                                attributes("rad", "deviation at which the label of the rigid drive changes on a ray",
                                           "$u$")),
            "rigid_ray_velocity": ("ray", on_rays[0, 1],
                                   attributes("rad s-1", "rate at which the label of the rigid drive changes on a ray",
                                              r"$\dot u$")),
            "ray_angle": (("contact_stiffness", "ray"), on_rays[1:, 0],
                          attributes("rad", "deviation at which the label changes on a ray", "$u$")),
            "ray_velocity": (("contact_stiffness", "ray"), on_rays[1:, 1],
                             attributes("rad s-1", "rate at which the label changes on a ray", r"$\dot u$")),
            "on_exact_boundary": ("ray", _crossed(exact, radius, ends),
                                  attributes("1", f"the exact boundary crosses the ray there, to {_EXACT:g} of it",
                                             flag_values=np.array([0, 1], dtype=np.int8), flag_meanings="no yes")),
            "order": ((), order, attributes("1", "order of the displacement in one over the stiffness")),
            "order_error": ((), error, attributes("1", "standard error of the order")),
        },
        coords={
            **axis("contact_stiffness", stiffness),
            **axis("contact_damping", _TIME * stiffness, "contact_stiffness"),
            **drive_parameters(drive, printed=("Fig. 8.14", "Sect. 8.6")),
            "ray": ("ray", angle, attributes("rad", "direction of the ray, in halves of the box")),
            **_plane(grid),
        },
        attrs={
            "title": "Region of attraction as the contact stiffens",
            "source": "lsvib, exact event-driven motion from the middle of every cell, and bisection along rays",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sects 5.5 and 8.7",
        },
    )  # fmt: skip


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that the slices tend to the rigid map, in first order, no cell left open, and the exact boundary."""
    stiffness, typical, order = (
        dataset.contact_stiffness.values,
        dataset.typical_displacement.values,
        float(dataset.order),
    )
    unresolved = int((dataset.attractor == Attractor.UNRESOLVED).sum())
    return [
        Check.holds(
            "The region of attraction of the compliant contact tends to that of the rigid drive",
            "Sects 5.5, 8.7",
            f"boundary displaced by {typical[0]:.2g} at {stiffness[0]:.0e} N/m and by {typical[-1]:.2g} at "
            f"{stiffness[-1]:.0e} N/m, order {order:.3f} ± {float(dataset.order_error):.3f}; {unresolved} unresolved",
            bool((np.diff(typical) < 0).all() and order > 0.9 and unresolved == 0),
        ),
        Check.holds(
            "The labels of the rigid drive change on the exact boundary of its basin, to 1e-9 of every ray",
            "Sect. 8.7, docs/basin.md",
            f"{int(dataset.on_exact_boundary.sum())} of {dataset.sizes['ray']} rays",
            bool((dataset.on_exact_boundary == 1).all()),
        ),
    ]


def _crossed(exact: Basin, radius: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Whether the exact boundary lies between two points of each ray, closely before and behind ``radius``."""
    pairs = [(part * (1 - _EXACT) * end, part * (1 + _EXACT) * end) for part, end in zip(radius, ends.T, strict=True)]
    return np.array([exact.contains(low) and not exact.contains(high) for low, high in pairs], dtype=np.int8)


def _plane(grid: Grid) -> dict[str, tuple]:
    return {"angle_deviation": axis_coordinate(grid.x), "velocity_deviation": axis_coordinate(grid.y)}


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
