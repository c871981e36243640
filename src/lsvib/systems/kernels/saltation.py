r"""The derivative of a motion with respect to its start: the flow of a mode, and the saltation matrix of an event.

In a mode x′ = A x + b, so that neighbours separate as e^{Aτ}. A neighbour meets the surface gᵀx + g₀ = 0 of an event
earlier or later; seen from event to event, with the field f before it and the affine reset x ↦ R x + r of the event,

    D = R (I − f gᵀ / gᵀf) e^{Aτ}

is the derivative of the state after the event with respect to that after the one before. Times and the field after the
event do not enter: the product over a period is the derivative of the Poincaré map, whose eigenvalues are the Floquet
multipliers without the trivial 1. (With it, the saltation matrix is R + (f⁺ − R f) gᵀ / gᵀf.) Release from rest with
two states has g = ±(1, 0) and f = (−Ω, 0), so that D is zero: a rest phase makes a cycle superstable.

Every matrix comes with a bound of its rounding, entry by entry.
"""

import math

from lsvib.systems.kernels.flow_planar import EPS, summed
from lsvib.systems.kernels.jit import entry, kernel, on_stack
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.systems.kernels.machine import derivative_at
from lsvib.systems.kernels.single_mode import field

_APART = 1e4  # in roundings, by which two fields that should be one differ for another reason
_TERMS = 8.0  # most roundings in a term of a product of two matrices with up to five rows


@entry
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
        value, size = summed(tables.surfaces[tables.guard_surface[guard]], before, before)
        distance = abs(value) / size if size > 0.0 else 0.0
        if distance < nearest:
            found, nearest = guard, distance
    return found


@kernel
def _event(tables, mode, kind, after, before, carried, unsure, out, lost):
    """Write R (I − f gᵀ / gᵀf) of an event that ends ``mode`` in the state ``before``, and its rounding; nan if none.

    f is also what the flow makes of the field at its start, ``carried`` (n), which is ``unsure`` (n) by rounding. Where
    a motion jams f grows without bound, and within the last place of a time both differ: what goes with
    the derivative of the flow is then the field that it carries.

    There is none where the field only touches the surface, or infinitely many events end.
    """
    n = before.size
    f, f_size = on_stack(n), on_stack(n)
    field(tables.flow, mode, before, f, f_size)
    differ = False
    for i in range(n):
        differ = differ or abs(carried[i] - f[i]) > _APART * (unsure[i] + EPS * f_size[i])
    for i in range(n):
        if differ:
            f[i], f_size[i] = carried[i], max(abs(carried[i]), unsure[i] / EPS)
    guard = -1 if kind == ACCUMULATION_KIND else crossed_guard(tables, mode, kind, after, before)
    normal = tables.surfaces[tables.guard_surface[max(guard, 0)]]
    speed, speed_size = 0.0, 0.0
    for i in range(n):
        speed += normal[i] * f[i]
        speed_size += abs(normal[i]) * f_size[i]
    known = guard >= 0 and 0.0 < speed * speed < math.inf  # an underflown square is what rounding leaves of a motion
    matrix, rounding = on_stack((n, n)), on_stack((n, n))
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
def _then(matrix, lost, unit, total, total_lost, room):
    """Replace the product ``total`` by ``matrix`` @ ``total``, and its rounding likewise; ``lost`` is in a unit."""
    n = matrix.shape[0]
    for j in range(n):
        for i in range(n):
            value, size, rounding = 0.0, 0.0, 0.0
            for k in range(n):
                value += matrix[i, k] * total[k, j]
                size += abs(matrix[i, k] * total[k, j])
                rounding += unit * lost[i, k] * abs(total[k, j]) + abs(matrix[i, k]) * total_lost[k, j]
            room[i, 0], room[i, 1] = value, rounding + _TERMS * EPS * size
        for i in range(n):
            total[i, j], total_lost[i, j] = room[i, 0], room[i, 1]


@entry
def derivative(flow_derivative, tables, begin, events, total, lost):
    """Write the derivative (n, n) of the state after the last event by the start, and a bound (n, n) of its rounding.

    Arguments: the address of ``machine.derivative``; where the motion begins; its events. Entries are nan if an event
    has no derivative. The start's own mode is kept: neighbours start in it.
    """
    n, mode, start, times = begin.state.size, begin.mode, begin.time, events.time
    matrix, rounding, room = on_stack((n, n)), on_stack((n, n)), on_stack((n, 2))
    begins, carried, unsure = on_stack(n), on_stack(n), on_stack(n)
    for i in range(n):
        for j in range(n):
            total[i, j], lost[i, j] = 1.0 if i == j else 0.0, 0.0
    for k in range(times.size):
        state = events.after[k - 1] if k > 0 else begin.state
        derivative_at(flow_derivative, tables.flow, mode, state, times[k] - start, matrix, rounding)
        _then(matrix, rounding, _TERMS * EPS, total, lost, room)
        if events.kind[k] != GRAZE_KIND:
            field(tables.flow, mode, state, begins, unsure)  # sizes of its terms, which are not asked
            for i in range(n):
                carried[i] = unsure[i] = 0.0
                for j in range(n):
                    carried[i] += matrix[i, j] * begins[j]
                    unsure[i] += _TERMS * EPS * (rounding[i, j] + abs(matrix[i, j])) * abs(begins[j])
            _event(tables, mode, events.kind[k], events.mode[k], events.before[k], carried, unsure, matrix, rounding)
            _then(matrix, rounding, 1.0, total, lost, room)
        mode, start = events.mode[k], times[k]
