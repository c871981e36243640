"""Charts: what a drive does over two of its parameters, cell by cell, with the exact curves that divide it.

A cell depends on nothing but its own drive, so a large chart can be cut into tiles, as a map of attraction may be.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Self

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib.basins.grid import MOST_CELLS, Axis
from lsvib.datasets import attributes as cf
from lsvib.datasets.io import write_dataset
from lsvib.datasets.spans import zero_where_rounded
from lsvib.datasets.sweep import known_key, product_of
from lsvib.dynamics.behaviour import Behaviour, behaviours
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.model import model_of
from lsvib.stability.curves import LOGARITHMIC, ChartBoundary, boundary_curves


class ChartAxis(Axis):
    """Cells along a parameter, of equal width, or of equal ratio where it spans decades (``LOGARITHMIC``)."""

    @classmethod
    def of(cls, drive: Drive, where: str, given: Any) -> Self:
        """Make an axis from text KEY=START:STOP:COUNT, or from (parameter, start, stop, count); ``InputError``."""
        if isinstance(given, str):
            name, equals, text = given.partition("=")
            parts: Any = (name, *text.split(":"))
            if not equals or len(parts) != 4:
                raise InputError(f"{where}: {given!r} is not of the form KEY=START:STOP:COUNT.")
        else:
            parts = given
            if not isinstance(parts, tuple | list) or len(parts) != 4:
                raise InputError(f"{where} = {numbers.shown(given)} is not a parameter with start, stop and count.")
        known_key(name := parts[0], f"{where}: ")
        axis = cls(*parts)
        if name in LOGARITHMIC and axis.start <= 0:
            raise InputError(f"axis {name} has start = {axis.start:g}; its cells have equal ratios, so start > 0.")
        return axis

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self.coordinate

    @property
    def ends(self) -> tuple[float, float]:
        """First and last value [SI unit]."""
        return self.start, self.stop

    def attributes(self) -> dict[str, Any]:
        """Return the attributes of the axis as a coordinate."""
        if self.name not in LOGARITHMIC:
            return cf.parameter(self.name, cf.VARIED, cell_width=self.width)
        first, second = self.middles(np.array([-0.5, 0.5]))  # edges
        return cf.parameter(self.name, cf.VARIED, cell_ratio=float(second / first))

    def middles(self, index: np.ndarray) -> np.ndarray:
        """Return the middles of the cells of these indices."""
        if self.name in LOGARITHMIC:
            return self.start * (self.stop / self.start) ** ((index + 0.5) / self.count)
        return zero_where_rounded(super().middles(index), self.width)


@dataclass(frozen=True)
class Plane:
    """The two axes of a chart of a drive, ``x`` along the columns and ``y`` along the rows."""

    drive: Drive
    x: ChartAxis
    y: ChartAxis

    @classmethod
    def of(cls, drive: Drive, x: Any, y: Any) -> Self:
        """Make the plane from axes as :meth:`ChartAxis.of` takes them; raises ``InputError``."""
        plane = cls(drive, ChartAxis.of(drive, "x", x), ChartAxis.of(drive, "y", y))
        if plane.x.name == plane.y.name:
            raise InputError(f"x and y are both {plane.x.name}; a chart needs two parameters.")
        if plane.x.count * plane.y.count > MOST_CELLS:
            raise InputError(f"the chart has more than {MOST_CELLS} cells; take fewer.")
        ends = product(plane.x.ends, plane.y.ends)
        corners = [drive.replace(**{plane.x.name: first, plane.y.name: second}) for first, second in ends]
        if not all(model_of(corner).curves for corner in corners):
            raise InputError(
                "charts are for rigid drives without friction of slide, bearing and collar, and for drives of which "
                "the threads alone comply."
            )
        return replace(plane, drive=corners[0])  # with the parts that are varied

    @property
    def dims(self) -> tuple[str, str]:
        """Names of the rows' and the columns' parameter."""
        return self.y.name, self.x.name

    def labels(self, workers: int = 1, progress: numbers.Progress | None = None) -> np.ndarray:
        """Return what the drives of the cells do (rows, columns), a ``Behaviour`` each, int8."""
        axes = {one.name: one.centres().tolist() for one in (self.y, self.x)}
        return behaviours(product_of(self.drive, axes), workers, progress).reshape(self.y.count, self.x.count)

    def whole(self, labels: np.ndarray) -> xr.Dataset:
        """Return the chart with the exact curves, from its labels (rows, columns)."""
        fixed = [(name, value) for name, value in self.drive if name not in self.dims]
        counts = {kind: int(np.count_nonzero(labels == kind)) for kind in Behaviour}
        cells = {"label": (self.dims, labels, LABEL)} | cf.fractions("behaviour", LABEL["long_name"], counts)
        return xr.Dataset(
            cf.given(fixed) | self._points() | cells,
            coords={one.name: (one.name, one.centres(), one.attributes()) for one in (self.y, self.x)},
            attrs={
                "title": f"What a lead-screw drive does over {self.x.name} and {self.y.name}",
                "source": "lsvib, exact event-driven motions from two starts of the drive in the middle of every cell",
                "references": "doi:10.1007/978-1-4419-1752-2_8, Sects 8.5-8.7",
                **cf.about_drive(self.drive, fixed),
            },
        )

    def _points(self) -> dict[str, cf.Variable]:
        """The points of all exact curves, one after the other; ``boundary_line`` numbers the lines."""
        found = boundary_curves(self.drive, (self.x.name, self.x.ends), (self.y.name, self.y.ends))
        lines = [(kind, line) for kind, parts in found.items() for line in parts]
        if not lines:
            return {}
        sizes = [len(line) for _, line in lines]
        points, dim = np.concatenate([line for _, line in lines]), "boundary_point"
        kinds = np.repeat(np.array([kind for kind, _ in lines], dtype=np.int8), sizes)
        number = np.repeat(np.arange(len(lines), dtype=np.int32), sizes)
        return {
            f"boundary_{self.x.name}": (dim, points[:, 0], cf.parameter(f"boundary_{self.x.name}", cf.VARIED)),
            f"boundary_{self.y.name}": (dim, points[:, 1], cf.parameter(f"boundary_{self.y.name}", cf.VARIED)),
            "boundary_name": cf.flagged(dim, kinds, "name of the exact curve", ChartBoundary),
            "boundary_line": cf.variable(dim, number, "1", "number of the line, whose points are joined"),
        }


LABEL = cf.attributes("1", "what the drive does", **cf.flags(Behaviour))


def chart(drive: Drive, x: Any, y: Any, workers: Any = 1, progress: numbers.Progress | None = None) -> xr.Dataset:
    """Return what a drive does over two of its parameters, as a dataset.

    Arguments: a drive of the rigid model or with compliant threads; ``x`` and ``y``, each "KEY=START:STOP:COUNT" or
    (parameter, start, stop, count) with values in SI units; number of ``workers``, which changes no
    label; ``progress``, called with numbers done and in all. Variables: ``label`` (rows of y, columns of
    x), ``fraction`` of each ``behaviour``, and the points of the exact curves (``boundary_…``). Raises ``InputError``.
    """
    plane, at_once = Plane.of(drive, x, y), numbers.workers(workers)
    return plane.whole(plane.labels(at_once, progress))


def summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a chart for JSON: ``cells``, ``fractions`` by behaviour, ``curves`` by name, ``cells_per_second``."""
    parts = {
        Behaviour(int(kind)).name.lower(): float(part)
        for kind, part in zip(found.behaviour, found.fraction, strict=True)
    }
    curves = sorted({int(kind) for kind in found.boundary_name.values}) if "boundary_name" in found else []
    return {
        "cells": int(found.label.size),
        "fractions": {name: part for name, part in parts.items() if part},
        "curves": [ChartBoundary(kind).name.lower() for kind in curves],
        "cells_per_second": found.label.size / seconds,
    }


def write_chart(settings: Mapping[str, Any], path: str | os.PathLike[str], workers: int = 1) -> None:
    """Write the chart of settings ``drive`` (changes of Table 8.1), ``x`` and ``y``.

    Each axis has ``parameter``, ``start``, ``stop`` and ``count``. Raises ``InputError``.
    """
    drive = Drive.of(settings["drive"])
    x, y = ([settings[name][key] for key in ("parameter", "start", "stop", "count")] for name in ("x", "y"))
    write_dataset(chart(drive, x, y, workers), path)
