"""The rule of what a motion ends in, which :mod:`lsvib.systems.attractor` states; for any number of states."""

import math
from typing import NamedTuple

import numpy as np

from lsvib.systems.kernels import event_loop, flow_taylor, machine, poincare_map, single_mode
from lsvib.systems.kernels.jit import entry, kernel, on_stack
from lsvib.systems.kernels.layout import CARRY, TIME, Events, Now, Status, Until
from lsvib.systems.kernels.poincare_map import NEAR, Section, Verdict
from lsvib.systems.kernels.single_mode import Outcome

FIRST = 16  # events after which a motion is asked whether it repeats, to rounding
CHUNK = 64  # events that are looked at first for what it tends to; every further look takes twice as many
SIGHT = 4096  # most events between two looks
_SOLVED = 8  # most returns in a period that the map is solved for
_STILL = 1e-12  # a step of this size, in sizes of a known cycle, is rounding


class Facts(NamedTuple):
    """What the modes and events of a model mean."""

    rests: np.ndarray  # (m,) modes at rest
    sticks: np.ndarray  # (m,) these, and modes in which something is held
    sprag_modes: np.ndarray  # (m,)
    sprag_kinds: np.ndarray  # (128,)
    conserves: bool  # all modes in motion preserve volumes, because nothing damps


class Known(NamedTuple):
    """Cycles that a motion may be found to join: their events on a section, and how many there are in a period."""

    kind: np.ndarray  # (c,)
    mode: np.ndarray  # (c,)
    visits: np.ndarray  # (c,) events on the section in a period
    events: np.ndarray  # (c,) all events in a period
    point: np.ndarray  # (c, n) on the section
    size: np.ndarray  # (c, n)


NOTES = np.dtype(
    [
        *(
            (name, np.int64)
            for name in ("kind", "mode", "returns", "events", "dimension", "first_event", "sprags", "index")
        ),
        *((name, np.float64) for name in ("time", "frequency", "left")),  # [s], [1/s], work in events
    ]
)


class Asked(NamedTuple):
    """What a motion may end in: the model's facts, known cycles, and events after which others are looked for, too."""

    facts: Facts
    known: Known
    patience: int


class Records(NamedTuple):
    """Room for the events of a motion, and of two periods."""

    motion: Events
    one: Events
    other: Events


class Found(NamedTuple):
    """What is found of a motion."""

    notes: np.ndarray  # (1,) of ``NOTES``
    state: np.ndarray  # (n,) on the section, or where the motion was left
    slopes: np.ndarray  # (n, n) P′, the first d rows and columns


@kernel
def stays(tables, facts, mode, state, found):
    """Return what a motion that never leaves its mode ends in; the frequency [1/s] of what lasts, 0 if several do."""
    found.notes[0]["mode"] = mode
    if facts.rests[mode]:
        return Outcome.RESTS
    outcome, found.notes[0]["frequency"] = single_mode.stays(tables.flow, mode, state)
    return outcome


@kernel
def _fits(known, c, kinds, modes, after, at, k):
    """Whether four points in a row, the last of them number k, show that a motion tends to known cycle ``c``."""
    n, size, steps = known.size.shape[1], known.size[c], (0.0, 0.0, 0.0)
    for j in range(3):
        i, before = at[k - 2 + j], at[k - 3 + j]
        if i - before != known.events[c]:
            return False
        step = 0.0
        for x in range(n):
            step = max(step, abs(after[i, x] - after[before, x]) / size[x])
        steps = (steps[1], steps[2], step)
    first, second, third = steps
    if second > max(first, _STILL) or (third > _STILL and third >= second):
        return False
    ratio = third / second if third > _STILL else 0.0
    for x in range(n):
        way = ratio / (1.0 - ratio) * (after[at[k], x] - after[at[k - 1], x])
        off = after[at[k], x] + way - known.point[c, x]  # where the way ends, from the cycle
        if not (abs(way) <= 0.1 * size[x] and abs(off) <= 1e-3 * size[x]):
            return False
    return True


@kernel
def _meets(known, c, state):
    """Whether a state is the point of known cycle ``c``, to rounding."""
    meets = True
    for x in range(state.size):
        meets = meets and abs(state[x] - known.point[c, x]) <= _STILL * known.size[c, x]
    return meets


@kernel
def _joins(known, kinds, modes, after, by_speed):
    """Return the known cycle that a motion (k events) joins, and the event that shows it; −1 if it joins none.

    Under a friction law (``by_speed``), where motions cost more, one point of the cycle itself shows that as well.
    """
    at = on_stack(kinds.size, np.int64)
    for c in range(known.kind.size):
        seen = count = 0
        for i in range(kinds.size):
            if kinds[i] == known.kind[c] and modes[i] == known.mode[c]:
                if seen % known.visits[c] == 0:
                    at[count], count = i, count + 1
                seen += 1
        for k in range(count if by_speed else 0):
            if _meets(known, c, after[at[k]]):
                return c, at[k]
        for k in range(3, count):
            if _fits(known, c, kinds, modes, after, at, k):
                return c, at[k]
    return -1, -1


@kernel
def _count_sprags(facts, kinds, modes, found):
    for i in range(kinds.size):
        found.notes[0]["sprags"] += facts.sprag_kinds[kinds[i]] or facts.sprag_modes[modes[i]]


@kernel
def _fewer_returns(section, events, count, state):
    """Return the fewest returns, a divisor of those of the section, after which a period is back, and its events."""
    for returns in range(1, section.returns):
        seen = 0
        for i in range(count if section.returns % returns == 0 else 0):
            seen += events.kind[i] == section.kind and events.mode[i] == section.mode
            if seen == returns:
                back = True
                for x in range(state.size):
                    # distance of two points, relative to the motion, that are one
                    back = back and abs(events.after[i, x] - state[x]) <= 1e-9 * section.size[x]
                if back:
                    return returns, i + 1
                break
    return section.returns, count


@kernel
def _period(engine, tables, facts, section, points, records, budget, found):
    """Return what a motion with these ``points`` (k, n) on a section tends to by its map.

    It is CYCLE, SLIDES, or SPENT, which stands for nothing that is known.
    """
    n, d, step, size, events = section.size.size, section.dimension, section.returns, section.size, records.one
    place, state, form = on_stack(d), on_stack(n), on_stack((d, d))
    count, lost = poincare_map.newton(engine, tables, section, False, place, state, found.slopes, events, budget)
    if count == 0:
        form[:] = 0.0
        for f in range(d):
            form[f, f] = 1.0
        earlier = points[points.shape[0] // 2 :: step]
        settles = engine.by_speed and flow_taylor.is_settled(tables.flow.taylor, section.mode, state)
        settles = settles and earlier.shape[0] > 3
        if settles and poincare_map.approaches(section, place, earlier, form):
            found.notes[0]["mode"] = -1
            return Outcome.SLIDES
        return Outcome.SPENT
    verdict = poincare_map.judge(poincare_map.growth(found.slopes[:d, :d], form), lost, facts.conserves)
    if verdict == Verdict.NONE:
        return Outcome.SPENT
    away, reach, last = 0.0, 0.0, points.shape[0] - 1
    for f in range(d):
        away = max(away, abs(place[f]))
    for i in range(n):
        reach = max(reach, abs(state[i]) / size[i])
    earlier = points[last // 2 + 1 + (last - last // 2 - 1) % step :: step]
    if away > NEAR:
        few = d > 1 and earlier.shape[0] <= 10
        if few or verdict == Verdict.NEUTRAL or not poincare_map.approaches(section, place, earlier, form):
            return Outcome.SPENT
    if not poincare_map.same_events(engine, tables, section, place, away, events, count, records.other, budget):
        return Outcome.SPENT
    # A fixed point of this size, relative to the motion, is steady sliding, if that lies on a surface, no mode is
    # pushed away from it, and the motion shrinks towards it.
    if reach < 1e-5:
        nearer = farther = pushed = 0.0
        none, rate, sizes = on_stack(n), on_stack(n), on_stack(n)
        none[:] = 0.0
        for k in range(count):
            single_mode.field(tables.flow, events.mode[k], none, rate, sizes)
            for i in range(n):
                pushed = max(pushed, sizes[i])
        for i in range(n):
            nearer = max(nearer, abs(points[last, i]) / size[i])
            farther = max(farther, abs(points[last - step, i]) / size[i])
        found.notes[0]["mode"] = -1
        return Outcome.SLIDES if nearer < farther and pushed == 0.0 else Outcome.SPENT
    returns, fewer = _fewer_returns(section, events, count, state)
    if fewer < count:
        poincare_map.slopes_of(engine, tables, section, state, events, fewer, found.slopes)
    found.notes[0]["kind"], found.notes[0]["mode"], found.notes[0]["returns"] = section.kind, section.mode, returns
    found.notes[0]["events"], found.notes[0]["dimension"] = fewer, d
    for i in range(n):
        found.state[i] = state[i]
    return Outcome.CYCLE


@kernel
def _look(engine, tables, asked, mode, records, count, budget, found):
    """Return what a motion tends to by its last events, ``count`` of them; Outcome.SPENT if they do not show it."""
    times, kinds, _, modes, points, after = records.motion  # points take the place of states before events
    n, size = found.state.size, on_stack(found.state.size)
    for i in range(n):
        size[i] = 0.0
        for k in range(count):
            size[i] = max(size[i], abs(after[k, i]))
        size[i] = size[i] if size[i] > 0.0 else 1.0  # a coordinate that is zero at every event may have any scale
    key = poincare_map.rarest_event(tables, kinds[:count], modes[:count], after[:count], size)
    if key < 0:  # it only touches guards: rounding decides whether there is an event
        outcome = stays(tables, asked.facts, mode, found.state, found)
        return Outcome.OSCILLATES if outcome == Outcome.OSCILLATES else Outcome.SPENT
    seen, longest, last = 0, 0.0, -1
    for k in range(count):
        if kinds[k] == kinds[key] and modes[k] == modes[key]:
            longest = max(longest, times[k] - times[last]) if last >= 0 else 0.0
            for i in range(n):
                points[seen, i] = after[k, i]
            seen, last = seen + 1, k
    points = points[max(0, seen - 1000) : seen]
    seen = points.shape[0]
    nearest, smallest, repeats = 1, math.inf, False
    for back in range(1, min(64, seen - 1) + 1):  # most returns in a period that repeats
        change = 0.0
        for i in range(n):
            change = max(change, abs(points[seen - 1, i] - points[seen - 1 - back, i]) / size[i])
        repeats = change <= 1e-10  # change of the state over a period, relative to the motion, that is rounding
        if repeats or (back <= _SOLVED and change < smallest):
            nearest, smallest = back, change
        if repeats:
            break
    if seen < 2 or (not repeats and (seen < 4 or (count < CHUNK and asked.known.kind.size == 0))):
        return Outcome.SPENT
    unit, free, directions = on_stack(n), on_stack(n, np.int64), on_stack((n, n))
    d = poincare_map.lay(tables.surfaces, points[max(0, seen - 1 - _SOLVED) :], size, unit, free, directions)
    kind, entered, origin = np.int64(kinds[key]), np.int64(modes[key]), points[seen - 1]
    limit = 10.0 * longest  # time that a return may take
    for returns in range(1, nearest + 1):  # a slow cycle may seem to have a multiple of its returns
        if nearest % returns == 0 and (repeats or seen - 1 - returns > seen // 2):
            section = Section(kind, entered, returns, limit, d, origin, size, unit, free, directions)
            outcome = _period(engine, tables, asked.facts, section, points, records, budget, found)
            if outcome != Outcome.SPENT:
                return outcome
    return Outcome.SPENT


@kernel
def _hardly_changes(after, count):
    """Whether both halves of the latest events of a motion have the same size in every coordinate."""
    half, same = count // 2, count >= 1000  # events, over whose halves a vibration that hardly changes has one size
    for i in range(after.shape[1]):
        first = last = 0.0
        for k in range(half):
            first, last = max(first, abs(after[k, i])), max(last, abs(after[half + k, i]))
        same = same and abs(last - first) <= 0.01 * max(first, last)  # relative difference of these sizes
    return same


@kernel
def _complaint(status):
    """Return the outcome that stands for a status of the engine that ends a run without an answer."""
    if status == Status.DIVERGED:
        return Outcome.GROWS
    if status == Status.ACCUMULATED:
        return Outcome.ACCUMULATES
    return Outcome.LOST if status == Status.NO_BRANCH else Outcome.SEARCH_SPENT


@entry
def end_of(engine, tables, asked, mode, state, records, found):
    """Return what the motion from ``state`` (n), replaced, in a mode ends in.

    Arguments: the engine (:class:`machine.Machine`); ``found``, filled, in which ``notes["left"]`` is the work that may
    be spent, in events.
    """
    n, used, last = state.size, 0, 0
    scale, clock, budget = on_stack(n), on_stack(4), on_stack(1)
    clock[:], budget[0] = 0.0, found.notes[0]["left"]
    facts, known, patience = asked
    now, events = Now(state, scale, clock), records.motion
    times, kinds, modes, after = events.time, events.kind, events.mode, events.after
    soon = engine.by_speed and known.kind.size > 0
    chunk = FIRST if known.kind.size == 0 else 2 if soon else CHUNK
    for i in range(n):
        scale[i] = abs(state[i])
    found.notes[0]["first_event"], found.notes[0]["sprags"], found.notes[0]["time"] = event_loop.NO_KIND, 0, 0.0
    # a literal would be another type, and compile the loop anew
    until = Until(math.inf, np.int64(event_loop.NO_KIND), np.int64(event_loop.NO_KIND))
    while budget[0] > 0.0:
        for i in range(n):
            found.state[i] = state[i]
        found.notes[0]["mode"] = mode
        part = event_loop.cut(events, 0, chunk)
        status, mode, count = machine.run_within(engine, tables, mode, now, until, part, budget)
        found.notes[0]["left"] = budget[0]
        if found.notes[0]["first_event"] == event_loop.NO_KIND and count > 0:
            found.notes[0]["first_event"] = kinds[0]
        if not math.isfinite(clock[TIME] + clock[CARRY]):
            return Outcome.LOST
        if status != Status.EVENTS_FULL and status != Status.SETTLED:
            return _complaint(status)
        if status == Status.EVENTS_FULL and known.kind.size > 0:
            found.notes[0]["index"], shows = _joins(known, kinds[:count], modes[:count], after[:count], soon)
            if shows >= 0:
                _count_sprags(facts, kinds[: shows + 1], modes[: shows + 1], found)
                found.notes[0]["time"] = times[shows]
                return Outcome.KNOWN
        _count_sprags(facts, kinds[:count], modes[:count], found)
        found.notes[0]["time"] = clock[TIME] + clock[CARRY]
        for i in range(n):
            found.state[i] = state[i]
        if status == Status.SETTLED:
            return stays(tables, facts, mode, state, found)
        used, last = used + count, count
        if used < (min(patience, CHUNK) if soon else patience):
            continue
        outcome = _look(engine, tables, asked, mode, records, count, budget, found)
        if outcome != Outcome.SPENT:
            return outcome
        chunk = CHUNK if chunk == FIRST and not soon else min(2 * chunk, SIGHT)
    return Outcome.SPENT_STEADILY if _hardly_changes(after, last) else Outcome.SPENT
