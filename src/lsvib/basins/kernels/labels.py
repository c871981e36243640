"""Where motions with two states end up: many starts at once, by what is known of motions that start on a few lines.

A motion that passes from mode to mode goes on from a point of a surface, so what becomes of it is a function of one
coordinate. ``Known`` holds that function as a table of intervals (made by :mod:`lsvib.basins.labels`), so that
a start needs its first event and one look-up. Every rest ends in the same state, so a rest mode needs only one label.

Labels are numbers that the caller chooses, but for two: ``UNKNOWN`` where the table does not say, and ``UNRESOLVED``
where the event budget is spent or the start lies on a boundary to rounding. A time that never comes is infinite.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.engine.kernels import event_loop, flow_planar
from lsvib.engine.kernels.flow_planar import EPS, ROUNDING, level
from lsvib.engine.kernels.jit import allocating_entry, entry, kernel
from lsvib.engine.kernels.layout import (
    A0,
    A1,
    ACCUMULATION_KIND,
    ALPHA,
    BETA,
    CARRY,
    CROSSING,
    DELTA,
    EQUILIBRIUM,
    GRAZE,
    GRAZE_KIND,
    LOST,
    NONE,
    TIME,
    Now,
    Status,
)

UNRESOLVED = -1  # as ``Attractor.UNRESOLVED``
UNKNOWN = -2  # no label of the caller is so low
NO_EVENT = event_loop.NO_KIND  # first event of a motion that has none
TOO_LONG, UNDETERMINED, DIVERGED = -1, -2, -3  # codes of itineraries that end nowhere
_SETTLED = int(Status.SETTLED)
_DIVERGED = int(Status.DIVERGED)


class Known(NamedTuple):
    """What is known of the motions of an automaton with m modes, s surfaces and t transitions.

    A *section* is a mode with a surface on which it is entered. Section (i, j) has the edges ``first[i, j]`` to
    ``last[i, j]``, both included, and between an edge and the next one the label of the former.
    """

    landing: np.ndarray  # (t,) surface on which a transition leaves the state, −1 for a corner
    free: np.ndarray  # (s,) the coordinate along a surface
    first: np.ndarray  # (m, s)
    last: np.ndarray  # (m, s) equal to the first if nothing is known
    edges: np.ndarray  # (e,)
    labels: np.ndarray  # (e,)
    resting: np.ndarray  # (m,) label of what is in a mode at rest; UNKNOWN for slip
    settled: np.ndarray  # (m,) label of what stays in a mode for ever
    centred: np.ndarray  # (m,) label of what is at the equilibrium of a mode
    diverged: int  # label of what leaves the range of numbers
    common: np.ndarray  # (m,) label of all that leaves a mode by an event, if that is one; else UNKNOWN
    share: np.ndarray  # (m,) part of an amplitude that is left after a turn, e^{−2πα/β}
    reach: np.ndarray  # (m,) size of the ellipse, as below, from which no event lies beyond the edges of the sections
    trap: np.ndarray  # (m, 3) κ², ρ² of the trapping ellipse η² + κ² y² < ρ² (0: none), ρ² that counts as arrival
    cycle_mode: np.ndarray  # (k,) mode and state after each event of the cycles
    cycle_state: np.ndarray  # (k, 2)
    cycle_reach: np.ndarray  # (k, 2) distance within which a state is on the cycle
    release: np.ndarray  # (m, 2) for a mode at rest: time [s] and number of sprags from its end to the attractor


class Cells(NamedTuple):
    """Cells of a grid of starts: coordinates of the columns and of the rows, and which one (0: u, 1: w) x is."""

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
    """Set the state of the working space to u [rad], w [rad/s], exact as given."""
    state, scale, _ = scratch.now
    state[0], state[1] = u, w
    scale[0], scale[1] = abs(u), abs(w)


@kernel
def step(tables, mode, short, scratch):
    """Go on past the next event, as ``event_loop.run_in`` does; ``short`` counts shortest stays in a row.

    Returns (``event_loop.GOES_ON`` or ``Status``, guard, kind, mode after, stay [s], short).
    """
    state, scale, _ = scratch.now
    room = scratch.room
    found, guard, stay = event_loop.next_event(
        tables, mode, state, scale, math.inf, room.guards, room.on_surface, room.work
    )
    if found == NONE:
        return _SETTLED, guard, NO_EVENT, mode, stay, short
    event_loop.arrive(tables, mode, scratch.now, guard, stay, room.work)
    if not (abs(state[0]) < event_loop.LARGEST and abs(state[1]) < event_loop.LARGEST):
        return _DIVERGED, guard, NO_EVENT, mode, stay, short
    short = short + 1 if stay < tables.shortest_stay else 0
    outcome, mode, kind, _ = event_loop.leave(tables, mode, found, guard, short, scratch.now, room.state)
    return outcome, guard, kind, mode, stay, 0 if kind == ACCUMULATION_KIND else short


@entry
def ellipse(tables, known, mode, state):
    """η² + κ² y² of a state with y = u − u_e, η = w + α y; with a damped mode and κ = max(α, β) it always falls."""
    row = tables.flow[mode]
    y = state[0] - row[EQUILIBRIUM]
    eta = state[1] + row[ALPHA] * y
    return eta * eta + known.trap[mode, 0] * y * y


@kernel
def _settled(tables, known, mode, state):
    """Label of what stays in ``mode`` for ever."""
    if state[0] == tables.flow[mode, EQUILIBRIUM] and state[1] == 0.0:
        return known.centred[mode]
    return known.settled[mode]


@entry
def look_up(known, mode, surface, state):
    """Return the label of a motion that enters ``mode`` at ``state`` on ``surface``, or UNKNOWN."""
    low, high = known.first[mode, surface], known.last[mode, surface]
    x = state[known.free[surface]]
    if low == high or not (known.edges[low] <= x < known.edges[high]):
        return UNKNOWN
    while high - low > 1:
        middle = (low + high) // 2
        if known.edges[middle] <= x:
            low = middle
        else:
            high = middle
    return known.labels[low]


@kernel
def label_of(tables, known, mode, scratch, budget):
    """Return the label and the kind of the first event of the motion of a ``scratch`` in ``mode``.

    ``budget``: events after which it is unresolved. Touching a guard without crossing it, to rounding, is a boundary.
    """
    state, short, first = scratch.now.state, 0, UNKNOWN
    for _ in range(budget):
        if ellipse(tables, known, mode, state) < known.trap[mode, 1]:
            return known.settled[mode], NO_EVENT if first == UNKNOWN else first
        rests = known.resting[mode]
        if rests != UNKNOWN and first != UNKNOWN:
            return rests, first
        outcome, guard, kind, after, _, short = step(tables, mode, short, scratch)
        first = kind if first == UNKNOWN else first
        if rests != UNKNOWN:
            return rests, first
        if outcome == _SETTLED:
            return _settled(tables, known, mode, state), first
        if outcome == _DIVERGED:
            return known.diverged, first
        if outcome != event_loop.GOES_ON or kind == GRAZE_KIND:
            return UNRESOLVED, first
        mode = after
        surface = known.landing[tables.guard_transition[guard]]
        if surface >= 0:
            label = look_up(known, mode, surface, state)
            if label != UNKNOWN:
                return label, first
    return UNRESOLVED, first


@kernel
def _outlook(row, share, g_u, g_w, g_0, u, w):
    """Return whether a guard g_u u + g_w w + g_0 that is positive at (u, w) will ever fall through zero.

    The guard of a damped oscillation swings about its value at the equilibrium, g_e, by A at the start. Its first
    minimum lies between g_e − A and g_e − e^{−2πα/β} A, and is computed only if zero lies there as well; later minima
    are shallower. ``row`` is that of the flow, ``share`` e^{−2πα/β}. Returns ``Found``; UNDECIDED for other modes.
    """
    a0, a1, alpha, beta, centre = row[A0], row[A1], row[ALPHA], row[BETA], row[EQUILIBRIUM]
    y = u - centre
    if not (beta > 0.0 and alpha > 0.0 and abs(centre) < 16.0 * abs(y)):
        return LOST
    middle, margin = g_u * centre + g_0, 4096.0 * EPS  # within it the bounds do not decide
    p = g_u * w - g_w * (a0 * y + a1 * w)
    across = (-a0 * (g_u * y + g_w * w) - alpha * p) / beta
    swing = beta * math.sqrt(p * p + across * across) / a0
    if middle > swing * (1.0 + margin):
        return NONE
    if middle < swing * share * (1.0 - margin):
        return CROSSING
    bottom = math.atan2(across, p) + 1.5 * math.pi
    depth = swing * math.exp(-alpha / beta * (bottom - 2.0 * math.pi if bottom > 2.0 * math.pi else bottom))
    rounding = 8.0 * EPS * (abs(middle) + depth)
    return CROSSING if depth > middle + rounding else NONE if depth < middle - rounding else GRAZE


@allocating_entry
def map_labels(tables, known, cells, budget, labels, first_events):
    """Label the starts of a grid: ``labels`` and, unless it is empty, ``first_events`` (rows, columns) are filled.

    Where all that leaves a mode has one label and the first event is not asked for, it is enough to know whether there
    is one.
    """
    scratch = new_scratch(tables)
    flow, surfaces, (x, y, across) = tables.flow, tables.surfaces, cells
    for i in range(y.size):
        for j in range(x.size):
            u, w = (y[i], x[j]) if across else (x[j], y[i])
            put(scratch, u, w)
            branch = event_loop.choose_branch(tables, 0, scratch.now.state, scratch.now.scale)
            label, first = UNRESOLVED if branch < 0 else UNKNOWN, NO_EVENT
            mode = tables.branch_mode[max(branch, 0)]
            if label == UNKNOWN:
                extent = ellipse(tables, known, mode, scratch.now.state)
                if extent < known.trap[mode, 1]:
                    label = known.settled[mode]
                elif first_events.size == 0 and known.common[mode] != UNKNOWN and extent < known.reach[mode]:
                    leaves = NONE
                    for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
                        sign, row = tables.guard_sign[guard], surfaces[tables.guard_surface[guard]]
                        g_u, g_w, g_0 = sign * row[0], sign * row[1], sign * row[2]
                        value = g_u * u + g_w * w + g_0
                        size = ROUNDING * (abs(g_0) + abs(g_u) * abs(u) + abs(g_w) * abs(w))
                        outlook = CROSSING if value < -size else LOST
                        if value > size:
                            outlook = _outlook(flow[mode], known.share[mode], g_u, g_w, g_0, u, w)
                        leaves = max(leaves, outlook)
                        if outlook == CROSSING:
                            leaves = CROSSING
                            break
                    if leaves == CROSSING:
                        label = known.common[mode]
                    elif leaves == NONE:
                        label = known.settled[mode]
            if label == UNKNOWN:
                label, first = label_of(tables, known, mode, scratch, budget)
            labels[i, j] = label
            if first_events.size > 0:
                first_events[i, j] = first


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


@allocating_entry
def itinerary(tables, known, absorbing, mode, state, symbols):
    """Follow the motion from ``state`` (2, replaced by the last state) in ``mode`` and write what decides its course.

    Arguments: ``absorbing`` (j, 4), intervals of sections: mode, surface, low, high; ``symbols``, filled: a number for
    each event, of the guard and the signs of all conditions of its transition. Returns (code, number of events, mode):
    code TOO_LONG if the symbols are used up, UNDETERMINED where the motion touches a guard or meets a corner, DIVERGED;
    3 i if the motion settles in mode i, 3 i + 1 if it comes to rest in it, 3 i + 2 if it enters absorbing interval i.
    """
    scratch, short = new_scratch(tables), 0
    put(scratch, state[0], state[1])
    code, count = TOO_LONG, 0
    while count < symbols.size and code == TOO_LONG:
        if ellipse(tables, known, mode, scratch.now.state) < known.trap[mode, 1]:
            code = 3 * mode
            break
        before = mode
        outcome, guard, kind, mode, stay, short = step(tables, mode, short, scratch)
        if outcome != event_loop.GOES_ON:
            code = 3 * before if outcome == _SETTLED else DIVERGED if outcome == _DIVERGED else UNDETERMINED
            break
        if kind == GRAZE_KIND:
            code = UNDETERMINED
            break
        transition = tables.guard_transition[guard]
        number = signs(tables, transition, scratch.now.state, scratch.now.scale)
        symbols[count] = (number * tables.guard_sign.size + guard) * 2 + (stay == 0.0)
        count += 1
        surface = known.landing[transition]
        if known.resting[mode] != UNKNOWN:
            code = 3 * mode + 1
        elif surface >= 0:
            x = scratch.now.state[known.free[surface]]
            for k in range(absorbing.shape[0]):
                here = absorbing[k, 0] == mode and absorbing[k, 1] == surface
                if here and absorbing[k, 2] <= x <= absorbing[k, 3]:
                    code = 3 * k + 2
                    break
    state[0], state[1] = scratch.now.state
    return code, count, mode


@allocating_entry
def last_agreement(tables, known, absorbing, section, low, high, resolution, course):
    """Bisect a section between ``low``, whose motion has the ``course``, and ``high``, whose motion leaves it.

    ``section``: mode and surface; ``course``: itinerary with −10 − code appended, up to where ``high`` differs first.
    Returns the last coordinate that agrees up to there and the first that does not, apart by ``resolution`` or rounding
    at most.
    """
    mode, surface = section
    position, free = course.size - 1, known.free[surface]
    symbols, state = np.empty(course.size, dtype=np.int64), np.empty(2)
    while high - low > max(resolution, EPS * min(abs(low), abs(high))):
        middle = 0.5 * (low + high)
        state[free] = middle
        put_on(tables, surface, state)
        code, count, _ = itinerary(tables, known, absorbing, mode, state, symbols)
        agrees = count == position + 1 or (count == position and -10 - code == course[position])
        for k in range(count):
            agrees = agrees and symbols[k] == course[k]
        if agrees:
            low = middle
        else:
            high = middle
    return low, high


@kernel
def _arrival_time(tables, known, mode, state):
    """Time [s] from ``state`` until the motion, which stays in a damped ``mode``, is within the ellipse of arrival."""
    row = tables.flow[mode]
    kappa2, goal = known.trap[mode, 0], known.trap[mode, 2]
    size = ellipse(tables, known, mode, state)
    if size <= goal:
        return 0.0
    if row[BETA] * row[BETA] == kappa2:  # the ellipse shrinks as e^{−2αt}
        return 0.5 * math.log(size / goal) / row[ALPHA]
    y, w = state[0] - row[EQUILIBRIUM], state[1]
    low, high, bracketed = 0.0, 1.0 / (row[ALPHA] + row[BETA] + row[DELTA]), False
    for _ in range(4000):  # 2098 doublings lead from the smallest double to the largest
        middle = 0.5 * (low + high) if bracketed else high
        c, s, s_rate = flow_planar.responses(row, middle)
        there, rate = y * c + w * s, w * s_rate - row[A0] * y * s
        eta = rate + row[ALPHA] * there
        outside = eta * eta + kappa2 * there * there > goal
        bracketed = bracketed or not outside
        low, high = (middle, high if bracketed else 2.0 * high) if outside else (low, middle)
        if bracketed and high - low <= 4.0 * EPS * high:
            break
    return high


@kernel
def _on_cycle(known, mode, state):
    for k in range(known.cycle_mode.size):
        near = abs(state[0] - known.cycle_state[k, 0]) <= known.cycle_reach[k, 0]
        near = near and abs(state[1] - known.cycle_state[k, 1]) <= known.cycle_reach[k, 1]
        if near and known.cycle_mode[k] == mode:
            return True
    return False


@entry
def approach(tables, known, sprags, mode, scratch, budget):
    """Return the time [s] until the motion of a ``scratch`` in ``mode`` is at its attractor, and its sprags.

    ``sprags`` (b): whether a branch is an event that sprags. Arrival: in the trapping ellipse; at an event of a cycle,
    within ``cycle_reach``; at the event after which an undamped mode is never left. The time is infinite if the motion
    diverges, or if ``budget`` events are not enough.
    """
    state, _, clock = scratch.now
    short, count, clock[TIME], clock[CARRY] = 0, 0, 0.0, 0.0
    if _on_cycle(known, mode, state):
        return 0.0, 0
    for _ in range(budget):
        if ellipse(tables, known, mode, state) < known.trap[mode, 2]:
            return clock[TIME] + clock[CARRY], count
        start = mode
        outcome, _, kind, mode, stay, short = step(tables, mode, short, scratch)
        if outcome == _SETTLED:
            if known.trap[mode, 2] > 0.0:
                return clock[TIME] + clock[CARRY] + _arrival_time(tables, known, mode, state), count
            if known.settled[mode] == known.diverged:
                return math.inf, count
            return clock[TIME] + clock[CARRY], count
        if outcome != event_loop.GOES_ON:
            return math.inf, count
        event_loop.add_time(clock, stay)
        if kind != GRAZE_KIND and kind != ACCUMULATION_KIND:
            for k in range(sprags.size):
                count += kind == sprags[k]
        if known.resting[start] != UNKNOWN:
            return clock[TIME] + clock[CARRY] + known.release[start, 0], count + int(known.release[start, 1])
        if _on_cycle(known, mode, state):
            return clock[TIME] + clock[CARRY], count
    return math.inf, count


@allocating_entry
def map_approaches(tables, known, sprags, cells, budget, times, counts):
    """Fill ``times`` [s] and ``counts`` (rows, columns) by :func:`approach`; other arguments as ``map_labels`` has."""
    scratch, (x, y, across) = new_scratch(tables), cells
    for i in range(y.size):
        for j in range(x.size):
            put(scratch, y[i] if across else x[j], x[j] if across else y[i])
            branch = event_loop.choose_branch(tables, 0, scratch.now.state, scratch.now.scale)
            if branch < 0:
                times[i, j], counts[i, j] = math.inf, 0
                continue
            time, count = approach(tables, known, sprags, tables.branch_mode[branch], scratch, budget)
            times[i, j], counts[i, j] = time, count
