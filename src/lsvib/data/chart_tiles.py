"""A chart that is computed in tiles, as a map of attraction may be: one tile, and the whole from its tiles."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lsvib.data.assembly import gather, write_tile
from lsvib.data.chart import LABEL, Plane
from lsvib.data.tiles import tile_place
from lsvib.drives.registry import find_model
from lsvib.errors import InputError
from lsvib.numbers import Progress


def plane_of(settings: Mapping[str, Any]) -> Plane:
    """Return the plane of a chart from its settings.

    ``model``; ``drive``, changes of Table 8.1; ``x`` and ``y``, each with ``parameter``, ``start``, ``stop`` and
    ``count``. Raises ``InputError``.
    """
    drive = find_model(settings.get("model", "rigid")).drive.of(settings["drive"])
    axes = []
    for name in ("x", "y"):
        given = settings[name]
        if set(given) != {"parameter", "start", "stop", "count"}:
            raise InputError(f"{name} has the keys {', '.join(given)}; it needs parameter, start, stop and count.")
        axes.append(tuple(given[key] for key in ("parameter", "start", "stop", "count")))
    return Plane.of(drive, *axes)


def chart_tile(settings: Mapping[str, Any], item: str, path: str | os.PathLike[str], workers: int = 1) -> None:
    """Chart one tile, such as "3-of-6", and write it; ``settings`` as of :func:`plane_of`, and ``resume``.

    Raises ``InputError`` and ``EngineError``.
    """
    plane, resume = plane_of(settings), settings.get("resume", "contact_sign")
    place = tile_place(item, plane.y.count, plane.x.count)
    labels = plane.labels(place.rows, place.columns, resume, workers)
    tile = plane.axes(resume).isel(dict(zip(plane.dims, (place.rows, place.columns), strict=True)))
    write_tile(tile.assign(label=(plane.dims, labels, LABEL)), place, settings, path)


def gather_chart(
    settings: Mapping[str, Any],
    tiles: Sequence[str],
    path: str | os.PathLike[str],
    progress: Progress | None = None,
) -> None:
    """Write the chart, with its exact curves, from the files of its tiles, each named after its item.

    ``settings`` as in :func:`chart_tile`; ``progress`` is told how many of how many tiles are in. Raises ``InputError``
    if a tile is missing, damaged or of another chart.
    """
    plane = plane_of(settings)
    places = {Path(tile): tile_place(Path(tile).stem, plane.y.count, plane.x.count) for tile in tiles}
    gather(plane.frame(settings.get("resume", "contact_sign")), settings, places, path, progress, "behaviour")
