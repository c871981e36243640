"""The certain search for the first guard that fires in a mode whose flow is carried in blocks.

A step on which a guard is undecided by its bounds (:mod:`lsvib.engine.kernels.guard_blocks`) is shortened. With
infinite time the walk ends when every block that moves has σ_c < 0 and, for each guard, Σ_c |g_c| |z_c| over these
blocks is less than the rest of the guard.
"""

import math

import numpy as np

from lsvib.engine.kernels import guard_blocks
from lsvib.engine.kernels.affine import apply, level
from lsvib.engine.kernels.flow_blocks import carry, change
from lsvib.engine.kernels.flow_planar import EPS
from lsvib.engine.kernels.guard_blocks import LONGEST, NOISE, ORDERS, POSITIVE, ROOT, TOUCHES, UNDECIDED
from lsvib.engine.kernels.jit import allocating_kernel, kernel
from lsvib.engine.kernels.newton import GUESSES, next_guess
from lsvib.engine.kernels.search_modal import HALVINGS as _HALVINGS
from lsvib.engine.kernels.search_modal import REPEATS, SHAKEN, SHARP, first_below
from lsvib.engine.kernels.status import Found

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_GRAZE = int(Found.GRAZE)
_LOST = int(Found.UNDECIDED)
_STEPS = 1_000_000  # budget of a search, which is then undecided: a kernel must come to an end
_GROWTH = 8.0  # largest exponent σ h on one step: bounds are too large by e⁸ at most
_LARGEST = 1e200  # beyond it a coordinate is about to overflow, and the search is undecided instead


@allocating_kernel
def search(flow, mode, state, guards, on_surface, limit, steps):
    """Find the first of several guards that falls through zero, or touches it from above, within ``limit`` [s].

    Arguments: flow tables, mode, state (n), guards (g, n + 1), each positive at the start or – where ``on_surface`` (g)
    – zero and not falling; that array is overwritten; ``steps`` (1), how many the search may still take, counted down:
    without any left it is undecided. Returns (``Found``, index of the guard, time [s]).
    The loop is one long function because all of its parts would share its twelve scratch arrays.
    """
    matrix = flow.matrix[mode]
    size, count = matrix.shape[0], guards.shape[0]
    start, there = np.empty(size), np.empty(size)
    work, noise, moving = np.empty((2, size, size)), np.empty(size), np.empty((2, size))
    weights, constants = np.empty((count, ORDERS, size)), np.empty(count)
    sizes, moved = np.empty((count, ORDERS, size)), np.empty((ORDERS, size))
    values, ahead, rounding, starts = np.empty((count, 3)), np.empty((count, 3)), np.empty(count), np.empty(count)
    apply(flow.to_blocks[mode], state, start)
    guard_blocks.forms(flow, mode, guards, weights, constants, sizes)
    guard_blocks.values(weights, constants, start, values)
    for guard in range(count):
        starts[guard] = 0.0 if on_surface[guard] else level(guards[guard], state, state)[0]
        if on_surface[guard]:
            values[guard, 0], values[guard, 1] = 0.0, max(values[guard, 1], 0.0)
    fastest, rising = guard_blocks.fastest(matrix), 0.0
    for place in range(size):
        rising = max(rising, flow.growth[mode, place])
    longest = _GROWTH / rising if rising > 0.0 else math.inf
    a, step = 0.0, min(limit, longest, 1.0 / fastest if fastest > 0.0 else 1.0)
    guard_blocks.derivative_sizes(flow, mode, start, a, moved, noise, moving)
    for i in range(size):
        there[i] = start[i]
    for _ in range(_STEPS):
        steps[0] -= 1.0
        if steps[0] < 0.0:
            return _LOST, -1, limit
        if a >= limit or (
            limit == math.inf and guard_blocks.never(flow, mode, there, weights, constants, sizes, moved)
        ):
            return _NONE, -1, limit
        b = limit if a + step >= limit else a + step
        for guard in range(count):
            rounding[guard] = guard_blocks.rounding(weights[guard, 0], constants[guard], there)
        carry(flow, mode, start, b, there, work)
        for i in range(size):
            if not abs(there[i]) < _LARGEST:
                return _LOST, -1, limit
        guard_blocks.values(weights, constants, there, ahead)
        for guard in range(count):
            rounding[guard] = max(rounding[guard], guard_blocks.rounding(weights[guard, 0], constants[guard], there))
        outcome, stretch, touched = POSITIVE, LONGEST, -1
        for guard in range(count):
            decision, slack = guard_blocks.decide(
                values[guard], ahead[guard], sizes[guard], moved, flow.growth[mode], b - a, rounding[guard],
                on_surface[guard],
            )  # fmt: skip
            stretch = min(stretch, slack)
            if decision == TOUCHES:
                touched = guard
            outcome = max(outcome, decision)
            if decision == UNDECIDED:
                break
        if outcome == UNDECIDED:
            # The bounds grow with the square of the step at least: 0.7 of what they would allow leaves room for that.
            step = (b - a) * max(0.1, min(0.5, 0.7 * math.sqrt(stretch)))
            if a + step == a:
                return first_below(ahead, b)
            continue
        if outcome == TOUCHES:
            t = _touching(
                flow, mode, start, weights, constants, touched, starts[touched], b, ahead[touched, 1],
                ahead[touched, 2], ahead, there, noise, work,
            )  # fmt: skip
            for guard in range(count):  # one that falls before that is looked for from here
                t = -1.0 if t > b and guard != touched and ahead[guard, 0] <= 0.0 else t
            if t > limit:
                return _NONE, -1, limit
            return _GRAZE, touched, t if t >= 0.0 else 0.5 * (a + b)
        if outcome == ROOT:
            bottom, t = math.inf, math.inf
            while t >= 0.0:
                first, when, slope, bend = _earliest(
                    flow, mode, start, weights, constants, ahead, a, b, there, work, on_surface, rounding
                )
                t = -1.0
                if first >= 0 and slope * slope < 2.0 * SHAKEN * bend * rounding[first]:
                    t = _touching(
                        flow, mode, start, weights, constants, first, starts[first], when, slope, bend, ahead,
                        there, noise, work,
                    )  # fmt: skip
                if t >= 0.0:
                    constants[first] = math.inf  # no root; another guard may have one before it touches
                    if t < bottom:
                        touched, bottom = first, t
                    carry(flow, mode, start, b, there, work)
                    guard_blocks.values(weights, constants, there, ahead)
            if bottom < when or first < 0:
                return (_GRAZE, touched, bottom) if bottom <= limit else (_NONE, -1, limit)
            if rounding[first] > SHARP * abs(slope) * when:
                when = _sharpened(
                    flow, mode, start, weights[first, 0], starts[first], rounding[first], slope, when, limit,
                    there, noise, work,
                )  # fmt: skip
            return _CROSSING, first, when
        for guard in range(count):
            on_surface[guard] = on_surface[guard] and ahead[guard, 0] <= rounding[guard]
        a, step = b, min(longest, (b - a) * max(1.0, 0.7 * math.sqrt(stretch)))
        values, ahead = ahead, values
        guard_blocks.derivative_sizes(flow, mode, there, a, moved, noise, moving)
    return _LOST, -1, limit


@kernel
def _earliest(flow, mode, start, weights, constants, ahead, a, b, z, work, on_surface, rounding):
    """Find the earliest root on a decided step [a, b] s.

    A guard that is still positive at the earliest root found so far has no root before it. Returns (index of the guard
    or −1, time [s], its first two derivatives there); ``ahead`` is overwritten.
    """
    first, when, slope, bend = -1, b, 0.0, 0.0
    for guard in range(constants.size):
        if first >= 0 and ahead[guard, 0] <= 0.0:
            carry(flow, mode, start, when, z, work)
            guard_blocks.values(weights, constants, z, ahead)
        if ahead[guard, 0] <= 0.0:
            low = a
            if on_surface[guard]:  # The guard rises first, so a value within rounding may belong to its way up.
                if first >= 0 and ahead[guard, 0] > -rounding[guard]:
                    continue
                low = _top(flow, mode, start, weights, constants, guard, a, when, ahead, z, work)
            first, when = guard, _root(flow, mode, start, weights, constants, guard, low, when, ahead, z, work)
            slope, bend = ahead[guard, 1], ahead[guard, 2]
    return first, when, slope, bend


@kernel
def _changed(flow, mode, start, weights, value_at_zero, t, moves, sizes, work):
    """Return a guard with weights (q) at time t [s] as :func:`lsvib.engine.kernels.search_modal._changed` does.

    ``moves``, ``sizes`` (q) and ``work`` are scratch space.
    """
    change(flow, mode, start, t, moves, sizes, work)
    value, total = value_at_zero, abs(value_at_zero)
    for j in range(start.size):
        value += weights[j] * moves[j]
        total += abs(weights[j]) * sizes[j]
    return value, 8.0 * EPS * total


@kernel
def _sharpened(flow, mode, start, weights, value_at_zero, rounding, slope, t, limit, moves, sizes, work):
    """Return a root of a guard with weights (q) as :func:`lsvib.engine.kernels.search_modal._sharpened` does.

    ``rounding``: of the guard as the sum of its parts; ``moves``, ``sizes`` (q) and ``work`` are scratch space.
    """
    for _ in range(REPEATS):
        value, noise = _changed(flow, mode, start, weights, value_at_zero, t, moves, sizes, work)
        step = -value / slope if slope != 0.0 else 0.0
        if not (noise < rounding and abs(value) <= SHAKEN * rounding and 0.0 < t + step <= limit):
            break
        t += step
    return t


@kernel
def _touching(flow, mode, start, weights, constants, index, value_at_zero, t, slope, bend, out, moves, sizes, work):
    """Return the time of a minimum as :func:`lsvib.engine.kernels.search_modal._touching` does, or −1.

    ``weights`` (g, k, q); ``out`` (g, 3), ``moves``, ``sizes`` (q) and ``work`` are scratch space. An exponential of a
    block loses more than a sum: its coordinates are known to ``_NOISE`` last places, a sum to eight.
    """
    for _ in range(REPEATS):
        t -= slope / bend
        if not (t > 0.0 and bend > 0.0):
            return -1.0
        carry(flow, mode, start, t, moves, work)
        guard_blocks.values(weights, constants, moves, out)
        slope, bend = out[index, 1], out[index, 2]
    lowest, rounding = out[index, 0], guard_blocks.rounding(weights[index, 0], constants[index], moves)
    off, first = constants[index] - value_at_zero, guard_blocks.rounding(weights[index, 0], constants[index], start)
    for j in range(start.size):
        off += weights[index, 0, j] * start[j]
    value, noise = _changed(flow, mode, start, weights[index, 0], value_at_zero, t, moves, sizes, work)
    positive = 8.0 * value >= -NOISE * noise and 8.0 * lowest >= -NOISE * rounding * (1.0 + abs(off) / first)
    return t if positive else -1.0


@kernel
def _top(flow, mode, start, weights, constants, guard, low, high, out, z, work):
    """Return the time at which a concave guard that rises from zero has its maximum, at most ``high``."""
    t = high
    for _ in range(_HALVINGS):
        carry(flow, mode, start, t, z, work)
        guard_blocks.values(weights, constants, z, out)
        if out[guard, 1] < 0.0:
            high = t
        elif t == high:
            return high
        else:
            low = t
        t = 0.5 * (low + high)
        if not low < t < high:
            break
    return low


@kernel
def _root(flow, mode, start, weights, constants, guard, low, high, out, z, work):
    """Return the root of a guard that is positive at ``low`` and not positive at ``high``."""
    rate, t = guard_blocks.fastest(flow.matrix[mode]), 0.5 * (low + high)
    for count in range(GUESSES):
        carry(flow, mode, start, t, z, work)
        guard_blocks.values(weights, constants, z, out)
        value, slope, curvature = out[guard, 0], out[guard, 1], out[guard, 2]
        if value > 0.0:
            low = t
        elif value == 0.0:
            return t
        else:
            high = t
        t, found = next_guess(t, value, slope, curvature, low, high, rate, count)
        if found:
            return t
    return t
