"""Periodic motions of a drive of any model, attracting or repelling, and the search for all of them.

Cycles are solved by Newton's method on the exact Poincaré map (:mod:`lsvib.dynamics.poincare_map`). The search takes
attracting ones from starts, and repelling ones where return maps cross the diagonal. Every cycle without rest of a
drive with two states meets Q = 0 or θ′ = 0, because within a mode only steady sliding lasts; with rest it is
superstable, hence reached from starts. So the return maps of these two lines are searched for P(y) = y: their
displacement P(y) − y is sampled in both directions over seven decades, and closer and closer towards the places beyond
which motions do not come back. A change of sign is a cycle or a jump; an extremum on the side of zero is narrowed down
first, since two cycles that are about to meet lie on either side of it. Of drives with four states the edges between
what the starts end on are followed instead (:mod:`lsvib.dynamics.edge_tracking`). A search is no proof: what a map does
between two samples without an extremum that shows stays unseen.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, cycle_label, orbit_extremes, steady_state
from lsvib.dynamics.edge_tracking import edge_cycles
from lsvib.dynamics.energy import Work, means, work
from lsvib.dynamics.impulses import Impulses, event_impulses
from lsvib.dynamics.poincare_map import Section, lines, multipliers, nearest_to_origin, section_key, size_of, solve
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND, TIME_SCALE, TaylorFlow
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import EngineError
from lsvib.models.drive import PARTS, Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.mechanism import seated_state
from lsvib.models.model import model_of
from lsvib.models.names import BODIES

_HALVINGS = 60  # of a bracket in which Newton's method fails: to the last bit
_SAME = 1e-7  # Two cycles of one stability that differ by less, relatively, are the same cycle.
_WORK_OF_LINES = 4_000_000  # in events, on all lines: a minute under a friction law
_ROUNDED = 1e-12  # of P(y) − y under a law, in sizes of a swing of the screw


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
    """Return starts (n) around steady sliding of a drive with parts, whose cycles may attract little of its states.

    They are drawn, the same in every run, from boxes of half to eight times what the bodies do in a swing with the
    speed of the motor, of the screw or, if that is faster, their own; the screw also by what twists its coupling.
    """
    if not drive.parts:
        return []
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
    """Search for cycles from ``states`` (n), on the lines (two states) and on edges of basins (more); one may be known.

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
    if len(automaton.states) > 2:
        edges = list(edge_cycles(automaton, endings, lambda section: _on_edge(drive, section)))
        for cycle in edges:
            _add(found, cycle)
        hits = sum(cycle is not None for cycle in edges)
        searched += "; " + (_edges(len(edges), hits) if edges else "no two ended differently, so no edge was tracked")
    elif not automaton.contracts and Doubt.WORK_BUDGET not in doubts:
        found_lines, budget = lines(automaton), Budget(_WORK_OF_LINES)
        for key, line in found_lines.items():
            for cycle in _on_line(drive, automaton, key, line, budget):
                _add(found, cycle)
        cut = ", in part, as they take more work than is allowed" if budget.left <= 0 else ""
        searched += f"; return maps of {len(found_lines)} lines over seven decades on both sides{cut}"
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


def slowest(automaton: Automaton) -> float:
    """Return the longest time scale [s] of the oscillators of an automaton with two states."""
    flow = automaton.tables.flow
    if isinstance(flow, TaylorFlow):  # without friction
        stiff = np.abs(flow.field[:, 1, 0])
        return float(1 / math.sqrt(stiff[stiff > 0].min()))
    rows = flow if isinstance(flow, np.ndarray) else flow.oscillators
    return float(rows[..., TIME_SCALE].max())


def _on_line(
    drive: Drive, automaton: Automaton, key: tuple[int, int], row: np.ndarray, budget: Budget
) -> Iterator[Cycle]:
    """Yield the cycles that the return map of a line shows."""
    sizes = np.array(swing(drive))
    middle = nearest_to_origin(np.append(row[:2] * sizes, row[2]))  # in these sizes
    if middle is None:
        return
    # A return may take 200 turns of the slowest oscillator, under a friction law, where a turn costs more, 20.
    longest = (20.0 if isinstance(automaton.tables.flow, TaylorFlow) else 200.0) * slowest(automaton)
    section = Section(automaton, key, middle * sizes, sizes, 1, longest, sizes, row, budget)
    # Lines are searched from 10^-4 to 10^3 of the size of a swing of the screw.
    steps = np.logspace(-4.0, 3.0, 160)  # on each side of a line: each lies a tenth farther out than the one before
    coarse = np.concatenate([-steps[::-1], [0.0], steps])
    places = _to_edges(section, coarse, [_gap(section, y) for y in coarse])
    gaps = [_gap(section, y) for y in places]
    brackets = []
    for k in range(len(places) - 1):
        here, after = gaps[k], gaps[k + 1]
        if here * after <= 0:
            brackets.append((places[k], places[k + 1]))
        elif k > 0 and gaps[k - 1] * here > 0 and here * after > 0 and abs(here) <= min(abs(gaps[k - 1]), abs(after)):
            nearest = _extremum(section, places[k - 1], places[k + 1], math.copysign(1.0, here))
            if _gap(section, nearest) * here <= 0:
                brackets += [(places[k - 1], nearest), (nearest, places[k + 1])]
    for low, high in brackets:
        cycle = _within(drive, section, low, high)
        if cycle is not None and not _of_rounding(cycle):
            yield cycle


def _of_rounding(cycle: Cycle) -> bool:
    """Whether rounding alone may make P(y) − y change its sign at a cycle of a drive with a friction law.

    There motions are rounded as steady sliding is: what a turn gains or loses has to be more than that.
    """
    if not isinstance(cycle.orbit.automaton.tables.flow, TaylorFlow) or cycle.multipliers.size == 0:
        return False
    away = abs(abs(cycle.multipliers[0]) - 1) * float(np.abs(cycle.state / cycle.section.size).max())
    return not (cycle.attracting or cycle.repelling) or away < _ROUNDED


def _to_edges(section: Section, places: np.ndarray, gaps: list[float]) -> np.ndarray:
    """Add places towards both ends of each stretch of places from which motions come back."""
    more = [places]
    for k in range(len(places) - 1):
        if math.isfinite(gaps[k]) == math.isfinite(gaps[k + 1]):
            continue
        inside, outside = (places[k], places[k + 1]) if math.isfinite(gaps[k]) else (places[k + 1], places[k])
        first = inside
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if math.isfinite(_gap(section, middle)) else (inside, middle)
        # Close to an end return maps bend, so samples go down to a millionth.
        more.append(inside + (first - inside) * np.append(0.7 ** np.arange(1, 40), 0.0))
    return np.unique(np.concatenate(more))


def _gap(section: Section, place: float) -> float:
    """P(y) − y; nan if the motion does not come back, or leaves at once."""
    motion = section.come_back(section.state(np.array([place])))
    if motion is None or motion.time[0] == 0.0:
        return math.nan
    return float(section.place(motion.end_state)[0] - place)


def _extremum(section: Section, low: float, high: float, sign: float) -> float:
    """Place between two others at which ``sign`` × (P(y) − y) is smallest, or the first at which it is negative."""

    def height(place: float) -> float:
        value = sign * _gap(section, place)
        return value if math.isfinite(value) else math.inf

    golden = 0.5 * (3 - math.sqrt(5))
    left, right = low + golden * (high - low), high - golden * (high - low)
    at_left, at_right = height(left), height(right)
    for _ in range(60):  # steps of the golden section, which leave 1e-12 of the bracket
        if min(at_left, at_right) < 0:
            break
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = low + golden * (high - low)
            at_left = height(left)
        else:
            low, left, at_left = left, right, at_right
            right = high - golden * (high - low)
            at_right = height(right)
    return left if at_left < at_right else right


def _within(drive: Drive, section: Section, low: float, high: float) -> Cycle | None:
    """Return the cycle in a bracket where P(y) − y changes its sign; Newton's method starts from ever smaller ones."""
    first = _gap(section, low)
    width = high - low
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        try:
            state, line = section.state(np.array([middle])), section.line
            there = Section(
                section.automaton, section.key, state, section.size, 1, section.longest, section.size, line,
                section.budget,
            )  # fmt: skip
            cycle = cycle_on(drive, there, "return map")
        except EngineError:
            cycle = None
        if cycle is not None:
            place = float(section.place(cycle.state)[0])
            if low - 1e-9 * width <= place <= high + 1e-9 * width:  # its place is rounded
                return cycle
        here = _gap(section, middle)
        if not math.isfinite(here):
            return None
        low, high = (middle, high) if here * first > 0 else (low, middle)
    return None
