"""The Poincaré map of a motion, compiled: its section, its returns, and its fixed points that attract.

The events of one kind that enter one mode lie on one surface, or on the intersection of several, as release from rest
does. The states there form an affine *section* of d dimensions. A place y (d) on it counts the free coordinates of the
state, from an origin, in units; the other coordinates follow from the surfaces. P(y) is the next place, with the
derivative P′ of :mod:`lsvib.systems.kernels.saltation`.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from lsvib.systems.kernels.event_loop import cut
from lsvib.systems.kernels.flow_planar import EPS, ROUNDING
from lsvib.systems.kernels.jit import entry, kernel, merged_kernel, on_stack
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, CARRY, GRAZE_KIND, TIME, Begin, Now, Status, Until
from lsvib.systems.kernels.machine import run_within
from lsvib.systems.kernels.saltation import derivative

LONGEST = 1024  # events in a period
NEAR = 1e-6  # distance within which a motion has reached a fixed point, well above rounding even in a stiff contact
_MARGINS = (1e-12, 2e-8)  # by which multipliers must lie inside the unit circle: the rounding of P′ between these
ON_CIRCLE = 1e-6  # distance from the unit circle of multipliers on it: defective ones scatter by the root of 1e-12
_TINY = 2.2250738585072014e-308  # the smallest normal number
_PARTS = 8  # most of the way to a fixed point, at the starts of which the events of a return are compared


class Verdict(IntEnum):
    """What a fixed point does to motions beside it."""

    NONE = 0  # it repels, or that is lost in rounding
    ATTRACTS = 1
    NEUTRAL = 2  # one of a family


class Section(NamedTuple):
    """A section of return through ``origin`` (n); one return of its map is ``returns`` of the motion."""

    kind: int  # of the events that end on it
    mode: int  # that they enter
    returns: int
    limit: float  # time [s] that one return of the motion may take
    dimension: int  # d
    origin: np.ndarray  # (n,)
    size: np.ndarray  # (n,) of the motion
    unit: np.ndarray  # (n,)
    free: np.ndarray  # (n,) the first d are the free coordinates
    directions: np.ndarray  # (n, n) state by place: the first d columns


@kernel
def meets(row, state, size):
    """Whether a state of a motion of a size (n) lies on a surface, to rounding."""
    n = state.size
    value, terms = row[n], abs(row[n])
    for i in range(n):
        value += row[i] * state[i]
        terms += abs(row[i]) * size[i]
    return abs(value) <= ROUNDING * terms


@entry
def rarest_event(tables, kinds, modes, after, size):
    """Return the index of the latest of the rarest events in the later half of a motion (k); −1 if it only touches.

    Of kinds that are equally rare the one that lies on most surfaces counts, because its section has the fewest
    dimensions and does not lie where the contact force passes zero, where the map is steep; then the latest one.
    """
    own, most, count = 0, 0, tables.guard_start.size - 1
    for k in range(kinds.size):
        if kinds[k] != GRAZE_KIND and kinds[k] != ACCUMULATION_KIND:
            own, most = own + 1, max(most, kinds[k])
    numbers, latest = on_stack((most + 1) * count, np.int64), on_stack((most + 1) * count, np.int64)
    numbers[:] = latest[:] = 0
    k, left = kinds.size, own - own // 2
    while left > 0:
        k -= 1
        if kinds[k] != GRAZE_KIND and kinds[k] != ACCUMULATION_KIND:
            left -= 1
            event = kinds[k] * count + modes[k]
            if numbers[event] == 0:
                latest[event] = k
            numbers[event] += 1
    best, fewest, highest = -1, kinds.size + 1, 0
    for event in range(numbers.size):
        if not 0 < numbers[event] <= fewest:
            continue
        met = 0
        for s in range(tables.surfaces.shape[0]):
            met += meets(tables.surfaces[s], after[latest[event]], size)
        rarer = numbers[event] < fewest or met > highest
        if rarer or (met == highest and latest[event] > best):
            best, fewest, highest = latest[event], numbers[event], met
    return best


@entry
def lay(surfaces, points, size, unit, free, directions):
    """Lay the section on which ``points`` (k, n) of a motion of a ``size`` (n) lie; the last one is its origin.

    A point may lie on one more surface by chance; those that all points meet count. Filled are unit (n); free (n), the
    coordinates that the surfaces leave, with full pivoting in this unit; directions (n, n), how the state changes with
    each of them. Returns how many are free.
    """
    n, count, rank, d = size.size, surfaces.shape[0], 0, 0
    rows, tied = on_stack(n, np.int64), on_stack(n, np.int64)  # surfaces that count, what each of them determines
    table, used = on_stack((count, n)), on_stack(count + n, np.bool_)
    used[:] = False
    for i in range(n):
        # least unit of a coordinate of the origin, relative to its size in the whole motion
        unit[i] = max(abs(points[points.shape[0] - 1, i]), 1e-6 * size[i], _TINY)
    for s in range(count):
        met, length = True, 0.0
        for k in range(points.shape[0]):
            met = met and meets(surfaces[s], points[k], size)
        for i in range(n):
            length = max(length, abs(surfaces[s, i]) * unit[i])
        for i in range(n):
            table[s, i] = surfaces[s, i] * unit[i] / length if met and length > 0.0 else 0.0
    while rank < n:
        largest, row, column = 1e-9, -1, -1  # relative pivot below which surfaces count as one
        for s in range(count):
            for i in range(n):
                if abs(table[s, i]) > largest and not (used[s] or used[count + i]):
                    largest, row, column = abs(table[s, i]), s, i
        if row < 0:
            break
        used[row] = used[count + column] = True
        rows[rank], tied[rank], pivot = row, column, table[row, column]
        for i in range(n):
            table[row, i] /= pivot
        for s in range(count):
            part = table[s, column]
            for i in range(n):
                table[s, i] -= part * table[row, i] if s != row else 0.0
        rank += 1
    for i in range(n):
        if used[count + i]:
            continue
        for k in range(n):
            directions[k, d] = unit[i] if k == i else 0.0
        for k in range(rank):
            directions[tied[k], d] = -table[rows[k], i] * unit[tied[k]]
        free[d], d = i, d + 1
    return d


@entry
def come_back(engine, tables, section, state, events, budget):
    """Follow a period from ``state`` (n), replaced by its end; returns the number of its events, 0 if there is none.

    What happens is written to ``events``; ``budget`` (1,) is counted down by what the period takes.
    """
    scale, clock, here, count, back = on_stack(state.size), on_stack(4), section.mode, 0, True
    clock[:] = 0.0
    for i in range(state.size):
        scale[i] = abs(state[i])
    now = Now(state, scale, clock)
    for _ in range(section.returns):
        until = Until(clock[TIME] + clock[CARRY] + section.limit, section.kind, section.mode)
        status, here, more = run_within(engine, tables, here, now, until, cut(events, count, events.time.size), budget)
        count += more
        back = status == Status.STOP_EVENT
        if not back:
            break
    return count if back and math.isfinite(clock[TIME] + clock[CARRY]) and events.time[0] > 0.0 else 0


@kernel
def put(section, part, place, state):
    """Write the state at ``part`` of the way from the origin to a place to ``state``."""
    for i in range(state.size):
        state[i] = section.origin[i]
        for f in range(section.dimension):
            state[i] += part * section.directions[i, f] * place[f]


@kernel
def _solve(matrix, vector):
    """Replace ``vector`` by the solution of ``matrix`` x = ``vector``, which is spoilt; whether there is one."""
    d = vector.size
    for k in range(d):
        pivot = k
        for i in range(k + 1, d):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if not 0.0 < abs(matrix[pivot, k]) < math.inf:
            return False
        for j in range(d):
            matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
        vector[k], vector[pivot] = vector[pivot], vector[k]
        for i in range(k + 1, d):
            part = matrix[i, k] / matrix[k, k]
            vector[i] -= part * vector[k]
            for j in range(k, d):
                matrix[i, j] -= part * matrix[k, j]
    for k in range(d - 1, -1, -1):
        for j in range(k + 1, d):
            vector[k] -= matrix[k, j] * vector[j]
        vector[k] /= matrix[k, k]
        if not math.isfinite(vector[k]):
            return False
    return True


@kernel
def slopes_of(engine, tables, section, state, events, count, slopes):
    """Write P′ (d, d) along a period of so many events from ``state`` (n) to ``slopes`` (n, n).

    Returns the size of its rounding, not finite without P′.
    """
    n, size = section.origin.size, 0.0
    total, lost = on_stack((n, n)), on_stack((n, n))
    derivative(engine.derivative, tables, Begin(0.0, section.mode, state), cut(events, 0, count), total, lost)
    for f in range(section.dimension):
        i = section.free[f]
        for g in range(section.dimension):
            slopes[f, g] = rounding = 0.0
            for j in range(n):
                slopes[f, g] += total[i, j] * section.directions[j, g] / section.unit[i]
                rounding += lost[i, j] * abs(section.directions[j, g]) / section.unit[i]
            size += rounding if math.isfinite(slopes[f, g]) else math.inf
    return size


@entry
def newton(engine, tables, section, patient, place, state, slopes, events, budget):
    """Solve P(y) = y from the origin by Newton's method: ``place`` (d), ``state`` (n), P′ and the period of it.

    Steps are taken until they no longer shrink, which is rounding. Returns the number of events of the period, 0
    without success, and the size of the rounding of P′. A ``patient`` search, of cycles that no motion tends to, halves
    steps beyond what comes back and goes on where they grow; whether it closes is for the caller to see.
    """
    d, last, halved = section.dimension, math.inf, 0
    matrix, gap, end, lost = on_stack((d, d)), on_stack(d), on_stack(state.size), 0.0
    for f in range(d):
        place[f] = gap[f] = 0.0
    for _ in range(40 if patient else 16):  # steps at most; each doubles the digits
        put(section, 1.0, place, state)
        for i in range(state.size):
            end[i] = state[i]
        count = come_back(engine, tables, section, end, events, budget)
        if count == 0 and patient and last < math.inf and halved < 8:
            for f in range(d):
                gap[f] *= 0.5
                place[f] -= gap[f]
            halved += 1
            continue
        if count == 0 or d == 0:
            return count, 0.0
        budget[0] -= count  # for P′, which takes about as much as ordinary events
        lost = slopes_of(engine, tables, section, state, events, count, slopes)
        for f in range(d):
            i = section.free[f]
            gap[f] = (end[i] - section.origin[i]) / section.unit[i] - place[f]
            for g in range(d):
                matrix[f, g] = (1.0 if f == g else 0.0) - slopes[f, g]
        if not (lost < math.inf and _solve(matrix, gap)):
            return count if patient else 0, lost
        length, far = 0.0, 1.0
        for f in range(d):
            length, far = max(length, abs(gap[f])), max(far, abs(place[f]))
        if length <= 4.0 * EPS * far or (length >= 0.5 * last and last <= NEAR):
            return count, lost
        if not (length < last or patient):
            return 0, lost
        last, halved = length, 0
        for f in range(d):
            place[f] += gap[f]
    return 0, lost


@entry
def growth(slopes, form):
    """Return the magnitude of the largest multiplier, an eigenvalue of P′ (d, d), by repeated squaring.

    ``form`` (d, d) is filled with Σ (P′ᵀ)ᵏ P′ᵏ, the quadratic form that P′ makes smaller, whatever its eigenvectors
    are; it is not finite where the sum is beyond all numbers.
    """
    d, logarithm, weight, rate = slopes.shape[0], 0.0, 1.0, -math.inf
    power, square, part = on_stack((d, d)), on_stack((d, d)), on_stack((d, d))
    for i in range(d):
        for j in range(d):
            power[i, j], form[i, j] = slopes[i, j], 1.0 if i == j else 0.0
    # of the number of returns over which growth is determined: 2⁴⁰, more than a slow multiplier needs
    for _ in range(40):
        largest = 0.0
        for i in range(d):
            for j in range(d):
                largest = max(largest, abs(power[i, j]))
        if largest == 0.0:
            break
        logarithm += math.log(largest)
        rate, weight = logarithm * weight, 0.5 * weight
        factor = math.exp(logarithm) if logarithm < 300.0 else math.inf
        for i in range(d):
            for j in range(d):
                power[i, j] /= largest
        for i in range(d):
            for j in range(d):
                square[i, j] = part[i, j] = 0.0
                for k in range(d):
                    square[i, j] += power[i, k] * power[k, j]
                    part[i, j] += form[i, k] * power[k, j]
        still = True  # power and form are what all that follow are
        for i in range(d):
            for j in range(d):
                more, before = 0.0, form[i, j]
                for k in range(d):
                    more += power[k, i] * part[k, j]
                form[i, j] += factor * (factor * more) if more != 0.0 and factor > 0.0 else 0.0
                still = still and form[i, j] == before and square[i, j] == power[i, j]
        if still:
            break
        logarithm *= 2.0
        power, square = square, power
    return math.exp(rate)


@entry
def judge(radius, lost, conserves):
    """Whether a fixed point attracts, by its largest multiplier, or is one of a neutral family: nothing damps."""
    margin = min(max(lost, _MARGINS[0]), _MARGINS[1])
    if conserves and abs(radius - 1.0) <= max(margin, ON_CIRCLE):
        return Verdict.NEUTRAL
    return Verdict.ATTRACTS if radius < 1.0 - margin else Verdict.NONE


@kernel
def approaches(section, place, points, form):
    """Whether each of some points (k, n) of a motion in turn lies nearer to a place, in the norm of ``form``."""
    d, last, away = section.dimension, math.inf, on_stack(section.dimension)
    for k in range(points.shape[0]):
        for f in range(d):
            i = section.free[f]
            away[f] = (points[k, i] - section.origin[i]) / section.unit[i] - place[f]
        distance = 0.0
        for f in range(d):
            for g in range(d):
                distance += away[f] * form[f, g] * away[g]
        if not (distance < last or distance <= NEAR * NEAR):
            return False
        last = distance
    return True


@merged_kernel
def same_events(engine, tables, section, place, away, events, count, room, budget):
    """Whether periods from all along the way to a place, ``away``, have the events of that from there, so many."""
    state = on_stack(section.origin.size)
    parts = math.ceil(min(away / NEAR, _PARTS))  # of the way, none shorter than ``NEAR`` unless it is the only one
    for k in range(parts):
        put(section, k / parts, place, state)
        if come_back(engine, tables, section, state, room, budget) != count:
            return False
        for i in range(count):
            if events.kind[i] != room.kind[i] or events.mode[i] != room.mode[i]:
                return False
    return True
