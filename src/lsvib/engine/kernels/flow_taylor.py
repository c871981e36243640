"""Flow of a mode whose friction depends on the sliding speed, by power series in time, step by step.

The field of a :class:`lsvib.engine.kernels.layout.TaylorFlow` is made of sums, products, one quotient and one
exponential, so the coefficients of its series follow from each other by short recurrences (Jorba and Zou 2005). A step
is so long that the last two terms are below the rounding of the largest one in each coordinate; with some twenty terms
that is a seventh of the radius of convergence. On the step the motion is the polynomial, and a guard, being affine, is
a polynomial too (:mod:`lsvib.engine.kernels.search_taylor`).

A constant coefficient is a case like any other, and so is a mode that does not slip: it has no piece of a law.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.engine.kernels.flow_planar import EPS, ROUNDING
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, inlined_kernel, kernel
from lsvib.engine.kernels.layout import CONSTANT, EXPONENT, FADE, FROM, LINEAR, ORDER, RISE, TO

_INVERSE = np.concatenate([[0.0], 1 / np.arange(1.0, ORDER + 1)])  # of an order; a product takes less than a quotient
TAIL = 0.5 * EPS  # size of the last terms of a series over that of a coordinate
NOTHING = 45.0  # (fade σ)^exponent of a decay that is below the rounding of a coefficient of friction
# Rows of series beside those of the state.
SIGMA, POWER, DECAY, MU, ETA, CONTACT, STEEP, SLOPE, REST, RATE = range(10)


class Series(NamedTuple):
    """Power series of a step, in time from its start over ``unit``, and scratch space of the search.

    The unit is a power of two near the step before, so that no coefficient leaves the range of numbers.
    """

    state: np.ndarray  # (n, ORDER + 1)
    parts: np.ndarray  # (10, ORDER + 1) σ, exponent, exponential, μ, η, q, q dη/dσ, and room for these
    here: np.ndarray  # (n,) the state at the start of the step
    sizes: np.ndarray  # (n,) sizes of the terms that the state was summed from, the largest of all steps so far
    spans: np.ndarray  # (n, 2) least and largest changes of the state on the step
    guard: np.ndarray  # (ORDER + 1,) a guard as a polynomial of the part of the step
    local: np.ndarray  # (ORDER + 1,) the same on a part of the step, in Bernstein's form
    fresh: np.ndarray  # (1,) whether the step is the first one, 1 or 0
    unit: np.ndarray  # (1,) of the time [s]
    place: np.ndarray  # (1,) time [s] of the event that was found, from the start of the step
    steps: np.ndarray  # (1,) steps that searches may still take; infinite at first


@allocating_kernel
def series_for(n):
    """Return uninitialised ``Series`` of n states, with steps without end."""
    return Series(
        np.empty((n, ORDER + 1)),
        np.empty((10, ORDER + 1)),
        np.empty(n),
        np.empty(n),
        np.empty((n, 2)),
        np.empty(ORDER + 1),
        np.empty(ORDER + 1),
        np.ones(1),
        np.ones(1),
        np.empty(1),
        np.full(1, math.inf),
    )


@inlined_kernel
def product(a, b, first, k):
    """Return Σ a_i b_{k−i} over i from ``first`` to k; in four sums, which a processor adds up side by side."""
    one = two = three = four = 0.0
    i = first
    while i + 2 < k:
        one += a[i] * b[k - i]
        two += a[i + 1] * b[k - i - 1]
        three += a[i + 2] * b[k - i - 2]
        four += a[i + 3] * b[k - i - 3]
        i += 4
    while i <= k:
        one += a[i] * b[k - i]
        i += 1
    return (one + two) + (three + four)


@inlined_kernel
def _affine(row, state, k):
    """Return the k-th coefficient of an affine function of the state."""
    n = state.shape[0]
    total = row[n] if k == 0 else 0.0
    for i in range(n):
        total += row[i] * state[i, k]
    return total


@inlined_kernel
def _law(law, parts, k):
    """Write the k-th coefficient of μ from those of σ so far."""
    sigma, power, decay = parts[SIGMA], parts[POWER], parts[DECAY]
    value = law[LINEAR] * sigma[k] + (law[CONSTANT] if k == 0 else 0.0)
    if law[RISE] != 0.0:
        fade = law[FADE]
        power[k] = -fade * (sigma[k] if law[EXPONENT] == 1.0 else fade * product(sigma, sigma, 0, k))
        if k == 0:
            decay[0] = math.exp(power[0])
        else:
            parts[RATE, k] = k * power[k]
            decay[k] = product(parts[RATE], decay, 1, k) * _INVERSE[k]
        value += law[RISE] * decay[k]
    parts[MU, k] = value


@kernel
def expand(flow, mode, piece, series, order):
    """Write the series of the state from ``series.here`` in a mode to an order; ``piece`` of the law, −1 for none.

    The force f = η q follows from (1 + B μ) f = μ q with a single product of series, of μ with q − B f.
    """
    x, parts, n = series.state, series.parts, series.here.size
    field, push, feedback = flow.field[mode], flow.push[mode], flow.feedback[mode]
    mu, contact, rest, unit, share = parts[MU], parts[CONTACT], parts[REST], series.unit[0], 1.0
    for i in range(n):
        x[i, 0] = series.here[i]
    for k in range(order):
        drive = 0.0
        if piece >= 0:
            parts[SIGMA, k], contact[k] = _affine(flow.speed[mode], x, k), _affine(flow.contact[mode], x, k)
            _law(flow.pieces[piece], parts, k)
            share = 1.0 / (1.0 + feedback * mu[0]) if k == 0 else share
            drive = (mu[0] * contact[k] + product(mu, rest, 1, k)) * share
            rest[k] = contact[k] - feedback * drive
        for i in range(n):
            x[i, k + 1] = unit * _INVERSE[k + 1] * (_affine(field[i], x, k) + push[i] * drive)


@kernel
def find_share(flow, mode, parts):
    """Write the series of η = μ / (1 + B μ) from that of μ."""
    mu, eta, feedback = parts[MU], parts[ETA], flow.feedback[mode]
    for k in range(ORDER):
        eta[k] = (mu[k] - feedback * product(mu, eta, 1, k)) / (1.0 + feedback * mu[0])


@kernel
def piece_at(flow, mode, state):
    """Return the piece of the law that holds at a state, −1 for none; where two meet, the one that is entered."""
    first, last = flow.piece_start[mode], flow.piece_start[mode + 1] - 1
    if first >= last:
        return first if first == last else -1
    row, n = flow.speed[mode], state.size
    sigma = row[n]
    for i in range(n):
        sigma += row[i] * state[i]
    piece = first
    while piece < last and sigma >= flow.pieces[piece, TO]:
        piece += 1
    return piece


@inlined_kernel
def step_of(series):
    """Return the time [s] up to which the last two terms of the series of each coordinate are rounding.

    That is in proportion to its sizes so far, and on the first step to the largest of its first three terms, or to the
    first one that is not zero, as where a ramp sets out from steady sliding.
    """
    logarithm = math.inf
    for i in range(series.here.size):
        x = series.state[i]
        for last in range(ORDER - 1, ORDER + 1):
            if x[last] == 0.0:
                continue
            reach = math.log(TAIL * series.sizes[i] / abs(x[last])) / last if series.sizes[i] > 0.0 else -math.inf
            if series.fresh[0] > 0.0:
                for k in range(1, last):
                    if k > 2 and reach > -math.inf:
                        break
                    if x[k] != 0.0:
                        reach = max(reach, math.log(TAIL * abs(x[k] / x[last])) / (last - k))
            logarithm = min(logarithm, reach)
    series.fresh[0] = 0.0
    return math.exp(logarithm) * series.unit[0]


@inlined_kernel
def value_at(row, t):
    """Return a polynomial (coefficients in ascending order) at t, of a series at a time over its unit."""
    total = row[row.size - 1]
    for k in range(row.size - 2, -1, -1):
        total = total * t + row[k]
    return total


@inlined_kernel
def note_sizes(series, t):
    """Note the sizes of the terms that the state at t [s] is summed from; those after the first three are smaller."""
    t /= series.unit[0]
    for i in range(series.here.size):
        x = series.state[i]
        series.sizes[i] = max(series.sizes[i], abs(x[0]) + t * (abs(x[1]) + t * abs(x[2])))
        if series.sizes[i] == 0.0:
            series.sizes[i] = abs(value_at(x, t))


@inlined_kernel
def begin(state, series):
    """Put a state at the start of a step."""
    series.fresh[0] = series.unit[0] = 1.0
    for i in range(state.size):
        series.here[i], series.sizes[i] = state[i], abs(state[i])


@kernel
def go_on(series, t):
    """Move the start of the step to the time t [s] on it, up to which sizes have been noted."""
    for i in range(series.here.size):
        series.here[i] = value_at(series.state[i], t / series.unit[0])
    if 1e-300 < t < 1e300:
        series.unit[0] = math.ldexp(1.0, math.frexp(t)[1])


@inlined_kernel
def is_settled(flow, mode, state):
    """Whether a motion stays in its mode for ever, by the quadratic form that falls along it."""
    level = flow.settled_level[mode]
    if level < 0.0:
        return False
    form, place, total = flow.settled_form[mode], flow.settled_place[mode], 0.0
    for i in range(state.size):
        for j in range(state.size):
            total += (state[i] - place[i]) * form[i, j] * (state[j] - place[j])
    return total <= level


@kernel
def _first_beyond(form, bound, side, step):
    """Return the first time, in units of the series, at which side · (form − bound) < 0; ``step`` if there is none.

    It is looked for on a fine grid, which a speed that is all but straight on a step does not pass over unseen, and
    then halved.
    """
    before = 0.0
    for part in range(1, 33):
        after = step * part / 32.0
        if side * (value_at(form, after) - bound) < 0.0:
            for _ in range(60):
                middle = 0.5 * (before + after)
                inside = side * (value_at(form, middle) - bound) >= 0.0
                before, after = (middle, after) if inside else (before, middle)
            return after
        before = after
    return step


@kernel
def _cut_at_rise(law, sigma, step):
    """Return a step, in units of its series, that ends where a decay which is nothing at first begins to count, if so.

    All terms of its series that are kept may be nothing, and yet the decay large before the end of a step: the length
    of the step, made of these terms, cannot know.
    """
    ratio, linear = law[FADE] * sigma[0], law[EXPONENT] == 1.0
    if law[RISE] == 0.0 or (ratio if linear else ratio * ratio) <= NOTHING:
        return step
    return _first_beyond(
        sigma[:ORDER], ((NOTHING - 1.0) if linear else math.sqrt(NOTHING - 1.0)) / law[FADE], 1.0, step
    )


@kernel
def cut_at_piece(flow, mode, piece, series, step):
    """Return the end of a step [s] within a piece of the law, and the piece that holds from there on."""
    unit = series.unit[0]
    if piece >= 0:
        step = unit * _cut_at_rise(flow.pieces[piece], series.parts[SIGMA], step / unit)
    if flow.piece_start[mode + 1] - flow.piece_start[mode] < 2:
        return step, piece
    low, high, form, whole = flow.pieces[piece, FROM], flow.pieces[piece, TO], series.guard, step / unit
    spread = abs(_affine(flow.speed[mode], series.state, ORDER))
    for k in range(ORDER - 1, 0, -1):
        spread = abs(series.parts[SIGMA, k]) + whole * spread
    spread *= whole
    if low < series.parts[SIGMA, 0] - spread and series.parts[SIGMA, 0] + spread < high:
        return step, piece
    for k in range(ORDER + 1):
        form[k] = _affine(flow.speed[mode], series.state, k)
    following = piece
    if piece > flow.piece_start[mode]:
        until = _first_beyond(form, low, 1.0, whole)
        following, whole = (piece - 1, until) if until < whole else (following, whole)
    if piece < flow.piece_start[mode + 1] - 1:
        until = _first_beyond(form, high, -1.0, whole)
        following, whole = (piece + 1, until) if until < whole else (following, whole)
    return (unit * whole if following != piece else step), following


@allocating_entry
def sample(flow, mode, state, start, times, out):
    """Write the states at ``times`` [s] (k), ascending, of a stay that began at ``start`` in ``state`` to ``out``."""
    series = series_for(state.size)
    begin(state, series)
    piece, passed, k = piece_at(flow, mode, state), 0.0, 0
    while k < times.size:
        expand(flow, mode, piece, series, ORDER)
        left = times[times.size - 1] - start - passed
        step, piece = cut_at_piece(flow, mode, piece, series, min(step_of(series), left))
        ends = not passed + step > passed
        while k < times.size and (ends or times[k] - start <= passed + step):
            for i in range(state.size):
                out[k, i] = value_at(series.state[i], min(times[k] - start - passed, step) / series.unit[0])
            k += 1
        note_sizes(series, step)
        go_on(series, step)
        passed += step


@allocating_entry
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    times, row = np.full(1, t), np.empty((1, state.size))
    sample(flow, mode, state, 0.0, times, row)
    for i in range(state.size):
        out[i] = row[0, i]


@inlined_kernel
def travel(flow, mode, state, stay, scale, work):
    """Replace ``state`` by the one of the event that the search has just found, and write the sizes of its terms."""
    go_on(work, work.place[0])
    for i in range(state.size):
        state[i], scale[i] = work.here[i], work.sizes[i]


@allocating_kernel
def slopes_at(flow, mode, state, scale, guard):
    """First and second derivative of a guard at a state, each with the size below which it is rounding only."""
    series, n = series_for(state.size), state.size
    begin(state, series)
    expand(flow, mode, piece_at(flow, mode, state), series, 2)
    rate, bend, rate_size, bend_size, drive = 0.0, 0.0, 0.0, 0.0, 0.0
    if flow.piece_start[mode + 1] > flow.piece_start[mode]:
        share = abs(series.parts[MU, 0] / (1.0 + flow.feedback[mode] * series.parts[MU, 0]))
        for j in range(n + 1):
            drive += share * abs(flow.contact[mode, j]) * (scale[j] if j < n else 1.0)
    for i in range(n):
        size = abs(flow.field[mode, i, n]) + abs(flow.push[mode, i]) * drive
        for j in range(n):
            size += abs(flow.field[mode, i, j]) * scale[j]
        rate += guard[i] * series.state[i, 1]
        rate_size += abs(guard[i]) * size
        bend += 2.0 * guard[i] * series.state[i, 2]
        for j in range(n):
            bend_size += abs(guard[j] * flow.field[mode, j, i]) * size
    bend_size = max(bend_size, abs(bend) * ROUNDING)
    return rate, ROUNDING * rate_size, bend, ROUNDING * bend_size


@allocating_entry
def nodes(flow, mode, state, t, places, states, steps):
    """Write the states at the ``places`` (j, parts of a step) of all steps of a stay t [s] in a mode.

    They go to ``states`` (k · j, n), and the lengths [s] of the steps to ``steps`` (k), as far as there is room.
    Returns the number of steps.
    """
    series, count = series_for(state.size), 0
    begin(state, series)
    piece, passed = piece_at(flow, mode, state), 0.0
    while passed < t:
        expand(flow, mode, piece, series, ORDER)
        step, piece = cut_at_piece(flow, mode, piece, series, min(step_of(series), t - passed))
        if count < steps.size:
            steps[count] = step
            for j in range(places.size):
                for i in range(state.size):
                    states[count * places.size + j, i] = value_at(series.state[i], places[j] * step / series.unit[0])
        note_sizes(series, step)
        go_on(series, step)
        count += 1
        if not passed + step > passed:
            break
        passed += step
    return count
