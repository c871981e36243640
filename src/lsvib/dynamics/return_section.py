"""The section on which a return map acts, and the map itself: one return of the motion, and its derivative."""

import math
from typing import NamedTuple, Self

import numpy as np

from lsvib.dynamics.poincare_map import derivative, eigenvalues, field, rounding
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import event_loop, flow_planar
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import EngineError, WorkSpentError
from lsvib.models.rigid import EventKind

ROUNDING = flow_planar.ROUNDING  # sums below it, relative to their terms, count as zero, as they do in the engine
SLOPE_STEP = 1e-5  # half step of the central difference for P′ on a line
_JACOBIAN_STEP = 1e-6  # half step of the central differences for P′ on a section of more dimensions
MARGIN = 2e-8  # by which multipliers must lie inside the unit circle, well beyond the rounding of P′, 1e-10
_FINER = 1e-12  # the same where P′ is an exact product: beyond its rounding over some hundred events
_FEW_EVENTS = 64  # in a return whose derivative is an exact product, each factor of which costs
_FACTOR = 60.0  # so much, in units of a budget: some hundred microseconds
LONGEST = 1000  # events in one return
_ROOM = 64  # events of each of many returns that are followed together; one with more is followed alone
PATIENCE = 10  # time that the next return may take, in times of the longest return seen
_ONE_PLANE = 1e-9  # relative singular value below which two surfaces count as one
_LEAST_SCALE = 1e-6  # least scale of a coordinate of the origin, relative to its size in the whole motion
_TINY = float(np.finfo(float).tiny)  # scale of a coordinate that is zero throughout, by which one can divide
_MADE = 30.0  # cost of a section, in units of a budget: some hundred microseconds


class Return(NamedTuple):
    """One return to a line: P(y) − y, and its events as determined by ``Section.outcome``."""

    excess: float
    events: tuple[bytes, bytes] | None


def section_key(motion: Motion) -> tuple[int, int] | None:
    """Return kind and mode of the rarest events in the later half of a motion; None if it only touches guards.

    If several kinds are equally rare, take the latest one (two states) or the one that lies on the most surfaces (more
    states), because its section has the fewest dimensions and does not lie where the contact force passes zero, where
    the map is steep.
    """
    ours = (motion.kind != GRAZE_KIND) & (motion.kind != ACCUMULATION_KIND)  # np.isin takes ten times as long
    count, states = len(motion.automaton.codes), motion.after[ours]
    events = motion.kind[ours] * np.int64(count) + motion.mode[ours]  # one number for each; np.unique takes far longer
    if not events.size:
        return None
    half = events.size // 2
    counts = np.bincount(events[half:])
    latest = np.zeros(counts.size, dtype=np.int64)
    latest[events[half:]] = np.arange(half, events.size)
    rarest = np.flatnonzero(counts == counts[counts > 0].min())
    rarest = rarest[np.argsort(-latest[rarest])].tolist()
    if states.shape[1] > 2:
        size = np.abs(motion.after).max(axis=0)
        rarest.sort(key=lambda event: -len(_surfaces(motion.automaton, states[latest[event]], size)))
    return divmod(rarest[0], count)


def _surfaces(automaton: Automaton, state: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the normals (k, n) of the surfaces on which a state (n) lies."""
    rows = automaton.tables.surfaces
    values = rows[:, :-1] @ state + rows[:, -1]
    return rows[np.abs(values) <= ROUNDING * (np.abs(rows[:, :-1]) @ size + np.abs(rows[:, -1])), :-1]


def lines(automaton: Automaton) -> dict[tuple[int, int], np.ndarray]:
    """Return the line of two states on which the events of a kind (key: kind, mode after) end, as a row (3).

    Events that end in rest or release the screw are left out: from rest there is one way only.
    """
    tables, found = automaton.tables, {}
    for mode in range(len(automaton.codes)):
        if automaton.codes[mode] in automaton.rest_codes:
            continue
        for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
            transition = tables.guard_transition[guard]
            for branch in range(tables.branch_start[transition], tables.branch_start[transition + 1]):
                kind, after = int(tables.branch_kind[branch]), int(tables.branch_mode[branch])
                if automaton.codes[after] in automaton.rest_codes or kind == EventKind.RELEASE:
                    continue
                row = tables.surfaces[tables.guard_surface[guard]]
                if tables.transition_reset[transition] >= 0:  # a seizure ends on θ′ = 0
                    reset = tables.resets[tables.transition_reset[transition]]
                    row = np.array([-reset[1, 0], 1.0, -reset[1, 2]])
                found[kind, after] = row
    return found


def nearest_to_origin(line: np.ndarray) -> np.ndarray | None:
    """Return the point (2) of a line, a row (3), that lies next to the origin; None if a double cannot tell it.

    It is formed from the row times a power of two, which changes no digit, and no square underflows.
    """
    if not line[:2].any():
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # what is beyond all numbers
        row = np.ldexp(line, -np.frexp(np.abs(line[:2]).max())[1])
        point = -row[2] * row[:2] / (row[:2] @ row[:2])
    return point if np.isfinite(point).all() else None


def _line(automaton: Automaton, key: tuple[int, int], met: np.ndarray) -> np.ndarray | None:
    """Return the normal (2) of the line of a section whose origin lies on the surfaces ``met``; None if it is a point.

    An event next to a corner lies on both of its surfaces to rounding; the one that it crossed is the section.
    """
    if len(met) == 1:
        return met[0]
    row = lines(automaton).get(key)
    return None if row is None else row[:2]


class Section:
    """The states near ``origin`` (n) in which events of one kind (``key``: kind, mode after) end.

    A state is ``origin`` + ``directions`` (n, d) · y. With two states y is measured in scales of the motion, ``size``
    (n); with more, in the origin's own coordinates, because an unloaded contact is far from its peak. One return of the
    map is made of ``returns`` returns to the section; ``longest`` [s] is the longest of them that was seen. Motions
    draw on a ``budget``, if there is one.
    """

    def __init__(
        self,
        automaton: Automaton,
        key: tuple[int, int],
        origin: np.ndarray,
        size: np.ndarray,
        returns: int,
        longest: float,
        budget: Budget | None = None,
    ) -> None:
        self.automaton, self.key, self.returns, self.origin, self.size = automaton, key, returns, origin, size
        self._limit, self.budget = PATIENCE * longest, budget
        if budget is not None:
            budget.spend(_MADE)
        met = _surfaces(automaton, origin, size)
        if origin.size > 2:
            scales = np.maximum(np.abs(origin), np.maximum(_LEAST_SCALE * size, _TINY))
            normals = met * scales
            units = np.frexp(np.abs(normals).max(axis=1, keepdims=True, initial=0.0))[1]
            normals = np.ldexp(normals, -units)  # whose squares do not underflow; all digits stay
            lengths = np.linalg.norm(normals, axis=1, keepdims=True)
            normals /= np.where(lengths == 0, 1.0, lengths)
            _, lengths, basis = np.linalg.svd(normals)
            axes = basis[np.count_nonzero(lengths > _ONE_PLANE) :]
            self.directions, self._axes = (axes * scales).T, axes / scales
        elif (normal := _line(automaton, key, met)) is not None:
            tangent = np.array([-normal[1], normal[0]])
            scales = np.maximum(size, _TINY)
            direction = tangent / np.abs(tangent / scales).max()
            chosen = np.argmax(np.abs(direction / scales))
            self.directions, self._axes = direction[:, None], (np.arange(2) == chosen)[None] / direction[chosen]
        else:
            self.directions, self._axes = np.zeros((2, 0)), np.zeros((0, 2))
        self._reach = self._inner_part() if len(self._axes) == 1 else (-math.inf, math.inf)

    def _inner_part(self) -> tuple[float, float]:
        """Return the places (first, last) of a line from which motions go into the mode.

        Along the line lies a guard of the mode, whose rate changes its sign at a corner; beyond that motions leave
        through the surface, and no event ends there.
        """
        tables, mode = self.automaton.tables, self.key[1]
        own = slice(tables.guard_start[mode], tables.guard_start[mode + 1])
        rows = tables.guard_sign[own, None] * tables.surfaces[tables.guard_surface[own]]
        normals, offsets, along = rows[:, :-1], rows[:, -1], self.directions[:, 0]
        met = np.abs(normals @ self.origin + offsets) <= ROUNDING * (np.abs(normals) @ self.size + np.abs(offsets))
        met &= np.abs(normals @ along) <= ROUNDING * (np.abs(normals) @ np.abs(along))
        first, last = -math.inf, math.inf
        (here, here_size), (there, there_size) = (
            field(self.automaton, mode, state) for state in (self.origin, self.origin + along)
        )
        for normal in normals[met]:
            rate, slope = float(normal @ here), float(normal @ (there - here))
            size = ROUNDING * float(np.abs(normal) @ np.maximum(here_size, there_size))
            if abs(slope) > size:
                corner = -(rate + size) / slope  # a rate above −size may be zero
                first, last = (max(first, corner), last) if slope > 0 else (first, min(last, corner))
            elif rate < -size:
                return math.inf, -math.inf
        return first, last

    @property
    def dimension(self) -> int:
        """Number d of directions along the section."""
        return len(self._axes)

    @property
    def axes(self) -> np.ndarray:
        """Rows (d, n) that give y of a displacement along the section."""
        return self._axes

    def state(self, place: np.ndarray) -> np.ndarray:
        """Return the state (n) at y = ``place`` (d)."""
        return self.origin + self.directions @ place

    def place(self, states: np.ndarray) -> np.ndarray:
        """Return y (..., d) of states (..., n) on the section."""
        return (states - self.origin) @ self._axes.T

    def distance(self, place: float) -> float:
        """Return the distance of a place on a line from where its free coordinate is zero, in the scale of y."""
        free = int(np.argmax(np.abs(self._axes[0])))
        return abs(float(self.state(np.array([place]))[free] * self._axes[0, free]))

    def at(self, origin: np.ndarray, size: np.ndarray) -> Self:
        """Return the section with another origin (n), in the scales ``size`` (n)."""
        origin = self._put_on_line(origin) if origin.size == 2 and self.dimension == 1 else origin
        return type(self)(self.automaton, self.key, origin, size, self.returns, self._limit / PATIENCE)

    def _put_on_line(self, state: np.ndarray) -> np.ndarray:
        """Return a state (2) near the line with its coordinate that is not free as the surface has it.

        Far nearer to zero than the origin, a state that is computed from it lies beside the surface by the rounding of
        the origin; a line laid through it would be as far off everywhere, and a drift along it might seem to end.
        """
        rows, other = self.automaton.tables.surfaces, 1 - int(np.argmax(np.abs(self._axes[0])))
        along = np.abs(rows[:, :2] @ self.directions[:, 0]) <= ROUNDING * (
            np.abs(rows[:, :2]) @ np.abs(self.directions[:, 0])
        )
        off = np.abs(rows[:, :2] @ self.origin + rows[:, 2])
        met = off <= ROUNDING * (np.abs(rows[:, :2]) @ self.size + np.abs(rows[:, 2]))
        for row in rows[along & met & (rows[:, other] != 0)]:
            state = state.copy()
            state[other] = -(row[2] + row[1 - other] * state[1 - other]) / row[other]
        return state

    def finer(self, place: float) -> Self | None:
        """Return the section with its origin at a place on the line, in the scales of one return from there."""
        origin = self.state(np.array([place]))
        motion = self.come_back(origin)
        if motion is None:
            return None
        size = np.abs(motion.after).max(axis=0)
        return self.at(origin, np.where(size > 0, size, self.size))

    def come_back(self, state: np.ndarray) -> Motion | None:
        """Follow the motion from a state (n) of the section until it is back; None if it does not come back."""
        motion, events, here = None, 0, state
        for _ in range(self.returns):
            try:
                motion = self._follow(here, self._limit, LONGEST, self.key)
            except WorkSpentError:
                raise
            except EngineError:
                return None
            if motion.status != Status.STOP_EVENT:
                return None
            here, events = motion.end_state, events + motion.time.size
        if self.returns > 1:
            motion = self._follow(state, math.inf, events)
        return motion

    def _follow(self, state: np.ndarray, t_end: float, events: int, stop: tuple[int, int] = (-1, -1)) -> Motion:
        mode, budget = self.key[1], self.budget
        return follow(self.automaton, state, t_end, mode=mode, stop=stop, max_events=events, budget=budget)

    def grain(self, place: np.ndarray) -> float:
        """Return the rounding of y in a return from y = ``place`` on a line, in roundings of one.

        Between events a motion with two states may swing much further than its states at events show, and a surface
        that it hardly crosses moves what follows by much more than a rounding. It is infinite if there is no return.
        """
        orbit = self.come_back(self.state(place))
        if orbit is None:
            return math.inf
        if self.origin.size > 2:
            return 1.0
        lost = rounding(orbit) / flow_planar.EPS
        return max(1.0, float(np.abs(self._axes[0]) @ lost)) if np.isfinite(lost).all() else math.inf

    def excess(self, place: np.ndarray) -> np.ndarray:
        """Return P(y) − y (d) at y = ``place`` (d); nan if the motion does not come back."""
        return self.outcome(place)[0]

    def outcome(self, place: np.ndarray) -> tuple[np.ndarray, tuple[bytes, bytes] | None]:
        """Return P(y) − y (d) at y = ``place`` (d), and the kinds and modes of the events of that return.

        The result is nan and None if the motion does not come back, or if the surface is crossed the other way there.
        """
        inside = self.dimension != 1 or self._reach[0] <= place[0] <= self._reach[1]
        motion = self.come_back(self.state(place)) if inside else None
        if motion is None or motion.time[0] == 0.0:
            return np.full(self.dimension, math.nan), None
        return self.place(motion.end_state) - place, (motion.kind.tobytes(), motion.mode.tobytes())

    def return_from(self, place: float) -> Return:
        """Follow one return from y = ``place`` on a line."""
        excess, events = self.outcome(np.array([place]))
        return Return(float(excess[0]), events)

    def returns_from(self, places: np.ndarray) -> list[Return]:
        """Follow one return from each of some places (k) on a line, as :meth:`return_from` does, of two states."""
        if self.returns > 1 or self.budget is not None:
            return [self.return_from(float(place)) for place in places]
        states = np.array([self.state(np.array([place])) for place in places.tolist()])
        counts = np.empty(len(states), dtype=np.int64)
        kinds, modes = (np.empty((len(states), _ROOM), dtype=kind) for kind in (np.int8, np.int64))
        event_loop.returns(self.automaton.tables, self.key[1], states, self._limit, self.key[0], kinds, modes, counts)
        found = []
        for k, count in enumerate(counts.tolist()):
            if count < 0:
                found.append(self.return_from(float(places[k])))
            elif count == 0 or not self._reach[0] <= places[k] <= self._reach[1]:
                found.append(Return(math.nan, None))
            else:
                excess = self.place(states[k]) - places[k : k + 1]
                found.append(Return(float(excess[0]), (kinds[k, :count].tobytes(), modes[k, :count].tobytes())))
        return found

    def jacobian(self, place: np.ndarray) -> np.ndarray:
        """Return P′ (d, d) at y = ``place`` (d) by central differences; nan if a motion does not come back."""
        step = SLOPE_STEP if self.dimension == 1 else _JACOBIAN_STEP
        offsets = step * np.eye(self.dimension)
        columns = [(self.excess(place + h) - self.excess(place - h)) / (2 * step) for h in offsets]
        return np.reshape(columns, offsets.shape).T + np.eye(self.dimension)

    def slopes(self, place: np.ndarray) -> tuple[np.ndarray, float]:
        """Return P′ (d, d) at y = ``place`` (d), and by how much its eigenvalues are uncertain [1]; nan as above."""
        if self.dimension == 0:  # the section is a point
            return np.zeros((0, 0)), MARGIN
        motion = self.come_back(self.state(place))
        if motion is not None and 0 < motion.time.size <= _FEW_EVENTS:
            if self.budget is not None:
                self.budget.spend(_FACTOR * motion.time.size)
            exact = derivative(motion)
            found = self._axes @ exact.matrix @ self.directions
            if np.isfinite(found).all() and np.isfinite(exact.rounding).all():
                with np.errstate(over="ignore"):  # beyond all numbers it is more than the margin
                    lost = np.abs(self._axes) @ exact.rounding @ np.abs(self.directions) * self.automaton.condition
                    size = float(np.linalg.norm(lost))
                return found, min(max(eigenvalues(found)[1] * size, _FINER), MARGIN)
        return self.jacobian(place), MARGIN
