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
from lsvib.core.jit import allocating_kernel, kernel
from lsvib.core.planar import A0, A1, ALPHA, BETA, DELTA, EPS, R1, R2, ROUNDING

ORDERS = 5  # derivatives 0 to 4


class ModalFlow(NamedTuple):
    """Flow tables of m modes with n states and up to p pairs; what a mode does not use is zero."""

    pairs: np.ndarray  # (m,) pairs of each mode
    oscillators: np.ndarray  # (m, p, planar columns)
    to_modal: np.ndarray  # (m, 2p, n + 1)
    from_modal: np.ndarray  # (m, n, 2p + 1)
    field: np.ndarray  # (m, n, n + 1), A and b


@kernel
def apply(table, vector, out):
    """Write the affine image of ``vector`` under the first columns and the last one of ``table`` to ``out``."""
    last = table.shape[1] - 1
    for i in range(out.size):
        total = table[i, last]
        for j in range(vector.size):
            total += table[i, j] * vector[j]
        out[i] = total


@kernel
def pair_after(row, u, w, t):
    """Modal coordinates of a pair a time t [s] later, and its decay factors: of the slow part, of the fast part, and h.

    Written out rather than with :func:`lsvib.core.planar.responses`, since most pairs of a stiff mode need fewer
    exponentials: a rate that is alone has R1 = R2, one that is carried without its equilibrium has a zero beside it.
    """
    if row[BETA] > 0.0:
        alpha, beta = row[ALPHA], row[BETA]
        decay = math.exp(-alpha * t)
        s = decay * math.sin(beta * t) / beta
        c = decay * math.cos(beta * t)
        return u * (c + alpha * s) + w * s, w * (c - alpha * s) - row[A0] * u * s, decay, 0.0, t
    rate, spread = row[R1], 2.0 * row[DELTA]
    slow = math.exp(rate * t) if rate != 0.0 else 1.0
    rest = w - rate * u
    if spread == 0.0:
        return slow * (u + rest * t), slow * (w + rate * rest * t), slow, 0.0, t
    less = math.expm1(-spread * t)
    h = -less / spread
    return slow * (u + rest * h), slow * (w * (1.0 + less + rate * h) - row[A0] * u * h), slow, slow * (1.0 + less), h


@kernel
def flow_pairs(rows, start, t, out):
    """Write the modal state (2p) a time t [s] after ``start`` to ``out``; the pairs carry no force."""
    for pair in range(rows.shape[0]):
        k = 2 * pair
        out[k], out[k + 1], _, _, _ = pair_after(rows[pair], start[k], start[k + 1], t)


@kernel
def flow_with_decays(rows, start, t, out, decays):
    """As :func:`flow_pairs`, and write each pair's decay factors (p, 3): of the slow part, of the fast part, and h."""
    for pair in range(rows.shape[0]):
        k = 2 * pair
        out[k], out[k + 1], slow, fast, h = pair_after(rows[pair], start[k], start[k + 1], t)
        decays[pair, 0], decays[pair, 1], decays[pair, 2] = slow, fast, h


@allocating_kernel
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    pairs = flow.pairs[mode]
    modal = np.empty(2 * pairs)
    apply(flow.to_modal[mode], state, modal)
    flow_pairs(flow.oscillators[mode, :pairs], modal, t, modal)
    apply(flow.from_modal[mode], modal, out)


@kernel
def travel(flow, mode, state, stay, scale, room):
    """Replace ``state`` by the one after a stay [s] in ``mode``, and write to ``scale`` (n) the sizes of its terms.

    ``room`` (2 or more, 2p or more) is scratch space.
    """
    pairs, last = flow.pairs[mode], flow.from_modal.shape[2] - 1
    modal, sizes = room[0, : 2 * pairs], room[1, : 2 * pairs]
    rows, table = flow.oscillators[mode, :pairs], flow.from_modal[mode]
    apply(flow.to_modal[mode], state, modal)
    for pair in range(pairs):
        part = slice(2 * pair, 2 * pair + 2)
        planar.magnitudes(rows, pair, modal[part], stay, sizes[part])
    flow_pairs(rows, modal, stay, modal)
    apply(table, modal, state)
    for i in range(state.size):
        total = abs(table[i, last])
        for j in range(modal.size):
            total += abs(table[i, j]) * sizes[j]
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
    """Write the factors of the bounds of a pair's part, given its value and rate at time zero, to ``out`` (orders, 6).

    Columns: amplitude of the slow and of the fast term (complex pair: of the oscillation, and 0), |P|, |Q|, what the
    slow amplitude may have lost to cancellation, and |Q| again where the rates are equal, so that Q has no term.
    """
    if row[BETA] > 0.0:
        across = (rate + row[ALPHA] * value) / row[BETA]
        size = math.sqrt(value * value + across * across)
        growth = math.sqrt(row[A0])
        for k in range(ORDERS):
            out[k, 0], out[k, 1], out[k, 2], out[k, 3] = size, 0.0, abs(value), abs(rate + row[ALPHA] * value)
            out[k, 4], out[k, 5] = 0.0, 0.0
            size *= growth
            value, rate = rate, -row[A0] * value - row[A1] * rate
        return
    p, q = value, rate - row[R1] * value
    spread = 2.0 * row[DELTA]
    fast = -q / spread if spread > 0.0 else 0.0
    slow, lost = p - fast, 4.0 * EPS * (abs(p) + abs(fast))
    for k in range(ORDERS):
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4] = slow, fast, abs(p), abs(q), lost
        out[k, 5] = 0.0 if spread > 0.0 else abs(q)
        p, q = row[R1] * p + q, row[R2] * q
        slow, fast, lost = row[R1] * slow if spread > 0.0 else p, row[R2] * fast, abs(row[R1]) * lost


@kernel
def bound(factors, slow, fast, h):
    """Bound of a pair's part of a derivative of a guard.

    Arguments: the derivative's row of ``amplitudes`` (6), and the largest decay factors on the way.
    """
    joint = slow * (factors[2] + factors[3] * h)
    split = slow * (abs(factors[0]) + factors[4] + factors[5] * h) + abs(factors[1]) * fast
    return min(joint, split)


@kernel
def range_of_terms(factors, here, there):
    """Bounds from below and above of a pair with real rates between two times: each of its terms is monotone.

    Arguments: a row of ``amplitudes`` (6), decay factors (3) at both times.
    """
    slow_here, slow_there = factors[0] * here[0], factors[0] * there[0]
    fast_here, fast_there = factors[1] * here[1], factors[1] * there[1]
    lost = (factors[4] + factors[5] * max(here[2], there[2])) * max(here[0], there[0])
    low = min(slow_here, slow_there) + min(fast_here, fast_there) - lost
    return low, max(slow_here, slow_there) + max(fast_here, fast_there) + lost


@kernel
def tail_bound(rows, amplitudes, guard, decays, t):
    """Bound of a guard's moving part for all times from ``t`` on, over the pairs with stiffness, which must all decay.

    With h(t) ≤ t, the joint form is at most (|P| + |Q| t) e^{−rt} with the slower rate r, which falls from t = 1/r on.
    """
    total = 0.0
    for pair in range(rows.shape[0]):
        if rows[pair, A0] == 0.0:
            continue
        factors, slow = amplitudes[guard, pair, 0], decays[pair, 0]
        rate = rows[pair, ALPHA] if rows[pair, BETA] > 0.0 else -rows[pair, R1]
        longest = t * slow if t * rate >= 1.0 else math.exp(-1.0) / rate
        joint = factors[2] * slow + factors[3] * longest
        split = slow * (abs(factors[0]) + factors[4]) + factors[5] * longest + abs(factors[1]) * decays[pair, 1]
        total += min(joint, split)
    return total


@kernel
def derivatives(rows, modal, forms, guard, out):
    """Write a guard (row of ``forms``, (g, 2p + 1)) and its first two derivatives to its row of ``out`` (g, 6).

    The last three are the same without the pairs that have real rates.
    """
    value, rate, bend = forms[guard, modal.size], 0.0, 0.0
    real_value, real_rate, real_bend = 0.0, 0.0, 0.0
    for pair in range(rows.shape[0]):
        u, w = modal[2 * pair], modal[2 * pair + 1]
        a0, a1 = rows[pair, A0], rows[pair, A1]
        acceleration = -a0 * u - a1 * w
        g_u, g_w = forms[guard, 2 * pair], forms[guard, 2 * pair + 1]
        part, part_rate = g_u * u + g_w * w, g_u * w + g_w * acceleration
        part_bend = g_u * acceleration - g_w * (a0 * w + a1 * acceleration)
        if rows[pair, BETA] > 0.0:
            value, rate, bend = value + part, rate + part_rate, bend + part_bend
        else:
            real_value, real_rate, real_bend = real_value + part, real_rate + part_rate, real_bend + part_bend
    out[guard, 0], out[guard, 1], out[guard, 2] = value + real_value, rate + real_rate, bend + real_bend
    out[guard, 3], out[guard, 4], out[guard, 5] = value, rate, bend


@kernel
def in_modal_form(flow, mode, guard, out):
    """Write an affine function of the state (n + 1) as one of the modal coordinates (2p + 1) to ``out``."""
    table = flow.from_modal[mode]
    n, last = guard.size - 1, out.size - 1
    for j in range(last):
        total = 0.0
        for i in range(n):
            total += guard[i] * table[i, j]
        out[j] = total
    total = guard[n]
    for i in range(n):
        total += guard[i] * table[i, table.shape[1] - 1]
    out[last] = total
