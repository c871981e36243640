"""What one step of the search proves of a guard in modal form, and how long steps may be.

On the step each of g, g′, g″ is enclosed (:func:`lsvib.engine.kernels.guard_sums.least_between`). Then, with g ≥ 0 at
its start a,

    g > 0 on [a, b]     no root;
    g′ > 0              no root;
    g′ < 0              g falls: one root if g_b ≤ 0, else none;
    g″ > 0, g′_a ≥ 0    no root;
    g″ < 0              g is above its chord: one root if g_b ≤ 0, else none.

Where none of these holds on a step that is long for the fastest part, g > 0 and g′ ≠ 0 are tried again with each part
enclosed on its own (:func:`lsvib.engine.kernels.guard_sums.least_by_swings`): a part that vibrates many times on the
step stays within its amplitude.
"""

import math

from lsvib.engine.kernels import guard_sums
from lsvib.engine.kernels.flow_planar import own_rate
from lsvib.engine.kernels.jit import inlined_kernel
from lsvib.engine.kernels.layout import ALPHA, BETA, R1, R2, Decision

_POSITIVE = int(Decision.POSITIVE)
_TOUCHES = int(Decision.TOUCHES)
_ROOT = int(Decision.ROOT)
_UNDECIDED = int(Decision.UNDECIDED)
_BEYOND_ROUNDING = 128.0  # factor where the guard changes by less than its rounding: the next step is 8 times as long
_LITTLE = 4.0  # factor below which the enclosure part by part is tried as well: the step would grow by less than 1.4
# ωh of the fastest part from which on the enclosure part by part can be the better one: the bound by the chord is
# (ωh)²/8 amplitudes, and a swing between two extremes is two of them.
_FAR = 4.0


@inlined_kernel
def fastest(flow, mode):
    """Return the largest rate [1/s] of a mode."""
    most = 0.0
    for pair in range(flow.pairs[mode]):
        row = flow.oscillators[mode, pair]
        most = max(most, abs(row[R1]), abs(row[R2]), abs(row[ALPHA]) + row[BETA])
    for single in range(flow.singles[mode]):
        most = max(most, abs(flow.rates[mode, single]))
    return most


@inlined_kernel
def fastest_growth(flow, mode):
    """Return the largest rate [1/s] at which a term grows; at most zero if none does."""
    growing = 0.0
    for pair in range(flow.pairs[mode]):
        growing = max(growing, own_rate(flow.oscillators[mode, pair]))
    for single in range(flow.singles[mode]):
        growing = max(growing, flow.rates[mode, single])
    return growing


@inlined_kernel
def first_step(flow, mode, work, count):
    """Return a step [s] on which the guards would be decided if they were pairs only; zero or infinite if unknown."""
    shortest = math.inf
    for guard in range(count):
        best = 0.0
        for k in range(3):
            curve = 0.0
            for pair in range(flow.pairs[mode]):
                curve += guard_sums.bound(work.pair_bounds[guard, pair, k + 2], 1.0, 1.0, 0.0)
            best = max(best, 4.0 * abs(work.values[0, guard, k]) / curve if curve > 0.0 else math.inf)
        shortest = min(shortest, math.sqrt(best))
    return shortest


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
def _decide_apart(flow, mode, work, guard, here, there, eighth, after, slack):
    """Decide what a guard does on one step, with each part of it enclosed on its own; returns as :func:`decide`."""
    low, least = guard_sums.least_by_swings(flow, mode, work, guard, here, there, 0, 1.0, eighth)
    if low > 0.0:
        return _POSITIVE, _margin(least, low)
    slack = max(slack, _margin(least, low))
    sign = _common_sign(work.values[here, guard, 1], work.values[there, guard, 1])
    if sign != 0.0:
        low, least = guard_sums.least_by_swings(flow, mode, work, guard, here, there, 1, sign, eighth)
        if low > 0.0:
            return _POSITIVE if sign > 0.0 else after, _margin(least, low)
        slack = max(slack, _margin(least, low))
    return _UNDECIDED, slack


@inlined_kernel
def _left_of_rounding(flow, mode, work, guard, here, there):
    """Return the rounding of a guard on a step: that of time zero, or less where large parts have died away."""
    left = max(
        guard_sums.rounding_at(flow, mode, work, guard, here), guard_sums.rounding_at(flow, mode, work, guard, there)
    )
    return min(left, work.rounding[guard])


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
def decide(flow, mode, work, guard, here, there, step, rate, starts_on_surface):
    """Decide what a guard does on one step, by the tests of the module docstring.

    ``here`` and ``there`` are the nodes at the ends of the step [s]; ``rate`` is the largest rate [1/s] of the mode.
    Returns the decision and the factor by which the test passes that decides; at most 1 if none does.
    """
    eighth, slack, turns = 0.125 * step * step, 0.0, rate * step > _FAR
    first, last = work.values[here, guard], work.values[there, guard]
    if min(first[0], last[0]) > 0.0:
        low, least = guard_sums.least_between(flow, mode, work, guard, here, there, 0, 1.0, eighth)
        slack = _margin(least, low)
        if low > 0.0:
            if turns and slack < _LITTLE:
                _, slack = _decide_apart(flow, mode, work, guard, here, there, eighth, _ROOT, slack)
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
    if turns:
        decision, slack = _decide_apart(flow, mode, work, guard, here, there, eighth, after, slack)
        if decision != _UNDECIDED:
            return decision, slack
    low, least = guard_sums.least_between(flow, mode, work, guard, here, there, 0, 1.0, eighth)
    if least - low <= work.rounding[guard]:
        rounding = _left_of_rounding(flow, mode, work, guard, here, there)
        if least - low <= rounding:
            return _decide_by_chord(first, last, rounding, starts_on_surface), _BEYOND_ROUNDING
    return _UNDECIDED, slack
