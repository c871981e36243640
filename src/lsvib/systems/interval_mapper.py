"""The map of a system with two states: intervals of sections, pulled back by events.

docs/attraction.md says why the two ends of an interval decide for all points between, and where the first labels come
from; far ends of intervals beside attractors are asked of the one rule (:mod:`lsvib.systems.attractor`), and so is a
motion that comes to no interval with a label for many events.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lsvib.errors import EngineError
from lsvib.systems.attractor import Attractor, Doubt, SteadyState, conserves, end_of_motion, shrinks_areas
from lsvib.systems.automaton import Automaton
from lsvib.systems.grid import Grid
from lsvib.systems.kernels import event_loop, jit, layout, next_section
from lsvib.systems.kernels.next_section import LEAVES, RESTS, STAYS, UNKNOWN, UNRESOLVED, Cells, Cycles, Pieces, Way
from lsvib.systems.mapper import NO_DOUBT, Mapper, Starts

_POINTS = 12_000  # of all sections whose next event is looked for at most, a third of a second
_FINEST = 1e-7  # width of an interval that is not halved, in sizes of the motions
_FAR = 4  # sections are divided up to 2⁴ sizes of the motions; what is farther out comes nearer
_NEAR = -12  # and at first no finer than to 2⁻¹² sizes
_BAND = 1e-12  # of places that rounding does not tell apart, in sizes
_STEPS = 1000.0  # of the search for an event; usual are five
_EVENTS = 512  # of a motion that comes to no interval, after which it is asked of the rule


class Section(NamedTuple):
    """A mode and a surface on which it is entered; ``free`` is the coordinate along the surface."""

    mode: int
    surface: int
    free: int


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

    def goes_on(self) -> np.ndarray:
        """Return false of intervals whose mode is not entered, or left at once, or whose next event has no place."""
        same, (outcome, number) = (self.found[:-1] == self.found[1:]).all(axis=1), self.found[1:, :2].T
        going: np.ndarray = ~same | ((outcome == LEAVES) & (number % 2 == 0))
        return going


class DividedSections:
    """The sections of an automaton with two states, divided until motions from each part end in one attractor.

    ``size`` (2) of the states in its motions; ``attractors``, the cycles that are known. ``way`` holds
    the table of all labels for the kernels; ``doubt`` says why what is unresolved in it is.
    """

    def __init__(self, automaton: Automaton, size: np.ndarray, attractors: Sequence[SteadyState]) -> None:
        self.automaton, self.size = automaton, size
        tables, pieces = automaton.tables, _nothing_known(automaton)
        scratch = next_section.new_scratch(tables)
        address = jit.address(next_section.to_next_event, tables, pieces, 0, 0, _STEPS, scratch)
        self.way = Way(address, tables, pieces, _STEPS)
        self.doubt = Doubt.ROUNDING  # where rests have an end
        self._rested = set[int]()  # modes at rest whose end has been asked for
        self._undamped = bool(conserves(automaton).all())
        self.lines: dict[Section, Line] = {}
        if automaton.contracts:  # all motions have one end
            label = Attractor.STEADY_SLIDING if shrinks_areas(automaton) else Attractor.NEUTRAL_FAMILY
            self.way.pieces.resting[self.way.pieces.resting != UNKNOWN] = label
            for section in find_sections(automaton, self.way.pieces):
                self.lines[section] = Line(np.array([-np.inf, np.inf]), np.zeros((2, 4)), np.zeros(2))
                self.lines[section].labels[:] = label
            self.way = self.way._replace(pieces=self._table())
            return
        octaves = 2.0 ** np.arange(_NEAR, _FAR + 1)
        for section in find_sections(automaton, self.way.pieces):
            points = size[section.free] * np.concatenate([-octaves[::-1], [0.0], octaves])
            self.lines[section] = Line(points, *self._divided(section, points))
        self._settle(attractors)
        while True:
            self._label()
            middles = {}
            for section, line in self.lines.items():
                wide = (line.labels == UNKNOWN) & ~line.waits & line.goes_on()
                wide &= np.diff(line.points) > _FINEST * size[section.free]
                middles[section] = 0.5 * (line.points[:-1] + line.points[1:])[wide]
            count = sum(points.size for points in middles.values())
            if not 0 < count <= _POINTS - sum(line.points.size for line in self.lines.values()):
                break
            for section, points in middles.items():
                self.lines[section].insert(points, *self._divided(section, points))
        self.way = self.way._replace(pieces=self._table())
        if not automaton.flow.by_speed:  # under a law ellipses shrink below their level only
            self._share()

    def _share(self) -> None:
        """Note the damped modes all motions in which have one label, and how far out that is known."""
        tables, pieces = self.automaton.tables, self.way.pieces
        for mode in np.flatnonzero((pieces.resting == UNKNOWN) & (pieces.level >= 0)).tolist():
            ends, far = {int(pieces.settled[mode])} - {UNKNOWN}, self.size * np.inf
            for transition in tables.guard_transition[slice(*tables.guard_start[mode : mode + 2])]:
                for after in tables.branch_mode[slice(*tables.branch_start[transition : transition + 2])].tolist():
                    section = self._section(after, pieces.landing[transition])
                    if section in self.lines:
                        more, known = self._extent(section)
                        ends, far[section.free] = ends | more, min(far[section.free], known)
                    else:
                        ends.add(int(pieces.resting[after]))
            if len(ends) == 1:
                pieces.common[mode] = ends.pop()
                room = np.maximum(far - np.abs(pieces.centre[mode]), 0.0)
                pieces.reach[mode] = (room**2 / np.diag(np.linalg.inv(pieces.form[mode]))).min()

    def _extent(self, section: Section) -> tuple[set[int], float]:
        """Return the labels of a section, where it is entered, and how far out all that is entered has one."""
        line = self.lines[section]
        entered = line.goes_on() | (line.labels != UNKNOWN)
        entered &= np.diff(line.points) > 2 * _FINEST * self.size[section.free]  # rounding, and what repels
        near = np.minimum(np.abs(line.points[:-1]), np.abs(line.points[1:]))
        far = float(min([np.abs(line.points).max(), *near[entered & (line.labels == UNKNOWN)]]))
        return set(line.labels[entered & (near < far)].tolist()), far

    def _images(self, section: Section, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what the next events from points (k) of a section are (k, 4), and where they lead to (k)."""
        found, image = np.empty((points.size, 4), dtype=np.int64), np.empty(points.size)
        next_section.images(self.way, section[:2], points, found, image)
        for mode in set(found[found[:, 0] == RESTS, 2].tolist()) - self._rested:
            k = int(np.argmax((found[:, 0] == RESTS) & (found[:, 2] == mode)))
            self._rested.add(mode)  # all that rest in it have one end
            end = self._end(self._section(mode, found[k, 3]), float(image[k]), Mapper.work)
            self.way.pieces.resting[mode], self.doubt = end.label, end.doubt or self.doubt
        return found, image

    def _divided(self, section: Section, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the images of points, where what two events of an undamped motion take back to its place stays, too.

        What does not pass rest is then the same backwards in time: so are those of all points between.
        """
        found, image = self._images(section, points)
        for k in np.flatnonzero((found[:, 0] == LEAVES) & self._undamped):
            course = self._course(section, float(points[k]), 2)
            if course is not None and abs(course[1] - points[k]) <= _BAND * self.size[section.free]:
                found[k, 0] = STAYS
        return found, image

    def _section(self, mode: int, surface: int) -> Section:
        return Section(int(mode), int(surface), int(self.way.pieces.free[surface]))

    def _end(self, section: Section, x: float, work: int = 50_000) -> SteadyState:
        state = np.empty(2)
        state[section.free] = x
        next_section.put_on(self.automaton.tables, section.surface, state)
        try:
            return end_of_motion(self.automaton, state, mode=int(section.mode), max_events=work)[0]
        except EngineError as error:
            return SteadyState.unresolved(state, error)

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
        places = self.way.pieces.centre
        for section in self.lines:
            place = places[section.mode]
            steady = SteadyState(Attractor.STEADY_SLIDING, place)
            if self.way.pieces.settled[section.mode] == steady.label and self._lies_on(section, place):
                for side in (-1, 1):
                    self._settle_beside(section, float(place[section.free]), steady, 2, (side,))
            for one in attractors:
                orbit = one.orbit
                if orbit is not None and (self.way.pieces.resting[orbit.mode] == UNKNOWN).all():
                    for state in orbit.after[orbit.mode == section.mode]:
                        if self._lies_on(section, state):
                            self._settle_beside(section, float(state[section.free]), one, orbit.time.size, (-1, 1))

    def _lies_on(self, section: Section, state: np.ndarray) -> bool:
        point = state.copy()
        next_section.put_on(self.automaton.tables, section.surface, point)
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
            courses = [course for x in ends if (course := self._course(section, x, events)) is not None]
            nearer = [path == courses[0][0] and abs(x - centre) < distance for path, x in courses]
            if nearer.count(True) < len(ends):
                continue
            found = [self._end(section, x) for x in ends]
            if all(one.label == attractor.label and (not one.orbit or one.same_period(attractor)) for one in found):
                points = np.setdiff1d([centre, *ends], line.points)
                line.insert(points, *self._images(section, points))
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


def _settling(automaton: Automaton) -> dict[str, np.ndarray]:
    """Return what stays in each mode for ever, as fields of ``Pieces``."""
    flow = automaton.tables.flow
    if automaton.flow.by_speed:
        label = np.where(flow.settled_level >= 0, Attractor.STEADY_SLIDING, UNKNOWN)
        return dict(settled=label, centre=flow.settled_place, form=flow.settled_form, level=flow.settled_level)
    alpha, kappa = flow[:, layout.ALPHA], np.maximum(flow[:, layout.ALPHA], flow[:, layout.BETA])
    damped = (alpha > 0) & (flow[:, layout.A0] > 0)
    undamped = np.where((alpha == 0) & (flow[:, layout.BETA] > 0), Attractor.NEUTRAL_FAMILY, UNKNOWN)
    # y = u − u_e, η = w + α y, κ = max(α, β). With y′ = η − α y, η′ = −α η − β² y (−δ² for β² if the roots are real)
    # the function falls at a rate of 2α − |κ² − β²| / κ at least, which is positive. It is e^{−2αt} exactly if κ = β.
    level = np.array([_trap(automaton, m, kappa[m]) if damped[m] else -1.0 for m in range(alpha.size)])
    damped &= ~np.signbit(level)
    return dict(
        settled=np.where(damped, Attractor.STEADY_SLIDING, undamped).astype(np.int64),
        centre=np.stack([flow[:, layout.EQUILIBRIUM], 0 * alpha], axis=1),
        form=np.array([[alpha**2 + kappa**2, alpha], [alpha, 0 * alpha + 1]]).transpose(2, 0, 1).copy(),
        level=level,
    )


def _trap(automaton: Automaton, mode: int, kappa: float) -> float:
    """Return ρ² of the largest ellipse η² + κ² y² < ρ² in which no guard of a damped mode fires."""
    tables, radius = automaton.tables, np.inf
    row = tables.flow[mode]
    if not kappa < event_loop.LARGEST:  # whose square overflows
        return 0.0
    with np.errstate(all="ignore"):  # a guard that hardly depends on the state is beyond all numbers: so is the square
        for guard in range(*tables.guard_start[mode : mode + 2]):
            u, w, constant = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard]]
            least = constant + u * row[layout.EQUILIBRIUM]
            slack = 64 * np.finfo(float).eps * (abs(constant) + abs(u * row[layout.EQUILIBRIUM]))
            if least < -slack:  # the equilibrium lies beyond, so that every motion leaves the mode
                return -0.0
            radius = min(radius, max(0.0, least - slack) / np.hypot(w, (u - row[layout.ALPHA] * w) / kappa))
    return float(radius**2)


def _nothing_known(automaton: Automaton) -> Pieces:
    tables, rests = automaton.tables, automaton.marked(automaton.codes, "rest")
    return Pieces(
        landing=landings(automaton, rests),
        common=np.full(rests.size, UNKNOWN),
        reach=np.zeros(rests.size),
        free=1 - tables.snap,
        resting=np.where(rests, UNRESOLVED, UNKNOWN).astype(np.int64),
        **_settling(automaton),
        first=np.zeros((rests.size, tables.snap.size), dtype=np.int64),
        last=np.zeros((rests.size, tables.snap.size), dtype=np.int64),
        edges=np.zeros(1),
        labels=np.full(1, UNKNOWN, dtype=np.int64),
    )


def landings(automaton: Automaton, rests: np.ndarray) -> np.ndarray:
    """The surface on which each transition leaves the state; −1 for the entry and on release, which is at a corner."""
    tables = automaton.tables
    landing = np.full(tables.transition_reset.size, -1, dtype=np.int64)
    for mode in np.flatnonzero(~rests):
        for guard in range(*tables.guard_start[mode : mode + 2]):
            transition = tables.guard_transition[guard]
            reset = tables.transition_reset[transition]
            landing[transition] = tables.guard_surface[guard]
            if reset >= 0:
                image = tables.surfaces[:, :2] @ tables.resets[reset]
                image[:, 2] += tables.surfaces[:, 2]
                landing[transition] = int(np.flatnonzero((image == 0).all(axis=1))[0])
    return landing


def find_sections(automaton: Automaton, pieces: Pieces) -> list[Section]:
    """Return the modes of slip with the surfaces on which events enter them."""
    tables, found = automaton.tables, set()
    for transition in np.flatnonzero(pieces.landing >= 0):
        surface = int(pieces.landing[transition])
        for mode in tables.branch_mode[slice(*tables.branch_start[transition : transition + 2])].tolist():
            if pieces.resting[mode] == UNKNOWN:
                found.add(Section(mode, surface, int(pieces.free[surface])))
    return sorted(found)


class IntervalMapper(Mapper):
    """Maps the starts of a system with two states by :class:`DividedSections`, where its labels are looked up.

    What ``time`` [s] and ``seizures`` are under constant friction, docs/attraction.md says; under a law they are as of
    systems with more states.
    """

    def __init__(self, automaton: Automaton, starts: Starts) -> None:
        super().__init__(automaton, starts)
        orbits = [one.orbit for one in self.attractors if one.orbit is not None]
        size = np.max([starts.size, *(np.abs(o.after).max(axis=0) for o in orbits)], axis=0)
        self.impacts = np.array([*automaton.marks["impact"]], dtype=np.int64)
        self.cycles = Cycles(
            np.concatenate([np.empty(0, dtype=np.int64), *(o.mode.astype(np.int64) for o in orbits)]),
            np.concatenate([np.empty((0, 2)), *(o.after for o in orbits)]),
            np.concatenate([np.empty((0, 2)), *(0 * o.after + 1e-9 * np.abs(o.after).max(axis=0) for o in orbits)]),
        )
        self.sections = DividedSections(self.automaton, size, self.attractors)

    @cached_property
    def work(self) -> int:  # type: ignore[override]
        """Events of a motion that is followed: a share of those of one, the more of 400 starts come to no interval."""
        x, y = 8 * self.starts.size[:, None] * np.linspace(-1, 1, 20)
        labels = np.empty((20, 20), dtype=np.int8)
        next_section.map_labels(self.sections.way, Cells(x, y, 0), _EVENTS, labels, labels[:, :0])
        return Mapper.work // max(1, int((labels == UNKNOWN).sum()))

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays, under a law by motions where times or seizures are asked for."""
        timed = not {"time", "seizures"}.isdisjoint(quantities)
        if timed and self.automaton.flow.by_speed:
            super().fill(found, grid, x, y, quantities)
            return
        first_events = found["first_event"][:, : x.size if "first_event" in quantities else 0]
        if shrinks_areas(self.automaton) and not timed and not first_events.size:
            found["label"][:] = Attractor.STEADY_SLIDING
            found["doubt"][:] = NO_DOUBT
            return
        along = {**grid.fixed, grid.x.coordinate: 1.0, grid.y.coordinate: 0.0}
        cells = Cells(x, y, int(np.argmax(self.starts.state(along))))
        next_section.map_labels(self.sections.way, cells, _EVENTS, found["label"], first_events)
        found["doubt"][:] = np.where(found["label"] == UNRESOLVED, list(Doubt).index(self.sections.doubt), NO_DOUBT)
        for i, j in np.argwhere(found["label"] == UNKNOWN):
            self.follow(found, grid, i, j, float(x[j]), float(y[i]))
        if timed:
            next_section.map_approaches(
                self.sections.way, self.cycles, self.impacts, cells, 100_000, found["time"], found["seizures"]
            )
            found["time"][found["label"] == UNRESOLVED] = np.inf
