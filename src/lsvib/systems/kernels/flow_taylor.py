"""Flow of a mode whose friction depends on the sliding speed, by power series in time, step by step.

The field of a :class:`lsvib.systems.kernels.layout.TaylorFlow` is made of sums, products, one quotient and one
exponential, so the coefficients of its series follow from each other by short recurrences (Jorba and Zou 2005). A step
is so long that the first term left out is 1/32 of a rounding in each coordinate; with some twenty terms that is a
sixth of the radius of convergence. On the step the motion is the polynomial, and a guard, being affine, is a
polynomial too (:mod:`lsvib.systems.kernels.search_taylor`).

A constant coefficient is a case like any other, and so is a mode that does not slip: it has no piece of a law.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.systems.kernels.flow_planar import EPS, ROUNDING, summed
from lsvib.systems.kernels.jit import allocating_entry, allocating_kernel, inlined_kernel, kernel, on_stack
from lsvib.systems.kernels.law import EXPONENT, FADE, FROM, LINEAR, RISE, TO, exponent, value
from lsvib.systems.kernels.layout import ORDER

_ORDERS = np.arange(ORDER + 1.0)
_INVERSE = np.concatenate([[0.0], 1 / _ORDERS[1:]])  # a product takes less than a quotient
_ONE, _TWO = np.uint64(1), np.uint64(2)
TAIL = math.log(EPS / 32)  # of the first term of a series that is left out, over the size of a coordinate
_NOTHING = 45.0  # (fade σ)^exponent of a decay that is below the rounding of a coefficient of friction
# Rows of series beside those of the state.
SIGMA, POWER, DECAY, MU, ETA, CONTACT, STEEP, SLOPE, REST, RATE, MATRIX = range(11)
_exponent, _value = inlined_kernel(exponent), inlined_kernel(value)


class Series(NamedTuple):
    """Power series of a step, in time from its start over ``unit``, and scratch space of the search.

    The unit is a power of two near the step before, so that no coefficient leaves the range of numbers.
    """

    state: np.ndarray  # (n, ORDER + 1)
    parts: np.ndarray  # (12 + n, ORDER + 1) σ, exponential, μ, η, q, q dη/dσ, room for these; at last the linear field
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
        np.empty((n, ORDER + 1)), np.empty((MATRIX + n + 2, ORDER + 1)), np.empty(n), np.empty(n), np.empty((n, 2)),
        np.empty(ORDER + 1), np.empty(ORDER + 1), np.ones(1), np.ones(1), np.empty(1), np.full(1, math.inf),
    )  # fmt: skip


@inlined_kernel
def _between(a, b, k):
    """Return Σ a_i b_{k−i} over i from 1 to k − 1; in two sums, which a processor adds up side by side, newest last.

    Indices have no sign here: for each that has one it is asked whether it counts from the end of the array.
    """
    one, two, i = 0.0, 0.0, _TWO
    while i + _TWO < k:
        one += a[i] * b[k - i]
        two += a[i + _ONE] * b[k - i - _ONE]
        i += _TWO
    if i + _ONE < k:
        one += a[i] * b[k - i]
    one += a[_ONE] * b[k - _ONE] if k > _ONE else 0.0
    two += a[k - _ONE] * b[_ONE] if k > _TWO else 0.0
    return one + two


@inlined_kernel
def product(a, b, first, k):
    """Return Σ a_i b_{k−i} over i from ``first``, 0 or 1, to k."""
    total = a[0] * b[k] if first == 0 else 0.0
    return total + (_between(a, b, np.uint64(k)) + a[k] * b[0]) if k > 0 else total


@inlined_kernel
def affine(row, state, k, n):
    """Return the k-th coefficient of an affine function of the n coordinates of the state."""
    total = row[n] if k == 0 else 0.0
    for i in range(n):
        total += row[i] * state[i, k]
    return total


@inlined_kernel
def law_at(law, sigma):
    """Return μ and μ′ [s/m] of a piece at a sliding speed [m/s], the exponential and its logarithmic derivative."""
    ratio = law[FADE] * sigma
    decay = math.exp(-_exponent(law, ratio))
    mu, slope, rate = _value(law, sigma, ratio, decay)
    return mu, slope, decay, rate


@inlined_kernel
def _prepare_law(law, parts, k):
    """Return what the coefficients before add to the k-th one of μ, and write what they add to others."""
    sigma, decay, rate = parts[SIGMA], parts[DECAY], parts[RATE]
    if law[RISE] == 0.0:
        decay[k] = rate[k] = 0.0
        return 0.0
    rate[k] = 0.0 if law[EXPONENT] == 1.0 else -law[FADE] * law[FADE] * _between(sigma, sigma, k)
    decay[k] = _between(rate, decay, k) * _INVERSE[k] + rate[k] * decay[0]
    return law[RISE] * decay[k]


@inlined_kernel
def _complete_law(parts, k):
    """Add to the k-th coefficients what that of σ adds; that of μ is known from its slope."""
    decay, rate, own = parts[DECAY], parts[RATE], parts[SIGMA, k]
    decay[k] += rate[0] * decay[0] * own
    rate[k] = _ORDERS[k] * (rate[k] + rate[0] * own)


@inlined_kernel
def slope_of_law(law, parts, slope):
    """Write the series of μ′ [s/m]."""
    for k in range(ORDER):
        slope[k] = law[LINEAR] if k == 0 else 0.0
        if law[RISE] != 0.0:
            steep = parts[DECAY, k]
            if law[EXPONENT] != 1.0:
                steep = 2.0 * law[FADE] * product(parts[SIGMA], parts[DECAY], 0, k)
            slope[k] -= law[RISE] * law[FADE] * steep


@inlined_kernel
def _wakes_below(law, sigma):
    """Return the sliding speed [m/s] below which a decay that is nothing at ``sigma`` counts, infinite if none is.

    All terms of its series that are kept may be nothing, and yet the decay large before the end of a step: the length
    of the step, made of these terms, cannot know.
    """
    if law[RISE] == 0.0 or _exponent(law, law[FADE] * sigma) <= _NOTHING:
        return math.inf
    return ((_NOTHING - 1.0) if law[EXPONENT] == 1.0 else math.sqrt(_NOTHING - 1.0)) / law[FADE]


@inlined_kernel
def _begin_force(flow, mode, piece, series, n):
    """Write the first coefficients of μ and of the force η q, and the linear field at the start.

    That has a row for each coordinate, for σ and for q, of what the coordinates add to its rate, and at last what the
    rest of the force adds. Returns the force, η over μ, and μ′ [s/m].
    """
    parts, rows, force = series.parts, series.parts[MATRIX:], 0.0
    share = slope = mu = rest = 0.0
    speed, contact, push = flow.speed[mode], flow.contact[mode], flow.push[mode]
    if piece >= 0:
        parts[SIGMA, 0], pressed = affine(speed, series.state, 0, n), affine(contact, series.state, 0, n)
        mu, slope, parts[DECAY, 0], parts[RATE, 0] = law_at(flow.pieces[piece], parts[SIGMA, 0])
        parts[MU, 0] = mu
        share = 1.0 / (1.0 + flow.feedback[mode] * mu)
        force = share * mu * pressed
        rest = pressed - flow.feedback[mode] * force
        parts[CONTACT, 0], parts[REST, 0] = pressed, rest
    for j in range(n + 1):
        of_force = share * (mu * contact[j] + rest * slope * speed[j]) if j < n else 1.0
        rows[n, j] = rows[n + 1, j] = 0.0
        for i in range(n):
            rows[i, j] = push[i] * of_force + (flow.field[mode, i, j] if j < n else 0.0)
            rows[n, j] += speed[i] * rows[i, j]
            rows[n + 1, j] += contact[i] * rows[i, j]
    return force, share, slope


@inlined_kernel
def _next(row, state, k, n, left, scale):
    """Return a coefficient of a coordinate, of σ or of q from those of the state before, and the rest of the force."""
    total = 0.0
    for i in range(n):
        total += row[i] * state[i, k]
    return scale * total + scale * row[n] * left


@inlined_kernel
def _expand(flow, mode, piece, series, n):
    """Write the series of the n coordinates from ``series.here`` in a mode; ``piece`` of the law, −1 for none.

    The force f = η q follows from (1 + B μ) f = μ q with a single product of series, of μ with q − B f. In the
    coefficient of each order those of the state count as in the linear field at the start, and what else there is are
    products of earlier ones, which a processor makes while it waits for them. It waits less as those of σ and q come
    from the order before, like those of the state, and as what it knows last is added last.
    """
    x, parts, unit, rows = series.state, series.parts, series.unit[0], series.parts[MATRIX:]
    mu, rest, law, feedback, left = parts[MU], parts[REST], flow.pieces[max(piece, 0)], flow.feedback[mode], 0.0
    own = pressed = 0.0
    for i in range(n):
        x[i, 0] = series.here[i]
    force, share, slope = _begin_force(flow, mode, piece, series, n)
    for i in range(n):
        x[i, 1] = unit * (affine(flow.field[mode, i], x, 0, n) + flow.push[mode, i] * force)
        own += flow.speed[mode, i] * x[i, 1]
        pressed += flow.contact[mode, i] * x[i, 1]
    k = _ONE
    while k < np.uint64(ORDER):
        if piece >= 0:
            late = _prepare_law(law, parts, k)
            left = share * rest[0] * late + share * _between(mu, rest, k)
            parts[SIGMA, k], parts[CONTACT, k], mu[k] = own, pressed, late + slope * own
            _complete_law(parts, k)
            rest[k] = pressed - feedback * share * (mu[0] * pressed + rest[0] * slope * own) - feedback * left
        scale = unit * _INVERSE[k + _ONE]
        for i in range(n):
            x[i, k + _ONE] = _next(rows[i], x, k, n, left, scale)
        own, pressed = _next(rows[n], x, k, n, left, scale), _next(rows[n + 1], x, k, n, left, scale)
        k += _ONE


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
    piece, (sigma, _) = first, summed(flow.speed[mode], state, state)
    while piece < last and sigma >= flow.pieces[piece, TO]:
        piece += 1
    return piece


@inlined_kernel
def _step_of(series):
    """Return the time [s] up to which the first term that the series of a coordinate leaves out is rounding.

    That is by each of its last two terms, as if terms fell evenly to it from its sizes so far, and on the first step
    from the largest of its first three terms, or from the first one that is not zero, as where a ramp sets out from
    steady sliding. Where all of these are zero, as in rest, the step is twice the one before, at first 1 s.
    """
    logarithm = math.inf
    for i in range(series.here.size):
        x = series.state[i]
        for last in range(ORDER - 1, ORDER + 1):
            if x[last] == 0.0:
                continue
            reach = -math.inf
            if series.sizes[i] > 0.0:
                reach = math.log(series.sizes[i] / abs(x[last])) / last + TAIL / (ORDER + 1)
            if series.fresh[0] > 0.0:
                for k in range(1, last):
                    if k > 2 and reach > -math.inf:
                        break
                    if x[k] != 0.0:
                        reach = max(reach, math.log(abs(x[k] / x[last])) / (last - k) + TAIL / (ORDER + 1 - k))
            logarithm = min(logarithm, reach)
    series.fresh[0] = 0.0
    return (1.0 if logarithm == math.inf else math.exp(logarithm)) * series.unit[0]


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
def go_on(series, step):
    """Move the start of the step to the end of a step [s], whose spans are known."""
    for i in range(series.here.size):
        series.here[i] += series.spans[i, 0] + series.spans[i, 1]
    if 1e-300 < step < 1e300:
        series.unit[0] = math.ldexp(1.0, math.frexp(step)[1])


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


@inlined_kernel
def _find_spans(series, step):
    """Write bounds of the changes of all coordinates on a step [s] to ``spans``; their sum is the change at its end."""
    t = step / series.unit[0]
    for i in range(series.here.size):
        low = high = 0.0
        for k in range(ORDER, 0, -1):
            term = series.state[i, k]
            low, high = (low + min(term, 0.0)) * t, (high + max(term, 0.0)) * t
        series.spans[i, 0], series.spans[i, 1] = low, high


@inlined_kernel
def _cut_at_piece(flow, mode, piece, series, step):
    """Return the end of a step [s] within a piece of the law, and the piece that holds from there on; finds spans."""
    unit = series.unit[0]
    below = _wakes_below(flow.pieces[piece], series.parts[SIGMA, 0]) if piece >= 0 else math.inf
    if below < math.inf:
        step = unit * _first_beyond(series.parts[SIGMA, :ORDER], below, 1.0, step / unit)
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
        form[k] = affine(flow.speed[mode], series.state, k, series.here.size)
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


@kernel
def take_step(flow, mode, piece, series, longest):
    """Write the series of a step from ``series.here`` in a mode; ``piece`` of the law, −1 for none.

    Loops over two states are written out, which takes a quarter of the time; and all is one kernel, as to call one
    takes a tenth of it. Returns the length of the step [s], at most ``longest``, and the piece behind it; finds spans.
    """
    if series.here.size == 2:
        _expand(flow, mode, piece, series, 2)
    else:
        _expand(flow, mode, piece, series, series.here.size)
    return _cut_at_piece(flow, mode, piece, series, min(_step_of(series), longest))


@allocating_entry
def sample(flow, mode, state, start, times, out):
    """Write the states at ``times`` [s] (k), ascending, of a stay that began at ``start`` in ``state`` to ``out``."""
    series = series_for(state.size)
    begin(state, series)
    piece, passed, k = piece_at(flow, mode, state), 0.0, 0
    while k < times.size:
        step, piece = take_step(flow, mode, piece, series, times[times.size - 1] - start - passed)
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
    for i in range(state.size):
        state[i], scale[i] = value_at(work.state[i], work.place[0] / work.unit[0]), work.sizes[i]


@kernel
def field_at(flow, mode, state, scale, rate, size):
    """Write x′ at a state and the sizes of its terms, by those of the state, both (n).

    Returns η [1], dη/dσ [s/m] and q [N].
    """
    n, piece = state.size, piece_at(flow, mode, state)
    share = steep = force = force_size = 0.0
    if piece >= 0:
        sigma, _ = summed(flow.speed[mode], state, state)
        force, force_size = summed(flow.contact[mode], state, scale)
        mu, slope, _, _ = law_at(flow.pieces[piece], sigma)
        one = 1.0 + flow.feedback[mode] * mu
        share, steep = mu / one, slope / (one * one)
    for i in range(n):
        rate[i] = flow.field[mode, i, n] + flow.push[mode, i] * share * force
        size[i] = abs(flow.field[mode, i, n]) + abs(flow.push[mode, i] * share) * force_size
        for j in range(n):
            rate[i] += flow.field[mode, i, j] * state[j]
            size[i] += abs(flow.field[mode, i, j] * scale[j])
    return share, steep, force


@kernel
def slopes_at(flow, mode, state, scale, guard):
    """First and second derivative of a guard at a state, each with the size below which it is rounding only."""
    n, own, size = state.size, on_stack(state.size), on_stack(state.size)
    share, steep, pressed = field_at(flow, mode, state, scale, own, size)
    rate = rate_size = bend = bend_size = sigma_rate = pressed_rate = pushed = 0.0
    for j in range(n):
        rate += guard[j] * own[j]
        rate_size += abs(guard[j]) * size[j]
        pushed += guard[j] * flow.push[mode, j]
        sigma_rate += flow.speed[mode, j] * own[j]
        pressed_rate += flow.contact[mode, j] * own[j]
        for i in range(n):
            bend += guard[i] * flow.field[mode, i, j] * own[j]
            bend_size += abs(guard[i] * flow.field[mode, i, j]) * size[j]
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
        step, piece = take_step(flow, mode, piece, series, t - passed)
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
