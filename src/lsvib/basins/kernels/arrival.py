"""When motions with two states arrive at their attractors, and how often they sprag on the way."""

import math

from lsvib.basins.kernels.labels import UNKNOWN, ellipse, new_scratch, put, step
from lsvib.engine.kernels import event_loop, flow_planar
from lsvib.engine.kernels.flow_planar import EPS
from lsvib.engine.kernels.jit import allocating_entry, entry, kernel
from lsvib.engine.kernels.layout import A0, ACCUMULATION_KIND, ALPHA, BETA, DELTA, EQUILIBRIUM, GRAZE_KIND, Status

_SETTLED = int(Status.SETTLED)
_STEPS = 4000  # 2098 doublings lead from the smallest double to the largest, and some 105 halvings end a bracket


@kernel
def arrival_time(tables, known, mode, state):
    """Time [s] from ``state`` until the motion, which stays in a damped ``mode``, is within the ellipse of arrival."""
    row = tables.flow[mode]
    kappa2, goal = known.trap[mode, 0], known.trap[mode, 2]
    size = ellipse(tables, known, mode, state)
    if size <= goal:
        return 0.0
    if row[BETA] * row[BETA] == kappa2:  # the ellipse shrinks as e^{−2αt}
        return 0.5 * math.log(size / goal) / row[ALPHA]
    y, w = state[0] - row[EQUILIBRIUM], state[1]
    low, high = 0.0, 1.0 / (row[ALPHA] + row[BETA] + row[DELTA])
    for _ in range(_STEPS):
        middle = high if low == 0.0 else 0.5 * (low + high)
        c, s, s_rate = flow_planar.responses(row, middle)
        there, rate = y * c + w * s, w * s_rate - row[A0] * y * s
        eta = rate + row[ALPHA] * there
        if eta * eta + kappa2 * there * there > goal:
            low, high = (middle, high) if low > 0.0 else (0.0, 2.0 * high)
        elif low == 0.0:
            low = EPS * high
        else:
            high = middle
        if low > 0.0 and high - low <= 4.0 * EPS * high:
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
    """Return the time [s] until the motion from ``scratch.state`` in ``mode`` is at its attractor, and its sprags.

    ``sprags`` (b): whether a branch is an event that sprags. Arrival: in the trapping ellipse; at an event of a cycle,
    within ``cycle_reach``; at the event after which an undamped mode is never left. The time is infinite if the motion
    diverges, or if ``budget`` events are not enough.
    """
    state, clock, short, count = scratch.state, scratch.clock, 0, 0
    clock[0] = clock[1] = 0.0
    if _on_cycle(known, mode, state):
        return 0.0, 0
    for _ in range(budget):
        if ellipse(tables, known, mode, state) < known.trap[mode, 2]:
            return clock[0] + clock[1], count
        start = mode
        outcome, _, kind, mode, stay, short = step(tables, mode, short, scratch)
        if outcome == _SETTLED:
            if known.trap[mode, 2] > 0.0:
                return clock[0] + clock[1] + arrival_time(tables, known, mode, state), count
            if known.settled[mode] == known.diverged:
                return math.inf, count
            return clock[0] + clock[1], count
        if outcome != event_loop.GOES_ON:
            return math.inf, count
        event_loop.add_time(clock, stay)
        if kind != GRAZE_KIND and kind != ACCUMULATION_KIND:
            for k in range(sprags.size):
                count += kind == sprags[k]
        if known.resting[start] != UNKNOWN:
            return clock[0] + clock[1] + known.release[start, 0], count + int(known.release[start, 1])
        if _on_cycle(known, mode, state):
            return clock[0] + clock[1], count
    return math.inf, count


@allocating_entry
def map_approaches(tables, known, sprags, x, y, across, budget, times, counts):
    """Fill ``times`` [s] and ``counts`` (rows, columns) by :func:`approach`; other arguments as ``map_labels`` has."""
    scratch = new_scratch(tables)
    for i in range(y.size):
        for j in range(x.size):
            put(scratch, y[i] if across else x[j], x[j] if across else y[i])
            branch = event_loop.choose_branch(tables, 0, scratch.state, scratch.scale)
            if branch < 0:
                times[i, j], counts[i, j] = math.inf, 0
                continue
            time, count = approach(tables, known, sprags, tables.branch_mode[branch], scratch, budget)
            times[i, j], counts[i, j] = time, count
