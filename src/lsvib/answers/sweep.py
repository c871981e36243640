"""Over values of a drive's parameters: what motions end on, and what the drive does.

A point depends on nothing but its own drive and start, so that no number depends on the other points, their order, or
the number of threads. Nothing is simulated for some time and looked at: the return map decides, as for one drive.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers, words
from lsvib.answers import attributes as cf
from lsvib.answers.io import on_screen, write_dataset
from lsvib.answers.spans import spaced
from lsvib.drives.complaints import meant
from lsvib.drives.drive import Drive, require_direction
from lsvib.drives.many import ManyDrives
from lsvib.drives.model import model_of
from lsvib.drives.scene import REST
from lsvib.dynamics.sweep import Behaviour, all_endings, behaviours
from lsvib.errors import InputError
from lsvib.files import File
from lsvib.numbers import names_and_values
from lsvib.stability.curves import ChartBoundary, boundary_curves
from lsvib.systems.attractor import Attractor

_VARIABLES = {
    "attractor": cf.attributes("1", "attractor that the motion reaches", **cf.flags(Attractor)),
    "amplitude": cf.attributes("rad", "amplitude of the steady vibration, half its peak-to-peak"),
    "period": cf.attributes("s", "period of the steady vibration", "$T$"),
    "multiplier": cf.attributes("1", "largest multiplier of the return map"),
    "peak_normal_force": cf.attributes("N", "largest magnitude of the normal force, excluding impulses of seizures"),
    "peak_normal_impulse": cf.attributes("N s", "largest magnitude of the normal impulse of a seizure"),
}
_BEHAVIOUR = cf.attributes("1", "what the drive does", **cf.flags(Behaviour))


def sweep(
    drive: Drive,
    over: Mapping[str, Any],
    start: Mapping[str, Any] | str | None = None,
    workers: Any = 1,
    progress: numbers.Progress | None = None,
) -> xr.Dataset:
    """Return what a drive does as its method ``sweep`` does; ``over``: values by name of a parameter."""
    at_once, axes = numbers.workers(workers), numbers.axes(over, known_key)
    drives, sizes = product_of(drive, axes), tuple(map(len, axes.values()))
    first = drives.one(0)  # with the parts that are varied
    begin: Mapping[str, float] | str = "near steady sliding"
    more: cf.Variables = {}
    if start is None:
        require_direction(drives.one(int(np.abs(drives.values["input_speed"]).argmin())))
        found, kinds = behaviours(drives, at_once, progress)
        more = {"behaviour": (tuple(axes), kinds.reshape(sizes), _BEHAVIOUR)} | _curves(drive, axes)
    elif start == REST:
        begin, found = REST, all_endings(drives, None, at_once, progress)
    else:
        given = names_and_values("start", start)
        begin = {key: numbers.start(f"start {key}", value) for key, value in given.items()}
        model_of(first).initial_state(first, begin)  # refuses other keys
        found = all_endings(drives, begin, at_once, progress)
    fixed = [(name, value) for name, value in first if name not in axes]
    swept = {name: (tuple(axes), found[name].reshape(sizes), about) for name, about in _VARIABLES.items()}
    return cf.answer(swept | more | cf.given(fixed), cf.varied(**axes), cf.about_drive(first, fixed)).assign_attrs(
        title=f"What a lead-screw drive does over {', '.join(axes)}",
        source="lsvib, exact event-driven motions and their return map",
        references=f"doi:10.1007/978-1-4419-1752-2_8, {model_of(first).equations}",
        initial_state=json.dumps(begin),
    )


def _curves(drive: Drive, axes: Mapping[str, Sequence[float]]) -> cf.Variables:
    """The points of all exact curves over two parameters, one after the other; ``boundary_line`` numbers the lines.

    There are none for drives of which no such curve is known, or where the direction changes.
    """
    if len(axes) != 2 or any(min(values) == max(values) for values in axes.values()):
        return {}
    y, x = ((name, (min(values), max(values))) for name, values in axes.items())
    corners = [drive.replace(**{y[0]: one, x[0]: other}) for one, other in product(y[1], x[1])]
    if not all(model_of(one).curves and one.input_speed * corners[0].input_speed > 0 for one in corners):
        return {}
    curves = boundary_curves(corners[0], x, y)  # with the parts that are varied
    lines = [(kind, line) for kind, parts in curves.items() for line in parts]
    if not lines:
        return {}
    points, sizes, dim = np.concatenate([line for _, line in lines]), [len(line) for _, line in lines], "boundary_point"
    kinds, number = (np.repeat(each, sizes) for each in ([kind for kind, _ in lines], range(len(lines))))
    names = (f"boundary_{name}" for name, _ in (x, y))
    return {name: (dim, own, cf.parameter(name, cf.VARIED)) for name, own in zip(names, points.T, strict=True)} | {
        "boundary_name": cf.flagged(dim, kinds, "name of the exact curve", ChartBoundary),
        "boundary_line": cf.variable(dim, number.astype(np.int32), "1", "number of the line, whose points are joined"),
    }


def summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a sweep for JSON: points, how many of each attractor and behaviour, names of exact curves, rate."""
    counts = {name: cf.counted(found[name]) if name in found else {} for name in ("behaviour", "boundary_name")}
    return {
        "points": found.attractor.size,
        "attractors": cf.counted(found.attractor),
        "behaviours": counts["behaviour"],
        "curves": list(counts["boundary_name"]),
        "points_per_second": found.attractor.size / seconds,
    }


def text(summary: Mapping[str, Any], table: Any) -> Iterator[str]:
    """Say a sweep, as a table of pandas, and its :func:`summary` in lines."""
    own, kind = list(table)[: list(table).index("attractor")], "behaviour" if "behaviour" in table else "attractor"
    columns = [*(name.partition(" [")[0] for name in own), kind, "amplitude", "period", "peak_normal_force"]
    yield from on_screen(table, columns, "--out sweep.csv")
    for kind, count in (summary["behaviours"] or summary["attractors"]).items():
        yield f"{words.plain(kind)}: {count} of {summary['points']} points"
    if summary["curves"]:
        yield f"exact curves: {', '.join(map(words.plain, summary['curves']))}"
    yield f"{words.rate(summary['points_per_second'])} points per second"


def write_chart(
    settings: Mapping[str, Any], path: File, workers: int = 1, about: Mapping[str, str] | None = None
) -> None:
    """Write the sweep of settings ``drive`` (changes of Table 8.1), ``x`` and ``y``.

    Each axis has ``parameter``, ``start``, ``stop`` and ``count``; ``about``: attributes. Raises ``InputError``.
    """
    axes = ([settings[name][key] for key in ("parameter", "start", "stop", "count")] for name in ("y", "x"))
    over = {name: spaced(name, *span) for name, *span in axes}
    write_dataset(sweep(Drive.of(settings["drive"]), over, workers=workers).assign_attrs(about or {}), path)


def known_key(name: Any) -> None:
    """Raise ``InputError`` unless drives have a parameter of this name."""
    if not isinstance(name, str) or name not in Drive.model_fields:
        raise InputError(f"{numbers.shown(name)} is not a known key; {meant(Drive, name)}.")


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
