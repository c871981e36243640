"""Closed-form flow of a mode with two states, and the certain isolation of a guard's roots along it.

A mode is the oscillator  u″ + a₁ u′ + a₀ u = b  with state (u, w = u′). With S its impulse response (S(0) = 0, S′(0) =
1), C = S′ + a₁ S its response to a unit displacement, and J = ∫S,

    u(t) = u_e + (u₀ − u_e) C + w₀ S = u₀ + w₀ S + (b − a₀ u₀) J,      w(t) = w₀ S′ + (b − a₀ u₀) S,      u_e = b / a₀.

The first form keeps relative accuracy near the equilibrium, the second when the equilibrium is far away or does not
exist (a₀ → 0); :func:`_far` chooses. Roots of the characteristic equation are held as −a₁/2 ± iβ or as r₁ ≥ r₂ with r₁
− r₂ = 2δ; in h = (1 − e^{−2δt}) / 2δ everything is smooth through δ = 0, so no case is special near a double root.

A guard g = g_u u + g_w w + g_0 has the derivative  g′(t) = p S′ + q S  with constants p, q. Its zeros are known in
closed form: one at most if the roots are real, and spaced by π/β otherwise. Between them g is monotone, so it has one
root there if its ends differ in sign and none otherwise; and since the extrema of an oscillation that does not grow
only get shallower, the first one decides for all time. This is what makes the search certain.
"""

import math

import numpy as np

from lsvib.core.jit import kernel
from lsvib.core.root import next_guess
from lsvib.core.status import Found

# Columns of a mode's row in the flow table.
A0, A1, B, ALPHA, BETA, DELTA, R1, R2, EQUILIBRIUM, TIME_SCALE = range(10)
COLUMNS = 10

EPS = float(np.finfo(np.float64).eps)
ROUNDING = 16.0 * EPS  # sums below this, relative to the sizes that they are made of, count as zero
_TWO_PI = 2.0 * math.pi
_HUGE = 1e250
_NEAR, _FAR, _SPLIT = range(3)  # forms of a guard along the flow
_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_GRAZE = int(Found.GRAZE)


@kernel
def responses(row, t):
    """Return C, S and S′ of a mode at time t [s]; ``row`` is the mode's row of the flow table."""
    if row[BETA] > 0.0:
        decay = math.exp(-row[ALPHA] * t)
        s = decay * math.sin(row[BETA] * t) / row[BETA]
        c = decay * math.cos(row[BETA] * t)
        return c + row[ALPHA] * s, s, c - row[ALPHA] * s
    decay = math.exp(row[R1] * t)
    spread = 2.0 * row[DELTA]
    fast = math.expm1(-spread * t)
    if fast < -0.5:  # what the fast part has left is small: nothing may be subtracted from 1
        left = math.exp(-spread * t)
        return (
            decay * (row[R1] * left - row[R2]) / spread,
            decay * (1.0 - left) / spread,
            decay * (row[R1] - row[R2] * left) / spread,
        )
    h = -fast / spread if spread > 0.0 else t
    return decay * (1.0 - row[R1] * h), decay * h, decay * (1.0 + fast + row[R1] * h)


@kernel
def _integrated_exponential(rate, t):
    """Return ∫₀ᵗ e^{rate t}."""
    return math.expm1(rate * t) / rate if rate != 0.0 else t


@kernel
def _integrated_response(row, t):
    """Return J = ∫₀ᵗ S, by its Taylor series where the closed form would cancel."""
    if abs(row[A1]) * t < 0.5 and abs(row[A0]) * t * t < 0.25:
        older, newer = 0.0, t
        total = 0.5 * t * t
        for n in range(20):
            older, newer = newer, -(row[A1] * t * (n + 1) * newer + row[A0] * t * t * older) / ((n + 1) * (n + 2))
            total += newer * t / (n + 3)
            if (abs(older) + abs(newer)) * t < 0.1 * EPS * total:  # either may vanish on its own
                break
        return total
    if row[BETA] > 0.0:
        less = math.expm1(-row[ALPHA] * t)
        s = math.sin(row[BETA] * t)
        c = math.cos(row[BETA] * t)
        one_less_cos = s * s / (1.0 + c) if c > 0.0 else 1.0 - c
        return (-less + (1.0 + less) * (one_less_cos - row[ALPHA] * s / row[BETA])) / row[A0]
    if 2.0 * row[DELTA] * t > 0.25:
        return (_integrated_exponential(row[R1], t) - _integrated_exponential(row[R2], t)) / (2.0 * row[DELTA])
    h = -math.expm1(-2.0 * row[DELTA] * t) / (2.0 * row[DELTA]) if row[DELTA] > 0.0 else t
    return (math.exp(row[R1] * t) * row[R1] * h - math.expm1(row[R1] * t)) / row[A0]


@kernel
def _far(row, u, w):
    """True if the equilibrium is absent, or so far away that displacements from it would cancel."""
    return row[A0] == 0.0 or abs(row[EQUILIBRIUM]) > 16.0 * (abs(u) + abs(w) * row[TIME_SCALE])


@kernel
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    row = flow[mode]
    u, w = state[0], state[1]
    c, s, s_rate = responses(row, t)
    if _far(row, u, w):
        force = row[B] - row[A0] * u
        out[0] = u + (w * s + force * _integrated_response(row, t))
        out[1] = w * s_rate + force * s
    else:
        y = u - row[EQUILIBRIUM]
        out[0] = row[EQUILIBRIUM] + (y * c + w * s)
        out[1] = w * s_rate - row[A0] * y * s


@kernel
def _shape(row, state, guard):
    """Constants of a guard along the flow: p, q, the form that holds, coefficients of 1, C or J, S, S′.

    A guard that comes with its parts – its values at the equilibrium and along both eigenvectors, formed without
    cancellation – is split where the real rates lie apart; then the last three are the coefficients of e^{r₁t}, e^{r₂t}
    and nothing. Without that a guard that is almost zero along the slow eigenvector, as the contact force next to the
    critical mass, would be lost in rounding.
    """
    u, w = state[0], state[1]
    far = _far(row, u, w)
    y = 0.0 if far else u - row[EQUILIBRIUM]
    force = row[B] - row[A0] * u if far else -row[A0] * y
    p = guard[0] * w + guard[1] * (force - row[A1] * w)
    q = guard[0] * force - guard[1] * row[A0] * w
    if far:
        return p, q, _FAR, guard[0] * u + guard[2], guard[0] * force, guard[0] * w + guard[1] * force, guard[1] * w
    if guard.size > 3 and 2.0 * row[DELTA] > abs(row[ALPHA]):
        spread = 2.0 * row[DELTA]
        slow, fast = guard[4] * (w - row[R2] * y) / spread, guard[5] * (row[R1] * y - w) / spread
        return p, q, _SPLIT, guard[3], slow, fast, 0.0
    constant = guard[0] * row[EQUILIBRIUM] + guard[2]
    return p, q, _NEAR, constant, guard[0] * y, guard[0] * w + guard[1] * force, guard[1] * w


@kernel
def _value(row, shape, t):
    """Value and first two derivatives of a guard at time t."""
    p, q, form, constant, c_part, s_part, rate_part = shape
    if form == _SPLIT:
        slow, fast = c_part * math.exp(row[R1] * t), s_part * math.exp(row[R2] * t)
        slow_rate, fast_rate = row[R1] * slow, row[R2] * fast
        return constant + (slow + fast), slow_rate + fast_rate, row[R1] * slow_rate + row[R2] * fast_rate
    c, s, s_rate = responses(row, t)
    if form == _FAR:
        c = _integrated_response(row, t)
    value = constant + (c_part * c + s_part * s + rate_part * s_rate)
    return value, p * s_rate + q * s, (q - row[A1] * p) * s_rate - row[A0] * p * s


@kernel
def _positive(row, shape, t):
    """Whether a guard that falls from a moderate value is still positive; a huge value has overflown on its way."""
    return 0.0 < _value(row, shape, t)[0] < _HUGE


@kernel
def _descent(row, shape, low, high, guess):
    """Root of a guard that falls from ``low`` to ``high``, where it is not positive."""
    t = guess if low < guess < high else 0.5 * (low + high)
    rate = abs(row[ALPHA]) + row[BETA] + row[DELTA]
    for count in range(300):
        value, slope, curvature = _value(row, shape, t)
        if 0.0 < value < _HUGE:
            low = t
        elif value == 0.0:
            return t
        else:  # negative, or overflown far beyond the root
            high = t
        t, found = next_guess(t, value, slope, curvature, low, high, rate, count)
        if found:
            return t
    return t


@kernel
def _up_to(row, shape, low, high, guess, limit):
    """As :func:`_descent`, but only a root before ``limit`` counts: returns (found, time)."""
    if low >= limit:
        return _NONE, limit
    if limit < high:
        if _positive(row, shape, limit):
            return _NONE, limit
        high = limit
    return _CROSSING, _descent(row, shape, low, high, guess)


@kernel
def crossing(flow, mode, state, guard, on_surface, limit):
    """Find the first time in (0, limit] at which a guard falls through zero or touches it from above.

    Arguments: flow table, mode, state (2), guard (g_u, g_w, g_0), positive at the start or – with ``on_surface`` – zero
    at the start and rising; limit [s], may be infinite. Returns (``Found``, time [s]); certain in the sense of the
    module docstring.
    """
    row = flow[mode]
    shape = _shape(row, state, guard)
    bend = row[A0] * guard[3] if shape[2] == _SPLIT else row[A0] * guard[2] + guard[0] * row[B]
    if shape[0] == 0.0 and shape[1] == 0.0:
        return _NONE, limit
    if row[BETA] > 0.0:
        return _oscillating_crossing(row, shape, bend, on_surface, limit)
    if row[A0] == 0.0 and row[A1] == 0.0:
        return _parabolic_crossing(shape, on_surface, limit)
    return _monotone_crossing(row, shape, bend, on_surface, limit)


@kernel
def _oscillating_crossing(row, shape, bend, on_surface, limit):
    p, q, far, constant = shape[0], shape[1], shape[2] == _FAR, shape[3]
    alpha, beta = row[ALPHA], row[BETA]
    across = (q - alpha * p) / beta
    phase = math.atan2(across, p)
    # g′ is proportional to cos(βt − phase): a maximum follows where it falls through zero, a minimum half a turn later.
    top = phase + 0.5 * math.pi
    if top < 0.0:
        top += _TWO_PI
    bottom = top + math.pi
    if not on_surface and bottom > _TWO_PI:
        bottom -= _TWO_PI
        top -= _TWO_PI
    if top >= limit * beta or (limit * beta <= bottom and _value(row, shape, limit)[0] > 0.0):
        return _NONE, limit
    swing = beta * math.sqrt(p * p + across * across) / row[A0]
    middle = bend / row[A0] if far else constant
    t_bottom = bottom / beta
    lowest = middle - swing * math.exp(-alpha * t_bottom)
    if lowest > 0.0 and alpha < 0.0:
        # A growing oscillation: go straight to the first minimum that is deep enough.
        turns = math.ceil((math.log(middle / swing) / -alpha - t_bottom) * beta / _TWO_PI - 1e-9)
        top += turns * _TWO_PI
        bottom += turns * _TWO_PI
        t_bottom = bottom / beta
        lowest = middle - swing * math.exp(-alpha * t_bottom)
    if top >= limit * beta:
        return _NONE, limit
    if far:
        lowest = _value(row, shape, t_bottom)[0]
    resolution = 8.0 * EPS * (abs(constant) + swing * math.exp(-alpha * t_bottom))
    if lowest > resolution:
        return _NONE, limit
    if lowest >= -resolution:
        return (_GRAZE, t_bottom) if t_bottom <= limit else (_NONE, limit)
    rise = swing * math.exp(-alpha * top / beta)
    highest = middle + rise
    if top > 0.0 and highest <= 8.0 * EPS * (abs(constant) + rise):
        return _CROSSING, top / beta  # it rose by less than rounding
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
        return _NONE, limit
    # The smaller positive root where the parabola falls; written so that nothing cancels.
    root = math.sqrt(square)
    t = -(p + root) / q if q != 0.0 and p > 0.0 else 2.0 * value / (root - p)
    if t > limit:
        return _NONE, limit
    return (_GRAZE, t) if q > 0.0 and square <= 8.0 * EPS * p * p else (_CROSSING, t)


@kernel
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


@kernel
def _monotone_crossing(row, shape, bend, on_surface, limit):
    p, q = shape[0], shape[1]
    if shape[2] == _SPLIT:
        p = row[R1] * shape[4] + row[R2] * shape[5]
        q = row[R1] * row[R1] * shape[4] + row[R2] * row[R2] * shape[5]  # of one sign with g″ where p = 0
    turn = _turning_time(row, shape)
    rises = on_surface or p > 0.0 or (p == 0.0 and q > 0.0)
    if rises:
        if turn == math.inf or not p > 0.0:
            return _NONE, limit
        low, high = turn, math.inf
    else:
        low, high = 0.0, turn
        if turn <= limit:
            lowest = _value(row, shape, turn)[0]
            resolution = 8.0 * EPS * (abs(shape[3]) + abs(lowest - shape[3]))
            if lowest > resolution:
                return _NONE, limit
            if lowest >= -resolution:
                return _GRAZE, turn
    if low >= limit:
        return _NONE, limit
    value, slope, _ = _value(row, shape, low)
    if value <= 0.0:
        return _CROSSING, low  # it rose by less than rounding
    guess = low - value / slope if slope < 0.0 else low
    if high == math.inf and limit == math.inf:
        if row[R1] < 0.0 and bend / row[A0] >= 0.0:
            return _NONE, limit  # falls for ever, to a limit that is not negative
        step = max(guess - low, low, EPS / max(abs(row[R2]), EPS))
        high = low + step
        while _positive(row, shape, high):
            step *= 2.0
            high = low + step
            if not step < 1e300:
                return _NONE, limit
    return _up_to(row, shape, low, high, guess, limit)


@kernel
def magnitudes(flow, mode, state, stay, scale):
    """Write to ``scale`` (2) the sizes of the terms that the state after a stay [s] in ``mode`` is summed from."""
    row = flow[mode]
    reach = min(stay, row[TIME_SCALE]) if row[A0] != 0.0 else stay
    scale[0] = abs(state[0]) + abs(state[1]) * reach
    scale[1] = abs(state[1]) + abs(row[B] - row[A0] * state[0]) * reach


@kernel
def slopes_at(flow, mode, state, scale, guard):
    """First and second derivative of a guard at a state, each with the size below which it is rounding only.

    ``scale`` (2) are the magnitudes that the state was computed from; its rounding is in proportion to them.
    """
    row = flow[mode]
    u, w = state[0], state[1]
    acceleration = row[B] - row[A0] * u - row[A1] * w
    jerk = -row[A0] * w - row[A1] * acceleration
    push = abs(row[B]) + abs(row[A0]) * scale[0] + abs(row[A1]) * scale[1]
    tug = abs(row[A0]) * scale[1] + abs(row[A1]) * push
    rate = guard[0] * w + guard[1] * acceleration
    bend = guard[0] * acceleration + guard[1] * jerk
    rate_size = ROUNDING * (abs(guard[0]) * scale[1] + abs(guard[1]) * push)
    bend_size = ROUNDING * (abs(guard[0]) * push + abs(guard[1]) * tug)
    return rate, rate_size, bend, bend_size


@kernel
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
        for k in (0.0, 1.0, count - 1.0, count):
            if 0.0 <= k <= count:
                value = _value(row, shape, start + k * half_turn)[0]
                low, high = min(low, value), max(high, value)
        return low, high
    turn = _turning_time(row, shape)
    if turn < duration:
        value = _value(row, shape, turn)[0]
        low, high = min(low, value), max(high, value)
    return low, high
