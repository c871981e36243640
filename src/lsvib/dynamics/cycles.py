"""Periodic motions of a drive of any model, attracting or repelling, and the search for all of them.

Cycles are solved by Newton's method on the exact Poincaré map (:mod:`lsvib.dynamics.poincare_map`). The search takes
attracting ones from starts, and repelling ones from the edges between what the starts end on
(:mod:`lsvib.dynamics.edge_tracking`). A search is no proof: what no start ends on stays unseen.
"""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, cycle_label, orbit_extremes, steady_state
from lsvib.dynamics.edge_tracking import edge_cycles
from lsvib.dynamics.energy import Work, means, work
from lsvib.dynamics.impulses import Impulses, event_impulses
from lsvib.dynamics.poincare_map import Section, multipliers, section_key, size_of, solve
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion, follow
from lsvib.models.drive import PARTS, Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.mechanism import seated_state
from lsvib.models.model import model_of
from lsvib.models.names import BODIES

_SAME = 1e-7  # Two cycles of one stability that differ by less, relatively, are the same cycle.


@dataclass(frozen=True)
class Cycle:
    """A periodic motion of ``drive``.

    ``orbit``: one period from ``state`` (n) on a section; ``residual`` [1]: change of the state over it, relative to
    the size of the motion; ``multipliers`` [1] (n − 1), complex, the largest first, and ``multiplier_error``, a bound
    of their errors (of stiff contacts an estimate); ``found_by``: how it was found.
    """

    drive: Drive
    orbit: Motion
    residual: float
    multipliers: np.ndarray
    multiplier_error: float
    found_by: str
    section: Section = field(compare=False)

    def __repr__(self) -> str:
        size = f"period={self.period:.9g}, amplitude={self.amplitude:.9g}, multipliers={self.multipliers}"
        return f"Cycle({self.label.name}, {size}, found_by={self.found_by!r}, {self.drive})"

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
        """Sprag–slip if it sprags, stick–slip if a part sticks, else other; neutral if it is one of a family."""
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
        return named_events(self.drive, self.orbit)

    @cached_property
    def extremes(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest value of each coordinate and observable, in its SI unit, in closed form."""
        automaton, unit = self.orbit.automaton, np.eye(self.state.size + 1)
        found = {name: orbit_extremes(self.orbit, unit[i]) for i, name in enumerate(automaton.states)}
        return found | {name: orbit_extremes(self.orbit, automaton.functional(name)) for name in automaton.observables}

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
        taken, known = self.work, (name for name in ("attracting", "repelling", "neutral") if getattr(self, name))
        return {
            "label": self.label.name.lower(),
            "attracting": self.attracting,
            "stability": next(known, "not known"),  # no multipliers, as infinitely many events have no derivative
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
            "work": asdict(taken) | {"balance": taken.balance, "efficiency": _finite(taken.efficiency)},
        }

    def _events(self) -> list[dict[str, Any]]:
        """Events of a period without touches: time [s], and the impulses [N s, N m s] of those that are seizures."""
        impulses, seized = vars(self.impulses), np.isin(self.orbit.kind, self.orbit.automaton.sprag_kinds)
        found, names = [], iter(self.itinerary)
        for k in np.flatnonzero(self.orbit.kind != GRAZE_KIND):
            kind, mode = next(names)
            event: dict[str, Any] = {"event": kind, "mode": mode, "time": float(self.orbit.time[k])}
            if seized[k]:
                event |= {f"{name}_impulse": float(each[k]) for name, each in impulses.items()}
            found.append(event)
        return found


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _number(value: complex) -> float | list[float] | None:
    if not np.isfinite(value):
        return None
    return float(value.real) if value.imag == 0 else [float(value.real), float(value.imag)]


def named_events(drive: Drive, motion: Motion) -> tuple[tuple[str, str], ...]:
    """Return the events of a motion, (kind, mode that is entered), without touches."""
    model, codes = model_of(drive), motion.automaton.codes[motion.mode]
    return tuple(
        (model.events(int(kind)).name.lower(), model.modes(int(code)).name.lower())
        for kind, code in zip(motion.kind, codes, strict=True)
        if kind != GRAZE_KIND
    )


def cycle_from(
    drive: Drive, automaton: Automaton, state: np.ndarray, mode: int, events: int, found_by: str
) -> Cycle | None:
    """Return the cycle near a start (n) in a mode, whose motion nearly has a period of so many events; None if none is.

    The section is chosen among its events as the attractors' is.
    """
    guess = follow(automaton, state, math.inf, mode=mode, max_events=2 * events)
    key = section_key(guess)
    if key is None or ACCUMULATION_KIND in guess.kind:
        return None
    watched = np.flatnonzero((guess.kind[:events] == key[0]) & (guess.mode[:events] == key[1]))
    if not watched.size:
        return None
    longest = 2.0 * float(guess.end_time)  # a return may take twice as long as it did
    section = Section(automaton, key, guess.after[watched[0]], size_of(guess), len(watched), longest)
    return cycle_on(drive, section, found_by)


def cycle_of(drive: Drive, steady: SteadyState) -> Cycle | None:
    """Return the cycle that a motion was found to end on, solved again; None for an equilibrium or a neutral family."""
    if steady.orbit is None or steady.label == Attractor.NEUTRAL_FAMILY:
        return None
    orbit = steady.orbit
    key = int(orbit.kind[-1]), int(orbit.end_mode)
    section = Section(orbit.automaton, key, steady.state, size_of(orbit), steady.returns, 2.0 * orbit.end_time)
    return cycle_on(drive, section, "start")


def cycle_on(drive: Drive, section: Section, found_by: str) -> Cycle | None:
    """Return the cycle near the origin of a section; None if Newton's method does not find one."""
    found = solve(section)
    if found is None:
        return None
    orbit, residual = found
    values, error = multipliers(section, orbit, residual)
    return Cycle(drive, orbit, residual, values, error, found_by, section)


def swing(drive: Drive) -> tuple[float, float]:
    """Return the sizes u [rad] and w [rad/s] of a swing of the screw under law −1 with the speed of the motor."""
    inertia = float(coefficients(drive).gamma[-1])
    return abs(drive.input_speed) * math.sqrt(inertia / drive.coupling_stiffness), abs(drive.input_speed)


def starts(drive: Drive) -> list[tuple[float, float]]:
    """Return starts (u [rad], w [rad/s]) next to steady sliding, at standstill, and far out on both sides."""
    u, w = swing(drive)
    still = -drive.input_speed
    standing = [(part * u, still) for part in (0.0, -0.5, 0.5)]
    return [(1e-3 * u, 0.0), (u, 0.0), (-u, 0.0), *standing, (10 * u, w), (-10 * u, -w)]


def random_starts(drive: Drive) -> list[np.ndarray]:
    """Return starts (n) around steady sliding, as a cycle may attract little of the states of a drive.

    They are drawn, the same in every run, from boxes of half to eight times what the bodies do in a swing with the
    speed of the motor, of the screw or, if that is faster, their own; the screw also by what twists its coupling.
    """
    (angle, rate), lever = swing(drive), drive.pitch_radius * math.tan(drive.lead_angle)
    sizes = [angle + abs(float(coefficients(drive).deflection)), rate]
    for part in drive.parts:
        # Compliant threads have no body of their own: it is the load's.
        inertia, stiffness = (getattr(drive, name) for name in ("mass", *PARTS[part])[-3:-1])
        along = lever if part == "threads" or BODIES[part].pushed == "contact" else 1.0
        sizes += [along * min(rate * math.sqrt(inertia / stiffness), angle), along * rate]
    draw = np.random.default_rng(0)
    boxes = 2.0 ** draw.uniform(-1.0, 3.0, (96, 1)) * sizes
    return list(seated_state(drive, 0.0, 0.0) + draw.uniform(-1.0, 1.0, boxes.shape) * boxes)


@dataclass(frozen=True)
class Search:
    """The ``cycles`` that a search found, attracting ones first; one of each neutral family; what was ``searched``.

    ``unresolved``: why the ends of some starts are not known.
    """

    cycles: tuple[Cycle, ...]
    families: tuple[SteadyState, ...]
    searched: str
    unresolved: tuple[Doubt, ...]


def search(drive: Drive, automaton: Automaton, states: Iterable[np.ndarray], known: Cycle | None = None) -> Search:
    """Search for cycles from ``states`` (n) and on the edges of basins between them; one may be known.

    Attractors that cannot be determined are left out. The attracting cycles come first, then by period.
    """
    found: list[Cycle] = []
    families: list[SteadyState] = []
    _add(found, known)
    endings: list[tuple[np.ndarray, SteadyState]] = []
    for state in states:
        # so that unresolved starts, however many, take less than twice the work of one
        lost = sum(steady.label == Attractor.UNRESOLVED for _, steady in endings)
        steady = steady_state(automaton, state, max_events=300_000 // (1 + lost) ** 2)
        endings.append((state, steady))
        if steady.label == Attractor.NEUTRAL_FAMILY:
            families = families or [steady]
        _add(found, cycle_of(drive, steady))
    doubts = tuple(steady.doubt for _, steady in endings if steady.doubt is not None)
    searched = f"motions from {len(endings)} starts"
    if doubts:
        verb = "is" if len(doubts) == 1 else "are"
        searched += f", of which {len(doubts)} {verb} unresolved ({'; '.join(sorted(set(doubts)))})"
    edges = list(edge_cycles(automaton, endings, lambda section: _on_edge(drive, section)))
    for cycle in edges:
        _add(found, cycle)
    hits = sum(cycle is not None for cycle in edges)
    searched += "; " + (_edges(len(edges), hits) if edges else "no two ended differently, so no edge was tracked")
    return Search(
        tuple(sorted(found, key=lambda cycle: (not cycle.attracting, cycle.period))), tuple(families), searched, doubts
    )


def _on_edge(drive: Drive, section: Section) -> Cycle | None:
    """Return the repelling cycle near the origin of a section, unless it is steady sliding, which lies on a surface."""
    cycle = cycle_on(drive, section, "edge of a basin")
    # size of a cycle, relative to the motion, that is steady sliding
    small = cycle is not None and np.abs(cycle.state / section.size).max() < 1e-5
    return cycle if cycle is not None and cycle.repelling and not small else None


def _edges(count: int, hits: int) -> str:
    if count == 1:
        return f"the edge between their two basins, with {'a' if hits else 'no'} cycle on it"
    return f"{count} edges between their basins, {hits} of them with a cycle on it"


def _add(found: list[Cycle], cycle: Cycle | None) -> None:
    if cycle is not None and not any(same_cycle(cycle, other) for other in found):
        found.append(cycle)


def same_cycle(one: Cycle, other: Cycle) -> bool:
    """Whether two cycles are the same: of one stability, with the same period and extremes to 1e-7."""
    if one.attracting != other.attracting or abs(one.period - other.period) > _SAME * one.period:
        return False
    ends = zip(one.extremes["angle_deviation"], other.extremes["angle_deviation"], strict=True)
    return all(abs(a - b) <= _SAME * (one.amplitude + other.amplitude) for a, b in ends)
