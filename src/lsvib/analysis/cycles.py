"""The attractor that a motion reaches, decided by the return map of its events; exact means and extremes over a cycle.

A motion either *settles* – the engine proves that no guard can fire again, so it stays in one linear mode for ever – or
its events recur. Events of one kind that enter one mode lie on one surface, on which the motion induces a return map.
The motion has reached its cycle when the map returns the same state to rounding; a map that converges slowly is solved
for its fixed point by the secant method and enclosed: P(s) − s is positive on its left and negative on its right, so a
fixed point lies between. Its multiplier P′ is measured; it attracts if |P′| < 1. No waiting time enters.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from lsvib.core import flows, planar
from lsvib.core.status import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.errors import EngineError
from lsvib.models.automaton import Automaton
from lsvib.models.motion import Motion, follow

_CHUNK = 64
_PERIODS = 8  # longest cycle, in returns to the section, that is looked for
_ROUNDING = 16 * planar.EPS
_REPEATS = (4 * planar.EPS, 1e-10)  # relative change that is rounding: of two states, of more (modal form)
_ENCLOSURE = 1e-9  # half width, in scales of the motion, of the first interval tried around a fixed point
_SLOPE_STEP = 1e-5  # half step of the central difference for the slope of the return map
_CORNER = 1e-9  # a fixed point smaller than this, in scales of the motion, is the equilibrium itself, on a surface


class Attractor(IntEnum):
    """Where a motion ends up."""

    UNRESOLVED = -1
    STEADY_SLIDING = 0
    STICK_SLIP_CYCLE = 1
    SPRAG_SLIP_CYCLE = 2
    OTHER_CYCLE = 3  # pure slip
    UNBOUNDED = 4
    REST = 5  # at rest for ever; a motor that turns ends every rest of a drive


@dataclass(frozen=True)
class SteadyState:
    """The attractor of a motion.

    ``label``; for a cycle: ``orbit``, one period as a motion from a point on the section; ``returns``, returns to the
    section in a period; ``residual``, change of the section state over one period relative to its size; ``enclosure``,
    half width of the interval that is proved to hold the fixed point, relative to its size (0 if the section state
    repeats to the last bit); ``multiplier``, slope of the return map there. ``state`` is the equilibrium or the section
    state.
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
        """Smallest and largest value over the cycle of an affine function (n + 1) or an observable (m, n + 1)."""
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
    """Exact extremes along a motion of an affine function (n + 1) or of an observable (modes, n + 1)."""
    low, high = math.inf, -math.inf
    modes, starts, _, durations = orbit.arcs()
    for mode, start, duration in zip(modes, starts, durations, strict=True):
        functional = row if row.ndim == 1 else row[mode]
        a, b = flows.extremes(orbit.automaton.tables.flow, mode, start, functional, duration)
        low, high = min(low, a), max(high, b)
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
    a0, a1, b = flow[:, planar.A0], flow[:, planar.A1], flow[:, planar.B]
    resting = a0 == 0
    spring = (b * durations - change[:, 1] - a1 * change[:, 0]) / np.where(resting, 1.0, a0)
    drift = starts[:, 0] * durations + 0.5 * starts[:, 1] * durations**2
    return np.stack([np.where(resting, drift, spring), change[:, 0], durations], axis=1), modes


def mean(orbit: Motion, observable: str, *, absolute: bool = False) -> float:
    """Mean of an observable over a motion without impulses; ``absolute``: of its magnitude (one sign in each mode)."""
    integrals, modes = arc_integrals(orbit)
    parts = np.einsum("ki,ki->k", orbit.automaton.observables[observable][modes], integrals)
    return float(np.sum(np.abs(parts) if absolute else parts) / orbit.end_time)


def steady_state(automaton: Automaton, state, *, mode: int | None = None, max_events: int = 200_000) -> SteadyState:
    """Find the attractor of the motion from ``state`` (n).

    Exits:

    * SETTLED: steady sliding in a damped mode, at its equilibrium; in an undamped one a slip cycle, in one that grows
      unbounded, unless the motion is at that equilibrium; rest in a mode at rest;
    * the section state repeats after 1 to 8 returns, or a fixed point of the return map is enclosed: a cycle, named
      sprag–slip if it sprags, stick–slip if it rests, else other; steady sliding if the fixed point is the origin;
    * the motion grows without bound: unbounded;
    * ``max_events``: unresolved.
    """
    state = np.array(state, dtype=float)
    used = 0
    while used < max_events:
        try:
            motion = follow(automaton, state, math.inf, mode=mode, max_events=_CHUNK)
        except EngineError:
            return SteadyState(Attractor.UNBOUNDED, state)
        if motion.status == Status.SETTLED:
            return settled(automaton, motion)
        cycle = _recurrence(automaton, motion)
        if cycle is not None:
            return cycle
        used += motion.time.size
        state, mode = motion.end_state, motion.end_mode
    return SteadyState(Attractor.UNRESOLVED, state)


def settled(automaton: Automaton, motion: Motion) -> SteadyState:
    """The attractor of a motion that stays in its last mode for ever."""
    flow = automaton.tables.flow
    if not isinstance(flow, np.ndarray):
        field = flow.field[motion.end_mode]
        return SteadyState(Attractor.STEADY_SLIDING, np.linalg.solve(field[:, :-1], -field[:, -1]))
    row = flow[motion.end_mode]
    if automaton.codes[motion.end_mode] in automaton.rest_codes:
        return SteadyState(Attractor.REST, motion.end_state)
    equilibrium = np.array([row[planar.EQUILIBRIUM], 0.0])
    if row[planar.ALPHA] > 0 or np.array_equal(motion.end_state, equilibrium):
        return SteadyState(Attractor.STEADY_SLIDING, equilibrium)
    if row[planar.ALPHA] < 0:
        return SteadyState(Attractor.UNBOUNDED, motion.end_state)
    orbit = follow(automaton, motion.end_state, 2 * math.pi / row[planar.BETA], mode=motion.end_mode)
    return SteadyState(Attractor.OTHER_CYCLE, motion.end_state, orbit, 1, 0.0, 0.0, 1.0)


def _recurrence(automaton: Automaton, motion: Motion) -> SteadyState | None:
    """The cycle that the last events of a motion lie on, or None if they do not tell."""
    key = _section(motion)
    points = motion.after[(motion.kind == key[0]) & (motion.mode == key[1])]
    size = np.maximum(np.abs(motion.after).max(axis=0), np.finfo(float).tiny)
    for returns in range(1, min(_PERIODS, len(points) - 1) + 1):
        if (np.abs(points[-1] - points[-1 - returns]) <= _REPEATS[size.size > 2] * size).all():
            section = _Section(automaton, key, returns, points[-1], size)
            return section.cycle(0.0, 0.0)
    if len(points) < 4:
        return None
    return _fixed_point(_Section(automaton, key, 1, points[-1], size), (points[-2] - points[-1]) / size)


def _section(motion: Motion) -> tuple[int, int]:
    """Kind and mode of the events to watch: the rarest of the last ones, the latest if several."""
    ours = ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    pairs = list(zip(motion.kind[ours].tolist(), motion.mode[ours].tolist(), strict=True))
    recent = pairs[len(pairs) // 2 :]
    return min(reversed(recent), key=recent.count)


class _Section:
    """A line of states that events of one kind (``key``: kind, mode after) enter on, and the return map along it.

    A point is ``origin`` + s · ``direction``; s counts in scales of the motion. Where two surfaces meet, as on release
    from rest, the section is a single point and ``direction`` is zero; so it is where the state has more than two
    coordinates, and a cycle must then show by itself.
    """

    def __init__(
        self, automaton: Automaton, key: tuple[int, int], returns: int, origin: np.ndarray, size: np.ndarray
    ) -> None:
        self.automaton, self.key, self.returns, self.origin, self.size = automaton, key, returns, origin, size
        rows = automaton.tables.surfaces
        values = rows[:, :-1] @ origin + rows[:, -1]
        met = rows[np.abs(values) <= _ROUNDING * (np.abs(rows[:, :-1]) @ size + np.abs(rows[:, -1]))]
        line = origin.size == 2 and len(met) == 1
        tangent = np.array([-met[0, 1], met[0, 0]]) if line else np.zeros(origin.size)
        largest = np.abs(tangent / size).max()
        self.direction = tangent / largest if largest > 0 else tangent
        self.axis = int(np.argmax(np.abs(self.direction / size)))

    def come_back(self, point: np.ndarray) -> Motion | None:
        """The motion from a point until it has returned ``returns`` times, or None if it does not."""
        motion, events = None, 0
        state = point
        for _ in range(self.returns):
            try:
                motion = follow(self.automaton, state, math.inf, mode=self.key[1], stop=self.key, max_events=1000)
            except EngineError:
                return None
            if motion.status != Status.STOP_EVENT:
                return None
            state, events = motion.end_state, events + motion.time.size
        if self.returns > 1:
            motion = follow(self.automaton, point, math.inf, mode=self.key[1], max_events=events)
        return motion

    def excess(self, s: float) -> float:
        """P(s) − s; nan if the motion does not come back."""
        motion = self.come_back(self.origin + s * self.direction)
        if motion is None:
            return math.nan
        return (motion.end_state[self.axis] - self.origin[self.axis]) / self.direction[self.axis] - s

    def slope(self, s: float) -> float:
        """P′(s), by a central difference."""
        return 1 + (self.excess(s + _SLOPE_STEP) - self.excess(s - _SLOPE_STEP)) / (2 * _SLOPE_STEP)

    def cycle(self, s: float, enclosure: float) -> SteadyState | None:
        """The cycle through the fixed point s."""
        point = self.origin + s * self.direction
        orbit = self.come_back(point)
        if orbit is None:
            return None
        modes = self.automaton.codes[orbit.arcs()[0]]
        if np.isin(orbit.kind, self.automaton.sprag_kinds).any() or np.isin(modes, self.automaton.sprag_codes).any():
            label = Attractor.SPRAG_SLIP_CYCLE
        elif np.isin(modes, self.automaton.rest_codes).any():
            label = Attractor.STICK_SLIP_CYCLE
        else:
            label = Attractor.OTHER_CYCLE
        residual = float(np.max(np.abs(orbit.end_state - point) / self.size))
        multiplier = 0.0 if point.size == 2 else math.nan
        if self.direction.any():
            multiplier = self.slope(s)
        return SteadyState(label, point, orbit, self.returns, residual, enclosure, multiplier)


def _fixed_point(section: _Section, last_step: np.ndarray) -> SteadyState | None:
    """Solve the return map for its fixed point near the last return by the secant method, and enclose it."""
    if not section.direction.any():
        return None
    older, old = float(last_step[section.axis]) * section.size[section.axis] / section.direction[section.axis], 0.0
    f_older, f_old = section.excess(older), section.excess(old)
    for _ in range(60):
        if abs(f_old) <= planar.EPS or f_old == f_older:
            break
        new = old - f_old * (old - older) / (f_old - f_older)
        f_new = section.excess(new)
        if math.isnan(f_new):
            return None
        older, f_older, old, f_old = old, f_old, new, f_new
        if abs(old - older) <= planar.EPS:
            break
    width = _ENCLOSURE
    if not abs(f_old) <= _ROUNDING or not section.excess(old - width) > 0 > section.excess(old + width):
        return None
    if not abs(section.slope(old)) < 1:
        return None
    point = section.origin + old * section.direction
    if np.abs(point / section.size).max() < _CORNER:
        here = section.origin / section.size
        if not np.abs(here).max() < np.abs(here + last_step).max():
            return None  # it grows away from the corner
        return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(point))
    while width > _ROUNDING and section.excess(old - width / 4) > 0 > section.excess(old + width / 4):
        width /= 4
    return section.cycle(old, width)
