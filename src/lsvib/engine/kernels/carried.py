"""Guards that are faint beside their terms, carried from arc to arc.

A state holds w = θ′ − Ω and not θ′. A speed of slip of 10⁻¹⁰ Ω therefore has six digits in it, and where nothing but
this speed decides when slip ends, as with a heavy nut, the event is late by 10⁻⁷ of the motion. What changes a guard
during an arc is as small as the guard itself (:func:`lsvib.engine.kernels.flow_modal.change`). So at the end of an arc
the guards that the state does not hold are noted as their value at its start and this change; or as the sum of their
parts, if that is closer because the parts have died away; or without what it has in common with the guard that has
fired. At the next search such a guard begins with this value.

Only modal flows note anything; ``work`` is the :class:`lsvib.engine.kernels.guard_sums.Sums` of the run.
"""

import math

from lsvib.engine.kernels import flow_modal
from lsvib.engine.kernels.affine import apply, level
from lsvib.engine.kernels.columns import A0, ALPHA, BETA, R2
from lsvib.engine.kernels.flow_planar import ROUNDING
from lsvib.engine.kernels.jit import inlined_kernel, kernel

FAINT = 2.0**-30  # The rounding of a faint guard is more than this part of it, as nine digits of an event are wanted.


@inlined_kernel
def note(flow, tables, mode, guard, stay, state, scale, work):
    """Note the guards of ``mode`` that are faint at ``state``, after a stay [s] that ended where ``guard`` fired.

    ``work.states`` is as :func:`lsvib.engine.kernels.flow_modal.travel` has left it.
    """
    first, last = tables.guard_start[mode], tables.guard_start[mode + 1]
    count, moved = 0, False
    for other in range(first, last):
        surface = tables.guard_surface[other]
        value, size = 0.0, 0.0
        if other != guard:
            value, size = level(tables.surfaces[surface], state, scale)
            if size <= FAINT * abs(value):
                continue
            if not moved:
                _move(flow, mode, stay, state.size, work)
                moved = True
            value, size = _moved(
                flow, tables, mode, other, work.starts[other - first], work.doubts[other - first], stay, work
            )
            value *= tables.guard_sign[other]
            less, rest = _beside(tables.surfaces[tables.guard_surface[guard]], tables.surfaces[surface], state, scale)
            if rest < size:
                value, size = less, rest
        work.noted[count, 0], work.noted[count, 1], work.noted[count, 2] = surface, value, size
        count += 1
    work.noted[work.noted.shape[0] - 1, 0] = count


@kernel
def _move(flow, mode, stay, n, work):
    """Write the modal state before an arc, its changes, and their sizes to rows 1, 3 and 4 of ``work.states``."""
    size = flow_modal.size_of(flow, mode)
    start = work.states[1, :size]
    apply(flow.to_modal[mode], work.states[2, :n], start)
    flow_modal.change(flow, mode, start, stay, work.states[3, :size], work.states[4, :size])


@kernel
def _moved(flow, tables, mode, guard, start, doubt, stay, work):
    """Return a guard after an arc, and its rounding, from both at the start of the arc."""
    size, k = flow_modal.size_of(flow, mode), 2 * flow.pairs[mode]
    end, before, moves, sizes = work.states[0], work.states[1], work.states[3], work.states[4]
    form = work.form[: size + 1]
    if tables.guard_parts.shape[1] > 0:
        for j in range(size + 1):
            form[j] = tables.guard_parts[guard, j]
    else:
        flow_modal.in_modal_form(flow, mode, tables.surfaces[tables.guard_surface[guard]], form)
        for j in range(size + 1):
            form[j] *= tables.guard_sign[guard]
    value, total, summed, terms = start, 0.0, form[size], abs(form[size])
    for j in range(size):
        value += form[j] * moves[j]
        total += abs(form[j]) * sizes[j]
        summed += form[j] * end[j]
    for pair in range(flow.pairs[mode]):
        oscillator, u, w = flow.oscillators[mode, pair], abs(end[2 * pair]), abs(end[2 * pair + 1])
        turn = math.sqrt(abs(oscillator[A0]))
        fastest = max(abs(oscillator[ALPHA]) + oscillator[BETA], abs(oscillator[R2]))
        known = 1.0 + fastest * stay  # The exponent and the phase are as large, and are rounded.
        if turn > 0.0:
            terms += known * (abs(form[2 * pair]) * (u + w / turn) + abs(form[2 * pair + 1]) * (w + u * turn))
        else:
            terms = math.inf
    for single in range(flow.singles[mode]):
        known = 1.0 + abs(flow.rates[mode, single]) * stay
        if flow.pushes[mode, single] != 0.0:
            terms += abs(form[k] * before[k])
        terms += known * abs(form[k] * end[k])
        k += 1
    total, terms = doubt + ROUNDING * total, ROUNDING * terms
    return (value, total) if total <= terms else (summed, terms)


@kernel
def _beside(zero, row, state, scale):
    """Return an affine function, given by its row, on the zero set of another one, and its rounding.

    Terms that both share are cancelled.
    Where slip ends, the speed of the screw is that of the nut, which may be small, and not w + Ω. That is known if both
    functions have the same weight, or its negative, on the coordinate that the state has been moved by.
    """
    n, chosen = state.size, 0
    for i in range(n):
        if abs(zero[i]) * scale[i] > abs(zero[chosen]) * scale[chosen]:
            chosen = i
    if row[chosen] == 0.0 or abs(row[chosen]) != abs(zero[chosen]):
        return 0.0, math.inf
    factor, value, size = row[chosen] / zero[chosen], 0.0, 0.0
    for i in range(n + 1):
        one, other = row[i], factor * zero[i]
        if one != other:  # what only one of them holds has its digits
            x, terms = (state[i], scale[i]) if i < n else (1.0, 1.0)
            value += (one - other) * x
            size += (abs(one) + abs(other)) * terms
    return value, ROUNDING * size


@inlined_kernel
def note_at_once(flow, tables, guard, work):
    """Note that a guard is zero that has fired at once; what was noted stays."""
    last, surface = work.noted.shape[0] - 1, tables.guard_surface[guard]
    count = int(work.noted[last, 0])
    place = count
    for k in range(count):
        if work.noted[k, 0] == surface:
            place = k
    if place < last:
        work.noted[place, 0], work.noted[place, 1], work.noted[place, 2] = surface, 0.0, 0.0
        work.noted[last, 0] = max(count, place + 1)


@inlined_kernel
def forget(flow, work):
    """Forget what was noted, where an impulse has changed the speeds."""
    work.noted[work.noted.shape[0] - 1, 0] = 0.0


@inlined_kernel
def put_as_noted(flow, tables, reset, state, work):
    """Set coordinates that a reset has made equal to a noted guard, as the nut's speed where it comes to that of the
    screw, to what was noted; it differs by rounding only."""
    n = state.size
    for k in range(int(work.noted[work.noted.shape[0] - 1, 0])):
        surface = tables.surfaces[int(work.noted[k, 0])]
        for i in range(n):
            same = True
            for j in range(n + 1):
                same = same and tables.resets[reset, i, j] == surface[j]
            if same:
                state[i] = work.noted[k, 1]


@inlined_kernel
def recalled(flow, surface, sign, value, size, work):
    """Return the noted value of a guard and its rounding. The value is NaN if the state alone determines the guard
    equally well.

    ``value`` and ``size`` are the guard and its rounding by the state; a guard on its surface has no rounding.
    """
    known, doubt = math.nan, 0.0 if value <= size else size
    if size > FAINT * abs(value):
        for k in range(int(work.noted[work.noted.shape[0] - 1, 0])):
            noted, rest = sign * work.noted[k, 1], work.noted[k, 2]
            if work.noted[k, 0] == surface and rest < size and abs(noted - value) <= size:
                return (noted, rest) if noted > rest else (known, doubt)
    return known, doubt


@inlined_kernel
def begin(flow, guard, known, doubt, work):
    """Set the value and the rounding with which a guard begins the next search; NaN: compute it from the state."""
    work.known[guard], work.doubts[guard] = known, doubt


@kernel
def take_up(flow, clock, work):
    """Take up what a run before this one has left behind the fourth entry of ``clock``."""
    rows = work.noted.shape[0]
    work.noted[rows - 1, 0] = 0.0
    if clock.size == 4 + 3 * rows:
        for k in range(rows):
            for i in range(3):
                work.noted[k, i] = clock[4 + 3 * k + i]
        clock[1 + 3 * rows] = 0.0


@kernel
def leave_behind(flow, clock, work):
    """Leave behind the fourth entry of ``clock`` what a run that goes on after this one takes up."""
    rows = work.noted.shape[0]
    if clock.size == 4 + 3 * rows:
        for k in range(rows):
            for i in range(3):
                clock[4 + 3 * k + i] = work.noted[k, i]
