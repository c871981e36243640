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

An itinerary ends where the rest of the motion is known (:mod:`lsvib.basins.section_courses`). Where the itineraries of
the ends of an interval differ, bisection finds the point up to which the itinerary of one end holds, and both parts are
examined again. Nothing else is assumed. The effect of rounding on such a point is measured: the search is repeated with
motions that are pushed by a few units of rounding after every event, and the starts for which the results differ are
labelled unresolved.
"""

from heapq import heappop, heappush

import numpy as np

from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED
from lsvib.basins.pieces import Pieces, agreed, completed, merged, opened, touching
from lsvib.basins.section_courses import EVENTS, WORK, Courses, Push, Stretch
from lsvib.basins.section_tables import FAR, LabelSection, releases_of, with_common_labels, with_cycles, with_labels
from lsvib.dynamics import drift_two_states, return_map
from lsvib.dynamics.attractors import Attractor, Passage
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar, layout
from lsvib.engine.motion import follow
from lsvib.errors import EngineError

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
_PROBES = (-0.5 * FAR, -30.0, -1.0, -0.1, 0.1, 1.0, 30.0, 0.5 * FAR)  # first starts, in sizes of the drive's motions
_WINDOW = 1e-4  # relative half width around a change of label in which motions are pushed
_SLIVER = 1e-6  # largest relative width of a piece whose motions touch a guard to rounding
_ROUNDING = 64 * flow_planar.EPS  # push after every event, relative to the terms that the state was computed from
_PUSHES = ((0.0, False), *((side * _ROUNDING, alternate) for side in (-1, 1) for alternate in (False, True)))


class Sections:
    """Labels along all sections of a planar automaton: ``known``, the table for the kernels; ``courses``, by which.

    ``complete``: whether the work sufficed; if it did not, motions that come to places without a label are to be
    followed further. Without ``rounding`` a start whose label is decided by rounding has one of the labels beside it
    instead of none.
    """

    def __init__(self, automaton: Automaton, rounding: bool = True) -> None:
        self.automaton = automaton
        self._pushes = _PUSHES[1:] if rounding else ()
        self.courses = courses = Courses(automaton)
        self.size, self.known = courses.size, courses.known
        self.complete = True
        self._found: dict[LabelSection, list[tuple[float, float, int]]] = {}
        if automaton.contracts:
            self._same_for_all()
            return
        for section in courses.sections:
            if not (courses.point(section, 0.0).any() or automaton.tables.flow[section.mode, layout.EQUILIBRIUM]):
                courses.absorb_by_corner(section, 1)
                courses.absorb_by_corner(section, -1)
        releases = releases_of(automaton, self.known)
        for mode, state in releases:
            self.known.resting[mode] = courses.explore(state, mode)
        for section in courses.sections:
            for part in _PROBES:
                x = part * self.size[section.free]
                if courses.belongs(section, x):
                    courses.course(section, x, _PUSHES[0])  # finds its attractor, if that is not known yet
        found = self._all_labels()
        self.complete = courses.work < WORK
        if not self.complete:  # what is left of a crowded section is no boundary
            found = {section: opened(pieces, _NOISE) for section, pieces in found.items()}
        self.known = with_common_labels(automaton, with_labels(self.known, found), found, self.size)
        self.known = with_cycles(automaton, self.known, courses.attractors, releases)

    def _same_for_all(self) -> None:
        """Fill the table for a drive all of whose motions have one attractor."""
        slips = self.known.resting == UNKNOWN
        label = self.known.settled[slips][0]  # damped slip ends in steady sliding, undamped slip in a neutral family
        found = {section: Pieces([-np.inf, np.inf], [int(label)]) for section in self.courses.sections}
        self.known.resting[~slips] = label
        self.known = with_common_labels(self.automaton, with_labels(self.known, found), found, self.size)

    def _all_labels(self) -> dict[LabelSection, Pieces]:
        """Return labels along all sections; what is unresolved is tried again when the others are known."""
        found: dict[LabelSection, Pieces] = {}
        for part in (_FIRST_ROUND, 1.0):
            open_ones = [one for one in self.courses.sections if one not in found or UNRESOLVED in found[one].labels]
            for k, section in enumerate(open_ones):
                share = 1.0 if part == 1.0 else 1.0 / (len(open_ones) - k)  # a section passes on what it does not spend
                self.courses.limit = self.courses.work + share * max(part * WORK - self.courses.work, 0.0)
                self._found.pop(section, None)
                labels = self._labels(section)
                found[section] = completed(labels, found[section]) if section in found else labels
        return found

    def _ends(self, section: LabelSection) -> Stretch:
        """Return the part of a section on which its mode can be entered: its guard rises, and no other has fired."""
        tables, origin = self.automaton.tables, self.courses.point(section, 0.0)
        along = self.courses.point(section, self.size[section.free]) - origin
        rows = []
        for guard in range(*tables.guard_start[section.mode : section.mode + 2]):
            u, w, constant = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard]]
            if tables.guard_surface[guard] == section.surface:
                flow = tables.flow[section.mode]
                u, w, constant = -w * flow[layout.A0], u - w * flow[layout.A1], w * flow[layout.B]
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

    def _pushed(self, section: LabelSection, pieces: Pieces, push: Push) -> Pieces:
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
        if labels[0] == UNKNOWN and not self.courses.belongs(section, edges[0]):
            edges, labels = edges[1:], labels[1:]
        if labels and labels[-1] == UNKNOWN and not self.courses.belongs(section, edges[-1]):
            edges, labels = edges[:-1], labels[:-1]
        return Pieces(edges, labels) if labels else Pieces([0.0, 0.0], [UNKNOWN])

    def _pieces(self, section: LabelSection, push: Push, ends: Stretch, learns: bool = False) -> Pieces:
        """Return labels along a section between two ``ends``, by bisection between motions of different courses.

        With ``learns`` a label is used as soon as it is found: pieces nearer to the equilibrium come first, and the
        course of a motion ends where it returns to a place of known label. Narrow pieces wait for all others, so that
        one crowded place does not take the work from the rest of the section. If there are very many pieces, narrow
        ones whose ends have the same label are not divided further.
        """
        waiting, found, splits, crowded = [(0, 0.0, *ends)], [], 0, _CROWDED
        while waiting:
            *_, low, high = heappop(waiting)
            known = len(self.courses.absorbed)
            low_course, high_course = (self.courses.course(section, x, push) for x in (low, high))
            if known != len(self.courses.absorbed):  # new intervals may have changed the codes in either course
                low_course, high_course = (self.courses.course(section, x, push, learns=False) for x in (low, high))
            position = _first_difference(low_course, high_course)
            narrow = splits > _MANY and high - low <= _NOISE * max(abs(low), abs(high))
            late = position == EVENTS  # alike to the end of the itinerary: halves differ by their attractors
            if late and not self.courses.spent and high - low > _NOISE * max(abs(low), abs(high)):
                for half in ((0.5 * (low + high), high), (low, 0.5 * (low + high))):
                    heappush(waiting, (*_turn(*half), *half))
                self.courses.work += _SPLIT
                continue
            if position < 0 or narrow or late or self.courses.spent:
                same = position < 0 or (narrow and self.courses.label(low_course) == self.courses.label(high_course))
                label = self.courses.label(low_course) if same else UNRESOLVED
                found.append((low, high, label))
                if learns:
                    self._remember(section, low, high, label)
                    if label > UNRESOLVED and splits >= crowded:
                        crowded *= 2
                        self._extend(section, max(low, high, key=abs))
                continue
            here, there = self.courses.parting(section, (low, high), push, low_course, position)
            self.courses.work += _SPLIT + _BISECTIONS * (position + 1)
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
        label = self.courses.label(self.courses.course(section, place, _PUSHES[0], learns=False))
        if label <= UNRESOLVED:
            return
        state = self.courses.point(section, place)
        try:
            motion = follow(self.automaton, state, np.inf, mode=section.mode, max_events=EVENTS)
        except EngineError:
            return
        size = np.abs(motion.after).max(axis=0, initial=0.0)
        seen = motion.mode == section.mode
        for kind, time in zip(motion.kind[seen], motion.time[seen], strict=True):
            line = return_map.ReturnSection(self.automaton, (int(kind), section.mode), state, size, 1, _PATIENT * time)
            if line.dimension == 1 and line.outcome(np.zeros(1))[1] is not None:
                ends = np.array([state, line.state(np.array([drift_two_states.reach_back(line)]))])
                self.courses.absorb_passage(Passage(section.mode, ends), Attractor(label))
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
            # Places were bisected to this width.
            near = 4 * flow_planar.EPS * max(abs(low), 1e-3 * self.size[section.free])
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
        self.courses.learn(known)


def _turn(low: float, high: float) -> tuple[int, float]:
    """Return the place of a piece in the queue: wide ones first, among these the one nearest to the equilibrium."""
    width = (high - low) / max(abs(low), abs(high), 1e-300)
    return sum(width <= narrow for narrow in _NARROW), min(abs(low), abs(high))


def _first_difference(one: np.ndarray, other: np.ndarray) -> int:
    """Return the index at which two courses first differ; −1 if they do not."""
    size = min(one.size, other.size)
    different = np.flatnonzero(one[:size] != other[:size])
    return int(different[0]) if different.size else -1
