"""The map of a drive with two states whose friction depends on speed: intervals of sections, pulled back by events.

Every event takes a motion from section to section, or to rest, which has one end. Where the next events of two points
of a section have the same guard and the same signs of all conditions, those of all points between them have, too, and
go to places between the two (docs/attraction.md). So an interval has the label of those that it is taken to, if they
have one; else it is halved. The first labels are those of rests, of motions that stay in their mode, and of intervals
beside attractors, whose far ends the one rule (:mod:`lsvib.dynamics.attractor`) sees tend to the attractor.

A motion that comes to no interval with a label for many events is asked of the one rule.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from lsvib.basins.grid import Grid
from lsvib.basins.kernels import next_section
from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED, Cells, new_scratch, put_on
from lsvib.basins.kernels.next_section import LEAVES, RESTS, STAYS, Pieces, Way
from lsvib.basins.labels import Section, find_sections, landings
from lsvib.basins.mapper import NO_DOUBT, Starts
from lsvib.basins.slice_mapper import StateMapper
from lsvib.dynamics.attractor import Attractor, SteadyState, end_of_motion
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import jit
from lsvib.errors import EngineError

_POINTS = 12_000  # of all sections whose next event is looked for at most, a third of a second
_FINEST = 1e-7  # width of an interval that is not halved, in sizes of the drive's motions
_FAR = 4  # sections are divided up to 2⁴ sizes of the drive's motions; what is farther out comes nearer
_NEAR = -12  # and at first no finer than to 2⁻¹² sizes
_BAND = 1e-12  # of places that rounding does not tell apart, in sizes
_STEPS = 1000.0  # of the search for an event; usual are five
_EVENTS = 512  # of a motion that comes to no interval, after which it is asked of the rule


class Line:
    """A section, divided by ascending ``points`` (k), with the next events from these and labels (k − 1) in between."""

    def __init__(self, points: np.ndarray, found: np.ndarray, image: np.ndarray) -> None:
        self.points, self.found, self.image = points, found, image
        self.labels = np.full(points.size - 1, UNKNOWN)
        self.waits = np.zeros(points.size - 1, dtype=bool)  # until the interval that it is taken to is divided

    def insert(self, points: np.ndarray, found: np.ndarray, image: np.ndarray) -> None:
        """Add points within; parts of an interval have its label."""
        at = np.searchsorted(self.points, points)
        self.labels = np.insert(self.labels, at, self.labels[at - 1])
        self.waits = np.zeros(self.labels.size, dtype=bool)
        self.points, self.image = np.insert(self.points, at, points), np.insert(self.image, at, image)
        self.found = np.insert(self.found, at, found, axis=0)

    def over(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the one label of all intervals that meet each [low, high], and whether to divide further is in vain.

        The label is UNKNOWN where there are several. A single interval without a label is divided first.
        """
        first, last = np.searchsorted(self.points, low, "right") - 1, np.searchsorted(self.points, high, "left") - 1
        inside = (first >= 0) & (last < self.labels.size)
        first, last = np.where(inside, first, 0), np.where(inside, last, 0)
        changes = np.concatenate([[0], np.cumsum(self.labels[1:] != self.labels[:-1])])
        labels = np.where(inside & (changes[first] == changes[last]), self.labels[first], UNKNOWN)
        return labels, (inside & (first == last)) | (high < self.points[0]) | (low > self.points[-1])


class DividedSections:
    """The sections of an automaton with two states, divided until motions from each part end in one attractor.

    ``size`` (2) of u [rad] and w [rad/s] in its motions; ``attractors``, the cycles that are known. ``way`` holds
    the table of all labels for the kernels.
    """

    def __init__(self, automaton: Automaton, size: np.ndarray, attractors: Sequence[SteadyState]) -> None:
        self.automaton, self.size = automaton, size
        tables, pieces = automaton.tables, _nothing_known(automaton)
        address = jit.address(next_section.to_next_event, tables, pieces, 0, 0, _STEPS, new_scratch(tables))
        self.way = Way(address, tables, pieces, _STEPS)
        self._rested = set[int]()  # modes at rest whose end has been asked for
        self.lines: dict[Section, Line] = {}
        octaves = 2.0 ** np.arange(_NEAR, _FAR + 1)
        for section in find_sections(automaton, self.way.pieces):
            points = size[section.free] * np.concatenate([-octaves[::-1], [0.0], octaves])
            self.lines[section] = Line(points, *self._images(section, points))
        self._settle(attractors)
        while True:
            self._label()
            middles = {section: self._middles(section) for section in self.lines}
            count = sum(points.size for points in middles.values())
            if not 0 < count <= _POINTS - sum(line.points.size for line in self.lines.values()):
                break
            for section, points in middles.items():
                self.lines[section].insert(points, *self._images(section, points))
        self.way = self.way._replace(pieces=self._table())

    def _images(self, section: Section, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what the next events from points (k) of a section are (k, 4), and where they lead to (k)."""
        found, image = np.empty((points.size, 4), dtype=np.int64), np.empty(points.size)
        next_section.images(self.way, section[:2], points, found, image)
        for mode in set(found[found[:, 0] == RESTS, 2].tolist()) - self._rested:
            k = int(np.argmax((found[:, 0] == RESTS) & (found[:, 2] == mode)))
            self._rested.add(mode)  # all that rest in it have one end
            self.way.pieces.resting[mode] = self._end(self._section(mode, found[k, 3]), float(image[k])).label
        return found, image

    def _section(self, mode: int, surface: int) -> Section:
        return Section(int(mode), int(surface), int(self.way.pieces.free[surface]))

    def _end(self, section: Section, x: float) -> SteadyState:
        state = np.empty(2)
        state[section.free] = x
        put_on(self.automaton.tables, section.surface, state)
        try:
            return end_of_motion(self.automaton, state, mode=int(section.mode), max_events=50_000)[0]
        except EngineError as error:
            return SteadyState.unresolved(state, error)

    def _middles(self, section: Section) -> np.ndarray:
        """Return the middles of the intervals of a section that are to be divided."""
        line, finest = self.lines[section], _FINEST * self.size[section.free]
        wide = (line.labels == UNKNOWN) & ~line.waits & (np.diff(line.points) > finest)
        same, (outcome, number) = (line.found[:-1] == line.found[1:]).all(axis=1), line.found[1:, :2].T
        # In vain where the mode is not entered, or left at once, and where its next event has no place.
        wide &= ~(same & ((outcome != LEAVES) | (number % 2 == 1)))
        middles: np.ndarray = 0.5 * (line.points[:-1] + line.points[1:])[wide]
        return middles

    def _label(self) -> None:
        """Label the intervals that their next event takes to one label, until nothing changes."""
        changed = True
        while changed:
            changed = False
            for line in self.lines.values():
                one, other = line.found[:-1], line.found[1:]
                alike = (line.labels == UNKNOWN) & (one == other).all(axis=1)
                for outcome, label in ((RESTS, self.way.pieces.resting), (STAYS, self.way.pieces.settled)):
                    here = alike & (one[:, 0] == outcome)
                    line.labels[here] = label[one[here, 2]]
                    changed = changed or bool((line.labels[here] != UNKNOWN).any())
                alike &= one[:, 0] == LEAVES
                for mode, surface in np.unique(one[alike, 2:], axis=0):
                    here = np.flatnonzero(alike & (one[:, 2] == mode) & (one[:, 3] == surface))
                    target = self.lines[self._section(mode, surface)]
                    ends = np.sort([line.image[here], line.image[here + 1]], axis=0)
                    band = _BAND * self.size[self.way.pieces.free[surface]]
                    labels, line.waits[here] = target.over(ends[0] - band, ends[1] + band)
                    changed = changed or bool((labels != UNKNOWN).any())
                    line.labels[here] = labels

    def _settle(self, attractors: Sequence[SteadyState]) -> None:
        """Label intervals beside steady sliding and beside the points of cycles that do not rest."""
        flow = self.automaton.tables.flow
        orbits = [(one, one.orbit) for one in attractors if one.orbit is not None and one.orbit.time.size]
        for section in self.lines:
            place = flow.settled_place[section.mode]
            steady = SteadyState(Attractor.STEADY_SLIDING, place)
            if flow.settled_level[section.mode] >= 0 and self._lies_on(section, place):
                for side in (-1, 1):
                    self._settle_beside(section, float(place[section.free]), steady, 2, (side,))
            for one, orbit in orbits:
                if (self.way.pieces.resting[orbit.mode] == UNKNOWN).all():
                    for state in orbit.after[orbit.mode == section.mode]:
                        if self._lies_on(section, state):
                            self._settle_beside(section, float(state[section.free]), one, orbit.time.size, (-1, 1))

    def _lies_on(self, section: Section, state: np.ndarray) -> bool:
        point = state.copy()
        put_on(self.automaton.tables, section.surface, point)
        return bool((np.abs(point - state) <= _BAND * self.size).all())

    def _settle_beside(
        self, section: Section, centre: float, attractor: SteadyState, events: int, sides: Sequence[int]
    ) -> None:
        """Label the widest interval beside an attractor whose ends tend to it, and that its events take into itself.

        Along the interval these are the same, so that they take it to itself in a monotone way.
        """
        line, size = self.lines[section], self.size[section.free]
        for distance in size * 4.0 ** np.arange(1, -16, -1):
            ends = [centre + side * distance for side in sides]
            courses = [self._course(section, x, events) for x in ends]
            same = all(one is not None and one[0] == courses[0][0] for one in courses)  # type: ignore[index]
            if not same or not all(abs(one[1] - centre) < distance for one in courses if one is not None):
                continue
            found = [self._end(section, x) for x in ends]
            if all(one.label == attractor.label and (not one.orbit or one.same_period(attractor)) for one in found):
                for x in np.setdiff1d([centre, *ends], line.points):
                    line.insert(*(np.atleast_1d(part) for part in (x, *self._images(section, np.array([x])))))
                low, high = min(centre, *ends), max(centre, *ends)
                line.labels[(line.points[:-1] >= low) & (line.points[1:] <= high)] = attractor.label
                return

    def _course(self, section: Section, x: float, events: int) -> tuple[list[bytes], float] | None:
        """Return what so many events are and where on the section they lead to; None unless they lead back to it."""
        path, here = [], section
        for _ in range(events):
            found, image = self._images(here, np.array([x]))
            if found[0, 0] != LEAVES:
                return None
            path.append(found.tobytes())
            here, x = self._section(*found[0, 2:]), float(image[0])
        return (path, x) if here == section else None

    def _table(self) -> Pieces:
        """Return the table of all labels, neighbours of one label joined."""
        edges, labels = [np.zeros(1)], [np.full(1, UNKNOWN)]
        first, last, count = np.zeros_like(self.way.pieces.first), np.zeros_like(self.way.pieces.last), 1
        for (mode, surface, _), line in self.lines.items():
            begins = np.flatnonzero(np.append(True, line.labels[1:] != line.labels[:-1]))
            edges.append(line.points[np.append(begins, -1)])
            labels.append(np.append(line.labels[begins], UNKNOWN))
            first[mode, surface], last[mode, surface] = count, count + begins.size
            count += begins.size + 1
        return self.way.pieces._replace(
            first=first, last=last, edges=np.concatenate(edges), labels=np.concatenate(labels).astype(np.int64)
        )


def _nothing_known(automaton: Automaton) -> Pieces:
    tables, rests = automaton.tables, automaton.marked(automaton.codes, "rest")
    slides = np.where(tables.flow.settled_level >= 0, Attractor.STEADY_SLIDING, UNKNOWN)
    return Pieces(
        landing=landings(automaton, rests),
        free=1 - tables.snap,
        resting=np.where(rests, UNRESOLVED, UNKNOWN).astype(np.int64),
        settled=slides.astype(np.int64),
        first=np.zeros((rests.size, tables.snap.size), dtype=np.int64),
        last=np.zeros((rests.size, tables.snap.size), dtype=np.int64),
        edges=np.zeros(1),
        labels=np.full(1, UNKNOWN, dtype=np.int64),
    )


class LawMapper(StateMapper):
    """Maps the starts of a drive with two states under a friction law, by :class:`DividedSections`.

    Labels, first events and doubts are looked up; times and seizures, if they are asked for, are those of motions that
    are followed to their ends, as of drives with more states.
    """

    def __init__(self, automaton: Automaton, starts: Starts) -> None:
        super().__init__(automaton, starts)
        places = [starts.size[None], *(np.abs(one.orbit.after) for one in self.attractors if one.orbit is not None)]
        self.sections = DividedSections(self.automaton, np.concatenate(places).max(axis=0), self.attractors)

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays; all of them by motions where times or seizures are asked for."""
        if not {"time", "seizures"}.isdisjoint(quantities):
            super().fill(found, grid, x, y, quantities)
            return
        cells = Cells(x, y, int(grid.x.coordinate == "w"))
        next_section.map_labels(self.sections.way, cells, _EVENTS, found["label"], found["first_event"])
        found["doubt"][:] = NO_DOUBT
        for i, j in np.argwhere(found["label"] < 0):
            self.follow(found, grid, i, j, float(x[j]), float(y[i]))
