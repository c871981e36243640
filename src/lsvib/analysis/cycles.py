"""The attractor that a motion reaches, decided by the return map of its events; exact means and extremes over a cycle.

A motion either *settles* – the engine proves that no guard can fire again, so it stays in one linear mode for ever – or its
events recur. Events of one kind that enter one mode lie on one surface, on which the motion induces a return map. The motion has
reached its cycle when the map returns the same state to rounding; a map that converges slowly is solved for its fixed point by
the secant method, and the fixed point is enclosed by a change of sign of P(s) − s on both sides, from above on the left to below on
the right: then a fixed point lies between, and it attracts from both sides if the measured |P′| < 1.
No waiting time enters.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from lsvib.core import planar
from lsvib.core.status import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.errors import EngineError
from lsvib.models.automaton import Automaton
from lsvib.models.motion import Motion, follow
from lsvib.models.rigid import EventKind, MotionMode

_CHUNK = 64
_PERIODS = 8  # longest cycle, in returns to the section, that is looked for
_ROUNDING = 16 * planar.EPS


class Attractor(IntEnum):
    """Where a motion ends up."""

    UNRESOLVED = -1
    STEADY_SLIDING = 0
    STICK_SLIP_CYCLE = 1
    SPRAG_SLIP_CYCLE = 2
    OTHER_CYCLE = 3  # pure slip
    UNBOUNDED = 4


@dataclass(frozen=True)
class SteadyState:
    """The attractor of a motion.

    ``label``; for a cycle: ``orbit``, one period as a motion from a point on the section; ``returns``, returns to the section in a period;
    ``residual``, change of the section state over one period relative to its size; ``enclosure``, half width of the interval that
    is proved to hold the fixed point, relative to its size (0 if the section state repeats to the last bit); ``multiplier``, slope of the
    return map there. ``state`` is the equilibrium or the section state.
    """

    label: Attractor
    state: np.ndarray
    orbit: Motion | None = None
    returns: int = 0
    residual: float = math.nan
    enclosure: float = math.nan
    multiplier: float = math.nan

    @property
    def period(self) -> float:
        """Period [s]; nan for an equilibrium."""
        return self.orbit.end_time if self.orbit else math.nan

    def extremes(self, row) -> tuple[float, float]:
        """Smallest and largest value over the cycle of an affine function (n + 1) of the state or of an observable's rows (m, n + 1)."""
        if self.orbit is None:
            value = float(row[:-1] @ self.state + row[-1])
            return value, value
        return orbit_extremes(self.orbit, row)

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak of u [rad]."""
        low, high = self.extremes(np.array([1.0, 0.0, 0.0]))
        return 0.5 * (high - low)


def orbit_extremes(orbit: Motion, row: np.ndarray) -> tuple[float, float]:
    """Smallest and largest value along a motion of an affine function (n + 1), or of an observable (modes, n + 1), exactly."""
    low, high = math.inf, -math.inf
    modes, starts, _, durations = orbit.arcs()
    for mode, start, duration in zip(modes, starts, durations, strict=True):
        functional = row if row.ndim == 1 else row[mode]
        a, b = planar.extremes(orbit.automaton.tables.flow, mode, start, functional, duration)
        low, high = min(low, a), max(high, b)
    return low, high


def arc_integrals(orbit: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Exact ∫(u, w, 1) dt over each arc of a motion, shape (k, 3) [rad s, rad, s], and the arcs' modes (k).

    From the equation of motion of the mode:  a₀ ∫u = b τ − Δw − a₁ Δu;  without stiffness, as at rest, w is constant.
    """
    modes, starts, ends, durations = orbit.arcs()
    flow = orbit.automaton.tables.flow[modes]
    change = ends - starts
    a0, a1, b = flow[:, planar.A0], flow[:, planar.A1], flow[:, planar.B]
    resting = a0 == 0
    spring = (b * durations - change[:, 1] - a1 * change[:, 0]) / np.where(resting, 1.0, a0)
    drift = starts[:, 0] * durations + 0.5 * starts[:, 1] * durations**2
    return np.stack([np.where(resting, drift, spring), change[:, 0], durations], axis=1), modes


def mean(orbit: Motion, observable: str, *, absolute: bool = False) -> float:
    """Mean of an observable over a motion, impulses left out; with ``absolute`` of its magnitude (its sign must be constant in a mode)."""
    integrals, modes = arc_integrals(orbit)
    parts = np.einsum("ki,ki->k", orbit.automaton.observables[observable][modes], integrals)
    return float(np.sum(np.abs(parts) if absolute else parts) / orbit.end_time)


def steady_state(automaton: Automaton, state, *, mode: int | None = None, max_events: int = 200_000) -> SteadyState:
    """Find the attractor of the motion from ``state`` (n).

    Exits: SETTLED in a damped mode → steady sliding at its equilibrium (in an undamped one, a slip cycle unless it is at rest there);
    section state repeated after 1 to 8 returns, or fixed point of the return map enclosed → cycle, named sprag–slip if it has
    a seizure, stick–slip if it has a rest, else other; the motion grows without bound → unbounded; else ``max_events`` → unresolved.
    """
    state = np.array(state, dtype=float)
    used = 0
    while used < max_events:
        try:
            motion = follow(automaton, state, math.inf, mode=mode, max_events=_CHUNK)
        except EngineError:
            return SteadyState(Attractor.UNBOUNDED, state)
        if motion.status == Status.SETTLED:
            return _settled(automaton, motion)
        cycle = _recurrence(automaton, motion)
        if cycle is not None:
            return cycle
        used += motion.time.size
        state, mode = motion.end_state, motion.end_mode
    return SteadyState(Attractor.UNRESOLVED, state)


def _settled(automaton: Automaton, motion: Motion) -> SteadyState:
    row = automaton.tables.flow[motion.end_mode]
    equilibrium = np.array([row[planar.EQUILIBRIUM], 0.0])
    if row[planar.ALPHA] > 0 or np.array_equal(motion.end_state, equilibrium):
        return SteadyState(Attractor.STEADY_SLIDING, equilibrium)
    orbit = follow(automaton, motion.end_state, 2 * math.pi / row[planar.BETA], mode=motion.end_mode)
    return SteadyState(Attractor.OTHER_CYCLE, motion.end_state, orbit, 1, 0.0, 0.0, 1.0)


def _recurrence(automaton: Automaton, motion: Motion) -> SteadyState | None:
    """The cycle that the last events of a motion lie on, or None if they do not tell."""
    key = _section(motion)
    hits = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    points = motion.after[hits]
    size = np.abs(motion.after).max(axis=0)
    for returns in range(1, min(_PERIODS, len(points) - 1) + 1):
        if (np.abs(points[-1] - points[-1 - returns]) <= 4 * planar.EPS * size).all():
            return _cycle(automaton, points[-1], key, returns, size, math.nan)
    if len(points) < 4:
        return None
    return _fixed_point(automaton, points, key, size)


def _section(motion: Motion) -> tuple[int, int]:
    """Kind and mode of the events to watch: the rarest of the last ones, the latest if several."""
    ours = ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    pairs = list(zip(motion.kind[ours].tolist(), motion.mode[ours].tolist(), strict=True))
    recent = pairs[len(pairs) // 2 :]
    return min(reversed(recent), key=recent.count)


def _return(automaton: Automaton, point: np.ndarray, key: tuple[int, int]) -> Motion | None:
    """One return to the section, or None if the motion does not come back."""
    try:
        motion = follow(automaton, point, math.inf, mode=key[1], stop=key, max_events=1000)
    except EngineError:
        return None
    return motion if motion.status == Status.STOP_EVENT else None


def _fixed_point(automaton: Automaton, points: np.ndarray, key: tuple[int, int], size: np.ndarray) -> SteadyState | None:
    """Solve the return map for a fixed point near the last returns by the secant method along the section."""
    direction = points[-1] - points[-2]
    direction = direction / np.abs(direction / size).max()  # unit step: one scale of the motion
    origin = points[-1]
    axis = int(np.argmax(np.abs(direction / size)))

    def excess(s: float) -> float:
        motion = _return(automaton, origin + s * direction, key)
        return math.nan if motion is None else (motion.end_state[axis] - origin[axis]) / direction[axis] - s

    older, old = -1.0 * (points[-1] - points[-2])[axis] / direction[axis], 0.0
    f_older, f_old = excess(older), excess(old)
    for _ in range(60):
        if abs(f_old) <= planar.EPS or f_old == f_older:
            break
        new = old - f_old * (old - older) / (f_old - f_older)
        f_new = excess(new)
        if math.isnan(f_new):
            return None
        older, f_older, old, f_old = old, f_old, new, f_new
        if abs(old - older) <= planar.EPS:
            break
    if not abs(f_old) <= _ROUNDING:
        return None
    point = origin + old * direction
    if np.abs(point / size).max() < 1e-9:
        return None  # the motion shrinks to a corner; it is for the caller's limit of events to say so
    width = 1e-9
    left, right = excess(old - width), excess(old + width)
    multiplier = 1 + (right - left) / (2 * width)
    while width > _ROUNDING and excess(old - width / 4) > 0 > excess(old + width / 4):
        width /= 4
    if not left > 0 > right:
        return None
    return _cycle(automaton, point, key, 1, size, multiplier, width)


def _cycle(automaton, point, key, returns, size, multiplier, enclosure=0.0) -> SteadyState | None:
    parts = [point]
    time = 0.0
    for _ in range(returns):
        motion = _return(automaton, parts[-1], key)
        if motion is None:
            return None
        time += motion.end_time
        parts.append(motion.end_state)
    orbit = motion if returns == 1 else follow(automaton, point, math.inf, mode=key[1], max_events=_events_of(automaton, point, key, returns))
    residual = float(np.max(np.abs(parts[-1] - point) / size))
    modes = orbit.automaton.codes[orbit.arcs()[0]]
    if (orbit.kind == EventKind.SEIZURE).any():
        label = Attractor.SPRAG_SLIP_CYCLE
    elif (modes == MotionMode.REST).any():
        label = Attractor.STICK_SLIP_CYCLE
    else:
        label = Attractor.OTHER_CYCLE
    if math.isnan(multiplier):
        multiplier = 0.0 if (orbit.kind == EventKind.RELEASE).any() else math.nan
    return SteadyState(label, point, orbit, returns, residual, enclosure, multiplier)


def _events_of(automaton: Automaton, point: np.ndarray, key: tuple[int, int], returns: int) -> int:
    """Number of events in ``returns`` returns to the section."""
    total = 0
    for _ in range(returns):
        motion = _return(automaton, point, key)
        total += motion.time.size
        point = motion.end_state
    return total
