r"""Periodic motions of any model, attracting or repelling, by Newton's method on the exact return map.

A section is the set of states with which an event of one kind ends (:mod:`lsvib.dynamics.poincare_map`); the return map P
of it is followed from event to event in closed form, and its derivative P′ is the exact product of
:mod:`lsvib.dynamics.poincare_map`. Newton's step  y ← y + (I − P′)⁻¹ (P(y) − y)  asks nothing of the stability.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from lsvib.dynamics.attractor import Attractor, SteadyState, cycle_label, orbit_extremes
from lsvib.dynamics.energy import Work, means, work
from lsvib.dynamics.impulses import Impulses, event_impulses
from lsvib.dynamics.poincare_map import AT_REST, Section, multipliers, section_derivative, section_key
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion, follow
from lsvib.models.drive import Drive
from lsvib.models.model import find_model

_NEWTON = 40  # steps; a start that Newton's method likes needs six
_HALVINGS = 8  # of a step that leads to where motions do not come back
_LONGER = 2.0  # a return may take so many times what it did


@dataclass(frozen=True)
class Cycle:
    """A periodic motion of ``drive``.

    ``orbit``: one period from ``state`` (n) on a section; ``residual`` [1]: change of the state over it, relative to
    the size of the motion; ``multipliers`` [1] (n − 1), complex, the largest first, and ``multiplier_error``, a bound
    of their errors (of stiff contacts an estimate); ``found_by``: how it was found.
    """

    drive: Drive
    orbit: Motion = field(repr=False)
    residual: float
    multipliers: np.ndarray
    multiplier_error: float
    found_by: str = "start"
    section: Section = field(repr=False, compare=False, default=None)  # type: ignore[assignment]

    @property
    def state(self) -> np.ndarray:
        """State (n) in which the period begins."""
        return self.orbit.start_state

    @property
    def period(self) -> float:
        """Period [s]."""
        return self.orbit.end_time

    @property
    def label(self) -> Attractor:
        """Sprag–slip if it sprags, stick–slip if it rests, else other; neutral if it is one of a family."""
        return Attractor.NEUTRAL_FAMILY if self.neutral else cycle_label(self.orbit)

    @property
    def leading(self) -> float:
        """Largest magnitude of a multiplier [1]."""
        return float(np.abs(self.multipliers).max(initial=0.0))

    @property
    def attracting(self) -> bool:
        """Whether all multipliers lie inside the unit circle by more than their error."""
        return self.leading + self.multiplier_error < 1

    @property
    def repelling(self) -> bool:
        """Whether a multiplier lies outside the unit circle by more than its error."""
        return self.leading - self.multiplier_error > 1

    @property
    def neutral(self) -> bool:
        """Whether the largest multiplier is on the unit circle, to its error; not if there are none."""
        return math.isfinite(self.leading) and not (self.attracting or self.repelling)

    @property
    def itinerary(self) -> tuple[tuple[str, str], ...]:
        """Events of a period, (kind, mode that is entered), without touches; the last one ends the period."""
        model = find_model(self.drive.model)
        return tuple(
            (model.events(int(kind)).name.lower(), model.modes(int(self.orbit.automaton.codes[mode])).name.lower())
            for kind, mode in zip(self.orbit.kind, self.orbit.mode, strict=True)
            if kind != GRAZE_KIND
        )

    @cached_property
    def extremes(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest value of each coordinate and observable, in its SI unit, in closed form."""
        automaton, unit = self.orbit.automaton, np.eye(self.state.size + 1)
        found = {name: orbit_extremes(self.orbit, unit[i]) for i, name in enumerate(automaton.states)}
        return found | {name: orbit_extremes(self.orbit, rows) for name, rows in automaton.observables.items()}

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak of u [rad]."""
        low, high = self.extremes["angle_deviation"]
        return 0.5 * (high - low)

    @cached_property
    def means(self) -> dict[str, float]:
        """Means of the observables over a period, in their SI units, without the impulses of seizures."""
        return means(self.orbit)

    @cached_property
    def work(self) -> Work:
        """Work over a period [J]."""
        return work(self.drive, self.orbit)

    @property
    def impulses(self) -> Impulses:
        """Impulses of each event of the period [N s, N m s]; zero but for seizures."""
        return event_impulses(self.drive, self.orbit)

    def to_json_multipliers(self) -> list[float | list[float] | None]:
        """Return the multipliers: numbers, or real and imaginary parts; None where there is no derivative."""
        return [_number(value) for value in self.multipliers]

    def to_json(self) -> dict[str, Any]:
        """Return what :class:`Cycle` says, as plain numbers and names."""
        taken = self.work
        return {
            "label": self.label.name.lower(),
            "attracting": self.attracting,
            "stability": self._stability(),
            "period": self.period,
            "amplitude": self.amplitude,
            "multipliers": self.to_json_multipliers(),
            "multiplier_error": _finite(self.multiplier_error),
            "state": [float(x) for x in self.state],
            "residual": self.residual,
            "found_by": self.found_by,
            "itinerary": self._events(),
            "extremes": {name: list(ends) for name, ends in self.extremes.items()},
            "means": self.means,
            "work": {
                "motor": taken.motor,
                "load": taken.load,
                "friction": taken.friction,
                "damping": taken.damping,
                "impacts": taken.impacts,
                "balance": taken.balance,
                "efficiency": _finite(taken.efficiency),
            },
        }

    def _stability(self) -> str:
        for name in ("attracting", "repelling", "neutral"):
            if getattr(self, name):
                return name
        return "not known"  # without multipliers, as infinitely many events have no derivative

    def _events(self) -> list[dict[str, Any]]:
        """Events of a period without touches: time [s], and the impulses [N s, N m s] of those that are seizures."""
        impulses, seized = self.impulses, np.isin(self.orbit.kind, self.orbit.automaton.sprag_kinds)
        found, names = [], iter(self.itinerary)
        for k in np.flatnonzero(self.orbit.kind != GRAZE_KIND):
            kind, mode = next(names)
            event: dict[str, Any] = {"event": kind, "mode": mode, "time": float(self.orbit.time[k])}
            if seized[k]:
                event |= {
                    "normal_impulse": float(impulses.normal[k]),
                    "axial_impulse": float(impulses.axial[k]),
                    "torque_impulse": float(impulses.torque[k]),
                }
            found.append(event)
        return found


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _number(value: complex) -> float | list[float] | None:
    """A real multiplier as a number, a complex one as its real and imaginary part."""
    if not np.isfinite(value):
        return None
    return float(value.real) if value.imag == 0 else [float(value.real), float(value.imag)]


def solve(section: Section) -> tuple[Motion, float] | None:
    """Return the periodic motion near the origin of a section and its residual [1]; None if Newton's method fails.

    The residual is the change of the state over the period relative to ``section.size``; it is rounding, times the
    growth of neighbours over a period.
    """
    place, best = np.zeros(section.dimension), None
    step, halved = np.zeros(section.dimension), 0
    for _ in range(_NEWTON):
        orbit = section.come_back(section.state(place))
        if orbit is None or orbit.time.size == 0 or orbit.time[-1] == 0.0:
            if not step.any() or halved == _HALVINGS:
                break
            step, halved = 0.5 * step, halved + 1  # beyond what comes back: half the way, and half of that
            place = place - step
            continue
        gap = section.place(orbit.end_state) - place
        residual = float(np.max(np.abs(orbit.end_state - orbit.start_state) / section.size))
        better = best is None or residual < best[1]
        if better:
            best = orbit, residual
        if section.dimension == 0:
            break
        found = newton_step(section_derivative(section, orbit).matrix, gap)
        if found is None or (not better and np.abs(found).max() < _CLOSE):
            break
        step, halved = found, 0
        place = place + step
        if np.abs(step).max() <= AT_REST * max(1.0, float(np.abs(place).max())):
            break
    return best if best is not None and best[1] < _CLOSE and _moves(best[0], section.size) else None


def _moves(orbit: Motion, size: np.ndarray) -> bool:
    """Whether a return is no mere touch: two events that rounding tells apart come back to where they began as well."""
    states, _ = orbit.at(orbit.end_time * np.array([0.25, 0.5, 0.75]))
    return bool((np.abs(states - orbit.start_state) > _MOVED * size).any())


_MOVED = 1e-9  # way of a return at one of its quarters, in sizes of the motion; a touch lasts for a few roundings
_CLOSE = 1e-8  # residual of a motion that is periodic, well above rounding times the growth of neighbours


def newton_step(slopes: np.ndarray, gap: np.ndarray) -> np.ndarray | None:
    """Return (I − P′)⁻¹ (P(y) − y); None if there is no derivative, or the matrix is singular."""
    if not (np.isfinite(slopes).all() and np.isfinite(gap).all()):
        return None
    try:
        step = np.linalg.solve(np.eye(len(gap)) - slopes, gap)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None


def cycle_from(
    drive: Drive, automaton: Automaton, state: np.ndarray, mode: int, events: int, found_by: str
) -> Cycle | None:
    """Return the cycle near the motion of so many events from a state (n) in a mode; None if there is none.

    The motion should be nearly periodic. The section is chosen among its events as the attractors' is.
    """
    guess = follow(automaton, state, math.inf, mode=mode, max_events=2 * events)
    key = section_key(guess)
    if key is None or ACCUMULATION_KIND in guess.kind:
        return None
    watched = np.flatnonzero((guess.kind[:events] == key[0]) & (guess.mode[:events] == key[1]))
    if not watched.size:
        return None
    size = np.maximum(np.abs(guess.after).max(axis=0), np.abs(guess.before).max(axis=0))
    size[size == 0] = 1.0
    section = Section(automaton, key, guess.after[watched[0]], size, len(watched), _LONGER * float(guess.end_time))
    return cycle_on(drive, section, found_by)


def cycle_of(drive: Drive, steady: SteadyState) -> Cycle | None:
    """Return the cycle that a motion was found to end on, solved again; None for an equilibrium or a neutral family."""
    if steady.orbit is None or steady.label == Attractor.NEUTRAL_FAMILY:
        return None
    orbit = steady.orbit
    size = np.maximum(np.abs(orbit.after).max(axis=0), np.abs(orbit.before).max(axis=0))
    size[size == 0] = 1.0
    key = int(orbit.kind[-1]), int(orbit.end_mode)
    section = Section(orbit.automaton, key, steady.state, size, steady.returns, _LONGER * orbit.end_time)
    return cycle_on(drive, section, "start")


def cycle_on(drive: Drive, section: Section, found_by: str) -> Cycle | None:
    """Return the cycle near the origin of a section; None if Newton's method does not find one."""
    found = solve(section)
    if found is None:
        return None
    orbit, residual = found
    values, error = multipliers(section, orbit, residual)
    return Cycle(drive, orbit, residual, values, error, found_by, section)
