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

_ORDERS = np.arange(ORDER + 1.0)
_INVERSE = np.concatenate([[0.0], 1 / _ORDERS[1:]])  # a product takes less than a quotient
_ONE, _TWO = np.uint64(1), np.uint64(2)
TAIL = 0.5 * EPS  # size of the last terms of a series over that of a coordinate
NOTHING = 45.0  # (fade σ)^exponent of a decay that is below the rounding of a coefficient of friction
# Rows of series beside those of the state.
SIGMA, POWER, DECAY, MU, ETA, CONTACT, STEEP, SLOPE, REST, RATE, MATRIX = range(11)


class Series(NamedTuple):
    """Power series of a step, in time from its start over ``unit``, and scratch space of the search.

    The unit is a power of two near the step before, so that no coefficient leaves the range of numbers.
    """

    state: np.ndarray  # (n, ORDER + 1)
    parts: np.ndarray  # (10 + n, ORDER + 1) σ, exponential, μ, η, q, q dη/dσ, room for these; at last the linear field
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
        np.empty((n, ORDER + 1)), np.empty((MATRIX + n, ORDER + 1)), np.empty(n), np.empty(n), np.empty((n, 2)),
        np.empty(ORDER + 1), np.empty(ORDER + 1), np.ones(1), np.ones(1), np.empty(1), np.full(1, math.inf),
    )  # fmt: skip


@inlined_kernel
def _between(a, b, k):
    """Return Σ a_i b_{k−i} over i from 1 to k − 1; in two sums, which a processor adds up side by side.

    Indices have no sign here: for each that has one it is asked whether it counts from the end of the array.
    """
    one = two = 0.0
    i = _ONE
    while i + _ONE < k:
        one += a[i] * b[k - i]
        two += a[i + _ONE] * b[k - i - _ONE]
        i += _TWO
    if i < k:
        one += a[i] * b[k - i]
    return one + two


@inlined_kernel
def product(a, b, first, k):
    """Return Σ a_i b_{k−i} over i from ``first``, 0 or 1, to k."""
    total = a[0] * b[k] if first == 0 else 0.0
    return total + (_between(a, b, np.uint64(k)) + a[k] * b[0]) if k > 0 else total


@inlined_kernel
def _affine(row, state, k):
    """Return the k-th coefficient of an affine function of the state."""
    n = state.shape[0]
    total = row[n] if k == 0 else 0.0
    for i in range(n):
        total += row[i] * state[i, k]
    return total


@inlined_kernel
def decay_at(law, sigma):
    """Return the exponential of a piece of the law at a sliding speed [m/s], and its logarithmic derivative [s/m]."""
    ratio = law[FADE] * sigma
    if law[EXPONENT] == 1.0:
        return math.exp(-ratio), -law[FADE]
    return math.exp(-ratio * ratio), -2.0 * law[FADE] * ratio


@inlined_kernel
def law_at(law, sigma):
    """Return μ and μ′ [s/m] of a piece of the law at a sliding speed [m/s]."""
    decay, falls = decay_at(law, sigma)
    return law[CONSTANT] + law[LINEAR] * sigma + law[RISE] * decay, law[LINEAR] + law[RISE] * falls * decay


@kernel
def _begin_force(flow, mode, piece, series):
    """Write the first coefficients of μ and of the force η q, and the matrix of the linear field at the start.

    Returns the force, η over μ, μ′ [s/m], the logarithmic derivative of the exponential [s/m].
    """
    parts, matrix, n = series.parts, series.parts[MATRIX:], series.here.size
    for i in range(n):
        for j in range(n):
            matrix[i, j] = flow.field[mode, i, j]
    if piece < 0:
        return 0.0, 0.0, 0.0, 0.0
    law, speed, contact, push = flow.pieces[piece], flow.speed[mode], flow.contact[mode], flow.push[mode]
    sigma, pressed = _affine(speed, series.state, 0), _affine(contact, series.state, 0)
    (mu, slope), (decay, falls) = law_at(law, sigma), decay_at(law, sigma)
    share = 1.0 / (1.0 + flow.feedback[mode] * mu)
    force = share * mu * pressed
    rest = pressed - flow.feedback[mode] * force
    parts[SIGMA, 0], parts[DECAY, 0], parts[MU, 0], parts[CONTACT, 0], parts[REST, 0] = sigma, decay, mu, pressed, rest
    for j in range(n):
        of_state = share * (mu * contact[j] + rest * slope * speed[j])
        for i in range(n):
            matrix[i, j] += push[i] * of_state
    return force, share, slope, falls


@inlined_kernel
def _expand(flow, mode, piece, series, order, n):
    """Write the series of the state from ``series.here`` in a mode to an order; ``piece`` of the law, −1 for none.

    The force f = η q follows from (1 + B μ) f = μ q with a single product of series, of μ with q − B f. In the
    coefficient of each order those of the state count as in the linear field at the start, and what else there is are
    products of earlier ones, which a processor makes while it waits for them.
    """
    x, parts, unit, matrix = series.state, series.parts, series.unit[0], series.parts[MATRIX:]
    sigma, decay, rate, mu, rest = parts[SIGMA], parts[DECAY], parts[RATE], parts[MU], parts[REST]
    law, speed, contact = flow.pieces[max(piece, 0)], flow.speed[mode], flow.contact[mode]
    push, feedback, left, bent, late = flow.push[mode], flow.feedback[mode], 0.0, 0.0, 0.0
    for i in range(n):
        x[i, 0] = series.here[i]
    force, share, slope, falls = _begin_force(flow, mode, piece, series)
    for i in range(n):
        x[i, 1] = unit * (_affine(flow.field[mode, i], x, 0) + push[i] * force)
    k = _ONE
    while k < np.uint64(order):
        if piece >= 0:
            if law[RISE] != 0.0:
                bent = 0.0 if law[EXPONENT] == 1.0 else -law[FADE] * law[FADE] * _between(sigma, sigma, k)
                late = _between(rate, decay, k) * _INVERSE[k] + bent * decay[0]
            left = share * (rest[0] * law[RISE] * late + _between(mu, rest, k))
        for i in range(n):
            total = push[i] * left
            for j in range(n):
                total += matrix[i, j] * x[j, k]
            x[i, k + _ONE] = unit * _INVERSE[k + _ONE] * total
        if piece >= 0:
            own = pressed = 0.0
            for i in range(n):
                own += speed[i] * x[i, k]
                pressed += contact[i] * x[i, k]
            sigma[k], parts[CONTACT, k], rate[k] = own, pressed, _ORDERS[k] * (bent + falls * own)
            decay[k], mu[k] = late + falls * decay[0] * own, law[RISE] * late + slope * own
            rest[k] = pressed - feedback * (left + share * (mu[0] * pressed + rest[0] * slope * own))
        k += _ONE


@kernel
def expand(flow, mode, piece, series, order):
    """Write the series of the state, as :func:`_expand` does; with a number of states that is known when it compiles.

    Loops over two states are then written out, which takes a quarter of the time.
    """
    if series.here.size == 2:
        _expand(flow, mode, piece, series, order, 2)
    else:
        _expand(flow, mode, piece, series, order, series.here.size)


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


@inlined_kernel
def _find_spans(series, step):
    """Write bounds of the changes of all coordinates on a step [s] to ``spans``."""
    for i in range(series.here.size):
        low, high, power = 0.0, 0.0, 1.0
        for k in range(1, ORDER + 1):
            power *= step / series.unit[0]
            term = series.state[i, k] * power
            low, high = low + min(term, 0.0), high + max(term, 0.0)
        series.spans[i, 0], series.spans[i, 1] = low, high


@kernel
def cut_at_piece(flow, mode, piece, series, step):
    """Return the end of a step [s] within a piece of the law, and the piece that holds from there on; finds spans."""
    unit = series.unit[0]
    if piece >= 0:
        step = unit * _cut_at_rise(flow.pieces[piece], series.parts[SIGMA], step / unit)
    _find_spans(series, step)
    if flow.piece_start[mode + 1] - flow.piece_start[mode] < 2:
        return step, piece
    low, high, form, whole = flow.pieces[piece, FROM], flow.pieces[piece, TO], series.guard, step / unit
    least = most = series.parts[SIGMA, 0]
    for i in range(series.here.size):
        factor, spans = flow.speed[mode, i], series.spans[i]
        least += min(factor * spans[0], factor * spans[1])
        most += max(factor * spans[0], factor * spans[1])
    if low < least and most < high:
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
    if following == piece:
        return step, piece
    _find_spans(series, unit * whole)
    return unit * whole, following


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


@kernel
def slopes_at(flow, mode, state, scale, guard):
    """First and second derivative of a guard at a state, each with the size below which it is rounding only."""
    n, piece, push = state.size, piece_at(flow, mode, state), flow.push[mode]
    share = steep = pressed = size_of_force = pushed = 0.0
    if piece >= 0:
        sigma, pressed = flow.speed[mode, n], flow.contact[mode, n]
        size_of_force = abs(flow.contact[mode, n])
        for j in range(n):
            sigma += flow.speed[mode, j] * state[j]
            pressed += flow.contact[mode, j] * state[j]
            size_of_force += abs(flow.contact[mode, j]) * scale[j]
        mu, slope = law_at(flow.pieces[piece], sigma)
        one = 1.0 + flow.feedback[mode] * mu
        share, steep = mu / one, slope / (one * one)
        size_of_force *= abs(share)
    rate = rate_size = bend = bend_size = sigma_rate = pressed_rate = 0.0
    for j in range(n):
        own = flow.field[mode, j, n] + push[j] * share * pressed  # x′ of the coordinate
        size = abs(flow.field[mode, j, n]) + abs(push[j]) * size_of_force
        for i in range(n):
            own += flow.field[mode, j, i] * state[i]
            size += abs(flow.field[mode, j, i]) * scale[i]
        rate += guard[j] * own
        rate_size += abs(guard[j]) * size
        pushed += guard[j] * push[j]
        for i in range(n):
            bend += guard[i] * flow.field[mode, i, j] * own
            bend_size += abs(guard[i] * flow.field[mode, i, j]) * size
        if piece >= 0:
            sigma_rate += flow.speed[mode, j] * own
            pressed_rate += flow.contact[mode, j] * own
    bend += pushed * (steep * sigma_rate * pressed + share * pressed_rate)
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
