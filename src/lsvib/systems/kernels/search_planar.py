"""The certain search for the first guard that fires in a mode with two states.

A guard g = g_u u + g_w w + g_0 along the flow of :mod:`lsvib.systems.kernels.flow_planar` has the derivative  g′(t) = p
S′ + q S  with constants p, q. Its zeros are known in closed form: one at most if the roots are real, and spaced by π/β
otherwise. Between them g is monotone, so it has one root there if its ends differ in sign and none otherwise; and since
the extrema of an oscillation that does not grow only get shallower, the first one decides for all time. This is what
makes the search certain.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.systems.kernels.flow_planar import EPS, far, integrated_response, responses
from lsvib.systems.kernels.jit import allocating_kernel, entry, inlined_entry, inlined_kernel, kernel
from lsvib.systems.kernels.layout import A0, A1, ALPHA, BETA, CROSSING, DELTA, EQUILIBRIUM, GRAZE, NONE, R1, R2, B

_HUGE = 1e250  # beyond it a value is on its way to overflow, and its sign means nothing
# At most so many steps for a root. Half of those after the first eight halve the bracket, so it shrinks by 10⁴³: to two
# neighbouring doubles, unless the root is 10²⁷ times nearer to zero than the bracket is wide.
GUESSES = 300
_NEAR, _FAR, _SPLIT = range(3)  # forms of a guard along the flow


@inlined_kernel
def next_guess(t, value, slope, curvature, low, high, rate, count):
    """A step towards the root of a function that falls there, between ``low`` and ``high``, or their middle.

    Arguments: present guess t, value and two derivatives there, the bracket, fastest rate of the mode, number of steps
    so far. The step goes to the root of the constant plus exponential that has this value and these derivatives (a
    term that grows or decays fast is met at once), near the root to that of Halley's hyperbola, which is the same to
    third order. Its error is of the order of the cube of the step, in units of g′/g″ and 1/rate; a step below 10⁻⁶ of
    both is the last, so that rounding alone is left, and so is one that does not move t. Returns (new guess, whether it
    is the root, and the bracket that the value leaves).
    """
    if 0.0 < value < _HUGE:
        low = t
    elif value == 0.0:
        return t, True, low, high
    else:  # negative, or overflown far beyond the root
        high = t
    bend = value * curvature / (slope * slope)
    if abs(bend) < 0.1:
        new = t - 2.0 * value / (slope * (2.0 - bend))
    else:
        new = t + math.log1p(-bend) * slope / curvature if bend < 1.0 else math.nan
    if new == t:
        return t, True, low, high
    if low < new < high and (count < 8 or count % 2 == 0):  # after some steps bisection takes turns
        return new, abs(new - t) * max(rate, abs(curvature / slope)) < 1e-6, low, high
    middle = 0.5 * (low + high)
    return middle, middle in (low, high), low, high


@inlined_kernel
def _shape(row, state, guard):
    """Constants of a guard along the flow: p, q, the form that holds, coefficients of 1, C or J, S, S′.

    A guard that comes with its parts – its values at the equilibrium and along both eigenvectors, formed without
    cancellation – is split where the real rates lie apart; then the last three are the coefficients of e^{r₁t}, e^{r₂t}
    and nothing. Without that a guard that is almost zero along the slow eigenvector would be lost in rounding.
    """
    u, w = state[0], state[1]
    is_far = far(row, u, w)
    y = 0.0 if is_far else u - row[EQUILIBRIUM]
    force = row[B] - row[A0] * u if is_far else -row[A0] * y
    p = guard[0] * w + guard[1] * (force - row[A1] * w)
    q = guard[0] * force - guard[1] * row[A0] * w
    if is_far:
        return p, q, _FAR, guard[0] * u + guard[2], guard[0] * force, guard[0] * w + guard[1] * force, guard[1] * w
    if guard.size > 3 and 2.0 * row[DELTA] > abs(row[ALPHA]):
        spread = 2.0 * row[DELTA]
        slow, fast = guard[4] * (w - row[R2] * y) / spread, guard[5] * (row[R1] * y - w) / spread
        return p, q, _SPLIT, guard[3], slow, fast, 0.0
    constant = guard[0] * row[EQUILIBRIUM] + guard[2]
    return p, q, _NEAR, constant, guard[0] * y, guard[0] * w + guard[1] * force, guard[1] * w


@inlined_kernel
def _value(row, shape, t):
    """Value and first two derivatives of a guard at time t."""
    p, q, form, constant, c_part, s_part, rate_part = shape
    if form == _SPLIT:
        slow, fast = c_part * math.exp(row[R1] * t), s_part * math.exp(row[R2] * t)
        slow_rate, fast_rate = row[R1] * slow, row[R2] * fast
        return constant + (slow + fast), slow_rate + fast_rate, row[R1] * slow_rate + row[R2] * fast_rate
    c, s, s_rate = responses(row, t)
    if form == _FAR:
        c = integrated_response(row, t)
    value = constant + (c_part * c + s_part * s + rate_part * s_rate)
    return value, p * s_rate + q * s, (q - row[A1] * p) * s_rate - row[A0] * p * s


@inlined_kernel
def _positive(row, shape, t):
    """Whether a guard that falls from a moderate value is still positive; a huge value has overflowed on its way."""
    return 0.0 < _value(row, shape, t)[0] < _HUGE


@inlined_kernel
def _descent(row, shape, low, high, guess):
    """Root of a guard that falls from ``low`` to ``high``, where it is not positive."""
    t = guess if low < guess < high else 0.5 * (low + high)
    rate = abs(row[ALPHA]) + row[BETA] + row[DELTA]
    for count in range(GUESSES):
        value, slope, curvature = _value(row, shape, t)
        t, found, low, high = next_guess(t, value, slope, curvature, low, high, rate, count)
        if found:
            return t
    return t


@inlined_kernel
def _up_to(row, shape, low, high, guess, limit):
    """As :func:`_descent`, but only a root before ``limit`` counts: returns (found, time)."""
    if low >= limit:
        return NONE, limit
    if limit < high:
        if _positive(row, shape, limit):
            return NONE, limit
        high = limit
    return CROSSING, _descent(row, shape, low, high, guess)


@inlined_entry
def crossing(flow, mode, state, guard, on_surface, limit):
    """Find the first time in (0, limit] at which a guard falls through zero or touches it from above.

    Arguments: flow table, mode, state (2), guard (g_u, g_w, g_0, and its parts if it has them), positive at the start
    or – with ``on_surface`` – zero at the start and rising; limit [s], may be infinite. Returns (``Found``, time [s]);
    certain in the sense of the module docstring.
    """
    row = flow[mode]
    shape = _shape(row, state, guard)
    bend = row[A0] * guard[3] if shape[2] == _SPLIT else row[A0] * guard[2] + guard[0] * row[B]
    if shape[0] == 0.0 and shape[1] == 0.0:
        return NONE, limit
    if row[BETA] > 0.0:
        return _oscillating_crossing(row, shape, bend, on_surface, limit)
    if row[A0] == 0.0 and row[A1] == 0.0:
        return _parabolic_crossing(shape, on_surface, limit)
    return _monotone_crossing(row, shape, bend, on_surface, limit)


class Work(NamedTuple):
    """What a search needs beside its arguments: that of two states has no steps and no sums."""

    steps: np.ndarray  # (1,) steps that searches may still take; infinite at first


@allocating_kernel
def room_for(flow, guards):
    """Return the ``Work`` for any number of guards, with steps without end."""
    return Work(np.full(1, math.inf))


@inlined_kernel
def search(flow, mode, state, guards, on_surface, limit, work):
    """Find the first of several guards (g) that fires within ``limit`` [s]; arguments as of :func:`crossing`.

    Returns (``Found``, index of the guard or −1, time [s]).
    """
    found, first, when = NONE, -1, limit
    for guard in range(guards.shape[0]):
        outcome, t = crossing(flow, mode, state, guards[guard], on_surface[guard], when)
        if outcome != NONE:
            found, first, when = outcome, guard, t
    return found, first, when


@inlined_kernel
def _hop(top, on_surface, limit):
    """Event of a guard whose maximum at ``top`` [s] is zero to rounding; from zero it rises and falls as a parabola."""
    t = 2.0 * top if on_surface else top
    return (CROSSING, t) if t <= limit else (NONE, limit)


@inlined_kernel
def _minimum(row, shape, middle, swing, t):
    """Value of a guard at its minimum at t [s], and the size below which that is rounding only."""
    reach = min(swing * math.exp(-row[ALPHA] * t), _HUGE)
    lowest = _value(row, shape, t)[0] if shape[2] == _FAR else middle - reach
    return lowest, 8.0 * EPS * (abs(shape[3]) + reach)


@inlined_kernel
def _oscillating_crossing(row, shape, bend, on_surface, limit):
    p, q, is_far, constant = shape[0], shape[1], shape[2] == _FAR, shape[3]
    alpha, beta = row[ALPHA], row[BETA]
    across = (q - alpha * p) / beta
    phase = math.atan2(across, p)
    # g′ is proportional to cos(βt − phase): a maximum follows where it falls through zero, a minimum half a turn later.
    top = phase + 0.5 * math.pi
    # A guard that rises and falls again as soon as this does not leave its rounding: the sum has lost its digits.
    if on_surface and abs(top) < 1e-8:
        top = math.atan2(p, -across)
    if top < 0.0:
        top += math.tau
    bottom = top + math.pi
    if not on_surface and bottom > math.tau:
        bottom -= math.tau
        top -= math.tau
    if top >= limit * beta or (limit * beta <= bottom and _value(row, shape, limit)[0] > 0.0):
        return NONE, limit
    swing = beta * math.sqrt(p * p + across * across) / row[A0]
    middle = bend / row[A0] if is_far else constant
    lowest, resolution = _minimum(row, shape, middle, swing, bottom / beta)
    if lowest > resolution and alpha < 0.0 and middle > swing:
        # A growing oscillation: go straight to the first minimum that is deep enough, or to the one before it.
        turns = math.floor((math.log(middle / swing) / -alpha * beta - bottom) / math.tau + 1e-9)
        top += turns * math.tau
        bottom += turns * math.tau
        lowest, resolution = _minimum(row, shape, middle, swing, bottom / beta)
        if lowest > resolution:
            top += math.tau
            bottom += math.tau
            lowest, resolution = _minimum(row, shape, middle, swing, bottom / beta)
    if lowest > resolution or top >= limit * beta:
        return NONE, limit
    t_bottom = bottom / beta
    if lowest >= -resolution:
        return (GRAZE, t_bottom) if t_bottom <= limit else (NONE, limit)
    rise = swing * math.exp(-alpha * top / beta)
    highest = middle + rise
    if top > 0.0 and highest <= 8.0 * EPS * (abs(constant) + rise):
        return _hop(top / beta, on_surface, limit)
    fraction = (highest + lowest) / (lowest - highest)
    guess = (top + math.acos(min(1.0, max(-1.0, fraction)))) / beta
    return _up_to(row, shape, max(top, 0.0) / beta, t_bottom, guess, limit)


@kernel
def _parabolic_crossing(shape, on_surface, limit):
    """Without stiffness and damping the guard is g(0) + p t + q t² / 2."""
    p, q = shape[0], shape[1]
    value = 0.0 if on_surface else shape[3] + shape[6]
    square = p * p - 2.0 * q * value
    if square < 0.0 or (q >= 0.0 and p >= 0.0) or (on_surface and q >= 0.0):
        return NONE, limit
    # The smaller positive root where the parabola falls; written so that nothing cancels.
    root = math.sqrt(square)
    t = -(p + root) / q if q != 0.0 and p > 0.0 else 2.0 * value / (root - p)
    if t > limit:
        return NONE, limit
    return (GRAZE, t) if q > 0.0 and square <= 8.0 * EPS * p * p else (CROSSING, t)


@inlined_kernel
def _turning_time(row, shape):
    """The one positive zero of g′ when the characteristic roots are real; infinite if there is none."""
    p, q = shape[0], shape[1]
    if shape[2] == _SPLIT:
        ratio = -(row[R2] * shape[5]) / (row[R1] * shape[4])
        return math.log(ratio) / (2.0 * row[DELTA]) if ratio > 1.0 else math.inf
    slow = q + row[R1] * p  # in proportion to the part of g′ that decays (or grows) with r₁
    excess = -p / slow
    if not excess > 0.0:
        return math.inf
    return math.log1p(2.0 * row[DELTA] * excess) / (2.0 * row[DELTA]) if row[DELTA] > 0.0 else excess


@inlined_kernel
def _monotone_crossing(row, shape, bend, on_surface, limit):
    p, q = shape[0], shape[1]
    if shape[2] == _SPLIT:
        p = row[R1] * shape[4] + row[R2] * shape[5]
        q = row[R1] * row[R1] * shape[4] + row[R2] * row[R2] * shape[5]  # of one sign with g″ where p = 0
    turn = _turning_time(row, shape)
    rises = on_surface or p > 0.0 or (p == 0.0 and q > 0.0)
    if rises:
        if turn == math.inf or not p > 0.0:
            return NONE, limit
        low, high = turn, math.inf
    else:
        low, high = 0.0, turn
        if turn < math.inf and turn <= limit:
            lowest = _value(row, shape, turn)[0]
            resolution = 8.0 * EPS * (abs(shape[3]) + abs(lowest - shape[3]))
            if lowest > resolution:
                return NONE, limit
            if lowest >= -resolution:
                return GRAZE, turn
    if low >= limit:
        return NONE, limit
    value, slope, _ = _value(row, shape, low)
    if value <= 0.0:
        return _hop(low, on_surface, limit)
    guess = low - value / slope if slope < 0.0 else low
    if high == math.inf and limit == math.inf:
        high = _below_zero(row, shape, bend, low, max(guess - low, low, EPS / max(abs(row[R2]), EPS)))
        if high == math.inf:
            return NONE, limit
    return _up_to(row, shape, low, high, guess, limit)


@inlined_kernel
def _below_zero(row, shape, bend, low, step):
    """A time after ``low`` at which a guard that falls for ever is no longer positive; infinite if there is none."""
    if row[R1] < 0.0 and bend / row[A0] >= 0.0:
        return math.inf  # falls to a limit that is not negative
    while not abs(_value(row, shape, low + step)[0]) < _HUGE:  # the step of a slope that is next to nothing
        step *= 0.5
    # Beyond 700 times of the slow exponential all of them are gone, and a bracket is too wide for GUESSES.
    while step * abs(row[R1]) > 700.0 and not _positive(row, shape, low + 0.5 * step):
        step *= 0.5
    while _positive(row, shape, low + step):
        step *= 2.0
        if not step < 1e300:
            return math.inf
    return low + step


@entry
def extremes(flow, mode, state, functional, duration):
    """Smallest and largest value of an affine function of the state over [0, duration] in a mode, in closed form.

    Arguments: ``functional`` (f_u, f_w, f_0), finite duration [s]. Returns (smallest, largest).
    """
    row = flow[mode]
    shape = _shape(row, state, functional)
    first = _value(row, shape, 0.0)[0]
    last = _value(row, shape, duration)[0]
    low, high = min(first, last), max(first, last)
    p, q = shape[0], shape[1]
    if p == 0.0 and q == 0.0:
        return low, high
    if row[BETA] > 0.0:
        half_turn = math.pi / row[BETA]
        start = ((math.atan2((q - row[ALPHA] * p) / row[BETA], p) + 0.5 * math.pi) % math.pi) / row[BETA]
        count = float(math.floor((duration - start) / half_turn))
        # Extrema only shrink or only grow along the flow: the first two and the last two bound them all.
        for k in (0.0, 1.0, max(count - 1.0, 2.0), max(count, 3.0)):
            if 0.0 <= k <= count:
                value = _value(row, shape, start + k * half_turn)[0]
                low, high = min(low, value), max(high, value)
        return low, high
    turn = _turning_time(row, shape)
    if turn < duration:
        value = _value(row, shape, turn)[0]
        low, high = min(low, value), max(high, value)
    return low, high
