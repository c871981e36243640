"""What a motion ends in – its attractor, or why that is not known – and exact means and extremes over a cycle."""

import math
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import NamedTuple

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import event_loop, layout
from lsvib.engine.motion import Motion
from lsvib.errors import (
    AccumulationError,
    DivergenceError,
    EngineError,
    UndecidedError,
    WorkSpentError,
)

_ONE_PERIOD = 1e-6  # relative difference of the periods of one cycle, as two motions reach it


class Attractor(IntEnum):
    """Where a motion ends up."""

    UNRESOLVED = -1
    STEADY_SLIDING = 0
    STICK_SLIP_CYCLE = 1
    SPRAG_SLIP_CYCLE = 2
    OTHER_CYCLE = 3  # a cycle of pure slip
    UNBOUNDED = 4  # of compliant threads, and of parts of a drive; other drives have a bounded energy
    REST = 5  # at rest for ever; never the label of a drive whose motor turns, which ends every rest
    NEUTRAL_FAMILY = 6  # undamped oscillations side by side, each periodic, none attracting the others


class Doubt(StrEnum):
    """Why the attractor of a motion is unresolved; nothing else is ever the reason."""

    EVENT_BUDGET = "event budget exhausted"
    RECURRENT = "event budget exhausted by a vibration that hardly changes in size and has no period that was found"
    WORK_BUDGET = "work budget exhausted by the search for one event"
    ROUNDING = "start or motion on a boundary to rounding"
    ACCUMULATION = "events accumulate, and the model does not say what follows"
    RANGE = "motion leaves the range of numbers"
    ENGINE = "no answer of the engine"

    @classmethod
    def of(cls, error: EngineError) -> "Doubt":
        """Return what an error of the engine stands for."""
        return next((doubt for kind, doubt in _MEANT.items() if isinstance(error, kind)), cls.ENGINE)


_MEANT = {
    DivergenceError: Doubt.RANGE,
    AccumulationError: Doubt.ACCUMULATION,
    UndecidedError: Doubt.WORK_BUDGET,
    WorkSpentError: Doubt.EVENT_BUDGET,
}


class Passage(NamedTuple):
    """A stretch of a line on which a ``mode`` is entered; all motions that enter the mode there have one attractor.

    ``ends`` (2, 2) are the states at the ends of the stretch.
    """

    mode: int
    ends: np.ndarray


@dataclass(frozen=True)
class SteadyState:
    """The attractor of a motion.

    ``label`` names it, and ``state`` (n) is the equilibrium or the state on the section. A cycle also has ``orbit``,
    one period as a motion from the point on the section; ``returns``, the number of returns to the section in a period;
    ``residual`` [1], the change of the section state over one period relative to the size of the motion; ``enclosure``
    [1], the half width of the interval that is proved to hold the fixed point, relative to that size (0 if the section
    state repeats to the last bit, nan if the section is not a line); and ``multiplier`` [1], the largest of the return
    map. ``passages`` are the stretches over which the motion was leapt. ``doubt`` says why an attractor is unresolved.
    """

    label: Attractor
    state: np.ndarray
    orbit: Motion | None = field(default=None, repr=False)
    returns: int = 0
    residual: float = math.nan
    enclosure: float = math.nan
    multiplier: float = math.nan
    passages: tuple[Passage, ...] = ()
    doubt: Doubt | None = None

    @classmethod
    def unresolved(cls, state: np.ndarray, doubt: "Doubt | EngineError") -> "SteadyState":
        """Return the attractor that is not known of a motion, whose last state (n) is known, and why."""
        return cls(Attractor.UNRESOLVED, state, doubt=doubt if isinstance(doubt, Doubt) else Doubt.of(doubt))

    @property
    def period(self) -> float:
        """Period [s]; nan for an equilibrium."""
        return self.orbit.end_time if self.orbit else math.nan

    def same_period(self, other: "SteadyState") -> bool:
        """Whether two cycles have one period, as two motions reach them."""
        return abs(self.period - other.period) <= _ONE_PERIOD * self.period

    def extremes(self, row: np.ndarray) -> tuple[float, float]:
        """Return the extremes over the cycle of an affine function (n + 1) or an observable (m, n + 1)."""
        if self.orbit is None:
            value = float(row[:-1] @ self.state + row[-1])
            return value, value
        return orbit_extremes(self.orbit, row)

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak of u [rad]."""
        low, high = self.extremes(np.eye(1, self.state.size + 1)[0])
        return 0.5 * (high - low)


def out_of_range(automaton: Automaton, state: np.ndarray) -> SteadyState:
    """Return the end of a motion that grows or leaves the range of numbers, with its last state (n) before that."""
    if automaton.passive:
        return SteadyState.unresolved(state, Doubt.RANGE)
    return SteadyState(Attractor.UNBOUNDED, state)


def cycle_label(orbit: Motion) -> Attractor:
    """Return the label of a cycle that is no family: sprag–slip if it sprags, stick–slip if it rests, else other."""
    automaton, codes = orbit.automaton, orbit.automaton.codes[orbit.arcs()[0]]
    if np.isin(orbit.kind, automaton.sprag_kinds).any() or np.isin(codes, automaton.sprag_codes).any():
        return Attractor.SPRAG_SLIP_CYCLE
    return Attractor.STICK_SLIP_CYCLE if np.isin(codes, automaton.rest_codes).any() else Attractor.OTHER_CYCLE


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
    functionals = np.array(np.broadcast_to(row, (len(automaton.codes), row.shape[-1])))
    low, high = event_loop.extremes_of_arcs(automaton.tables.flow, modes, starts, durations, functionals)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise EngineError("the extremes of the motion cannot be isolated: the rates of a mode lie too far apart.")
    return low, high


def arc_integrals(orbit: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Exact ∫(u, w, 1) dt over each arc of a motion, shape (k, 3) [rad s, rad, s], and the arcs' modes (k).

    From the equation of motion of the mode:  a₀ ∫u = b τ − Δw − a₁ Δu;  without stiffness, as at rest, w is constant.
    """
    modes, starts, ends, durations = orbit.arcs()
    flow = orbit.automaton.tables.flow[modes]
    change = ends - starts
    a0, a1, b = flow[:, layout.A0], flow[:, layout.A1], flow[:, layout.B]
    resting = a0 == 0
    spring = (b * durations - change[:, 1] - a1 * change[:, 0]) / np.where(resting, 1.0, a0)
    drift = starts[:, 0] * durations + 0.5 * starts[:, 1] * durations**2
    return np.stack([np.where(resting, drift, spring), change[:, 0], durations], axis=1), modes
