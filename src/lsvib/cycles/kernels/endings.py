"""Where motions with two states end, of many automata at once: the common cases of ``lsvib.cycles.attractors``.

Every motion of a search – a part of the whole one, a return to a section, a cycle – is followed by one and the same
call of the event loop, which would else be compiled once for each: what comes back is *answered* by a plan of what to
follow next (:func:`_answer`). Every step is that of :func:`lsvib.cycles.attractors.steady_state`, of
:class:`lsvib.cycles.return_map.ReturnSection` and :func:`lsvib.cycles.attractors.orbit_extremes`, number by number, so
that the results are the same to the last bit. What is rare there – undamped families, leaps over slow returns, cycles
of several returns, lost searches – is not here: such a motion is *open*, and the caller follows it by those functions.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.engine.kernels import dispatch, event_loop
from lsvib.engine.kernels.columns import ALPHA, BETA, EQUILIBRIUM
from lsvib.engine.kernels.flow_planar import EPS, ROUNDING
from lsvib.engine.kernels.jit import allocating_kernel, kernel
from lsvib.engine.kernels.status import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.engine.kernels.tables import Tables

OPEN, SETTLED, CYCLE = range(3)  # outcomes: left to the caller; in one mode for ever; on a cycle
AMPLITUDE, PERIOD, MULTIPLIER, FORCE, SEIZURE_SPEED = range(5)  # columns of the numbers of a cycle
NUMBERS = 5  # how many they are
SPRAGS, RESTS, REVERSES = 1, 2, 4  # bits that say what happens on a cycle
_SETTLED, _STOPPED, _FULL = int(Status.SETTLED), int(Status.STOP_EVENT), int(Status.EVENTS_FULL)
# What a motion is followed for; the numbers lie beyond those of outcomes.
_PART = 3  # a part of the whole motion
_OLDER, _OLD, _NEW = 4, 5, 6  # P(y) − y for the secant method: the state before the last, the last, the next ones
_LEFT, _RIGHT = 7, 8  # of an enclosure, its ends
_AFTER, _BEFORE = 9, 10  # of P′, its two places
_STRAIGHT = 11  # P(y) − y of the last state, to see how many returns away the fixed point is
_ORBIT = 12  # the cycle


class Search(NamedTuple):
    """The numbers of the search, as ``lsvib.cycles.attractors`` and ``lsvib.cycles.return_map`` have them."""

    chunk: int  # events that are looked at first
    patience: int  # events after which a motion is left to the caller
    returns: int  # returns over which a repetition is looked for
    solved: int  # returns among which the nearest one is looked for
    fewest: int  # returns that show where a motion goes
    repeats: float  # relative change that is rounding
    corner: float  # size of a fixed point, in scales of the motion, that is an equilibrium
    few: float  # returns within which a target counts as reached straight
    patience_of_return: float  # time that a return may take, in times of the longest one seen
    longest: int  # events in one return
    secants: int
    wider: float
    widest: float
    slope_step: float


class Facts(NamedTuple):
    """What the event kinds and modes of a model mean."""

    rest: int  # mode at rest, −1 if there is none
    sprag: int  # kind of a seizure
    reversal: int  # kind of a reversal of the contact force


class Plan(NamedTuple):
    """What is followed next and what is known so far: numbers that change."""

    whole: np.ndarray  # (_WHOLES,) counts and indices, by the names below
    real: np.ndarray  # (_REALS,) numbers, by the names below
    left: np.ndarray  # (2,) state at the end of the last part of the whole motion
    origin: np.ndarray  # (2,) of the section
    direction: np.ndarray  # (2,) along it; zero if it is a point
    size: np.ndarray  # (2,) of the motion
    found: np.ndarray  # (2,) state on the cycle


# Of ``whole``: mode to start in, and most events; mode at the end of the last part, events of it, and of all parts;
# kind and mode of the section, whether it is a line, and the coordinate that measures its places; secants; whether the
# wider of two intervals is tried, and events of the return from its left end; whether the motion repeats to the last
# bit.
_MODE, _MOST, _LEFT_MODE, _CHUNK, _USED, _KIND, _ENTERS, _LINE, _CHOSEN, _SECANTS, _WIDER, _EVENTS, _REPEATS = range(13)
_WHOLES = 13  # how many they are
# Of ``real``: place that is followed; the last two places and P(y) − y there; half width of the interval; P(y) − y at
# its left end and at the first place of P′; longest time of a return; P′.
_PLACE, _Y_OLDER, _F_OLDER, _Y_OLD, _F_OLD, _WIDTH, _F_LEFT, _F_AFTER, _LIMIT, _SLOPE = range(10)
_REALS = 10  # how many they are


class Room(NamedTuple):
    """Working space: events as the event loop writes them, and the state."""

    times: np.ndarray
    kinds: np.ndarray
    signs: np.ndarray
    modes: np.ndarray
    before: np.ndarray
    after: np.ndarray
    state: np.ndarray
    scale: np.ndarray
    clock: np.ndarray
    other_kinds: np.ndarray  # events of another return, to compare with
    other_modes: np.ndarray


@kernel
def _put(room, u, w):
    """Set the state, exact as given, and the clock to zero."""
    room.state[0], room.state[1] = u, w
    room.scale[0], room.scale[1] = abs(u), abs(w)
    room.clock[0] = room.clock[1] = room.clock[2] = 0.0
    room.clock[3] = math.inf


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


@kernel
def _lay_section(tables, plan, u, w):
    """Lay the section of a plan through a state: a line if the state lies on one surface, else a point."""
    met, normal, size, direction = 0, 0, plan.size, plan.direction
    for s in range(tables.surfaces.shape[0]):
        row = tables.surfaces[s]
        value = row[0] * u + row[1] * w + row[2]
        if abs(value) <= ROUNDING * (abs(row[0]) * size[0] + abs(row[1]) * size[1] + abs(row[2])):
            met, normal = met + 1, s
    plan.origin[0], plan.origin[1] = u, w
    plan.whole[_LINE] = met == 1
    if met == 1:
        direction[0], direction[1] = -tables.surfaces[normal, 1], tables.surfaces[normal, 0]
        length = max(abs(direction[0] / size[0]), abs(direction[1] / size[1]))
        direction[0], direction[1] = direction[0] / length, direction[1] / length
        plan.whole[_CHOSEN] = abs(direction[1] / size[1]) > abs(direction[0] / size[0])


@kernel
def _place(plan, u, w):
    """Place of a state along the line."""
    i = plan.whole[_CHOSEN]
    return ((w if i == 1 else u) - plan.origin[i]) * (1.0 / plan.direction[i])


@kernel
def _return_from(plan, search, room, phase, place):
    """Follow the return from a place of the section."""
    plan.real[_PLACE] = place
    plan.whole[_MODE], plan.whole[_MOST] = plan.whole[_ENTERS], search.longest
    _put(room, plan.origin[0] + plan.direction[0] * place, plan.origin[1] + plan.direction[1] * place)
    return phase


@kernel
def _cycle_from(plan, search, room, u, w):
    """Follow the cycle through a state, if it is one: a fixed point next to the equilibrium is not."""
    if plan.whole[_REPEATS] == 0 and max(abs(u / plan.size[0]), abs(w / plan.size[1])) < search.corner:
        return OPEN
    plan.whole[_MODE], plan.whole[_MOST] = plan.whole[_ENTERS], search.longest
    plan.found[0], plan.found[1] = u, w
    _put(room, u, w)
    return _ORBIT


@kernel
def _go_on(plan, room):
    """Follow the next part of the whole motion, twice as long, from where the last one ended."""
    plan.whole[_CHUNK] *= 2
    plan.whole[_MOST], plan.whole[_MODE] = plan.whole[_CHUNK], plan.whole[_LEFT_MODE]
    _put(room, plan.left[0], plan.left[1])
    return _PART


@allocating_kernel
def _look(tables, search, plan, room, count):
    """Answer a part of the motion that is full of events: does it come back to where it was, or nearly?"""
    key = _latest_of_the_rarest(tables, room, count)
    if key < 0:
        return _go_on(plan, room)
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
        return _go_on(plan, room)
    if repeated > 1 or (repeated == 0 and nearest > 1):  # a cycle of several returns
        return OPEN
    if repeated == 0 and seen - 2 <= seen // 2:  # no earlier return in the later half
        return _go_on(plan, room)
    plan.whole[_KIND], plan.whole[_ENTERS], plan.whole[_REPEATS] = kind, mode, repeated
    plan.real[_LIMIT] = search.patience_of_return * longest
    _lay_section(tables, plan, u, w)
    plan.real[_Y_OLD] = plan.real[_SLOPE] = 0.0
    if plan.whole[_LINE] == 0:
        return _cycle_from(plan, search, room, u, w)
    if repeated == 1:
        return _return_from(plan, search, room, _AFTER, search.slope_step)
    j = watched[seen - 2]
    plan.real[_Y_OLDER] = _place(plan, room.after[j, 0], room.after[j, 1])
    plan.whole[_SECANTS] = 0
    return _return_from(plan, search, room, _OLDER, plan.real[_Y_OLDER])


@kernel
def _secant(plan, search, room):
    """Take the next step of the secant method, or begin with the enclosure of its result."""
    real = plan.real
    if plan.whole[_SECANTS] < search.secants and not (abs(real[_F_OLD]) <= EPS or real[_F_OLD] == real[_F_OLDER]):
        plan.whole[_SECANTS] += 1
        new = real[_Y_OLD] - real[_F_OLD] * (real[_Y_OLD] - real[_Y_OLDER]) / (real[_F_OLD] - real[_F_OLDER])
        return _return_from(plan, search, room, _NEW, new)
    real[_WIDTH], plan.whole[_WIDER] = ROUNDING, 0
    return _return_from(plan, search, room, _LEFT, real[_Y_OLD] - real[_WIDTH])


@kernel
def _enclosed(plan, search, room, inward):
    """Answer the returns from both ends of an interval: try the wider one, the next ones, or take it as proof."""
    real, whole = plan.real, plan.whole
    if inward and whole[_WIDER]:
        return _return_from(plan, search, room, _AFTER, real[_Y_OLD] + search.slope_step)
    if inward:
        whole[_WIDER] = 1
        return _return_from(plan, search, room, _LEFT, real[_Y_OLD] - search.wider * real[_WIDTH])
    whole[_WIDER] = 0
    real[_WIDTH] *= search.wider
    if real[_WIDTH] >= search.widest:
        return _go_on(plan, room)
    return _return_from(plan, search, room, _LEFT, real[_Y_OLD] - real[_WIDTH])


@kernel
def _answer_return(plan, search, room, phase, excess, count):
    """Answer a return to a line: P(y) − y, nan if the motion does not come back, and its number of events."""
    real, whole = plan.real, plan.whole
    if phase == _OLDER:
        real[_F_OLDER] = excess
        return _return_from(plan, search, room, _OLD, 0.0)
    if phase == _OLD:
        real[_F_OLD] = excess
        if not (math.isfinite(real[_F_OLDER]) and math.isfinite(excess)):
            return OPEN
        return _secant(plan, search, room)
    if phase == _NEW:
        if math.isnan(excess):
            return _go_on(plan, room)
        real[_Y_OLDER], real[_F_OLDER] = real[_Y_OLD], real[_F_OLD]
        real[_Y_OLD], real[_F_OLD] = real[_PLACE], excess
        if abs(real[_Y_OLD] - real[_Y_OLDER]) <= EPS:
            whole[_SECANTS] = search.secants
        return _secant(plan, search, room)
    if phase == _LEFT:
        real[_F_LEFT], whole[_EVENTS] = excess, count
        for k in range(count):
            room.other_kinds[k], room.other_modes[k] = room.kinds[k], room.modes[k]
        width = search.wider * real[_WIDTH] if whole[_WIDER] else real[_WIDTH]
        return _return_from(plan, search, room, _RIGHT, real[_Y_OLD] + width)
    if phase == _RIGHT:
        inward = real[_F_LEFT] > 0.0 > excess and count == whole[_EVENTS]
        for k in range(count if inward else 0):
            inward = inward and room.other_kinds[k] == room.kinds[k] and room.other_modes[k] == room.modes[k]
        return _enclosed(plan, search, room, inward)
    if phase == _AFTER:
        real[_F_AFTER] = excess
        return _return_from(plan, search, room, _BEFORE, real[_Y_OLD] - search.slope_step)
    if phase == _BEFORE:
        real[_SLOPE] = (real[_F_AFTER] - excess) / (2.0 * search.slope_step) + 1.0
        if whole[_REPEATS] == 1:
            if not math.isfinite(real[_SLOPE]):
                real[_SLOPE] = math.nan
            return _cycle_from(plan, search, room, plan.origin[0], plan.origin[1])
        if not abs(real[_SLOPE]) < 1.0:
            return _go_on(plan, room)
        return _return_from(plan, search, room, _STRAIGHT, 0.0)
    u = plan.origin[0] + plan.direction[0] * real[_Y_OLD]
    w = plan.origin[1] + plan.direction[1] * real[_Y_OLD]
    if not abs(_place(plan, u, w)) <= search.few * abs(excess):  # a way that the caller shall look at
        return OPEN
    return _cycle_from(plan, search, room, u, w)


@kernel
def _stays(tables, facts, mode, room):
    """Whether a motion that never leaves a mode ends in steady sliding; other ends are left to the caller."""
    row = tables.flow[mode]
    if mode == facts.rest:
        return OPEN
    excited = room.state[0] != row[EQUILIBRIUM] or room.state[1] != 0.0
    undamped = abs(row[ALPHA]) <= ROUNDING * row[BETA]
    return OPEN if excited and (undamped or row[ALPHA] < 0.0) else SETTLED


@allocating_kernel
def _answer(tables, facts, search, plan, room, phase, status, mode, count):
    """Answer what was followed: return what to follow next, or the outcome; see the names of phases."""
    end = room.clock[0] + room.clock[1]
    if phase == _PART:
        if not math.isfinite(end):
            return OPEN
        if status == _SETTLED:
            return _stays(tables, facts, mode, room)
        plan.whole[_USED] += count
        if status != _FULL or plan.whole[_USED] >= search.patience:
            return OPEN
        touches = tables.flow[mode, ALPHA] == 0.0 and tables.flow[mode, BETA] > 0.0
        for i in range(count // 2, count):
            touches = touches and room.kinds[i] == GRAZE_KIND
        if touches:
            return OPEN
        plan.left[0], plan.left[1] = room.state
        plan.whole[_LEFT_MODE] = mode
        return _look(tables, search, plan, room, count)
    back = status == _STOPPED and math.isfinite(end)
    if phase == _ORBIT:
        return CYCLE if back else OPEN
    if not back or room.times[0] == 0.0:
        return _answer_return(plan, search, room, phase, math.nan, 0)
    excess = _place(plan, room.state[0], room.state[1]) - plan.real[_PLACE]
    return _answer_return(plan, search, room, phase, excess, count)


@allocating_kernel
def _describe(tables, facts, plan, room, count, force, speed, numbers):
    """Write the numbers of the cycle that was followed; returns the bits of what happens on it.

    ``force`` (modes, 3) is the observable of the normal force; ``speed`` [rad/s] that of the motor.
    """
    mode, time, fastest = plan.whole[_ENTERS], 0.0, 0.0
    numbers[PERIOD], numbers[MULTIPLIER] = room.clock[0] + room.clock[1], plan.real[_SLOPE]
    low, high = math.inf, -math.inf
    least, most = math.inf, -math.inf
    row, state = np.zeros(3), np.empty(2)
    row[0] = 1.0
    state[0], state[1] = plan.found
    bits = RESTS if mode == facts.rest else 0
    for k in range(count + 1):
        until = room.times[k] if k < count else numbers[PERIOD]
        a, b = dispatch.extremes(tables.flow, mode, state, row, until - time)
        low, high = min(low, a), max(high, b)
        a, b = dispatch.extremes(tables.flow, mode, state, force[mode], until - time)
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


@allocating_kernel
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
        np.zeros(_WHOLES, dtype=np.int64),
        np.zeros(_REALS),
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
        _put(room, starts[k, 0], starts[k, 1])
        branch = event_loop.choose_branch(tables, 0, room.state, room.scale)
        plan.whole[_USED], plan.whole[_CHUNK], plan.whole[_MOST] = 0, search.chunk, search.chunk
        plan.whole[_MODE] = tables.branch_mode[branch] if branch >= 0 else -1
        phase, count = _PART if branch >= 0 else OPEN, 0
        while phase >= _PART:
            most, whole = plan.whole[_MOST], phase == _PART
            status, mode, count = event_loop.run(
                tables,
                plan.whole[_MODE],
                room.state,
                room.scale,
                room.clock,
                math.inf if whole else plan.real[_LIMIT],
                -1 if whole else plan.whole[_KIND],
                -1 if whole else plan.whole[_ENTERS],
                (
                    room.times[:most],
                    room.kinds[:most],
                    room.signs[:most],
                    room.modes[:most],
                    room.before[:most],
                    room.after[:most],
                ),
            )
            phase = _answer(tables, facts, search, plan, room, phase, status, mode, count)
        outcomes[k], bits[k], numbers[k, :] = phase, 0, math.nan
        if phase == CYCLE:
            bits[k] = _describe(tables, facts, plan, room, count, force[k], speed[k], numbers[k])
