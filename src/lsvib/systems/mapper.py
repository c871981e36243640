"""The region of attraction: the attractor of every start in a grid, how long it takes, and what happens on the way.

Every start is asked of the one rule (:mod:`lsvib.systems.attractor`), with the cycles that a few fixed starts reach as
known ones, which a motion that joins them ends on at once. So the result does not depend on the grid, tiles or workers.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from lsvib.errors import EngineError, InputError
from lsvib.numbers import Progress
from lsvib.systems.attractor import Attractor, Doubt, KnownCycles, SteadyState, end_of_motion
from lsvib.systems.automaton import Automaton
from lsvib.systems.grid import Grid

QUANTITIES = {"label": np.int8, "time": np.float64, "seizures": np.int32, "first_event": np.int8, "doubt": np.int8}
NO_DOUBT = -1  # of a cell whose label is known


@dataclass(frozen=True)
class Starts:
    """How motions of a system begin, for its maps.

    ``state`` makes a state (n) of the values that a grid gives by name, or raises ``InputError``; ``size`` (2) is that
    of motions in the first two coordinates, and ``first`` are states from which cycles are looked for beforehand.
    """

    state: Callable[[Mapping[str, float]], np.ndarray]
    size: np.ndarray
    first: Sequence[np.ndarray]


class Mapper:
    """Maps planar slices of the starts of an automaton to what becomes of them, one motion followed for every cell.

    ``label`` is decided as the module says; ``time`` [s] and ``seizures`` (events or modes that sprag) are those until
    then: the last event, or the fourth of the points that show the cycle; ``first_event``: kind of the first event.
    ``attractors`` are the cycles that motions are known to reach.
    """

    work = 700_000  # events of a motion, each of some microseconds

    def __init__(self, automaton: Automaton, starts: Starts) -> None:
        self.automaton, self.starts = automaton, starts
        self.attractors: list[SteadyState] = []
        for start in starts.first:
            with suppress(EngineError):
                found, _ = end_of_motion(automaton, start, max_events=70_000)
                known = any(other.same_period(found) for other in self.attractors)
                if found.orbit is not None and found.orbit.time.size and not known:
                    self.attractors.append(found)
        # Cycles that are not known are looked for after 1024 events: their map costs more than these.
        self._known = KnownCycles.of(self.attractors, self.automaton, 1024)

    def cells(
        self,
        grid: Grid,
        rows: slice = slice(None),
        columns: slice = slice(None),
        quantities: Sequence[str] = tuple(QUANTITIES),
        workers: int = 1,
        progress: Progress | None = None,
    ) -> dict[str, np.ndarray]:
        """Map the cells ``rows`` × ``columns`` of a grid.

        Every cell is computed on its own: no number depends on the grid around it, on tiles or on ``workers``.

        Arguments: ``quantities`` wanted; number of ``workers``; ``progress``, called with the numbers of rows done
        and in all. Returns arrays of shape (rows, columns): label int8, time float64 [s], seizures int32, first_event
        int8, doubt int8 (the place in ``Doubt`` of why the label is unresolved, −1 if it is not). Raises ``InputError``
        if the grid's coordinates are not those of the state, or a quantity is not known.
        """
        for name in quantities:
            if name not in QUANTITIES:
                raise InputError(f"quantity {name!r} is not one of {', '.join(QUANTITIES)}.")
        y = grid.y.centres(*rows.indices(grid.y.count)[:2])
        x = grid.x.centres(*columns.indices(grid.x.count)[:2])
        self.starts.state({**grid.fixed, grid.x.coordinate: grid.x.start, grid.y.coordinate: grid.y.start})
        # An array that nobody fills takes no memory.
        found = {name: np.empty((y.size, x.size), dtype) for name, dtype in QUANTITIES.items()}

        def fill(row: int) -> None:
            here = slice(row, row + 1)
            self.fill({name: array[here] for name, array in found.items()}, grid, x, y[here], quantities)

        with ThreadPoolExecutor(workers) as pool:
            for done, _ in enumerate(pool.map(fill, range(y.size)), 1):
                if progress is not None:
                    progress(done, y.size)
        return {name: found[name] for name in quantities}

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays (rows, columns) of at least the ``quantities`` of cells at ``x`` and ``y``, one after the other.

        Coordinates that are neither axes nor fixed have the values of steady sliding, such as a seated contact.
        """
        for i, j in np.ndindex(y.size, x.size):
            self.follow(found, grid, i, j, float(x[j]), float(y[i]))

    def follow(self, found: Mapping[str, np.ndarray], grid: Grid, i: int, j: int, x: float, y: float) -> None:
        """Fill the cell (i, j), at ``x`` and ``y``, by the one rule."""
        state = self.starts.state({**grid.fixed, grid.x.coordinate: x, grid.y.coordinate: y})
        try:
            end, course = end_of_motion(self.automaton, state, max_events=self.work, known=self._known)
            label, doubt, sprags, first = end.label, end.doubt, course.sprags, course.first_event
            time = np.inf if doubt is not None or label == Attractor.UNBOUNDED else course.time
        except EngineError as error:  # no mode fits the start
            label, doubt, time, sprags, first = Attractor.UNRESOLVED, Doubt.of(error), np.inf, 0, -1
        code = NO_DOUBT if doubt is None else list(Doubt).index(doubt)
        for array, value in zip(found.values(), (label, time, sprags, first, code), strict=True):
            array[i, j] = value
