"""Run an automaton: the engine's kernels for Python, their statuses turned into results or clear messages."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from lsvib import numbers
from lsvib.errors import AccumulationError, DivergenceError, EngineError, InputError, UndecidedError, WorkSpentError
from lsvib.systems.automaton import Automaton, Branch, Guard, Mode, Surface, Transition, assemble
from lsvib.systems.exact.modal_form import PlanarMode, linear_mode
from lsvib.systems.kernels import event_loop, jit
from lsvib.systems.kernels.layout import CARRY, FIRST_MODEL_KIND, STEPS, TIME, Begin, Events, Now, Status, Tables, Until
from lsvib.systems.kernels.machine import STEP

NEVER = Until(0.0, -1, -1)  # for its type
_FIRST_CAPACITY = 256  # events that the first list holds; each further list holds twice as many as came before
_MANY_EVENTS = 10_000_000  # limit where the caller gives none; they take about a gigabyte
_MANY_STEPS = 50_000_000  # of the searches for events, likewise; a minute or two
_FINE = (Status.TIME_REACHED, Status.STOP_EVENT, Status.SETTLED, Status.EVENTS_FULL, Status.WORK_SPENT)

# cost of a call of the engine from Python, in units of one ordinary event, one to three microseconds, as measured
CALL = 10.0


class Budget:
    """Work that may still be spent on runs, ``left`` [1], in units of one ordinary event.

    Runs draw on it by their number of events and by the steps of the search for them, so it bounds time whatever the
    system, and its results do not depend on the machine. It is one for many runs, which all count down the same number.
    """

    def __init__(self, left: float) -> None:
        self.left = left

    def spend(self, work: float) -> None:
        """Draw on the budget; raises ``WorkSpentError`` if nothing is left."""
        self.left -= work
        if self.left < 0:
            raise WorkSpentError("the motion takes too much work to compute.")


@dataclass(frozen=True)
class Motion:
    """A motion, such as one period of a cycle: its events, and closed forms between them.

    Arrays over the k events: ``time`` [s], ``kind``, ``sign``, ``mode`` (after the event), ``before`` and ``after`` (k,
    n). ``status`` says why it ended, at ``end_time`` [s] (of the last event if the motion settled) in ``end_mode`` and
    ``end_state`` (n).

    >>> import lsvib
    >>> orbit = lsvib.Drive(translation_damping=1000, axial_force=30).steady_state("rest").orbit
    >>> states, modes = orbit.at([0, orbit.end_time / 2])
    >>> states.round(6).tolist(), modes.tolist()
    ([[-0.046103, 2.876102], [0.041839, -0.850947]], [1, 0])
    """

    automaton: Automaton = field(repr=False)
    start_mode: int
    start_state: np.ndarray
    time: np.ndarray = field(repr=False)
    kind: np.ndarray = field(repr=False)
    sign: np.ndarray = field(repr=False)
    mode: np.ndarray = field(repr=False)
    before: np.ndarray = field(repr=False)
    after: np.ndarray = field(repr=False)
    status: Status
    end_time: float
    end_mode: int
    end_state: np.ndarray

    def at(self, times: "ArrayLike") -> tuple[np.ndarray, np.ndarray]:
        """Return exact states (k, n) and modes (k) at ``times`` (k) [s], in any order; at an event, those after it."""
        times = np.ascontiguousarray(times, dtype=float)
        order = np.argsort(times, kind="stable")
        states = np.empty((times.size, self.start_state.size))
        modes = np.empty(times.size, dtype=np.int64)
        begin = Begin(0.0, self.start_mode, self.start_state)
        event_loop.states_at(self.automaton.tables, begin, self.events(), times[order], states, modes)
        if 0.0 not in self.time:  # closed forms leave a rounding of what is zero
            states[times[order] == 0.0] = self.start_state
        return states[back := np.argsort(order)], modes[back]

    def events(self) -> Events:
        """Return the arrays over the events as the tuple that kernels take."""
        return Events(self.time, self.kind, self.sign, self.mode, self.before, self.after)

    def arcs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the arcs between events: mode (k), state at the start (k, n), at the end (k, n), duration [s] (k)."""
        modes = np.concatenate([[self.start_mode], self.mode])
        starts = np.concatenate([self.start_state[None], self.after])
        ends = np.concatenate([self.before, self.end_state[None]])
        durations = np.diff(self.time, prepend=0.0, append=self.end_time)
        return modes, starts, ends, durations


def enter(automaton: Automaton, state: ArrayLike) -> tuple[int, np.ndarray]:
    """Return the mode in which a motion from ``state`` (n) starts, and the state; ``InputError`` if not finite."""
    state = np.array(state, dtype=float)
    for name, value in zip(automaton.states, state, strict=True):
        numbers.start(f"start {name}", float(value))
    branch = event_loop.choose_branch(automaton.tables, 0, state, np.abs(state))
    if branch < 0:
        raise EngineError(f"no mode fits the start {state.tolist()}; this is a bug, please report it.")
    return int(automaton.tables.branch_mode[branch]), state


def follow(
    automaton: Automaton,
    state: ArrayLike,
    t_end: float,
    *,
    mode: int | None = None,
    stop: tuple[int, int] = (-1, -1),
    max_events: int | None = None,
    budget: Budget | None = None,
) -> Motion:
    """Follow the motion from ``state`` (n) at time 0 until ``t_end`` [s].

    Arguments: t_end ≥ 0, infinite if the motion is known to settle or ``stop`` or ``max_events`` ends it; mode: start
    there instead of where the state says; stop: (event kind, mode after or −1) to end after; max_events: end after so
    many; budget: what the run may cost, counted down. Returns a :class:`Motion` with status TIME_REACHED, STOP_EVENT,
    SETTLED or, with ``max_events``, EVENTS_FULL, or WORK_SPENT where the search for the event after the last one takes
    all that the budget has. Raises ``EngineError`` if the model has no answer, there are more than ten million events
    or, without a budget, searches for them take more than 50 million steps; ``DivergenceError`` if the motion grows
    without bound, ``WorkSpentError`` if the budget does not suffice.
    """
    if not t_end >= 0:
        raise InputError(f"t_end = {t_end} is outside the allowed range t_end >= 0.")
    if mode is None:
        mode, state = enter(automaton, state)
    else:
        state = np.array(state, dtype=float)
    start_mode, start_state = mode, state.copy()
    if budget is not None:
        budget.spend(CALL)
    engine = automaton.engines.pop() if automaton.engines else engine_for(automaton.tables)
    clock = np.array([0.0, 0.0, 0.0, _MANY_STEPS if budget is None else budget.left / STEP])
    now, until = Now(state, np.abs(state), clock), Until(float(t_end), *stop)
    most = _MANY_EVENTS if max_events is None else max_events
    pieces, total, capacity = [], 0, min(_FIRST_CAPACITY, most)
    while True:
        events = new_events(capacity, state.size)
        steps = clock[STEPS]
        status, mode, count = event_loop.run_in(engine.room, automaton.tables, mode, now, until, events)
        if budget is not None and status == Status.WORK_SPENT:
            budget.left = 0.0
        elif budget is not None:
            budget.spend(count + STEP * (steps - clock[STEPS]))
        pieces.append([column[:count] for column in events])
        total += count
        if status != Status.EVENTS_FULL or total >= most:
            break
        capacity = min(max(2 * total, _FIRST_CAPACITY), most - total)
    automaton.engines.append(engine)
    end_time = float(clock[TIME] + clock[CARRY])
    if status == Status.WORK_SPENT and budget is None:
        raise WorkSpentError(
            f"the motion takes more than {_MANY_STEPS:,} steps to the event after t = {end_time:.6g} s; shorten the "
            "duration or, if rates lie far apart, use larger inertias, or smaller stiffness and damping."
        )
    columns = [np.concatenate(column) for column in zip(*pieces, strict=True)] if len(pieces) > 1 else pieces[0]
    motion = Motion(
        automaton, start_mode, start_state, *Events(*columns),
        status=Status(status), end_time=end_time, end_mode=int(mode), end_state=state,
    )  # fmt: skip
    error = _complaint(Status(status), end_time, state, most if max_events is None else None)
    if error is not None:
        error.motion = motion
        raise error
    return motion


def engine_for(tables: Tables) -> event_loop.Engine:
    """Return what is needed to follow motions with these tables, or others of one shape, one at a time."""
    room, n = event_loop.room_for(tables), tables.surfaces.shape[1] - 1
    row = np.empty(n)
    run = jit.address(event_loop.run_in, room, tables, 0, Now(row, row, row), NEVER, new_events(0, n))
    return event_loop.Engine(run, room)


def new_events(capacity: int, n: int) -> Events:
    """Return room for so many events of a motion with n states, as the event loop writes them."""
    time, kind, sign, mode = (np.empty(capacity, dtype=own) for own in (float, np.int8, np.int8, np.int64))
    return Events(time, kind, sign, mode, np.empty((capacity, n)), np.empty((capacity, n)))


def _complaint(status: Status, time: float, state: np.ndarray, most: int | None) -> EngineError | None:
    """Return the error that a status means, if it means one; ``most``: events after which a motion is too long."""
    if status == Status.EVENTS_FULL and most is not None:
        return EngineError(f"more than {most} events before t = {time:.6g} s; shorten the duration.")
    if status in _FINE and math.isfinite(time):
        return None
    where = f"at t = {time:.6g} s, state {np.array2string(state, precision=6)}"
    if status == Status.DIVERGED:
        return DivergenceError(f"the motion grows without bound ({where}); shorten the duration or add damping.")
    if status == Status.ACCUMULATED:
        return AccumulationError(f"infinitely many events accumulate {where}, and the model does not say what follows.")
    if status == Status.UNDECIDED:
        return UndecidedError(
            f"the search for the next event does not end ({where}): the rates of the mode lie too far apart."
        )
    if status == Status.NO_BRANCH:
        return EngineError(
            f"no branch of a transition fits {where}: under a friction law that grows with speed it has reached the "
            "Painlevé region, and what follows is not determined; otherwise this is a bug; please report it."
        )
    return EngineError(f"the clock left the range of numbers ({where}).")


def compile_engine() -> None:
    """Compile and cache the engine for linear flows; kernels of maps are when they are first used."""
    for kind in ("planar", "modal"):
        automaton = bouncing(kind)
        motion = follow(automaton, [1.0, 0.0], 10.0)
        if motion.time.size != 2:
            raise EngineError(f"the compiled engine bounced {motion.time.size} times instead of 2")
        motion.at([1.0])
        event_loop.extremes_of_arcs(automaton.tables.flow, *motion.arcs()[:2], np.ones(3), automaton.tables.surfaces)


def bouncing(kind: str) -> Automaton:
    """Return the automaton of an oscillator that bounces off a wall; ``kind`` of its flow: planar or modal."""
    field = [(0, 1, 0), (-1, 0, 0)]
    flow = PlanarMode.of(1, 0, 1, 0) if kind == "planar" else linear_mode(field, (1.0, 1.0), None, "the wall")
    free = (Branch("free", FIRST_MODEL_KIND),)
    return assemble(
        states=("u", "w"),
        surfaces={"wall": Surface((1, 0, 0.5), 0)},
        modes={"free": Mode(0, flow, (Guard("wall", 1, "bounce"),))},
        transitions={"entry": Transition(free), "bounce": Transition(free, reset=((1, 0, 0), (0, -1, 0)))},
        observables={},
        shortest_stay=0.0,
    )
