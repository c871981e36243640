"""The automaton of a scene for general solvers: each mode a field with linear guards, and what happens at an event.

A general solver integrates x′ = A x + b until a guard falls through zero; the driver here puts the state on the
guard's surface, makes the transition and starts the solver again. It computes with lists of plain Python floats: for
two to four of them that is several times faster than numpy, and the fastest solvers spend a few microseconds on an arc.
Where friction depends on speed the field has one term more (:class:`Friction`). What the engine alone needs, to divide
steady sliding in two halves that pass into each other, is no event of a rival.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmarks.judge import Record
from benchmarks.rivals.race_scenes import RaceScene
from benchmarks.sweeps.paths import fields
from lsvib.drives.names import Event
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import event_loop
from lsvib.systems.kernels.law import CONSTANT
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND, TaylorFlow, Test

ROUNDING = 1e-12  # A sum that is smaller, relative to its terms, is zero.
RETRIES = 8  # repetitions, each with steps a quarter as long, where a solver steps over a root next to its start
MOST_STEPS = 20_000  # steps of a solver from one event to the next
_POSITIVE, _ZERO, _LEADS = map(int, (Test.POSITIVE, Test.ZERO, Test.LEADS))  # compare faster than an IntEnum


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
        if self.calls % 64 == 0:
            self.look()

    def look(self) -> None:
        """Raise ``GaveUp`` if the processor time is over."""
        if time.process_time() > self.end:
            raise GaveUp(f"over {self.limit:g} s")


class Friction(NamedTuple):
    """What friction that depends on the sliding speed σ [m/s] adds to the field of a mode: η q d, see :func:`eta`.

    Rows (n + 1) of σ and of the contact force without friction, q, which are affine; the push d (n); B and the law.
    """

    speed: np.ndarray
    contact: np.ndarray
    push: np.ndarray
    law: tuple[float, ...]


def exponential(x: float) -> float:
    """Return e^x, not beyond all numbers where a step goes far beyond standstill, so that it is seen and refused."""
    return math.exp(min(x, 50.0))


def eta(sigma, law: tuple[float, ...], exp: Callable = exponential):
    """Return η = μ / (1 + B μ) at a speed, a number or an expression of the package that ``exp`` is from.

    ``law``: B and the numbers of μ = constant + linear σ + rise exp(−(fade σ)^exponent), which stays above zero here.
    """
    feedback, constant, linear, rise, fade, exponent = law
    mu = constant + linear * sigma + rise * exp(-((fade * sigma) ** exponent))
    return mu / (1.0 + feedback * mu)


@dataclass(frozen=True)
class HybridMode:
    """Field A (n, n), b (n); guards as rows (g, n + 1), positive inside the mode; their indices in the tables."""

    matrix: np.ndarray
    constant: np.ndarray
    guards: np.ndarray
    indices: list[int]
    friction: Friction | None = None

    def rate(self) -> Callable[[np.ndarray], np.ndarray]:
        """Return the field, a function from x to x′."""
        matrix, constant = self.matrix, self.constant
        if self.friction is None:
            return lambda x: matrix @ x + constant
        speed, contact, push, law = self.friction
        rows, offsets = np.vstack([matrix, speed[:-1], contact[:-1]]), np.array([*constant, speed[-1], contact[-1]])

        def rubbed(x: np.ndarray) -> np.ndarray:
            """Return x′ by one product of matrices."""
            *_, sigma, force = values = rows @ x + offsets
            return values[:-2] + eta(sigma, law) * force * push

        return rubbed


# Follow a mode to its first guard or to an end [s]:
# (mode, time, state, end) -> (time, state, index of the guard within the mode or None)
Integrate = Callable[[int, float, Sequence[float], float], tuple[float, Sequence[float], int | None]]


class _Guard(NamedTuple):
    """Rows (n + 1) of plain numbers, of affine functions of the state: guard, its rate, and the size of that rate.

    The last is an affine function of the magnitudes of the state, and all its entries are positive.
    """

    row: list[float]
    slope: list[float]
    slope_size: list[float]


def _plain_guards(mode: HybridMode) -> list[_Guard]:
    """Return the guards g·x + h of a mode with their rates g·(A x + b).

    Friction that depends on speed is not in the rates: they decide at a release only, where the coupling drives on.
    """
    weights = mode.guards[:, :-1]
    field = np.column_stack([mode.matrix, mode.constant])
    rows = mode.guards.tolist(), (weights @ field).tolist(), (np.abs(weights) @ np.abs(field)).tolist()
    return [_Guard(*of_guard) for of_guard in zip(*rows, strict=True)]


def _affine(row: Sequence[float], state: Sequence[float]) -> tuple[float, float]:
    """Return the value of the affine function ``row`` (n + 1) at ``state`` (n), and the size of its terms."""
    if len(state) == 2:  # what most drives have, without a loop
        first, second, constant = row[0] * state[0], row[1] * state[1], row[2]
        return first + second + constant, abs(first) + abs(second) + abs(constant)
    value = size = 0.0
    for weight, x in zip(row, state, strict=False):  # the constant, which comes last, is added below
        term = weight * x
        value += term
        size += abs(term)
    return value + row[-1], size + abs(row[-1])


def _holds(test: int, value: float, rounding: float) -> bool:
    """Whether a value, known up to ``rounding``, has the sign that a test asks for."""
    if test == _POSITIVE:
        return value > rounding
    return abs(value) <= rounding if test == _ZERO else value >= -rounding


def _friction(flow, mode: int) -> Friction | None:
    """What friction that depends on speed adds in a mode of flow tables; none where it does not, or at rest."""
    if not isinstance(flow, TaylorFlow) or flow.piece_start[mode] == flow.piece_start[mode + 1]:
        return None
    law = flow.pieces[flow.piece_start[mode], CONSTANT:].tolist()
    return Friction(flow.speed[mode], flow.contact[mode], flow.push[mode], (float(flow.feedback[mode]), *law))


class Hybrid:
    """A scene's automaton, mode by mode."""

    def __init__(self, scene: RaceScene) -> None:
        self.scene = scene
        self.automaton = scene.automaton()
        self.tables = t = self.automaton.tables
        self.fields = fields(self.automaton)
        self.modes = []
        leads = t.branch_kind[t.branch_start[t.guard_transition]]
        for mode, field in enumerate(self.fields):
            own = [k for k in range(t.guard_start[mode], t.guard_start[mode + 1]) if leads[k] != Event.PASSAGE]
            rows, matrix = t.guard_sign[own, None] * t.surfaces[t.guard_surface[own]], field[:, :-1].copy()
            self.modes.append(HybridMode(matrix, field[:, -1].copy(), rows, own, _friction(t.flow, mode)))
        self.names = {int(kind): kind.name.lower() for kind in scene.definition.events}
        self._guards = [_plain_guards(mode) for mode in self.modes]
        self._landings = [
            (t.surfaces[surface].tolist(), int(snap), int(transition))
            for surface, snap, transition in zip(
                t.guard_surface, t.snap[t.guard_surface], t.guard_transition, strict=True
            )
        ]
        self._resets = [None if k < 0 else t.resets[k].tolist() for k in t.transition_reset]
        self._branches = [
            [self._own_branch(k) for k in range(t.branch_start[i], t.branch_start[i + 1])]
            for i in range(len(t.branch_start) - 1)
        ]

    def _own_branch(self, branch: int) -> tuple[list, int, int]:
        """Conditions (row, test) of a branch, its mode and its kind of event, as plain numbers."""
        t = self.tables
        own = slice(t.condition_start[branch], t.condition_start[branch + 1])
        conditions = list(zip(t.condition_row[own].tolist(), t.condition_test[own].tolist(), strict=True))
        return conditions, int(t.branch_mode[branch]), int(t.branch_kind[branch])

    def due(self, mode: int, state: Sequence[float]) -> int | None:
        """Return the first guard of a mode that is negative, or zero and falling, at ``state`` (n)."""
        for index, guard in enumerate(self._guards[mode]):
            value, size = _affine(guard.row, state)
            if value > ROUNDING * size:
                continue
            if value < -ROUNDING * size:
                return index
            slope = _affine(guard.slope, state)[0]
            if slope < 0.0 and slope < -ROUNDING * _affine(guard.slope_size, state)[1]:
                return index
        return None

    def fire(self, mode: int, guard: int, state: Sequence[float], arrived: bool) -> tuple[int, list[float], int]:
        """Make the transition of a guard at ``state`` (n): returns the new mode, the new state and the kind of event.

        A state that has ``arrived`` at the guard is put on its surface first; one that is entered beyond it, where a
        jump is due, is not.
        """
        surface, snap, transition = self._landings[self.modes[mode].indices[guard]]
        state = list(state)
        if arrived:
            state[snap] -= _affine(surface, state)[0] / surface[snap]
        reset = self._resets[transition]
        if reset is not None:
            state = [_affine(row, state)[0] for row in reset]
        new_mode, kind = self._branch(transition, state)
        return new_mode, state, kind

    def _branch(self, transition: int, state: Sequence[float]) -> tuple[int, int]:
        """Mode and kind of event of the first branch of a transition whose conditions all hold."""
        for conditions, mode, kind in self._branches[transition]:
            decided = False
            for row, test in conditions:
                if decided:  # by a condition before, up to the one at which the chain of those ends
                    decided = test == _LEADS
                    continue
                value, size = _affine(row, state)
                if not _holds(test, value, ROUNDING * size):
                    break
                decided = test == _LEADS and value > ROUNDING * size
            else:
                return mode, kind
        raise GaveUp("no branch fits")

    def run(self, integrate: Integrate, clock: Clock, max_events: int) -> "Recorder":
        """Follow the scene with a solver, event by event; what is returned works out the rest when it is called."""
        clock.start()
        now, end, state = 0.0, self.scene.duration, [float(x) for x in self.scene.state]
        mode, _ = self._branch(0, state)
        record = Recorder(self, mode, state)
        try:
            while True:
                guard = self.due(mode, state)
                arrived = guard is None
                if arrived and now < end:
                    now, state, guard = integrate(mode, now, state, end)
                if guard is None:
                    return record.close(now, state)
                if len(record.times) == max_events:
                    raise GaveUp(f"over {max_events} events")
                mode, state, kind = self.fire(mode, guard, state, arrived)
                record.add(now, kind, mode, state)
        except GaveUp as reason:
            return record.close(now, state, str(reason))


class Recorder:
    """The arcs of a run; a call works out the rest after the time has been taken."""

    def __init__(self, hybrid: Hybrid, mode: int, state: Sequence[float]) -> None:
        self.hybrid = hybrid
        self.times, self.kinds, self.modes, self.starts = [], [], [mode], [state]
        self.end, self.end_state, self.failure = 0.0, state, ""

    def add(self, now: float, kind: int, mode: int, after: Sequence[float]) -> None:
        """Note an event."""
        self.times.append(now)
        self.kinds.append(kind)
        self.modes.append(mode)
        self.starts.append(after)

    def close(self, now: float, state: Sequence[float], failure: str = "") -> "Recorder":
        """Note the end."""
        self.end, self.end_state, self.failure = now, state, failure
        return self

    def __call__(self) -> Record:
        """Return the run with its extremes: those of the closed form from the states that the method found."""
        extremes = (np.nan, np.nan)
        if not self.failure:
            extremes = arc_extremes(
                self.hybrid.automaton,
                self.modes,
                self.starts,
                [0.0, *self.times],
                self.end,
                self.hybrid.scene.steady_from,
            )
        return Record(
            end=np.asarray(self.end_state, dtype=float),
            times=np.array(self.times),
            kinds=[self.hybrid.names[kind] for kind in self.kinds],
            extremes=extremes,
            failure=self.failure,
        )


def arc_extremes(automaton: Automaton, modes, starts, times, end: float, steady_from: float) -> tuple[float, float]:
    """Return the smallest and largest u [rad] from ``steady_from`` [s] on, over arcs with these modes and starts."""
    flow, late_arcs = automaton.tables.flow, []
    for mode, start, begin, stop in zip(modes, starts, times, [*times[1:], end], strict=True):
        if stop >= steady_from:
            late, state = max(steady_from - begin, 0.0), np.empty(len(start))
            event_loop.advance(flow, int(mode), np.asarray(start, dtype=float), late, state)
            late_arcs.append((int(mode), state, stop - begin - late))
    if not late_arcs:
        return np.inf, -np.inf
    angle = np.zeros((len(automaton.codes), len(starts[0]) + 1))
    angle[:, 0] = 1.0
    modes, starts, durations = map(np.array, zip(*late_arcs, strict=True))
    return event_loop.extremes_of_arcs(flow, modes, starts, durations, angle)


def counted(kinds: np.ndarray) -> np.ndarray:
    """Mark the events that a method is compared by: all but touched guards, accumulations and passages."""
    return ~np.isin(kinds, (GRAZE_KIND, ACCUMULATION_KIND, Event.PASSAGE))
