"""The region of attraction: the attractor of every start in a grid, how long it takes, and what happens on the way."""

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, Self

import numpy as np

from lsvib.analysis.sections import Sections
from lsvib.core import attraction
from lsvib.errors import InputError
from lsvib.models.model import find_model
from lsvib.models.parameters import LeadScrew

QUANTITIES = ("label", "time", "seizures", "first_event")
COORDINATES = {
    "u": "angle_deviation",
    "w": "velocity_deviation",
    "e": "thread_mismatch",
    "v": "mismatch_rate",
}
_EVENTS = 100_000  # budget of a motion
_CELLS = 16384  # of a block, about: the share of work that a thread takes at a time
_MOST = 1_000_000_000  # cells along an axis

Progress = Callable[[int, int], None]


class Axis(NamedTuple):
    """Cells of equal width along a coordinate: u [rad], w [rad/s], with compliant threads e [m] and v [m/s]."""

    coordinate: str
    start: float
    stop: float
    count: int

    def centres(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """Return the middles of cells ``first`` to ``last`` (excluded); each from its own index, whatever the range."""
        return self.middles(np.arange(first, self.count if last is None else last))

    def middles(self, index: np.ndarray) -> np.ndarray:
        """Return the middles of the cells of these indices."""
        return self.start + (index + 0.5) * ((self.stop - self.start) / self.count)

    @property
    def width(self) -> float:
        """Width of a cell."""
        return (self.stop - self.start) / self.count

    @classmethod
    def checked(cls, coordinate: str, start: float, stop: float, count: int) -> Self:
        """Make an axis; ``InputError`` if it is none."""
        if coordinate not in COORDINATES:
            raise InputError(f"axis {coordinate!r} is not a coordinate of a state: {', '.join(COORDINATES)}.")
        if not (math.isfinite(start) and math.isfinite(stop) and start < stop):
            raise InputError(f"axis {coordinate} has start = {start:g} and stop = {stop:g}; it needs start < stop.")
        if not 1 <= count <= _MOST:
            raise InputError(f"axis {coordinate} has count = {count}; the allowed range is 1 <= count <= {_MOST}.")
        return cls(coordinate, start, stop, count)


class Grid(NamedTuple):
    """Starts in two coordinates, ``x`` along columns and ``y`` along rows; ``fixed`` are the values of the others."""

    x: Axis
    y: Axis
    fixed: Mapping[str, float] = {}

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a grid from ``{coordinate: {start, stop, count}}`` twice and ``{coordinate: value}``, as YAML has it."""
        items = []
        for key, value in values.items():
            if isinstance(value, Mapping):
                if set(value) != {"start", "stop", "count"}:
                    raise InputError(f"axis {key} has the keys {', '.join(value)}; it needs start, stop and count.")
                value = f"{value['start']}:{value['stop']}:{value['count']}"
            items.append(f"{key}={value}")
        return cls.parse(items)

    @classmethod
    def parse(cls, items: Sequence[str]) -> Self:
        """Read ``KEY=START:STOP:COUNT`` twice and ``KEY=VALUE`` for coordinates that are fixed.

        Raises ``InputError`` in one sentence.
        """
        axes, fixed = [], {}
        for item in items:
            key, equals, text = item.partition("=")
            parts = text.split(":")
            if not equals or len(parts) not in (1, 3):
                raise InputError(f"{item!r} is neither of the form KEY=START:STOP:COUNT nor KEY=VALUE.")
            if key in fixed or key in [axis.coordinate for axis in axes]:
                raise InputError(f"the coordinate {key} is given twice.")
            try:
                numbers = [float(part) for part in parts]
            except ValueError:
                raise InputError(f"{item!r} holds something that is not a number.") from None
            if len(parts) == 1:
                if key not in COORDINATES or not math.isfinite(numbers[0]):
                    raise InputError(f"{item!r} does not fix one of the coordinates {', '.join(COORDINATES)}.")
                fixed[key] = numbers[0]
                continue
            if numbers[2] != int(numbers[2] if math.isfinite(numbers[2]) else 0):
                raise InputError(f"axis {key} has count = {parts[2]}, which is not a whole number.")
            axes.append(Axis.checked(key, numbers[0], numbers[1], int(numbers[2])))
        if len(axes) != 2:
            raise InputError(f"a grid needs two axes KEY=START:STOP:COUNT, not {len(axes)}.")
        return cls(*axes, fixed)


def mapper(
    drive: LeadScrew, model: str = "rigid", physics: Sequence[str] | None = None, resume: str = "contact_sign"
) -> "Mapper":
    """Return the mapper of a drive.

    Arguments: drive; name of the model; ``physics`` and ``resume`` as in a scene. Raises ``InputError``.
    """
    kind = find_model(model)
    if model != "rigid":
        raise InputError(f"model = {model!r} has no map yet; the allowed value is rigid.")
    physics = (*kind.terms, *kind.options) if physics is None else tuple(physics)
    return Mapper(drive, model, physics, resume)


class Mapper:
    """Maps the starts of a drive with two states to what becomes of them.

    * ``label``: the attractor (``lsvib.analysis.cycles.Attractor``), by the table of :mod:`lsvib.analysis.sections`;
      unresolved (−1) is a start that lies on a boundary to rounding.
    * ``time`` [s] until it is reached: for steady sliding the entry into the largest ellipse around the equilibrium in
      which no guard can fire (closed form); for a cycle the first event after which the motion is on it to 1e-9 of its
      size; infinite if the motion is unbounded or unresolved.
    * ``seizures`` until then, and ``first_event``: kind of the first event of the motion, −1 if there is none.

    No time of waiting enters. Every cell is computed on its own: no number depends on the grid around it, on tiles or
    on threads. ``attractors`` are the cycles that motions reach (``SteadyState``).
    """

    def __init__(self, drive: LeadScrew, model: str, physics: tuple[str, ...], resume: str) -> None:
        kind = find_model(model)
        self.drive, self.model, self.physics, self.resume = drive, model, physics, resume
        self.events = kind.events
        self.automaton = kind.build(drive, physics, resume)
        self.sections = Sections(self.automaton)
        self.attractors = self.sections.attractors
        self._sprags = np.array(self.automaton.sprag_kinds, dtype=np.int64)

    def cells(
        self,
        grid: Grid,
        rows: slice = slice(None),
        columns: slice = slice(None),
        quantities: Sequence[str] = QUANTITIES,
        threads: int = 1,
        progress: Progress | None = None,
    ) -> dict[str, np.ndarray]:
        """Map the cells ``rows`` × ``columns`` of a grid.

        Arguments: ``quantities`` wanted; number of ``threads``; ``progress``, called with the numbers of cells done
        and in all. Returns arrays of shape (rows, columns): label int8, time float64 [s], seizures int32, first_event
        int8. Raises ``InputError`` if the grid's coordinates are not those of the state, or a quantity is not known.
        """
        for name in quantities:
            if name not in QUANTITIES:
                raise InputError(f"quantity {name!r} is not one of {', '.join(QUANTITIES)}.")
        self._check(grid)
        y = grid.y.centres(*rows.indices(grid.y.count)[:2])
        x = grid.x.centres(*columns.indices(grid.x.count)[:2])
        across = int(grid.x.coordinate == "w")
        found = {"label": np.empty((y.size, x.size), dtype=np.int8)}
        found["first_event"] = np.empty((y.size, x.size if "first_event" in quantities else 0), dtype=np.int8)
        approaches = not {"time", "seizures"}.isdisjoint(quantities)
        if approaches:
            found["time"] = np.empty((y.size, x.size))
            found["seizures"] = np.empty((y.size, x.size), dtype=np.int32)

        def block(part: slice) -> int:
            tables, known = self.automaton.tables, self.sections.known
            labels = found["label"][part]
            attraction.map_labels(tables, known, x, y[part], across, _EVENTS, labels, found["first_event"][part])
            if approaches:
                times, counts = found["time"][part], found["seizures"][part]
                attraction.map_approaches(tables, known, self._sprags, x, y[part], across, _EVENTS, times, counts)
                times[labels == attraction.UNRESOLVED] = np.inf
            return labels.size

        height = max(1, _CELLS // max(1, x.size))
        parts = [slice(i, min(i + height, y.size)) for i in range(0, y.size, height)]
        done = 0
        with ThreadPoolExecutor(threads) as pool:
            for size in pool.map(block, parts):
                done += size
                if progress is not None:
                    progress(done, y.size * x.size)
        return {name: found[name] for name in quantities}

    def labels_of(self, u: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Return the labels (n) of single starts, u [rad] and w [rad/s] (n), with the same bits as in any grid."""
        u, w = np.asarray(u, dtype=float), np.asarray(w, dtype=float)
        order = np.argsort(w, kind="stable")
        x, y = u[order], w[order]
        found, none = np.empty((1, x.size), dtype=np.int8), np.empty((1, 0), dtype=np.int8)
        bounds = [0, *(np.flatnonzero(np.diff(y)) + 1), x.size] if x.size else [0]
        for first, last in zip(bounds[:-1], bounds[1:], strict=True):
            part, tables, known = slice(first, last), self.automaton.tables, self.sections.known
            attraction.map_labels(tables, known, x[part], y[first : first + 1], 0, _EVENTS, found[:, part], none)
        labels = np.empty(x.size, dtype=np.int8)
        labels[order] = found[0]
        return labels

    def labels_at(self, grid: Grid, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        """Return the labels (n) of single cells of a grid, given by their indices ``row`` and ``column`` (n)."""
        self._check(grid)
        x, y = grid.x.middles(column), grid.y.middles(row)
        return self.labels_of(x, y) if grid.x.coordinate == "u" else self.labels_of(y, x)

    def _check(self, grid: Grid) -> None:
        if {grid.x.coordinate, grid.y.coordinate} != {"u", "w"} or grid.fixed:
            raise InputError(
                "the rigid drive has the coordinates u and w: the grid needs them as its axes, none fixed."
            )
