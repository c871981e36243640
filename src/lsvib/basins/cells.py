"""What all mappers of regions of attraction share: their interface, the quantities of a cell, and work in blocks."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import numpy as np

from lsvib.basins.grid import Grid
from lsvib.cycles.attractors import SteadyState
from lsvib.drives.parameters import RigidParameters
from lsvib.engine.automaton import Automaton
from lsvib.errors import InputError

QUANTITIES = ("label", "time", "seizures", "first_event", "doubt")
NO_DOUBT = -1  # of a cell whose label is told

Progress = Callable[[int, int], None]


class Mapper(Protocol):
    """What every mapper offers, whatever the number of states of its model.

    ``drive``, ``model``, ``physics`` and ``resume`` are those of the scene; ``events`` are the codes of the model's
    events by name; ``attractors`` are the cycles that motions are known to reach.
    """

    drive: RigidParameters
    model: str
    physics: tuple[str, ...]
    resume: str
    events: Mapping[str, int]
    automaton: Automaton
    attractors: Sequence[SteadyState]

    def cells(
        self,
        grid: Grid,
        rows: slice = ...,
        columns: slice = ...,
        quantities: Sequence[str] = ...,
        workers: int = ...,
        progress: Progress | None = ...,
    ) -> dict[str, np.ndarray]:
        """Map the cells ``rows`` × ``columns`` of a grid.

        Arguments: ``quantities`` wanted; number of ``workers``; ``progress``, called with the numbers of rows done
        and in all. Returns arrays of shape (rows, columns): label int8, time float64 [s], seizures int32, first_event
        int8, doubt int8 (the place in :class:`Doubt` of why the label is unresolved, −1 if it is not). Raises
        ``InputError`` if the grid's coordinates are not those of the state, or a quantity is not known.
        """
        ...

    def labels_of(self, u: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Return the labels (n) of single starts, u [rad] and w [rad/s] (n), with the same bits as in any grid."""
        ...


def check_quantities(names: Sequence[str]) -> None:
    """Raise ``InputError`` if a name is none of a quantity."""
    for name in names:
        if name not in QUANTITIES:
            raise InputError(f"quantity {name!r} is not one of {', '.join(QUANTITIES)}.")


def in_blocks(
    work: Callable[[slice], None], rows: int, height: int, workers: int, progress: Progress | None = None
) -> None:
    """Call ``work`` for blocks of ``height`` of so many ``rows``, by ``workers``, and tell ``progress`` of the rows."""
    parts = [slice(i, min(i + height, rows)) for i in range(0, rows, height)]
    with ThreadPoolExecutor(workers) as pool:
        for part, _ in zip(parts, pool.map(work, parts), strict=True):
            if progress is not None:
                progress(part.stop, rows)
