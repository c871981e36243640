"""The courses of motions from a section: their itineraries, up to where the rest of the motion is known.

It is known (i) at rest, because every rest ends in the same state; (ii) where the motion settles; (iii) in an
*absorbing interval* around a point of a cycle. The return map takes this interval into itself, and it is monotone there
because both ends have the same itinerary; so all motions that enter the interval go on for ever as the cycle does.
"""

import numpy as np

from lsvib.basins.kernels import itinerary
from lsvib.basins.kernels.itinerary import DIVERGED, GRAZED, STUCK, TOO_LONG
from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED
from lsvib.basins.section_tables import ON_CYCLE, LabelSection, find_sections, nothing_known, sizes
from lsvib.dynamics.attractors import Attractor, Passage, SteadyState, steady_state
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar

Stretch = tuple[float, float]  # coordinates of two points of a section
Push = tuple[float, bool]  # relative change of the coordinate after every event, and whether its sign alternates
EVENTS = 256  # longest itinerary; a motion that goes on is labelled by a search for its attractor
_HASTE = 16  # events after which a motion that hardly moves is leapt over
WORK = 20_000_000  # events that may be followed for one drive; they take a few seconds
_LEAPS_COST = 400_000  # events that take about as long as a search by leaps
_COST = 60_000  # events that take about as long as a search for an attractor
_LATER = 1000  # plus the label of an attractor that was found beyond the itinerary, it is the code at a course's end
_FUTILE = 8  # searches without a result after which none is made: motions stay that long only near a repelling cycle
_IN_VAIN = 20  # searches that leapt over nothing, after which motions are followed without leaps


class Courses:
    """The sections of a planar automaton, and what is known of the motions from them.

    ``size`` (2) of u [rad] and w [rad/s] in its motions; ``known``, the table for the kernels; ``attractors`` that were
    found; ``absorbing`` (k, 4), mode, surface and ends of the intervals in which an itinerary ends; ``work``, events
    that were followed, of which ``limit`` may be.
    """

    def __init__(self, automaton: Automaton) -> None:
        self.automaton = automaton
        self.size = sizes(automaton)
        self.known = nothing_known(automaton, self.size)
        self.sections = find_sections(automaton, self.known)
        self.attractors: list[SteadyState] = []
        self.absorbing = np.empty((0, 4))
        self.absorbed: list[Attractor] = []
        self._learned: list[Attractor] = []
        self.work = self._futile = self._in_vain = 0
        self.limit: float = WORK
        self._symbols = np.empty(EVENTS, dtype=np.int64)

    @property
    def spent(self) -> bool:
        """Whether more events were followed than may be."""
        return self.work > self.limit

    def point(self, section: LabelSection, x: float) -> np.ndarray:
        """Return the state (2) of a point of a section."""
        state = np.empty(2)
        state[section.free] = x
        itinerary.put_on(self.automaton.tables, section.surface, state)
        return state

    def belongs(self, section: LabelSection, x: float) -> bool:
        """Tell whether a point of a section lies in its mode, so that no other guard has fired already."""
        tables, state = self.automaton.tables, self.point(section, x)
        guards = slice(*tables.guard_start[section.mode : section.mode + 2])
        rows = tables.surfaces[tables.guard_surface[guards]]
        values = tables.guard_sign[guards] * (rows[:, :2] @ state + rows[:, 2])
        return bool((values[tables.guard_surface[guards] != section.surface] >= 0).all())

    def explore(self, state: np.ndarray, mode: int, learns: bool = True) -> Attractor:
        """Find the attractor of a motion; if it is a new cycle without rest, note an absorbing interval of it."""
        if self._futile > _FUTILE:
            return Attractor.UNRESOLVED
        patience = _HASTE if self._in_vain < _IN_VAIN else _COST
        found = steady_state(self.automaton, state, mode=mode, max_events=_COST, patience=patience)
        if found.label == Attractor.UNRESOLVED:
            self._futile += 1
            self.work += (WORK - self.work) // _FUTILE  # where nothing is found, less is spent
        self._in_vain += not found.passages
        self.work += _COST if patience == _COST else _LEAPS_COST
        if not learns:
            return found.label
        for passage in found.passages if found.label != Attractor.UNRESOLVED else ():
            self.absorb_passage(passage, found.label)
        if found.orbit is None or any(one.label == found.label and one.same_period(found) for one in self.attractors):
            return found.label
        self.attractors.append(found)
        if (self.known.resting[found.orbit.arcs()[0]] == UNKNOWN).all():
            interval = self._absorbing_interval(found)
            if interval is not None:
                self._absorb(interval, found.label)
        return found.label

    def absorb_passage(self, passage: Passage, label: Attractor) -> None:
        """Add a stretch of a section from which all motions were found to have one label."""
        for section in self.sections:
            points = [self.point(section, x) for x in passage.ends[:, section.free]]
            near = ON_CYCLE * np.abs(passage.ends).max(axis=0)
            if section.mode == passage.mode and (np.abs(points - passage.ends) <= near).all():
                low, high = sorted(passage.ends[:, section.free])
                same = (self.absorbing[:, 0] == section.mode) & (self.absorbing[:, 1] == section.surface)
                if not (same & (self.absorbing[:, 2] <= low) & (high <= self.absorbing[:, 3])).any():
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
            points = [x for x in points if (np.abs(self.point(section, x[section.free]) - x) <= near).all()]
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
        state, path = self.point(section, x), []
        for _ in range(visits):
            code, count, _ = itinerary.itinerary(
                self.automaton.tables, self.known, everywhere, section.mode, state, 0.0, False, self._symbols
            )
            if code != 2:
                return None
            path.append(self._symbols[:count].tobytes())
        return path, float(state[section.free])

    def course(self, section: LabelSection, x: float, push: Push, learns: bool = True) -> np.ndarray:
        """Return the itinerary of the motion from a point of a section, with the code of its end as the last number.

        With ``learns`` an attractor that is found beyond the itinerary ends later itineraries.
        """
        before = None
        while True:
            state = self.point(section, x)
            code, count, mode = itinerary.itinerary(
                self.automaton.tables, self.known, self.absorbing, section.mode, state, *push, self._symbols
            )
            self.work += count
            if code != TOO_LONG or self.spent:
                return np.append(self._symbols[:count], -10 - code)
            label = self.explore(state, mode, learns)
            learned = len(self.absorbed)
            if not learns or (before is not None and (learned == before[0] or (state == before[1]).all())):
                return np.append(self._symbols[:count], _LATER + label)
            before = learned, state

    def absorb_by_corner(self, section: LabelSection, side: int) -> None:
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
        self.absorbing = np.insert(self.absorbing, len(self.absorbed), interval, axis=0)
        self.absorbed.append(label)

    def label(self, course: np.ndarray) -> int:
        """Return the label of a motion by its course."""
        if course[-1] >= _LATER + Attractor.UNRESOLVED:
            return int(course[-1]) - _LATER
        code = -10 - int(course[-1])
        if code < 0:
            return {DIVERGED: self.known.diverged, GRAZED: GRAZED, STUCK: UNKNOWN}.get(code, UNRESOLVED)
        index, kind = divmod(code, 3)
        return int((self.known.settled, self.known.resting, [*self.absorbed, *self._learned])[kind][index])

    def learn(self, pieces: list[tuple[LabelSection, float, float, int]]) -> None:
        """End later itineraries in these pieces of sections, with their labels, instead of those learned before."""
        rows = [(one.mode, one.surface, low, high) for one, low, high, _ in pieces]
        self._learned = [Attractor(label) for _, _, _, label in pieces]
        self.absorbing = np.vstack([self.absorbing[: len(self.absorbed)], *rows])

    def parting(self, section: LabelSection, ends: Stretch, push: Push, course: np.ndarray, position: int) -> Stretch:
        """Return the neighbours between two ``ends`` between which ``course``, of the lower one, ends at a position."""
        resolution = 1e-3 * flow_planar.EPS * self.size[section.free]
        return itinerary.last_agreement(
            self.automaton.tables, self.known, self.absorbing, section.mode, section.surface,
            *ends, resolution, *push, course, position,
        )  # fmt: skip
