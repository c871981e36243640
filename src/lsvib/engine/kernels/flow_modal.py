"""Closed-form flow of a mode with any number of states, as a sum of oscillators and exponentials.

A linear mode x′ = A x + b splits into modal coordinates, y = W x + w₀, x = V y + v₀: *pairs* (u, w = u′), each an
oscillator of :mod:`lsvib.engine.kernels.flow_planar` without force, for two complex or two neighbouring real rates, so
that nothing is special where the two coincide; and *singles* q′ = r q + f, one for each rate that is alone. A single
with f ≠ 0 is one whose equilibrium lies far away, or nowhere (r = 0), and is carried without it:

    f = 0:  q(t) = q₀ e^{rt}            f ≠ 0:  q(t) = q₀ + (r q₀ + f) ∫₀ᵗ e^{rτ} dτ

Where a coordinate is the small difference of large terms, as an angle of 10⁻¹⁰ rad beside an equilibrium at 10² rad, or
one of modal coordinates that are 10⁶ times as large, it is moved by the change of the modal state (:func:`_displace`).

An affine function of the state, such as a guard, is a sum over pairs and singles, and so is every derivative of it:
:mod:`lsvib.engine.kernels.guard_sums`.
"""

import math

import numpy as np

from lsvib.engine.kernels import flow_planar
from lsvib.engine.kernels.affine import apply
from lsvib.engine.kernels.columns import A0, A1, ALPHA, BETA, DELTA, R1, TIME_SCALE
from lsvib.engine.kernels.flow_planar import OVERFLOW, ROUNDING, own_rate
from lsvib.engine.kernels.jit import allocating_entry, inlined_kernel, kernel

FAR = 2.0**14  # terms of a coordinate, in sizes of itself, beside which it would lose four digits
_GAIN = 16.0  # by so much the terms must change less than they are: where a pair has turned, it gives them anew
ROWS = 6  # of the scratch space of :func:`travel`


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


@kernel
def change(flow, mode, start, t, out, sizes):
    """Write the change of the modal state within a time t [s] to ``out``; it has its own digits however small it is.

    With S and J = ∫S of a pair, u(t) − u₀ = w₀ S − a₀ u₀ J and w(t) − w₀ = −w₀ (a₁ S + a₀ J) − a₀ u₀ S. ``sizes`` get
    the largest sizes of these terms up to then: after a whole turn S and J are zero, and known to no more than that.
    """
    k = 0
    for pair in range(flow.pairs[mode]):
        row = flow.oscillators[mode, pair]
        u, w = start[k], start[k + 1]
        _, s, _, _, _, _ = responses(row, t)
        integral = flow_planar.integrated_response(row, t)
        out[k] = w * s - row[A0] * u * integral
        out[k + 1] = -w * (row[A1] * s + row[A0] * integral) - row[A0] * u * s
        grown = math.exp(min(own_rate(row) * t, OVERFLOW)) if own_rate(row) > 0.0 else 1.0
        a0, a1 = abs(row[A0]), abs(row[A1])
        most = max(abs(s), grown * t / (1.0 + (math.sqrt(a0) + a1) * t))
        area = max(abs(integral), min(most * t, 2.0 * grown / a0))
        sizes[k] = abs(w) * most + a0 * abs(u) * area
        sizes[k + 1] = abs(w) * (a1 * most + a0 * area) + a0 * abs(u) * most
        k += 2
    for single in range(flow.singles[mode]):
        rate, push = flow.rates[mode, single], flow.pushes[mode, single]
        integral = math.expm1(min(rate * t, OVERFLOW)) / rate if rate != 0.0 else t
        out[k] = (rate * start[k] + push) * integral
        sizes[k] = (abs(rate * start[k]) + abs(push)) * integral
        k += 1


@inlined_kernel
def _put_together(flow, mode, coordinates, before, state):
    """Write the state of modal coordinates to ``state`` (n).

    Returns whether one of its coordinates is small, both there and ``before`` (n), beside the terms that it is made of.
    """
    table, far = flow.from_modal[mode], False
    last = table.shape[1] - 1
    for i in range(state.size):
        total, size = table[i, last], 0.0
        for j in range(coordinates.size):
            part = table[i, j] * coordinates[j]
            total += part
            size += abs(part)
        state[i] = total
        far = far or size > FAR * max(abs(before[i]), abs(total))
    return far


@kernel
def _displace(flow, mode, before, t, state, scale, room):
    """Form those coordinates of ``state`` anew that are small beside their terms, and their sizes in ``scale`` (n).

    ``before`` (n) is the state a time t [s] earlier; ``room`` is that of :func:`travel`, with the modal coordinates of
    ``state`` in its first row, and ``before`` may be the third. Where the terms have changed by their own size there
    is nothing to gain.
    """
    n, count, table = state.size, size_of(flow, mode), flow.from_modal[mode]
    end, start, moves, sizes, chosen = room[0, :count], room[1, :count], room[3, :count], room[4, :count], room[5, :n]
    any_chosen, k = False, 2 * flow.pairs[mode]
    for pair in range(flow.pairs[mode]):
        row = flow.oscillators[mode, pair]
        turned = min(1.0, t / row[TIME_SCALE] + abs(row[A1]) * t)
        moves[2 * pair], moves[2 * pair + 1] = abs(end[2 * pair]) * turned, abs(end[2 * pair + 1]) * turned
    for single in range(flow.singles[mode]):
        moves[k] = min(abs(end[k]), abs(flow.rates[mode, single] * end[k] + flow.pushes[mode, single]) * t)
        k += 1
    for i in range(n):
        terms, changes = 0.0, 0.0
        for j in range(count):
            terms += abs(table[i, j] * end[j])
            changes += abs(table[i, j]) * moves[j]
        small = terms > FAR * max(abs(before[i]), abs(state[i])) and terms > _GAIN * changes
        chosen[i], any_chosen = 1.0 if small else 0.0, any_chosen or small
    if not any_chosen:
        return
    apply(flow.to_modal[mode], before, start)
    change(flow, mode, start, t, moves, sizes)
    for i in range(n):
        total, size = before[i], abs(before[i])
        for j in range(count):
            total += table[i, j] * moves[j]
            size += abs(table[i, j]) * sizes[j]
        if chosen[i] > 0.0 and math.isfinite(total):
            state[i], scale[i] = total, size


@allocating_entry
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    n, count = state.size, size_of(flow, mode)
    room = np.empty((ROWS + 1, max(n, count)))
    coordinates, before = room[0, :count], room[2, :n]
    for i in range(n):
        before[i] = state[i]
    apply(flow.to_modal[mode], state, coordinates)
    carry(flow, mode, coordinates, t, coordinates)
    if _put_together(flow, mode, coordinates, before, out):
        _displace(flow, mode, before, t, out, room[ROWS, :n], room)


@inlined_kernel
def travel(flow, mode, state, stay, scale, room):
    """Replace ``state`` by the one after a stay [s] in ``mode``, and write to ``scale`` (n) the sizes of its terms.

    ``room`` (ROWS, q and n or more) is scratch space.
    """
    n, count, last = state.size, size_of(flow, mode), flow.from_modal.shape[2] - 1
    coordinates, sizes, before, table = room[0, :count], room[1, :count], room[2, :n], flow.from_modal[mode]
    for i in range(n):
        before[i] = state[i]
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
    if _put_together(flow, mode, coordinates, before, state):
        _displace(flow, mode, before, stay, state, scale, room)


@inlined_kernel
def is_still(flow, mode, state):
    """Whether a state is an equilibrium of a mode to the last bit; where N is zero there a guard rests on zero."""
    field, n = flow.field[mode], state.size
    for i in range(n):
        rate = field[i, n]
        for j in range(n):
            rate += field[i, j] * state[j]
        if rate != 0.0:
            return False
    return True


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
        speed, speed_size = field[i, n], abs(field[i, n])
        for j in range(n):
            speed += field[i, j] * state[j]
            speed_size += abs(field[i, j]) * scale[j]
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
