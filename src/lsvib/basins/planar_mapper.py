"""The region of attraction of models with two states: every start is looked up in a table of sections."""

from collections.abc import Mapping, Sequence

import numpy as np

from lsvib.basins.grid import Grid
from lsvib.basins.kernels import arrival
from lsvib.basins.labels import Sections
from lsvib.basins.mapper import NO_DOUBT, Mapper
from lsvib.dynamics.attractors import Doubt
from lsvib.errors import InputError
from lsvib.models.drive import Drive

_EVENTS = 100_000  # of a motion, after which its start is unresolved
_FEWER = 300  # the same where the table of sections has gaps, in which many motions may go on and on: 0.1 ms


class PlanarMapper(Mapper):
    """Maps the starts of a drive with two states to what becomes of them.

    * ``label``: the attractor (``lsvib.dynamics.attractors.Attractor``), by the table of
      :mod:`lsvib.basins.labels`; unresolved (−1) is a start that lies on a boundary to rounding or, where the
      table has gaps, one whose motion comes to none of its labels in time. ``doubt`` says which of the two it is.
    * ``time`` [s] until it is reached: for steady sliding the entry into the largest ellipse around the equilibrium in
      which no guard can fire (closed form); for a cycle the first event after which the motion is on it to 1e-9 of its
      size; infinite if the motion is unbounded or unresolved.
    * ``seizures`` until then, and ``first_event``: kind of the first event of the motion, −1 if there is none.

    No time of waiting enters. Every cell is computed on its own: no number depends on the grid around it, on tiles or
    on threads. ``attractors`` are the cycles that motions reach (``SteadyState``). Without ``rounding``, which is
    ready in two thirds of the time, a start on a boundary has the label of one side.
    """

    block = 16384  # a thread works on one block at a time

    def __init__(self, drive: Drive, model: str, physics: tuple[str, ...], resume: str, rounding: bool = True) -> None:
        super().__init__(drive, model, physics, resume)
        self.sections = Sections(self.automaton, rounding)
        self.attractors = self.sections.courses.attractors
        self._events = _EVENTS if self.sections.complete else _FEWER
        # Why a start is unresolved, if it is.
        self.doubt = Doubt.ROUNDING if self.sections.complete else Doubt.EVENT_BUDGET
        self._sprags = np.array(self.automaton.sprag_kinds, dtype=np.int64)

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays; times of unresolved cells are infinite, and all cells have the same doubt, if any."""
        tables, known, across = self.automaton.tables, self.sections.known, int(grid.x.coordinate == "w")
        labels, times = found["label"], found["time"]
        first_events = found["first_event"][:, : x.size if "first_event" in quantities else 0]
        labels.map_labels(tables, known, x, y, across, self._events, labels, first_events)
        if not {"time", "seizures"}.isdisjoint(quantities):
            arrival.map_approaches(tables, known, self._sprags, x, y, across, _EVENTS, times, found["seizures"])
            times[labels == labels.UNRESOLVED] = np.inf
        if "doubt" in quantities:
            found["doubt"][:] = np.where(labels == labels.UNRESOLVED, list(Doubt).index(self.doubt), NO_DOUBT)

    def check(self, grid: Grid) -> None:
        """Raise ``InputError`` unless the axes are u and w and nothing is fixed."""
        if {grid.x.coordinate, grid.y.coordinate} != {"u", "w"} or grid.fixed:
            raise InputError(
                "the rigid drive has the coordinates u and w: the grid needs them as its axes, none fixed."
            )
