"""Maps of the region of attraction by this engine and by other methods: speed and wrong labels."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from benchmarks.maps.map_methods import METHODS
from benchmarks.maps.map_race import MapOutcome, RaceBox, contest, wrong_share
from lsvib.basins.curves import Window
from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import drive_parameters, named_index, variable
from lsvib.datasets.checks import Check
from lsvib.datasets.io import machine
from lsvib.models.drive import RigidDrive

_SOURCE = "docs/attraction.md"
_CERTAIN = 1e-12  # distance from which on no label of the engine may be wrong or undecided
_CHANGED = ("mass", "support_damping", "axial_force")  # in which the drives of the boxes may differ
_PLACES = ("Fig. 8.14", "Sect. 8.6")  # that state some of their values


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the methods of :data:`benchmarks.maps.map_methods.METHODS` on some boxes."""
    cells = {name: count for name, count in settings["cells"].items() if count}
    distances = spans.logarithmic(settings["distances"])
    boxes = [RaceBox(RigidDrive.of(b["drive"]), Window(**b["window"])) for b in settings["boxes"].values()]
    found = [contest(box, cells, settings["repeats"], distances, settings["starts"], settings["seed"]) for box in boxes]
    rows = [[outcomes[name] for outcomes, _ in found] for name in cells]
    lengths, labels = [length for _, length in found], "; ".join(METHODS[name].label for name in cells)
    floors, along = [box["ratio_floor"] for box in settings["boxes"].values()], "boundary_distance"
    return xr.Dataset(
        _measured(rows, distances, lengths)
        | {
            **phase_plane.window_edges("window", ("box", "edge"), [box.window for box in boxes]),
            "ratio_floor": variable("box", floors, "1", "ratio to RK4 with the coarse step that is asked for"),
        },
        coords={
            **drive_parameters([box.drive for box in boxes], "box", along=_CHANGED, printed=_PLACES),
            "method": named_index("method", "method", list(cells), labels=labels),
            "box": named_index("box", "box", list(settings["boxes"]), labels="; ".join(map(_title, boxes))),
            along: variable(along, distances, "1", "distance from the boundary in widths of the box"),
        },
        attrs={
            "title": "Maps of the region of attraction by this engine and by other methods",
            "source": "lsvib; labels judged by the exact boundary of the basin",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7",
            "timing": "processor time of one thread for a grid, methods in turn, least of the repeats; without "
            "compilation and the engine's table of intervals",
            **machine(),
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that no label of the engine is wrong or undecided, and how much faster than Runge–Kutta it is."""
    names = dataset.method.attrs["flag_meanings"].split()
    boxes = np.atleast_1d(dataset.box.attrs["flag_meanings"].split())
    engine, coarse = (dataset.isel(method=names.index(n)) for n in ("engine", "rk4_coarse"))
    far = dataset.boundary_distance.values >= _CERTAIN * 0.99  # a distance is a power of ten only to rounding
    near = (engine.wrong_near + engine.undecided_near).values[:, far]
    on_grid = int((engine.wrong_cells + engine.undecided_cells).sum())
    ratio = (coarse.time_per_label / engine.time_per_label).values
    return [
        Check.holds(
            f"No label of the engine is wrong or undecided, on grids and {_CERTAIN:g} widths or more from the boundary",
            _SOURCE,
            f"{on_grid} of {int(engine.cells.sum())} cells, largest share at a distance {near.max():g}",
            on_grid == 0 and not near.any(),
        ),
        *(
            Check.holds(
                f"{box}: the engine maps at least {floor:g} times as fast as RK4 of 1e-4 s with the same rule",
                _SOURCE,
                f"{x:.2f} times",
                x >= floor,
            )
            for box, x, floor in zip(boxes, ratio, dataset.ratio_floor.values, strict=True)
        ),
    ]


def _measured(rows: list[list[MapOutcome]], distances: np.ndarray, lengths: list[float]) -> dict[str, tuple]:
    """Variables over (method, box) and (method, box, distance)."""

    def table(value, dtype=float) -> np.ndarray:
        return np.array([[value(outcome) for outcome in row] for row in rows], dtype=dtype)

    flat, deep = ("method", "box"), ("method", "box", "boundary_distance")
    where = "distance from the boundary"
    reach = table(lambda o: np.max(distances[(o.wrong + o.undecided) > 0], initial=0.0))
    share = np.array([[wrong_share(o, distances, x) for o, x in zip(row, lengths, strict=True)] for row in rows])
    return {
        "time_per_label": variable(flat, table(lambda o: o.seconds), "s", "processor time for one label"),
        "cells": variable(flat, table(lambda o: o.cells, np.int64), "1", "number of cells of the grid"),
        "wrong_cells": variable(flat, table(lambda o: o.wrong_cells, np.int64), "1", "cells with a wrong label"),
        "undecided_cells": variable(
            flat, table(lambda o: o.undecided_cells, np.int64), "1", "cells without a label, the method being undecided"
        ),
        "wrong_share": variable(flat, share, "1", "share of the box that is labelled wrongly"),
        "reach": variable(flat, reach, "1", f"largest {where} at which a label is wrong or undecided, 0 for none"),
        "wrong_near": variable(deep, table(lambda o: o.wrong), "1", f"share of wrong labels at a {where}"),
        "undecided_near": variable(deep, table(lambda o: o.undecided), "1", f"share of undecided labels at a {where}"),
    }


def _title(box: RaceBox) -> str:
    left, right, bottom, top = box.window
    edges = (
        f"±{right:g} rad × ±{top:g} rad/s"
        if (left, bottom) == (-right, -top)
        else f"{left:g} … {right:g} rad × {bottom:g} … {top:g} rad/s"
    )
    return f"R = {box.drive.axial_force:g} N, {edges}".replace("-", "−")
