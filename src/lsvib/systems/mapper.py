"""The region of attraction: the attractor of every start in a grid, how long it takes, and what happens on the way."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from lsvib.errors import InputError
from lsvib.numbers import Progress
from lsvib.systems.attractor import SteadyState
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


class Mapper(ABC):
    """Maps the starts of an automaton to what becomes of them, whatever the number of its states.

    ``attractors`` are the cycles that motions are known to reach. A mapper fills blocks of about ``block`` cells at a
    time.
    """

    attractors: Sequence[SteadyState]
    block: int

    def __init__(self, automaton: Automaton, starts: Starts) -> None:
        self.automaton, self.starts = automaton, starts

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
        height = max(1, self.block // max(1, x.size))
        parts = [slice(i, min(i + height, y.size)) for i in range(0, y.size, height)]

        def fill(part: slice) -> None:
            self.fill({name: array[part] for name, array in found.items()}, grid, x, y[part], quantities)

        with ThreadPoolExecutor(workers) as pool:
            for part, _ in zip(parts, pool.map(fill, parts), strict=True):
                if progress is not None:
                    progress(part.stop, y.size)
        return {name: found[name] for name in quantities}

    @abstractmethod
    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays (rows, columns) of at least the ``quantities`` of cells at ``x`` (columns) and ``y`` (rows)."""
