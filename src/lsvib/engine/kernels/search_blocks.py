r"""The certain search for the first guard that fires in a mode whose flow is carried in blocks.

In the norm of each block, |z_c(a + τ)| ≤ e^{σ_c τ} |z_c(a)| (:mod:`lsvib.engine.kernels.flow_blocks`). With the norm of
rows that belongs to it, a guard g = g₀ + Σ_c g_c z_c obeys, for any h and any j ≤ k,

    |g^{(k)}| ≤ M_k = Σ_c max(1, e^{σ_c h}) min_j |g_c B_c^{k−j}| |B_c^j z_c(a)|      on [a, a + h].

With |f − chord of f| ≤ max|f″| h²/8 for any f, a guard that is not negative at a is decided on [a, b] if

    min(g_a, g_b)   > M₂ h²/8      g stays positive: no root;
    min(g′_a, g′_b) > M₃ h²/8      g rises: no root;
    max(g′_a, g′_b) < −M₃ h²/8     g falls: one root if g_b ≤ 0, else none;
    min(g″_a, g″_b) > M₄ h²/8      g is convex: no root if it also starts without falling.

A step on which a guard is undecided is shortened. With infinite time the walk ends when every block that moves has
σ_c < 0 and, for each guard, Σ_c |g_c| |z_c| over these blocks is less than the rest of the guard.
"""

import math

import numpy as np

from lsvib.engine.kernels.affine import apply, level
from lsvib.engine.kernels.flow_blocks import carry, change
from lsvib.engine.kernels.flow_planar import EPS
from lsvib.engine.kernels.jit import allocating_kernel, kernel
from lsvib.engine.kernels.newton import GUESSES, next_guess
from lsvib.engine.kernels.search_modal import HALVINGS as _HALVINGS
from lsvib.engine.kernels.search_modal import REPEATS, SHAKEN, SHARP, first_below
from lsvib.engine.kernels.status import Found

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_GRAZE = int(Found.GRAZE)
_LOST = int(Found.UNDECIDED)
_POSITIVE, _TOUCHES, _ROOT, _UNDECIDED = range(4)
_ORDERS = 5  # derivatives 0 to 4
_NOISE = 64.0  # relative rounding of a block's coordinates, in units of EPS; more by the angle that they have turned
_STEPS = 1_000_000  # budget of a search, which is then undecided: a kernel must come to an end
_LONGEST = 64.0  # largest factor by which a test counts as passed: the next step is at most 0.7 √64 = 5.6 times as long
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
    weights, constants = np.empty((count, _ORDERS, size)), np.empty(count)
    sizes, moved = np.empty((count, _ORDERS, size)), np.empty((_ORDERS, size))
    values, ahead, rounding, starts = np.empty((count, 3)), np.empty((count, 3)), np.empty(count), np.empty(count)
    apply(flow.to_blocks[mode], state, start)
    _forms(flow, mode, guards, weights, constants, sizes)
    _values(weights, constants, start, values)
    for guard in range(count):
        starts[guard] = 0.0 if on_surface[guard] else level(guards[guard], state, state)[0]
        if on_surface[guard]:
            values[guard, 0], values[guard, 1] = 0.0, max(values[guard, 1], 0.0)
    fastest, rising = _fastest(matrix), 0.0
    for place in range(size):
        rising = max(rising, flow.growth[mode, place])
    longest = _GROWTH / rising if rising > 0.0 else math.inf
    a, step = 0.0, min(limit, longest, 1.0 / fastest if fastest > 0.0 else 1.0)
    _derivative_sizes(flow, mode, start, a, moved, noise, moving)
    for i in range(size):
        there[i] = start[i]
    for _ in range(_STEPS):
        steps[0] -= 1.0
        if steps[0] < 0.0:
            return _LOST, -1, limit
        if a >= limit or (limit == math.inf and _never(flow, mode, there, weights, constants, sizes, moved)):
            return _NONE, -1, limit
        b = limit if a + step >= limit else a + step
        for guard in range(count):
            rounding[guard] = _rounding(weights[guard, 0], constants[guard], there)
        carry(flow, mode, start, b, there, work)
        for i in range(size):
            if not abs(there[i]) < _LARGEST:
                return _LOST, -1, limit
        _values(weights, constants, there, ahead)
        for guard in range(count):
            rounding[guard] = max(rounding[guard], _rounding(weights[guard, 0], constants[guard], there))
        outcome, stretch, touched = _POSITIVE, _LONGEST, -1
        for guard in range(count):
            decision, slack = _decide(
                values[guard], ahead[guard], sizes[guard], moved, flow.growth[mode], b - a, rounding[guard],
                on_surface[guard],
            )  # fmt: skip
            stretch = min(stretch, slack)
            if decision == _TOUCHES:
                touched = guard
            outcome = max(outcome, decision)
            if decision == _UNDECIDED:
                break
        if outcome == _UNDECIDED:
            # The bounds grow with the square of the step at least: 0.7 of what they would allow leaves room for that.
            step = (b - a) * max(0.1, min(0.5, 0.7 * math.sqrt(stretch)))
            if a + step == a:
                return first_below(ahead, b)
            continue
        if outcome == _TOUCHES:
            t = _touching(
                flow, mode, start, weights, constants, touched, starts[touched], b, ahead[touched, 1],
                ahead[touched, 2], ahead, there, noise, work,
            )  # fmt: skip
            for guard in range(count):  # one that falls before that is looked for from here
                t = -1.0 if t > b and guard != touched and ahead[guard, 0] <= 0.0 else t
            if t > limit:
                return _NONE, -1, limit
            return _GRAZE, touched, t if t >= 0.0 else 0.5 * (a + b)
        if outcome == _ROOT:
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
                    _values(weights, constants, there, ahead)
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
        _derivative_sizes(flow, mode, there, a, moved, noise, moving)
    return _LOST, -1, limit


@kernel
def _forms(flow, mode, guards, weights, constants, sizes):
    """Write g_c B_c^k to ``weights`` (g, k, q), g₀ to ``constants`` (g), and the norms of the former to ``sizes``.

    The norm of a block's part stands at the block's first place; the other places are zero.
    """
    table, edges = flow.from_blocks[mode], flow.edges[mode]
    n, size = guards.shape[1] - 1, table.shape[1] - 1
    for guard in range(guards.shape[0]):
        constants[guard] = guards[guard, n]
        for i in range(n):
            constants[guard] += guards[guard, i] * table[i, size]
        for j in range(size):
            weights[guard, 0, j] = 0.0
            for i in range(n):
                weights[guard, 0, j] += guards[guard, i] * table[i, j]
        for k in range(1, _ORDERS):
            for j in range(size):
                weights[guard, k, j] = 0.0
                for i in range(size):
                    weights[guard, k, j] += weights[guard, k - 1, i] * flow.matrix[mode, i, j]
        for k in range(_ORDERS):
            _row_norms(weights[guard, k], flow.inverse_norm[mode], edges, sizes[guard, k])


@kernel
def _row_norms(vector, inverse, edges, out):
    """Write the norm of each block's part of a row, |g_c R_c⁻¹|, to its first place, zero elsewhere."""
    for i in range(out.size):
        out[i] = 0.0
    for block in range(edges.size - 1):
        first, last, total = edges[block], edges[block + 1], 0.0
        for j in range(first, last):
            part = 0.0
            for i in range(first, j + 1):
                part += vector[i] * inverse[i, j]
            total += part * part
        if total > 0.0:
            out[first] = math.sqrt(total)


@kernel
def _norms(vector, factor, edges, out):
    """Write the norm of each block's part of a vector, |R_c z_c|, to its first place, zero elsewhere."""
    for i in range(out.size):
        out[i] = 0.0
    for block in range(edges.size - 1):
        first, last, total = edges[block], edges[block + 1], 0.0
        for i in range(first, last):
            part = 0.0
            for j in range(i, last):
                part += factor[i, j] * vector[j]
            total += part * part
        if total > 0.0:
            out[first] = math.sqrt(total)


@kernel
def _derivative_sizes(flow, mode, z, t, out, noise, moving):
    """Write bounds of |B_c^k z_c| (k, q) at time ``t``, the rounding of z included, to each block's first place.

    ``noise`` (q) and ``moving`` (2, q) are scratch space.
    """
    matrix, edges, factor, rates = flow.matrix[mode], flow.edges[mode], flow.norm[mode], flow.rate[mode]
    now, following = moving[0], moving[1]
    for i in range(z.size):
        now[i] = z[i]
    _norms(z, factor, edges, noise)
    for k in range(_ORDERS):
        _norms(now, factor, edges, out[k])
        for i in range(z.size):
            total = 0.0
            for j in range(z.size):
                total += matrix[i, j] * now[j]
            following[i] = total
        now, following = following, now
        for block in range(edges.size - 1):
            first, last = edges[block], edges[block + 1]
            if first < last:
                out[k, first] += EPS * (_NOISE + rates[first] * t) * noise[first]
                noise[first] *= rates[first]


@kernel
def _bound(sizes, moved, growth, k, step):
    """Return M_k of a guard on a step [s], see the module docstring."""
    total = 0.0
    for place in range(growth.size):
        least = sizes[k, place] * moved[0, place]
        for j in range(1, k + 1):
            least = min(least, sizes[k - j, place] * moved[j, place])
        if least > 0.0:
            total += least * math.exp(max(0.0, growth[place] * step))
    return total


@kernel
def _decide(here, there, sizes, moved, growth, step, rounding, starts_on_surface):
    """Decide what a guard does on one step, by the tests of the module docstring.

    ``here`` and ``there`` (3) are the guard and two derivatives at the ends of the step [s]. Returns the decision and
    the factor by which the test passes that decides; at most 1 if none does.
    """
    eighth = 0.125 * step * step
    second = _bound(sizes, moved, growth, 2, step) * eighth
    least = min(here[0], there[0])
    if least > second:
        return _POSITIVE, least / second if second > 0.0 else _LONGEST
    third = _bound(sizes, moved, growth, 3, step) * eighth
    slowest = min(here[1], there[1])
    if slowest > third:
        return _POSITIVE, slowest / third if third > 0.0 else _LONGEST
    fall = -max(here[1], there[1])
    if fall > third:
        return _ROOT if there[0] <= 0.0 else _POSITIVE, fall / third if third > 0.0 else _LONGEST
    slack = max(least / second, slowest / third, fall / third, 0.0)
    if here[1] >= 0.0:
        fourth = _bound(sizes, moved, growth, 4, step) * eighth
        curve = min(here[2], there[2])
        if curve > fourth:
            return _POSITIVE, curve / fourth if fourth > 0.0 else _LONGEST
        slack = max(slack, curve / fourth)
    if second < rounding:
        # On so short a step the guard is its chord to rounding: it rests on zero, or it touches it.
        if least > rounding:
            return _POSITIVE, _LONGEST
        if there[0] <= -rounding:
            return _ROOT, _LONGEST
        falls = there[0] >= 0.0 and there[1] <= 0.0  # and may die away without ever touching zero
        return _POSITIVE if starts_on_surface or falls else _TOUCHES, _LONGEST
    return _UNDECIDED, slack


@kernel
def _values(weights, constants, z, out):
    """Write each guard and its first two derivatives to its row of ``out`` (g, 3)."""
    for guard in range(constants.size):
        for k in range(3):
            total = constants[guard] if k == 0 else 0.0
            for i in range(z.size):
                total += weights[guard, k, i] * z[i]
            out[guard, k] = total


@kernel
def _rounding(weights, constant, z):
    """Return the size of the rounding of a guard with these weights (q)."""
    total = abs(constant)
    for i in range(z.size):
        total += abs(weights[i] * z[i])
    return 8.0 * EPS * total


@kernel
def _fastest(matrix):
    """Return a bound of the rates [1/s] of a mode: the largest row sum of its matrix."""
    fastest = 0.0
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += abs(matrix[i, j])
        fastest = max(fastest, total)
    return fastest


@kernel
def _never(flow, mode, z, weights, constants, sizes, moved):
    """Return whether all blocks that move die away, and the guards stay positive until they have."""
    edges, growth = flow.edges[mode], flow.growth[mode]
    for guard in range(constants.size):
        level = constants[guard]
        for block in range(edges.size - 1):
            first, last = edges[block], edges[block + 1]
            if first == last:
                continue
            if last == first + 1 and flow.matrix[mode, first, first] == 0.0:
                level += weights[guard, 0, first] * z[first]
            elif growth[first] < 0.0:
                level -= sizes[guard, 0, first] * moved[0, first]
            else:
                return False
        if not level > 0.0:
            return False
    return True


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
            _values(weights, constants, z, ahead)
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
        _values(weights, constants, moves, out)
        slope, bend = out[index, 1], out[index, 2]
    lowest, rounding = out[index, 0], _rounding(weights[index, 0], constants[index], moves)
    off, first = constants[index] - value_at_zero, _rounding(weights[index, 0], constants[index], start)
    for j in range(start.size):
        off += weights[index, 0, j] * start[j]
    value, noise = _changed(flow, mode, start, weights[index, 0], value_at_zero, t, moves, sizes, work)
    positive = 8.0 * value >= -_NOISE * noise and 8.0 * lowest >= -_NOISE * rounding * (1.0 + abs(off) / first)
    return t if positive else -1.0


@kernel
def _top(flow, mode, start, weights, constants, guard, low, high, out, z, work):
    """Return the time at which a concave guard that rises from zero has its maximum, at most ``high``."""
    t = high
    for _ in range(_HALVINGS):
        carry(flow, mode, start, t, z, work)
        _values(weights, constants, z, out)
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
    rate, t = _fastest(flow.matrix[mode]), 0.5 * (low + high)
    for count in range(GUESSES):
        carry(flow, mode, start, t, z, work)
        _values(weights, constants, z, out)
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
