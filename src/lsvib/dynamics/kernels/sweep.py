"""Where motions of many drives with two states end, by the rule of :mod:`lsvib.dynamics.kernels.attractor`."""

import math

import numpy as np

from lsvib.dynamics.kernels.attractor import NOTES, Found, end_of
from lsvib.dynamics.kernels.machine import AnyFlow
from lsvib.dynamics.kernels.single_mode import Outcome
from lsvib.engine.kernels import event_loop, search_planar
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, by_address
from lsvib.engine.kernels.layout import Tables

NUMBERS = np.dtype([(name, np.float64) for name in ("amplitude", "period", "multiplier", "force", "seizure_speed")])
end_of_at = by_address(end_of)
SPRAGS, RESTS, REVERSES = 1, 2, 4  # bits that say what happens on a cycle


@allocating_kernel
def _describe(tables, facts, reversal, found, events, force, speed, numbers):
    """Write the numbers of a cycle, a period of which is in ``events``; returns the bits of what happens on it.

    ``reversal``: kind of an event that reverses the contact force; ``force`` (m, 3), that observable; ``speed`` [rad/s]
    of the motor.
    """
    times, kinds, _, modes, before, after = events
    count, mode, time, state, row = found.notes[0]["events"], found.notes[0]["mode"], 0.0, np.empty(2), np.zeros(3)
    low, high, least, most, fastest = math.inf, -math.inf, math.inf, -math.inf, 0.0
    row[0] = 1.0
    state[0], state[1] = found.state[0], found.state[1]
    bits = RESTS if facts.rests[mode] else 0
    for k in range(count):
        a, b = search_planar.extremes(tables.flow.planar, mode, state, row, times[k] - time)
        low, high = min(low, a), max(high, b)
        a, b = search_planar.extremes(tables.flow.planar, mode, state, force[mode], times[k] - time)
        least, most = min(least, a), max(most, b)
        time, mode, state[0], state[1] = times[k], modes[k], after[k, 0], after[k, 1]
        bits |= (RESTS if facts.rests[mode] else 0) | (REVERSES if kinds[k] == reversal else 0)
        if facts.sprag_kinds[kinds[k]]:
            bits |= SPRAGS
            fastest = max(fastest, abs(speed + before[k, 1]))
    numbers["period"], numbers["seizure_speed"] = time, fastest
    numbers["multiplier"] = found.slopes[0, 0] if found.notes[0]["dimension"] > 0 else 0.0
    bounded = math.isfinite(low + high + least + most)
    numbers["amplitude"] = 0.5 * (high - low) if bounded else math.nan
    numbers["force"] = max(abs(least), abs(most)) if bounded else math.nan
    return bits


@allocating_entry
def ends_of_many(
    rule, engine, many, members, facts, known, reversal, work, starts, force, speed, rooms, outcomes, bits, numbers
):
    """Follow the motions of many drives, each from its own start.

    Arguments: the address of the rule; the engine; tables whose doubles have a first axis (k) for drives; the drives
    that are wanted (j); the work for each, in events; ``starts`` (k, 2); ``force`` (k, m, 3); ``speed`` (k); ``rooms``
    for events as of ``end_of``. ``outcomes``, ``bits`` (k) and ``numbers`` (k, of ``NUMBERS``) are filled for the
    drives that are wanted.
    """
    events, one, other = rooms
    found = Found(np.zeros(1, dtype=NOTES), np.zeros(2), np.zeros((2, 2)))
    state, scale = np.empty(2), np.empty(2)
    for k in members:
        tables = Tables(
            AnyFlow(many.flow.planar[k], many.flow.modal, many.flow.taylor),
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
        for i in range(2):
            state[i], scale[i] = starts[k, i], abs(starts[k, i])
        found.notes[0]["left"], bits[k] = work, 0
        branch = event_loop.choose_branch(tables, 0, state, scale)
        outcomes[k] = Outcome.OPEN
        if branch >= 0:
            mode = tables.branch_mode[branch]
            outcomes[k] = end_of_at(rule, engine, tables, facts, known, mode, state, 0, events, one, other, found)
        if outcomes[k] == Outcome.CYCLE:
            bits[k] = _describe(tables, facts, reversal, found, one, force[k], speed[k], numbers[k])
