r"""Cycles over a parameter: a chain of smooth pieces, through folds and borders, by pseudo-arclength continuation.

docs/cycles.md says what pieces, folds and borders are. The next point of a piece is sought by Newton's method in the
plane across the tangent at the last one (:mod:`lsvib.systems.shooting`); it has to have the same itinerary, and to lie
where the tangent points, else the step is halved. At a fold the tangent has no part in the parameter, whose value there
is exact to rounding, as it is stationary. Behind a border motions are tried from next to the last orbit, on either side
of the parameter; from those with other events Newton's method seeks a cycle, at three distances δ from the border: one
that comes nearer to the orbit as δ falls is the next piece.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lsvib.errors import EngineError, InputError
from lsvib.numbers import NotNumber, Progress, bisected, number, shown, whole_between
from lsvib.systems.cycles import Cycle, cycle_from, same_cycle
from lsvib.systems.kernels.saltation import crossed_guard
from lsvib.systems.section import AT_REST
from lsvib.systems.shooting import Build, Itinerary, Shooting, Shot, Solved, Units, alike, rate_of

_FIRST = 1e-2  # step of a piece, in sizes of the motion and of the parameter
_LONGEST = 2.5e-2
_SMALLEST = 1e-7  # steps of less that fail are at a border
_STEEP = 0.2  # part of the parameter in a tangent; where it has more no fold is near, and Newton's method keeps it
_TO_ROUNDING = 1e-16
_DISTANCES = (1e-4, 1e-6, 1e-8)  # δ from a border, in q
_NEARER = 0.3  # most that is left of the distance from the orbit where δ falls to its hundredth; its root leaves 0.1
_BACK = "it comes back to where it began"
_TOUCHES = 0.02  # next to a border: speed of a touch, as a part of the largest; arc that vanishes, of the period
_FLAT = 1e-10  # in q, by which rounding may turn a branch
_NOTHING = 1e-4  # extent of a cycle, in sizes of the motion, that is about to vanish


@dataclass(frozen=True)
class Change:
    """A change along a branch, at a ``value`` [SI unit] of the parameter and a length ``along`` [1] of the branch.

    ``kind``: fold, itinerary, stability, or end; ``what``: the change in words, as ``along`` grows; ``name``: that of
    the bifurcation (docs/systems.md), or empty.
    """

    kind: str
    value: float
    what: str
    along: float
    name: str = ""


@dataclass(frozen=True)
class BranchPoint:
    """A ``cycle`` of the branch at a ``value`` [SI unit] of the parameter; ``along``: length [1] from its start."""

    value: float
    cycle: Cycle
    along: float


@dataclass(frozen=True)
class CycleBranch:
    """A branch of cycles over a ``parameter`` (docs/cycles.md): its ``points`` in order, and its ``changes``.

    >>> branch = impact.follow(impact.steady_state("fly"), "r", (0.75, 0.85))  # of lsvib.systems.System
    >>> [(change.kind, change.value) for change in branch.changes], branch.points[0].cycle.attracting
    ([('end', 0.75), ('end', 0.85)], True)
    """

    parameter: str
    points: tuple[BranchPoint, ...] = field(repr=False)
    changes: tuple[Change, ...]
    system: str = field(default="", repr=False)  # keys of one's own, as JSON

    @property
    def folds(self) -> list[float]:
        """Values of the parameter [SI unit] at folds."""
        return [change.value for change in self.changes if change.kind == "fold"]


def follow_cycle(
    cycle: Cycle,
    build: Build,
    parameter: str,
    start: float,
    span: tuple[float, float],
    most: int,
    progress: Progress | None,
) -> CycleBranch:
    """Follow a cycle over a parameter, both ways from its own value ``start``, as far as it goes within ``span``.

    Arguments: ``build`` makes the automaton at a value, or raises ``InputError``; ``most`` points each way;
    ``progress`` is called with the number of points found, and ``most`` for a way that has ended, and with twice
    ``most``. Raises ``InputError`` if the cycle cannot be followed at all.
    """
    (low, below), (high, above) = (_allowed(build, start, end) for end in span)
    sizes = np.abs(cycle.orbit.at(cycle.period * np.linspace(0.0, 1.0, 200))[0]).max(axis=0)
    units = Units(build, np.where(sizes == 0, 1.0, sizes), cycle.period, abs(start) or max(-low, high), (low, high))
    down, up = (_Walk(units, (below, above), cycle, most, way) for way in (-1.0, 1.0))
    for walk, before in ((down, 0), (up, most)):
        if any(change.what == _BACK for change in down.changes):  # all of it is known
            up.points = down.points[:1]
            continue
        for found in walk.go(start):
            if progress is not None:
                progress(before + found, 2 * most)
    points = [replace(point, along=-point.along) for point in reversed(down.points[1:])]
    changes = [replace(change, along=-change.along) for change in reversed(down.changes)]
    return CycleBranch(parameter, (*points, *up.points), (*changes, *up.changes))


def span_of(owner: str, parameter: str, here: float, span: Any, points: Any) -> tuple[tuple[float, float], int]:
    """Return the ends of a span that holds the ``owner``'s own value, and the most points; raises ``InputError``."""
    try:
        low, high = (number(value) for value in span)
    except (NotNumber, TypeError, ValueError):
        raise InputError(f"span = {shown(span)} is not two numbers.") from None
    if not low < high or not low <= here <= high:
        raise InputError(f"span = {low:g}, {high:g} must ascend and contain the {owner}'s own {parameter} = {here:g}.")
    return (low, high), whole_between("points", points, 2, 100_000)  # more cycles would fill the memory


def _allowed(build: Build, start: float, end: float) -> tuple[float, str]:
    """The last value towards an end of the span at which there is a system, and what ends there, in words."""

    def refused(value: float) -> str:
        try:
            build(value)
        except (InputError, EngineError) as error:
            return f"the next value is not allowed: {error}"
        return ""

    if not refused(end):
        return end, "the range ends"
    last = bisected(lambda value: not refused(value), end, start)
    return last, refused(math.nextafter(last, end))


@dataclass
class _Walk:
    """The branch from its ``first`` cycle one ``way`` of the parameter (1 or −1); ``ends`` of the span, in words."""

    units: Units
    ends: tuple[str, str]
    first: Cycle
    most: int
    way: float
    points: list[BranchPoint] = field(default_factory=list)
    changes: list[Change] = field(default_factory=list)

    def go(self, start: float) -> Iterator[int]:
        """Follow the branch from a value to its end; yields the number of points as it grows, at last the most."""
        shooting = Shooting(self.units, self.first.orbit)
        here = shooting.here(self.first.period, start, np.array([0.0, self.way]))
        if here is None:
            raise InputError("the cycle cannot be followed: its return map has no derivative.")
        self.points.append(BranchPoint(start, self.first, 0.0))
        step = _FIRST
        there: Solved | None = here
        while there is not None and not self._ends(here):
            yield len(self.points)
            # no longer than a part of a cycle that shrinks
            there, step = _stepped(shooting, here, min(step, _LONGEST, 0.3 * _extent(shooting, here)))
            cycle = None if there is None else _cycle(there)
            if there is None or cycle is None:  # next to a graze, where neighbours grow, it may not close to rounding
                last, left = here, 2 * _SMALLEST if there is None else 0.0
                while left > _TO_ROUNDING:
                    left *= 0.5
                    found = _on_piece(shooting, last, left)
                    last = last if found is None else replace(found, tangent=here.tangent)
                there, step = self._behind(shooting, here, last), _FIRST
            elif not self._reached(shooting, here, there, cycle):
                there = None
            if there is not None:
                here = there
                if not shooting.centred(there):  # equations from the middle of another arc, if it has a tangent there
                    other = Shooting(self.units, there.motion)
                    again = other.here(there.motion.end_time, self.units.value(there.z), there.tangent)
                    shooting, here = (shooting, there) if again is None else (other, again)
        yield self.most

    def _ends(self, here: Solved) -> bool:
        """Whether the branch ends at a point that is noted: of the span, or the last that is allowed."""
        if len(self.points) >= self.most:
            self._change("end", here, "the number of points is used up")
        elif not self.units.holds(here.z[-1] + math.copysign(2 * AT_REST, here.tangent[-1])):
            self._change("end", here, self.ends[int(here.tangent[-1] > 0)])
        return bool(self.changes) and self.changes[-1].kind == "end"

    def _change(self, kind: str, at: Solved, what: str, further: float = 0.0, name: str = "") -> None:
        """Note a change at a point, so much further along than the last point."""
        self.changes.append(Change(kind, self.units.value(at.z), what, self.points[-1].along + further, name))

    def _reached(self, shooting: Shooting, here: Solved, there: Solved, cycle: Cycle) -> bool:
        """Note a point of the same piece and what changes on the way to it; returns whether the branch goes on."""
        turn, (before, now) = here, (_extent(shooting, one) for one in (here, there))
        if now < _NOTHING:
            gone = there.z + (now / (before - now) if before > now else 0.0) * (there.z - here.z)
            self._change("end", replace(there, z=gone), "it shrinks to nothing")
            return False
        if here.tangent[-1] * there.tangent[-1] < 0:
            turn = _halved(shooting, here, there, lambda other: other.tangent[-1] * here.tangent[-1] > 0)
        if turn is here:
            self._compare(shooting, here, there, cycle)
        elif (parts := _parts(shooting, turn)) > 1:
            part, name = ("half", "period doubling") if parts == 2 else (f"1/{parts} of", "")
            self._change("end", turn, f"it merges with the cycle of {part} its period", name=name)
            return False
        elif (turn.z[-1] - here.z[-1]) * (turn.z[-1] - there.z[-1]) > _FLAT**2:  # beyond both, and not by rounding
            self._change("fold", turn, "two cycles meet", float(np.linalg.norm(turn.z - here.z)), "fold")
        self._add(here, there, cycle)
        back = self._comes_back(shooting, here, there)
        if back:
            self._change("end", there, _BACK)
        return not back

    def _add(self, here: Solved, there: Solved, cycle: Cycle) -> None:
        along = self.points[-1].along + float(np.linalg.norm(there.z - here.z))
        self.points.append(BranchPoint(self.units.value(there.z), cycle, along))

    def _compare(self, shooting: Shooting, here: Solved, there: Solved, cycle: Cycle) -> None:
        """Note a change of stability between two points of a piece."""
        before = self.points[-1].cycle
        outside = _outside(before)
        if outside == _outside(cycle) or before.neutral or cycle.neutral:
            return
        point = _halved(shooting, here, there, lambda other: _outside(_cycle(other)) == outside)
        leading = (_cycle(point) or before).multipliers[0]
        what = "a pair of multipliers" if leading.imag else f"a multiplier {'+1' if leading.real > 0 else '−1'}"
        name = "Neimark–Sacker" if leading.imag else "" if leading.real > 0 else "period doubling"
        further = float(np.linalg.norm(point.z - here.z))
        self._change("stability", point, f"{what} crosses the unit circle", further, name)

    def _comes_back(self, shooting: Shooting, here: Solved, there: Solved) -> bool:
        """Whether the branch passes its first cycle between two points."""
        start = self.units.counted(self.points[0].value)
        part = (start - here.z[-1]) / (there.z[-1] - here.z[-1]) if there.z[-1] != here.z[-1] else 0.0
        if not 0.0 < part <= 1.0:
            return False
        again = shooting.fixed(np.append((here.z + part * (there.z - here.z))[:-1], start))
        cycle = None if again is None else _cycle(again)
        return cycle is not None and same_cycle(cycle, self.first)

    def _behind(self, shooting: Shooting, here: Solved, last: Solved) -> Solved | None:
        """Note a border, at the last point of a piece, and the first point behind it, or why there is none."""
        behind, nearest = _other(shooting, last)
        cycle, further = None if behind is None else _cycle(behind), float(np.linalg.norm(last.z - here.z))
        if behind is None or cycle is None:
            what, name = self._why(shooting, last, nearest)
            self._change("end", last, what, further, name)
            return None
        words = _in_words(last, behind) if self.way > 0 else _in_words(behind, last)
        name = _border(last, behind)
        if words:
            self._change("itinerary", last, words, further, name)
        if last.tangent[-1] * (behind.z[-1] - last.z[-1]) < 0:
            self._change("fold", last, "two cycles with different events meet", further, name)
        self._add(here, behind, cycle)
        return behind

    def _why(self, shooting: Shooting, last: Solved, nearest: Solved | None) -> tuple[str, str]:
        """Why no piece is found behind the last point of one, and the border's name; ``nearest``: a cycle there."""
        extent = _extent(shooting, last)
        if extent < 1e2 * _NOTHING:
            return f"it has shrunk to {100 * extent:.1g} % of the motion at its start; no further cycle is found", ""
        beyond = next(_otherwise(shooting, last), None)
        if beyond is None:
            return "no further cycle is found, by Newton's method or by motions from near its orbit", ""
        what = f"it {_in_words(last, beyond) or 'changes the order of its events'}"
        if last.rests and not beyond.rests:
            what = "it no longer comes to rest"
        if not alike(last.motion.automaton, beyond.motion.automaton):
            what += " as the system gets other modes"
        other = "" if nearest is None else f"; the nearest has a period of {nearest.motion.end_time:.9g} s"
        what += f", and no cycle of other events is found to close on its orbit{other}"
        return what, _border(last, beyond)


def _stepped(shooting: Shooting, here: Solved, step: float) -> tuple[Solved | None, float]:
    """The next point of a piece, not beyond the span, and the step to try from there; None at a border.

    Where the step fails it is halved, and then what is left of it, so that points soon come close to a border.
    """

    def taken(step: float) -> Solved | None:
        there = _on_piece(shooting, here, step)
        found = None if there is None else shooting.directed(there, there.z - here.z)
        return found if found is not None and found.tangent @ here.tangent >= 0.9 else None  # it turned too much

    there = taken(step)
    if there is not None:
        return there, 1.5 * step
    low, high = 0.0, step
    while high >= _SMALLEST and high - low > 0.2 * high:
        middle = 0.5 * (low + high)
        found = taken(middle)
        low, high, there = (low, middle, there) if found is None else (middle, high, found)
    return there, high - low


def _on_piece(shooting: Shooting, here: Solved, step: float) -> Solved | None:
    """The point of the piece a step ahead, or at the end of the span before it; None if it is not where that leads."""
    units, ahead = shooting.units, here.tangent
    guess = here.z + step * ahead
    across = None if abs(ahead[-1]) > _STEEP else ahead
    if not units.holds(guess[-1]):
        step, across = (units.counted(units.value(guess)) - here.z[-1]) / ahead[-1], None
        guess = here.z + step * ahead
    there = shooting.solved(guess, across, here.slope, here.itinerary)
    if there is None or there.itinerary != here.itinerary or shooting.across(there) < 0.5:  # the plane may soon miss it
        return None
    if np.linalg.norm(there.z - guess) > 0.25 * step + 1e-10:  # by which it may bend; rounding adds to small steps
        return None
    return replace(there, tangent=-there.tangent) if there.tangent @ ahead < 0 else there


def _halved(shooting: Shooting, here: Solved, there: Solved, holds: Callable[[Solved], bool]) -> Solved:
    """The last point on the way to another at which a condition holds, to a billionth of the way."""
    length = float(here.tangent @ (there.z - here.z))
    low, high, point = 0.0, length, here
    while high - low > 1e-9 * length:
        for part in (0.5, 0.4, 0.6):  # Newton's method may miss one of them by rounding
            middle = low + part * (high - low)
            found = _on_piece(shooting, here, middle)
            if found is not None:
                break
        low, high, point = (low, middle, point) if found is None or not holds(found) else (middle, high, found)
    return point


def _other(shooting: Shooting, last: Solved) -> tuple[Solved | None, Solved | None]:
    """The cycle of other events that closes on the orbit of the last cycle of a piece, and the nearest that does not.

    One with which the parameter goes on comes first.
    """
    onward, nearest, least = math.copysign(1.0, last.tangent[-1]), None, math.inf
    for sign in (onward, -onward):
        before: dict[Itinerary, float] = {}
        for distance in _DISTANCES:
            q, after = last.z[-1] + sign * distance, dict[Itinerary, float]()
            for there in _near(shooting, last, q, distance) if shooting.units.holds(q) else ():
                away = after[there.itinerary] = float(np.linalg.norm(there.z - last.z))
                if away <= _NEARER * before.get(there.itinerary, 0.0):
                    found = shooting.directed(there, np.array([0.0, sign]))  # away from the border
                    if found is not None:
                        return found, None
                if away < least:
                    nearest, least = there, away
            before = after
    return None, nearest


def _near(shooting: Shooting, last: Solved, q: float, distance: float) -> Iterator[Solved]:
    """Yield a cycle of each itinerary but the last one's that motions from around it lead to."""
    seen = {last.itinerary}
    for place in _around(shooting, last, q, distance):
        shot = shooting.at(place)
        if shot is None or shot.itinerary in seen:
            continue
        found = shooting.fixed(place)
        if found is not None and found.itinerary not in seen:
            seen.add(found.itinerary)
            yield found


def _otherwise(shooting: Shooting, last: Solved) -> Iterator[Shot]:
    """Yield motions of other events from around the last cycle of a piece, the nearest first."""
    onward = math.copysign(1.0, last.tangent[-1])
    for distance in reversed(_DISTANCES):
        for q in (last.z[-1] + onward * distance, last.z[-1] - onward * distance):
            for place in _around(shooting, last, q, distance) if shooting.units.holds(q) else ():
                shot = shooting.at(place, settled=True)
                if shot is not None and shot.itinerary != last.itinerary:
                    yield shot


def _around(shooting: Shooting, last: Solved, q: float, distance: float) -> Iterator[np.ndarray]:
    """Yield places at a value of the parameter: the last orbit's, next to it, and where motions from it come to."""
    here = np.append(last.z[:-1], q)
    yield here
    for size in (1.0, 30.0):
        for step in size * distance * np.eye(here.size)[:-2]:
            yield here + step
            yield here - step
    for _ in range(8):  # periods, in which a motion comes to a cycle that attracts it
        shot = shooting.at(here)
        if shot is None:
            return
        here = np.array([*shot.motion.end_state / shooting.units.size, *here[-2:]])
    yield here


def _parts(shooting: Shooting, shot: Shot) -> int:
    """In how many parts that are alike a period divides."""
    events, size = shot.itinerary, shooting.units.size
    for parts in range(len(events), 1, -1):
        if events == events[: len(events) // parts] * parts:
            (state,), _ = shot.motion.at([shot.motion.end_time / parts])
            if (np.abs(state - shot.motion.start_state) / size).max() < 1e2 * _NOTHING:
                return parts
    return 1


def _in_words(one: Shot, other: Shot) -> str:
    """What events a cycle has not that another one has, and the other way round; passages are none of the motion."""
    before, after = (Counter(shot.motion.automaton.in_words(shot.itinerary)) for shot in (one, other))
    changes = ("loses", before - after), ("gains", after - before)
    named = [(verb, ", ".join(f"{kind} into {mode}" for kind, mode in sorted(events))) for verb, events in changes]
    return " and ".join(f"{verb} {events}" for verb, events in named if events).replace("_", " ")


def _border(one: Shot, other: Shot) -> str:
    """The name of a border between cycles, by what vanishes there, the same from either side."""
    few, many = sorted((one, other), key=lambda shot: len(shot.itinerary))
    lost, own = _own(few, many.itinerary), _own(many, few.itinerary)
    name = "grazing" if _touches(many, own) or _touches(few, lost) else "border collision"
    return _sliding(many, own, bool(lost.any())) or name


def _own(shot: Shot, other: Itinerary = ()) -> np.ndarray:
    """Which events of a motion another itinerary lacks; passages and touches are in none."""
    extra, codes = Counter(shot.itinerary) - Counter(other), shot.motion.automaton.codes[shot.motion.mode]
    return np.array([event in extra for event in zip(shot.motion.kind.tolist(), codes.tolist(), strict=True)], bool)


def _sliding(many: Shot, own: np.ndarray, lost: bool) -> str:
    """The name of a sliding bifurcation, by the arc, of sliding or beside it, that vanishes after an own event."""
    motion, events = many.motion, _own(many)
    held = motion.automaton.marked(motion.automaton.codes[motion.mode[events]], "held")
    lasts = np.diff(motion.time[events], append=motion.time[events][0] + motion.end_time)
    k = int(np.argmin(np.where(own[events], lasts, math.inf)))
    if not (own[events][k] and lasts[k] < _TOUCHES * motion.end_time):
        return ""
    if held[k]:
        return "crossing-sliding" if lost else "grazing-sliding"
    onward = held[(k + 1) % held.size] and not lost
    return ("adding-sliding" if held[k - 1] else "switching-sliding") if onward else ""


def _touches(shot: Shot, own: np.ndarray) -> bool:
    """Whether one of its own events only touches its surface, and not for want of time."""
    motion, automaton = shot.motion, shot.motion.automaton
    modes, _, ends, _ = motion.arcs()
    others = motion.time[_own(shot) & ~own]
    states, along = motion.at(motion.end_time * np.linspace(0.0, 1.0, 64))
    rates = np.array([rate_of(automaton, int(mode), state) for mode, state in zip(along, states, strict=True)])
    for k in np.flatnonzero(own):
        guard = crossed_guard(automaton.tables, modes[k], motion.kind[k], motion.mode[k], ends[k])
        row = automaton.tables.surfaces[automaton.tables.guard_surface[guard], :-1]
        speed = abs(row @ rate_of(automaton, int(modes[k]), ends[k])) / np.abs(rates @ row).max()
        apart = np.abs((others - motion.time[k]) / motion.end_time)
        if guard >= 0 and speed < min([_TOUCHES, *0.5 * np.minimum(apart, 1 - apart)]):
            return True
    return False


def _extent(shooting: Shooting, shot: Shot) -> float:
    """The largest peak-to-peak of a coordinate over a period, in sizes of the motion."""
    states, _ = shot.motion.at(shot.motion.end_time * np.linspace(0.0, 1.0, 16))
    return float(np.max(np.ptp(states, axis=0) / shooting.units.size))


def _cycle(solved: Shot) -> Cycle | None:
    motion = solved.motion
    start = motion.automaton, motion.start_state, motion.start_mode
    return cycle_from(*start, motion.time.size, "continuation")


def _outside(cycle: Cycle | None) -> int:
    return -1 if cycle is None else int(np.sum(np.abs(cycle.multipliers) > 1))
