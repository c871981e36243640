"""The event loop: flow to the first guard that fires, reset, branch, and again. It knows no model.

A guard is positive inside its mode and fires when it falls through zero. On entering a mode a guard may already be
zero, since the state has just arrived on it. It is then judged by its first derivative that is not zero to rounding: a
guard that rises is watched from its first maximum on, and a guard that falls fires at once. No time step and no
tolerance in time is involved.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import types

from lsvib.systems.kernels import flow_modal, flow_planar, flow_taylor, search_modal, search_planar, search_taylor
from lsvib.systems.kernels.flow_planar import level
from lsvib.systems.kernels.jit import (
    allocating_entry,
    by_address,
    by_kind,
    entry,
    inlined_entry,
    inlined_kernel,
    merged_kernel,
)
from lsvib.systems.kernels.layout import (
    ACCUMULATION_KIND,
    CARRY,
    CROSSING,
    GRAZE,
    GRAZE_KIND,
    LOST,
    NONE,
    SHORT_STAYS,
    STEPS,
    TIME,
    Events,
    Status,
    Test,
)

_ACCUMULATED = int(Status.ACCUMULATED)
_NO_BRANCH = int(Status.NO_BRANCH)
GOES_ON = -1  # stands for a status where the run does not end; no status is negative
NO_KIND = -1  # stands for an event kind where nothing has happened; no kind is negative
MANY = 24  # this many stays in a row below ``shortest_stay`` are an accumulation
LARGEST = 1e150  # a coordinate beyond it has left the range of numbers: its square is close to overflow

# What depends on the kind of flow.
advance = by_kind(flow_planar.advance, flow_modal.advance, flow_taylor.advance)
travel = by_kind(flow_planar.travel, flow_modal.travel, flow_taylor.travel)
slopes_at = by_kind(flow_planar.slopes_at, flow_modal.slopes_at, flow_taylor.slopes_at)
workspace = by_kind(search_planar.room_for, search_modal.room_for, search_taylor.room_for)
search = by_kind(search_planar.search, search_modal.search, search_taylor.search)
extremes = by_kind(search_planar.extremes, search_modal.extremes, search_taylor.extremes)


@merged_kernel
def next_event(tables, mode, state, scale, limit, room, zeros, work):
    """Find the first guard of ``mode`` that fires within ``limit`` [s].

    ``scale`` (n) are the magnitudes that the state was computed from; a guard below their rounding counts as zero.
    A guard that is negative at ``state`` fires at once, so a model may enter a mode from a state outside it where a
    jump is due. ``room`` (g, n + 1 + parts) and ``zeros`` (g) are scratch space for the guards of the mode, and
    ``work`` is the scratch space of the search (:func:`workspace`).
    Returns (``Found``, guard index, time [s]).
    """
    first_guard = tables.guard_start[mode]
    count = tables.guard_start[mode + 1] - first_guard
    guards, on_surface = room[:count], zeros[:count]
    for k in range(count):
        guard = first_guard + k
        for i in range(state.size + 1):
            guards[k, i] = tables.guard_sign[guard] * tables.surfaces[tables.guard_surface[guard], i]
        for i in range(tables.guard_parts.shape[1]):
            guards[k, state.size + 1 + i] = tables.guard_parts[guard, i]
        value, size = level(guards[k], state, scale)
        on_surface[k] = value <= size
        if on_surface[k]:
            rate, rate_size, bend, bend_size = slopes_at(tables.flow, mode, state, scale, guards[k])
            falls = rate < -rate_size or (rate <= rate_size and bend < -bend_size)
            # A guard that turns back before it is below zero by its own rounding does not fall: what is held lets go
            # of a second body without acceleration, and what rounding makes of that instant is no end of slip.
            if falls and state.size > 2 and bend > bend_size and rate * rate <= 2.0 * bend * size:
                falls = False
            if value < -size or falls:
                return CROSSING, guard, 0.0
    found, k, when = search(tables.flow, mode, state, guards, on_surface, limit, work)
    return found, first_guard + k, when


@inlined_entry
def choose_branch(tables, transition, state, scale):
    """Return the first branch of a transition whose conditions hold at ``state``, or −1; ``scale`` as in next_event."""
    for branch in range(tables.branch_start[transition], tables.branch_start[transition + 1]):
        holds, k, end = True, tables.condition_start[branch], tables.condition_start[branch + 1]
        while holds and k < end:
            value, size = level(tables.condition_row[k], state, scale)
            test = tables.condition_test[k]
            if test == Test.POSITIVE:
                holds = value > size
            elif test == Test.ZERO:
                holds = abs(value) <= size
            else:
                holds = value >= -size
            while test == Test.LEADS and value > size:  # those that it leads to do not count
                k += 1
                test = tables.condition_test[k]
            k += 1
        if holds:
            return branch
    return -1


@inlined_kernel
def put_on_surface(tables, guard, state, scale):
    """Move one coordinate, by no more than rounding, so that the guard's surface is met to the last bit.

    ``scale`` (n) are the magnitudes that the state was computed from; the entry of the coordinate that is moved is
    reduced to the rounding of the surface equation, if that is smaller.
    """
    surface = tables.surfaces[tables.guard_surface[guard]]
    chosen = tables.snap[tables.guard_surface[guard]]
    if state.size > 2:
        # Move the coordinate whose rounding changes the surface function most; for another coordinate the same change
        # may be many digits.
        for i in range(state.size):
            if abs(surface[i]) * scale[i] > abs(surface[chosen]) * scale[chosen]:
                chosen = i
    rest = surface[surface.size - 1]
    size = abs(rest)
    for i in range(surface.size - 1):
        if i != chosen:
            rest += surface[i] * state[i]
            size += abs(surface[i]) * scale[i]
    state[chosen] = -rest / surface[chosen]
    scale[chosen] = min(scale[chosen], size / abs(surface[chosen]))


@inlined_kernel
def apply_reset(tables, transition, state, scratch):
    """Apply the affine reset of a transition to ``state`` in place; ``scratch`` has the size of the state."""
    index = tables.transition_reset[transition]
    if index < 0:
        return
    for i in range(state.size):
        row = tables.resets[index, i]
        total = row[state.size]
        for j in range(state.size):
            total += row[j] * state[j]
        scratch[i] = total
    for i in range(state.size):  # element by element: assigning arrays compiles numba's text of the error as well
        state[i] = scratch[i]


@inlined_kernel
def arrive(tables, mode, now, guard, stay, work):
    """Move the state in place to the event of ``guard`` after a stay [s] in ``mode``; its scale follows it."""
    state, scale = now.state, now.scale
    if stay > 0.0:
        travel(tables.flow, mode, state, stay, scale, work)
        put_on_surface(tables, guard, state, scale)
    for i in range(state.size):
        scale[i] = max(scale[i], abs(state[i]))


@inlined_kernel
def leave(tables, mode, found, guard, short_stays, now, scratch):
    """Reset the state in place where the guard has fired, and choose what follows.

    ``short_stays``: number of stays below ``shortest_stay`` in a row, this one included; ``scratch`` has the size of
    the state. Returns (GOES_ON or the ``Status`` that ends the run, mode after the event, event kind, its sign).
    """
    if found == GRAZE:
        return GOES_ON, mode, GRAZE_KIND, 0
    apply_reset(tables, tables.guard_transition[guard], now.state, scratch)
    if short_stays == MANY:
        beyond = tables.beyond_accumulation[mode]
        return GOES_ON if beyond >= 0 else _ACCUMULATED, beyond, ACCUMULATION_KIND, 0
    branch = choose_branch(tables, tables.guard_transition[guard], now.state, now.scale)
    if branch < 0:
        return _NO_BRANCH, mode, NO_KIND, 0
    return GOES_ON, tables.branch_mode[branch], tables.branch_kind[branch], tables.branch_sign[branch]


class Room(NamedTuple):
    """Scratch space of a run, which makes no array itself: what makes none counts no references."""

    state: np.ndarray  # (n,)
    guards: np.ndarray  # (g, n + 1 + parts)
    on_surface: np.ndarray  # (g,)
    work: Any  # of the search


@allocating_entry
def room_for(tables):
    """Return scratch space for runs with these tables, one at a time."""
    n, count = tables.surfaces.shape[1] - 1, tables.guard_sign.size
    guards = np.empty((count, n + 1 + tables.guard_parts.shape[1]))
    return Room(np.empty(n), guards, np.empty(count, dtype=np.bool_), workspace(tables.flow, count))


@entry
def run_in(room, tables, mode, now, until, events):
    """Follow the motion from a mode and where it is (``Now``) to an end (``Until``), in the scratch space ``room``.

    What happens is written to ``events``. If a run ends because these are full, a second run with the replaced
    arguments goes on as if the first had never ended. Returns (``Status``, mode, number of events).
    """
    flow, work, count = tables.flow, room.work, 0
    state, scale, clock = now
    work.steps[0] = clock[STEPS]
    while True:
        remaining = (until.time - clock[TIME]) - clock[CARRY]
        if math.isnan(remaining):  # a motion back in time has left the range of numbers, and its time with it
            return Status.DIVERGED, mode, count
        found, guard, stay = next_event(tables, mode, state, scale, remaining, room.guards, room.on_surface, work)
        clock[STEPS] = work.steps[0]
        if found == LOST:
            return Status.WORK_SPENT if clock[STEPS] < 0.0 else Status.UNDECIDED, mode, count
        if found == NONE:
            if remaining == math.inf:
                return Status.SETTLED, mode, count
            advance(flow, mode, state, remaining, state)
            clock[TIME], clock[CARRY] = until.time, 0.0
            return Status.TIME_REACHED, mode, count
        if count == events.time.size:
            return Status.EVENTS_FULL, mode, count
        arrive(tables, mode, now, guard, stay, work)
        add_time(clock, stay)
        for i in range(state.size):
            events.before[count, i] = state[i]
            if not abs(state[i]) < LARGEST:
                return Status.DIVERGED, mode, count
        clock[SHORT_STAYS] = clock[SHORT_STAYS] + 1.0 if stay < tables.shortest_stay else 0.0
        end, mode, kind, sign = leave(tables, mode, found, guard, clock[SHORT_STAYS], now, room.state)
        if end != GOES_ON:
            return end, mode, count
        if kind == ACCUMULATION_KIND:
            clock[SHORT_STAYS] = 0.0
        events.time[count], events.kind[count] = clock[TIME] + clock[CARRY], kind
        events.sign[count], events.mode[count] = sign, mode
        for i in range(state.size):
            events.after[count, i] = state[i]
        count += 1
        if kind == until.kind and (until.mode < 0 or mode == until.mode):
            return Status.STOP_EVENT, mode, count


run_at = by_address(run_in, types.UniTuple(types.int64, 3))


class Engine(NamedTuple):
    """What kernels need to follow motions by :func:`run_at`, one at a time."""

    address: int  # of run_in
    room: Room


@inlined_kernel
def add_time(clock, stay):
    """Add a stay [s] to the time of a clock, a compensated sum, so that many short stays lose no digits."""
    total = clock[TIME] + stay
    if abs(clock[TIME]) >= abs(stay):
        clock[CARRY] += (clock[TIME] - total) + stay
    else:
        clock[CARRY] += (stay - total) + clock[TIME]
    clock[TIME] = total


@merged_kernel
def cut(events, first, last):
    """Return the events from the one of a number up to the one before another."""
    return Events(
        events.time[first:last], events.kind[first:last], events.sign[first:last], events.mode[first:last],
        events.before[first:last], events.after[first:last],
    )  # fmt: skip


@entry
def _sample(flow, mode, state, start, times, out):
    """Write the states at ``times`` [s] (k) of a stay that has begun at ``start`` in ``state``, in closed form."""
    for k in range(times.size):
        advance(flow, mode, state, times[k] - start, out[k])


sample = by_kind(_sample, _sample, flow_taylor.sample)


@entry
def states_at(tables, begin, events, times, states, modes):
    """Write exact states and modes at ``times`` [s], ascending from the begin on, to ``states`` and ``modes``.

    At the very time of an event they are those after it.
    """
    event, first = -1, 0
    while first < times.size:
        while event + 1 < events.time.size and events.time[event + 1] <= times[first]:
            event += 1
        last = first
        while last < times.size and (event + 1 == events.time.size or times[last] < events.time[event + 1]):
            modes[last] = begin.mode if event < 0 else events.mode[event]
            last += 1
        since, state = (begin.time, begin.state) if event < 0 else (events.time[event], events.after[event])
        sample(tables.flow, modes[first], state, since, times[first:last], states[first:last])
        first = last


@allocating_entry
def extremes_of_arcs(flow, modes, starts, durations, functionals):
    """Smallest and largest value over many arcs of a function that is affine in the state in each mode.

    Arguments: for each arc its mode (k), the state at its start (k, n) and its duration [s] (k); ``functionals``
    (modes, n + 1), under a friction law also (modes, 2 n + 2), of which the second half counts η times. Returns
    (smallest, largest), infinite if those of an arc are.
    """
    low, high = math.inf, -math.inf
    for k in range(modes.size):
        a, b = extremes(flow, modes[k], starts[k], functionals[modes[k]], durations[k])
        low, high = min(low, a), max(high, b)
    return low, high


extremes_at = by_address(extremes_of_arcs, types.UniTuple(types.float64, 2))
