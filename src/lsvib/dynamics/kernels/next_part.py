"""Decide, after a part of a motion was followed, what to follow next, or what the motion ends on.

The steps are those of :func:`lsvib.dynamics.attractor.steady_state`, of
:class:`lsvib.dynamics.poincare_map.Section` and of :mod:`lsvib.dynamics.recurrences`, number by number.
"""

import math

import numpy as np

from lsvib.dynamics.kernels.plan import (
    AFTER,
    BEFORE,
    CHOSEN,
    CYCLE,
    ENTERS,
    EVENTS,
    F_AFTER,
    F_LEFT,
    F_OLD,
    F_OLDER,
    FIRST,
    KIND,
    LAST,
    LEFT,
    LEFT_MODE,
    LIMIT,
    LINE,
    NEW,
    OLD,
    OLDER,
    OPEN,
    ORBIT,
    PART,
    PLACE,
    REPEATS,
    RIGHT,
    SECANTS,
    SETTLED,
    SLOPE,
    STRAIGHT,
    USED,
    WIDER,
    WIDTH,
    Y_OLD,
    Y_OLDER,
    cycle_from,
    go_on,
    lay_section,
    place,
    return_from,
)
from lsvib.engine.kernels.flow_planar import EPS, ROUNDING
from lsvib.engine.kernels.jit import allocating_kernel, kernel
from lsvib.engine.kernels.layout import A0, A1, ACCUMULATION_KIND, ALPHA, BETA, EQUILIBRIUM, GRAZE_KIND, B, Status

_SETTLED, _STOPPED, _FULL = int(Status.SETTLED), int(Status.STOP_EVENT), int(Status.EVENTS_FULL)


@allocating_kernel
def _latest_of_the_rarest(tables, room, count):
    """Index of the latest of the rarest events in the later half of a motion; −1 if it only touches guards."""
    ours = 0
    for i in range(count):
        if room.kinds[i] != GRAZE_KIND and room.kinds[i] != ACCUMULATION_KIND:
            ours += 1
    most = 0
    for kind in tables.branch_kind:
        most = max(most, kind)
    modes = tables.flow.shape[0]
    numbers, latest = np.zeros((most + 1) * modes, dtype=np.int64), np.zeros((most + 1) * modes, dtype=np.int64)
    i, left = count, ours - ours // 2
    while left > 0:
        i -= 1
        if room.kinds[i] != GRAZE_KIND and room.kinds[i] != ACCUMULATION_KIND:
            left -= 1
            own = room.kinds[i] * modes + room.modes[i]
            if numbers[own] == 0:
                latest[own] = i
            numbers[own] += 1
    best, fewest = -1, count + 1
    for own in range(numbers.size):
        if 0 < numbers[own] < fewest or (numbers[own] == fewest and latest[own] > best):
            best, fewest = latest[own], numbers[own]
    return best


@allocating_kernel
def _look(tables, facts, search, plan, room, count):
    """Answer a part of the motion that is full of events: does it come back to where it was, or nearly?"""
    key = _latest_of_the_rarest(tables, room, count)
    if key < 0:
        return go_on(plan, room)
    kind, mode = room.kinds[key], room.modes[key]
    size, seen, longest, last = plan.size, 0, 0.0, -1
    size[0] = size[1] = 0.0
    watched = np.empty(count, dtype=np.int64)
    for i in range(count):
        size[0], size[1] = max(size[0], abs(room.after[i, 0])), max(size[1], abs(room.after[i, 1]))
        if room.kinds[i] == kind and room.modes[i] == mode:
            if seen > 0:
                longest = max(longest, room.times[i] - room.times[last])
            last, watched[seen] = i, i
            seen += 1
    for i in range(2):
        if size[i] == 0.0:
            size[i] = 1.0
    u, w = room.after[last, 0], room.after[last, 1]
    repeated, nearest, smallest = 0, 1, math.inf
    for back in range(1, min(search.returns, seen - 1) + 1):
        i = watched[seen - 1 - back]
        change = max(abs(u - room.after[i, 0]) / size[0], abs(w - room.after[i, 1]) / size[1])
        if change <= search.repeats:
            repeated = back
            break
        if back <= search.solved and change < smallest:
            nearest, smallest = back, change
    if seen < search.fewest and repeated == 0:
        return go_on(plan, room)
    if repeated > 1 or (repeated == 0 and nearest > 1):  # a cycle of several returns
        return OPEN
    if repeated == 0 and seen - 2 <= seen // 2:  # no earlier return in the later half
        return go_on(plan, room)
    plan.whole[KIND], plan.whole[ENTERS], plan.whole[REPEATS] = kind, mode, repeated
    plan.real[LIMIT] = search.patience_of_return * longest
    lay_section(tables, plan, u, w)
    plan.real[Y_OLD] = plan.real[SLOPE] = 0.0
    if plan.whole[LINE] == 0:  # next to a corner the caller shall look
        return cycle_from(plan, search, room, u, w) if kind == facts.release or mode == facts.rest else OPEN
    if repeated == 1:
        return return_from(plan, search, room, AFTER, search.slope_step)
    j = watched[seen - 2]
    plan.real[Y_OLDER] = place(plan, room.after[j, 0], room.after[j, 1])
    plan.whole[SECANTS] = 0
    return return_from(plan, search, room, OLDER, plan.real[Y_OLDER])


@kernel
def _secant(plan, search, room):
    """Take the next step of the secant method, or begin with the enclosure of its result."""
    real = plan.real
    if plan.whole[SECANTS] < search.secants and not (abs(real[F_OLD]) <= EPS or real[F_OLD] == real[F_OLDER]):
        plan.whole[SECANTS] += 1
        new = real[Y_OLD] - real[F_OLD] * (real[Y_OLD] - real[Y_OLDER]) / (real[F_OLD] - real[F_OLDER])
        return return_from(plan, search, room, NEW, new)
    real[WIDTH], plan.whole[WIDER] = ROUNDING, 0
    return return_from(plan, search, room, LEFT, real[Y_OLD] - real[WIDTH])


@kernel
def _enclosed(plan, search, room, inward):
    """Answer the returns from both ends of an interval: try the wider one, the next ones, or take it as proof."""
    real, whole = plan.real, plan.whole
    if inward and whole[WIDER]:
        return return_from(plan, search, room, AFTER, real[Y_OLD] + search.slope_step)
    if inward:
        whole[WIDER] = 1
        return return_from(plan, search, room, LEFT, real[Y_OLD] - search.wider * real[WIDTH])
    whole[WIDER] = 0
    real[WIDTH] *= search.wider
    if real[WIDTH] >= search.widest:
        return go_on(plan, room)
    return return_from(plan, search, room, LEFT, real[Y_OLD] - real[WIDTH])


@kernel
def _grain(tables, plan, room, count):
    """Rounding of the place after a return of ``count`` events, in roundings of one; see ``Section.grain``.

    It is bounded by how far the motion swings, and by the least speed at which it crosses a surface.
    """
    far_u = far_w = 0.0
    least, mode = 1.0, plan.whole[ENTERS]
    for i in range(count):
        row, u, w = tables.flow[mode], room.before[i, 0], room.before[i, 1]
        swing_u = abs(u) + (abs(w) / row[BETA] if row[BETA] > 0.0 else 0.0)
        swing_w = abs(w) + row[BETA] * abs(u)
        far_u, far_w = max(far_u, swing_u), max(far_w, swing_w)
        rate = row[B] - row[A0] * u - row[A1] * w
        rates = abs(row[B]) + abs(row[A0]) * swing_u + abs(row[A1]) * swing_w
        for s in range(tables.surfaces.shape[0]):
            n_u, n_w, n_0 = tables.surfaces[s, 0], tables.surfaces[s, 1], tables.surfaces[s, 2]
            size = abs(n_u) * swing_w + abs(n_w) * rates
            if size > 0.0 and abs(n_u * u + n_w * w + n_0) <= ROUNDING * (abs(n_u * u) + abs(n_w * w) + abs(n_0)):
                least = min(least, abs(n_u * w + n_w * rate) / size)
        mode = room.modes[i]
    i = plan.whole[CHOSEN]
    swing = max(1.0, (far_w if i == 1 else far_u) / abs(plan.direction[i]))
    return swing / least if least > 0.0 else math.inf


@kernel
def _answer_return(tables, plan, search, room, phase, excess, count):
    """Answer a return to a line: P(y) − y, nan if the motion does not come back, and its number of events."""
    real, whole = plan.real, plan.whole
    if phase == OLDER:
        real[F_OLDER] = excess
        return return_from(plan, search, room, OLD, 0.0)
    if phase == OLD:
        real[F_OLD] = excess
        if not (math.isfinite(real[F_OLDER]) and math.isfinite(excess)):
            return OPEN
        return _secant(plan, search, room)
    if phase == NEW:
        if math.isnan(excess):
            return go_on(plan, room)
        real[Y_OLDER], real[F_OLDER] = real[Y_OLD], real[F_OLD]
        real[Y_OLD], real[F_OLD] = real[PLACE], excess
        if abs(real[Y_OLD] - real[Y_OLDER]) <= EPS:
            whole[SECANTS] = search.secants
        return _secant(plan, search, room)
    if phase == LEFT:
        real[F_LEFT], whole[EVENTS] = excess, count
        for k in range(count):
            room.other_kinds[k], room.other_modes[k] = room.kinds[k], room.modes[k]
        width = search.wider * real[WIDTH] if whole[WIDER] else real[WIDTH]
        return return_from(plan, search, room, RIGHT, real[Y_OLD] + width)
    if phase == RIGHT:
        inward = real[F_LEFT] > 0.0 > excess and count == whole[EVENTS]
        for k in range(count if inward else 0):
            inward = inward and room.other_kinds[k] == room.kinds[k] and room.other_modes[k] == room.modes[k]
        return _enclosed(plan, search, room, inward)
    if phase == AFTER:
        real[F_AFTER] = excess
        return return_from(plan, search, room, BEFORE, real[Y_OLD] - search.slope_step)
    if phase == BEFORE:
        real[SLOPE] = (real[F_AFTER] - excess) / (2.0 * search.slope_step) + 1.0
        clear = search.clear * _grain(tables, plan, room, count)
        attracts = excess > clear and real[F_AFTER] < -clear
        if whole[REPEATS] == 1:
            return cycle_from(plan, search, room, plan.origin[0], plan.origin[1]) if attracts else OPEN
        if not abs(real[SLOPE]) < 1.0:
            return go_on(plan, room)
        if not attracts:
            return OPEN
        return return_from(plan, search, room, STRAIGHT, 0.0)
    u = plan.origin[0] + plan.direction[0] * real[Y_OLD]
    w = plan.origin[1] + plan.direction[1] * real[Y_OLD]
    if not abs(place(plan, u, w)) <= search.few * abs(excess):  # a way that the caller shall look at
        return OPEN
    return cycle_from(plan, search, room, u, w)


@kernel
def _stays(tables, facts, mode, room):
    """Whether a motion that never leaves a mode ends in steady sliding; other ends are left to the caller."""
    row = tables.flow[mode]
    if mode == facts.rest:
        return OPEN
    excited = room.state[0] != row[EQUILIBRIUM] or room.state[1] != 0.0
    return OPEN if excited and row[ALPHA] <= 0.0 else SETTLED


@allocating_kernel
def answer(tables, facts, search, plan, room, phase, status, mode, count):
    """Answer what was followed: return what to follow next, or the outcome; see the names of phases."""
    end = room.clock[0] + room.clock[1]
    if phase == PART:
        if not math.isfinite(end):
            return OPEN
        if status == _SETTLED:
            return _stays(tables, facts, mode, room)
        plan.whole[USED] += count
        if status != _FULL or plan.whole[USED] >= search.patience:
            return OPEN
        touches = tables.flow[mode, ALPHA] == 0.0 and tables.flow[mode, BETA] > 0.0
        for i in range(count // 2, count):
            touches = touches and room.kinds[i] == GRAZE_KIND
        if touches:
            return OPEN
        plan.left[0], plan.left[1] = room.state
        plan.whole[LEFT_MODE] = mode
        return _look(tables, facts, search, plan, room, count)
    back = status == _STOPPED and math.isfinite(end)
    if phase == ORBIT:
        return CYCLE if back else OPEN
    inside = plan.real[FIRST] <= plan.real[PLACE] <= plan.real[LAST]
    if not back or room.times[0] == 0.0 or not inside:
        return _answer_return(tables, plan, search, room, phase, math.nan, 0)
    excess = place(plan, room.state[0], room.state[1]) - plan.real[PLACE]
    return _answer_return(tables, plan, search, room, phase, excess, count)
