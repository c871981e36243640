"""Guards along a modal flow, as sums of oscillators and exponentials, and enclosures of them and their derivatives.

With the modal coordinates of :mod:`lsvib.systems.kernels.flow_modal` a guard is

    g(t) = g₀ + Σ p(t) + Σ a e^{rt} + Σ b ∫₀ᵗ e^{rτ} dτ

where the sums are over the pairs and the two sorts of singles. The parts are formed once for a search; after that a
value of any guard costs the exponentials of its mode and a few products. The k-th derivative of the part of a pair is
bounded by

    complex:  min( |z| ω^k e^{−αt},  e^{−αt} (|P_k| + |Q_k| t) )
    real:     min( |a₁ r₁^k| e^{r₁t} + |a₂ r₂^k| e^{r₂t},  e^{r₁t} (|P_k| + |Q_k| h(t)) )

where the second forms stay small near a double rate. The k-th derivative of the part of a single is monotone, so its
values at both ends of a step enclose it.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.systems.kernels import flow_modal
from lsvib.systems.kernels.flow_planar import EPS, apply, own_rate
from lsvib.systems.kernels.jit import allocating_kernel, inlined_kernel, kernel
from lsvib.systems.kernels.layout import A0, A1, ALPHA, BETA, DELTA, R1, R2

ORDERS = 5  # derivatives 0 to 4
_LEAST = 2.0**-960  # a guard that is smaller is rounding: the smallest doubles, down to 2⁻¹⁰⁷⁴, have no digits


class Sums(NamedTuple):
    """Parts of up to g guards in a mode of up to p pairs and s singles, and their values at up to three times.

    ``pairs`` holds p, p′ − ρp, p′ and ρp′ − a₀p of each pair's part at time zero, as
    :func:`lsvib.systems.kernels.flow_modal.responses` wants them.
    """

    states: np.ndarray  # (2, q) the modal state at time zero, and spare room
    form: np.ndarray  # (q + 1,) one guard in modal coordinates
    starts: np.ndarray  # (g,) each guard at time zero, from the state itself
    constants: np.ndarray  # (g,) g₀ plus the values at time zero of singles without an equilibrium
    pairs: np.ndarray  # (g, p, 4)
    pair_bounds: np.ndarray  # (g, p, orders, 4) amplitudes of the slow and of the fast term, |P_k|, |Q_k|
    singles: np.ndarray  # (g, s, orders) factor of e^{rt} in each derivative
    rounding: np.ndarray  # (g,) size of a guard below which it is rounding only
    pair_nodes: np.ndarray  # (3, p, 6) responses of each pair at a time
    single_nodes: np.ndarray  # (3, s, 2) the growth of each single and its integral at a time
    values: np.ndarray  # (3, g, 6) a guard and its first two derivatives at a time, and the same for its pairs alone
    steps: np.ndarray  # (1,) steps that searches may still take; infinite at first


@allocating_kernel
def room_for(flow, guards):
    """Return uninitialised ``Sums`` for so many guards, with steps without end."""
    pairs, singles = flow.oscillators.shape[1], flow.rates.shape[1]
    size = flow.to_modal.shape[1]
    return Sums(
        np.empty((2, size)), np.empty(size + 1), np.empty(guards), np.empty(guards), np.empty((guards, pairs, 4)),
        np.empty((guards, pairs, ORDERS, 4)), np.empty((guards, singles, ORDERS)), np.empty(guards),
        np.empty((3, pairs, 6)), np.empty((3, singles, 2)), np.empty((3, guards, 6)), np.full(1, math.inf),
    )  # fmt: skip


@inlined_kernel
def prepare(flow, mode, state, guards, sums):
    """Form the parts of guards (g, n + 1 or more) from a state (n), and their values at time zero as node 0."""
    pairs, singles, size = flow.pairs[mode], flow.singles[mode], flow_modal.size_of(flow, mode)
    start, form = sums.states[0, :size], sums.form[: size + 1]
    apply(flow.to_modal[mode], state, start)
    for pair in range(pairs):
        node = sums.pair_nodes[0, pair]
        node[0], node[1], node[2], node[3], node[4], node[5] = 1.0, 0.0, 1.0, 1.0, 1.0, 0.0
    for single in range(singles):
        sums.single_nodes[0, single, 0], sums.single_nodes[0, single, 1] = 1.0, 0.0
    for guard in range(guards.shape[0]):
        flow_modal.in_modal_form(flow, mode, guards[guard], form)
        constant, total, k = form[size], abs(form[size]), 0
        for pair in range(pairs):
            row, u, w, g_u, g_w = flow.oscillators[mode, pair], start[k], start[k + 1], form[k], form[k + 1]
            part, rate, own = g_u * u + g_w * w, g_u * w - g_w * (row[A0] * u + row[A1] * w), own_rate(row)
            parts = sums.pairs[guard, pair]
            parts[0], parts[1], parts[2], parts[3] = part, rate - own * part, rate, own * rate - row[A0] * part
            pair_bounds(row, part, rate, sums.pair_bounds[guard, pair])
            total += abs(g_u * u) + abs(g_w * w)
            k += 2
        for single in range(singles):
            rate, push = flow.rates[mode, single], flow.pushes[mode, single]
            part, factors = form[k] * start[k], sums.singles[guard, single]
            if push == 0.0:
                factors[0], factors[1] = part, rate * part
            else:
                factors[0], factors[1] = 0.0, form[k] * (rate * start[k] + push)
                constant += part
            for order in range(2, ORDERS):
                factors[order] = rate * factors[order - 1]
            total += abs(part)
            k += 1
        sums.constants[guard] = constant
        sums.rounding[guard] = max(8.0 * EPS * total, _LEAST)
        evaluate(flow, mode, sums, guard, 0)


@inlined_kernel
def pair_bounds(row, value, rate, out):
    """Write the factors of the bounds of a pair's part, given its value and rate at time zero, to ``out`` (orders, 4).

    The columns are those of ``Sums.pair_bounds``. The amplitude of the slow term includes the rounding that
    cancellation may have left in it; it is infinite where the two rates are equal, because then there are no two terms.
    """
    if row[BETA] > 0.0:
        across = (rate + row[ALPHA] * value) / row[BETA]
        size = math.sqrt(value * value + across * across)
        more = math.sqrt(row[A0])
        for k in range(ORDERS):
            out[k, 0], out[k, 1], out[k, 2], out[k, 3] = size, 0.0, abs(value), abs(rate + row[ALPHA] * value)
            size *= more
            value, rate = rate, -row[A0] * value - row[A1] * rate
        return
    p, q = value, rate - row[R1] * value
    spread = 2.0 * row[DELTA]
    fast = -q / spread if spread > 0.0 else 0.0
    slow, lost = p - fast, 4.0 * EPS * (abs(p) + abs(fast))
    for k in range(ORDERS):
        out[k, 0] = abs(slow) + lost if spread > 0.0 else math.inf
        out[k, 1], out[k, 2], out[k, 3] = abs(fast), abs(p), abs(q)
        p, q = row[R1] * p + q, row[R2] * q
        slow, fast, lost = row[R1] * slow, row[R2] * fast, abs(row[R1]) * lost


@inlined_kernel
def bound(factors, slow, fast, h):
    """Return the bound of a pair's part of a derivative from a row of ``pair_bounds`` (4) and the largest responses."""
    joint = slow * (factors[2] + factors[3] * h)
    split = slow * factors[0] + factors[1] * fast
    return split if split < joint else joint


@inlined_kernel
def go_to(flow, mode, sums, t, node):
    """Write the responses of pairs and singles at time t [s] as a node."""
    for pair in range(flow.pairs[mode]):
        at = sums.pair_nodes[node, pair]
        at[0], at[1], at[2], at[3], at[4], at[5] = flow_modal.responses(flow.oscillators[mode, pair], t)
    for single in range(flow.singles[mode]):
        at = sums.single_nodes[node, single]
        at[0], at[1] = flow_modal.growth(flow.rates[mode, single], flow.pushes[mode, single], t)


@inlined_kernel
def evaluate(flow, mode, sums, guard, node):
    """Write a guard and its first two derivatives at a node to ``values``."""
    value, rate, bend = 0.0, 0.0, 0.0
    for pair in range(flow.pairs[mode]):
        at, parts, row = sums.pair_nodes[node, pair], sums.pairs[guard, pair], flow.oscillators[mode, pair]
        part, part_rate = parts[0] * at[0] + parts[1] * at[1], parts[2] * at[2] + parts[3] * at[1]
        value, rate, bend = value + part, rate + part_rate, bend - row[A0] * part - row[A1] * part_rate
    out = sums.values[node, guard]
    out[3], out[4], out[5] = value, rate, bend
    value += sums.constants[guard]
    for single in range(flow.singles[mode]):
        e, integral = sums.single_nodes[node, single, 0], sums.single_nodes[node, single, 1]
        factors = sums.singles[guard, single]
        value += factors[0] * e + factors[1] * integral
        rate += factors[1] * e
        bend += factors[2] * e
    out[0], out[1], out[2] = value, rate, bend


@kernel
def rounding_at(flow, mode, sums, guard, node):
    """Return the size of a guard at a node below which it is rounding only: of its parts as far as they are left."""
    total = abs(sums.constants[guard])
    for pair in range(flow.pairs[mode]):
        at = sums.pair_nodes[node, pair]
        total += bound(sums.pair_bounds[guard, pair, 0], at[3], at[4], at[5])
    for single in range(flow.singles[mode]):
        e, integral = sums.single_nodes[node, single, 0], sums.single_nodes[node, single, 1]
        total += abs(sums.singles[guard, single, 0] * e) + abs(sums.singles[guard, single, 1] * integral)
    return max(8.0 * EPS * total, _LEAST)


@inlined_kernel
def least_between(flow, mode, sums, guard, here, there, k, sign, eighth):
    """Bound ``sign`` times the k-th derivative of a guard from below between two nodes.

    ``eighth`` [s²] is h²/8, where h is the time between the nodes. The part of the pairs differs from its chord by
    max|f″| h²/8 at most. The part of the singles is enclosed likewise, or by the values of each single at both ends,
    whichever is narrower. Returns the lower bound and the lesser of the values at the two nodes.
    """
    left, right = sums.values[here, guard], sums.values[there, guard]
    least = min(sign * left[k], sign * right[k])
    smooth, rough = 0.0, 0.0  # bounds of the second derivative of pairs and of singles
    below = min(sign * left[k + 3], sign * right[k + 3])
    for pair in range(flow.pairs[mode]):
        a, b = sums.pair_nodes[here, pair], sums.pair_nodes[there, pair]
        smooth += bound(sums.pair_bounds[guard, pair, k + 2], max(a[3], b[3]), max(a[4], b[4]), max(a[5], b[5]))
    for single in range(flow.singles[mode]):
        a, b, factors = sums.single_nodes[here, single], sums.single_nodes[there, single], sums.singles[guard, single]
        rough += abs(factors[k + 2]) * max(a[0], b[0])
        first, last = factors[k] * a[0], factors[k] * b[0]
        if k == 0:
            first, last = first + factors[1] * a[1], last + factors[1] * b[1]
        below += min(sign * first, sign * last)
    if k == 0:
        below += sign * sums.constants[guard]
    low, other = least - (smooth + rough) * eighth, min(below - smooth * eighth, least)
    return other if other > low else low, least


@inlined_kernel
def lowest_from(flow, mode, sums, guard, node, t):
    """Return a lower bound of a guard for all times from the node at t [s] on; −∞ if a part of it grows, but by drift.

    Because h(t) ≤ t, the joint form of a pair is at most (|P| + |Q| t) e^{−rt} with its slower rate r; this falls from
    t = 1/r on.
    """
    level = sums.constants[guard]
    for pair in range(flow.pairs[mode]):
        row, at, factors = flow.oscillators[mode, pair], sums.pair_nodes[node, pair], sums.pair_bounds[guard, pair, 0]
        rate = -own_rate(row)
        if rate == 0.0 and row[BETA] > 0.0:  # it swings for ever
            level -= factors[0]
            continue
        if not (row[A0] > 0.0 and rate > 0.0):
            return -math.inf
        longest = t * at[3] if t * rate >= 1.0 else math.exp(-1.0) / rate
        joint = factors[2] * at[3] + factors[3] * longest
        split = factors[0] * at[3] + factors[1] * at[4]
        level -= split if split < joint else joint
    for single in range(flow.singles[mode]):
        rate, push, factors = flow.rates[mode, single], flow.pushes[mode, single], sums.singles[guard, single]
        e = sums.single_nodes[node, single, 0]
        if rate > 0.0 or (rate == 0.0 and push != 0.0 and factors[1] < 0.0):
            return -math.inf
        if rate == 0.0:
            level += factors[0] + factors[1] * sums.single_nodes[node, single, 1]
        elif push == 0.0:
            level -= abs(factors[0]) * e
        else:
            way = factors[1] / -rate  # from time zero to the limit
            level += way - abs(way) * e
    return level


@kernel
def outlasts(flow, mode, sums, guard, node):
    """Whether a guard stays positive from a node on: its part that decays least does, and outweighs all else.

    That part is real, may be the constant and may grow; the others are of it what they are at the node, or less.
    """
    lead = sums.constants[guard]
    for single in range(flow.singles[mode]):  # with a push it is carried as what it grows by from time zero
        if flow.pushes[mode, single] != 0.0:
            lead -= sums.singles[guard, single, 1] / flow.rates[mode, single]  # of a drift it is no number
    slowest, total = 0.0 if lead != 0.0 else -math.inf, abs(lead)
    for pair in range(flow.pairs[mode]):
        row, at, parts = flow.oscillators[mode, pair], sums.pair_nodes[node, pair], sums.pairs[guard, pair]
        factors, spread = sums.pair_bounds[guard, pair, 0], 2.0 * row[DELTA]
        size = factors[0] * at[3] + factors[1] * at[4]
        if size > 0.0 and own_rate(row) > slowest:
            slowest = own_rate(row)
            lead = (parts[0] + parts[1] / spread) * at[3] if spread > 0.0 else 0.0
        total += size
    for single in range(flow.singles[mode]):
        rate, factors = flow.rates[mode, single], sums.singles[guard, single]
        part = factors[0] if flow.pushes[mode, single] == 0.0 else factors[1] / rate
        size = part * sums.single_nodes[node, single, 0]
        if size != 0.0 and rate > slowest:
            slowest, lead = rate, size
        total += abs(size)
    return 2.0 * lead > total
