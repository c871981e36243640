"""The region of attraction with more than two states: planar slices, one motion followed for every cell.

Every start is asked of the one rule (:mod:`lsvib.systems.attractor`), with the cycles that a few fixed starts reach as
known ones, which a motion that joins them ends on at once. So the result does not depend on the grid, tiles or workers.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from lsvib.errors import EngineError
from lsvib.systems.attractor import Attractor, Doubt, KnownCycles, SteadyState, end_of_motion
from lsvib.systems.automaton import Automaton
from lsvib.systems.grid import Grid
from lsvib.systems.mapper import NO_DOUBT, Mapper, Starts


class StateMapper(Mapper):
    """Maps planar slices of the starts of an automaton to what becomes of them.

    ``label`` as in the module docstring; ``time`` [s] and ``seizures`` (events or modes that sprag) until the label is
    decided: the last event, or the fourth of the points that show the cycle; ``first_event``: kind of the first event.
    """

    block = 1  # a row at a time
    work = 700_000  # events of a motion, each of some microseconds

    def __init__(self, automaton: Automaton, starts: Starts) -> None:
        super().__init__(automaton, starts)
        self.attractors: list[SteadyState] = []
        for start in starts.first:
            with suppress(EngineError):
                found, _ = end_of_motion(automaton, start, max_events=70_000)
                known = any(other.same_period(found) for other in self.attractors)
                if found.orbit is not None and found.orbit.time.size and not known:
                    self.attractors.append(found)
        # Cycles that are not known are looked for after 1024 events: their map costs more than these.
        self._known = KnownCycles.of(self.attractors, self.automaton, 1024)

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill all arrays, one start after the other.

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
