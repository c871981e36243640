"""A region of attraction mapped in tiles: which cells each tile holds, one tile, and the whole from its tiles."""

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lsvib.basins.cells import Mapper
from lsvib.basins.grid import Grid
from lsvib.basins.mapper import mapper
from lsvib.data.assembly import TilePlace, gather, write_tile
from lsvib.data.attraction_map import cells, dimensions, frame, parameters, surroundings
from lsvib.drives.registry import find_model
from lsvib.errors import InputError
from lsvib.numbers import Progress


def layout(tiles: int, rows: int, columns: int) -> tuple[int, int]:
    """Return how many tiles lie below and beside each other: of all factors of ``tiles`` those nearest to square tiles.

    ``rows``, ``columns``: cells of the map. Raises ``InputError`` if some tile would have no cell.
    """
    pairs = [(n, tiles // n) for n in range(1, tiles + 1) if tiles % n == 0]
    pairs = [(down, across) for down, across in pairs if down <= rows and across <= columns]
    if not pairs:
        raise InputError(f"tiles = {tiles} cannot divide a map of {columns} x {rows} cells; choose another number.")
    return min(pairs, key=lambda pair: abs(math.log(rows / pair[0] * pair[1] / columns)))


def tile_place(item: str, rows: int, columns: int) -> TilePlace:
    """Return the cells of the tile ``item`` ("3-of-6", counted from 1 along the rows) of a map of some cells."""
    number, tiles = (int(word) for word in item.split("-of-"))
    down, across = layout(tiles, rows, columns)
    i, j = divmod(number - 1, across)
    return TilePlace(i * rows // down, (i + 1) * rows // down, j * columns // across, (j + 1) * columns // across)


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
    place = tile_place(item, grid.y.count, grid.x.count)
    found = mapped.cells(grid, place.rows, place.columns, settings["quantities"], workers)
    tile = frame(mapped, grid).isel(dict(zip(dimensions(grid), (place.rows, place.columns), strict=True)))
    write_tile(tile.assign(cells(mapped, grid, found)), place, settings, path)


def gather_map(
    settings: Mapping[str, Any],
    tiles: Sequence[str],
    path: str | os.PathLike[str],
    progress: Progress | None = None,
) -> None:
    """Write the map from the files of its tiles, each named after its item.

    ``settings`` as in :func:`map_tile`; ``progress`` is told how many of how many tiles are in. Raises ``InputError``
    if a tile is missing, damaged or of another map.
    """
    grid, mapped = Grid.of(settings["grid"]), mapper_of(settings)
    places = {Path(tile): tile_place(Path(tile).stem, grid.y.count, grid.x.count) for tile in tiles}
    around = frame(mapped, grid).assign(parameters(mapped) | surroundings(mapped, grid))
    gather(around, settings, places, path, progress)
