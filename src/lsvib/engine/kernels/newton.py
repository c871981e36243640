"""The step of Newton's method with which both searches polish a root."""

import math

from lsvib.engine.kernels.jit import inlined_kernel

_PATIENCE = 8  # steps before bisection takes turns
_LAST_STEP = 1e-6  # in units of the times g′/g″ and 1/rate
# At most so many steps for a root. Half of those after the first eight halve the bracket, so it shrinks by 10⁴³: to two
# neighbouring doubles, unless the root is 10²⁷ times nearer to zero than the bracket is wide.
GUESSES = 300


@inlined_kernel
def next_guess(t, value, slope, curvature, low, high, rate, count):
    """A step towards the root of a function that falls there, between ``low`` and ``high``, or their middle.

    Arguments: present guess t, value and two derivatives there, the bracket, fastest rate of the mode, number of steps
    so far. The step goes to the root of the constant plus exponential that has this value and these derivatives (a
    term that grows or decays fast is met at once), near the root to that of Halley's hyperbola, which is the same to
    third order. Its error is of the order of the cube of the step, in units of g′/g″ and 1/rate; a step below 10⁻⁶ of
    both is the last, so that rounding alone is left, and so is one that does not move t. Returns (new guess, whether it
    is the root).
    """
    bend = value * curvature / (slope * slope)
    if abs(bend) < 0.1:
        new = t - 2.0 * value / (slope * (2.0 - bend))
    else:
        new = t + math.log1p(-bend) * slope / curvature if bend < 1.0 else math.nan
    if new == t:
        return t, True
    if low < new < high and (count < _PATIENCE or count % 2 == 0):
        return new, abs(new - t) * max(rate, abs(curvature / slope)) < _LAST_STEP
    middle = 0.5 * (low + high)
    return middle, middle in (low, high)
