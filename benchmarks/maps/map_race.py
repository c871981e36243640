"""Ways to map a region of attraction in one run: labels per second, wrong labels, how near to the boundary they lie.

The judge is the exact boundary of the basin (:mod:`lsvib.basins.boundary`), which no map knows of: a label is wrong
if it says steady sliding outside of it or anything else inside. Distances are in widths of the box along each axis, so
that a cell of a map of n × n cells is 1/n wide.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.maps.map_kernels import stepped_labels
from lsvib.basins.boundary import Basin, basin
from lsvib.basins.curves import Arc, Piece, Window, inside, state_on
from lsvib.basins.kernels import labels as engine
from lsvib.basins.labels import PlanarMapper
from lsvib.basins.mapper import mapper
from lsvib.dynamics.attractor import Attractor
from lsvib.engine.kernels import layout
from lsvib.errors import InputError
from lsvib.models.drive import Drive

_SAMPLES = 400  # points of a piece of the boundary from which its length is summed
_LONG = 1.0  # [s] A method that takes longer on a box is not repeated.
_ENOUGH = 10  # With so many wrong cells on a grid their number tells their share.
_HORIZON = 1.0  # [s] after which the motion of a rival is unresolved: some hundred swings of the drive
_BUDGET = 100_000  # events after which a motion is unresolved

Label = Callable[[np.ndarray, np.ndarray, np.ndarray], None]  # (x, y, labels), filled


@dataclass(frozen=True)
class MapMethod:
    """A way to map: ``prepare`` makes the function that is timed."""

    label: str
    prepare: Callable[[PlanarMapper], Label]


def _engine(maps: PlanarMapper) -> Label:
    tables, known = maps.automaton.tables, maps.sections.known
    none = np.empty((0, 0), dtype=np.int8)
    return lambda x, y, found: engine.map_labels(tables, known, engine.Cells(x, y, 0), _BUDGET, found, none)


def _stepped(maps: PlanarMapper, step: float) -> Label:
    tables, known = maps.automaton.tables, maps.sections.known
    return lambda x, y, labels: stepped_labels(tables, known, x, y, step, _HORIZON, labels)


METHODS: dict[str, MapMethod] = {
    "engine": MapMethod("lsvib", _engine),
    "rk4_coarse": MapMethod("RK4, 1e-4 s", partial(_stepped, step=1e-4)),
    "rk4_fine": MapMethod("RK4, 1e-5 s", partial(_stepped, step=1e-5)),
}


@dataclass(frozen=True)
class RaceBox:
    """A drive and the part of the phase plane that is mapped."""

    drive: Drive
    window: Window

    def grid(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Middles of count × count cells: u (count) [rad], w (count) [rad/s]."""
        part = (np.arange(count) + 0.5) / count
        left, right, bottom, top = self.window
        return left + part * (right - left), bottom + part * (top - bottom)


@dataclass
class MapOutcome:
    """What one method does on one box.

    ``seconds`` [s] of processor time for one start on one thread, of each repeat; numbers of ``cells`` and of
    those with a wrong and an undecided label; shares [1] of ``wrong`` and ``undecided`` labels at each distance (d).
    """

    seconds: list[float]
    cells: int
    wrong_cells: int
    undecided_cells: int
    wrong: np.ndarray
    undecided: np.ndarray


def contest(
    box: RaceBox, cells: Mapping[str, int], repeats: int, distances: np.ndarray, count: int, seed: int
) -> tuple[dict[str, MapOutcome], float]:
    """Run the methods on a box.

    Arguments: ``cells`` along an edge of each method's grid; ``repeats`` of each grid, methods in turn, after one run
    that compiles; ``distances`` (d) [widths of the box] from the boundary of ``count`` random starts on either side of
    it; ``seed`` of those. Returns the outcomes by method, and the length of the boundary in
    the box [widths of the box].
    """
    maps, exact = mapper(box.drive), basin(box.drive)
    beside, length = beside_boundary(exact, box.window, distances, count, seed)
    starts = beside.reshape(-1, 2)
    truth = np.array([exact.contains(start) for start in starts])
    outcomes, labels_of = {}, {name: METHODS[name].prepare(maps) for name in cells}
    for name, edge in cells.items():
        labels = np.array([_cells(labels_of[name], start[:1], start[1:])[0, 0] for start in starts])
        wrong, undecided = _judged(labels, truth)
        share = [part.reshape(distances.size, -1).mean(axis=1) for part in (wrong, undecided)]
        x, y = box.grid(edge)
        inside_cells = np.array([[exact.contains((u, w)) for u in x] for w in y])
        found = _judged(_cells(labels_of[name], x, y), inside_cells)
        outcomes[name] = MapOutcome([], edge**2, int(found[0].sum()), int(found[1].sum()), *share)
    _take_times(box, cells, labels_of, outcomes, repeats)
    return outcomes, length


def strip_share(distances: np.ndarray, wrong: np.ndarray, length: float) -> float:
    """Share [1] of a box labelled wrongly, from the shares ``wrong`` (d) at ``distances`` (d) from the boundary in it.

    What lies nearer to the boundary than the smallest distance counts as wrong, so that it is never nothing.
    """
    steps = np.diff(distances)
    strip = distances[0] + float((0.5 * (wrong[1:] + wrong[:-1]) * steps).sum())
    return 2.0 * length * strip


def wrong_share(outcome: MapOutcome, distances: np.ndarray, length: float) -> float:
    """Share [1] of wrong labels: counted where the grid has enough of them, else that of the strip at the boundary."""
    if outcome.wrong_cells >= _ENOUGH:
        return outcome.wrong_cells / outcome.cells
    return strip_share(distances, outcome.wrong, length)


def beside_boundary(
    exact: Basin, window: Window, distances: np.ndarray, count: int, seed: int
) -> tuple[np.ndarray, float]:
    """Return starts beside the boundary of a basin, (distance, side, count, 2), and its length in a window.

    ``count`` points are spread evenly along the boundary, by length, and each is moved to either side, at right angles,
    by every distance; lengths, distances and angles in widths of the window. Raises ``InputError`` if no part of the
    boundary lies in the window.
    """
    closed, paths = inside(exact.flow, exact.curves, window)
    pieces = [piece for path in (*closed, *paths) for piece in path]
    if not pieces:
        raise InputError("the boundary of the basin does not pass through the box.")
    widths = np.array([window.right - window.left, window.top - window.bottom])
    along = np.linspace(0.0, 1.0, _SAMPLES)
    tracks = [np.array([_point(exact.flow, piece, part) for part in along]) / widths for piece in pieces]
    sums = [np.append(0.0, np.cumsum(np.hypot(*np.diff(track, axis=0).T))) for track in tracks]
    ends = np.append(0.0, np.cumsum([total[-1] for total in sums]))
    generator = np.random.default_rng(seed)
    places = (np.arange(count) + generator.random(count)) / count * ends[-1]
    found = np.empty((distances.size, 2, count, 2))
    for k, place in enumerate(places):
        index = min(int(np.searchsorted(ends, place, "right")) - 1, len(pieces) - 1)
        part = float(np.interp(place - ends[index], sums[index], along))
        point = _point(exact.flow, pieces[index], part)
        tangent = _tangent(exact.flow, pieces[index], point) / widths
        normal = np.array([-tangent[1], tangent[0]]) / np.hypot(*tangent)
        for side in (0, 1):
            found[:, side, k] = point + np.multiply.outer(distances, (1 - 2 * side) * normal * widths)
    return found, float(ends[-1])


def _point(flow: np.ndarray, piece: Piece, part: float) -> np.ndarray:
    """The state (2) on a piece at a part of its time, or of its length."""
    if isinstance(piece, Arc):
        return state_on(flow, piece, part * piece.duration)
    return piece.start + part * (piece.end - piece.start)


def _tangent(flow: np.ndarray, piece: Piece, point: np.ndarray) -> np.ndarray:
    if not isinstance(piece, Arc):
        return piece.end - piece.start
    row, (u, w) = flow[piece.mode], point
    return np.array([w, row[layout.B] - row[layout.A0] * u - row[layout.A1] * w])


def _judged(labels: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mark wrong and undecided labels; ``truth``: whether the start lies in the basin."""
    undecided = labels == engine.UNRESOLVED
    return ~undecided & ((labels == Attractor.STEADY_SLIDING) != truth), undecided


def _cells(label: Label, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Labels (rows, columns) of a grid."""
    labels = np.empty((y.size, x.size), dtype=np.int8)
    label(x, y, labels)
    return labels


def _take_times(
    box: RaceBox,
    cells: Mapping[str, int],
    labels_of: Mapping[str, Label],
    outcomes: Mapping[str, MapOutcome],
    repeats: int,
) -> None:
    """Enter the processor times of each method, all in turn, so that a busy machine slows all alike."""
    grids = {name: (*box.grid(edge), np.empty((edge, edge), dtype=np.int8)) for name, edge in cells.items()}
    spent = dict.fromkeys(grids, 0.0)
    for _ in range(repeats):
        for name, (x, y, labels) in grids.items():
            if spent[name] > _LONG:
                continue
            begun = time.process_time()
            labels_of[name](x, y, labels)
            took = time.process_time() - begun
            spent[name] += took
            outcomes[name].seconds.append(took / labels.size)
