"""The certain search for the first guard that fires in a mode with many states.

The search walks from time zero in steps [a, b] on which every guard is *decided*: proved to have no root, or one. If a
guard is undecided, the step is shortened, so no root is passed over. On a step each of g, g′, g″ is enclosed
(:func:`lsvib.systems.kernels.guard_sums.least_between`). Then, with g ≥ 0 at its start a,

    g > 0 on [a, b]     no root;
    g′ > 0              no root;
    g′ < 0              g falls: one root if g_b ≤ 0, else none;
    g″ > 0, g′_a ≥ 0    no root;
    g″ < 0              g is above its chord: one root if g_b ≤ 0, else none.

If the step has become so short that the guard changes by less than its rounding on it, the guard grazes. With infinite
time the walk ends when, for every guard, the bounds of all parts together are below the guard's constant, or, where it
has none, below its slowest part.

``work`` is the :class:`lsvib.systems.kernels.guard_sums.Sums` of the search. A *node* is one of three places in it for
what is known at a time.
"""

import math

import numpy as np

from lsvib.systems.kernels import guard_sums
from lsvib.systems.kernels.flow_modal import advance, is_still, slopes_at, stays
from lsvib.systems.kernels.flow_planar import level, own_rate
from lsvib.systems.kernels.guard_sums import evaluate, go_to, lowest_from, outlasts, prepare, room_for, rounding_at
from lsvib.systems.kernels.jit import allocating_kernel, inlined_kernel, kernel
from lsvib.systems.kernels.layout import ALPHA, BETA, CROSSING, GRAZE, LOST, NONE, R1, R2, Decision
from lsvib.systems.kernels.search_planar import GUESSES, next_guess

_POSITIVE = int(Decision.POSITIVE)
_TOUCHES = int(Decision.TOUCHES)
_ROOT = int(Decision.ROOT)
_UNDECIDED = int(Decision.UNDECIDED)
_SPARE = 2  # the node that is free while a root is looked for; nodes 0 and 1 are the ends of the step


@inlined_kernel
def fastest(flow, mode):
    """Return the largest rate [1/s] of a mode, and the largest at which a term grows, zero if none does."""
    most = growing = 0.0
    for pair in range(flow.pairs[mode]):
        row = flow.oscillators[mode, pair]
        most = max(most, abs(row[R1]), abs(row[R2]), abs(row[ALPHA]) + row[BETA])
        growing = max(growing, own_rate(row))
    for single in range(flow.singles[mode]):
        rate = flow.rates[mode, single]
        most, growing = max(most, abs(rate)), max(growing, rate)
    return most, growing


@inlined_kernel
def first_step(flow, mode, work, count, rate):
    """Return a step [s] on which the guards would be decided if they were pairs only; if unknown, 1/``rate`` or 1."""
    shortest = math.inf
    for guard in range(count):
        best = 0.0
        for k in range(3):
            curve = 0.0
            for pair in range(flow.pairs[mode]):
                curve += guard_sums.bound(work.pair_bounds[guard, pair, k + 2], 1.0, 1.0, 0.0)
            best = max(best, 4.0 * abs(work.values[0, guard, k]) / curve if curve > 0.0 else math.inf)
        shortest = min(shortest, math.sqrt(best))
    if 0.0 < shortest < math.inf:
        return shortest
    return 1.0 / rate if rate > 0.0 else 1.0


@inlined_kernel
def _margin(end, bound):
    """Return the factor by which a test passes: the lesser value at the ends over its distance to the lower bound."""
    width = end - bound
    return end / width if width > 0.0 else math.inf


@inlined_kernel
def _common_sign(x, y):
    """Return the common sign of two numbers; zero if their signs differ or one of them is zero."""
    if min(x, y) > 0.0:
        return 1.0
    return -1.0 if max(x, y) < 0.0 else 0.0


@inlined_kernel
def _decide_by_chord(first, last, rounding, starts_on_surface):
    """Decide whether a guard with these values and derivatives at the ends of a step rests on zero, or touches it.

    ``rounding``: size of the guard below which it is rounding only; zero where nothing is left of the guard.
    """
    if min(first[0], last[0]) > rounding:
        return _POSITIVE
    if last[0] <= -rounding and not (starts_on_surface and last[0] == 0.0):
        return _ROOT
    # While it still falls it has not touched zero: it may die away without ever coming there.
    falls = last[0] >= 0.0 and last[1] <= 0.0
    return _POSITIVE if starts_on_surface or falls else _TOUCHES


@inlined_kernel
def decide(flow, mode, work, guard, here, there, step, starts_on_surface):
    """Decide what a guard does on one step, by the tests of the module docstring.

    ``here`` and ``there`` are the nodes at the ends of the step [s].
    Returns the decision and the factor by which the test passes that decides; at most 1 if none does.
    """
    eighth, slack = 0.125 * step * step, 0.0
    first, last = work.values[here, guard], work.values[there, guard]
    if min(first[0], last[0]) > 0.0:
        low, least = guard_sums.least_between(flow, mode, work, guard, here, there, 0, 1.0, eighth)
        slack = _margin(least, low)
        if low > 0.0:
            return _POSITIVE, slack
    after = _ROOT if last[0] <= 0.0 else _POSITIVE
    sign = _common_sign(first[1], last[1])
    if sign != 0.0:
        low, least = guard_sums.least_between(flow, mode, work, guard, here, there, 1, sign, eighth)
        slack = max(slack, _margin(least, low))
        if low > 0.0:
            return _POSITIVE if sign > 0.0 else after, _margin(least, low)
    sign = _common_sign(first[2], last[2])
    if sign < 0.0 or (sign > 0.0 and first[1] >= 0.0):
        low, least = guard_sums.least_between(flow, mode, work, guard, here, there, 2, sign, eighth)
        if low > 0.0:
            return _POSITIVE if sign > 0.0 else after, _margin(least, low)
    low, least = guard_sums.least_between(flow, mode, work, guard, here, there, 0, 1.0, eighth)
    if least - low <= work.rounding[guard]:
        # The rounding on the step is that of time zero, or less where large parts have died away.
        left = max(rounding_at(flow, mode, work, guard, here), rounding_at(flow, mode, work, guard, there))
        rounding = min(left, work.rounding[guard])
        if least - low <= rounding:
            return _decide_by_chord(first, last, rounding, starts_on_surface), 128.0  # the next step is 8 times as long
    return _UNDECIDED, slack


@inlined_kernel
def search(flow, mode, state, guards, on_surface, limit, work):
    """Find the first of several guards that falls through zero, or touches it from above, within ``limit`` [s].

    Arguments: flow tables, mode, state (n), guards (g, n + 1), each positive at the start or – where ``on_surface`` (g)
    – zero and not falling; that array is overwritten, and so is ``work``, whose steps are counted down: without any
    left the search is undecided. Returns (``Found``, index of the guard, time [s]).
    """
    count, touched = guards.shape[0], False
    for guard in range(count):
        touched = touched or on_surface[guard]
    if stays(flow, mode, state) or (touched and is_still(flow, mode, state)):
        return NONE, -1, limit
    prepare(flow, mode, state, guards, work)
    for guard in range(count):
        work.starts[guard] = 0.0 if on_surface[guard] else level(guards[guard], state, state)[0]
        if on_surface[guard]:
            work.values[0, guard, 0] = 0.0
            work.values[0, guard, 1] = max(work.values[0, guard, 1], 0.0)
    rate, growing = fastest(flow, mode)
    # Bounds of what grows are taken at the end of a step, so they are too large by e⁸ at most.
    longest = 8.0 / growing if growing > 0.0 else math.inf
    steps, a, step = 0, 0.0, min(limit, longest, first_step(flow, mode, work, count, rate))
    for _ in range(1_000_000):  # a kernel must come to an end
        work.steps[0] -= 1.0
        if work.steps[0] < 0.0:
            return LOST, -1, limit
        here, there = steps % 2, 1 - steps % 2
        if a >= limit or (limit == math.inf and _never(flow, mode, work, count, here, a)):
            return NONE, -1, limit
        b = limit if a + step >= limit else a + step
        go_to(flow, mode, work, b, there)
        # The bounds of the tests grow with the square of the step. So where a test passes by a factor f, the next step
        # is 0.7 √f times as long, and 0.7 leaves a margin; at most 70 times.
        outcome, stretch, touched = _POSITIVE, 1e4, -1
        for guard in range(count):
            evaluate(flow, mode, work, guard, there)
            decision, slack = decide(flow, mode, work, guard, here, there, b - a, on_surface[guard])
            stretch = min(stretch, slack)
            if decision == _TOUCHES:
                touched = guard
            outcome = max(outcome, decision)
            if decision == _UNDECIDED:
                break
        if outcome == _UNDECIDED:
            step = (b - a) * max(0.1, min(0.5, 0.7 * math.sqrt(stretch)))
            if a + step == a:
                return _first_below(work.values[there, :count], b)
            continue
        if outcome == _TOUCHES:
            at = work.values[there, touched]
            t = _touching(flow, mode, work, touched, b, at[1], at[2])
            for guard in range(count):  # one that falls before that is looked for from here
                if t > b and guard != touched:
                    evaluate(flow, mode, work, guard, _SPARE)
                    t = -1.0 if work.values[_SPARE, guard, 0] <= 0.0 else t
            if t > limit:
                return NONE, -1, limit
            return GRAZE, touched, t if t >= 0.0 else 0.5 * (a + b)
        if outcome == _ROOT and _fallen(work, there, on_surface):
            first, when = _earliest(flow, mode, work, there, a, b, on_surface, rate)
            if first < 0:
                return NONE, -1, limit
            return CROSSING, first, when
        for guard in range(count):
            on_surface[guard] = on_surface[guard] and work.values[there, guard, 0] <= work.rounding[guard]
        a, step = b, min(longest, (b - a) * max(1.0, 0.7 * math.sqrt(stretch)))
        steps += 1
    return LOST, -1, limit


@inlined_kernel
def _never(flow, mode, work, count, node, t):
    """True if every guard stays positive from t [s], a node, on."""
    never = True
    for guard in range(count):
        never = never and (
            lowest_from(flow, mode, work, guard, node, t) > 0.0 or outlasts(flow, mode, work, guard, node)
        )
    return never


@kernel
def _first_below(values, b):
    """Result where a step that ends at b [s] cannot be halved any more: the guard that is lowest, unless positive."""
    lowest = 0
    for guard in range(values.shape[0]):
        lowest = guard if values[guard, 0] < values[lowest, 0] else lowest
    return (CROSSING if values[lowest, 0] <= 0.0 else LOST), lowest, b


@kernel
def _fallen(work, there, on_surface):
    """Whether a guard is below zero; one that began on zero has not fallen while it is within its rounding."""
    fallen = False
    for guard in range(on_surface.size):
        limit = -work.rounding[guard] if on_surface[guard] else 0.0
        fallen = fallen or work.values[there, guard, 0] <= limit
    return fallen


@inlined_kernel
def _earliest(flow, mode, work, there, a, b, on_surface, rate):
    """Find the earliest root on a decided step [a, b] s.

    A guard that is still positive at the earliest root found so far has no root before it. Returns (index of the guard
    or −1, time [s]).
    """
    first, when = -1, b
    for guard in range(on_surface.size):
        node = there
        if first >= 0 and work.values[there, guard, 0] <= 0.0:
            node = _SPARE
            go_to(flow, mode, work, when, node)
            evaluate(flow, mode, work, guard, node)
        if work.values[node, guard, 0] <= 0.0:
            low = a
            if on_surface[guard]:  # The guard rises first, so a value within rounding may belong to its way up.
                if first >= 0 and work.values[node, guard, 0] > -work.rounding[guard]:
                    continue
                low = _top(flow, mode, work, guard, a, when)
                go_to(flow, mode, work, when, _SPARE)
                evaluate(flow, mode, work, guard, _SPARE)
                node = _SPARE
            first = guard
            when = _root(flow, mode, work, guard, node, low, when, rate)
    return first, when


@kernel
def _touching(flow, mode, work, index, t, slope, bend):
    """Return the time of the minimum of a guard next to t [s], or −1 if it is negative beyond rounding there.

    ``slope`` and ``bend`` are the derivatives at t. Without damping a guard that starts at zero with its first
    derivative touches zero after a turn, where rounding alone makes two roots of one. The sum is as wrong there as it
    was at time zero, as far as its parts are left.
    """
    go_to(flow, mode, work, 0.0, _SPARE)
    evaluate(flow, mode, work, index, _SPARE)
    off = abs(work.values[_SPARE, index, 0] - work.starts[index])
    for _ in range(3):  # Newton's steps, whose slope has lost digits as well
        t -= slope / bend
        if not (t > 0.0 and bend > 0.0):
            return -1.0
        go_to(flow, mode, work, t, _SPARE)
        evaluate(flow, mode, work, index, _SPARE)
        slope, bend = work.values[_SPARE, index, 1], work.values[_SPARE, index, 2]
    rounding = rounding_at(flow, mode, work, index, _SPARE) * (1.0 + off / work.rounding[index])
    return t if work.values[_SPARE, index, 0] >= -rounding else -1.0


@kernel
def _top(flow, mode, work, guard, low, high):
    """Return the time at which a concave guard that rises from zero has its maximum, at most ``high``."""
    t = high
    for _ in range(1100):  # seconds cannot be halved more often: the smallest double is 2⁻¹⁰⁷⁴
        go_to(flow, mode, work, t, _SPARE)
        evaluate(flow, mode, work, guard, _SPARE)
        if work.values[_SPARE, guard, 1] < 0.0:
            high = t
        elif t == high:
            return high
        else:
            low = t
        t = 0.5 * (low + high)
        if not low < t < high:
            break
    return low


@inlined_kernel
def _root(flow, mode, work, guard, node, low, high, rate):
    """Return the root of a guard that is positive before it, from ``low`` on, and not positive after it.

    The values of the guard at ``high`` are those of ``node``. Returns its time [s].
    """
    t = high
    for count in range(GUESSES):
        value, slope, curvature = work.values[node, guard, 0], work.values[node, guard, 1], work.values[node, guard, 2]
        t, found, low, high = next_guess(t, value, slope, curvature, low, high, rate, count)
        if found:
            return t
        node = _SPARE
        go_to(flow, mode, work, t, node)
        evaluate(flow, mode, work, guard, node)
    return t


@allocating_kernel
def extremes(flow, mode, state, functional, duration):
    """Smallest and largest value of an affine function of the state over [0, duration] in a mode.

    The rate of the function is affine in the state as well; its roots are isolated one after the other.
    Arguments: ``functional`` (n + 1), finite duration [s]. Returns (smallest, largest), infinite if the search for a
    root does not end, or there are a million.
    """
    n = state.size
    work, guards, on_surface = room_for(flow, 1), np.zeros((1, n + 1)), np.zeros(1, dtype=np.bool_)
    rate, here, moves = np.zeros(n + 1), np.empty(n), False
    for j in range(n + 1):
        for i in range(n):
            rate[j] += functional[i] * flow.field[mode, i, j]
        moves = moves or rate[j] != 0.0
    for i in range(n):  # element by element: whole arrays compile numba's texts of errors as well
        here[i] = state[i]
    low = high = level(functional, here, here)[0]
    if not moves:
        return low, high
    passed, sign = 0.0, 0.0
    for _ in range(1_000_000):
        value, size = level(rate, here, here)
        slope, _, _, _ = slopes_at(flow, mode, here, here, rate)
        on_surface[0] = sign != 0.0 or abs(value) <= size
        if sign == 0.0:
            sign = math.copysign(1.0, slope if on_surface[0] else value)
        for j in range(n + 1):
            guards[0, j] = sign * rate[j]
        found, _, stay = search(flow, mode, here, guards, on_surface, duration - passed, work)
        if found == LOST:
            return -math.inf, math.inf
        if found == NONE:
            break
        passed += stay
        advance(flow, mode, here, stay, here)
        value, _ = level(functional, here, here)
        low, high = min(low, value), max(high, value)
        if found == CROSSING:
            sign = -sign
    else:
        return -math.inf, math.inf
    advance(flow, mode, state, duration, here)
    value, _ = level(functional, here, here)
    return min(low, value), max(high, value)
