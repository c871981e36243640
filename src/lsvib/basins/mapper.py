"""The region of attraction: the attractor of every start in a grid, how long it takes, and what happens on the way."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from lsvib.basins.grid import Grid
from lsvib.dynamics.attractor import SteadyState
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.friction import depends_on_speed
from lsvib.models.model import automaton_of, coordinates, model_of
from lsvib.numbers import Progress

QUANTITIES = {"label": np.int8, "time": np.float64, "seizures": np.int32, "first_event": np.int8, "doubt": np.int8}
NO_DOUBT = -1  # of a cell whose label is known


class Mapper(ABC):
    """Maps the starts of a drive to what becomes of them, whatever the number of states of its model.

    ``drive`` and ``physics`` are those of the scene; ``definition`` is what its parts make of it, and
    ``events`` are the codes of its events by name; ``attractors`` are the cycles that motions are known to reach. A
    mapper fills blocks of about ``block`` cells at a time.
    """

    attractors: Sequence[SteadyState]
    block: int

    def __init__(self, drive: Drive, physics: tuple[str, ...]) -> None:
        self.drive, self.physics = drive, physics
        self.definition = model_of(drive)
        self.events = self.definition.events
        self.automaton = automaton_of(drive)
        self.keys = tuple(key for key in coordinates() if coordinates()[key] in self.automaton.states)

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
        self.check(grid)
        y = grid.y.centres(*rows.indices(grid.y.count)[:2])
        x = grid.x.centres(*columns.indices(grid.x.count)[:2])
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

    def check(self, grid: Grid) -> None:
        """Raise ``InputError`` unless the grid has what a start needs, and nothing that the state has not."""
        given = (grid.x.coordinate, grid.y.coordinate, *grid.fixed)
        for key in given:
            if key not in self.keys:
                raise InputError(f"this drive has the coordinates {', '.join(self.keys)}, not {key}.")
        for key in self.definition.required:
            if key not in given:
                raise InputError(f"the grid needs the coordinate {key}, as an axis or fixed.")

    @abstractmethod
    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays (rows, columns) of at least the ``quantities`` of cells at ``x`` (columns) and ``y`` (rows)."""


def mapper(drive: Drive, physics: Sequence[str] | None = None) -> Mapper:
    """Return the mapper of a drive, ``physics`` as in a scene; raises ``InputError``.

    For a rigid drive whose motor turns that is a ``PlanarMapper`` or, under a friction law, a ``LawMapper``; else a
    ``StateMapper``.

    >>> import lsvib
    >>> from lsvib.basins.grid import Axis, Grid
    >>> grid = Grid(Axis("u", -0.03, 0.03, 4), Axis("w", -5, 5, 2))
    >>> mapped = mapper(lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10))
    >>> mapped.cells(grid, quantities=("label",))["label"].tolist()
    [[0, 0, 0, 0], [0, 0, 0, 2]]
    """
    definition = model_of(drive)
    physics = definition.terms if physics is None else tuple(physics)
    if not (drive.rigid and drive.input_speed):
        from lsvib.basins.slice_mapper import StateMapper  # each with kernels of its own

        return StateMapper(drive, physics)
    if depends_on_speed(drive):
        from lsvib.basins.law_mapper import LawMapper

        return LawMapper(drive, physics)
    from lsvib.basins.labels import PlanarMapper

    return PlanarMapper(drive, physics)
