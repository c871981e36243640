"""Closed-form flow of a mode with two states.

A mode is the oscillator  u″ + a₁ u′ + a₀ u = b  with state (u, w = u′). With S its impulse response (S(0) = 0, S′(0) =
1), C = S′ + a₁ S its response to a unit displacement, and J = ∫S,

    u(t) = u_e + (u₀ − u_e) C + w₀ S = u₀ + w₀ S + (b − a₀ u₀) J,      w(t) = w₀ S′ + (b − a₀ u₀) S,      u_e = b / a₀.

The first form keeps relative accuracy near the equilibrium, the second when the equilibrium is far away or does not
exist (a₀ → 0); :func:`far` chooses. Roots of the characteristic equation are held as −a₁/2 ± iβ or as r₁ ≥ r₂ with r₁
− r₂ = 2δ; in h = (1 − e^{−2δt}) / 2δ everything is smooth through δ = 0, so no case is special near a double root.
"""

import math

import numpy as np

from lsvib.systems.kernels.jit import entry, inlined_entry, inlined_kernel, kernel
from lsvib.systems.kernels.layout import A0, A1, ALPHA, BETA, DELTA, EQUILIBRIUM, R1, R2, TIME_SCALE, B

EPS = float(np.finfo(np.float64).eps)
OVERFLOW = 700.0  # of an exponent
ROUNDING = 16.0 * EPS  # sums below this, relative to the sizes that they are made of, count as zero


@inlined_kernel
def apply(table, vector, out):
    """Write the affine image of ``vector`` under the first columns and the last one of ``table`` to ``out``."""
    last = table.shape[1] - 1
    for i in range(out.size):
        total = table[i, last]
        for j in range(vector.size):
            total += table[i, j] * vector[j]
        out[i] = total


@inlined_kernel
def summed(row, state, scale):
    """Value of an affine function at a state (n), and the sum of the sizes that its terms have at ``scale`` (n).

    What stands in ``row`` behind n + 1 is not read.
    """
    value, size = row[state.size], abs(row[state.size])
    for i in range(state.size):
        value += row[i] * state[i]
        size += abs(row[i] * scale[i])
    return value, size


@inlined_entry
def level(row, state, scale):
    """Value of an affine function at a state (n), and the size below which it is rounding only.

    ``scale`` (n) are the magnitudes that the state was computed from.
    """
    value, size = summed(row, state, scale)
    return value, ROUNDING * size


@inlined_kernel
def own_rate(row):
    """Rate ρ [1/s] at which the slower, or faster growing, part of the free motion changes: −α or r₁."""
    return -row[ALPHA] if row[BETA] > 0.0 else row[R1]


@inlined_entry
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


@entry
def integrated_response(row, t):
    """Return J = ∫₀ᵗ S, by its Taylor series where the closed form would cancel."""
    if abs(row[A1]) * t < 0.5 and abs(row[A0]) * t * t < 0.25:
        older, newer = 0.0, t
        total = 0.5 * t * t
        for n in range(20):  # at the longest times for which the series is summed 18 terms leave rounding only
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


@inlined_kernel
def far(row, u, w):
    """True if the equilibrium is absent, or so far away that displacements from it would cancel."""
    return row[A0] == 0.0 or abs(row[EQUILIBRIUM]) > 16.0 * (abs(u) + abs(w) * row[TIME_SCALE])


@inlined_entry
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    row = flow[mode]
    u, w = state[0], state[1]
    c, s, s_rate = responses(row, t)
    if far(row, u, w):
        force = row[B] - row[A0] * u
        out[0] = u + (w * s + force * integrated_response(row, t))
        out[1] = w * s_rate + force * s
    elif u == row[EQUILIBRIUM] and w == 0.0 and not math.isfinite(c + s + s_rate):
        out[0], out[1] = u, w  # growth beyond all numbers does not move what is in equilibrium
    else:
        y = u - row[EQUILIBRIUM]
        out[0] = row[EQUILIBRIUM] + (y * c + w * s)
        out[1] = w * s_rate - row[A0] * y * s


@inlined_kernel
def magnitudes(flow, mode, state, stay, scale):
    """Write to ``scale`` (2) the sizes of the terms that the state after a stay [s] in ``mode`` is summed from."""
    row = flow[mode]
    reach = min(stay, row[TIME_SCALE]) if row[A0] != 0.0 else stay
    speed, push = abs(state[1]), abs(row[B] - row[A0] * state[0])
    scale[0] = abs(state[0]) + speed * reach
    scale[1] = speed + push * reach
    rate = own_rate(row)
    if rate > 0.0:  # the deviation from the equilibrium grows
        more = math.expm1(min(rate * stay, OVERFLOW))
        reach = row[TIME_SCALE] if row[A0] != 0.0 else 1.0 / rate
        scale[0] += more * (speed + push * reach) * reach
        scale[1] += more * (speed + push * reach)


@inlined_kernel
def travel(flow, mode, state, stay, scale, work):
    """Replace ``state`` by the one after a stay [s] in ``mode``, and write to ``scale`` (2) the sizes of its terms."""
    magnitudes(flow, mode, state, stay, scale)
    advance(flow, mode, state, stay, state)


@inlined_entry
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
