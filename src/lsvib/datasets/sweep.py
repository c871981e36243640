"""Over values of a drive's parameters: what motions end on, and what the drive does.

A point depends on nothing but its own drive and start, so that no number depends on the other points, their order, or
the number of threads. Nothing is simulated for some time and looked at: the return map decides, as for one drive.

A *sweep* takes any values of any parameters, and one motion of each drive. A *chart* takes the middles of cells over
two parameters, up to three motions, and the exact curves that divide it.
"""

import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, Self

import numpy as np
import xarray as xr

from lsvib import numbers, words
from lsvib.basins.grid import MOST_CELLS, Axis
from lsvib.datasets import attributes as cf
from lsvib.datasets.io import write_dataset
from lsvib.datasets.spans import zero_where_rounded
from lsvib.dynamics.attractor import Attractor
from lsvib.dynamics.behaviour import Behaviour, behaviours
from lsvib.dynamics.sweep import all_endings
from lsvib.errors import InputError
from lsvib.models.drive import Drive, names_and_values, require_direction
from lsvib.models.many import ManyDrives
from lsvib.models.model import model_of
from lsvib.models.scene import REST
from lsvib.stability.curves import LOGARITHMIC, ChartBoundary, boundary_curves

START = {"u": 1e-3, "w": 0.0}  # next to steady sliding: rad, and rad/s
_MOST = 10_000_000  # points, of which each has some hundred bytes

_VARIABLES = {
    "attractor": cf.attributes("1", "attractor that the motion reaches", **cf.flags(Attractor)),
    "amplitude": cf.attributes("rad", "amplitude of the steady vibration, half its peak-to-peak"),
    "period": cf.attributes("s", "period of the steady vibration", "$T$"),
    "multiplier": cf.attributes("1", "largest multiplier of the return map"),
    "peak_normal_force": cf.attributes("N", "largest magnitude of the normal force, without the impulses of seizures"),
    "peak_normal_impulse": cf.attributes("N s", "largest magnitude of the normal impulse of a seizure"),
}
_LABEL = cf.attributes("1", "what the drive does", **cf.flags(Behaviour))


def sweep(
    drive: Drive,
    over: Mapping[str, Any],
    start: Mapping[str, Any] | str | None = None,
    workers: Any = 1,
    progress: numbers.Progress | None = None,
) -> xr.Dataset:
    """Return what a drive ends on as its method ``sweep`` does; ``over``: values by name of a parameter."""
    at_once, axes = numbers.workers(workers), axes_of(over)
    drives, sizes = product_of(drive, axes), tuple(map(len, axes.values()))
    first = drives.one(0)  # with the parts that are varied
    begin: dict[str, float] | str = REST
    if start != REST:
        given = START if start is None else names_and_values("start", start)
        begin = {key: numbers.start(f"start {key}", value) for key, value in given.items()}
        model_of(first).initial_state(first, begin)  # refuses other keys
    found = all_endings(drives, begin if isinstance(begin, dict) else None, at_once, progress)
    return _over(
        cf.varied(**axes),
        first,
        {name: (tuple(axes), found[name].reshape(sizes), about) for name, about in _VARIABLES.items()},
        title=f"What a lead-screw drive ends on over {', '.join(axes)}",
        source="lsvib, exact event-driven motion and its return map",
        references=f"doi:10.1007/978-1-4419-1752-2_8, {model_of(first).equations}",
        initial_state=json.dumps(begin),
    )


def summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a sweep for JSON: number of ``points``, of each of the ``attractors``, ``points_per_second``."""
    points = found.attractor.size
    return {"points": points, "attractors": cf.counted(found.attractor), "points_per_second": points / seconds}


def text(summary: Mapping[str, Any]) -> Iterator[str]:
    """Say a :func:`summary` in lines."""
    for kind, count in summary["attractors"].items():
        yield f"{words.plain(kind)}: {count} of {summary['points']} points"
    yield f"{words.rate(summary['points_per_second'])} points per second"


class ChartAxis(Axis):
    """Cells along a parameter, of equal width, or of equal ratio where it spans decades (``LOGARITHMIC``)."""

    @classmethod
    def of(cls, where: str, given: Any) -> Self:
        """Make an axis from text KEY=START:STOP:COUNT, or from (parameter, start, stop, count); ``InputError``."""
        if isinstance(given, str):
            name, equals, ends = given.partition("=")
            given, parts = (name, *ends.split(":")), given
            if not equals or len(given) != 4:
                raise InputError(f"{where}: {parts!r} is not of the form KEY=START:STOP:COUNT.")
        if not isinstance(given, tuple | list) or len(given) != 4:
            raise InputError(f"{where} = {numbers.shown(given)} is not a parameter with start, stop and count.")
        known_key(name := given[0], f"{where}: ")
        axis = cls(*given)
        if name in LOGARITHMIC and axis.start <= 0:
            raise InputError(f"axis {name} has start = {axis.start:g}; its cells have equal ratios, so start > 0.")
        return axis

    @property
    def ends(self) -> tuple[float, float]:
        """First and last value [SI unit]."""
        return self.start, self.stop

    def middles(self, index: np.ndarray) -> np.ndarray:
        """Return the middles of the cells of these indices."""
        if self.coordinate in LOGARITHMIC:
            return self.start * (self.stop / self.start) ** ((index + 0.5) / self.count)
        return zero_where_rounded(super().middles(index), self.width)

    def variable(self) -> cf.Variable:
        """Return the middles as the coordinate of a chart."""
        name, (first, second) = self.coordinate, self.middles(np.array([-0.5, 0.5]))  # edges
        more = {"cell_ratio": float(second / first)} if name in LOGARITHMIC else {"cell_width": self.width}
        return name, self.centres(), cf.parameter(name, cf.VARIED, **more)


def chart(drive: Drive, x: Any, y: Any, workers: Any = 1, progress: numbers.Progress | None = None) -> xr.Dataset:
    """Return what a drive does over two of its parameters as its method ``chart`` does."""
    at_once, x, y = numbers.workers(workers), ChartAxis.of("x", x), ChartAxis.of("y", y)
    names = y.coordinate, x.coordinate
    if len(set(names)) < 2:
        raise InputError(f"x and y are both {x.coordinate}; a chart needs two parameters.")
    if x.count * y.count > MOST_CELLS:
        raise InputError(f"the chart has more than {MOST_CELLS} cells; take fewer.")
    corners = [drive.replace(**dict(zip(names, ends, strict=True))) for ends in product(y.ends, x.ends)]
    for corner in corners:
        require_direction(corner)
    if not all(model_of(corner).curves for corner in corners):
        raise InputError(
            "charts are for rigid drives without friction of slide, bearing and collar, and for drives of which "
            "the threads alone comply."
        )
    drive = corners[0]  # with the parts that are varied
    labels = charted(drive, x, y, at_once, progress)
    cells = {"label": (names, labels, _LABEL)} | cf.fractions("behaviour", _LABEL["long_name"], Behaviour, labels)
    return _over(
        {one.coordinate: one.variable() for one in (y, x)},
        drive,
        _curves(drive, x, y) | cells,
        title=f"What a lead-screw drive does over {x.coordinate} and {y.coordinate}",
        source="lsvib, exact event-driven motions from two starts of the drive in the middle of every cell",
        references="doi:10.1007/978-1-4419-1752-2_8, Sects 8.5-8.7",
    )


def charted(
    drive: Drive, x: Axis, y: Axis, workers: int = 1, progress: numbers.Progress | None = None
) -> np.ndarray[Any, Any]:
    """Return what the drives of the cells of a chart do (rows of y, columns of x), a ``Behaviour`` each, int8."""
    drives = product_of(drive, {one.coordinate: one.centres().tolist() for one in (y, x)})
    return behaviours(drives, workers, progress).reshape(y.count, x.count)


def _curves(drive: Drive, x: ChartAxis, y: ChartAxis) -> cf.Variables:
    """The points of all exact curves, one after the other; ``boundary_line`` numbers the lines."""
    sides = (x.coordinate, x.ends), (y.coordinate, y.ends)
    lines = [(kind, line) for kind, parts in boundary_curves(drive, *sides).items() for line in parts]
    if not lines:
        return {}
    points, sizes, dim = np.concatenate([line for _, line in lines]), [len(line) for _, line in lines], "boundary_point"
    kinds, number = (np.repeat(each, sizes) for each in ([kind for kind, _ in lines], range(len(lines))))
    names = (f"boundary_{name}" for name, _ in sides)
    return {name: (dim, own, cf.parameter(name, cf.VARIED)) for name, own in zip(names, points.T, strict=True)} | {
        "boundary_name": cf.flagged(dim, kinds, "name of the exact curve", ChartBoundary),
        "boundary_line": cf.variable(dim, number.astype(np.int32), "1", "number of the line, whose points are joined"),
    }


def chart_summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a chart for JSON: ``cells``, ``fractions`` by behaviour, ``curves`` by name, ``cells_per_second``."""
    cells = found.label.size
    return {
        "cells": cells,
        "fractions": {name: count / cells for name, count in cf.counted(found.label).items()},
        "curves": list(cf.counted(found.boundary_name)) if "boundary_name" in found else [],
        "cells_per_second": cells / seconds,
    }


def chart_text(summary: Mapping[str, Any]) -> Iterator[str]:
    """Say a :func:`chart_summary` in lines."""
    yield from words.shares(summary["fractions"], summary["cells"])
    yield f"exact curves: {', '.join(map(words.plain, summary['curves'])) or 'none'}"
    yield f"{words.rate(summary['cells_per_second'])} cells per second"


def write_chart(settings: Mapping[str, Any], path: str | os.PathLike[str], workers: int = 1) -> None:
    """Write the chart of settings ``drive`` (changes of Table 8.1), ``x`` and ``y``.

    Each axis has ``parameter``, ``start``, ``stop`` and ``count``. Raises ``InputError``.
    """
    x, y = ([settings[name][key] for key in ("parameter", "start", "stop", "count")] for name in ("x", "y"))
    write_dataset(chart(Drive.of(settings["drive"]), x, y, workers), path)


def _over(coordinates: cf.Variables, drive: Drive, found: cf.Variables, **more: str) -> xr.Dataset:
    """What was found over values of some parameters of a drive, the coordinates; ``more`` attributes."""
    fixed = [(name, value) for name, value in drive if name not in coordinates]
    return cf.answer(found | cf.given(fixed), coordinates, cf.about_drive(drive, fixed) | more)


def known_key(name: Any, where: str = "") -> None:
    """Raise ``InputError`` unless drives have a parameter of this name."""
    if not isinstance(name, str) or name not in Drive.model_fields:
        known = ", ".join(Drive.model_fields)
        raise InputError(f"{where}{numbers.shown(name)} is not a known key; the known keys are {known}.")


def axes_of(over: Any) -> dict[str, list[float]]:
    """Return the values of each parameter of a product; raises ``InputError``."""
    axes: dict[str, list[float]] = {}
    lists = names_and_values("over", over)
    for name, given in lists.items():
        known_key(name)
        if isinstance(given, str | bytes | Mapping) or getattr(given, "ndim", 1) != 1 or not hasattr(given, "__len__"):
            raise InputError(f"over: {name} = {numbers.shown(given)} is not a list of numbers.")
    total = math.prod(map(len, lists.values()))
    if not 1 <= total <= _MOST:
        raise InputError(f"over has {total} points; the allowed range is 1 <= points <= {_MOST}.")
    for name, given in lists.items():
        try:
            axes[name] = [numbers.number(value) for value in given]
        except numbers.NotNumber as error:
            raise InputError(f"over: {name} holds a value that {error}.") from None
    if not axes:
        raise InputError("over names no parameter; give the values of one, such as axial_force.")
    return axes


def product_of(drive: Drive, axes: Mapping[str, Sequence[float]]) -> ManyDrives:
    """Return the drives over the product of values of some parameters, the last one fastest.

    Raises ``InputError`` if one of them is not acceptable: all that couples ranges, such as μ < cot λ, is monotonic in
    each parameter, so that the corners of the product decide.
    """
    ends = []
    for values in axes.values():  # ranges may leave out what is near zero
        parts = ([x for x in values if np.sign(x) == sign] for sign in (-1, 0, 1))
        ends.append(sorted({end(part) for part in parts if part for end in (min, max)} | {x for x in values if x != x}))
    for corner in product(*ends):
        drive.replace(**dict(zip(axes, corner, strict=True)))
    grids = np.meshgrid(*axes.values(), indexing="ij")
    first = drive.replace(**{name: values[0] for name, values in axes.items()})
    return ManyDrives(dict(first) | {name: grid.ravel() for name, grid in zip(axes, grids, strict=True)})
