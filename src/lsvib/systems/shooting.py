r"""The equations of a cycle over a parameter, by shooting from the middle of one of its arcs.

The unknowns are the state x (n) there, the period T and the parameter p, with the flow φ_T of the system at p:

    φ_T(x, p) − x = 0,        f₀ᵀ (x − x₀) = 0,

x₀ a place on the arc and f₀ the direction of the motion there. No surface and no event enters, so that these equations
are the same on both sides of a change of events. They are smooth where the motion has the same events in the same order
(its *itinerary*). All unknowns are counted in sizes of the motion; p is counted by q, p = p₀ sinh q with its size p₀ at
the start (docs/cycles.md).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lsvib.errors import EngineError, InputError
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import single_mode
from lsvib.systems.kernels.layout import GRAZE_KIND, Status
from lsvib.systems.kernels.saltation import crossed_guard
from lsvib.systems.machine import of_one_type
from lsvib.systems.motion import Budget, Motion, enter, follow
from lsvib.systems.section import AT_REST, CLOSE, derivative

_MOST_WORK = 100_000  # of a period, in events: a second under a friction law
_ROUNDED = 1e-12  # change of a state over a period that is rounding, relative to the growth of neighbours
_CLOSED = 1e-14  # the same, where it is as small as it may be
_STEEP = 1e3  # rate at the end of an arc, relative to its middle, beyond which it grows without bound
_DIFFERENCE = 1e-9  # step in q of the derivative by the parameter

Build = Callable[[float], Automaton]  # at a value of the parameter
Itinerary = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Units:
    """Sizes of the state (n), of the period [s] and of the parameter p₀, whose values lie in ``span`` [SI unit]."""

    build: Build
    size: np.ndarray
    period: float
    scale: float
    span: tuple[float, float]

    def value(self, z: np.ndarray) -> float:
        """The value of the parameter at z = (x, T, q), not beyond the span."""
        value = min(max(self.scale * math.sinh(z[-1]), self.span[0]), self.span[1])
        return next((end for end in self.span if abs(value - end) <= AT_REST * abs(end)), value)

    def counted(self, value: float) -> float:
        """The q of a value of the parameter."""
        return math.asinh(value / self.scale)

    def holds(self, q: float) -> bool:
        """Whether the span holds q, to rounding."""
        return self.counted(self.span[0]) - AT_REST <= q <= self.counted(self.span[1]) + AT_REST


@dataclass(frozen=True)
class Shot:
    """The motion over one period T from a place z = (x, T, q), of the system there."""

    z: np.ndarray
    motion: Motion

    @cached_property
    def itinerary(self) -> Itinerary:
        """Its events, (kind, code of the mode that is entered), without touches and without passages.

        A passage divides the tables, not the motion.
        """
        automaton, kinds = self.motion.automaton, self.motion.kind
        own = ~(automaton.marked(kinds, "passage") | (kinds == GRAZE_KIND))
        codes = automaton.codes[self.motion.mode[own]]
        return tuple(zip(kinds[own].tolist(), codes.tolist(), strict=True))

    @property
    def rests(self) -> bool:
        """Whether it rests on the way."""
        automaton = self.motion.automaton
        return bool(automaton.marked(automaton.codes[self.motion.mode], "rest").any())


@dataclass(frozen=True)
class Solved(Shot):
    """A cycle at a place z of a branch, with the unit ``tangent`` there; ``slope`` (n) is the derivative by q."""

    tangent: np.ndarray
    slope: np.ndarray


class Shooting:
    """The equations from the middle of a cycle's longest arc, of those in which nothing sticks if there are any."""

    def __init__(self, units: Units, cycle: Motion) -> None:
        modes, _, _, durations = cycle.arcs()
        codes = cycle.automaton.codes[modes]
        moves = ~cycle.automaton.marked(codes, "rest", "held")
        arc = int(np.argmax(np.where(moves, durations, 0.0) if moves.any() else durations))
        begins = float(durations[:arc].sum()) + 0.5 * float(durations[arc])
        (state,), (mode,) = cycle.at([begins])
        self.units, self.code, self.origin = units, int(codes[arc]), state / units.size
        ahead = self._rate(cycle.automaton, mode, state)
        self.normal = ahead / np.linalg.norm(ahead)

    def _rate(self, automaton: Automaton, mode: int, state: np.ndarray) -> np.ndarray:
        """x′ (n) in sizes of the motion by its period."""
        return np.asarray(rate_of(automaton, mode, state) / self.units.size * self.units.period)

    def at(self, z: np.ndarray, settled: bool = False) -> Shot | None:
        """The motion over T from a place; None where the engine has no answer, no system is, or it has ``settled``."""
        if not (z[-2] > 0 and self.units.holds(z[-1])):
            return None
        try:
            automaton = self.units.build(self.units.value(z))
            state = z[:-2] * self.units.size
            motion = follow(
                automaton, state, z[-2] * self.units.period, mode=_mode(automaton, self.code, state),
                budget=Budget(_MOST_WORK),
            )  # fmt: skip
        except (EngineError, InputError):
            return None
        lasts = motion.time.size and motion.status == Status.TIME_REACHED
        return Shot(z, motion) if lasts or settled else None

    def across(self, shot: Shot) -> float:
        """The cosine between a motion at its end and the normal of the plane."""
        ahead = self._rate(shot.motion.automaton, shot.motion.end_mode, shot.motion.end_state)
        return float(self.normal @ ahead / np.linalg.norm(ahead))

    def centred(self, shot: Shot) -> bool:
        """Whether a motion begins well across the plane, and well inside of its arc, not in a fifth next to an end."""
        first, last = shot.motion.time[0], shot.motion.end_time - shot.motion.time[-1]
        return bool(min(first, last) >= 0.2 * (first + last)) and self.across(shot) >= 0.8

    def gap(self, shot: Shot) -> np.ndarray:
        """What the equations leave, (n + 1)."""
        x = shot.z[:-2]
        return np.append(shot.motion.end_state / self.units.size - x, self.normal @ (x - self.origin))

    def slopes(self, shot: Shot, slope: np.ndarray) -> np.ndarray:
        """Their derivative (n + 1, n + 2) by x, T and q, the last one as given."""
        size = self.units.size
        inner = variations(shot.motion, shot.motion.automaton, 1.0)[:, :-1] * size / size[:, None] - np.eye(size.size)
        rate = self._rate(shot.motion.automaton, shot.motion.end_mode, shot.motion.end_state)
        return np.vstack([np.column_stack([inner, rate, slope]), [*self.normal, 0.0, 0.0]])

    def directed(self, shot: Shot, way: np.ndarray) -> Solved | None:
        """A cycle with its tangent along a way that it was come to; None where there is no system beside it.

        A way may be of other equations, in which T and q alone are the same.
        """
        slope = self._slope(shot)
        matrix = np.empty(0) if slope is None else self.slopes(shot, slope)
        if slope is None or not np.isfinite(matrix).all():
            return None
        tangent, k = np.linalg.svd(matrix)[2][-1], -min(way.size, shot.z.size)
        return Solved(shot.z, shot.motion, -tangent if tangent[k:] @ way[k:] < 0 else tangent, slope)

    def _slope(self, shot: Shot) -> np.ndarray | None:
        """The derivative (n) of φ_T by q, there or, where tables are of another form from there on, next to it."""
        for step in (_DIFFERENCE, -_DIFFERENCE):
            along = np.eye(shot.z.size)[-1] * step
            for base in (shot, self.at(shot.z + along)):
                there = None if base is None else self.at(base.z + along, settled=True)
                if base is not None and there is not None and alike(base.motion.automaton, there.motion.automaton):
                    found: np.ndarray = variations(base.motion, there.motion.automaton, step)[:, -1] / self.units.size
                    return found
        return None

    def solved(
        self, guess: np.ndarray, across: np.ndarray | None, slope: np.ndarray, wanted: Itinerary = ()
    ) -> Solved | None:
        """The cycle in the plane through a guess across a direction, or of its q, by Newton's method.

        ``slope`` as of one near it; from step to step it follows from the change of the gap, as in the secant method.
        ``wanted``: the itinerary that it is to have.
        """
        row = np.eye(guess.size)[-1] if across is None else across
        before: Shot | None = None
        z, last, strays, stalls = guess.copy(), math.inf, 0, 0
        for steps in range(10):  # most starts need four
            shot = self.at(z)
            if shot is None:
                return None
            gap, matrix = self.gap(shot), self.slopes(shot, slope)
            if before is not None and before.itinerary == shot.itinerary:
                done = z - before.z
                if abs(done[-1]) > max(CLOSE, 0.1 * np.abs(done).max()):
                    slope = (gap - self.gap(before) - matrix[:, :-1] @ done[:-1])[:-1] / done[-1]
                    matrix[:-1, -1] = slope
            try:
                step = np.linalg.solve(np.vstack([matrix, row]), -np.append(gap, row @ (z - guess)))
            except np.linalg.LinAlgError:
                return None
            if not np.isfinite(step).all():  # there is no derivative
                return None
            step[-1] = 0.0 if across is None else step[-1]  # to the last bit, so that no other system is made
            length = float(np.abs(step).max())
            left = np.abs(gap).max() / max(1.0, np.abs(matrix[:-1, :-2]).max())
            stalls += left <= _ROUNDED and length <= CLOSE and length > 0.5 * last
            if max(left, length) <= _CLOSED or stalls == 2:
                break
            strays += bool(wanted) and wanted != shot.itinerary
            if strays > 3 or length > 1.0 or (steps > 5 and length > 0.5 * last):  # in sizes of the motion
                return None
            z, last, before = z + step, length, shot
        else:
            return None
        tangent = np.linalg.svd(matrix)[2][-1]
        return Solved(z, shot.motion, tangent if tangent @ row >= 0 else -tangent, slope)

    def here(self, period: float, value: float, way: np.ndarray) -> Solved | None:
        """The cycle that they are made from, of a period at a value, with its tangent along a way in T and q."""
        shot = self.at(np.array([*self.origin, period / self.units.period, self.units.counted(value)]))
        return None if shot is None else self.directed(shot, way[-2:])

    def fixed(self, z: np.ndarray) -> Solved | None:
        """The cycle near a place at the same parameter."""
        return self.solved(z, None, np.zeros(z.size - 2))


def _mode(automaton: Automaton, code: int, state: np.ndarray) -> int:
    """The mode of a code that holds a state; the mode that a motion enters from there if there is none."""
    tables, modes = automaton.tables, np.flatnonzero(automaton.codes == code)
    for mode in modes if modes.size > 1 else ():
        own = slice(tables.guard_start[mode], tables.guard_start[mode + 1])
        rows = tables.surfaces[tables.guard_surface[own]]
        if (tables.guard_sign[own] * (rows[:, :-1] @ state + rows[:, -1]) >= 0).all():
            return int(mode)
    return int(modes[0]) if modes.size else enter(automaton, state)[0]


def variations(motion: Motion, beside: Automaton, step: float) -> np.ndarray:
    """Return the derivative (n, n + 1) of a motion's end, at its fixed time, by its start and by a parameter.

    With the tables ``beside``, of the parameter a step further on, single arcs and events are compared, each from the
    same state, so that no graze nearby disturbs the difference; what changes is carried on as changes of the start are.
    It is nan where an event has no derivative.
    """
    automaton, n = motion.automaton, motion.start_state.size
    total, late = np.eye(n, n + 1), np.zeros(n + 1)  # changes of the state, and of the time of the last event
    for k, (mode, start, end, duration) in enumerate(zip(*motion.arcs(), strict=True)):
        rate, happens = rate_of(automaton, mode, end), k < motion.time.size and motion.kind[k] != GRAZE_KIND
        (middle,), _ = _arc(automaton, mode, start, math.inf).at([0.5 * duration])
        steep = happens and np.abs(rate).max() > _STEEP * np.abs(rate_of(automaton, mode, middle)).max()
        flow = derivative(_arc(automaton, mode, start, duration))[0]
        total = flow @ total
        if steep:  # the motion jams: rates are as the flow carries them, arcs go up to their events
            rate = flow @ rate_of(automaton, mode, start)
        else:
            (there,), _ = _arc(beside, mode, start, math.inf).at([duration])
            total[:, -1] += (there - end) / step
        if not happens:
            continue
        own, other = automaton.tables, (automaton if steep else beside).tables
        guard = crossed_guard(own, mode, motion.kind[k], motion.mode[k], end)
        surface, reset = own.guard_surface[guard], own.transition_reset[own.guard_transition[guard]]
        speed = own.surfaces[surface, :-1] @ rate
        if guard < 0 or speed == 0:  # infinitely many events end here, or it is only touched
            return np.full((n, n + 1), np.nan)
        affine, moved = np.append(end, 1.0), own.surfaces[surface, :-1] @ total
        moved[-1] += (other.surfaces[surface] - own.surfaces[surface]) @ affine / step
        later = -moved / speed
        total, late = total + np.outer(rate, later), late + later
        if reset >= 0:
            total = own.resets[reset][:, :-1] @ total
            total[:, -1] += (other.resets[reset] - own.resets[reset]) @ affine / step
        if steep:
            try:
                event = int(motion.kind[k]), int(motion.mode[k])
                whole = follow(beside, start, 2.0 * duration, mode=mode, stop=event)
            except EngineError:
                return np.full((n, n + 1), np.nan)
            total[:, -1] += (whole.end_state - motion.after[k]) / step
            late[-1] += (whole.end_time - duration) / step
    return total - np.outer(rate, late)


def alike(one: Automaton, other: Automaton) -> bool:
    """Whether two automata differ in doubles only."""
    pairs = zip(one.tables, other.tables, strict=True)
    return all(np.array_equal(a, b) for a, b in pairs if isinstance(a, np.ndarray) and a.dtype == np.int64)


def _arc(automaton: Automaton, mode: int, start: np.ndarray, duration: float) -> Motion:
    """A motion in one mode that ends in a touch, on to which derivatives go."""
    kinds = np.array([GRAZE_KIND], dtype=np.int8)
    return Motion(
        automaton, mode, start, np.array([duration]), kinds, 0 * kinds, np.array([mode]), start[None], start[None],
        status=Status.TIME_REACHED, end_time=duration, end_mode=mode, end_state=start,
    )  # fmt: skip


def rate_of(automaton: Automaton, mode: int, state: np.ndarray) -> np.ndarray:
    """Return x′ (n) at a state in a mode."""
    rate, size = np.empty_like(state), np.empty_like(state)
    single_mode.field(of_one_type(automaton.tables).flow, mode, state, rate, size)
    return rate
