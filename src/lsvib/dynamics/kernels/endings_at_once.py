"""Where motions with two states end, of many automata at once: the common cases of ``lsvib.dynamics.attractor``.

Every motion of a search – a part of the whole one, a return to a section, a cycle – is followed by one and the same
call of the event loop, which would else be compiled once for each: what comes back is *answered* by a plan of what to
follow next (:mod:`lsvib.dynamics.kernels.next_part`). Every step is that of the search for one drive
(:func:`lsvib.dynamics.attractor.steady_state`, :class:`lsvib.dynamics.poincare_map.Section`,
:func:`lsvib.dynamics.attractor.orbit_extremes`), number by number, so that the results are the same to the last
bit. What is rare there – undamped families, leaps over slow returns, cycles of several returns, lost searches – is not
here: such a motion is *open*, and the caller follows it by those functions.
"""

import math

import numpy as np

from lsvib.dynamics.kernels.next_part import answer
from lsvib.dynamics.kernels.plan import (
    CHUNK,
    CYCLE,
    ENTERS,
    KIND,
    LIMIT,
    MODE,
    MOST,
    OPEN,
    PART,
    REALS,
    SLOPE,
    USED,
    WHOLES,
    Plan,
    Room,
    put,
)
from lsvib.engine.kernels import event_loop
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel
from lsvib.engine.kernels.layout import Tables

AMPLITUDE, PERIOD, MULTIPLIER, FORCE, SEIZURE_SPEED = range(5)  # columns of the numbers of a cycle
NUMBERS = 5  # how many they are
SPRAGS, RESTS, REVERSES = 1, 2, 4  # bits that say what happens on a cycle


@allocating_kernel
def _describe(tables, facts, plan, room, count, force, speed, numbers):
    """Write the numbers of the cycle that was followed; returns the bits of what happens on it.

    ``force`` (modes, 3) is the observable of the normal force; ``speed`` [rad/s] that of the motor.
    """
    mode, time, fastest = plan.whole[ENTERS], 0.0, 0.0
    numbers[PERIOD], numbers[MULTIPLIER] = room.clock[0] + room.clock[1], plan.real[SLOPE]
    low, high = math.inf, -math.inf
    least, most = math.inf, -math.inf
    row, state = np.zeros(3), np.empty(2)
    row[0] = 1.0
    state[0], state[1] = plan.found
    bits = RESTS if mode == facts.rest else 0
    for k in range(count + 1):
        until = room.times[k] if k < count else numbers[PERIOD]
        a, b = event_loop.extremes(tables.flow, mode, state, row, until - time)
        low, high = min(low, a), max(high, b)
        a, b = event_loop.extremes(tables.flow, mode, state, force[mode], until - time)
        least, most = min(least, a), max(most, b)
        if k < count:
            time, mode = until, room.modes[k]
            state[0], state[1] = room.after[k, 0], room.after[k, 1]
            if mode == facts.rest:
                bits |= RESTS
            if room.kinds[k] == facts.reversal:
                bits |= REVERSES
            if room.kinds[k] == facts.sprag:
                bits |= SPRAGS
                fastest = max(fastest, abs(speed + room.before[k, 1]))
    numbers[AMPLITUDE], numbers[FORCE] = 0.5 * (high - low), max(abs(least), abs(most))
    if not (math.isfinite(low) and math.isfinite(high) and math.isfinite(least) and math.isfinite(most)):
        numbers[AMPLITUDE] = numbers[FORCE] = math.nan
    numbers[SEIZURE_SPEED] = fastest
    return bits


@allocating_entry
def endings(many, members, facts, search, starts, force, speed, outcomes, bits, numbers):
    """Follow the motions of many drives, each from its own start.

    Arguments: tables whose doubles have a first axis (k) for drives; the drives that are wanted (j); ``starts`` (k, 2);
    ``force`` (k, modes, 3); ``speed`` (k). ``outcomes``, ``bits`` (k) and ``numbers`` (k, NUMBERS) are filled for the
    drives that are wanted. Long because compiled code names every field of the tables and arrays that it hands on.
    """
    size = max(search.longest, 2 * search.patience)
    room = Room(
        np.empty(size),
        np.empty(size, dtype=np.int8),
        np.empty(size, dtype=np.int8),
        np.empty(size, dtype=np.int64),
        np.empty((size, 2)),
        np.empty((size, 2)),
        np.empty(2),
        np.empty(2),
        np.empty(4),
        np.empty(size, dtype=np.int8),
        np.empty(size, dtype=np.int64),
    )
    plan = Plan(
        np.zeros(WHOLES, dtype=np.int64),
        np.zeros(REALS),
        np.zeros(2),
        np.zeros(2),
        np.zeros(2),
        np.zeros(2),
        np.zeros(2),
    )
    for k in members:
        tables = Tables(
            many.flow[k],
            many.surfaces[k],
            many.snap,
            many.guard_start,
            many.guard_surface,
            many.guard_sign,
            many.guard_transition,
            many.guard_parts[k],
            many.transition_reset,
            many.resets[k],
            many.branch_start,
            many.branch_mode,
            many.branch_kind,
            many.branch_sign,
            many.condition_start,
            many.condition_row[k],
            many.condition_test,
            many.beyond_accumulation,
            many.shortest_stay[k],
        )
        put(room, starts[k, 0], starts[k, 1])
        branch = event_loop.choose_branch(tables, 0, room.state, room.scale)
        plan.whole[USED], plan.whole[CHUNK], plan.whole[MOST] = 0, search.chunk, search.chunk
        plan.whole[MODE] = tables.branch_mode[branch] if branch >= 0 else -1
        phase, count = PART if branch >= 0 else OPEN, 0
        while phase >= PART:
            most, whole = plan.whole[MOST], phase == PART
            status, mode, count = event_loop.run(
                tables,
                plan.whole[MODE],
                room.state,
                room.scale,
                room.clock,
                math.inf if whole else plan.real[LIMIT],
                -1 if whole else plan.whole[KIND],
                -1 if whole else plan.whole[ENTERS],
                (
                    room.times[:most],
                    room.kinds[:most],
                    room.signs[:most],
                    room.modes[:most],
                    room.before[:most],
                    room.after[:most],
                ),
            )
            phase = answer(tables, facts, search, plan, room, phase, status, mode, count)
        outcomes[k], bits[k], numbers[k, :] = phase, 0, math.nan
        if phase == CYCLE:
            bits[k] = _describe(tables, facts, plan, room, count, force[k], speed[k], numbers[k])
