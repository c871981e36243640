"""Periodic motions of a system, attracting or repelling, and the search for all of them.

Cycles are solved by Newton's method on the exact Poincaré map (:mod:`lsvib.systems.section`). The search takes
attracting ones from starts, and repelling ones from the edges between what the starts end on
(:mod:`lsvib.systems.edge_tracking`). A search is no proof: what no start ends on stays unseen.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from lsvib.systems.attractor import Attractor, Doubt, SteadyState, cycle_label, orbit_extremes, steady_state
from lsvib.systems.automaton import Automaton, product
from lsvib.systems.edge_tracking import edge_cycles
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.systems.motion import Motion, follow
from lsvib.systems.section import Section, multipliers, section_key, size_of, solve

_SAME = 1e-7  # Two cycles of one stability that differ by less, relatively, are the same cycle.


@dataclass(frozen=True)
class Cycle:
    """A periodic motion.

    ``orbit``: one period from ``state`` (n) on a section; ``residual`` [1]: the change of the state over it, relative
    to the size of the motion; ``multipliers`` [1] (n − 1), complex, the largest first, and ``multiplier_error``, a
    bound of their errors (for stiff contacts an estimate); ``found_by``: how it was found (docs/cycles.md).

    >>> cycle = impact.steady_state("fly").cycle  # of lsvib.systems.System
    >>> cycle.attracting, f"{cycle.period:.6f} s", f"{cycle.leading:.6f}", cycle.itinerary
    (True, '6.283185 s', '0.584322', (('phase 0', 'fly'), ('x > 1', 'fly')))
    >>> [round(end, 6) for end in cycle.extremes["v"]]
    [-1.356586, 1.704323]
    """

    orbit: Motion
    residual: float
    multipliers: np.ndarray
    multiplier_error: float
    found_by: str
    section: Section = field(compare=False)

    def __repr__(self) -> str:
        size = f"period={self.period:.9g}, amplitude={self.amplitude:.9g}, multipliers={self.multipliers}"
        return f"Cycle({self.label.name}, {size}, found_by={self.found_by!r})"

    @property
    def state(self) -> np.ndarray:
        """State (n) [SI units] in which the period begins."""
        return self.orbit.start_state

    @property
    def period(self) -> float:
        """Period [s]."""
        return self.orbit.end_time

    @property
    def label(self) -> Attractor:
        """Sprag–slip if it has a seizure, stick–slip if a part sticks, else other; neutral if it is one of a family."""
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
        """Whether the largest multiplier lies on the unit circle, within its error; False if it does not exist."""
        return math.isfinite(self.leading) and not (self.attracting or self.repelling)

    @property
    def itinerary(self) -> tuple[tuple[str, str], ...]:
        """Events of a period, (kind, mode that is entered), without grazing; the last one ends the period."""
        orbit, own = self.orbit, self.orbit.kind != GRAZE_KIND
        return orbit.automaton.in_words(zip(orbit.kind[own], orbit.automaton.codes[orbit.mode[own]], strict=True))

    @cached_property
    def extremes(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest value [SI unit] of each coordinate and observable, by name, in closed form."""
        automaton, unit = self.orbit.automaton, np.eye(self.state.size + 1)
        found = {name: orbit_extremes(self.orbit, unit[i]) for i, name in enumerate(automaton.states)}
        return found | {name: orbit_extremes(self.orbit, automaton.functional(name)) for name in automaton.observables}

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak value of the first coordinate, u [rad] of a drive."""
        low, high = self.extremes[self.orbit.automaton.states[0]]
        return 0.5 * (high - low)

    @cached_property
    def means(self) -> dict[str, float]:
        """Means of the observables over a period [SI units], by name, without impulses."""
        names = list(self.orbit.automaton.observables)
        totals = observable_integrals(self.orbit, names).sum(axis=0)
        return dict(zip(names, (totals / self.period).tolist(), strict=True))

    def to_json_multipliers(self) -> list[float | list[float] | None]:
        """Return the multipliers as numbers, or as pairs of real and imaginary part; None if they do not exist."""
        found = [[value.real, value.imag] if value.imag else value.real for value in self.multipliers.tolist()]
        return [value if np.isfinite(value).all() else None for value in found]

    def multipliers_in_words(self) -> str:
        """Return the multipliers and the bound of their errors as text."""
        own = self.multipliers.tolist()
        found = (f"{x.real:.9g}{f' {x.imag:+.9g}i' if x.imag else ''}" if np.isfinite(x) else "none" for x in own)
        said = ", ".join(found) or "none"
        return f"{said} (± {self.multiplier_error:.1g})" if math.isfinite(self.multiplier_error) else said

    def to_json(self) -> dict[str, Any]:
        """Return what is known of the cycle, as plain numbers and names."""
        known = (name for name in ("attracting", "repelling", "neutral") if getattr(self, name))
        return {
            "attracting": self.attracting,
            "stability": next(known, "not known"),  # no multipliers, as infinitely many events have no derivative
            "period": self.period,
            "amplitude": self.amplitude,
            "multipliers": self.to_json_multipliers(),
            "multiplier_error": float(self.multiplier_error) if math.isfinite(self.multiplier_error) else None,
            "state": self.state.tolist(),
            "residual": self.residual,
            "found_by": self.found_by,
        }


def integrals(orbit: Motion, forms: Callable[[int], Iterable[np.ndarray]]) -> np.ndarray:
    """Return the integrals over time [s] (arcs, k) of quadratic forms by mode, over each arc of a motion."""
    flow, arcs = orbit.automaton.flow, zip(*orbit.arcs(), strict=True)
    return np.array([flow.integral(mode, start, float(time), [*forms(int(mode))]) for mode, start, _, time in arcs])


def observable_integrals(orbit: Motion, names: Sequence[str]) -> np.ndarray:
    """Return the integrals over time [s] (arcs, k) of observables by name, over each arc of a motion."""
    own, parts, one = orbit.automaton.observables, orbit.automaton.parts, np.eye(orbit.start_state.size + 1)[-1]

    def forms(mode: int) -> Iterator[np.ndarray]:
        for name in names:
            form = product(own[name][mode], one)
            yield np.stack([form, product(parts[name][mode], one)]) if name in parts else form

    return integrals(orbit, forms)


def cycle_from(automaton: Automaton, state: np.ndarray, mode: int, events: int, found_by: str) -> Cycle | None:
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
    return cycle_on(section, found_by)


def cycle_of(steady: SteadyState) -> Cycle | None:
    """Return the cycle that a motion was found to end on, solved again; None for an equilibrium or a neutral family."""
    if steady.orbit is None or steady.label == Attractor.NEUTRAL_FAMILY:
        return None
    orbit = steady.orbit
    key = int(orbit.kind[-1]), int(orbit.end_mode)
    section = Section(orbit.automaton, key, steady.state, size_of(orbit), steady.returns, 2.0 * orbit.end_time)
    return cycle_on(section, "start")


def cycle_on(section: Section, found_by: str) -> Cycle | None:
    """Return the cycle near the origin of a section; None if Newton's method does not find one."""
    found = solve(section)
    if found is None:
        return None
    orbit, residual = found
    values, error = multipliers(section, orbit, residual)
    return Cycle(orbit, residual, values, error, found_by, section)


@dataclass(frozen=True)
class Search:
    """The ``cycles`` that a search found, attracting ones first; one of each neutral family; what was ``searched``.

    ``unresolved``: why the ends of some starts are not known.
    """

    cycles: tuple[Cycle, ...]
    families: tuple[SteadyState, ...]
    searched: str
    unresolved: tuple[Doubt, ...]


def search(automaton: Automaton, states: Iterable[np.ndarray], known: Cycle | None = None) -> Search:
    """Search for cycles from ``states`` (n) and on the edges of basins between them; one may be known.

    Attractors that cannot be determined are left out. The attracting cycles come first, then by period.
    """
    endings: list[tuple[np.ndarray, SteadyState]] = []
    for state in states:
        # so that unresolved starts, however many, take less than twice the work of one
        lost = sum(steady.label == Attractor.UNRESOLVED for _, steady in endings)
        endings.append((state, steady_state(automaton, state, max_events=300_000 // (1 + lost) ** 2)))
    doubts = tuple(steady.doubt for _, steady in endings if steady.doubt is not None)
    searched = f"motions from {len(endings)} starts"
    if doubts:
        verb = "is" if len(doubts) == 1 else "are"
        searched += f", of which {len(doubts)} {verb} unresolved ({'; '.join(sorted(set(doubts)))})"
    edges = list(edge_cycles(automaton, endings, _on_edge))
    found: list[Cycle] = []
    for cycle in (known, *(cycle_of(steady) for _, steady in endings), *edges):
        if cycle is not None and not any(same_cycle(cycle, other) for other in found):
            found.append(cycle)
    found.sort(key=lambda cycle: (not cycle.attracting, cycle.period))
    families = tuple(steady for _, steady in endings if steady.label == Attractor.NEUTRAL_FAMILY)[:1]
    hits = sum(cycle is not None for cycle in edges)
    if not edges:
        searched += "; no two ended differently, so no edge was tracked"
    elif len(edges) == 1:
        searched += f"; the edge between their two basins, with {'a' if hits else 'no'} cycle on it"
    else:
        searched += f"; {len(edges)} edges between their basins, {hits} of them with a cycle on it"
    return Search(tuple(found), families, searched, doubts)


def _on_edge(section: Section) -> Cycle | None:
    """Return the repelling cycle near the origin of a section, unless it is the equilibrium at zero, on a surface."""
    cycle = cycle_on(section, "edge of a basin")
    # size of a cycle, relative to the motion, that is the equilibrium
    small = cycle is not None and np.abs(cycle.state / section.size).max() < 1e-5
    return cycle if cycle is not None and cycle.repelling and not small else None


def same_cycle(one: Cycle, other: Cycle) -> bool:
    """Whether two cycles are the same: of one stability, with the same period and extremes to 1e-7."""
    if one.attracting != other.attracting or abs(one.period - other.period) > _SAME * one.period:
        return False
    first = one.orbit.automaton.states[0]
    ends = zip(one.extremes[first], other.extremes[first], strict=True)
    return all(abs(a - b) <= _SAME * (one.amplitude + other.amplitude) for a, b in ends)
