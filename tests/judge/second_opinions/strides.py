"""A fast way to follow drives with four states: strides by propagators, conditions between them by polynomials.

Each arc begins with a stride far below the fastest time; strides double while the quintic polynomial through value and
two derivatives of every condition at both ends agrees with the condition in the middle. By the coefficients of that
polynomial in Bernstein's form a condition keeps its sign, or falls through zero once, or is looked at more closely; a
root is closed in on by shorter and shorter strides. It shares no line with the engine, nor its method, and has 32
digits; but what is between the places it looks at is interpolated, not proved. Where it cannot tell it says so.
"""

import numpy as np

from judge.second_opinions.double_doubles import add, affine, finite, moved, multiply
from judge.second_opinions.endings import AMBIGUOUS, EVENTS_FULL, LATE, TIME_REACHED
from judge.second_opinions.jit import allocating_kernel, kernel
from judge.second_opinions.stride_constants import ABSENT, FORCE, ORDERS, Ladders

SEIZURE = FORCE - 1  # what a condition of no speed is in the Painlevé region
_ZERO = 1e-25  # of its terms: a condition that an event, or the start, has put on zero
_SAFETY = 4.0  # times the error of the polynomial in the middle
_ROUNDING = 1e-13  # of the coefficients
MOST_STRIDES = 100_000  # of a motion of some turns
_PATIENCE = 4  # strides after one that was too long, before a longer one is tried
_LOWEST = -20  # rung of the shortest stride, below the ladder's by the series; two events may follow each other so fast
_NONE = -1  # index of no mode and of no condition


@kernel
def _shift(field, x, s, term, other, out):
    """Put the state a time s, below the first rung, after x into ``out``, by the series of the flow; arrays (4, 2)."""
    for i in range(4):
        term[i, 0], term[i, 1] = affine(field[i], x)
        term[i, 0], term[i, 1] = multiply(term[i, 0], term[i, 1], s, 0.0)
        out[i, 0], out[i, 1] = add(x[i, 0], x[i, 1], term[i, 0], term[i, 1])
    for k in range(2, 7):
        for i in range(4):
            h, e = 0.0, 0.0
            for j in range(4):
                p, q = multiply(field[i, j, 0], field[i, j, 1], term[j, 0], term[j, 1])
                h, e = add(h, e, p, q)
            other[i, 0], other[i, 1] = multiply(h, e, s / k, 0.0)
        for i in range(4):
            term[i, 0], term[i, 1] = other[i, 0], other[i, 1]
            out[i, 0], out[i, 1] = add(out[i, 0], out[i, 1], term[i, 0], term[i, 1])


@kernel
def _sign(c, m, r, x, reached, on_zero):
    """Sign of a condition at x, or of its first derivative that is not zero; 0 if all are.

    ``reached`` (4,): largest magnitude of each coordinate so far, by which x is known: what an event has put on zero
    may be no more than the coordinate's own last digits.
    """
    for k in range(ORDERS):
        if k == 0 and on_zero:
            continue
        value, _ = affine(c.rows[m, r, k], x)
        size = c.sizes[m, r, k, 4]
        for i in range(4):
            size += c.sizes[m, r, k, i] * reached[i]
        if abs(value) > _ZERO * size:
            return 1 if value > 0 else -1
    return 0


@kernel
def _lasts(c, m, x, reached, zero):
    """Whether a mode's own flow keeps all its conditions; the speeds whose bits are in ``zero`` are zero exactly."""
    if c.ties[m] & ~zero:
        return False
    for r in range(c.kinds.shape[1]):
        kind = c.kinds[m, r]
        if kind != ABSENT and _sign(c, m, r, x, reached, kind >= 0 and zero >> kind & 1) < 0:
            return False
    return True


@kernel
def _chosen(c, x, reached, zero, seized):
    """The one mode that lasts at x, or _NONE; ``seized``: sign of the impulse of a seizure just before, or 0."""
    found, rest, against = _NONE, _NONE, _NONE
    count, rests = 0, 0
    for m in range(c.direction.size):
        if not _lasts(c, m, x, reached, zero):
            continue
        found, count = m, count + 1
        if c.direction[m] == 0:
            rest, rests = m, rests + 1
        elif seized and c.direction[m] == -seized and c.contact[m] == seized:
            against = m
    if c.paradox:
        if against != _NONE:
            return against
        if rests:
            return rest if rests == 1 else _NONE
    return found if count == 1 else _NONE


@kernel
def _look(c, m, x, h, values):
    """Put value, and first and second derivative times h and h², of the conditions of a mode into ``values``."""
    for r in range(c.kinds.shape[1]):
        if c.kinds[m, r] != ABSENT:
            values[r, 0] = affine(c.rows[m, r, 0], x)[0]
            values[r, 1] = affine(c.rows[m, r, 1], x)[0] * h
            values[r, 2] = affine(c.rows[m, r, 2], x)[0] * h * h


@kernel
def _between(left, middle, right, fresh):
    """What a condition does between two places: 0 it stays positive, 1 it falls through zero once, −1 cannot tell.

    ``left``, ``middle``, ``right`` (3,): value and derivatives; ``fresh``: it is zero on the left, and leaves it.
    """
    b0 = 0.0 if fresh else left[0]
    b1, b2 = b0 + left[1] / 5, b0 + 2 * left[1] / 5 + left[2] / 20
    b5 = right[0]
    b4, b3 = b5 - right[1] / 5, b5 - 2 * right[1] / 5 + right[2] / 20
    top = max(abs(b0), abs(b1), abs(b2), abs(b3), abs(b4), abs(b5))
    value = (b0 + 5 * b1 + 10 * b2 + 10 * b3 + 5 * b4 + b5) / 32
    slope = 5 * (-b0 - 3 * b1 - 2 * b2 + 2 * b3 + 3 * b4 + b5) / 16
    error = _SAFETY * max(abs(value - middle[0]), abs(slope - middle[1])) + _ROUNDING * top
    later = min(b3, b4, b5)
    if fresh:
        if later > error and min(b1, b2) >= -_ROUNDING * top:
            return 0
        return -1
    if min(b0, b1, b2, later) > error:
        return 0
    steepest = max(b1 - b0, b2 - b1, b3 - b2, b4 - b3, b5 - b4)
    return 1 if b5 < -error and steepest < -error else -1


@kernel
def _judge(c, m, x, middle, end, h, fresh, crossing, left, mid, right):
    """Whether one of a mode's conditions is unclear within a stride h, and whether one, so ``crossing``, falls."""
    _look(c, m, x, h, left)
    _look(c, m, middle, h, mid)
    _look(c, m, end, h, right)
    unclear, crossed = False, False
    for r in range(crossing.size):
        if c.kinds[m, r] == ABSENT:
            continue
        what = _between(left[r], mid[r], right[r], fresh[r])
        unclear |= what < 0
        crossing[r] = what > 0
        crossed |= what > 0
    return unclear, crossed


@kernel
def _moment(c, m, r, x, most):
    """Time, up to ``most``, until a falling condition is zero, by Newton's method on its series."""
    value = affine(c.rows[m, r, 0], x)[0]
    g1, g2 = affine(c.rows[m, r, 1], x)[0], affine(c.rows[m, r, 2], x)[0]
    g3, g4 = affine(c.rows[m, r, 3], x)[0], affine(c.rows[m, r, 4], x)[0]
    s = 0.0
    for _ in range(8):
        slope = g1 + s * (g2 + s * (g3 / 2 + s * g4 / 6))
        if slope >= 0:
            return most
        s -= (value + s * (g1 + s * (g2 / 2 + s * (g3 / 6 + s * g4 / 24)))) / slope
    return s


@allocating_kernel
def _arc(c, m, x, zero, t, t_end, budget, size):
    """Follow a mode from x, which is moved, to the first condition that fails or to t_end.

    Returns (status, time, index of the condition, what is left of the budget); _NONE for the index at t_end. One loop:
    its parts share nine arrays, which are made once for an arc and not for each stride.
    """
    count, first = c.kinds.shape[1], c.shortest[m]
    field, tables = c.fields[m], c.tables[m]
    middle, end, other, term = np.empty((4, 2)), np.empty((4, 2)), np.empty((4, 2)), np.empty((4, 2))
    left, mid, right = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    fresh, crossing = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    for r in range(count):
        kind = c.kinds[m, r]
        if kind == ABSENT:
            continue
        value = affine(c.rows[m, r, 0], x)[0]
        terms = c.sizes[m, r, 0, 4]
        for i in range(4):
            terms += c.sizes[m, r, 0, i] * size[i]
        fresh[r] = (kind >= 0 and zero >> kind & 1) or abs(value) <= _ZERO * terms
        if not fresh[r] and value <= 0:
            return AMBIGUOUS, t, r, budget
    rung, patience = 1, 0
    while t_end - t > 0:
        while rung > 0 and t + first * 2.0**rung > t_end:
            rung -= 1
        budget -= 1
        if budget < 0:
            return LATE, t, _NONE, budget
        h = first * 2.0**rung
        last = rung <= 0 and t + h >= t_end
        if last:
            h = t_end - t
        if rung > 0:
            moved(tables[rung - 1], x, middle)
            moved(tables[rung - 1], middle, end)
        else:
            _shift(field, x, 0.5 * h, term, other, middle)
            _shift(field, x, h, term, other, end)
        if not finite(end):
            return AMBIGUOUS, t, _NONE, budget
        unclear, crossed = _judge(c, m, x, middle, end, h, fresh, crossing, left, mid, right)
        if unclear:
            rung, patience = rung - 1, _PATIENCE
            if rung < _LOWEST:
                return AMBIGUOUS, t, _NONE, budget
            continue
        if crossed:
            if rung > 0:
                s, fired = _close_in(c, m, x, rung, crossing, middle, end)
            else:
                s, fired = _last_digits(c, m, x, 0.0, crossing, middle, other, end)
            return (AMBIGUOUS if fired == _NONE else TIME_REACHED), t + s, fired, budget
        fresh[:] = False
        t = t_end if last else t + h
        for i in range(4):
            size[i] = max(size[i], abs(middle[i, 0]), abs(end[i, 0]))
            x[i, 0], x[i, 1] = end[i, 0], end[i, 1]
        if patience > 0:
            patience -= 1
        elif rung + 1 < len(tables):
            rung += 1
    return TIME_REACHED, t_end, _NONE, budget


@allocating_kernel
def _close_in(c, m, x, rung, crossing, ahead, scratch):
    """Move x to the first zero of the crossing conditions, which lies within a stride; (time, index) or (·, _NONE)."""
    first, spent, other = c.shortest[m], 0.0, np.empty((4, 2))
    for k in range(rung - 1, -1, -1):
        for _ in range(2 if k == 0 else 1):  # the stride is one first rung longer than the sum of those tried
            moved(c.tables[m, k], x, ahead)
            inside = True
            for r in range(crossing.size):
                if crossing[r]:
                    inside &= affine(c.rows[m, r, 0], ahead)[0] > 0
            if not inside:
                break
            x[:] = ahead
            spent += first * 2.0**k
    return _last_digits(c, m, x, spent, crossing, ahead, other, scratch)


@allocating_kernel
def _last_digits(c, m, x, spent, crossing, ahead, other, scratch):
    """Move x, which two first rungs at most separate from it, to the first zero; (``spent`` and time, index)."""
    first = c.shortest[m]
    fired, least = _NONE, 2 * first
    for r in range(crossing.size):
        if crossing[r]:
            s = _moment(c, m, r, x, 2 * first)
            if s < least:
                fired, least = r, s
    if fired == _NONE:
        return spent, fired
    for _ in range(3):  # the last digits of the time are beyond a double
        s = _moment(c, m, fired, x, 2 * first)
        if not abs(s) < 2 * first:
            return spent, _NONE
        _shift(c.fields[m], x, s, ahead, other, scratch)
        x[:] = scratch
        spent += s
    return spent, fired


@kernel
def _on_zero(c, x):
    """Bits of the speeds that are zero at a start."""
    zero = 0
    for k in range(2):
        zero |= int(affine(c.speeds[k], x)[0] == 0.0) << k
    return zero


@kernel
def _put(table, x, scratch):
    """Apply an affine map (4, 5, 2) to x."""
    for i in range(4):
        scratch[i, 0], scratch[i, 1] = affine(table[i], x)
    for i in range(4):
        x[i, 0], x[i, 1] = scratch[i, 0], scratch[i, 1]


@allocating_kernel
def follow(c: Ladders, start, t_end, most, times, before, after, fired, states, end, size):
    """Follow the motion from ``start`` (4,) to ``t_end`` [s], by at most so many strides; the arrays (k) tell events.

    ``before``, ``after``: modes; ``fired``: kind of the condition that failed, or SEIZURE; ``states`` (k, 4), or (0, 4)
    if they are not wanted; ``end``, ``size`` (4,): final state, and largest magnitude of each coordinate. Returns (how
    it ends, number of events, mode at the end).
    """
    x, scratch = np.zeros((4, 2)), np.empty((4, 2))
    x[:, 0] = start
    size[:] = np.abs(start)
    t, count, budget, mode = 0.0, 0, most, _NONE
    zero, status = _on_zero(c, x), TIME_REACHED
    slip = affine(c.speeds[0], x)[0]
    way = 0 if slip == 0 else (1 if slip > 0 else -1)
    if c.paradox and way != 0:
        for m in range(c.direction.size):
            if c.direction[m] == way and c.contact[m] == -way:
                mode = m
    else:
        mode = _chosen(c, x, size, zero, 0)
    while True:
        if mode == _NONE:
            status = AMBIGUOUS
            break
        row, here = 0, mode
        at_once = False
        if c.paradox and count == 0 and way != 0:  # a start where law −1 is not admissible
            for r in range(c.kinds.shape[1]):
                if c.kinds[mode, r] == FORCE and affine(c.rows[mode, r, 0], x)[0] < 0:
                    row, at_once = r, True
        if not at_once:
            status, t, row, budget = _arc(c, mode, x, zero, t, t_end, budget, size)
            if status != TIME_REACHED or row == _NONE:
                break
        kind = c.kinds[mode, row]
        zero, seized = c.ties[mode], 0
        if kind >= 0:
            zero |= 1 << kind
        elif c.paradox and c.direction[mode] != 0:
            slip = affine(c.speeds[0], x)[0]
            seized, zero, kind = (1 if slip > 0 else -1), 1, SEIZURE
            for i in range(4):
                x[i, 0], x[i, 1] = add(x[i, 0], x[i, 1], c.impulse[i] * slip, 0.0)
        _put(c.ties_of[zero], x, scratch)
        for i in range(4):
            size[i] = max(size[i], abs(x[i, 0]))
        mode = _chosen(c, x, size, zero, seized)
        if mode == _NONE:
            status = AMBIGUOUS
            break
        times[count], before[count], after[count], fired[count] = t, here, mode, kind
        if count < states.shape[0]:
            for i in range(4):
                states[count, i] = x[i, 0]
        count += 1
        if count == times.size:
            status = EVENTS_FULL
            break
    end[:] = x[:, 0] + x[:, 1]
    return status, count, mode
