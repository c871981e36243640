"""A chart that is computed in tiles, as a map of attraction may be: one tile, and the whole from its tiles."""

import os
from collections.abc import Mapping, Sequence
from typing import Any

from lsvib.datasets.chart import LABEL, Plane, shares
from lsvib.datasets.io import write_dataset
from lsvib.datasets.map import joined, rows_of
from lsvib.errors import InputError
from lsvib.models.model import find_model


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
    rows = rows_of(item, plane.y.count)
    labels = plane.labels(rows, resume=resume, workers=workers)
    write_dataset(plane.axes(resume).isel({plane.y.name: rows}).assign(label=(plane.dims, labels, LABEL)), path)


def gather_chart(
    settings: Mapping[str, Any], tiles: Sequence[str | os.PathLike[str]], path: str | os.PathLike[str]
) -> None:
    """Write the chart, the dataset of ``drive.chart(…)``, from the files of its tiles; ``settings`` as of a tile."""
    plane = plane_of(settings)
    labels = joined(tiles, plane.y.name).label
    whole = plane.frame(settings.get("resume", "contact_sign"))
    write_dataset(whole.assign({"label": labels, **shares(labels.values)}), path)
