"""Where motions with two states end, of many automata at once: the common cases of ``lsvib.cycles.attractors``.

Every step is that of :func:`lsvib.cycles.attractors.steady_state`, :class:`lsvib.cycles.return_map.ReturnSection` and
:func:`lsvib.cycles.attractors.orbit_extremes`, number by number, so that the results are the same to the last bit. What
is rare there – undamped families, leaps over slow returns, cycles of several returns, lost searches – is not here: such
a motion is *open*, and the caller follows it by those functions.
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
NUMBERS = 5
SPRAGS, RESTS, REVERSES = 1, 2, 4  # bits that say what happens on a cycle
_SETTLED, _STOPPED, _FULL = int(Status.SETTLED), int(Status.STOP_EVENT), int(Status.EVENTS_FULL)


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


class _Section(NamedTuple):
    """A line, or a point, in which events of one kind that enter one mode end; see ``ReturnSection``."""

    kind: int
    mode: int
    is_line: bool
    chosen: int  # coordinate that measures the place
    origin: np.ndarray  # (2,)
    direction: np.ndarray  # (2,)
    limit: float


class _Room(NamedTuple):
    """Working space: events as the event loop writes them, and states."""

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


@allocating_kernel
def _new_room(size):
    return _Room(
        np.empty(size),
        np.empty(size, dtype=np.int8),
        np.empty(size, dtype=np.int8),
        np.empty(size, dtype=np.int64),
        np.empty((size, 2)),
        np.empty((size, 2)),
        np.empty(2),
        np.empty(2),
        np.empty(3),
        np.empty(size, dtype=np.int8),
        np.empty(size, dtype=np.int64),
    )


@kernel
def _put(room, u, w):
    """Set the state, exact as given, and the clock to zero."""
    room.state[0], room.state[1] = u, w
    room.scale[0], room.scale[1] = abs(u), abs(w)
    room.clock[0] = room.clock[1] = room.clock[2] = 0.0


@allocating_kernel
def _run(tables, mode, room, limit, kind, stop_mode, most):
    """Follow the motion from the state of the room; returns (status, mode, number of events)."""
    events = (
        room.times[:most],
        room.kinds[:most],
        room.signs[:most],
        room.modes[:most],
        room.before[:most],
        room.after[:most],
    )
    return event_loop.run(tables, mode, room.state, room.scale, room.clock, limit, kind, stop_mode, events)


@kernel
def _end_time(room):
    return room.clock[0] + room.clock[1]


@allocating_kernel
def _key(tables, room, count):
    """Index of the latest of the rarest events in the later half of a motion; −1 if it only touches guards."""
    ours = 0
    for i in range(count):
        if room.kinds[i] != GRAZE_KIND and room.kinds[i] != ACCUMULATION_KIND:
            ours += 1
    numbers = np.zeros((tables.branch_kind.max() + 1, tables.flow.shape[0]), dtype=np.int64)
    latest = np.empty_like(numbers)
    i, left = count, ours - ours // 2
    while left > 0:
        i -= 1
        kind, mode = room.kinds[i], room.modes[i]
        if kind != GRAZE_KIND and kind != ACCUMULATION_KIND:
            left -= 1
            if numbers[kind, mode] == 0:
                latest[kind, mode] = i
            numbers[kind, mode] += 1
    best, fewest = -1, count + 1
    for kind in range(numbers.shape[0]):
        for mode in range(numbers.shape[1]):
            number = numbers[kind, mode]
            if 0 < number < fewest or (number == fewest and latest[kind, mode] > best):
                best, fewest = latest[kind, mode], number
    return best


@allocating_kernel
def _section(tables, kind, mode, u, w, size, longest, search):
    """The section of events through a state, for motions of some size."""
    met, normal = 0, 0
    for s in range(tables.surfaces.shape[0]):
        row = tables.surfaces[s]
        value = row[0] * u + row[1] * w + row[2]
        if abs(value) <= ROUNDING * (abs(row[0]) * size[0] + abs(row[1]) * size[1] + abs(row[2])):
            met, normal = met + 1, s
    origin, direction, chosen = np.empty(2), np.zeros(2), 0
    origin[0], origin[1] = u, w
    if met == 1:
        direction[0], direction[1] = -tables.surfaces[normal, 1], tables.surfaces[normal, 0]
        length = max(abs(direction[0] / size[0]), abs(direction[1] / size[1]))
        direction[0], direction[1] = direction[0] / length, direction[1] / length
        chosen = 1 if abs(direction[1] / size[1]) > abs(direction[0] / size[0]) else 0
    return _Section(kind, mode, met == 1, chosen, origin, direction, search.patience_of_return * longest)


@allocating_kernel
def _come_back(tables, section, room, search, u, w):
    """Follow the motion from a state until it is back on the section; returns the number of events, −1 without."""
    _put(room, u, w)
    status, _, count = _run(tables, section.mode, room, section.limit, section.kind, section.mode, search.longest)
    return count if status == _STOPPED and math.isfinite(_end_time(room)) else -1


@allocating_kernel
def _excess(tables, section, room, search, place):
    """P(y) − y of a line at y = ``place``, nan if the motion does not come back; and the number of its events."""
    count = _come_back(
        tables,
        section,
        room,
        search,
        section.origin[0] + section.direction[0] * place,
        section.origin[1] + section.direction[1] * place,
    )
    if count < 0 or room.times[0] == 0.0:
        return math.nan, 0
    i = section.chosen
    return (room.state[i] - section.origin[i]) * (1.0 / section.direction[i]) - place, count


@allocating_kernel
def _slope(tables, section, room, search, place):
    """P′ of a line by a central difference."""
    step = search.slope_step
    after, _ = _excess(tables, section, room, search, place + step)
    before, _ = _excess(tables, section, room, search, place - step)
    return (after - before) / (2.0 * step) + 1.0


@allocating_kernel
def _inward(tables, section, room, search, place, width):
    """Whether motions from both ends of an interval come back nearer to its middle, by the same events."""
    left, first = _excess(tables, section, room, search, place - width)
    for k in range(first):
        room.other_kinds[k], room.other_modes[k] = room.kinds[k], room.modes[k]
    right, second = _excess(tables, section, room, search, place + width)
    if not (left > 0.0 > right and first == second):
        return False
    same = True
    for k in range(first):
        same = same and room.other_kinds[k] == room.kinds[k] and room.other_modes[k] == room.modes[k]
    return same


@allocating_kernel
def _enclosed(tables, section, room, search, older):
    """Solve a line by the secant method and enclose the solution: (open, found, place, slope)."""
    old = 0.0
    f_older, _ = _excess(tables, section, room, search, older)
    f_old, _ = _excess(tables, section, room, search, old)
    if not (math.isfinite(f_older) and math.isfinite(f_old)):
        return True, False, old, 0.0
    for _ in range(search.secants):
        if abs(f_old) <= EPS or f_old == f_older:
            break
        new = old - f_old * (old - older) / (f_old - f_older)
        f_new, _ = _excess(tables, section, room, search, new)
        if math.isnan(f_new):
            return False, False, old, 0.0
        older, f_older, old, f_old = old, f_old, new, f_new
        if abs(old - older) <= EPS:
            break
    width = ROUNDING
    while width < search.widest and not (
        _inward(tables, section, room, search, old, width)
        and _inward(tables, section, room, search, old, search.wider * width)
    ):
        width *= search.wider
    if width >= search.widest:
        return False, False, old, 0.0
    slope = _slope(tables, section, room, search, old)
    return False, abs(slope) < 1.0, old, slope


@allocating_kernel
def _cycle(tables, facts, section, room, search, u, w, force, speed, numbers):
    """Write the numbers of the cycle through a state of the section; returns (outcome, bits of what happens on it).

    ``force`` (modes, 3) is the observable of the normal force; ``speed`` [rad/s] that of the motor.
    """
    count = _come_back(tables, section, room, search, u, w)
    if count < 0:
        return OPEN, 0
    bits = RESTS if section.mode == facts.rest else 0
    numbers[PERIOD] = _end_time(room)
    low, high = math.inf, -math.inf
    least, most = math.inf, -math.inf
    row, state = np.zeros(3), np.empty(2)
    row[0] = 1.0
    mode, time = section.mode, 0.0
    state[0], state[1] = u, w
    fastest = 0.0
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
    numbers[AMPLITUDE] = 0.5 * (high - low)
    numbers[FORCE] = max(abs(least), abs(most))
    if not (math.isfinite(low) and math.isfinite(high) and math.isfinite(least) and math.isfinite(most)):
        numbers[AMPLITUDE] = numbers[FORCE] = math.nan
    numbers[SEIZURE_SPEED] = fastest
    return CYCLE, bits


@allocating_kernel
def _recurrence(tables, facts, room, search, count, force, speed, numbers):
    """The cycle that the last events of a motion lie on: (whether the search is over, outcome, bits)."""
    key = _key(tables, room, count)
    if key < 0:
        return False, OPEN, 0
    kind, mode = room.kinds[key], room.modes[key]
    size, seen, longest, last = np.zeros(2), 0, 0.0, -1
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
        return False, OPEN, 0
    if repeated > 1 or (repeated == 0 and nearest > 1):
        return True, OPEN, 0  # a cycle of several returns
    section = _section(tables, kind, mode, u, w, size, longest, search)
    if repeated == 1:
        slope = _slope(tables, section, room, search, 0.0) if section.is_line else 0.0
        numbers[MULTIPLIER] = slope if math.isfinite(slope) else math.nan
        outcome, bits = _cycle(tables, facts, section, room, search, u, w, force, speed, numbers)
        return True, outcome, bits
    if seen - 2 <= seen // 2:  # no earlier return in the later half
        return False, OPEN, 0
    if not section.is_line:
        numbers[MULTIPLIER] = 0.0
        found_u, found_w = u, w
    else:
        i, j = section.chosen, watched[seen - 2]
        older = (room.after[j, i] - section.origin[i]) * (1.0 / section.direction[i])
        lost, found, place, slope = _enclosed(tables, section, room, search, older)
        if lost:
            return True, OPEN, 0
        if not found:
            return False, OPEN, 0
        numbers[MULTIPLIER] = slope
        found_u = section.origin[0] + section.direction[0] * place
        found_w = section.origin[1] + section.direction[1] * place
        target = ((found_u if i == 0 else found_w) - section.origin[i]) * (1.0 / section.direction[i])
        first, _ = _excess(tables, section, room, search, 0.0)
        if not abs(target) <= search.few * abs(first):
            return True, OPEN, 0
    if max(abs(found_u / size[0]), abs(found_w / size[1])) < search.corner:
        return True, OPEN, 0
    outcome, bits = _cycle(tables, facts, section, room, search, found_u, found_w, force, speed, numbers)
    return True, outcome, bits


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
def ending(tables, facts, search, room, u, w, force, speed, numbers):
    """Follow the motion from a state: (outcome, bits of what happens on a cycle).

    ``numbers`` (NUMBERS) are replaced.
    """
    _put(room, u, w)
    branch = event_loop.choose_branch(tables, 0, room.state, room.scale)
    if branch < 0:
        return OPEN, 0
    mode = tables.branch_mode[branch]
    used, chunk = 0, search.chunk
    while True:
        status, mode, count = _run(tables, mode, room, math.inf, -1, -1, chunk)
        if not math.isfinite(_end_time(room)):
            return OPEN, 0
        if status == _SETTLED:
            return _stays(tables, facts, mode, room), 0
        used += count
        if status != _FULL or used >= search.patience:
            return OPEN, 0
        touches = tables.flow[mode, ALPHA] == 0.0 and tables.flow[mode, BETA] > 0.0
        for i in range(count // 2, count):
            touches = touches and room.kinds[i] == GRAZE_KIND
        if touches:
            return OPEN, 0
        u, w = room.state[0], room.state[1]
        over, outcome, bits = _recurrence(tables, facts, room, search, count, force, speed, numbers)
        if over:
            return outcome, bits
        _put(room, u, w)
        chunk = 2 * chunk


@allocating_kernel
def endings(many, members, facts, search, starts, force, speed, outcomes, bits, numbers):
    """Follow the motions of many drives, each from its own start.

    Arguments: tables whose doubles have a first axis (k) for drives; the drives that are wanted (j); ``starts`` (k, 2);
    ``force`` (k, modes, 3); ``speed`` (k). ``outcomes``, ``bits`` (k) and ``numbers`` (k, NUMBERS) are filled for the
    drives that are wanted.
    """
    room = _new_room(max(search.longest, 2 * search.patience))
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
        numbers[k, :] = math.nan
        outcomes[k], bits[k] = ending(
            tables, facts, search, room, starts[k, 0], starts[k, 1], force[k], speed[k], numbers[k]
        )
