"""The attractor that a motion of any model reaches: the one rule by which every label of a motion is decided.

The way of a label: here → :mod:`lsvib.systems.kernels.attractor` (the rule) → :mod:`lsvib.systems.kernels.poincare_map`
(section, returns, fixed points) → :mod:`lsvib.systems.kernels.saltation` (their derivatives), which follow motions by
the engine. Maps, sweeps and charts ask nothing else.

The motion is followed for 16 events, for 64, and then for twice as many again and again, until no guard can fire any
more or its events recur. Then the section is that of the rarest events of the later half, and Newton's method seeks a
fixed point of the map of as many returns as take the state back or, in 64 events or more, nearest to where it was
(:mod:`lsvib.systems.section`). What leaves the range of numbers is unbounded if energy can grow in the model; what the
budget does not suffice for is unresolved, for a named reason (:class:`Doubt`). No waiting time enters, and nothing
depends on other motions.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike

from lsvib.errors import AccumulationError, DivergenceError, EngineError, UndecidedError, WorkSpentError
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import attractor as rule
from lsvib.systems.kernels import event_loop
from lsvib.systems.kernels.poincare_map import LONGEST, ON_CIRCLE
from lsvib.systems.kernels.single_mode import Outcome
from lsvib.systems.machine import lent
from lsvib.systems.motion import Motion, enter, follow, new_events


class Attractor(IntEnum):
    """Where a motion of a drive ends (docs/attraction.md), numbered as in datasets: ``lsvib.Attractor(2).name``.

    OTHER_CYCLE: pure slip, nothing sticks; UNBOUNDED: only in a system that is not passive; REST: at rest for ever;
    NEUTRAL_FAMILY: undamped oscillations side by side, each periodic, none attracting the others.
    """

    UNRESOLVED = -1
    STEADY_SLIDING = 0
    STICK_SLIP_CYCLE = 1
    SPRAG_SLIP_CYCLE = 2
    OTHER_CYCLE = 3
    UNBOUNDED = 4
    REST = 5
    NEUTRAL_FAMILY = 6


class Doubt(StrEnum):
    """Why the attractor of a motion is unresolved, in words; there are no other reasons."""

    EVENT_BUDGET = "too many events without a result"
    RECURRENT = "too many events: the vibration hardly changes in size, but no period was found"
    WORK_BUDGET = "the search for one event took too much work"
    ROUNDING = "the start or the motion lies on a boundary, to rounding"
    ACCUMULATION = "infinitely many events accumulate, and the model does not say what follows"
    RANGE = "the motion leaves the range of numbers"
    ENGINE = "the engine gave no answer"
    COMMAND = "the commanded speed does not settle at input_speed within the duration"

    @classmethod
    def of(cls, error: EngineError) -> "Doubt":
        """Return the doubt that an error of the engine means."""
        return next((doubt for kind, doubt in _MEANT.items() if isinstance(error, kind)), cls.ENGINE)


_MEANT = {
    DivergenceError: Doubt.RANGE,
    AccumulationError: Doubt.ACCUMULATION,
    UndecidedError: Doubt.WORK_BUDGET,
    WorkSpentError: Doubt.EVENT_BUDGET,
}
_UNRESOLVED: dict[int, Doubt] = {
    Outcome.SPENT: Doubt.EVENT_BUDGET,
    Outcome.SPENT_STEADILY: Doubt.RECURRENT,
    Outcome.SEARCH_SPENT: Doubt.WORK_BUDGET,
    Outcome.ACCUMULATES: Doubt.ACCUMULATION,
    Outcome.LOST: Doubt.ENGINE,
}


@dataclass(frozen=True)
class SteadyState:
    """The attractor of a motion.

    ``label`` names it; ``state`` (n) [SI units] is the equilibrium, or the state on the section. A cycle also has
    ``orbit``, one period as a motion from the point on the section; ``returns``, the number of returns to the section
    in a period; ``residual`` [1], the change of the section state over one period relative to the size of the motion;
    and ``multiplier`` [1], the largest of the return map, or its magnitude if it is complex. ``doubt`` says why an
    attractor is unresolved (docs/attraction.md).

    >>> found = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10).steady_state({"u": 0.1, "w": 0})
    >>> found.label.name, f"{found.period:.6f} s", f"{found.amplitude:.6f} rad", f"{found.multiplier:.6f}"
    ('SPRAG_SLIP_CYCLE', '0.010944 s', '0.055997 rad', '0.060277')
    >>> [round(end, 6) for end in found.extremes([1, 0, 0])]  # of u [rad]
    [-0.115638, -0.003644]
    """

    label: Attractor
    state: np.ndarray
    orbit: Motion | None = None
    returns: int = 0
    residual: float = math.nan
    multiplier: float = math.nan
    doubt: Doubt | None = None

    def __repr__(self) -> str:
        sizes = f"period={self.period:.9g}, amplitude={self.amplitude:.9g}, " if self.orbit else ""
        return f"SteadyState({self.label.name}, {sizes}state={self.state}, doubt={self.doubt and self.doubt.name})"

    @classmethod
    def unresolved(cls, state: np.ndarray, doubt: "Doubt | EngineError") -> "SteadyState":
        """Return an unresolved attractor, from the last known state (n) [SI units] and the reason."""
        return cls(Attractor.UNRESOLVED, state, doubt=doubt if isinstance(doubt, Doubt) else Doubt.of(doubt))

    @property
    def period(self) -> float:
        """Period [s]; NaN for an equilibrium."""
        return self.orbit.end_time if self.orbit else math.nan

    def same_period(self, other: "SteadyState") -> bool:
        """Whether two cycles have the same period [s], to a relative 1e-6."""
        return abs(self.period - other.period) <= 1e-6 * self.period

    def extremes(self, row: "ArrayLike") -> tuple[float, float]:
        """Return the extremes over the cycle of an affine function (n + 1), or of one for each mode (m, n + 1).

        The constant is last. Raises ``EngineError`` if they cannot be isolated.
        """
        row = np.asarray(row, dtype=float)
        if self.orbit is None:
            value = float(row[:-1] @ self.state + row[-1])
            return value, value
        return orbit_extremes(self.orbit, row)

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak value of the first coordinate, u [rad] of a drive."""
        low, high = self.extremes(np.eye(1, self.state.size + 1)[0])
        return 0.5 * (high - low)


class Course(NamedTuple):
    """A motion until its end is determined: time [s], events and modes that sprag, first event (−1: none)."""

    time: float
    sprags: int
    first_event: int


class KnownCycles(NamedTuple):
    """Cycles that a motion may be found to join, before others are looked for, and what is asked of the rule."""

    cycles: Sequence[Any]  # with an orbit each, such as steady states
    asked: rule.Asked

    @classmethod
    def of(cls, cycles: Sequence[Any], automaton: Automaton, patience: int) -> "KnownCycles":
        """Return the table of cycles of an automaton, each with events.

        ``patience``: events after which other cycles are looked for as well.
        """
        orbits = [one.orbit for one in cycles if one.orbit is not None]
        kind, mode = (np.array([getattr(o, name)[-1] for o in orbits], dtype=np.int64) for name in ("kind", "mode"))
        visits = [np.sum((o.kind == o.kind[-1]) & (o.mode == o.mode[-1])) for o in orbits]
        point, size = np.empty((2, len(orbits), len(automaton.states)))
        for k, orbit in enumerate(orbits):
            point[k], size[k] = orbit.after[-1], np.maximum(np.abs(orbit.after).max(axis=0), np.finfo(float).tiny)
        events = np.array([o.time.size for o in orbits], dtype=np.int64)
        table = rule.Known(kind, mode, np.array(visits, dtype=np.int64), events, point, size)
        rests, held, jams = (automaton.marked(automaton.codes, mark) for mark in ("rest", "held", "jam"))
        impacts = automaton.marked(np.arange(128), "impact")  # kinds of events are numbers of eight bits
        facts = rule.Facts(rests, rests | held, jams, impacts, bool(np.all(conserves(automaton))))
        return cls(cycles, rule.Asked(facts, table, patience))


def steady_state(
    automaton: Automaton, state: ArrayLike, *, mode: int | None = None, max_events: int = 300_000
) -> SteadyState:
    """Find the attractor of a motion from ``state`` (n), in ``mode`` if given, by the rule of the module docstring.

    ``max_events`` bounds the work, of the motion and of the returns by which its map is solved, in units of one
    ordinary event. Where slip makes every area of the phase plane smaller (``Automaton.contracts``) it is known.
    """
    return end_of_motion(automaton, state, mode=mode, max_events=max_events)[0]


def end_of_motion(
    automaton: Automaton,
    state: ArrayLike,
    *,
    mode: int | None = None,
    max_events: float = 300_000,
    known: KnownCycles | None = None,
) -> tuple[SteadyState, Course]:
    """Return the attractor of a motion, as :func:`steady_state` does, and its course until that is determined.

    With ``known`` cycles the motion is looked at after every 64 events: it has joined one of them when its last four
    points on the cycle's section tend to the cycle's point, in geometric steps with as many events between them as the
    cycle has.
    """
    here = np.array(state, dtype=float)
    if shrinks_areas(automaton):
        return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(here)), Course(math.nan, 0, -1)
    if mode is None:
        mode, here = enter(automaton, here)
    known = known or KnownCycles.of((), automaton, 0)
    found = new_found(here.size, max_events)
    with lent(automaton) as (machine, tables):
        outcome = rule.end_of(machine, tables, known.asked, mode, here, records(here.size), found)
    notes = found.notes[0]
    course = Course(float(notes["time"]), int(notes["sprags"]), int(notes["first_event"]))
    return _meant(automaton, outcome, found, known), course


def records(states: int) -> rule.Records:
    """Return the room for events that the rule needs: for those of the motion, and for two periods."""
    return rule.Records(new_events(rule.SIGHT, states), new_events(LONGEST, states), new_events(LONGEST, states))


def shrinks_areas(automaton: Automaton) -> bool:
    """Whether the model vouches that every motion ends in steady sliding: areas shrink, so no orbit is closed."""
    return automaton.contracts and not conserves(automaton)


def conserves(automaton: Automaton) -> Any:
    """Whether all modes in motion preserve areas or volumes, because nothing damps; of many systems for each (k)."""
    return automaton.flow.conserves(~automaton.marked(automaton.codes, "rest"))


def new_found(states: int, work: float) -> rule.Found:
    """Return what the rule fills, with the work that may be spent."""
    notes = np.zeros(1, dtype=rule.NOTES)
    notes["left"] = work
    return rule.Found(notes, np.zeros(states), np.zeros((states, states)))


def _meant(automaton: Automaton, outcome: int, found: rule.Found, known: KnownCycles) -> SteadyState:
    state, mode = found.state.copy(), int(found.notes[0]["mode"])
    if outcome == Outcome.KNOWN:
        return cast(SteadyState, known.cycles[int(found.notes[0]["index"])])
    if outcome == Outcome.SLIDES:
        label = Attractor.REST if automaton.stands else Attractor.STEADY_SLIDING
        return SteadyState(label, automaton.flow.equilibrium(mode))
    if outcome == Outcome.RESTS:
        return SteadyState(Attractor.REST, state)
    if outcome == Outcome.GROWS:
        if automaton.passive:  # only rounding hides the next event
            return SteadyState.unresolved(state, Doubt.RANGE)
        return SteadyState(Attractor.UNBOUNDED, state)
    if outcome in _UNRESOLVED:
        return SteadyState.unresolved(state, _UNRESOLVED[outcome])
    try:
        if outcome == Outcome.OSCILLATES:
            frequency = float(found.notes[0]["frequency"])  # zero for several, which have no common period
            if not frequency:
                return SteadyState(Attractor.NEUTRAL_FAMILY, state, multiplier=1.0)
            orbit = follow(automaton, state, 2 * math.pi / frequency, mode=mode)
            return SteadyState(Attractor.NEUTRAL_FAMILY, state, orbit, 1, 0.0, 1.0)
        return _cycle(automaton, found, known)
    except EngineError as error:
        return SteadyState.unresolved(state, error)


def _cycle(automaton: Automaton, found: rule.Found, known: KnownCycles) -> SteadyState:
    notes, state, facts = found.notes[0], found.state.copy(), known.asked.facts
    d = int(notes["dimension"])
    orbit = follow(automaton, state, math.inf, mode=int(notes["mode"]), max_events=int(notes["events"]))
    label, leading = cycle_label(orbit), float(largest(found.slopes[:d, :d]))
    neutral = facts.conserves and abs(leading) > 1 - ON_CIRCLE and label != Attractor.SPRAG_SLIP_CYCLE
    modes, _, _, durations = orbit.arcs()
    # part of a period for which the largest of a neutral family seems to rest where it touches that
    brief = label == Attractor.STICK_SLIP_CYCLE and durations[facts.sticks[modes]].sum() <= 1e-6 * orbit.end_time
    label = Attractor.NEUTRAL_FAMILY if neutral or (facts.conserves and brief) else label
    size = np.maximum(np.abs(orbit.after).max(axis=0), np.finfo(float).tiny)
    residual = float(np.max(np.abs(orbit.end_state - state) / size))
    return SteadyState(label, state, orbit, int(notes["returns"]), residual, leading)


def cycle_label(orbit: Motion) -> Attractor:
    """Return the label of a cycle that is no family: sprag–slip if it sprags, stick–slip if a part sticks, or other."""
    automaton, codes = orbit.automaton, orbit.automaton.codes[orbit.arcs()[0]]
    if automaton.marked(orbit.kind, "impact").any() or automaton.marked(codes, "jam").any():
        return Attractor.SPRAG_SLIP_CYCLE
    return Attractor.STICK_SLIP_CYCLE if automaton.marked(codes, "rest", "held").any() else Attractor.OTHER_CYCLE


def largest(slopes: np.ndarray) -> np.ndarray:
    """Return the eigenvalues of P′ (..., d, d) of the largest magnitude, or that if they are complex; 0 if d = 0."""
    if slopes.shape[-1] == 0:
        return np.zeros(slopes.shape[:-2])
    values = np.linalg.eigvals(slopes)
    leading = np.take_along_axis(values, np.abs(values).argmax(axis=-1)[..., None], axis=-1)[..., 0]
    return np.where(leading.imag == 0, leading.real, np.abs(leading))


def orbit_extremes(orbit: Motion, row: np.ndarray, wanted: np.ndarray | None = None) -> tuple[float, float]:
    """Exact extremes along a motion of an affine function (n + 1) or of an observable (modes, n + 1).

    With ``wanted`` (modes) over the arcs in these modes only, and not a number where there is none. Raises
    ``EngineError`` where the rates of a mode lie too far apart to isolate them.
    """
    automaton = orbit.automaton
    modes, starts, _, durations = orbit.arcs()
    if wanted is not None:
        chosen = wanted[modes]
        if not chosen.any():
            return math.nan, math.nan
        modes, starts, durations = modes[chosen], starts[chosen], durations[chosen]
    functionals = np.array(np.broadcast_to(row, (len(automaton.codes), row.shape[-1])), order="C")
    low, high = event_loop.extremes_of_arcs(automaton.tables.flow, modes, starts, durations, functionals)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise EngineError("the extremes of the motion cannot be isolated: the rates of a mode lie too far apart.")
    return low, high
