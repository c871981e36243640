"""Regions of attraction as a CF dataset: what becomes of every start of a grid, with the lines and cycles around it."""

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers, words
from lsvib.answers import attributes as cf
from lsvib.answers import phase_plane
from lsvib.answers.io import read_dataset, rows_of, write_dataset
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.model import model_of
from lsvib.drives.names import Event
from lsvib.dynamics.boundary import known_basin
from lsvib.dynamics.curves import Window
from lsvib.errors import InputError
from lsvib.files import File
from lsvib.systems.attractor import Attractor, Doubt
from lsvib.systems.grid import MOST_CELLS, Axis, Grid
from lsvib.systems.interval_mapper import IntervalMapper
from lsvib.systems.mapper import NO_DOUBT, Mapper, Starts


def mapper(drive: Drive) -> Mapper:
    """Return the mapper of a drive.

    For a rigid drive whose motor turns that is an ``IntervalMapper``, else a ``Mapper``.

    >>> import lsvib
    >>> grid = lsvib.Grid(lsvib.Axis("u", -0.03, 0.03, 4), lsvib.Axis("w", -5, 5, 2))
    >>> mapped = mapper(lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10))
    >>> mapped.cells(grid, quantities=("label",))["label"].tolist()
    [[0, 0, 0, 0], [0, 0, 0, 2]]
    """
    model, speed = model_of(drive), drive.input_speed
    u, w = abs(speed) * (drive.screw_inertia / drive.coupling_stiffness) ** 0.5, abs(speed)
    first = [{"u": x, "w": y} for x, y in ((u, 0.0), (-u, 0.0), (0.0, -1.5 * speed), (3 * u, 3 * w))]
    state = partial(model.initial_state, drive)
    kind = IntervalMapper if drive.rigid and speed else Mapper
    return kind(automaton_of(drive), Starts(state, np.array([u, w]), [*map(state, first)]))


def map_attraction(
    drive: Drive,
    grid: Grid | Mapping[str, Any],
    quantities: Sequence[str] = ("label",),
    workers: Any = 1,
    progress: numbers.Progress | None = None,
) -> xr.Dataset:
    """Map the region of attraction of a drive as ``drive.attraction(…)``."""
    at_once = numbers.workers(workers)
    starts = grid if isinstance(grid, Grid) else Grid.of(grid, model_of(drive).states)
    if (total := starts.x.count * starts.y.count) > MOST_CELLS:
        raise InputError(
            f"grid has {total} cells; the allowed range is up to {MOST_CELLS}, or more in tiles by the workflow."
        )
    mapped = mapper(drive)
    if isinstance(quantities, str) or not isinstance(quantities, Sequence):
        raise InputError(f"quantities = {numbers.shown(quantities)} is not a list of names.")
    asked = list(dict.fromkeys(["label", *quantities]))
    found = mapped.cells(starts, quantities=asked, workers=at_once, progress=progress)
    return _around(frame(drive, starts).assign(cells(starts, found)), drive, mapped, starts)


def grids_of(drives: Sequence[Drive], angle: Mapping[str, Any], velocity: Mapping[str, Any]) -> xr.Dataset:
    """Return the attractors of the motions of some drives from the middles of cells, (case, u, w), by the mapper.

    ``angle`` u [rad] and ``velocity`` w [rad/s]: ``start``, ``stop`` and ``count`` of the cells of equal width.
    """
    grid = Grid(Axis("u", **angle), Axis("w", **velocity))
    labels = [mapper(drive).cells(grid, quantities=("label",))["label"].T for drive in drives]
    plane = ("case", "grid_u", "grid_w")
    return xr.Dataset(
        {"grid_attractor": phase_plane.attractors(plane, labels)},
        coords=phase_plane.grid_axes(grid.x.centres(), grid.y.centres()) | cf.drive_parameters(drives),
        attrs={
            "title": "Attractors of the motions of lead-screw drives from grids of starts",
            "source": "lsvib, exact event-driven motion from the middle of every cell",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7",
        },
    )


def _around(cells: xr.Dataset, drive: Drive, mapper: Mapper, grid: Grid) -> xr.Dataset:
    """Add to the cells of a map what belongs to the whole: fractions of attractors, drive and :func:`surroundings`."""
    share = np.array([np.count_nonzero(cells.label.values == kind) for kind in Attractor]) / cells.label.size
    return cells.assign(
        {
            "attractor": cf.flagged("attractor", list(Attractor), "attractor", Attractor),
            "fraction": cf.variable("attractor", share, "1", "fraction of the cells"),
        }
        | cf.given(drive)
        | surroundings(drive, mapper, grid)
    )


def frame(drive: Drive, grid: Grid) -> xr.Dataset:
    """Return a map without its cells: middles of the cells, and global attributes, ``grid`` among them as JSON."""
    axes: cf.Variables = {
        axis.coordinate: (axis.coordinate, axis.centres(), cf.quantity(axis.coordinate) | {"cell_width": axis.width})
        for axis in (grid.y, grid.x)
    }
    model, spans = model_of(drive), {axis.coordinate: [axis.start, axis.stop, axis.count] for axis in (grid.x, grid.y)}
    about = {
        "title": "Regions of attraction of a lead-screw drive",
        "source": "lsvib, exact event-driven motion from the middle of every cell",
        "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7",
        "physics": " ".join((*model.terms, *model.options)),
        "grid": json.dumps({"axes": spans, "fixed": dict(grid.fixed)}),
    }
    return cf.answer({}, axes, cf.about_drive(drive, drive) | about)


def cells(grid: Grid, found: Mapping[str, np.ndarray]) -> dict[str, cf.Variable]:
    """Return what :meth:`Mapper.cells` gave of some cells as variables; in a file ``time`` is that of a motion."""
    about = {
        "label": cf.attributes("1", phase_plane.ATTRACTOR, **cf.flags(Attractor)),
        "time": cf.attributes("s", "time until the attractor is reached", "$t$", comment="missing if it never is"),
        "seizures": cf.attributes("1", "number of seizures until the attractor is reached"),
        "first_event": cf.attributes("1", "first event of the motion", **cf.flags(Event, none=True)),
        "doubt": cf.attributes(
            "1",
            "why the label is unresolved",
            **cf.flags(dict(enumerate(["none", *(doubt.name.lower() for doubt in Doubt)], NO_DOUBT))),
            comment="; ".join(f"{doubt.name.lower()}: {doubt}" for doubt in Doubt),
        ),
    }
    if "time" in found:
        found = {**found, "time": np.where(np.isfinite(found["time"]), found["time"], np.nan)}
    names, dims = {"time": "settling_time"}, (grid.y.coordinate, grid.x.coordinate)
    return {names.get(name, name): (dims, array, about[name]) for name, array in found.items()}


def surroundings(drive: Drive, mapper: Mapper, grid: Grid) -> dict[str, cf.Variable]:
    """Return what is drawn around a map of u and w: of every model the limit cycles that were met.

    Of the rigid drive also the lines Q = 0 and θ′ = 0 and, where known, the boundary of the basin and its area.
    """
    data: dict[str, cf.Variable] = {}
    if (grid.x.coordinate, grid.y.coordinate) != ("u", "w"):
        return data
    orbits = [found.orbit for found in mapper.attractors if found.orbit is not None]
    if orbits:
        data |= phase_plane.orbits(orbits)
    if drive.rigid:
        lines = phase_plane.lines([drive])
        names = ("contact_line_angle", "contact_line_slope", "stop_velocity")
        data |= {name: ((), lines[name][1][0], lines[name][2]) for name in names}
    if (basin := known_basin(drive)) is not None:
        window = Window(grid.x.start, grid.x.stop, grid.y.start, grid.y.stop)
        data |= phase_plane.curve("boundary", "boundary_point", basin.line(window), "on the exact boundary")
        words = "area of the basin of steady sliding within the map, exact"
        data["basin_area"] = cf.variable((), basin.area(window), "rad2 s-1", words)
    return data


def summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a map that has the ``doubt`` of each cell, for JSON.

    ``fractions`` by attractor, number of ``unresolved`` cells and why, exact area of the basin, cells per second.
    """
    cells, counts, doubts = found.label.size, cf.counted(found.label), cf.counted(found.doubt)
    reasons = {str(doubt): doubts[doubt.name.lower()] for doubt in Doubt if doubt.name.lower() in doubts}
    unresolved = counts.pop("unresolved", 0)
    return {
        "cells": cells,
        "fractions": {name: count / cells for name, count in counts.items()},
        "unresolved": unresolved,
        "unresolved_because": dict(sorted(reasons.items())),
        "exact_basin_area": found.basin_area.item() if "basin_area" in found else None,
        "cells_per_second": cells / seconds,
    }


def text(summary: Mapping[str, Any]) -> Iterator[str]:
    """Say a :func:`summary` in lines."""
    yield from words.shares(summary["fractions"], summary["cells"])
    yield f"unresolved: {summary['unresolved']} cells"
    for doubt, cells in summary["unresolved_because"].items():
        yield f"  {cells} cells unresolved: {doubt}"
    if (area := summary["exact_basin_area"]) is not None:
        yield f"exact area of the basin of steady sliding in the map: {area:.12g} rad2/s"
    yield f"{words.rate(summary['cells_per_second'])} cells per second"


def map_tile(settings: Mapping[str, Any], item: str, path: File, workers: int = 1) -> None:
    """Map one tile ("3-of-6") and write it; ``settings``: ``drive``, ``grid`` and ``quantities``."""
    drive, grid = _of(settings)
    rows = rows_of(item, grid.y.count)
    found = mapper(drive).cells(grid, rows, quantities=settings["quantities"], workers=workers)
    write_dataset(frame(drive, grid).isel({grid.y.coordinate: rows}).assign(cells(grid, found)), path)


def gather_map(
    settings: Mapping[str, Any], tiles: Sequence[File], path: File, about: Mapping[str, str] | None = None
) -> None:
    """Write the map of ``drive.attraction(…)`` from its tiles; ``settings`` as of a tile, ``about``: attributes."""
    drive, grid = _of(settings)
    joined = xr.concat([read_dataset(tile) for tile in tiles], grid.y.coordinate, data_vars="minimal",
                       coords="minimal", compat="override", join="exact", combine_attrs="override")  # fmt: skip
    del joined.attrs["summary"]  # of a tile
    write_dataset(_around(joined, drive, mapper(drive), grid).assign_attrs(about or {}), path)


def _of(settings: Mapping[str, Any]) -> tuple[Drive, Grid]:
    drive = Drive.of(settings["drive"])
    return drive, Grid.of(settings["grid"], model_of(drive).states)
