"""The certain search for the first guard that fires in a mode with many states.

The search walks from time zero in steps [a, b] on which every guard is *decided*: proved to have no root, or one
(:mod:`lsvib.engine.kernels.search_modal`). If a guard is undecided, the step is shortened, so no root is passed over. If
the step has become so short that the guard changes by less than its rounding on it, the guard grazes. With infinite
time the walk ends when, for every guard, the bounds of all parts together are below the guard's constant.

``work`` is the :class:`lsvib.engine.kernels.guard_sums.Sums` of the search. A *node* is one of three places in it for
what is known at a time.
"""

import math

from lsvib.engine.kernels.flow_planar import level
from lsvib.engine.kernels.guard_sums import evaluate, go_to, lowest_from, prepare, rounding_at
from lsvib.engine.kernels.jit import inlined_kernel, kernel
from lsvib.engine.kernels.layout import Decision, Found
from lsvib.engine.kernels.search_modal import decide, fastest, fastest_growth, first_step
from lsvib.engine.kernels.search_planar import GUESSES, next_guess

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_GRAZE = int(Found.GRAZE)
_LOST = int(Found.UNDECIDED)
_POSITIVE = int(Decision.POSITIVE)
_TOUCHES = int(Decision.TOUCHES)
_ROOT = int(Decision.ROOT)
_UNDECIDED = int(Decision.UNDECIDED)
_STEPS = 1_000_000  # budget of a search, which is then undecided: a kernel must come to an end
# The bounds of the tests grow with the square of the step. So where a test passes by a factor f, the next step is
# 0.7 √f times as long, and 0.7 leaves a margin.
_LONGEST = 1e4  # largest f that is counted: a step grows at most 70-fold
_GROWTH = 8.0  # largest exponent of growth on one step: bounds, taken at its end, are too large by e⁸ at most
_SPARE = 2  # the node that is free while a root is looked for; nodes 0 and 1 are the ends of the step
_SHAKEN = 16.0  # of rounding: a guard that turns back before it is as far below zero may only touch it
_REPEATS = 3  # of Newton's step to where a guard touches zero, whose slope has lost digits as well
_HALVINGS = 1100  # an interval of seconds cannot be halved more often: the smallest double is 2⁻¹⁰⁷⁴


@inlined_kernel
def search(flow, mode, state, guards, on_surface, limit, work):
    """Find the first of several guards that falls through zero, or touches it from above, within ``limit`` [s].

    Arguments: flow tables, mode, state (n), guards (g, n + 1), each positive at the start or – where ``on_surface`` (g)
    – zero and not falling; that array is overwritten, and so is ``work``, whose steps are counted down: without any
    left the search is undecided. Returns (``Found``, index of the guard, time [s]). It is long because its ends,
    written as functions of their own, made it a twentieth slower.
    """
    count = guards.shape[0]
    prepare(flow, mode, state, guards, work)
    for guard in range(count):
        work.starts[guard] = 0.0 if on_surface[guard] else level(guards[guard], state, state)[0]
        if on_surface[guard]:
            work.values[0, guard, 0] = 0.0
            work.values[0, guard, 1] = max(work.values[0, guard, 1], 0.0)
    growing, rate, step = fastest_growth(flow, mode), fastest(flow, mode), first_step(flow, mode, work, count)
    longest = _GROWTH / growing if growing > 0.0 else math.inf
    if not 0.0 < step < math.inf:
        step = 1.0 / rate if rate > 0.0 else 1.0
    steps, a, step = 0, 0.0, min(limit, longest, step)
    for _ in range(_STEPS):
        work.steps[0] -= 1.0
        if work.steps[0] < 0.0:
            return _LOST, -1, limit
        here, there = steps % 2, 1 - steps % 2
        if a >= limit or (limit == math.inf and _never(flow, mode, work, count, here, a)):
            return _NONE, -1, limit
        b = limit if a + step >= limit else a + step
        go_to(flow, mode, work, b, there)
        outcome, stretch, touched = _POSITIVE, _LONGEST, -1
        for guard in range(count):
            evaluate(flow, mode, work, guard, there)
            decision, slack = decide(flow, mode, work, guard, here, there, b - a, rate, on_surface[guard])
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
                return _NONE, -1, limit
            return _GRAZE, touched, t if t >= 0.0 else 0.5 * (a + b)
        if outcome == _ROOT:
            bottom, t = math.inf, math.inf
            while t >= 0.0:
                first, when, slope, bend = _earliest(flow, mode, work, count, there, a, b, on_surface, rate)
                t = -1.0
                if first >= 0 and slope * slope < 2.0 * _SHAKEN * bend * work.rounding[first]:
                    t = _touching(flow, mode, work, first, when, slope, bend)
                if t >= 0.0:
                    work.values[there, first, 0] = math.inf  # no root; another guard may have one before it touches
                    if t < bottom:
                        touched, bottom = first, t
            if bottom < when or first < 0:
                return (_GRAZE, touched, bottom) if bottom <= limit else (_NONE, -1, limit)
            return _CROSSING, first, when
        for guard in range(count):
            on_surface[guard] = on_surface[guard] and work.values[there, guard, 0] <= work.rounding[guard]
        a, step = b, min(longest, (b - a) * max(1.0, 0.7 * math.sqrt(stretch)))
        steps += 1
    return _LOST, -1, limit


@inlined_kernel
def _never(flow, mode, work, count, node, t):
    """True if every guard stays positive from t [s], a node, on."""
    least = math.inf
    for guard in range(count):
        least = min(least, lowest_from(flow, mode, work, guard, node, t))
    return least > 0.0


@kernel
def _first_below(values, b):
    """Result of the search where a step that ends at b [s] cannot be halved any more: the guard that is lowest there.

    Returns (``Found``, index of the guard, b): undecided if every guard is positive.
    """
    lowest = 0
    for guard in range(values.shape[0]):
        if values[guard, 0] < values[lowest, 0]:
            lowest = guard
    return (_CROSSING if values[lowest, 0] <= 0.0 else _LOST), lowest, b


@inlined_kernel
def _earliest(flow, mode, work, count, there, a, b, on_surface, rate):
    """Find the earliest root on a decided step [a, b] s.

    A guard that is still positive at the earliest root found so far has no root before it. Returns (index of the guard
    or −1, time [s], its first two derivatives there).
    """
    first, when, slope, bend = -1, b, 0.0, 0.0
    for guard in range(count):
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
            when, slope, bend = _root(flow, mode, work, guard, node, low, when, rate)
    return first, when, slope, bend


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
    for _ in range(_REPEATS):
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
    for _ in range(_HALVINGS):
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

    The values of the guard at ``high`` are those of ``node``. Returns (time [s], first two derivatives there).
    """
    t, slope, curvature = high, 0.0, 0.0
    for count in range(GUESSES):
        value, slope, curvature = work.values[node, guard, 0], work.values[node, guard, 1], work.values[node, guard, 2]
        if value > 0.0:
            low = t
        elif value == 0.0:
            return t, slope, curvature
        else:  # negative, or overflown far beyond the root
            high = t
        t, found = next_guess(t, value, slope, curvature, low, high, rate, count)
        if found:
            return t, slope, curvature
        node = _SPARE
        go_to(flow, mode, work, t, node)
        evaluate(flow, mode, work, guard, node)
    return t, slope, curvature
