"""What one step of the search proves of a guard in a mode whose flow is carried in blocks, and how long steps may be.

With |f − chord of f| ≤ max|f″| h²/8 for any f, and the bounds M_k of :mod:`lsvib.engine.kernels.guard_blocks`, a guard
that is not negative at a is decided on [a, b] if

    min(g_a, g_b)   > M₂ h²/8      g stays positive: no root;
    min(g′_a, g′_b) > M₃ h²/8      g rises: no root;
    max(g′_a, g′_b) < −M₃ h²/8     g falls: one root if g_b ≤ 0, else none;
    min(g″_a, g″_b) > M₄ h²/8      g is convex: no root if it also starts without falling.
"""

from lsvib.engine.kernels.chord import decide_by_chord
from lsvib.engine.kernels.guard_blocks import bound, rounding_at
from lsvib.engine.kernels.jit import inlined_kernel, kernel
from lsvib.engine.kernels.status import Decision

_POSITIVE = int(Decision.POSITIVE)
_ROOT = int(Decision.ROOT)
_UNDECIDED = int(Decision.UNDECIDED)
_LONGEST = 64.0  # largest factor by which a test counts as passed: the next step is at most 0.7 √64 = 5.6 times as long


@kernel
def fastest(flow, mode):
    """Return a bound of the rates [1/s] of a mode: the largest row sum of its matrix."""
    matrix, most = flow.matrix[mode], 0.0
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += abs(matrix[i, j])
        most = max(most, total)
    return most


@kernel
def fastest_growth(flow, mode):
    """Return the largest rate [1/s] at which the norm of a block grows; at most zero if none does."""
    growing = 0.0
    for place in range(flow.growth.shape[1]):
        growing = max(growing, flow.growth[mode, place])
    return growing


@inlined_kernel
def first_step(flow, mode, work, count):
    """Return zero: no step [s] to try first is known."""
    return 0.0


@inlined_kernel
def _factor(value, bound):
    """Return the factor by which a test passes, or would pass; a bound is zero where a guard has died away."""
    if bound > 0.0:
        return min(value / bound, _LONGEST)
    return _LONGEST if value > 0.0 else 0.0


@kernel
def decide(flow, mode, work, guard, here, there, step, rate, starts_on_surface):
    """Decide what a guard does on one step, as :func:`lsvib.engine.kernels.step_sums.decide` does.

    The rounding of the guard on the step is written to ``work.rounding``.
    """
    rounding = max(rounding_at(flow, mode, work, guard, here), rounding_at(flow, mode, work, guard, there))
    work.rounding[guard] = rounding
    first, last, eighth = work.values[here, guard], work.values[there, guard], 0.125 * step * step
    second = bound(flow, mode, work, guard, 2, step) * eighth
    least = min(first[0], last[0])
    if least > second:
        return _POSITIVE, _factor(least, second)
    third = bound(flow, mode, work, guard, 3, step) * eighth
    slowest = min(first[1], last[1])
    if slowest > third:
        return _POSITIVE, _factor(slowest, third)
    fall = -max(first[1], last[1])
    if fall > third:
        return _ROOT if last[0] <= 0.0 else _POSITIVE, _factor(fall, third)
    slack = max(_factor(least, second), _factor(slowest, third), _factor(fall, third), 0.0)
    if first[1] >= 0.0:
        fourth = bound(flow, mode, work, guard, 4, step) * eighth
        curve = min(first[2], last[2])
        if curve > fourth:
            return _POSITIVE, _factor(curve, fourth)
        slack = max(slack, _factor(curve, fourth))
    if second <= rounding:
        return decide_by_chord(first, last, rounding, starts_on_surface), _LONGEST
    return _UNDECIDED, slack
