"""All cycles that a search finds: attracting ones from starts, repelling ones where return maps cross the diagonal.

Every cycle without rest of a drive with two states meets Q = 0 or θ′ = 0, because within a mode only steady sliding
lasts; with rest it is superstable, hence reached from starts. So the return maps of these two lines are searched for
P(y) = y: their displacement P(y) − y is sampled in both directions over seven decades, and closer and closer towards
the places beyond which motions do not come back. A change of sign is a cycle or a jump; an extremum on the side of zero
is narrowed down first, since two cycles that are about to meet lie on either side of it. Cycles are then solved by
Newton's method. Of drives with four states the edges between what the starts end on are followed instead
(:mod:`lsvib.dynamics.edge_tracking`). A search is no proof: what a map does between two samples without an extremum that shows
stays unseen.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from lsvib.dynamics.attractor import Attractor, SteadyState, steady_state
from lsvib.dynamics.cycles import Cycle, cycle_from, cycle_of, cycle_on
from lsvib.dynamics.edge_tracking import edge_cycles
from lsvib.dynamics.poincare_map import Section, lines, nearest_to_origin
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import layout
from lsvib.errors import EngineError
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients

_DECADES = (-4.0, 3.0)  # Lines are searched from 10^-4 to 10^3 of the size of a swing of the screw.
_SAMPLES = 160  # on each side of a line: each lies a tenth farther out than the one before
_GOLDEN = 0.3819660112501051  # (3 − √5) / 2
_NARROW = 60  # steps of the golden section, which leave 1e-12 of the bracket
_HALVINGS = 60  # of a bracket in which Newton's method fails: to the last bit
_CLOSER = np.append(
    0.7 ** np.arange(1, 40), 0.0
)  # Close to an end return maps bend, so samples go down to a millionth.
_BEYOND = 1e-9  # part of a bracket by which a cycle may lie beyond it, for the rounding of its place
_SAME = 1e-7  # Two cycles of one stability that differ by less, relatively, are the same cycle.
_MOST, _LESS = 300_000, 30_000  # work for a start, and for one after another could not be told to its end
_SWINGS = 200.0  # turns of the slowest oscillator that a return may take


@dataclass(frozen=True)
class Seed:
    """A start that is nearly periodic: state (n), mode, number of events of a period, and where it is from."""

    state: np.ndarray
    mode: int
    events: int
    found_by: str


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


@dataclass(frozen=True)
class Search:
    """The ``cycles`` that a search found, attracting ones first; one of each neutral family; what was ``searched``."""

    cycles: tuple[Cycle, ...]
    families: tuple[SteadyState, ...]
    searched: str


def search(
    drive: Drive,
    automaton: Automaton,
    states: Iterable[np.ndarray],
    seeds: Sequence[Seed] = (),
) -> Search:
    """Search for cycles from seeds, from ``states`` (n), on the lines (two states) and on edges of basins (more).

    Attractors that cannot be determined are left out. The attracting cycles come first, then by period.
    """
    found: list[Cycle] = []
    families: list[SteadyState] = []
    for seed in seeds:
        _add(found, cycle_from(drive, automaton, seed.state, seed.mode, seed.events, seed.found_by))
    endings: list[tuple[np.ndarray, SteadyState]] = []
    for state in states:
        lost = any(steady.label == Attractor.UNRESOLVED for _, steady in endings)
        steady = steady_state(automaton, state, max_events=_LESS if lost else _MOST)
        endings.append((state, steady))
        if steady.label == Attractor.NEUTRAL_FAMILY:
            families = families or [steady]
        _add(found, cycle_of(drive, steady))
    unresolved = sum(steady.label == Attractor.UNRESOLVED for _, steady in endings)
    searched = f"motions from {len(endings)} starts"
    searched += f", of which {unresolved} are unresolved" if unresolved else ""
    if len(automaton.states) > 2:
        edges = list(edge_cycles(drive, automaton, endings))
        for cycle in edges:
            _add(found, cycle)
        hits = sum(cycle is not None for cycle in edges)
        searched += "; " + (_edges(len(edges), hits) if edges else "no two ended differently, so no edge was tracked")
    elif not automaton.contracts:
        found_lines = lines(automaton)
        for key, line in found_lines.items():
            for cycle in _on_line(drive, automaton, key, line):
                _add(found, cycle)
        searched += f"; return maps of {len(found_lines)} lines over seven decades on both sides"
    return Search(
        tuple(sorted(found, key=lambda cycle: (not cycle.attracting, cycle.period))), tuple(families), searched
    )


def _edges(count: int, hits: int) -> str:
    if count == 1:
        return f"the edge between their two basins, with {'a' if hits else 'no'} cycle on it"
    return f"{count} edges between their basins, {hits} of them with a cycle on it"


def _add(found: list[Cycle], cycle: Cycle | None) -> None:
    if cycle is not None and not any(_same(cycle, other) for other in found):
        found.append(cycle)


def _same(one: Cycle, other: Cycle) -> bool:
    if one.attracting != other.attracting or abs(one.period - other.period) > _SAME * one.period:
        return False
    ends = zip(one.extremes["angle_deviation"], other.extremes["angle_deviation"], strict=True)
    return all(abs(a - b) <= _SAME * (one.amplitude + other.amplitude) for a, b in ends)


def _on_line(drive: Drive, automaton: Automaton, key: tuple[int, int], row: np.ndarray):
    """Yield the cycles that the return map of a line shows."""
    sizes = np.array(swing(drive))
    middle = nearest_to_origin(np.append(row[:2] * sizes, row[2]))  # in these sizes
    if middle is None:
        return
    section = Section(automaton, key, middle * sizes, sizes, 1, _patience(automaton))
    if section.dimension != 1:
        return
    steps = np.logspace(*_DECADES, _SAMPLES)
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
        if cycle is not None:
            yield cycle


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
        more.append(inside + (first - inside) * _CLOSER)
    return np.unique(np.concatenate(more))


def _patience(automaton: Automaton) -> float:
    """Longest time [s] that a return may take."""
    scales = automaton.tables.flow[:, layout.TIME_SCALE]
    return _SWINGS * float(scales.max())


def _gap(section: Section, place: float) -> float:
    """P(y) − y; nan if there is no return."""
    return float(section.excess(np.array([place]))[0])


def _extremum(section: Section, low: float, high: float, sign: float) -> float:
    """Place between two others at which ``sign`` × (P(y) − y) is smallest, or the first at which it is negative."""

    def height(place: float) -> float:
        value = sign * _gap(section, place)
        return value if math.isfinite(value) else math.inf

    left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    at_left, at_right = height(left), height(right)
    for _ in range(_NARROW):
        if min(at_left, at_right) < 0:
            break
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = low + _GOLDEN * (high - low)
            at_left = height(left)
        else:
            low, left, at_left = left, right, at_right
            right = high - _GOLDEN * (high - low)
            at_right = height(right)
    return left if at_left < at_right else right


def _within(drive: Drive, section: Section, low: float, high: float) -> Cycle | None:
    """Return the cycle in a bracket where P(y) − y changes its sign; Newton's method starts from ever smaller ones."""
    first = _gap(section, low)
    width = high - low
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        try:
            state, patience = section.state(np.array([middle])), _patience(section.automaton)
            there = Section(section.automaton, section.key, state, section.size, 1, patience)
            cycle = cycle_on(drive, there, "return map")
        except EngineError:
            cycle = None
        if cycle is not None:
            place = float(section.place(cycle.state)[0])
            if low - _BEYOND * width <= place <= high + _BEYOND * width:
                return cycle
        here = _gap(section, middle)
        if not math.isfinite(here):
            return None
        low, high = (middle, high) if here * first > 0 else (low, middle)
    return None
