"""The certain search for the first guard that fires in a mode whose flow is a series of steps.

On a step the guard is a polynomial g of the part τ of the step, whose last terms are rounding. Its coefficients in
Bernstein's form on an interval bound it there: all positive, no root; one change of sign, one root; otherwise the
interval is halved, so that no root of the polynomial is passed over. An interval on which the guard does not leave its
rounding is where it touches zero.
"""

import math

import numpy as np

from lsvib.systems.kernels import flow_taylor
from lsvib.systems.kernels.flow_planar import EPS, summed
from lsvib.systems.kernels.flow_taylor import ETA, affine, begin, go_on, piece_at, series_for, take_step, value_at
from lsvib.systems.kernels.jit import allocating_kernel, inlined_kernel, kernel
from lsvib.systems.kernels.layout import CROSSING, GRAZE, LOST, NONE, ORDER

_SHARES = np.array([1.0 / math.comb(ORDER, k) for k in range(ORDER + 1)])  # 1 over the binomial coefficients
_FINEST = 2.0**-40  # part of a step on which a guard that is still undecided touches zero
# Steps below the rounding of the time, one after the other, in which a guard may still be reached: so it is where the
# acceleration grows without bound before Γ₊ = 0.
_STALLED = 256


@allocating_kernel
def room_for(flow, guards):
    """Return the scratch space of a search for any number of guards, with steps without end."""
    return series_for(flow.push.shape[1])


@inlined_kernel
def _stays_positive(series, guard):
    """Whether a guard is positive on the whole step, by the bounds of the coordinates alone."""
    n = series.here.size
    least, size = guard[n], abs(guard[n])
    for i in range(n):
        low, high = guard[i] * series.spans[i, 0], guard[i] * series.spans[i, 1]
        least += guard[i] * series.here[i] + min(low, high)
        size += abs(guard[i]) * series.sizes[i]
    return least > 8.0 * EPS * size


@inlined_kernel
def _form(series, guard, step):
    """Write a guard as a polynomial of the part of the step; returns the size below which it is rounding only."""
    power = 1.0
    for k in range(ORDER + 1):
        series.guard[k] = affine(guard, series.state, k, series.here.size) * power
        power *= step / series.unit[0]
    return 8.0 * EPS * summed(guard, series.here, series.sizes)[1]


@kernel
def _into_bernstein(form, start, width, local):
    """Write a polynomial in Bernstein's form on [start, start + width] to ``local``."""
    last = form.size - 1
    for k in range(last + 1):
        local[k] = form[k]
    for i in range(last if start > 0.0 else 0):
        for k in range(last - 1, i - 1, -1):
            local[k] += start * local[k + 1]
    power = 1.0
    for k in range(last + 1):
        local[k] *= power * _SHARES[k]
        power *= width
    for i in range(1, last + 1):
        for k in range(last, i - 1, -1):
            local[k] += local[k - 1]


@kernel
def _root(form, low, high, share):
    """Return the root of a polynomial that falls from ``low``, where it is positive, to ``high``, where it is not.

    ``share`` of the way is where a straight line between the two values has its root.
    """
    t = low + share * (high - low)
    for _ in range(200):  # each of them halves the bracket at least, or comes from Newton's method
        value = slope = 0.0
        for k in range(form.size - 1, -1, -1):
            slope = slope * t + value
            value = value * t + form[k]
        if value > 0.0:
            low = t
        else:
            high = t
        new = t - value / slope if slope < 0.0 else math.nan
        if new == t or not low < high:
            return t
        if not low < new < high:
            new = 0.5 * (low + high)
            if new in (low, high):
                return high
        t = new
    return t


@kernel
def first_fall(form, on_surface, rounding, top, local):
    """Find the first τ in [0, top], top ≤ 1, at which a polynomial falls through zero or touches it from above.

    Arguments: coefficients in ascending order; whether it is zero at τ = 0, and does not fall there; size of it that
    is rounding; scratch space. Returns (``Found``, τ).
    """
    if on_surface:  # of g = τ^k p only p matters; as it does not fall, what is negative of the first orders is rounding
        for _ in range(3):
            for k in range(form.size - 1):
                form[k] = form[k + 1]
            form[form.size - 1] = 0.0
            if form[0] > (0.0 if form[1] < -rounding else rounding):  # before what falls, a little is a rise
                break
    least = form[0]
    for k in range(1, form.size):
        least += min(form[k], 0.0)
    if least > 0.0:
        return NONE, top
    if form[0] <= 0.0:  # what rests on zero to all these orders does not fall
        return (NONE, top) if on_surface and form[0] >= -rounding else (CROSSING, 0.0)
    start, width = 0.0, top
    while start < top:
        _into_bernstein(form, start, width, local)
        changes, largest = 0, abs(local[0])
        for k in range(1, local.size):
            changes += (local[k] > 0.0) != (local[k - 1] > 0.0)
            largest = max(largest, abs(local[k]))
        if changes == 0 and local[0] > 0.0:
            start += width
            width = min(2.0 * width, top - start)
        elif local[0] <= 0.0:
            return CROSSING, start
        elif changes == 1:
            return CROSSING, _root(form, start, start + width, local[0] / (local[0] - local[local.size - 1]))
        elif width < _FINEST or largest <= rounding:
            return (CROSSING if local[local.size - 1] < -rounding else GRAZE), start + 0.5 * width
        else:
            width *= 0.5
    return NONE, top


@inlined_kernel
def _rests(series, guard):
    """Whether a guard that began on zero is still there: that of a contact without a force, while its bodies stand."""
    value, size = summed(guard, series.here, series.sizes)
    return abs(value) <= 8.0 * EPS * size


@inlined_kernel
def _moves(series):
    """Whether a state moves at all."""
    moves = False
    for i in range(series.here.size):
        moves = moves or series.state[i, 1] != 0.0
    return moves


@kernel
def search(flow, mode, state, guards, on_surface, limit, work):
    """Find the first of several guards that falls through zero, or touches it from above, within ``limit`` [s].

    Arguments and what is returned are those of :func:`lsvib.systems.kernels.search_modal.search`.
    """
    begin(state, work)
    piece, passed, stalled = piece_at(flow, mode, state), 0.0, 0
    while passed < limit:
        # passages beside the point of rest, which are many, say nothing
        if flow_taylor.is_settled(flow, mode, work.here):
            return NONE, -1, limit
        work.steps[0] -= 1.0
        step, following = take_step(flow, mode, piece, work, limit - passed)
        if not _moves(work):
            return NONE, -1, limit
        if work.steps[0] < 0.0 or not 0.0 < step < 1e300:
            return LOST, -1, limit
        flow_taylor.note_sizes(work, step)
        found, first, top = NONE, -1, 1.0
        for guard in range(guards.shape[0]):
            if not on_surface[guard] and _stays_positive(work, guards[guard]):
                continue
            rounding = _form(work, guards[guard], step)
            outcome, part = first_fall(work.guard, on_surface[guard], rounding, top, work.local)
            if outcome != NONE:
                found, first, top = outcome, guard, part
        if found != NONE:
            work.place[0] = top * step
            return found, first, passed + top * step
        stalled = 0 if passed + step > passed else stalled + 1
        if stalled > _STALLED:
            return LOST, -1, limit
        go_on(work, step)
        passed, piece = passed + step, following
        for guard in range(guards.shape[0]):
            on_surface[guard] = on_surface[guard] and _rests(work, guards[guard])
    return NONE, -1, limit


@inlined_kernel
def _functional(flow, mode, piece, series, functional):
    """Write the series of an affine function, and of η times another one that stands behind it, to ``series.guard``."""
    n = series.here.size
    for k in range(ORDER + 1):
        series.guard[k] = affine(functional, series.state, k, n)
    if functional.size == n + 1 or piece < 0:
        return
    flow_taylor.find_share(flow, mode, series.parts)
    for k in range(ORDER):  # η is known to one order less
        for j in range(k + 1):
            series.guard[k] += series.parts[ETA, j] * affine(functional[n + 1 :], series.state, k - j, n)
    series.guard[ORDER] = 0.0


@allocating_kernel
def _extremes_on_step(form, step, low, high, local):
    """Return the bounds low and high widened to hold a polynomial (ascending) on a step, in its unit of the time."""
    slope, power, last = np.empty(form.size), 1.0, form.size - 1
    for k in range(form.size):
        form[k] *= power
        power *= step
    here, begun, size = 0.0, False, 0.0
    for k in range(form.size):
        size += abs(form[k])
    while True:
        value = value_at(form, here)
        low, high = min(low, value), max(high, value)
        for k in range(last + 1):
            slope[k] = form[k]
        for i in range(last):
            for k in range(last - 1, i - 1, -1):
                slope[k] += here * slope[k + 1]
        for k in range(last):
            slope[k] = (k + 1) * slope[k + 1]
        slope[last] = 0.0
        rounding, sign = 64.0 * EPS * size, 1.0
        if begun:  # at a root of the derivative the next order decides
            slope[0], sign = 0.0, math.copysign(1.0, slope[1])
        elif slope[0] < 0.0:
            sign = -1.0
        for k in range(last + 1):
            slope[k] *= sign
        found, part = first_fall(slope, begun, rounding, 1.0, local)
        if found == NONE or not here < here + part < 1.0:
            break
        here, begun = here + part, True
    value = value_at(form, 1.0)
    return min(low, value), max(high, value)


@allocating_kernel
def extremes(flow, mode, state, functional, duration):
    """Smallest and largest value of a function of the state over [0, duration] in a mode.

    ``functional``: an affine function (n + 1), or two of them (2 n + 2), the second of which counts η times. Returns
    (smallest, largest).
    """
    series = series_for(state.size)
    begin(state, series)
    piece, passed, low, high = piece_at(flow, mode, state), 0.0, math.inf, -math.inf
    while passed <= duration:
        step, following = take_step(flow, mode, piece, series, duration - passed)
        _functional(flow, mode, piece, series, functional)
        piece = following
        low, high = _extremes_on_step(series.guard, step / series.unit[0], low, high, series.local)
        flow_taylor.note_sizes(series, step)
        go_on(series, step)
        if not passed + step > passed:
            break
        passed += step
    return low, high
