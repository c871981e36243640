r"""Cycles over a parameter, by pseudo-arclength continuation of the fixed point of the Poincaré map, through folds.

The unknowns are the free coordinates y of a section (the others follow from its surfaces, which move with the parameter
p) and p itself. On  F(y, p) = P(y, p) − y = 0  the next point is sought where it meets the plane across the tangent at
the last one. p is counted by q, p = p_0 sinh q with its size p_0 at the start, so that steps are in relation far from
zero, and a branch does not depend on the range that is asked for. F_y = P′ − I is exact; F_p is a central difference,
which steers Newton's method and the tangent, but is no part of the residual F. At a *fold* the tangent has no part in
p; as p is stationary there its value is exact to rounding.

The motion decides on its own events, so that the itinerary may change from point to point; such changes, and folds, are
located by halving. Where a section is no longer met, another event of the last cycle takes its place; if none does, the
branch ends. Where an event appears the branch has a kink: there the step, not the tangent before it, gives the
direction.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from lsvib.dynamics.cycles import Cycle
from lsvib.dynamics.poincare_map import Section, derivative, multipliers, newton_step
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar
from lsvib.engine.kernels.layout import GRAZE_KIND
from lsvib.engine.motion import Motion, follow
from lsvib.errors import EngineError, InputError
from lsvib.models.drive import Drive

_SMALLEST = 1e-7  # step, in sizes of the parameter and of the motion
_CONVERGED = 1e-8  # a step of Newton's method after which one more is rounding only

Build = Callable[[float], tuple[Drive, Automaton]]


@dataclass(frozen=True)
class Change:
    """Something happens at a ``value`` [SI unit] of the parameter, at a length ``along`` [1] of the branch.

    ``kind`` is fold, itinerary, stability, or end; ``what`` says it in words.
    """

    kind: str
    value: float
    what: str
    along: float


@dataclass(frozen=True)
class BranchPoint:
    """A cycle of the branch at a ``value`` [SI unit] of the parameter; ``along``: length [1] from its start."""

    value: float
    cycle: Cycle
    along: float


@dataclass(frozen=True)
class CycleBranch:
    """A branch of cycles over a ``parameter``: its ``points`` in order, and the ``changes`` along it."""

    parameter: str
    points: tuple[BranchPoint, ...]
    changes: tuple[Change, ...]

    @property
    def folds(self) -> list[float]:
        """Values of the parameter [SI unit] at folds."""
        return [change.value for change in self.changes if change.kind == "fold"]


@dataclass(frozen=True)
class Solved:
    """A point of the branch: unknowns z = (y, q), its cycle, and the tangent."""

    z: np.ndarray
    cycle: Cycle
    tangent: np.ndarray


class BranchEquations:
    """The equations F(y, p) = 0 on a section of return of a cycle, whose surfaces move with the parameter p.

    y: its free coordinates, in sizes of the motion; ``scale`` p_0 of the parameter p = p_0 sinh q. Modes that are parts
    of one have one code; ``part`` says which of them.
    """

    def __init__(self, build: Build, cycle: Cycle, scale: float) -> None:
        own, size = cycle.section, cycle.section.size
        section = Section(own.automaton, own.key, cycle.state, size, own.returns, cycle.period, size)
        self.build, self.scale, self.size, self.free = build, scale, size, section.free
        self._rows, self._tied = section.rows, section.tied
        self.kind, self.code = own.key[0], own.automaton.codes[own.key[1]]
        self.part = int(np.sum(own.automaton.codes[: own.key[1]] == self.code))
        self.returns, self.longest = own.returns, cycle.period

    def place(self, state: np.ndarray) -> np.ndarray:
        """Return y (d) of a state (n)."""
        return np.asarray(state[self.free] / self.size[self.free])

    def state(self, automaton: Automaton, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the state (n) at y on the section of an automaton, and its derivative (n, d)."""
        rows = automaton.tables.surfaces[self._rows]
        state, slope = np.zeros(self.size.size), np.zeros((self.size.size, len(self.free)))
        state[self.free] = place * self.size[self.free]
        slope[self.free, range(len(self.free))] = self.size[self.free]
        if self._tied.size:
            tied = rows[:, self._tied]
            state[self._tied] = np.linalg.solve(tied, -(rows[:, :-1] @ state + rows[:, -1]))
            slope[self._tied] = np.linalg.solve(tied, -(rows[:, :-1] @ slope))
        return state, slope

    def value(self, z: np.ndarray) -> float:
        """The value of the parameter at a point (y, q)."""
        return self.scale * math.sinh(z[-1])

    def counted(self, value: float) -> float:
        """The q of a value of the parameter."""
        return math.asinh(value / self.scale)

    def at(self, z: np.ndarray) -> tuple[Drive, Section, Motion] | None:
        """The drive, the section and one return from a point (y, q); None where none comes back or no drive is."""
        try:
            drive, automaton = self.build(self.value(z))
            modes = np.flatnonzero(automaton.codes == self.code)
            if self.part >= modes.size:
                return None
            state, _ = self.state(automaton, z[:-1])
            key = self.kind, int(modes[self.part])
            section = Section(automaton, key, state, self.size, self.returns, self.longest)
            motion = section.come_back(state)
        except (EngineError, InputError):
            return None
        if motion is None or motion.time.size == 0 or motion.time[0] == 0.0:
            return None
        return drive, section, motion

    def slopes(self, z: np.ndarray, motion: Motion, last: np.ndarray | None = None) -> np.ndarray | None:
        """[F_y, F_p] (d, d + 1); F_p (d) as it was where it is given: it only steers."""
        d = z.size - 1
        if d == 0:
            return np.zeros((0, 1))
        _, along = self.state(motion.automaton, z[:-1])
        matrix = derivative(motion).matrix @ along
        inner = matrix[self.free] / self.size[self.free][:, None] - np.eye(d)
        if last is None:
            size = 1e-5  # step of the difference, in sizes of the parameter
            step, beside = np.eye(d + 1)[-1] * size, {0.0: self.place(motion.end_state)}
            for sign in (1.0, -1.0):
                there = self.at(z + sign * step)
                if there is not None and events_of(there[2]) == events_of(motion):  # else it is that of a kink
                    beside[sign] = self.place(there[2].end_state)
            if len(beside) == 1:
                return None
            low, high = min(beside), max(beside)
            last = (beside[high] - beside[low]) / ((high - low) * size)
        found = np.column_stack([inner, last])
        return found if np.isfinite(found).all() else None

    def corrected(self, guess: np.ndarray, tangent: np.ndarray) -> Solved | None:
        """The point of the branch in the plane through ``guess`` across ``tangent``, with its tangent."""
        slopes: np.ndarray | None = None
        z, last, length, events = guess.copy(), math.inf, math.inf, None
        for _ in range(30):  # steps; where the derivative jumps as an event appears they converge slowly at first
            found = self.at(z)
            if found is None:
                return None
            gap = self.place(found[2].end_state) - z[:-1]
            same = events == events_of(found[2])
            slopes = self.slopes(z, found[2], None if slopes is None or not same else slopes[:, -1])
            events = events_of(found[2])
            if slopes is None:
                return None
            # for F = 0 in the plane across the tangent
            step = newton_step(np.vstack([slopes, tangent]), -np.append(gap, tangent @ (z - guess)))
            if step is None:
                return None
            length = float(np.abs(step).max(initial=0.0))
            if length <= 4 * flow_planar.EPS or (last <= _CONVERGED and length >= 0.5 * last):
                break
            # size of a step of Newton's method, in sizes of the motion, beyond which it has left the branch
            if length > 1.0:
                return None
            z, last = z + step, length
        found = self.at(z)
        if found is None or slopes is None or not length <= _CONVERGED:
            return None
        slopes = self.slopes(z, found[2], slopes[:, -1])
        if slopes is None:
            return None
        drive, section, motion = found
        residual = float(np.max(np.abs(motion.end_state - motion.start_state) / section.size))
        values, error = multipliers(section, motion, residual)
        if not residual <= 1e-12 * max(1.0, float(np.abs(values).max(initial=0.0))):  # rounding, as neighbours grow
            return None
        ahead = null_direction(slopes)
        if ahead @ tangent < 0:
            ahead = -ahead
        cycle = Cycle(drive, motion, residual, values, error, "continuation", section)
        return Solved(z, cycle, ahead)


def events_of(motion: Motion) -> tuple[list[int], list[int]]:
    """Kinds of a motion's events and codes of the modes that they enter, without touches."""
    own = motion.kind != GRAZE_KIND
    return motion.kind[own].tolist(), motion.automaton.codes[motion.mode[own]].tolist()


def null_direction(slopes: np.ndarray) -> np.ndarray:
    """Unit vector that the slopes (d, d + 1) take to zero."""
    if not len(slopes):
        return np.ones(1)
    return np.asarray(np.linalg.svd(slopes)[2][-1])


def follow_cycle(
    cycle: Cycle, build: Build, parameter: str, span: tuple[float, float], most: int = 1000
) -> CycleBranch:
    """Follow a cycle over a parameter, both ways from where it is, as far as it goes within ``span``.

    Arguments: the cycle, of the drive with the parameter at its own value; ``build`` makes drive and automaton at
    another value; ``most`` points each way. Raises ``InputError`` if the cycle cannot be followed at all.
    """
    down, below = _followed(cycle, build, parameter, span, -1.0, most)
    up, above = _followed(cycle, build, parameter, span, 1.0, most)
    points = [replace(point, along=-point.along) for point in reversed(down[1:])]
    changes = [replace(change, along=-change.along) for change in reversed(below)]
    return CycleBranch(parameter, (*points, *up), (*changes, *above))


def _followed(
    cycle: Cycle, build: Build, parameter: str, span: tuple[float, float], direction: float, most: int
) -> tuple[list[BranchPoint], list[Change]]:
    """Points and changes of the branch that begins with the parameter growing or falling."""
    low, high = span
    start = float(getattr(cycle.drive, parameter))
    curve = BranchEquations(build, cycle, abs(start) or max(-low, high))
    here = _first(curve, cycle, start, direction)
    if isinstance(here, str):
        raise InputError(f"the cycle at {parameter} = {start:g} cannot be followed: {here}.")
    points: list[BranchPoint] = [BranchPoint(start, here.cycle, 0.0)]
    changes: list[Change] = []
    along, step = 0.0, 1e-2
    while len(points) < most:
        there, curve, here, taken = _next(curve, here, step)
        if there is None:
            value, what = _end(curve, here, cycle, start)
            changes.append(Change("end", value, what, along))
            break
        value = curve.value(there.z)
        if not low <= value <= high:
            edge = _at_value(curve, here, there, low if value < low else high)
            if edge is not None:
                changes += changes_between(curve, here, edge, taken, along)
                points.append(BranchPoint(curve.value(edge.z), edge.cycle, along + taken))
            changes.append(Change("end", low if value < low else high, "the range ends", along + taken))
            break
        changes += changes_between(curve, here, there, taken, along)
        along += taken
        points.append(BranchPoint(value, there.cycle, along))
        # A step that was taken whole makes the next one longer, up to a 25th of the range or of the motion.
        step = min(step * 1.5, 4e-2) if taken >= step else max(taken, _SMALLEST)
        here = there
    else:
        changes.append(Change("end", points[-1].value, "the branch is longer than the number of points", along))
    return points, changes


def _first(curve: BranchEquations, cycle: Cycle, start: float, direction: float) -> Solved | str:
    """The first point of a branch, or why there is none, as the end of a sentence."""
    z = np.append(curve.place(cycle.state), curve.counted(start))
    found = curve.at(z)
    if found is None:
        return "its motion does not come back"
    slopes = curve.slopes(z, found[2])
    if slopes is None:
        return "its return map has no derivative"
    tangent = null_direction(slopes)
    return Solved(z, cycle, tangent * direction if tangent[-1] >= 0 else -tangent * direction)


def _next(curve: BranchEquations, here: Solved, step: float) -> tuple[Solved | None, BranchEquations, Solved, float]:
    """The next point, on this section or another of the cycle; also the curve, the last point on it, the step taken."""
    for other, again in _places(curve, here):
        # Beyond a kink the branch may turn by more than a right angle, though the parameter goes on: step along it.
        along = np.eye(again.z.size)[-1] * math.copysign(1.0, again.tangent[-1])
        for start in (again, replace(again, tangent=along)):
            there, taken = _stepped(other, start, step)
            if there is not None:
                return there, other, start, taken
    return None, curve, here, 0.0


def _places(curve: BranchEquations, here: Solved) -> Iterator[tuple[BranchEquations, Solved]]:
    """Yield the same point on this section and on the others of the cycle."""
    yield curve, here
    for cycle in other_sections(here.cycle):
        other = BranchEquations(curve.build, cycle, curve.scale)
        again = _first(other, cycle, curve.value(here.z), 1.0)
        if isinstance(again, Solved):
            turned = again.tangent[-1] * here.tangent[-1] < 0
            yield other, replace(again, tangent=-again.tangent) if turned else again


def _end(curve: BranchEquations, here: Solved, first: Cycle, start: float) -> tuple[float, str]:
    """Where a branch ends after its last point ``here``, a value of the parameter, and what is known of why.

    Where it goes on from one state alone, as a slip that begins at rest does, it is the last place at which that slip
    comes back; else a place that is rounded to what is known of it.
    """
    value = curve.value(here.z)
    # amplitude, relative to that at the start, of a cycle that is about to vanish; it does so in proportion
    if here.cycle.amplitude < 1e-4 * first.amplitude:
        return _rounded(value, 1e-4 * abs(value - start)), "it shrinks to nothing"
    what = "no further cycle is found"
    for other, again in _places(curve, here):
        if _rests(again.cycle.orbit) and _slips_on(other, again):
            what = "its slip no longer comes to rest"
        if again.z.size == 1:
            low, high = 0.0, 2 * _SMALLEST
            while low < (middle := 0.5 * (low + high)) < high:
                comes_back = other.corrected(again.z + middle * again.tangent, again.tangent) is not None
                low, high = (middle, high) if comes_back else (low, middle)
            return other.value(again.z + low * again.tangent), what
    return _rounded(value, 2 * _SMALLEST * math.hypot(curve.scale, value)), what


def _rounded(value: float, error: float) -> float:
    return round(value, -math.floor(math.log10(error))) if error > 0 else value


def _rests(motion: Motion) -> bool:
    return bool(np.isin(motion.automaton.codes[motion.mode], motion.automaton.rest_codes).any())


def _slips_on(curve: BranchEquations, here: Solved) -> bool:
    """Whether a motion just beyond the end of a branch of cycles with rest comes to rest no more."""
    z = here.z + 10 * _SMALLEST * here.tangent
    try:
        _, automaton = curve.build(curve.value(z))
        mode = int(np.flatnonzero(automaton.codes == curve.code)[curve.part])
        state, _ = curve.state(automaton, z[:-1])
        motion = follow(automaton, state, 10 * here.cycle.period, mode=mode)
    except (EngineError, InputError, IndexError):
        return False
    starts_at_rest = curve.code in automaton.rest_codes
    return not _rests(motion) and (motion.time.size > 0 or not starts_at_rest)


def _stepped(curve: BranchEquations, here: Solved, step: float) -> tuple[Solved | None, float]:
    while step >= _SMALLEST:
        there = curve.corrected(here.z + step * here.tangent, here.tangent)
        if there is not None:
            turned = there.tangent @ (there.z - here.z) < 0  # across a kink the tangents tell no direction
            there = replace(there, tangent=-there.tangent) if turned else there
            kink = events_of(there.cycle.orbit) != events_of(here.cycle.orbit)
            # smallest cosine between tangents: beyond it the step was too long
            if there.tangent @ here.tangent >= (-1.0 if kink else 0.2):
                return there, step
        step *= 0.5
    return None, 0.0


def other_sections(cycle: Cycle) -> Iterator[Cycle]:
    """Yield the same cycle, begun at other events of it."""
    orbit, seen = cycle.orbit, {cycle.section.key}
    for k in range(orbit.time.size):
        key = int(orbit.kind[k]), int(orbit.mode[k])
        if key in seen or key[0] == GRAZE_KIND:
            continue
        seen.add(key)
        returns = int(np.sum((orbit.kind == key[0]) & (orbit.mode == key[1])))
        section = Section(orbit.automaton, key, orbit.after[k], cycle.section.size, returns, 2 * cycle.period)
        motion = section.come_back(orbit.after[k])
        if motion is not None:
            yield replace(cycle, orbit=motion, section=section)


def _at_value(curve: BranchEquations, here: Solved, there: Solved, value: float) -> Solved | None:
    target = curve.counted(value)
    part = (target - here.z[-1]) / (there.z[-1] - here.z[-1])
    guess = here.z + part * (there.z - here.z)
    guess[-1] = target
    edge = curve.corrected(guess, np.eye(guess.size)[-1])
    if edge is not None and edge.tangent @ there.tangent < 0:
        return replace(edge, tangent=-edge.tangent)
    return edge


def changes_between(curve: BranchEquations, here: Solved, there: Solved, step: float, along: float) -> list[Change]:
    """Folds, changes of the itinerary and of stability between two points."""
    found = []
    fold = here.tangent[-1] * there.tangent[-1] < 0
    if fold:
        at, point = _halved(curve, here, step, lambda solved: bool(solved.tangent[-1] * here.tangent[-1] > 0))
        found.append(Change("fold", curve.value(point.z), "two cycles meet", along + at))
    before, after = Counter(here.cycle.itinerary), Counter(there.cycle.itinerary)
    if here.cycle.itinerary != there.cycle.itinerary and before != after:
        at, point = _halved(curve, here, step, lambda solved: Counter(solved.cycle.itinerary) == before)
        lost, gained = before - after, after - before
        words = [f"{verb} {_named(events)}" for verb, events in (("loses", lost), ("gains", gained)) if events]
        found.append(Change("itinerary", curve.value(point.z), " and ".join(words), along + at))
    outside = _outside(here.cycle)
    if not fold and outside != _outside(there.cycle) and not found:
        at, point = _halved(curve, here, step, lambda solved: _outside(solved.cycle) == outside)
        leading = point.cycle.multipliers[0]
        what = "a pair of multipliers" if leading.imag else f"a multiplier {'+1' if leading.real > 0 else '−1'}"
        found.append(Change("stability", curve.value(point.z), f"{what} passes the unit circle", along + at))
    return found


def _named(events: Counter[tuple[str, str]]) -> str:
    return ", ".join(f"{kind.replace('_', ' ')} into {mode.replace('_', ' ')}" for kind, mode in sorted(events))


def _outside(cycle: Cycle) -> int:
    return int(np.sum(np.abs(cycle.multipliers) > 1))


def _halved(curve: BranchEquations, here: Solved, step: float, holds: Callable[[Solved], bool]) -> tuple[float, Solved]:
    """The last place within a step at which a condition holds, to rounding; nearly that where points are missing."""
    low, high, point = 0.0, step, here
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        solved = curve.corrected(here.z + middle * here.tangent, here.tangent)
        if solved is not None and holds(solved):
            low, point = middle, solved
        else:
            high = middle
    return low, point
