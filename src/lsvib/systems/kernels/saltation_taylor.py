"""The derivative of a stay in a mode with respect to its start, where friction depends on speed, and the field there.

Neighbours separate by y′ = (P + η d qᵀ + q₀ (dη/dσ) d σᵀ) y along the motion, whose coefficients are power series on
each step of :mod:`lsvib.systems.kernels.flow_taylor`; so is y.
"""

import numpy as np

from lsvib.systems.kernels import flow_taylor
from lsvib.systems.kernels.flow_taylor import CONTACT, ETA, MU, POWER, REST, SLOPE, STEEP, product
from lsvib.systems.kernels.jit import allocating_kernel, inlined_kernel, kernel
from lsvib.systems.kernels.layout import ORDER


@kernel
def field(flow, mode, state, rate, size):
    """Write x′ at a state, and the sizes of its terms, both (n)."""
    flow_taylor.field_at(flow, mode, state, state, rate, size)


@inlined_kernel
def _steepness(flow, mode, piece, parts):
    """Write the series of q dη/dσ = q μ′ (1 − B η)² from those of the step."""
    feedback, slope, rest = flow.feedback[mode], parts[SLOPE], parts[REST]
    flow_taylor.find_share(flow, mode, parts)
    flow_taylor.slope_of_law(flow.pieces[piece], parts, slope)
    for k in range(ORDER):
        rest[k] = (1.0 if k == 0 else 0.0) - feedback * parts[ETA, k]
    for k in range(ORDER):  # products in place, from the highest power down
        parts[STEEP, k] = product(rest, rest, 0, k)
    for k in range(ORDER - 1, -1, -1):
        slope[k] = product(slope, parts[STEEP], 0, k)
    for k in range(ORDER - 1, -1, -1):
        parts[STEEP, k] = product(slope, parts[CONTACT], 0, k)


@kernel
def _carry(flow, mode, piece, series, column, step, total, room):
    """Multiply a column of ``total`` (n, n) by the derivative of a step, whose series are known."""
    n, parts, unit = series.here.size, series.parts, series.unit[0]
    for i in range(n):
        room[i, 0] = total[i, column]
    sigma, contact = parts[POWER], parts[MU]  # are not needed any more
    for k in range(ORDER):
        pushed = 0.0
        if piece >= 0:
            sigma[k] = contact[k] = 0.0
            for i in range(n):
                sigma[k] += flow.speed[mode, i] * room[i, k]
                contact[k] += flow.contact[mode, i] * room[i, k]
            pushed = product(parts[ETA], contact, 0, k) + product(parts[STEEP], sigma, 0, k)
        for i in range(n):
            value = flow.push[mode, i] * pushed
            for j in range(n):
                value += flow.field[mode, i, j] * room[j, k]
            room[i, k + 1] = unit * value / (k + 1)
    for i in range(n):
        total[i, column] = flow_taylor.value_at(room[i], step / unit)


@allocating_kernel
def derivative(flow, mode, state, t, out, size):
    """Write the derivative (n, n) of the state after a time t [s] in ``mode`` by ``state``, and sizes of its terms."""
    n = state.size
    series, room = flow_taylor.series_for(n), np.empty((n, ORDER + 1))
    flow_taylor.begin(state, series)
    piece, passed, steps = flow_taylor.piece_at(flow, mode, state), 0.0, 0
    for i in range(n):
        for j in range(n):
            out[i, j] = 1.0 if i == j else 0.0
            size[i, j] = 0.0
    while passed < t:
        step, following = flow_taylor.take_step(flow, mode, piece, series, t - passed)
        if piece >= 0:
            _steepness(flow, mode, piece, series.parts)
        for column in range(n):
            _carry(flow, mode, piece, series, column, step, out, room)
        flow_taylor.note_sizes(series, step)
        flow_taylor.go_on(series, step)
        for i in range(n):
            for j in range(n):
                size[i, j] = max(size[i, j], abs(out[i, j]))
        if not passed + step > passed:
            break
        passed, piece, steps = passed + step, following, steps + 1
    for i in range(n):
        for j in range(n):
            size[i, j] *= 1.0 + 0.1 * steps
