r"""The derivative of a motion with respect to its start: the flow of a mode, and the saltation matrix of an event.

In a mode x′ = A x + b, so that neighbours separate as e^{Aτ}. A neighbour meets the surface gᵀx + g₀ = 0 of an event
earlier or later; seen from event to event, with the field f before it and the affine reset x ↦ R x + r of the event,

    D = R (I − f gᵀ / gᵀf) e^{Aτ}

is the derivative of the state after the event with respect to that after the one before. Times and the field after the
event do not enter: the product over a period is the derivative of the Poincaré map, whose eigenvalues are the Floquet
multipliers without the trivial 1. (With it, the saltation matrix is R + (f⁺ − R f) gᵀ / gᵀf.) Release from rest of the
rigid drive has g = ±(1, 0) and f = (−Ω, 0), so that D is zero: a rest phase makes a cycle superstable.

Every matrix comes with a bound of its rounding, entry by entry.
"""

import math

import numpy as np

from lsvib.dynamics.kernels import saltation_taylor
from lsvib.engine.kernels import flow_planar
from lsvib.engine.kernels.flow_planar import EPS, OVERFLOW
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, by_kind, kernel
from lsvib.engine.kernels.layout import A0, A1, ACCUMULATION_KIND, GRAZE_KIND, B

_TERMS = 8.0  # most roundings in a term of a product of two matrices with up to five rows


@kernel
def _planar_flow(flow, mode, start, time, out, size):
    c, s, s_rate = flow_planar.responses(flow[mode], time)
    out[0, 0], out[0, 1], out[1, 0], out[1, 1] = c, s, -flow[mode, A0] * s, s_rate
    for i in range(2):
        for j in range(2):
            size[i, j] = abs(out[i, j])


@allocating_kernel
def _modal_flow(flow, mode, start, time, out, size):
    n, pairs, singles = out.shape[0], flow.pairs[mode], flow.singles[mode]
    into, back = flow.to_modal[mode], flow.from_modal[mode]
    carried = np.zeros((2 * pairs + singles, 2))  # of one column: its values and their sizes
    for j in range(n):
        for pair in range(pairs):
            k, row = 2 * pair, flow.oscillators[mode, pair]
            c, s, s_rate = flow_planar.responses(row, time)
            p, q, bent = into[k, j], into[k + 1, j], row[A0] * s
            carried[k, 0], carried[k, 1] = c * p + s * q, abs(c * p) + abs(s * q)
            carried[k + 1, 0], carried[k + 1, 1] = s_rate * q - bent * p, abs(s_rate * q) + abs(bent * p)
        for single in range(singles):
            k = 2 * pairs + single
            carried[k, 0] = math.exp(min(flow.rates[mode, single] * time, OVERFLOW)) * into[k, j]
            carried[k, 1] = abs(carried[k, 0])
        for i in range(n):
            out[i, j] = size[i, j] = 0.0
            for k in range(carried.shape[0]):
                out[i, j] += back[i, k] * carried[k, 0]
                size[i, j] += abs(back[i, k]) * carried[k, 1]


# The derivative of the state after a time by that at the start, e^{At} of a linear flow, and the sizes of the terms of
# its entries, both (n, n).
flow_matrix = by_kind(_planar_flow, _modal_flow, saltation_taylor.derivative)


@kernel
def _planar_field(flow, mode, state, rate, size):
    row = flow[mode]
    rate[0], size[0] = state[1], abs(state[1])
    rate[1] = row[B] - row[A0] * state[0] - row[A1] * state[1]
    size[1] = abs(row[B]) + abs(row[A0] * state[0]) + abs(row[A1] * state[1])


@kernel
def _modal_field(flow, mode, state, rate, size):
    n = state.size
    for i in range(n):
        rate[i], size[i] = flow.field[mode, i, n], abs(flow.field[mode, i, n])
        for j in range(n):
            rate[i] += flow.field[mode, i, j] * state[j]
            size[i] += abs(flow.field[mode, i, j] * state[j])


# x′ at a state, and the sizes of its terms, both (n).
field = by_kind(_planar_field, _modal_field, saltation_taylor.field)


@kernel
def crossed_guard(tables, mode, kind, after, before):
    """Return the guard of ``mode`` that an event of ``kind`` into the mode ``after`` belongs to; −1 if there is none.

    Of several it is the one whose surface is nearest to the state ``before`` the event: that one is met to rounding.
    """
    found, nearest = -1, math.inf
    for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
        transition, fits = tables.guard_transition[guard], False
        for branch in range(tables.branch_start[transition], tables.branch_start[transition + 1]):
            fits = fits or (tables.branch_mode[branch] == after and tables.branch_kind[branch] == kind)
        if not fits:
            continue
        row, n = tables.surfaces[tables.guard_surface[guard]], before.size
        value, size = row[n], abs(row[n])
        for i in range(n):
            value += row[i] * before[i]
            size += abs(row[i] * before[i])
        distance = abs(value) / size if size > 0.0 else 0.0
        if distance < nearest:
            found, nearest = guard, distance
    return found


@allocating_kernel
def _event(tables, mode, kind, after, before, out, lost):
    """Write R (I − f gᵀ / gᵀf) of an event that ends ``mode`` in the state ``before``, and its rounding; nan if none.

    There is none where the field only touches the surface, or infinitely many events end.
    """
    n = before.size
    f, f_size = np.empty(n), np.empty(n)
    field(tables.flow, mode, before, f, f_size)
    guard = -1 if kind == ACCUMULATION_KIND else crossed_guard(tables, mode, kind, after, before)
    normal = tables.surfaces[tables.guard_surface[max(guard, 0)]]
    speed, speed_size = 0.0, 0.0
    for i in range(n):
        speed += normal[i] * f[i]
        speed_size += abs(normal[i]) * f_size[i]
    known = guard >= 0 and 0.0 < speed * speed < math.inf  # an underflown square is what rounding leaves of a motion
    matrix, rounding = np.empty((n, n)), np.empty((n, n))
    for i in range(n):
        for j in range(n):
            across, unit = f[i] * normal[j], 1.0 if i == j else 0.0
            matrix[i, j] = unit - across / speed if known else math.nan
            # The quotient's own rounding, that of its parts, and of the difference in gᵀf.
            part = f_size[i] * abs(normal[j]) / abs(speed) + abs(across) * speed_size / (speed * speed)
            rounding[i, j] = _TERMS * EPS * (part + abs(matrix[i, j])) if known else math.nan
    reset = tables.transition_reset[tables.guard_transition[max(guard, 0)]]
    for i in range(n):
        for j in range(n):
            out[i, j], lost[i, j] = matrix[i, j], rounding[i, j]
            if reset >= 0:
                out[i, j] = lost[i, j] = 0.0
                for k in range(n):
                    out[i, j] += tables.resets[reset, i, k] * matrix[k, j]
                    lost[i, j] += abs(tables.resets[reset, i, k]) * rounding[k, j]


@kernel
def _then(matrix, lost, total, total_lost, room):
    """Replace the product ``total`` by ``matrix`` @ ``total``, and its rounding likewise."""
    n = matrix.shape[0]
    for j in range(n):
        for i in range(n):
            value, size, rounding = 0.0, 0.0, 0.0
            for k in range(n):
                value += matrix[i, k] * total[k, j]
                size += abs(matrix[i, k] * total[k, j])
                rounding += lost[i, k] * abs(total[k, j]) + abs(matrix[i, k]) * total_lost[k, j]
            room[i, 0], room[i, 1] = value, rounding + _TERMS * EPS * size
        for i in range(n):
            total[i, j], total_lost[i, j] = room[i, 0], room[i, 1]


@allocating_entry
def derivative(tables, mode, start, state, times, kinds, modes, before, after, total, lost):
    """Write the derivative (n, n) of the state after the last event by the start, and a bound (n, n) of its rounding.

    Arguments: mode, time [s] and state (n) of the start; times, kinds, modes after, and states before and after the
    events (k). Entries are nan if an event has no derivative. The start's own mode is kept: neighbours start in it.
    """
    n = before.shape[1]
    matrix, rounding, room = np.empty((n, n)), np.empty((n, n)), np.empty((n, 2))
    for i in range(n):
        for j in range(n):
            total[i, j], lost[i, j] = 1.0 if i == j else 0.0, 0.0
    for k in range(times.size):
        begin = after[k - 1] if k > 0 else state
        flow_matrix(tables.flow, mode, begin, times[k] - start, matrix, rounding)
        for i in range(n):
            for j in range(n):
                rounding[i, j] *= _TERMS * EPS
        _then(matrix, rounding, total, lost, room)
        if kinds[k] != GRAZE_KIND:
            _event(tables, mode, kinds[k], modes[k], before[k], matrix, rounding)
            _then(matrix, rounding, total, lost, room)
        mode, start = modes[k], times[k]
