"""From section to section: the next event of motions with two states, for any kind of flow.

A *section* is a mode with a surface on which it is entered (:mod:`lsvib.systems.interval_mapper`). ``Pieces`` holds
what motions from sections end in, as far as that is known: intervals of the coordinate along each section.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from lsvib.systems.kernels import event_loop
from lsvib.systems.kernels.flow_planar import level
from lsvib.systems.kernels.jit import allocating_entry, by_address, entry, kernel, on_stack
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, CARRY, GRAZE_KIND, NONE, TIME, Now, Tables

UNRESOLVED = -1  # as ``Attractor.UNRESOLVED``
UNKNOWN = -2  # no label of the caller is so low
LEAVES, STAYS, RESTS, LOST = range(4)  # what the next event of a motion is: one, none, the begin of rest, not told


class Cells(NamedTuple):
    """Cells of a grid of starts: coordinates of the columns and of the rows, and which coordinate of the state x is."""

    x: np.ndarray
    y: np.ndarray
    across: int


class Scratch(NamedTuple):
    """Working space of one motion: where it is, and spare room."""

    now: Now
    room: event_loop.Room


@allocating_entry
def new_scratch(tables):
    """Return the working space for one motion at a time."""
    return Scratch(Now(np.zeros(2), np.zeros(2), np.zeros(4)), event_loop.room_for(tables))


@kernel
def put(scratch, u, w):
    """Set the state of the working space to u, w, exact as given."""
    state, scale, _ = scratch.now
    state[0], state[1] = u, w
    scale[0], scale[1] = abs(u), abs(w)


@entry
def look_up(pieces, mode, surface, state):
    """Return the label of a motion that enters ``mode`` at ``state`` on ``surface``, or UNKNOWN."""
    low, high = pieces.first[mode, surface], pieces.last[mode, surface]
    x = state[pieces.free[surface]]
    if low == high or not (pieces.edges[low] <= x < pieces.edges[high]):
        return UNKNOWN
    while high - low > 1:
        middle = (low + high) // 2
        if pieces.edges[middle] <= x:
            low = middle
        else:
            high = middle
    return pieces.labels[low]


@entry
def put_on(tables, surface, state):
    """Set the dependent coordinate of a point of a surface, as ``event_loop.put_on_surface`` does."""
    row, chosen = tables.surfaces[surface], tables.snap[surface]
    state[chosen] = -(row[2] + row[1 - chosen] * state[1 - chosen]) / row[chosen]


@kernel
def signs(tables, transition, state, scale):
    """The signs of all conditions of a transition at a state, as a number in base three."""
    number = 0
    for k in range(
        tables.condition_start[tables.branch_start[transition]],
        tables.condition_start[tables.branch_start[transition + 1]],
    ):
        value, size = level(tables.condition_row[k], state, scale)
        number = 3 * number + (0 if abs(value) <= size else 1 if value > 0.0 else 2)
    return number


class Pieces(NamedTuple):
    """What motions from the sections of an automaton with m modes and s surfaces end in.

    Section (i, j) has the edges ``first[i, j]`` to ``last[i, j]``, both included, and between an edge and the next one
    the label of the former.
    """

    landing: np.ndarray  # (t,) surface on which a transition leaves the state, −1 for a corner
    free: np.ndarray  # (s,) the coordinate along a surface
    resting: np.ndarray  # (m,) label of what is in a mode at rest; UNKNOWN for slip
    settled: np.ndarray  # (m,) label of what stays in a mode for ever
    centre: np.ndarray  # (m, n) its equilibrium y = 0
    form: np.ndarray  # (m, n, n) S; what has yᵀ S y < level stays in the mode for ever
    level: np.ndarray  # (m,)
    common: np.ndarray  # (m,) the one label of what is in a mode with yᵀ S y < reach; UNKNOWN if there are several
    reach: np.ndarray  # (m,)
    first: np.ndarray  # (m, s)
    last: np.ndarray  # (m, s) equal to the first if nothing is known
    edges: np.ndarray  # (e,)
    labels: np.ndarray  # (e,)


class Way(NamedTuple):
    """How motions are followed: address of :func:`to_next_event`, tables, and steps that a search may take."""

    address: int
    tables: Tables
    pieces: Pieces
    steps: float


@entry
def to_next_event(tables, pieces, mode, short, steps, scratch):
    """Go on past the next event, as ``event_loop.run_in`` does; ``short`` counts shortest stays in a row.

    Returns what the event is, guard, kind, mode after, stay [s] and short stays in a row.
    """
    (state, scale, _), room = scratch.now, scratch.room
    room.work.steps[0] = steps
    found, guard, stay = event_loop.next_event(
        tables, mode, state, scale, math.inf, room.guards, room.on_surface, room.work
    )
    if found == NONE:
        return STAYS, guard, event_loop.NO_KIND, mode, stay, short
    event_loop.arrive(tables, mode, scratch.now, guard, stay, room.work)
    if not (abs(state[0]) < event_loop.LARGEST and abs(state[1]) < event_loop.LARGEST):
        return LOST, guard, event_loop.NO_KIND, mode, stay, short
    short = short + 1 if stay < tables.shortest_stay else 0
    outcome, after, kind, _ = event_loop.leave(tables, mode, found, guard, short, scratch.now, room.state)
    short = 0 if kind == ACCUMULATION_KIND else short
    if outcome != event_loop.GOES_ON or kind == GRAZE_KIND:
        return LOST, guard, kind, mode, stay, short
    return RESTS if pieces.resting[after] != UNKNOWN else LEAVES, guard, kind, after, stay, short


_next_at = by_address(to_next_event, types.Tuple([*[types.int64] * 4, types.float64, types.int64]))


@allocating_entry
def images(way, section, points, found, image):
    """Follow motions from ``points`` (k) of a section (mode, surface) to their next event.

    Filled: ``found`` (k, 4), what the next event is, a number for the guard and the signs of all conditions of its
    transition, odd where it comes at once, mode and surface after it; ``image`` (k), the coordinate there.
    """
    address, tables, pieces, steps = way
    scratch, (mode, surface) = new_scratch(tables), section
    state = scratch.now.state
    for k in range(points.size):
        state[pieces.free[surface]] = points[k]
        put_on(tables, surface, state)
        put(scratch, state[0], state[1])
        outcome, guard, _, after, stay, _ = _next_at(address, tables, pieces, mode, 0, steps, scratch)
        found[k, 0], found[k, 1], found[k, 2], found[k, 3], image[k] = outcome, 0, after, -1, 0.0
        if outcome in (LEAVES, RESTS):
            transition = tables.guard_transition[guard]
            number = signs(tables, transition, state, scratch.now.scale)
            found[k, 1] = (number * tables.guard_sign.size + guard) * 2 + (stay == 0.0)
            found[k, 3] = pieces.landing[transition]
            image[k] = state[pieces.free[found[k, 3]]]


@entry
def ellipse(pieces, mode, state):
    """Return yᵀ S y of a state."""
    y, w, s = state[0] - pieces.centre[mode, 0], state[1] - pieces.centre[mode, 1], pieces.form[mode]
    return s[0, 0] * y * y + 2.0 * s[0, 1] * y * w + s[1, 1] * w * w


@allocating_entry
def map_labels(way, cells, budget, labels, first_events):
    """Label the starts of a grid: ``labels`` and ``first_events`` (rows, columns) are filled.

    A motion goes on from event to event until it comes to a piece, rests, or stays in its mode. The label is UNKNOWN
    where ``budget`` events are not enough, or the next one is not told; UNRESOLVED where no mode fits the start.
    """
    address, tables, pieces, steps = way
    scratch, (x, y, across) = new_scratch(tables), cells
    state = scratch.now.state
    for i in range(y.size):
        for j in range(x.size):
            put(scratch, y[i] if across else x[j], x[j] if across else y[i])
            branch = event_loop.choose_branch(tables, 0, state, scratch.now.scale)
            label, first, short = UNRESOLVED if branch < 0 else UNKNOWN, event_loop.NO_KIND, 0
            mode = tables.branch_mode[max(branch, 0)]
            rests = pieces.resting[mode]  # what starts at rest leaves it at a corner, which no piece holds
            extent = ellipse(pieces, mode, state)
            if label == UNKNOWN and extent < pieces.level[mode]:
                label = pieces.settled[mode]
            elif label == UNKNOWN and first_events.size == 0 and extent < pieces.reach[mode]:
                label = pieces.common[mode]
            for count in range(budget if label == UNKNOWN else 0):
                outcome, guard, kind, mode, _, short = _next_at(address, tables, pieces, mode, short, steps, scratch)
                first = kind if count == 0 else first
                if rests != UNKNOWN:
                    label = rests
                elif outcome == LEAVES:
                    label = look_up(pieces, mode, pieces.landing[tables.guard_transition[guard]], state)
                elif outcome == STAYS:
                    label = pieces.settled[mode]
                elif outcome == RESTS:
                    label = pieces.resting[mode]
                if label != UNKNOWN or outcome == LOST:
                    break
            labels[i, j] = label
            if first_events.size:
                first_events[i, j] = first


class Cycles(NamedTuple):
    """Mode and state after each event of cycles (k), and the distance within which a state is on the cycle."""

    mode: np.ndarray  # (k,)
    state: np.ndarray  # (k, n)
    reach: np.ndarray  # (k, n)


@kernel
def _on_cycle(cycles, mode, state):
    for k in range(cycles.mode.size):
        near = cycles.mode[k] == mode
        for i in range(state.size):
            near = near and abs(state[i] - cycles.state[k, i]) <= cycles.reach[k, i]
        if near:
            return True
    return False


@kernel
def _arrival_time(tables, pieces, mode, state):
    """Time [s] from ``state`` until the motion, which stays in ``mode``, is within the ellipse that it never leaves."""
    if not ellipse(pieces, mode, state) > pieces.level[mode]:
        return 0.0
    there = on_stack(2)
    low, high, bracketed = 0.0, tables.shortest_stay, False
    for _ in range(4000):  # 2098 doublings lead from the smallest double to the largest
        middle = 0.5 * (low + high) if bracketed else high
        event_loop.advance(tables.flow, mode, state, middle, there)
        outside = ellipse(pieces, mode, there) > pieces.level[mode]
        bracketed = bracketed or not outside
        low, high = (middle, high if bracketed else 2.0 * high) if outside else (low, middle)
        if bracketed and high - low <= 1e-15 * high:
            break
    return high


@entry
def approach(way, cycles, sprags, mode, scratch, budget):
    """Return the time [s] until the motion of a ``scratch`` in ``mode`` is at its attractor, and its sprags.

    ``sprags`` (k): kinds of events that sprag. Arrival: in the ellipse that is never left; at an event
    of a cycle; at the event after which an undamped mode is never left. The time is infinite if ``budget`` events are
    not enough.
    """
    address, tables, pieces, steps = way
    state, _, clock = scratch.now
    short, count, clock[TIME], clock[CARRY] = 0, 0, 0.0, 0.0
    if _on_cycle(cycles, mode, state):
        return 0.0, 0
    for _ in range(budget):
        if ellipse(pieces, mode, state) < pieces.level[mode]:
            return clock[TIME] + clock[CARRY], count
        outcome, _, kind, mode, stay, short = _next_at(address, tables, pieces, mode, short, steps, scratch)
        if outcome == STAYS:
            more = _arrival_time(tables, pieces, mode, state) if pieces.level[mode] > 0.0 else 0.0
            return clock[TIME] + clock[CARRY] + more, count
        if outcome == LOST:
            return math.inf, count
        event_loop.add_time(clock, stay)
        if kind != ACCUMULATION_KIND:
            for k in range(sprags.size):
                count += kind == sprags[k]
        if _on_cycle(cycles, mode, state):
            return clock[TIME] + clock[CARRY], count
    return math.inf, count


@allocating_entry
def map_approaches(way, cycles, sprags, cells, budget, times, counts):
    """Fill ``times`` [s] and ``counts`` (rows, columns) by :func:`approach`; other arguments as ``map_labels`` has."""
    scratch, (x, y, across), tables = new_scratch(way.tables), cells, way.tables
    for i in range(y.size):
        for j in range(x.size):
            put(scratch, y[i] if across else x[j], x[j] if across else y[i])
            branch = event_loop.choose_branch(tables, 0, scratch.now.state, scratch.now.scale)
            times[i, j], counts[i, j] = math.inf, 0
            if branch >= 0:
                mode = tables.branch_mode[branch]
                times[i, j], counts[i, j] = approach(way, cycles, sprags, mode, scratch, budget)
