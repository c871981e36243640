"""The tables that the kernels of :mod:`lsvib.basins.kernels.labels` work with."""

from typing import NamedTuple

import numpy as np

from lsvib.basins.kernels import arrival, labels
from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED, Known
from lsvib.basins.pieces import Pieces
from lsvib.dynamics.attractors import Attractor, SteadyState
from lsvib.dynamics.return_section import nearest_to_origin
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import event_loop, flow_planar, layout

FAR = 1e3  # Sections are labelled up to so many times the size of the drive's motions.
ON_CYCLE = 1e-9  # A state this close to a point of a cycle, relative to the cycle's size, is on it.
_EVENTS = 4000  # most events between the end of a rest and the attractor


class LabelSection(NamedTuple):
    """A mode and a surface on which it is entered; ``free`` is the coordinate along the surface."""

    mode: int
    surface: int
    free: int


def sizes(automaton: Automaton) -> np.ndarray:
    """Return the sizes (2) of u [rad] and w [rad/s] in a drive's motions, from corners of surfaces and equilibria."""
    rows, flow = automaton.tables.surfaces, automaton.tables.flow
    stiff = flow[:, layout.A0] != 0
    tau = float(flow[stiff, layout.TIME_SCALE].max())
    points = [np.array([u, 0.0]) for u in flow[stiff, layout.EQUILIBRIUM]]
    for i, one in enumerate(rows):
        point = nearest_to_origin(one)
        if point is not None:
            points.append(point)
        for other in rows[:i]:
            if one[0] * other[1] != one[1] * other[0]:
                points.append(np.linalg.solve([one[:2], other[:2]], [-one[2], -other[2]]))
    largest_u, largest_w = np.abs(points).max(axis=0).tolist()
    u = max(largest_u, largest_w * tau) or 1.0
    return np.minimum([u, u / tau], event_loop.LARGEST / FAR)  # farther out motions have left the range of numbers


def nothing_known(automaton: Automaton, size: np.ndarray) -> Known:
    """Return the tables of an automaton before anything is known of its sections; ``size`` as of :func:`sizes`, (2)."""
    tables = automaton.tables
    modes, surfaces = len(tables.flow), len(tables.surfaces)
    rests = np.isin(automaton.codes, automaton.rest_codes)
    alpha = tables.flow[:, layout.ALPHA]
    settled = np.where(alpha > 0, Attractor.STEADY_SLIDING, np.where(alpha < 0, Attractor.UNBOUNDED, 0))
    undamped = (alpha == 0) & ~rests
    settled[undamped] = np.where(tables.flow[undamped, layout.BETA] > 0, Attractor.NEUTRAL_FAMILY, Attractor.UNBOUNDED)
    settled[rests] = Attractor.REST
    return Known(
        landing=_landings(automaton, rests),
        free=1 - tables.snap,
        first=np.zeros((modes, surfaces), dtype=np.int64),
        last=np.zeros((modes, surfaces), dtype=np.int64),
        edges=np.zeros(1),
        labels=np.full(1, UNKNOWN, dtype=np.int64),
        resting=np.where(rests, UNRESOLVED, UNKNOWN).astype(np.int64),
        settled=settled.astype(np.int64),
        centred=np.where(rests, Attractor.REST, Attractor.STEADY_SLIDING).astype(np.int64),
        diverged=int(Attractor.UNBOUNDED),
        common=np.full(modes, UNKNOWN, dtype=np.int64),
        share=_shares(tables.flow),
        reach=np.zeros(modes),
        trap=np.array([_trap(automaton, mode, size) for mode in range(modes)]),
        cycle_mode=np.empty(0, dtype=np.int64),
        cycle_state=np.empty((0, 2)),
        cycle_reach=np.empty((0, 2)),
        release=np.zeros((modes, 2)),
    )


def _landings(automaton: Automaton, rests: np.ndarray) -> np.ndarray:
    """The surface on which each transition leaves the state; −1 for the entry and on release, which is at a corner."""
    tables = automaton.tables
    landing = np.full(tables.transition_reset.size, -1, dtype=np.int64)
    for mode in np.flatnonzero(~rests):
        for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
            transition = tables.guard_transition[guard]
            reset = tables.transition_reset[transition]
            landing[transition] = tables.guard_surface[guard]
            if reset >= 0:
                image = tables.surfaces[:, :2] @ tables.resets[reset]
                image[:, 2] += tables.surfaces[:, 2]
                landing[transition] = int(np.flatnonzero((image == 0).all(axis=1))[0])
    return landing


def find_sections(automaton: Automaton, known: Known) -> list[LabelSection]:
    """Return the modes of slip with the surfaces on which events enter them."""
    tables, found = automaton.tables, set()
    for transition, surface in enumerate(known.landing):
        if surface >= 0:
            branches = range(tables.branch_start[transition], tables.branch_start[transition + 1])
            modes = {int(tables.branch_mode[branch]) for branch in branches}
            found |= {(mode, int(surface)) for mode in modes if known.resting[mode] == UNKNOWN}
    return [LabelSection(mode, surface, int(known.free[surface])) for mode, surface in sorted(found)]


def releases_of(automaton: Automaton, known: Known) -> list[tuple[int, np.ndarray]]:
    """Return the modes at rest, each with the one state in which it ends."""
    tables, found = automaton.tables, []
    for mode in np.flatnonzero(known.resting != UNKNOWN):
        enters = np.flatnonzero(tables.branch_mode == mode)
        transitions = np.searchsorted(tables.branch_start, enters, "right") - 1
        surface = tables.surfaces[known.landing[transitions].max()]
        guard = tables.surfaces[tables.guard_surface[tables.guard_start[mode]]]
        corner = np.linalg.solve([surface[:2], guard[:2]], [-surface[2], -guard[2]])
        found.append((int(mode), corner))
    return found


def _trap(automaton: Automaton, mode: int, size: np.ndarray) -> tuple[float, float, float]:
    """κ², ρ² of the largest ellipse η² + κ² y² < ρ² in which no guard of a damped mode fires, and ρ² of arrival.

    y = u − u_e, η = w + α y, κ = max(α, β). With y′ = η − α y and η′ = −α η − β² y (−δ² for β² if the roots are real)
    the function falls at a rate of 2α − |κ² − β²| / κ at least, which is positive. It is e^{−2αt} exactly if κ = β.
    """
    tables = automaton.tables
    row = tables.flow[mode]
    kappa, radius = max(row[layout.ALPHA], row[layout.BETA]), np.inf
    if not (row[layout.ALPHA] > 0 and row[layout.A0] > 0 and kappa < event_loop.LARGEST):  # whose square overflows
        return 0.0, 0.0, 0.0
    with np.errstate(all="ignore"):  # a guard that hardly depends on the state is beyond all numbers: so is the square
        for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
            u, w, constant = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard]]
            least = constant + u * row[layout.EQUILIBRIUM]
            slack = 64 * flow_planar.EPS * (abs(constant) + abs(u * row[layout.EQUILIBRIUM]))
            radius = min(radius, max(0.0, least - slack) / np.hypot(w, (u - row[layout.ALPHA] * w) / kappa))
        if radius == np.inf:
            radius = float(size[1])
        return kappa**2, radius**2, max(radius, ON_CYCLE * size[1]) ** 2


def with_labels(known: Known, found: dict[LabelSection, Pieces]) -> Known:
    """Return ``known`` with the labels of sections."""
    first, last, edges, labels = np.zeros_like(known.first), np.zeros_like(known.last), [], []
    for section, pieces in found.items():
        first[section.mode, section.surface] = len(edges)
        edges += pieces.edges
        labels += [*pieces.labels, UNKNOWN]
        last[section.mode, section.surface] = len(edges) - 1
    return known._replace(first=first, last=last, edges=np.array(edges), labels=np.array(labels, dtype=np.int64))


def _shares(flow: np.ndarray) -> np.ndarray:
    """Return the part of an amplitude that is left after a turn; 0 for modes that do not oscillate."""
    beta = flow[:, layout.BETA]
    turns = -2 * np.pi * flow[:, layout.ALPHA] / np.where(beta > 0, beta, 1.0)
    return np.where(beta > 0, np.exp(np.minimum(turns, flow_planar.OVERFLOW)), 0.0)


def with_common_labels(
    automaton: Automaton, known: Known, found: dict[LabelSection, Pieces], size: np.ndarray
) -> Known:
    """Add one label for a whole mode where all sections that can be reached from it have that label.

    An arc from within the ellipse of size F² stays in it, so that its coordinates are bounded by |y| ≤ F / κ and
    |w| ≤ F (1 + α / κ): with a ``reach`` F² that keeps both within the known part of the sections.
    """
    tables = automaton.tables
    for mode in np.flatnonzero(known.resting == UNKNOWN):
        labels = set()
        for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
            transition = tables.guard_transition[guard]
            surface = int(known.landing[transition])
            for after in tables.branch_mode[tables.branch_start[transition] : tables.branch_start[transition + 1]]:
                if known.resting[after] != UNKNOWN:
                    labels.add(int(known.resting[after]))
                else:
                    labels |= set(found[LabelSection(int(after), surface, int(known.free[surface]))].labels)
        row, kappa = tables.flow[mode], np.sqrt(known.trap[mode, 0])
        if len(labels) == 1 and kappa > 0:
            known.common[mode] = labels.pop()
            room = max(0.0, FAR * size[0] - abs(row[layout.EQUILIBRIUM]))
            known.reach[mode] = min(kappa * room, FAR * size[1] / (1 + row[layout.ALPHA] / kappa)) ** 2
    return known


def with_cycles(automaton: Automaton, known: Known, attractors: list[SteadyState], releases) -> Known:
    """Add the points of the cycles, and what follows the end of rest."""
    orbits = [found.orbit for found in attractors if found.orbit.time.size]
    if orbits:
        known = known._replace(
            cycle_mode=np.concatenate([orbit.mode for orbit in orbits]),
            cycle_state=np.concatenate([orbit.after for orbit in orbits]),
            cycle_reach=np.concatenate(
                [np.broadcast_to(ON_CYCLE * np.abs(o.after).max(axis=0), o.after.shape) for o in orbits]
            ),
        )
    tables = automaton.tables
    for mode, state in releases:
        transition = tables.guard_transition[tables.guard_start[mode]]
        branch = event_loop.choose_branch(tables, transition, state, np.abs(state))
        scratch = labels.new_scratch(tables)
        scratch.state[:], scratch.scale[:] = state, np.abs(state)
        sprags = np.array(automaton.sprag_kinds, dtype=np.int64)
        known.release[mode] = arrival.approach(tables, known, sprags, tables.branch_mode[branch], scratch, _EVENTS)
    return known
