"""Regions of attraction as a CF dataset: what becomes of every start of a grid, with the lines and cycles around it."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib.basins.curves import Window
from lsvib.basins.grid import Axis, Grid, coordinates
from lsvib.basins.mapper import NO_DOUBT, Mapper
from lsvib.basins.mapper import mapper as mapper_of
from lsvib.datasets import maps_of_models, phase_plane
from lsvib.datasets.attributes import GIVEN, Variable, attributes, flags, flags_or_none, fractions, parameter, quantity
from lsvib.dynamics.attractor import Attractor, Doubt
from lsvib.errors import InputError
from lsvib.models.drive import Drive, names_and_values
from lsvib.models.model import of_model, rule
from lsvib.numbers import Progress

_CYCLE_SAMPLES = 400  # of a limit cycle that is drawn: corners that no picture shows


@dataclass(frozen=True)
class AttractionMap:
    """A ``dataset`` of ``drive.attraction(…)``, its cells counted by attractor, and the ``seconds`` it took.

    ``doubts`` counts the unresolved cells by why they are, as ends of sentences.
    """

    dataset: xr.Dataset
    counts: Mapping[Attractor, int]
    seconds: float
    doubts: Mapping[str, int]


def map_attraction(
    drive: Drive,
    grid: Grid | Mapping[str, Any],
    quantities: Sequence[str] = ("label",),
    resume: str = "contact_sign",
    workers: Any = 1,
    progress: Progress | None = None,
) -> AttractionMap:
    """Map the region of attraction of a drive as ``drive.attraction(…)``; the seconds are without compiling."""
    at_once = numbers.workers(workers)
    starts = _grid(grid)
    mapper = mapper_of(drive, drive.model, resume=rule(resume))
    if isinstance(quantities, str) or not isinstance(quantities, Sequence):
        raise InputError(f"quantities = {numbers.shown(quantities)} is not a list of names.")
    wanted = list(dict.fromkeys(["label", *quantities]))
    asked = list(dict.fromkeys([*wanted, "doubt"]))
    mapper.cells(starts, slice(0, 1), slice(0, 1), asked)  # so that compiling is not part of the speed
    begin = perf_counter()
    found = mapper.cells(starts, quantities=asked, workers=at_once, progress=progress)
    seconds = perf_counter() - begin
    shown = {name: found[name] for name in wanted}
    return AttractionMap(attraction_map(mapper, starts, shown), count(found["label"]), seconds, doubts(found["doubt"]))


def count(labels: np.ndarray) -> dict[Attractor, int]:
    """Return the number of cells of each attractor."""
    return {kind: int(np.count_nonzero(labels == kind)) for kind in Attractor}


def doubts(codes: np.ndarray) -> dict[str, int]:
    """Return the numbers of unresolved cells by why they are, from the quantity ``doubt`` of a map."""
    kinds = list(Doubt)
    return dict(sorted(Counter(str(kinds[code]) for code in codes[codes != NO_DOUBT]).items()))


def attraction_map(mapper: Mapper, grid: Grid, found: Mapping[str, np.ndarray]) -> xr.Dataset:
    """Return the dataset of a map.

    Arguments: mapper; grid; ``found``, the arrays (rows, columns) that :meth:`Mapper.cells` gave for the whole grid.
    The coordinates are those of the grid's axes, at the middles of the cells. Besides the quantities of the map:
    ``fraction`` of each attractor, and the :func:`surroundings`. Times that never come are missing.
    """
    return frame(mapper, grid).assign(
        cells(mapper, grid, found)
        | fractions("attractor", "attractor", count(found["label"]))
        | parameters(mapper)
        | surroundings(mapper, grid)
    )


def frame(mapper: Mapper, grid: Grid) -> xr.Dataset:
    """Return a map without its cells: coordinates and global attributes."""
    coordinates = zip(dimensions(grid), map(axis_coordinate, (grid.y, grid.x)), strict=True)
    return xr.Dataset(coords=dict(coordinates), attrs=global_attributes(mapper, grid))


def dimensions(grid: Grid) -> tuple[str, str]:
    """Return the names of the dimensions of a map, rows first."""
    return coordinates()[grid.y.coordinate], coordinates()[grid.x.coordinate]


def cells(mapper: Mapper, grid: Grid, found: Mapping[str, np.ndarray]) -> dict[str, Variable]:
    """Return the arrays of some cells as variables; in its file the quantity ``time`` is that of a motion."""
    return {
        "settling_time" if name == "time" else name: (
            dimensions(grid),
            np.where(np.isfinite(array), array, np.nan) if name == "time" else array,
            variable_attributes(mapper, name),
        )
        for name, array in found.items()
    }


def axis_coordinate(axis: Axis) -> Variable:
    """Return the coordinate variable of an axis: the middles of its cells."""
    name = coordinates()[axis.coordinate]
    return name, axis.centres(), {**quantity(name), "cell_width": axis.width}


def parameters(mapper: Mapper) -> dict[str, Variable]:
    """Return the parameters of the drive of a map as variables."""
    return {name: ((), value, parameter(name, GIVEN)) for name, value in mapper.drive}


def variable_attributes(mapper: Mapper, name: str) -> dict[str, Any]:
    """Return the attributes of a quantity of a map, by its name."""
    if name == "label":
        return attributes("1", phase_plane.ATTRACTOR, **flags(Attractor))
    if name == "time":
        return attributes("s", "time until the attractor is reached", "$t$", comment="missing where it never is")
    if name == "seizures":
        return attributes("1", "number of seizures until the attractor is reached")
    if name == "doubt":
        return attributes(
            "1",
            "why the label is unresolved",
            flag_values=np.arange(NO_DOUBT, len(Doubt), dtype=np.int8),
            flag_meanings=" ".join(["none", *(doubt.name.lower() for doubt in Doubt)]),
            comment="; ".join(f"{doubt.name.lower()}: {doubt}" for doubt in Doubt),
        )
    return attributes("1", "first event of the motion", **flags_or_none(mapper.events))


def surroundings(mapper: Mapper, grid: Grid) -> dict[str, Variable]:
    """Return what is drawn around a map in the plane of u and w.

    Of every model the limit cycles that were met, and what :mod:`lsvib.datasets.maps_of_models` has of some.
    """
    data: dict[str, Variable] = {}
    if (grid.x.coordinate, grid.y.coordinate) != ("u", "w"):
        return data
    orbits = [found.orbit for found in mapper.attractors if found.orbit is not None]
    count = max([_CYCLE_SAMPLES, *(2 * (orbit.time.size + 1) for orbit in orbits)])  # two at least for each arc
    points = np.array([phase_plane.sample(orbit, count)[1][:, :2] for orbit in orbits])
    if orbits:
        data |= phase_plane.curve("cycle", ("cycle", "sample"), points, "on the limit cycle")
    data |= of_model(maps_of_models, mapper.model, "surroundings", _nothing)(mapper.drive, grid_window(grid))
    return data


def _nothing(drive: Drive, window: Window) -> dict[str, Variable]:
    """What is drawn around a map of a model without a file of its own."""
    return {}


def grid_window(grid: Grid) -> Window:
    """Return the rectangle of a map in u and w."""
    return Window(grid.x.start, grid.x.stop, grid.y.start, grid.y.stop)


def global_attributes(mapper: Mapper, grid: Grid) -> dict[str, str]:
    """Return the global attributes of a map; ``grid`` holds its axes and fixed coordinates as JSON."""
    axes = {axis.coordinate: list(axis[1:]) for axis in (grid.x, grid.y)}
    return {
        "title": "Regions of attraction of a lead-screw drive",
        "source": "lsvib, exact event-driven motion from the middle of every cell",
        "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7",
        "model": mapper.model,
        "parameters": json.dumps(dict(mapper.drive)),
        "physics": " ".join(mapper.physics),
        "resume": mapper.resume,
        "grid": json.dumps({"axes": axes, "fixed": dict(grid.fixed)}),
    }


def summary(
    counts: Mapping[Attractor, int], doubts: Mapping[str, int], exact_basin_area: float | None, seconds: float
) -> dict[str, Any]:
    """Summarise a map for JSON: ``fractions`` by attractor, ``unresolved`` cells and why, cells per second, area."""
    cells = sum(counts.values())
    return {
        "cells": cells,
        "fractions": {kind.name.lower(): n / cells for kind, n in counts.items() if n and kind >= 0},
        "unresolved": counts[Attractor.UNRESOLVED],
        "unresolved_because": dict(doubts),
        "exact_basin_area": exact_basin_area,
        "cells_per_second": cells / seconds,
    }


def _grid(given: Grid | Mapping[str, Any]) -> Grid:
    """A grid from one, or from axes as (start, stop, count) or as a mapping with these keys."""
    if isinstance(given, Grid):
        return given
    values = names_and_values("grid", given)
    for name, span in values.items():
        if isinstance(span, tuple | list):
            if len(span) != 3:
                raise InputError(f"axis {name} has {len(span)} numbers; it needs start, stop and count.")
            values[name] = dict(zip(("start", "stop", "count"), span, strict=True))
    return Grid.of(values)
