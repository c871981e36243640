"""The automaton of a scene for general solvers: each mode a linear field with guards, and what happens at an event.

A general solver integrates x′ = A x + b until a guard falls through zero; the driver here puts the state on the
guard's surface, makes the transition and starts the solver again. Everything is plain Python on a few numbers, small
against a solver's own overhead.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lsvib.accuracy.result import Run
from lsvib.accuracy.scenes import Scene
from lsvib.core import flows, planar
from lsvib.core.status import ACCUMULATION_KIND, GRAZE_KIND, Test
from lsvib.models.automaton import Automaton

_ROUNDING = 1e-12  # of the terms of a sum: less is zero


class GaveUp(Exception):
    """A run is over its time, or its solver cannot go on; the message says which."""


class Clock:
    """A limit on the time of a run; solvers call :meth:`check` in every evaluation of the field."""

    def __init__(self, limit: float) -> None:
        self.limit, self.end, self.calls = limit, 0.0, 0

    def start(self) -> None:
        """Start the time."""
        self.end = time.process_time() + self.limit

    def check(self) -> None:
        """Raise ``GaveUp`` if the processor time is over; looks at the clock in every 64th call."""
        self.calls += 1
        if self.calls % 64 == 0 and (failure := self.over()):
            raise GaveUp(failure)

    def over(self) -> str:
        """Say that the processor time is over, or nothing."""
        return f"over {self.limit:g} s" if time.process_time() > self.end else ""


@dataclass(frozen=True)
class HybridMode:
    """Field A (n, n), b (n); guards as rows (g, n + 1), positive inside the mode; their indices in the tables."""

    matrix: np.ndarray
    constant: np.ndarray
    guards: np.ndarray
    first_guard: int


# (mode, time, state, end) -> (time, state, index of the guard within the mode or None)
Integrate = Callable[[int, float, np.ndarray, float], tuple[float, np.ndarray, int | None]]


class Hybrid:
    """A scene's automaton, mode by mode."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.automaton = scene.automaton()
        self.tables = t = self.automaton.tables
        self.fields = fields(self.automaton)
        self.modes = []
        for mode, field in enumerate(self.fields):
            own = slice(t.guard_start[mode], t.guard_start[mode + 1])
            rows = t.guard_sign[own, None] * t.surfaces[t.guard_surface[own]]
            self.modes.append(HybridMode(field[:, :-1].copy(), field[:, -1].copy(), rows, int(own.start)))
        self.names = {int(kind): kind.name.lower() for kind in scene.kind.events}

    def due(self, mode: int, state: np.ndarray) -> int | None:
        """Return the first guard of a mode that is negative, or zero and falling, at ``state``."""
        found = self.modes[mode]
        rate = found.matrix @ state + found.constant
        rate_size = np.abs(found.matrix) @ np.abs(state) + np.abs(found.constant)
        for index, row in enumerate(found.guards):
            value = row[:-1] @ state + row[-1]
            size = _ROUNDING * (np.abs(row[:-1]) @ np.abs(state) + abs(row[-1]))
            falls = row[:-1] @ rate < -_ROUNDING * (np.abs(row[:-1]) @ rate_size)
            if value < -size or (value <= size and falls):
                return index
        return None

    def fire(self, mode: int, guard: int, state: np.ndarray, arrived: bool) -> tuple[int, np.ndarray, int]:
        """Make the transition of a guard at ``state``: returns the new mode, the new state and the kind of event.

        A state that has ``arrived`` at the guard is put on its surface first; one that is entered beyond it, where a
        jump is due, is not.
        """
        t = self.tables
        index = self.modes[mode].first_guard + guard
        surface, snap = t.surfaces[t.guard_surface[index]], t.snap[t.guard_surface[index]]
        state = state.copy()
        if arrived:
            state[snap] -= (surface[:-1] @ state + surface[-1]) / surface[snap]
        transition = t.guard_transition[index]
        reset = t.transition_reset[transition]
        if reset >= 0:
            state = t.resets[reset][:, :-1] @ state + t.resets[reset][:, -1]
        branch = self._branch(transition, state)
        return int(t.branch_mode[branch]), state, int(t.branch_kind[branch])

    def enter(self, start=None) -> tuple[int, np.ndarray]:
        """Mode and state at the start of the scene, or at another ``start`` (n)."""
        state = np.array(self.scene.state if start is None else start, dtype=float)
        return int(self.tables.branch_mode[self._branch(0, state)]), state

    def _branch(self, transition: int, state: np.ndarray) -> int:
        t = self.tables
        for branch in range(t.branch_start[transition], t.branch_start[transition + 1]):
            own = slice(t.condition_start[branch], t.condition_start[branch + 1])
            for row, test in zip(t.condition_row[own], t.condition_test[own], strict=True):
                value = row[:-1] @ state + row[-1]
                size = _ROUNDING * (np.abs(row[:-1]) @ np.abs(state) + abs(row[-1]))
                if not (
                    value > size
                    if test == Test.POSITIVE
                    else abs(value) <= size
                    if test == Test.ZERO
                    else value >= -size
                ):
                    break
            else:
                return branch
        raise GaveUp("no branch fits")

    def run(self, integrate: Integrate, clock: Clock, max_events: int) -> "Record":
        """Follow the scene with a solver, event by event."""
        clock.start()
        mode, state = self.enter()
        now, end = 0.0, self.scene.duration
        record = Record(self, mode, state)
        try:
            while True:
                guard = self.due(mode, state)
                arrived = guard is None
                if arrived:
                    now, state, guard = integrate(mode, now, state, end)
                if guard is None:
                    return record.close(now, state)
                if len(record.times) == max_events:
                    raise GaveUp(f"over {max_events} events")
                mode, state, kind = self.fire(mode, guard, state, arrived)
                record.add(now, kind, mode, state)
        except GaveUp as reason:
            return record.close(now, state, str(reason))


class Record:
    """The arcs of a run; :meth:`run` works out the rest after the time has been taken."""

    def __init__(self, hybrid: Hybrid, mode: int, state: np.ndarray) -> None:
        self.hybrid = hybrid
        self.times, self.kinds, self.modes, self.starts = [], [], [mode], [state]
        self.end, self.end_state, self.failure = 0.0, state, ""

    def add(self, now: float, kind: int, mode: int, after: np.ndarray) -> None:
        """Note an event."""
        self.times.append(now)
        self.kinds.append(kind)
        self.modes.append(mode)
        self.starts.append(after)

    def close(self, now: float, state: np.ndarray, failure: str = "") -> "Record":
        """Note the end."""
        self.end, self.end_state, self.failure = now, state, failure
        return self

    def run(self) -> Run:
        """Return the run with its extremes: those of the closed form from the states that the method found."""
        extremes = (np.nan, np.nan)
        if not self.failure:
            extremes = arc_extremes(
                self.hybrid.automaton, self.modes, self.starts, [0.0, *self.times], self.end, self.hybrid.scene.window
            )
        return Run(
            end_state=np.asarray(self.end_state, dtype=float),
            times=np.array(self.times),
            kinds=[self.hybrid.names[kind] for kind in self.kinds],
            extremes=extremes,
            failure=self.failure,
        )


def fields(automaton: Automaton) -> np.ndarray:
    """Return A and b of every mode, (m, n, n + 1)."""
    flow = automaton.tables.flow
    if not isinstance(flow, np.ndarray):
        return flow.field
    table = np.zeros((len(flow), 2, 3))
    table[:, 0, 1] = 1.0
    table[:, 1] = np.stack([-flow[:, planar.A0], -flow[:, planar.A1], flow[:, planar.B]], axis=1)
    return table


def arc_extremes(automaton: Automaton, modes, starts, times, end: float, window: float) -> tuple[float, float]:
    """Smallest and largest u [rad] from ``window`` [s] on over arcs with these modes, states and times of start."""
    low, high = np.inf, -np.inf
    flow, state = automaton.tables.flow, np.empty(len(starts[0]))
    angle = np.zeros(state.size + 1)
    angle[0] = 1.0
    for mode, start, begin, stop in zip(modes, starts, times, [*times[1:], end], strict=True):
        if stop < window:
            continue
        late = max(window - begin, 0.0)
        flows.advance(flow, int(mode), np.asarray(start, dtype=float), late, state)
        a, b = flows.extremes(flow, int(mode), state, angle, stop - begin - late)
        low, high = min(low, a), max(high, b)
    return low, high


def counted(kinds: np.ndarray) -> np.ndarray:
    """Mark the events that a method is compared by: all but touched guards and accumulations."""
    return ~np.isin(kinds, (GRAZE_KIND, ACCUMULATION_KIND))
