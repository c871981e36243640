"""Maps of the region of attraction by this engine and by other methods: speed and wrong labels."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from benchmarks.record import QUARTILES, quartiles
from lsvib.datasets import spans
from lsvib.datasets.attributes import drive_parameters, named_index, variable
from lsvib.datasets.checks import Check
from lsvib.datasets.io import machine
from lsvib.figures import style
from lsvib.figures.settings import CaseSeed, DriveChanges, FigureSettings, PlaneWindow, PositiveSpan, SettingsSection
from lsvib.figures.style import Axes, Figure
from lsvib.models.drive import Drive

if TYPE_CHECKING:
    from benchmarks.maps.map_race import MapOutcome, RaceBox

CAPTION = """\
Ways to map the region of attraction: (a) share of wrong labels of the box against labels per second on one thread;
(b–d) share of labels that are wrong, and shaded of those that are undecided, among starts at a distance from the exact
boundary of the basin, in widths of the box, with the quartiles of how many times longer Runge–Kutta takes. What is
nearer to the boundary than the smallest distance counts as wrong in (a).
"""

BoxName = Annotated[str, Field(pattern="^[a-z][a-z0-9_]*$")]
Some = Annotated[int, Field(ge=1, le=10_000)]
SomeOrNone = Annotated[int, Field(ge=0, le=10_000)]
_SOURCE = "docs/attraction.md"
_CERTAIN = 1e-12  # distance from which on no label of the engine may be wrong or undecided
_CHANGED = ("mass", "support_damping", "axial_force")  # in which the drives of the boxes may differ
_PLACES = ("Fig. 8.14", "Sect. 8.6")  # that state some of their values
_STYLES = {  # colour, dashes
    "engine": (style.BLACK, "-"),
    "rk4_coarse": (style.BLUE, "-"),
    "rk4_fine": (style.SKY, "-"),
}
_MARKERS = {"o": "circles", "s": "squares", "D": "diamonds", "^": "triangles", "v": "wedges", "P": "crosses"}  # boxes


class MappedBox(SettingsSection):
    """A drive and the part of the phase plane that is mapped."""

    drive: DriveChanges
    window: PlaneWindow


class CellsOfMethods(SettingsSection):
    """Cells along an edge of each method's grid, 0 to leave the method out."""

    engine: Some
    rk4_coarse: Some
    rk4_fine: SomeOrNone = 0


class Settings(FigureSettings):
    """Ways to map the region of attraction, their speed and their wrong labels."""

    timed: ClassVar = True

    boxes: dict[BoxName, MappedBox] = Field(
        min_length=1, max_length=6, description="Drives, each with the part of the phase plane that is mapped."
    )
    cells: CellsOfMethods
    repeats: int = Field(ge=1, le=1000, description="Repeats of each timed grid.")
    distances: PositiveSpan = Field(
        description="Distances from the boundary in widths of the box, evenly in logarithms."
    )
    starts: int = Field(ge=1, le=100_000, description="Starts on either side of the boundary at each distance.")
    seed: CaseSeed = Field(description="Seed of their places along the boundary.")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the methods of :data:`benchmarks.maps.map_race.METHODS` on some boxes."""
    from benchmarks.maps.map_race import METHODS, RaceBox, contest
    from lsvib.basins.curves import Window
    from lsvib.datasets import phase_plane

    cells = {name: count for name, count in settings["cells"].items() if count}
    distances = spans.logarithmic(settings["distances"])
    boxes = [RaceBox(Drive.of(b["drive"]), Window(**b["window"])) for b in settings["boxes"].values()]
    found = [contest(box, cells, settings["repeats"], distances, settings["starts"], settings["seed"]) for box in boxes]
    rows = [[outcomes[name] for outcomes, _ in found] for name in cells]
    lengths, labels = [length for _, length in found], "; ".join(METHODS[name].label for name in cells)
    along = "boundary_distance"
    return xr.Dataset(
        _measured(rows, distances, lengths)
        | {
            **phase_plane.window_edges("window", ("box", "edge"), [box.window for box in boxes]),
        },
        coords={
            **drive_parameters([box.drive for box in boxes], "box", along=_CHANGED, printed=_PLACES),
            "method": named_index("method", "method", list(cells), labels=labels),
            "box": named_index("box", "box", list(settings["boxes"]), labels="; ".join(map(_title, boxes))),
            "quartile": variable("quartile", list(QUARTILES), "1", "share of the repeats below"),
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
    """Check that no label of the engine is wrong or undecided."""
    engine = dataset.isel(method=dataset.method.attrs["flag_meanings"].split().index("engine"))
    far = dataset.boundary_distance.values >= _CERTAIN * 0.99  # a distance is a power of ten only to rounding
    near = (engine.wrong_near + engine.undecided_near).values[:, far]
    on_grid = int((engine.wrong_cells + engine.undecided_cells).sum())
    return [
        Check.holds(
            f"No label of the engine is wrong or undecided, on grids and {_CERTAIN:g} widths or more from the boundary",
            _SOURCE,
            f"{on_grid} of {int(engine.cells.sum())} cells, largest share at a distance {near.max():g}",
            on_grid == 0 and not near.any(),
        ),
    ]


def _measured(rows: "list[list[MapOutcome]]", distances: np.ndarray, lengths: list[float]) -> dict[str, tuple]:
    """Variables over (method, box) and (method, box, distance)."""
    from benchmarks.maps.map_race import wrong_share

    def table(value, dtype=float) -> np.ndarray:
        return np.array([[value(outcome) for outcome in row] for row in rows], dtype=dtype)

    first, coarse = rows[0], rows[1]  # the engine, and the only one that is never left out
    pairs = [list(zip(a.seconds, b.seconds, strict=False)) for a, b in zip(first, coarse, strict=True)]
    ratios = [quartiles([theirs / ours for ours, theirs in pair]) for pair in pairs]
    flat, deep = ("method", "box"), ("method", "box", "boundary_distance")
    where = "distance from the boundary"
    reach = table(lambda o: np.max(distances[(o.wrong + o.undecided) > 0], initial=0.0))
    share = np.array([[wrong_share(o, distances, x) for o, x in zip(row, lengths, strict=True)] for row in rows])
    return {
        "time_per_label": variable(flat, table(lambda o: min(o.seconds)), "s", "processor time for one label"),
        "time_per_label_quartiles": variable(
            (*flat, "quartile"), table(lambda o: quartiles(o.seconds)), "s", "processor time for one label, quartiles"
        ),
        "coarse_ratio": variable(("box", "quartile"), ratios, "1", "time of RK4 with the coarse step over lsvib's"),
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


def _title(box: "RaceBox") -> str:
    left, right, bottom, top = box.window
    edges = (
        f"±{right:g} rad × ±{top:g} rad/s"
        if (left, bottom) == (-right, -top)
        else f"{left:g} … {right:g} rad × {bottom:g} … {top:g} rad/s"
    )
    return f"R = {box.drive.axial_force:g} N, {edges}".replace("-", "−")


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) wrong share against labels per second for all boxes, (b …) labels near the boundary, box by box."""
    count = dataset.sizes["box"]
    rows = (count + 2) // 2
    figure = style.new_figure(style.DOUBLE, 2.6 * rows + 0.8)
    panels = np.ravel(figure.subplots(rows, 2))
    names = dataset.method.attrs["flag_meanings"].split()
    titles = dataset.box.attrs["labels"].split("; ")
    _speed(panels[0], dataset, names)
    for k, axes in enumerate(panels[1:]):
        if k >= count:
            axes.set_visible(False)
            continue
        _near(axes, dataset.isel(box=k), names)
        low, middle, high = dataset.coarse_ratio.values[k]
        slower = f"RK4 of 1e-4 s × {middle:.2g} ({low:.2g}–{high:.2g})"
        axes.set_title(f"({chr(98 + k)}) {list(_MARKERS.values())[k]}: {titles[k]}\n{slower}", fontsize=7)
    figure.legend(handles=_handles(dataset, names), loc="outside lower center", ncols=4, fontsize=6.5)
    return figure


def _speed(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Labels per second and wrong share of each box; an arrow marks a bound, where no wrong label was seen."""
    for k, name in enumerate(names):
        method = dataset.isel(method=k)
        colour, dashes = _STYLES[name]
        for box, marker in zip(range(dataset.sizes["box"]), _MARKERS, strict=False):
            face = colour if dashes == "-" else "white"
            rate, share = 1.0 / float(method.time_per_label[box]), float(method.wrong_share[box])
            axes.plot(rate, share, marker, color=colour, mfc=face, markersize=5)
            axes.hlines(
                share, *(1.0 / method.time_per_label_quartiles.values[box, [2, 0]]), color=colour, linewidth=0.8
            )
            if float(method.reach[box]) == 0.0 and int(method.wrong_cells[box]) == 0:
                axes.annotate("", (rate, share / 30), (rate, share), arrowprops={"arrowstyle": "->", "color": colour,
                              "linewidth": 0.7})  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="Labels per second, one thread [s⁻¹]", ylabel="Share of wrong labels")
    axes.set_title("(a) speed and wrong labels of all boxes", fontsize=7)
    axes.margins(0.08)
    low, high = axes.get_ylim()
    axes.set_ylim(low / 30, high)


def _near(axes: Axes, box: xr.Dataset, names: list[str]) -> None:
    for k, name in enumerate(names):
        method = box.isel(method=k)
        colour, dashes = _STYLES[name]
        width = 1.6 if name == "engine" else 1.0
        axes.plot(
            box.boundary_distance,
            method.wrong_near,
            dashes,
            color=colour,
            linewidth=width,
            zorder=3 if name == "engine" else 2,
        )
        if method.undecided_near.any():
            either = method.wrong_near + method.undecided_near
            axes.fill_between(box.boundary_distance, method.wrong_near, either, color=colour, alpha=0.15, linewidth=0)
    axes.set(xscale="log", xlabel="Distance from the boundary [widths of the box]", ylabel="Share of wrong labels")
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlim(float(box.boundary_distance[0]), float(box.boundary_distance[-1]))
    for power in (3, 6):  # maps of 10³ × 10³ and 10⁶ × 10⁶ cells
        axes.axvline(10.0**-power, color=style.GREY, linestyle=":", linewidth=0.8, zorder=0)
        words = f"cell of\n$10^{power}\\times10^{power}$"
        axes.text(1.3 * 10.0**-power, 0.99, words, fontsize=7.5, color=style.GREY, va="top")


def _handles(dataset: xr.Dataset, names: list[str]) -> list:
    from matplotlib.lines import Line2D

    labels = dataset.method.attrs["labels"].split("; ")
    handles = [
        Line2D([], [], color=_STYLES[name][0], linestyle=_STYLES[name][1], label=label)
        for name, label in zip(names, labels, strict=True)
    ]
    if dataset.undecided_near.any():
        handles.append(Line2D([], [], color=style.VERMILION, alpha=0.15, linewidth=6, label="undecided"))
    return handles
