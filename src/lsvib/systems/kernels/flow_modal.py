"""Closed-form flow of a mode with any number of states, as a sum of oscillators and exponentials.

A linear mode x′ = A x + b splits into modal coordinates, y = W x + w₀, x = V y + v₀: *pairs* (u, w = u′), each an
oscillator of :mod:`lsvib.systems.kernels.flow_planar` without force, for two complex or two neighbouring real rates, so
that nothing is special where the two coincide; and *singles* q′ = r q + f, one for each rate that is alone. A single
with f ≠ 0 is one whose equilibrium lies far away, or nowhere (r = 0), and is carried without it:

    f = 0:  q(t) = q₀ e^{rt}            f ≠ 0:  q(t) = q₀ + (r q₀ + f) ∫₀ᵗ e^{rτ} dτ

An affine function of the state, such as a guard, is a sum over pairs and singles, and so is every derivative of it:
:mod:`lsvib.systems.kernels.guard_sums`.
"""

import math

import numpy as np

from lsvib.systems.kernels import flow_planar
from lsvib.systems.kernels.flow_planar import OVERFLOW, ROUNDING, apply, own_rate, summed
from lsvib.systems.kernels.jit import allocating_entry, inlined_kernel
from lsvib.systems.kernels.layout import A0, ALPHA, BETA, DELTA, R1


@inlined_kernel
def responses(row, t):
    """Responses of a pair at time t [s]: (c, s, c′) and the bounds of its decay (slow, fast, h).

    With ρ = −α for complex rates and r₁ for real ones, (c, s, c′) gives every function of the pair from its value p and
    rate q at time zero: p(t) = p c + (q − ρ p) s and p′(t) = q c′ + (ρ q − a₀ p) s.
    """
    if row[BETA] > 0.0:
        decay = math.exp(-row[ALPHA] * t)
        s = decay * math.sin(row[BETA] * t) / row[BETA]
        c = decay * math.cos(row[BETA] * t)
        return c, s, c, decay, 0.0, t
    slow, spread = math.exp(row[R1] * t), 2.0 * row[DELTA]
    less = math.expm1(-spread * t)
    h = -less / spread if spread > 0.0 else t
    fast = slow * (1.0 + less)
    return slow, slow * h, fast, slow, fast, h


@inlined_kernel
def growth(rate, push, t):
    """Growth e^{rt} of a single, and its integral from 0 to t where the single is carried without its equilibrium.

    It ends short of overflow, so that what does not take part in it is not spoilt by an infinity.
    """
    if push == 0.0:
        return math.exp(min(rate * t, OVERFLOW)), 0.0
    if rate == 0.0:
        return 1.0, t
    more = math.expm1(min(rate * t, OVERFLOW))
    return 1.0 + more, more / rate


@inlined_kernel
def size_of(flow, mode):
    """Number of modal coordinates of a mode."""
    return 2 * flow.pairs[mode] + flow.singles[mode]


@inlined_kernel
def carry(flow, mode, start, t, out):
    """Write the modal state a time t [s] after ``start`` to ``out`` (may be ``start`` itself)."""
    k = 0
    for pair in range(flow.pairs[mode]):
        row = flow.oscillators[mode, pair]
        u, w, rate = start[k], start[k + 1], own_rate(row)
        c, s, turned, _, _, _ = responses(row, t)
        if u == 0.0 and w == 0.0 and not math.isfinite(c + s + turned):
            out[k], out[k + 1] = 0.0, 0.0  # growth beyond all numbers does not move what is in equilibrium
        else:
            out[k], out[k + 1] = u * c + (w - rate * u) * s, w * turned + (rate * w - row[A0] * u) * s
        k += 2
    for single in range(flow.singles[mode]):
        rate, push = flow.rates[mode, single], flow.pushes[mode, single]
        e, integral = growth(rate, push, t)
        out[k] = start[k] * e if push == 0.0 else start[k] + (rate * start[k] + push) * integral
        k += 1


@inlined_kernel
def is_still(flow, mode, state):
    """Whether a state is an equilibrium of a mode to the last bit; where N is zero there a guard rests on zero."""
    still = True
    for i in range(state.size):
        still = still and summed(flow.field[mode, i], state, state)[0] == 0.0
    return still


@inlined_kernel
def stays(flow, mode, state):
    """Whether a state is zero where nothing pushes: an equilibrium beyond all rounding, however much it repels."""
    for i in range(state.size):
        if state[i] != 0.0:
            return False
    return is_still(flow, mode, state)


@allocating_entry
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    if stays(flow, mode, state):
        for i in range(state.size):
            out[i] = 0.0
        return
    coordinates = np.empty(size_of(flow, mode))
    apply(flow.to_modal[mode], state, coordinates)
    carry(flow, mode, coordinates, t, coordinates)
    apply(flow.from_modal[mode], coordinates, out)


@inlined_kernel
def travel(flow, mode, state, stay, scale, work):
    """Replace ``state`` by the one after a stay [s] in ``mode``, and write to ``scale`` (n) the sizes of its terms.

    ``work`` is the scratch space of the search (:func:`lsvib.systems.kernels.guard_sums.room_for`).
    """
    n, count, last = state.size, size_of(flow, mode), flow.from_modal.shape[2] - 1
    coordinates, sizes, table = work.states[0, :count], work.states[1, :count], flow.from_modal[mode]
    apply(flow.to_modal[mode], state, coordinates)
    k = 2 * flow.pairs[mode]
    for pair in range(flow.pairs[mode]):
        part = slice(2 * pair, 2 * pair + 2)
        flow_planar.magnitudes(flow.oscillators[mode], pair, coordinates[part], stay, sizes[part])
    for single in range(flow.singles[mode]):
        rate, push = flow.rates[mode, single], flow.pushes[mode, single]
        q = coordinates[k]
        reach = min(stay, 1.0 / abs(rate)) if push == 0.0 and rate != 0.0 else stay
        sizes[k] = abs(q) + abs(rate * q + push) * reach
        if rate > 0.0:
            sizes[k] += abs(q + push / rate) * math.expm1(min(rate * stay, OVERFLOW))
        k += 1
    carry(flow, mode, coordinates, stay, coordinates)
    for i in range(n):
        total = abs(table[i, last])
        for j in range(count):
            total += abs(table[i, j]) * sizes[j]
        scale[i] = total
    apply(table, coordinates, state)


@inlined_kernel
def slopes_at(flow, mode, state, scale, guard):
    """First and second derivative of a guard at a state, each with the size below which it is rounding only."""
    n = state.size
    field = flow.field[mode]
    rate, bend, rate_size, bend_size = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        weight, weight_size = 0.0, 0.0  # of x_i in the rate: (gᵀ A)_i
        for j in range(n):
            weight += guard[j] * field[j, i]
            weight_size += abs(guard[j] * field[j, i])
        speed, speed_size = summed(field[i], state, scale)
        rate += guard[i] * speed
        rate_size += abs(guard[i]) * speed_size
        bend += weight * speed
        bend_size += weight_size * speed_size
    return rate, ROUNDING * rate_size, bend, ROUNDING * bend_size


@inlined_kernel
def in_modal_form(flow, mode, guard, out):
    """Write an affine function of the state (n + 1) as one of the modal coordinates (q + 1) to ``out``.

    A guard may have its modal form behind the n + 1 numbers, with digits that the sums here would lose.
    """
    table = flow.from_modal[mode]
    n, count = table.shape[0], out.size - 1
    if guard.size > n + 1:
        for j in range(count + 1):
            out[j] = guard[n + 1 + j]
        return
    for j in range(count):
        total = 0.0
        for i in range(n):
            total += guard[i] * table[i, j]
        out[j] = total
    total = guard[n]
    for i in range(n):
        total += guard[i] * table[i, table.shape[1] - 1]
    out[count] = total
