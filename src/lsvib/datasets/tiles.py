"""A region of attraction mapped in tiles, which are bands of rows: one tile, and the whole from its tiles."""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from lsvib.basins.grid import Grid
from lsvib.basins.mapper import Mapper, mapper
from lsvib.datasets.attributes import fractions
from lsvib.datasets.io import read_dataset, write_dataset
from lsvib.datasets.map import cells, count, dimensions, frame, parameters, surroundings
from lsvib.errors import InputError
from lsvib.models.model import find_model


def rows_of(item: str, rows: int) -> slice:
    """Return the rows of the tile ``item`` ("3-of-6", counted from 1) of a map of so many ``rows``."""
    number, tiles = (int(word) for word in item.split("-of-"))
    if tiles > rows:
        raise InputError(f"tiles = {tiles} is outside the allowed range 1 <= tiles <= {rows}, the number of rows.")
    return slice((number - 1) * rows // tiles, number * rows // tiles)


def joined(tiles: Sequence[str | os.PathLike[str]], rows: str) -> xr.Dataset:
    """Return the dataset whose tiles along the dimension ``rows`` are in these files, in their order.

    Raises ``InputError`` if a file is missing or damaged.
    """
    return xr.concat([read_dataset(tile) for tile in tiles], rows, data_vars="minimal", coords="minimal",
                     compat="override", join="exact", combine_attrs="override")  # fmt: skip


def mapper_of(settings: Mapping[str, Any]) -> Mapper:
    """Return the mapper of settings ``model``, ``drive`` (changes of Table 8.1), ``resume``; raises ``InputError``."""
    model = settings.get("model", "rigid")
    drive = find_model(model).drive.of(settings["drive"])
    return mapper(drive, model, resume=settings.get("resume", "contact_sign"))


def map_tile(settings: Mapping[str, Any], item: str, path: str | os.PathLike[str], workers: int = 1) -> None:
    """Map one tile and write it.

    ``settings``: ``grid`` as in :meth:`Grid.of`, those of :func:`mapper_of`, and ``quantities`` of each cell; ``item``:
    "3-of-6". Raises ``InputError`` and ``EngineError``.
    """
    grid, mapped = Grid.of(settings["grid"]), mapper_of(settings)
    rows = rows_of(item, grid.y.count)
    found = mapped.cells(grid, rows, quantities=settings["quantities"], workers=workers)
    tile = frame(mapped, grid).isel({dimensions(grid)[0]: rows})
    write_dataset(tile.assign(cells(mapped, grid, found)), path)


def gather_map(
    settings: Mapping[str, Any], tiles: Sequence[str | os.PathLike[str]], path: str | os.PathLike[str]
) -> None:
    """Write the map, the dataset of ``drive.attraction(…)``, from the files of its tiles; ``settings`` as of a tile."""
    grid, mapped = Grid.of(settings["grid"]), mapper_of(settings)
    whole = joined(tiles, dimensions(grid)[0])
    shares = fractions("attractor", "attractor", count(whole.label.values))
    write_dataset(whole.assign(shares | parameters(mapped) | surroundings(mapped, grid)), path)
