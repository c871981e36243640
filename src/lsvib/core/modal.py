"""Closed-form flow of a mode with any number of states, as a sum of oscillators, and bounds of its derivatives.

A linear mode x′ = A x + b splits into pairs of modal coordinates, each an oscillator of :mod:`lsvib.core.planar`:
y = W x + w₀, x = V y + v₀. A pair is made of two complex or of two neighbouring real rates, so nothing is special where
the two rates of a pair coincide. A guard is a sum over the pairs, and so is every derivative of it. The k-th derivative
of a pair's part is bounded by

    complex:  min( |z| ω^k e^{−αt},  e^{−αt} (|P_k| + |Q_k| t) )
    real:     min( |a₁ r₁^k| e^{r₁t} + |a₂ r₂^k| e^{r₂t},  e^{r₁t} (|P_k| + |Q_k| h(t)) )

where the second forms stay small near a double rate. :mod:`lsvib.core.walk` isolates roots with these bounds.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.core import planar
from lsvib.core.jit import kernel
from lsvib.core.planar import A0, A1, ALPHA, BETA, DELTA, EPS, R1, R2, ROUNDING, responses

ORDERS = 5  # derivatives 0 to 4


class ModalFlow(NamedTuple):
    """Flow tables of m modes with n states and p pairs."""

    oscillators: np.ndarray  # (m, p, planar columns)
    to_modal: np.ndarray  # (m, 2p, n + 1)
    from_modal: np.ndarray  # (m, n, 2p + 1)
    field: np.ndarray  # (m, n, n + 1), A and b


@kernel
def apply(table, vector, out):
    """Write the affine image of ``vector`` under ``table`` (k, size + 1) to ``out`` (k)."""
    last = vector.size
    for i in range(out.size):
        total = table[i, last]
        for j in range(last):
            total += table[i, j] * vector[j]
        out[i] = total


@kernel
def flow_pairs(rows, start, t, out):
    """Write the modal state (2p) a time t [s] after ``start`` to ``out``; the pairs carry no force."""
    for pair in range(rows.shape[0]):
        c, s, s_rate = responses(rows[pair], t)
        u, w = start[2 * pair], start[2 * pair + 1]
        out[2 * pair] = u * c + w * s
        out[2 * pair + 1] = w * s_rate - rows[pair, A0] * u * s


@kernel
def flow_with_decays(rows, start, t, out, decays):
    """As :func:`flow_pairs`, and write each pair's decay factors (p, 3): of the slow part, of the fast part, and h."""
    for pair in range(rows.shape[0]):
        u, w = start[2 * pair], start[2 * pair + 1]
        if rows[pair, BETA] > 0.0:
            alpha, beta = rows[pair, ALPHA], rows[pair, BETA]
            decay = math.exp(-alpha * t)
            s = decay * math.sin(beta * t) / beta
            c = decay * math.cos(beta * t)
            out[2 * pair] = u * (c + alpha * s) + w * s
            out[2 * pair + 1] = w * (c - alpha * s) - rows[pair, A0] * u * s
            decays[pair, 0], decays[pair, 1], decays[pair, 2] = decay, 0.0, t
        else:
            slow_rate, spread = rows[pair, R1], 2.0 * rows[pair, DELTA]
            slow = math.exp(slow_rate * t)
            fast = math.expm1(-spread * t)
            h = -fast / spread if spread > 0.0 else t
            out[2 * pair] = slow * (u * (1.0 - slow_rate * h) + w * h)
            out[2 * pair + 1] = slow * (w * (1.0 + fast + slow_rate * h) - rows[pair, A0] * u * h)
            decays[pair, 0], decays[pair, 1], decays[pair, 2] = slow, slow * (1.0 + fast), h


@kernel
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    modal = np.empty(flow.to_modal.shape[1])
    apply(flow.to_modal[mode], state, modal)
    flow_pairs(flow.oscillators[mode], modal, t, modal)
    apply(flow.from_modal[mode], modal, out)


@kernel
def magnitudes(flow, mode, state, stay, scale):
    """Write to ``scale`` (n) the sizes of the terms that the state after a stay [s] in ``mode`` is summed from."""
    modal = np.empty(flow.to_modal.shape[1])
    apply(flow.to_modal[mode], state, modal)
    sizes = np.empty(modal.size)
    for pair in range(modal.size // 2):
        part = slice(2 * pair, 2 * pair + 2)
        planar.magnitudes(flow.oscillators[mode], pair, modal[part], stay, sizes[part])
    for i in range(state.size):
        total = abs(flow.from_modal[mode, i, modal.size])
        for j in range(modal.size):
            total += abs(flow.from_modal[mode, i, j]) * sizes[j]
        scale[i] = total


@kernel
def guard_at(flow, mode, state, scale, guard):
    """Value, first and second derivative of a guard at a state, each with the size below which it is rounding only."""
    n = state.size
    field = flow.field[mode]
    value, rate, bend = guard[n], 0.0, 0.0
    size, rate_size, bend_size = abs(guard[n]), 0.0, 0.0
    for i in range(n):
        value += guard[i] * state[i]
        size += abs(guard[i]) * scale[i]
        weight, weight_size = 0.0, 0.0  # of x_i in the rate: (gᵀ A)_i
        for j in range(n):
            weight += guard[j] * field[j, i]
            weight_size += abs(guard[j] * field[j, i])
        speed, speed_size = field[i, n], abs(field[i, n])
        for j in range(n):
            speed += field[i, j] * state[j]
            speed_size += abs(field[i, j]) * scale[j]
        rate += guard[i] * speed
        rate_size += abs(guard[i]) * speed_size
        bend += weight * speed
        bend_size += weight_size * speed_size
    return value, ROUNDING * size, rate, ROUNDING * rate_size, bend, ROUNDING * bend_size


@kernel
def amplitudes(row, value, rate, out):
    """Write the factors of the bounds of a pair's part, given its value and rate at time zero, to ``out``."""
    if row[BETA] > 0.0:
        across = (rate + row[ALPHA] * value) / row[BETA]
        size = math.sqrt(value * value + across * across)
        for k in range(ORDERS):
            out[k, 0], out[k, 1], out[k, 2], out[k, 3] = size, 0.0, abs(value), abs(rate + row[ALPHA] * value)
            size *= math.sqrt(row[A0])
            value, rate = rate, -row[A0] * value - row[A1] * rate
        return
    p, q = value, rate - row[R1] * value
    spread = 2.0 * row[DELTA]
    for k in range(ORDERS):
        fast = abs(q) / spread if spread > 0.0 else math.inf
        slow = abs(p + q / spread) if spread > 0.0 else math.inf
        # p + q / spread loses digits to cancellation; what is lost is added, so that the bound stays a bound.
        out[k, 0] = slow + 4.0 * EPS * (abs(p) + fast) if spread > 0.0 else math.inf
        out[k, 1], out[k, 2], out[k, 3] = fast, abs(p), abs(q)
        p, q = row[R1] * p + q, row[R2] * q


@kernel
def bound(amplitudes, guard, k, largest):
    """Bound of the k-th derivative of a guard; ``amplitudes`` (g, p, orders, 4), ``largest`` decay factors (p, 3)."""
    total = 0.0
    for pair in range(largest.shape[0]):
        slow = largest[pair, 0]
        joint = slow * (amplitudes[guard, pair, k, 2] + amplitudes[guard, pair, k, 3] * largest[pair, 2])
        fast = amplitudes[guard, pair, k, 1]
        split = amplitudes[guard, pair, k, 0] * slow + (fast * largest[pair, 1] if fast > 0.0 else 0.0)
        total += joint if not split < joint else split
    return total


@kernel
def tail_bound(rows, amplitudes, guard, decays, t):
    """Bound of a guard's moving part for all times from ``t`` on, over the pairs with stiffness, which must all decay.

    With h(t) ≤ t, the joint form is at most (|P| + |Q| t) e^{−rt} with the slower rate r, which falls from t = 1/r on.
    """
    total = 0.0
    for pair in range(decays.shape[0]):
        if rows[pair, A0] == 0.0:
            continue
        slow, fast = decays[pair, 0], amplitudes[guard, pair, 0, 1]
        rate = rows[pair, ALPHA] if rows[pair, BETA] > 0.0 else -rows[pair, R1]
        split = amplitudes[guard, pair, 0, 0] * slow + (fast * decays[pair, 1] if fast > 0.0 else 0.0)
        longest = t * slow if t * rate >= 1.0 else math.exp(-1.0) / rate
        joint = amplitudes[guard, pair, 0, 2] * slow + amplitudes[guard, pair, 0, 3] * longest
        total += joint if not split < joint else split
    return total


@kernel
def derivatives(rows, modal, forms, guard, out):
    """Write a guard (row of ``forms``, (g, 2p + 1)) and its first two derivatives to its row of ``out`` (g, 3)."""
    value, rate, bend = forms[guard, modal.size], 0.0, 0.0
    for pair in range(rows.shape[0]):
        u, w = modal[2 * pair], modal[2 * pair + 1]
        a0, a1 = rows[pair, A0], rows[pair, A1]
        acceleration = -a0 * u - a1 * w
        g_u, g_w = forms[guard, 2 * pair], forms[guard, 2 * pair + 1]
        value += g_u * u + g_w * w
        rate += g_u * w + g_w * acceleration
        bend += g_u * acceleration - g_w * (a0 * w + a1 * acceleration)
    out[guard, 0], out[guard, 1], out[guard, 2] = value, rate, bend


@kernel
def in_modal_form(flow, mode, guard, out):
    """Write an affine function of the state (n + 1) as one of the modal coordinates (2p + 1) to ``out``."""
    table = flow.from_modal[mode]
    n = guard.size - 1
    for j in range(out.size):
        total = guard[n] if j == out.size - 1 else 0.0
        for i in range(n):
            total += guard[i] * table[i, j]
        out[j] = total
