"""The region of attraction of models with more than two states: planar slices, one motion followed for every cell.

A cell's motion is followed on the exact engine until one of the following holds:

* no guard can ever fire again, by the engine's own proof (``Status.SETTLED``): the attractor of that mode;
* it joins a known cycle: of its last four points on the cycle's section – events of the rarest kind into one mode –
  each step is shorter than the one before, by a ratio q, with as many events between them as the cycle has, and the
  point that they tend to, x + q / (1 − q) Δx, is the cycle's within ``_SAME`` of the cycle's size. (A contact creeps at
  the rate k_c / c_c, so that a motion may come close to its cycle only after thousands of returns.)
* it diverges: unbounded;
* ``_ROUNDS`` times 64 events: then the motion is followed and extrapolated from there (``steady_state``), with as much
  work as ``_EVENTS`` events; what that leaves open is unresolved.

Known cycles are those that a few fixed starts reach, with less work; so the result does not depend on the grid, tiles
or threads.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from lsvib.basins.grid import Grid, coordinates
from lsvib.basins.mapper import NO_DOUBT, Mapper
from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, out_of_range, steady_state
from lsvib.dynamics.settling import settled
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import DivergenceError, EngineError, InputError
from lsvib.models.drive import Drive

_CHUNK = 64  # events that are followed between two looks at a motion
_ROUNDS = 16  # of _CHUNK events each, which cost less than the return map that comes after them
_EVENTS = 700_000  # units of work beyond the rounds, each some microseconds
_PART = 10  # before a map begins, each start that looks for a cycle has a tenth of that work, and so has steady sliding
_SAME = 1e-3  # distance in sizes of the cycle that extrapolation from four points may leave; a label needs no more
_NEAR = 0.1  # distance in sizes of the cycle; from farther the motion may meet other events on its way
_DOUBTS = list(Doubt)
_KINDS = 128  # kinds of events are numbers of eight bits
_STILL = 1e-12  # size of a step on the section that is rounding, in sizes of the cycle


class Destiny(NamedTuple):
    """What becomes of a motion: label, time [s], number of sprags, kind of the first event (−1: none), and any doubt.

    The time is infinite where the label is unresolved; ``doubt`` says why it is.
    """

    label: Attractor
    time: float
    seizures: int
    first_event: int
    doubt: Doubt | None = None


class StateMapper(Mapper):
    """Maps planar slices of the starts of a drive to what becomes of them.

    ``label`` as in the module docstring; ``time`` [s] and ``seizures`` (events or modes that sprag) until the label is
    decided: the last event, or the fourth of the points that show the cycle; ``first_event``: kind of the first event.
    """

    block = 1  # a row at a time

    def __init__(self, drive: Drive, model: str, physics: tuple[str, ...], resume: str) -> None:
        super().__init__(drive, model, physics, resume)
        self.keys = tuple(key for key in coordinates() if coordinates()[key] in self.automaton.states)
        self.attractors: list[SteadyState] = []
        self._sprag_mode = np.isin(self.automaton.codes, self.automaton.sprag_codes)
        self._sprag_kind = np.isin(np.arange(_KINDS), self.automaton.sprag_kinds)
        speed = abs(drive.input_speed)
        reach = speed * (drive.screw_inertia / drive.coupling_stiffness) ** 0.5
        for u, w in ((reach, 0.0), (-reach, 0.0), (0.0, -1.5 * drive.input_speed), (3 * reach, 3 * speed)):
            start = self.definition.initial_state(drive, {"u": u, "w": w})
            found = self._end(start, work=_EVENTS // _PART)
            known = any(other.same_period(found) for other in self.attractors)
            if found.orbit is not None and found.orbit.time.size and not known:
                self.attractors.append(found)

    def check(self, grid: Grid) -> None:
        """Raise ``InputError`` unless the grid has what a start needs, and nothing that the state has not."""
        given = (grid.x.coordinate, grid.y.coordinate, *grid.fixed)
        for key in given:
            if key not in self.keys:
                raise InputError(f"the model {self.model} has the coordinates {', '.join(self.keys)}, not {key}.")
        for key in self.definition.required:
            if key not in given:
                raise InputError(f"the grid of the model {self.model} needs the coordinate {key}, as an axis or fixed.")

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill all arrays, one start after the other.

        Coordinates that are neither axes nor fixed have the values that the model gives them, such as a seated contact.
        """
        for i in range(y.size):
            for j in range(x.size):
                values = {**grid.fixed, grid.x.coordinate: x[j], grid.y.coordinate: y[i]}
                *destiny, doubt = self.destiny(self.definition.initial_state(self.drive, values))
                code = NO_DOUBT if doubt is None else _DOUBTS.index(doubt)
                for array, value in zip(found.values(), (*destiny, code), strict=True):
                    array[i, j] = value

    def destiny(self, state: np.ndarray) -> Destiny:
        """Return what becomes of the motion from a state (n)."""
        mode, time, sprags, first, budget = None, 0.0, 0, None, Budget(_EVENTS)
        if not state.any():
            end = self._end(state, work=_EVENTS // _PART)
            if end.label == Attractor.STEADY_SLIDING:
                return Destiny(Attractor.STEADY_SLIDING, 0.0, 0, -1)
        for _ in range(_ROUNDS):
            try:
                motion = follow(self.automaton, state, np.inf, mode=mode, max_events=_CHUNK, budget=budget)
            except EngineError as error:
                if isinstance(error, DivergenceError):
                    end = out_of_range(self.automaton, state)
                else:
                    end = SteadyState.unresolved(state, error)
                return Destiny(end.label, np.inf, sprags, -1 if first is None else first, end.doubt)
            if first is None:
                first = int(motion.kind[0]) if motion.time.size else -1
            if motion.status == Status.SETTLED:
                sprags += self._sprags(motion, motion.time.size)
                return Destiny(settled(self.automaton, motion).label, time + motion.end_time, sprags, first)
            for cycle in self.attractors:
                last = _joins(motion, cycle)
                if last is not None:
                    sprags += self._sprags(motion, last + 1)
                    return Destiny(cycle.label, time + float(motion.time[last]), sprags, first)
            time, sprags = time + motion.end_time, sprags + self._sprags(motion, motion.time.size)
            state, mode = motion.end_state, motion.end_mode
            if motion.status == Status.WORK_SPENT:
                break
        end = self._end(state, mode)
        return Destiny(
            end.label, time if end.doubt is None else np.inf, sprags, -1 if first is None else first, end.doubt
        )

    def _end(self, state: np.ndarray, mode: int | None = None, work: int = _EVENTS) -> SteadyState:
        """Return the attractor of a motion; unresolved if the engine does not decide or the work does not suffice."""
        try:
            return steady_state(self.automaton, state, mode=mode, max_events=work)
        except EngineError as error:
            return SteadyState.unresolved(state, error)

    def _sprags(self, motion: Motion, count: int) -> int:
        """Count the first events of a motion that sprag or enter a mode that does."""
        return int(np.sum(self._sprag_kind[motion.kind[:count]] | self._sprag_mode[motion.mode[:count]]))


def _joins(motion: Motion, cycle: SteadyState) -> int | None:
    """Return the index of the event at which four points in a row show that a motion tends to a cycle, or None."""
    orbit = cycle.orbit
    size = np.maximum(np.abs(orbit.after).max(axis=0), np.finfo(float).tiny)
    kind, mode, per_return = orbit.kind[-1], orbit.mode[-1], orbit.time.size
    at = np.flatnonzero((motion.kind == kind) & (motion.mode == mode))
    at = at[:: np.sum((orbit.kind == kind) & (orbit.mode == mode))]
    if at.size < 4:
        return None
    points, returned = motion.after[at], (np.diff(at) == per_return).tolist()
    steps = np.abs(np.diff(points, axis=0) / size).max(axis=1).tolist()
    for k in range(3, at.size):
        first, second, third = steps[k - 3 : k]
        if not all(returned[k - 3 : k]) or second > max(first, _STILL) or (third > _STILL and third >= second):
            continue
        ratio = third / second if third > _STILL else 0.0
        way = ratio / (1 - ratio) * (points[k] - points[k - 1])
        limit = points[k] + way
        if (np.abs(way) <= _NEAR * size).all() and (np.abs(limit - orbit.after[-1]) <= _SAME * size).all():
            return int(at[k])
    return None
