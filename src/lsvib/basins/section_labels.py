r"""What becomes of motions that start on a surface between two modes: labels as a function of one coordinate.

A *section* is a mode together with a surface on which the mode is entered. After every event a motion with two states
is on a section or at rest, unless the event was its last one; so the label of a motion is that of its state after the
first event. Along a section the label is constant between finitely many points, which are found here to the last bit.

It is enough to compare two ends, for the following reason. For the motion from a point of a section, write down the
guard of every event and the signs of all conditions of its transition; this is the *itinerary* of the point. If two
points of a section have the same itinerary, every point between them has it, too. Consider one event. The two arcs do
not meet, because motions are unique, and they do not cross the section's surface, which bounds the mode. Together with
the pieces of the two surfaces between their ends they enclose a region, which lies in the mode because the mode is
convex. The rate of a guard is affine along its surface, so between two points at which the field enters the mode it
enters everywhere, and between two points at which it leaves the mode it leaves everywhere. Hence a motion that starts
between the two points can leave the region only between the ends of the two arcs. It does leave the region: otherwise
there would be an equilibrium in it, but the index of the field along such a boundary is zero. If both motions settle,
the motions between them stay between them. The conditions are affine, too: a condition that has the same sign at both
ends has it between them. So the next event starts again from a section, between two of its points.

An itinerary ends where the rest of the motion is known: (i) at rest, because every rest ends in the same state; (ii)
where the motion settles; (iii) in an *absorbing interval* around a point of a cycle. The return map takes this interval
into itself, and it is monotone there because both ends have the same itinerary; so all motions that enter the interval
go on for ever as the cycle does. Where the itineraries of the ends of an interval differ, bisection finds the point up
to which the itinerary of one end holds, and both parts are examined again. Nothing else is assumed. The effect of
rounding on such a point is measured: the search is repeated with motions that are pushed by a few units of rounding
after every event, and the starts for which the results differ are labelled unresolved.
"""

from heapq import heappop, heappush

import numpy as np

from lsvib.basins.kernels import itinerary
from lsvib.basins.kernels.itinerary import DIVERGED, GRAZED, STUCK, TOO_LONG
from lsvib.basins.kernels.labelling import UNKNOWN, UNRESOLVED
from lsvib.basins.pieces import Pieces, agreed, completed, merged, opened, touching
from lsvib.basins.section_tables import (
    FAR,
    ON_CYCLE,
    LabelSection,
    find_sections,
    nothing_known,
    releases_of,
    sizes,
    with_common_labels,
    with_cycles,
    with_labels,
)
from lsvib.cycles import drift_two_states, return_map
from lsvib.cycles.attractors import Attractor, Passage, SteadyState, steady_state
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import columns, flow_planar
from lsvib.engine.motion import follow
from lsvib.errors import EngineError

_EVENTS = 256  # longest itinerary; a motion that goes on is labelled by a search for its attractor
_HASTE = 16  # events after which a motion that hardly moves is leapt over
_WORK = 20_000_000  # events that may be followed for one drive; they take a few seconds
_BISECTIONS = 60  # motions that are followed to find the place at which two courses part
_FIRST_ROUND = 0.5  # part of the work that is shared out to all sections before any of them gets more
_SPLIT = 5_000  # events that take about as long as the bookkeeping of one piece
# Where the speed passes zero by less than its rounding, neighbours differ at random over the square root of that
# rounding. So in a section of more than _MANY pieces those of a relative width below _NOISE are not divided.
_MANY = 200
_NOISE = 1e-6
_NARROW = (1e-4, 1e-8)  # relative widths below which pieces wait for wider ones
_CROWDED = 24  # number of pieces of a section at which, as at each doubling, a drift is looked for that joins them
_BESIDE = 1e-9  # relative distance of a start beside a piece
_PATIENT = 1e3  # time that a return from farther away may take, in times of a return that was seen
_LEAPS_COST = 400_000  # events that take about as long as a search by leaps
_COST = 60_000  # events that take about as long as a search for an attractor
_PROBES = (-0.5 * FAR, -30.0, -1.0, -0.1, 0.1, 1.0, 30.0, 0.5 * FAR)  # first starts, in sizes of the drive's motions
_LATER = 1000  # plus the label of an attractor that was found beyond the itinerary, it is the code at a course's end
_WINDOW = 1e-4  # relative half width around a change of label in which motions are pushed
_FUTILE = 8  # searches without a result after which none is made: motions stay that long only near a repelling cycle
_IN_VAIN = 20  # searches that leapt over nothing, after which motions are followed without leaps
_ONE_CYCLE = 1e-6  # relative difference of periods below which two cycles of one label are one
_SLIVER = 1e-6  # largest relative width of a piece whose motions touch a guard to rounding
_ROUNDING = 64 * flow_planar.EPS  # push after every event, relative to the terms that the state was computed from
_PUSHES = ((0.0, False), *((side * _ROUNDING, alternate) for side in (-1, 1) for alternate in (False, True)))


class Sections:
    """The sections of a planar automaton, the attractors of its motions, and ``known``, the table for the kernels.

    ``complete``: whether the work sufficed; if it did not, motions that come to places without a label are to be
    followed further. Without ``rounding`` a start whose label is decided by rounding has one of the labels beside it
    instead of none.
    """

    def __init__(self, automaton: Automaton, rounding: bool = True) -> None:
        self.automaton = automaton
        self._pushes = _PUSHES[1:] if rounding else ()
        self.size = sizes(automaton)
        self.known = nothing_known(automaton, self.size)
        self.sections = find_sections(automaton, self.known)
        self.attractors: list[SteadyState] = []
        self._absorbing = np.empty((0, 4))
        self._absorbed: list[Attractor] = []
        self._found: dict[LabelSection, list[tuple[float, float, int]]] = {}
        self._learned: list[Attractor] = []
        self._work = self._futile = self._in_vain = 0
        self.complete = True
        self._limit = _WORK  # of the section that is examined
        self._symbols = np.empty(_EVENTS, dtype=np.int64)
        if automaton.contracts:
            self._same_for_all()
            return
        for section in self.sections:
            if not (self._point(section, 0.0).any() or automaton.tables.flow[section.mode, columns.EQUILIBRIUM]):
                self._absorb_by_corner(section, 1)
                self._absorb_by_corner(section, -1)
        releases = releases_of(automaton, self.known)
        for mode, state in releases:
            self.known.resting[mode] = self._explore(state, mode)
        for section in self.sections:
            for part in _PROBES:
                state = self._point(section, part * self.size[section.free])
                if self._belongs(section, state):
                    self._course(
                        section, state[section.free], _PUSHES[0]
                    )  # finds its attractor, if that is not known yet
        found = self._all_labels()
        self.complete = self._work < _WORK
        if not self.complete:  # what is left of a crowded section is no boundary
            found = {section: opened(pieces, _NOISE) for section, pieces in found.items()}
        self.known = with_common_labels(automaton, with_labels(self.known, found), found, self.size)
        self.known = with_cycles(automaton, self.known, self.attractors, releases)

    def _same_for_all(self) -> None:
        """Fill the table for a drive all of whose motions have one attractor."""
        slips = self.known.resting == UNKNOWN
        label = self.known.settled[slips][0]  # damped slip ends in steady sliding, undamped slip in a neutral family
        found = {section: Pieces([-np.inf, np.inf], [int(label)]) for section in self.sections}
        self.known.resting[~slips] = label
        self.known = with_common_labels(self.automaton, with_labels(self.known, found), found, self.size)

    def _all_labels(self) -> dict[LabelSection, Pieces]:
        """Return labels along all sections; what is unresolved is tried again when the others are known."""
        found: dict[LabelSection, Pieces] = {}
        for part in (_FIRST_ROUND, 1.0):
            open_ones = [one for one in self.sections if one not in found or UNRESOLVED in found[one].labels]
            for k, section in enumerate(open_ones):
                share = 1.0 if part == 1.0 else 1.0 / (len(open_ones) - k)  # a section passes on what it does not spend
                self._limit = self._work + share * max(part * _WORK - self._work, 0.0)
                self._found.pop(section, None)
                labels = self._labels(section)
                found[section] = completed(labels, found[section]) if section in found else labels
        return found

    def _point(self, section: LabelSection, x: float) -> np.ndarray:
        state = np.empty(2)
        state[section.free] = x
        itinerary.put_on(self.automaton.tables, section.surface, state)
        return state

    def _belongs(self, section: LabelSection, state: np.ndarray) -> bool:
        """Tell whether a point of a section lies in its mode, so that no other guard has fired already."""
        tables = self.automaton.tables
        guards = slice(*tables.guard_start[section.mode : section.mode + 2])
        rows = tables.surfaces[tables.guard_surface[guards]]
        values = tables.guard_sign[guards] * (rows[:, :2] @ state + rows[:, 2])
        return bool((values[tables.guard_surface[guards] != section.surface] >= 0).all())

    def _ends(self, section: LabelSection) -> tuple[float, float]:
        """Return the part of a section on which its mode can be entered: its guard rises, and no other has fired."""
        tables, origin = self.automaton.tables, self._point(section, 0.0)
        along = self._point(section, self.size[section.free]) - origin
        rows = []
        for guard in range(*tables.guard_start[section.mode : section.mode + 2]):
            u, w, constant = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard]]
            if tables.guard_surface[guard] == section.surface:
                flow = tables.flow[section.mode]
                u, w, constant = -w * flow[columns.A0], u - w * flow[columns.A1], w * flow[columns.B]
            rows.append((u, w, constant))
        low, high = -FAR, FAR
        for u, w, constant in rows:
            slope, level = u * along[0] + w * along[1], u * origin[0] + w * origin[1] + constant
            rounding = _SLIVER * (abs(u * origin[0]) + abs(w * origin[1]) + abs(constant))
            if slope > 0:
                low = max(low, -(level + rounding) / slope)
            elif slope < 0:
                high = min(high, -(level + rounding) / slope)
            elif level < -rounding:
                return 0.0, 0.0
        return low * self.size[section.free], high * self.size[section.free]

    def _explore(self, state: np.ndarray, mode: int, learns: bool = True) -> Attractor:
        """Find the attractor of a motion; if it is a new cycle without rest, note an absorbing interval of it."""
        if self._futile > _FUTILE:
            return Attractor.UNRESOLVED
        patience = _HASTE if self._in_vain < _IN_VAIN else _COST
        found = steady_state(self.automaton, state, mode=mode, max_events=_COST, patience=patience)
        if found.label == Attractor.UNRESOLVED:
            self._futile += 1
            self._work += (_WORK - self._work) // _FUTILE  # where nothing is found, less is spent
        self._in_vain += not found.passages
        self._work += _COST if patience == _COST else _LEAPS_COST
        if not learns:
            return found.label
        for passage in found.passages if found.label != Attractor.UNRESOLVED else ():
            self._absorb_passage(passage, found.label)
        if found.orbit is None or any(_same(found, other) for other in self.attractors):
            return found.label
        self.attractors.append(found)
        if (self.known.resting[found.orbit.arcs()[0]] == UNKNOWN).all():
            interval = self._absorbing_interval(found)
            if interval is not None:
                self._absorb(interval, found.label)
        return found.label

    def _absorb_passage(self, passage: Passage, label: Attractor) -> None:
        """Add a stretch of a section from which all motions were found to have one label."""
        for section in self.sections:
            points = [self._point(section, x) for x in passage.ends[:, section.free]]
            near = ON_CYCLE * np.abs(passage.ends).max(axis=0)
            if section.mode == passage.mode and (np.abs(points - passage.ends) <= near).all():
                low, high = sorted(passage.ends[:, section.free])
                same = (self._absorbing[:, 0] == section.mode) & (self._absorbing[:, 1] == section.surface)
                if not (same & (self._absorbing[:, 2] <= low) & (high <= self._absorbing[:, 3])).any():
                    self._absorb((section.mode, section.surface, low, high), label)
                return

    def _absorbing_interval(self, cycle: SteadyState) -> tuple[float, ...] | None:
        """Double an interval around a point of a cycle while the return map takes it into itself; return the last."""
        orbit = cycle.orbit
        if not orbit.time.size:  # a neutral oscillation that meets nothing
            return None
        near = ON_CYCLE * np.abs(orbit.after).max(axis=0)
        for section in self.sections:
            points = orbit.after[orbit.mode == section.mode]
            points = [x for x in points if (np.abs(self._point(section, x[section.free]) - x) <= near).all()]
            if not points:
                continue
            x, found, width = points[0][section.free], None, near[section.free]
            while width < self.size[section.free]:
                ends = [self._returned(section, x + side * width, len(points)) for side in (-1, 1)]
                if None in ends or ends[0][0] != ends[1][0] or any(abs(end - x) >= width for _, end in ends):
                    break
                found, width = (section.mode, section.surface, x - width, x + width), 2 * width
            if found is not None:
                return found
        return None

    def _returned(self, section: LabelSection, x: float, visits: int) -> tuple[list[bytes], float] | None:
        """Return itinerary and coordinate after so many returns to a section; None if it does not come back."""
        everywhere = np.array([[section.mode, section.surface, -np.inf, np.inf]])
        state, path = self._point(section, x), []
        for _ in range(visits):
            code, count, _ = itinerary.itinerary(
                self.automaton.tables, self.known, everywhere, section.mode, state, 0.0, False, self._symbols
            )
            if code != 2:
                return None
            path.append(self._symbols[:count].tobytes())
        return path, float(state[section.free])

    def _course(self, section: LabelSection, x: float, push: tuple[float, bool], learns: bool = True) -> np.ndarray:
        """Return the itinerary of the motion from a point of a section, with the code of its end as the last number.

        With ``learns`` an attractor that is found beyond the itinerary ends later itineraries.
        """
        before = None
        while True:
            state = self._point(section, x)
            code, count, mode = itinerary.itinerary(
                self.automaton.tables, self.known, self._absorbing, section.mode, state, *push, self._symbols
            )
            self._work += count
            if code != TOO_LONG or self._work > self._limit:
                return np.append(self._symbols[:count], -10 - code)
            label = self._explore(state, mode, learns)
            learned = len(self._absorbed)
            if not learns or (before is not None and (learned == before[0] or (state == before[1]).all())):
                return np.append(self._symbols[:count], _LATER + label)
            before = learned, state

    def _absorb_by_corner(self, section: LabelSection, side: int) -> None:
        """Add the part of a section, if any, from which motions shrink to the equilibrium 0 on its surface.

        The modes on both sides of the surface share this equilibrium, and near it the return map is linear. So what
        holds at one point holds at all nearer ones, if a motion that starts 10³ times nearer has the same itinerary.
        """
        width, found = ON_CYCLE * self.size[section.free], None
        while width < self.size[section.free]:
            there, nearer = (self._returned(section, side * part * width, 1) for part in (1.0, 1e-3))
            if there is None or nearer is None or there[0] != nearer[0] or not 0 < side * there[1] < width:
                break
            found, width = (section.mode, section.surface, *sorted((0.0, side * width))), 2 * width
        if found is not None:
            self._absorb(found, Attractor.STEADY_SLIDING)

    def _absorb(self, interval: tuple[float, ...], label: Attractor) -> None:
        self._absorbing = np.insert(self._absorbing, len(self._absorbed), interval, axis=0)
        self._absorbed.append(label)

    def _label(self, course: np.ndarray) -> int:
        if course[-1] >= _LATER + Attractor.UNRESOLVED:
            return int(course[-1]) - _LATER
        code = -10 - int(course[-1])
        if code < 0:
            return {DIVERGED: self.known.diverged, GRAZED: GRAZED, STUCK: UNKNOWN}.get(code, UNRESOLVED)
        index, kind = divmod(code, 3)
        return int((self.known.settled, self.known.resting, [*self._absorbed, *self._learned])[kind][index])

    def _labels(self, section: LabelSection) -> Pieces:
        """Return labels along a section; unresolved where motions that are pushed by rounding have different labels."""
        ends = self._ends(section)
        if not ends[0] < ends[1]:
            return Pieces([0.0, 0.0], [UNKNOWN])
        runs = [self._trimmed(section, self._pieces(section, _PUSHES[0], ends, learns=True))]
        if len(runs[0].labels) == 1:
            return runs[0]
        runs += [self._pushed(section, runs[0], push) for push in self._pushes]
        return agreed(runs, _ROUNDING * self.size[section.free])

    def _pushed(self, section: LabelSection, pieces: Pieces, push: tuple[float, bool]) -> Pieces:
        """Find the labels again for motions that are pushed, near the places of a section where labels change."""
        edges, labels = [pieces.edges[0]], [pieces.labels[0]]
        for before, cut, after, label in zip(
            pieces.edges, pieces.edges[1:], pieces.edges[2:], pieces.labels[1:], strict=False
        ):
            reach = _WINDOW * max(abs(cut), self.size[section.free])
            ends = max(cut - reach, 0.5 * (before + cut)), min(cut + reach, 0.5 * (cut + after))
            near = self._pieces(section, push, ends)
            edges += [*near.edges]
            labels += [*near.labels, label]
        return Pieces([*edges, pieces.edges[-1]], labels)

    def _trimmed(self, section: LabelSection, pieces: Pieces) -> Pieces:
        """Cut off ends of a section that lie outside its mode, where no motion enters it."""
        edges, labels = pieces
        if labels[0] == UNKNOWN and not self._belongs(section, self._point(section, edges[0])):
            edges, labels = edges[1:], labels[1:]
        if labels and labels[-1] == UNKNOWN and not self._belongs(section, self._point(section, edges[-1])):
            edges, labels = edges[:-1], labels[:-1]
        return Pieces(edges, labels) if labels else Pieces([0.0, 0.0], [UNKNOWN])

    def _pieces(
        self, section: LabelSection, push: tuple[float, bool], ends: tuple[float, float], learns: bool = False
    ) -> Pieces:
        """Return labels along a section between two ``ends``, by bisection between motions of different courses.

        With ``learns`` a label is used as soon as it is found: pieces nearer to the equilibrium come first, and the
        course of a motion ends where it returns to a place of known label. Narrow pieces wait for all others, so that
        one crowded place does not take the work from the rest of the section. If there are very many pieces, narrow
        ones whose ends have the same label are not divided further.
        """
        resolution = 1e-3 * flow_planar.EPS * self.size[section.free]
        waiting, found, splits, crowded = [(0, 0.0, *ends)], [], 0, _CROWDED
        while waiting:
            *_, low, high = heappop(waiting)
            known = len(self._absorbed)
            low_course, high_course = (self._course(section, x, push) for x in (low, high))
            if known != len(self._absorbed):  # new intervals may have changed the codes in either course
                low_course, high_course = (self._course(section, x, push, learns=False) for x in (low, high))
            position = _first_difference(low_course, high_course)
            narrow = splits > _MANY and high - low <= _NOISE * max(abs(low), abs(high))
            late = position == _EVENTS  # alike to the end of the itinerary: halves differ by their attractors
            if late and self._work <= self._limit and high - low > _NOISE * max(abs(low), abs(high)):
                for half in ((0.5 * (low + high), high), (low, 0.5 * (low + high))):
                    heappush(waiting, (*_turn(*half), *half))
                self._work += _SPLIT
                continue
            if position < 0 or narrow or late or self._work > self._limit:
                same = position < 0 or (narrow and self._label(low_course) == self._label(high_course))
                label = self._label(low_course) if same else UNRESOLVED
                found.append((low, high, label))
                if learns:
                    self._remember(section, low, high, label)
                    if label > UNRESOLVED and splits >= crowded:
                        crowded *= 2
                        self._extend(section, max(low, high, key=abs))
                continue
            here, there = itinerary.last_agreement(
                self.automaton.tables, self.known, self._absorbing, section.mode, section.surface,
                low, high, resolution, *push, low_course, position,
            )  # fmt: skip
            self._work += _SPLIT + _BISECTIONS * (position + 1)
            splits += 1
            for part in ((low, here), (there, high)):
                heappush(waiting, (*_turn(*part), *part))
        found.sort()
        edges, labels = [*(low for low, _, _ in found), ends[1]], [label for _, _, label in found]
        return merged(edges, labels, _SLIVER * self.size[section.free])

    def _extend(self, section: LabelSection, x: float) -> None:
        """Give its label to all motions that drift past a place beside a labelled piece, where a return hardly moves.

        The label is that of the place itself: the piece may end at a cycle that repels, and have another one.
        """
        place = x * (1.0 + _BESIDE)
        label = self._label(self._course(section, place, _PUSHES[0], learns=False))
        if label <= UNRESOLVED:
            return
        state = self._point(section, place)
        try:
            motion = follow(self.automaton, state, np.inf, mode=section.mode, max_events=_EVENTS)
        except EngineError:
            return
        size = np.abs(motion.after).max(axis=0, initial=0.0)
        for kind, time in zip(
            motion.kind[motion.mode == section.mode], motion.time[motion.mode == section.mode], strict=True
        ):
            line = return_map.ReturnSection(self.automaton, (int(kind), section.mode), state, size, 1, _PATIENT * time)
            if line.dimension == 1 and line.outcome(np.zeros(1))[1] is not None:
                ends = np.array([state, line.state(np.array([drift_two_states.reach_back(line, 0.0)]))])
                self._absorb_passage(Passage(section.mode, ends), Attractor(label))
                return

    def _remember(self, section: LabelSection, low: float, high: float, label: int) -> None:
        """Note the label of a piece of a section, so that later itineraries may end there; its ends are excluded."""
        pieces = self._found.setdefault(section, [])
        pieces.append((low, high, label))
        pieces.sort()
        sliver = _SLIVER * self.size[section.free]
        joined: list[tuple[float, float, int]] = []
        for low, high, label in pieces:
            touches = [one for one in joined[-2:] if one[2] == label]
            special = touches and len(joined) > 1 and touches[-1] is joined[-2] and touching(joined[-1], sliver)
            near = (
                4 * flow_planar.EPS * max(abs(low), 1e-3 * self.size[section.free])
            )  # places were bisected to this width
            if touches and touches[-1] is joined[-1] and low <= joined[-1][1] + near:
                joined[-1:] = [(joined[-1][0], high, label)]
            elif special and low <= joined[-1][1] + near and joined[-1][0] <= joined[-2][1] + near:
                joined[-2:] = [(joined[-2][0], high, label)]
            else:
                joined.append((low, high, label))
        self._found[section] = joined
        known = [
            (one, low + _SLIVER * (high - low), high - _SLIVER * (high - low), label)
            for one, parts in self._found.items()
            for low, high, label in parts
            if label > UNRESOLVED
        ]
        rows = [(one.mode, one.surface, low, high) for one, low, high, _ in known]
        self._learned = [Attractor(label) for _, _, _, label in known]
        self._absorbing = np.vstack([self._absorbing[: len(self._absorbed)], *rows])


def _turn(low: float, high: float) -> tuple[int, float]:
    """Return the place of a piece in the queue: wide ones first, among these the one nearest to the equilibrium."""
    width = (high - low) / max(abs(low), abs(high), 1e-300)
    return sum(width <= narrow for narrow in _NARROW), min(abs(low), abs(high))


def _first_difference(one: np.ndarray, other: np.ndarray) -> int:
    """Return the index at which two courses first differ; −1 if they do not."""
    size = min(one.size, other.size)
    different = np.flatnonzero(one[:size] != other[:size])
    return int(different[0]) if different.size else -1


def _same(one: SteadyState, other: SteadyState) -> bool:
    return one.label == other.label and abs(one.period - other.period) <= _ONE_CYCLE * one.period
