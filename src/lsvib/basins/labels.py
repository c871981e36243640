"""The fast map of a drive with two states: what becomes of motions from a surface, as a function of one coordinate.

A *section* is a mode together with a surface on which the mode is entered. After every event a motion with two states
is on a section or at rest, unless the event was its last one; so the label of a motion is that of its state after the
first event. Along a section the label is constant between finitely many points, which are found here to the last bit:
docs/attraction.md says how, and why comparing the *itineraries* of two ends – the guards of all events, the signs of
all conditions of their transitions – is enough. Rounding moves such a point; so starts within a band about it, far
wider than rounding, are unresolved.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from heapq import heappop, heappush
from typing import Any, NamedTuple

import numpy as np

from lsvib.basins.grid import Grid
from lsvib.basins.kernels import labels as kernels
from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED, Known
from lsvib.basins.mapper import NO_DOUBT, Mapper, Starts
from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, steady_state
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import event_loop, flow_planar, layout

_EVENTS = 100_000  # of a motion, after which its start is unresolved
_SYMBOLS = 256  # events of the longest itinerary; what a motion ends in that goes on is searched
_WORK = 500  # pieces into which sections may be divided for one drive, about a second
_FAR = 1e3  # sections are labelled up to so many times the size of the drive's motions
_ON_CYCLE = 1e-9  # a state this close to a point of a cycle, relative to the cycle's size, is on it
_BAND = 1e-12  # half width of the band about a change of label in which starts are unresolved, in sizes


class Section(NamedTuple):
    """A mode and a surface on which it is entered; ``free`` is the coordinate along the surface."""

    mode: int
    surface: int
    free: int


class Pieces(NamedTuple):
    """A function along a section that is constant between ``edges`` (n + 1), with ``labels`` (n)."""

    edges: list[float]
    labels: list[int]


class Sections:
    """Labels along all sections of a planar automaton.

    ``size`` (2) of u [rad] and w [rad/s] in its motions; ``known``, the table for the kernels; ``attractors`` that were
    found; ``complete``: whether the work sufficed; if it did not, motions that come to places without a label are to be
    followed further.
    """

    def __init__(self, automaton: Automaton) -> None:
        self.automaton = automaton
        self.size = _sizes(automaton)
        self.known = _nothing_known(automaton, self.size)
        self.attractors: list[SteadyState] = []
        self.complete = True
        self._absorbing = np.empty((0, 4))  # mode, surface and ends of absorbing intervals
        self._absorbed: list[int] = []  # and their labels
        self._work = self._limit = 0.0
        self._symbols = np.empty(_SYMBOLS, dtype=np.int64)
        sections, releases = find_sections(automaton, self.known), _releases(automaton, self.known)
        if automaton.contracts:  # all motions have one attractor
            rests = self.known.resting != UNKNOWN
            label = int(self.known.settled[~rests][0])
            found = {section: Pieces([-np.inf, np.inf], [label]) for section in sections}
            self.known.resting[rests] = label
            releases = releases if label == Attractor.STEADY_SLIDING else []
        else:
            for mode, state in releases:
                self.known.resting[mode] = self._search(state, mode)
            found = {}
            for k, section in enumerate(sections):  # a section passes on what it does not spend
                self._limit = self._work + (_WORK - self._work) / (len(sections) - k)
                found[section] = self._labels(section)
            self.complete = not any(UNKNOWN in pieces.labels for pieces in found.values())
        self.known = _with_labels(automaton, self.known, found, self.size)
        self._releases = releases

    @cached_property
    def timed(self) -> Known:
        """The table ``known`` with what tells when attractors are reached, by a kernel that labels do without."""
        return _with_cycles(self.automaton, self.known, self.attractors, self._releases)

    def _labels(self, section: Section) -> Pieces:
        """Return labels along a section, by bisection between motions of different courses, wide pieces first."""
        tables, size = self.automaton.tables, self.size[section.free]
        low, high = (end * size for end in self._ends(section))
        found: list[tuple[float, float, int]] = []
        waiting = [(-np.inf, low, high)] if low < high else []
        while waiting:
            _, low, high = heappop(waiting)
            intervals = len(self._absorbed)
            courses = [self._course(section, x) for x in (low, high)]
            if intervals != len(self._absorbed):  # new intervals may have changed the codes in either course
                courses = [self._course(section, x) for x in (low, high)]
            shorter = min(map(len, courses))
            differ = np.flatnonzero(courses[0][:shorter] != courses[1][:shorter])
            if not differ.size:
                found.append((low, high, self._label(courses[0])))
            elif differ[0] == _SYMBOLS or self._work > self._limit:
                found.append((low, high, UNKNOWN))
            else:
                self._work += 1
                resolution = 1e-3 * flow_planar.EPS * size
                course = courses[0][: differ[0] + 1]
                here, there = kernels.last_agreement(
                    tables, self.known, self._absorbing, section[:2], low, high, resolution, course
                )
                for part in ((low, here), (there, high)):
                    heappush(waiting, ((part[0] - part[1]) / max(*map(abs, part), 1e-300), *part))
        sliver = 1e-6 * size  # largest width of a piece whose motions touch a guard to rounding
        return _merged(sorted(found), sliver, _BAND * size)

    def _ends(self, section: Section) -> tuple[float, float]:
        """Return the part of a section, in sizes, where its mode can be entered: its guard rises, no other fired."""
        tables, origin = self.automaton.tables, self._point(section, 0.0)
        along = self._point(section, self.size[section.free]) - origin
        low, high = -_FAR, _FAR
        for guard in range(*tables.guard_start[section.mode : section.mode + 2]):
            u, w, constant = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard]]
            if tables.guard_surface[guard] == section.surface:
                flow = tables.flow[section.mode]
                u, w, constant = -w * flow[layout.A0], u - w * flow[layout.A1], w * flow[layout.B]
            slope, level = u * along[0] + w * along[1], u * origin[0] + w * origin[1] + constant
            rounding = _BAND * (abs(u * origin[0]) + abs(w * origin[1]) + abs(constant))
            if slope > 0:
                low = max(low, (rounding - level) / slope)
            elif slope < 0:
                high = min(high, (rounding - level) / slope)
            elif level < rounding:
                return 0.0, 0.0
        return low, high

    def _point(self, section: Section, x: float) -> np.ndarray:
        state = np.empty(2)
        state[section.free] = x
        kernels.put_on(self.automaton.tables, section.surface, state)
        return state

    def _course(self, section: Section, x: float) -> np.ndarray:
        """Return the itinerary of the motion from a point of a section, with what it ends in as the last number.

        That is −1 − code, or the label of the attractor where the itinerary does not end.
        """
        while True:
            state = self._point(section, x)
            code, count, mode = kernels.itinerary(
                self.automaton.tables, self.known, self._absorbing, section.mode, state, self._symbols
            )
            if code != kernels.TOO_LONG:
                return np.append(self._symbols[:count], -10 - code)
            intervals = len(self._absorbed)
            label = self._search(state, mode)
            if intervals == len(self._absorbed):
                return np.append(self._symbols[:count], label)

    def _label(self, course: np.ndarray) -> int:
        code = -10 - int(course[-1])
        if len(course) > _SYMBOLS:
            return int(course[-1])
        if code < 0:
            return self.known.diverged if code == kernels.DIVERGED else UNRESOLVED
        index, kind = divmod(code, 3)
        return int((self.known.settled, self.known.resting, self._absorbed)[kind][index])

    def _search(self, state: np.ndarray, mode: int) -> int:
        """Find the attractor of a motion; if it is a new cycle without rest, note an absorbing interval of it."""
        if self._work > _WORK:
            return UNRESOLVED
        found = steady_state(self.automaton, state, mode=mode, max_events=16_000)
        # A search takes as long as some pieces; where searches are in vain they are soon given up.
        self._work += _WORK / 4 if found.label == Attractor.UNRESOLVED else 8
        if found.orbit is None or any(one.label == found.label and one.same_period(found) for one in self.attractors):
            return int(found.label)
        self.attractors.append(found)
        orbit = found.orbit
        if orbit.time.size and (self.known.resting[orbit.arcs()[0]] == UNKNOWN).all():
            near = _ON_CYCLE * np.abs(orbit.after).max(axis=0)
            for section in find_sections(self.automaton, self.known):
                points = orbit.after[orbit.mode == section.mode]
                gaps = [np.abs(self._point(section, x[section.free]) - x) for x in points]
                visits = [x[section.free] for x, gap in zip(points, gaps, strict=True) if (gap <= near).all()]
                if visits and self._absorb(section, visits, near[section.free], int(found.label)):
                    break
        return int(found.label)

    def _absorb(self, section: Section, visits: Sequence[float], width: float, label: int) -> bool:
        """Double an interval around a point of a cycle while the return map takes it into itself; note the last."""
        x, found = visits[0], None
        while width < self.size[section.free]:
            one, other = (self._returned(section, x + side * width, len(visits)) for side in (-1, 1))
            if one is None or other is None or one[0] != other[0]:
                break
            if max(abs(one[1] - x), abs(other[1] - x)) >= width:
                break
            found, width = (section.mode, section.surface, x - width, x + width), 2 * width
        if found is not None:
            self._absorbing = np.vstack([self._absorbing, found])
            self._absorbed.append(label)
        return found is not None

    def _returned(self, section: Section, x: float, visits: int) -> tuple[list[bytes], float] | None:
        """Return itinerary and coordinate after so many returns to a section; None if it does not come back."""
        everywhere = np.array([[section.mode, section.surface, -np.inf, np.inf]])
        state, path = self._point(section, x), []
        for _ in range(visits):
            code, count, _ = kernels.itinerary(
                self.automaton.tables, self.known, everywhere, section.mode, state, self._symbols
            )
            if code != 2:
                return None
            path.append(self._symbols[:count].tobytes())
        return path, float(state[section.free])


def _merged(pieces: Sequence[tuple[float, float, int]], sliver: float, band: float) -> Pieces:
    """Join neighbours of one label, and what is unresolved in a ``sliver`` between them; put bands about changes."""
    joined: list[tuple[float, float, int]] = []
    for low, high, label in pieces:
        if len(joined) > 1 and joined[-2][2] == label and joined[-1][2] == UNRESOLVED and low - joined[-1][0] <= sliver:
            joined.pop()
        same = bool(joined) and joined[-1][2] == label
        joined.append((joined.pop()[0] if same else low, high, label))
    if not joined:
        return Pieces([], [])
    edges, labels = [joined[0][0]], [joined[0][2]]
    for cut, _, label in joined[1:]:
        edges += [cut - band, cut + band]
        labels += [UNRESOLVED, label]
    return Pieces([*edges, joined[-1][1]], labels)


def _sizes(automaton: Automaton) -> np.ndarray:
    """Return the sizes (2) of u [rad] and w [rad/s] in a drive's motions, from corners of surfaces and equilibria."""
    rows, flow = automaton.tables.surfaces, automaton.tables.flow
    stiff = flow[:, layout.A0] != 0
    tau = float(flow[stiff, layout.TIME_SCALE].max())
    points = [np.array([u, 0.0]) for u in flow[stiff, layout.EQUILIBRIUM]]
    with np.errstate(all="ignore"):  # what is beyond all numbers is no size
        for i, one in enumerate(rows):
            length = np.hypot(*one[:2])
            points.append(-(one[2] / length) * (one[:2] / length))  # of the line, what is nearest to the origin
            for other in rows[:i]:
                if one[0] * other[1] != one[1] * other[0]:
                    points.append(np.linalg.solve([one[:2], other[:2]], [-one[2], -other[2]]))
    points = [point for point in points if np.isfinite(point).all()]
    largest_u, largest_w = np.abs(points).max(axis=0).tolist()
    u = max(largest_u, largest_w * tau) or 1.0
    return np.minimum([u, u / tau], event_loop.LARGEST / _FAR)  # farther out motions have left the range of numbers


def _nothing_known(automaton: Automaton, size: np.ndarray) -> Known:
    """Return the tables of an automaton before anything is known of its sections; ``size`` as of :func:`_sizes`."""
    tables = automaton.tables
    modes, surfaces = len(tables.flow), len(tables.surfaces)
    rests = automaton.marked(automaton.codes, "rest")
    alpha, beta = tables.flow[:, layout.ALPHA], tables.flow[:, layout.BETA]
    undamped = np.where(beta > 0, Attractor.NEUTRAL_FAMILY, Attractor.UNBOUNDED)
    slip = np.where(alpha > 0, Attractor.STEADY_SLIDING, np.where(alpha < 0, Attractor.UNBOUNDED, undamped))
    turns = np.minimum(-2 * np.pi * alpha / np.where(beta > 0, beta, 1.0), flow_planar.OVERFLOW)
    return Known(
        landing=landings(automaton, rests),
        free=1 - tables.snap,
        first=np.zeros((modes, surfaces), dtype=np.int64),
        last=np.zeros((modes, surfaces), dtype=np.int64),
        edges=np.zeros(1),
        labels=np.full(1, UNKNOWN, dtype=np.int64),
        resting=np.where(rests, UNRESOLVED, UNKNOWN).astype(np.int64),
        settled=np.where(rests, Attractor.REST, slip).astype(np.int64),
        centred=np.where(rests, Attractor.REST, Attractor.STEADY_SLIDING).astype(np.int64),
        diverged=int(Attractor.UNBOUNDED),
        common=np.full(modes, UNKNOWN, dtype=np.int64),
        share=np.where(beta > 0, np.exp(turns), 0.0),
        reach=np.zeros(modes),
        trap=np.array([_trap(automaton, mode, size) for mode in range(modes)]),
        cycle_mode=np.empty(0, dtype=np.int64),
        cycle_state=np.empty((0, 2)),
        cycle_reach=np.empty((0, 2)),
        release=np.zeros((modes, 2)),
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


def _trap(automaton: Automaton, mode: int, size: np.ndarray) -> tuple[float, float, float]:
    """κ², ρ² of the largest ellipse η² + κ² y² < ρ² in which no guard of a damped mode fires, and ρ² of arrival."""
    # y = u − u_e, η = w + α y, κ = max(α, β). With y′ = η − α y, η′ = −α η − β² y (−δ² for β² if the roots are real)
    # the function falls at a rate of 2α − |κ² − β²| / κ at least, which is positive. It is e^{−2αt} exactly if κ = β.
    tables = automaton.tables
    row = tables.flow[mode]
    kappa, radius = max(row[layout.ALPHA], row[layout.BETA]), np.inf
    if not (row[layout.ALPHA] > 0 and row[layout.A0] > 0 and kappa < event_loop.LARGEST):  # whose square overflows
        return 0.0, 0.0, 0.0
    with np.errstate(all="ignore"):  # a guard that hardly depends on the state is beyond all numbers: so is the square
        for guard in range(*tables.guard_start[mode : mode + 2]):
            u, w, constant = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard]]
            least = constant + u * row[layout.EQUILIBRIUM]
            slack = 64 * flow_planar.EPS * (abs(constant) + abs(u * row[layout.EQUILIBRIUM]))
            radius = min(radius, max(0.0, least - slack) / np.hypot(w, (u - row[layout.ALPHA] * w) / kappa))
        if radius == np.inf:
            radius = float(size[1])
        return kappa**2, radius**2, max(radius, _ON_CYCLE * size[1]) ** 2


def find_sections(automaton: Automaton, known: Any) -> list[Section]:  # Known, or Pieces of a law
    """Return the modes of slip with the surfaces on which events enter them."""
    tables, found = automaton.tables, set()
    for transition in np.flatnonzero(known.landing >= 0):
        surface = int(known.landing[transition])
        for mode in tables.branch_mode[slice(*tables.branch_start[transition : transition + 2])].tolist():
            if known.resting[mode] == UNKNOWN:
                found.add(Section(mode, surface, int(known.free[surface])))
    return sorted(found)


def _releases(automaton: Automaton, known: Known) -> list[tuple[int, np.ndarray]]:
    """Return the modes at rest, each with the one state in which it ends."""
    tables, found = automaton.tables, []
    for mode in np.flatnonzero(known.resting != UNKNOWN):
        enters = np.flatnonzero(tables.branch_mode == mode)
        transitions = np.searchsorted(tables.branch_start, enters, "right") - 1
        surface = tables.surfaces[known.landing[transitions].max()]
        guard = tables.surfaces[tables.guard_surface[tables.guard_start[mode]]]
        found.append((int(mode), np.linalg.solve([surface[:2], guard[:2]], [-surface[2], -guard[2]])))
    return found


def _with_labels(automaton: Automaton, known: Known, found: Mapping[Section, Pieces], size: np.ndarray) -> Known:
    """Add the labels of sections, and one for a whole mode where all sections that it leads to have no other."""
    tables, edges, labels = automaton.tables, [0.0], [UNKNOWN]
    for (mode, surface, _), pieces in found.items():
        if pieces.labels:
            known.first[mode, surface] = len(edges)
            edges += pieces.edges
            labels += [*pieces.labels, UNKNOWN]
            known.last[mode, surface] = len(edges) - 1
    for mode in np.flatnonzero(known.resting == UNKNOWN).tolist():
        ends = set()
        for transition in tables.guard_transition[slice(*tables.guard_start[mode : mode + 2])]:
            surface = int(known.landing[transition])
            for after in tables.branch_mode[slice(*tables.branch_start[transition : transition + 2])].tolist():
                section = Section(after, surface, int(known.free[surface]))
                ends |= set(found[section].labels) if section in found else {int(known.resting[after])}
        row, kappa = tables.flow[mode], np.sqrt(known.trap[mode, 0])
        if len(ends) == 1 and kappa > 0:
            known.common[mode] = ends.pop()
            # An arc from within the ellipse of size F² stays in it: |y| ≤ F / κ and |w| ≤ F (1 + α / κ).
            room = max(0.0, _FAR * size[0] - abs(row[layout.EQUILIBRIUM]))
            known.reach[mode] = min(kappa * room, _FAR * size[1] / (1 + row[layout.ALPHA] / kappa)) ** 2
    return known._replace(edges=np.array(edges), labels=np.array(labels, dtype=np.int64))


def _with_cycles(
    automaton: Automaton, known: Known, attractors: Sequence[SteadyState], releases: Sequence[tuple[int, np.ndarray]]
) -> Known:
    """Add the points of the cycles, and what follows the end of rest."""
    orbits = [found.orbit for found in attractors if found.orbit is not None and found.orbit.time.size]
    if orbits:
        known = known._replace(
            cycle_mode=np.concatenate([orbit.mode for orbit in orbits]),
            cycle_state=np.concatenate([orbit.after for orbit in orbits]),
            cycle_reach=np.concatenate([0 * o.after + _ON_CYCLE * np.abs(o.after).max(axis=0) for o in orbits]),
        )
    tables, sprags = automaton.tables, np.array([*automaton.marks["impact"]], dtype=np.int64)
    for mode, state in releases:
        leads, size = tables.guard_transition[tables.guard_start[mode]], np.abs(state)
        branch, scratch = event_loop.choose_branch(tables, leads, state, size), kernels.new_scratch(tables)
        scratch.now.state[:], scratch.now.scale[:] = state, size
        known.release[mode] = kernels.approach(tables, known, sprags, tables.branch_mode[branch], scratch, _EVENTS)
    return known


class PlanarMapper(Mapper):
    """Maps the starts of a drive with two states: each is looked up in the table of :class:`Sections`.

    * ``label``: the attractor (``lsvib.dynamics.attractor.Attractor``); unresolved (−1) is a start that lies on a
      boundary to rounding or, where the table has gaps, one whose motion comes to none of its labels in time. ``doubt``
      says which of the two it is.
    * ``time`` [s] until it is reached: for steady sliding the entry into the largest ellipse around the equilibrium in
      which no guard can fire (closed form); for a cycle the first event after which the motion is on it to 1e-9 of its
      size; infinite if the motion is unbounded or unresolved.
    * ``seizures`` until then, and ``first_event``: kind of the first event of the motion, −1 if there is none.

    No time of waiting enters. ``attractors`` are the cycles that motions reach (``SteadyState``).
    """

    block = 16384  # a thread works on one block at a time

    def __init__(self, automaton: Automaton, starts: Starts) -> None:
        super().__init__(automaton, starts)
        self.sections = Sections(self.automaton)
        self.attractors = self.sections.attractors
        self._events = _EVENTS if self.sections.complete else _SYMBOLS  # in gaps many motions go on and on
        # Why a start is unresolved, if it is.
        self.doubt = Doubt.ROUNDING if self.sections.complete else Doubt.EVENT_BUDGET
        self._sprags = np.array([*self.automaton.marks["impact"]], dtype=np.int64)

    def fill(
        self, found: Mapping[str, np.ndarray], grid: Grid, x: np.ndarray, y: np.ndarray, quantities: Sequence[str]
    ) -> None:
        """Fill arrays; times of unresolved cells are infinite, and all cells have the same doubt, if any."""
        tables, known = self.automaton.tables, self.sections.known
        cells = kernels.Cells(x, y, int(grid.x.coordinate == "w"))
        labels, times = found["label"], found["time"]
        first_events = found["first_event"][:, : x.size if "first_event" in quantities else 0]
        kernels.map_labels(tables, known, cells, self._events, labels, first_events)
        if not {"time", "seizures"}.isdisjoint(quantities):
            kernels.map_approaches(tables, self.sections.timed, self._sprags, cells, _EVENTS, times, found["seizures"])
            times[labels == UNRESOLVED] = np.inf
        if "doubt" in quantities:
            found["doubt"][:] = np.where(labels == UNRESOLVED, list(Doubt).index(self.doubt), NO_DOUBT)
