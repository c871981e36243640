"""The certain search for the first guard that fires in a mode with many states.

The search walks from time zero in steps [a, b] on which every guard g is *decided*. Each of g, g′, g″ is enclosed on
the step: the part of the pairs with complex rates by |f − chord of f| ≤ max|f″| h²/8, h = b − a, with the bounds of
:func:`lsvib.core.modal.bound`; the part of the pairs with real rates likewise, or term by term, since each term is
monotone – whichever is narrower. Then, with g ≥ 0 at a,

    g > 0 on [a, b]     no root;
    g′ > 0              no root;
    g′ < 0              g falls: one root if g_b ≤ 0, else none;
    g″ > 0, g′_a ≥ 0    no root;
    g″ < 0              g is above its chord: one root if g_b ≤ 0, else none.

A step on which a guard is undecided is shortened, so no root is passed over. Where shortening ends because the whole
step is below the rounding of the guard, the guard grazes. With infinite time the walk ends when the bounds of all parts
together are below the guards' constants.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.core import modal
from lsvib.core.jit import allocating_kernel, kernel
from lsvib.core.planar import A0, A1, ALPHA, BETA, EPS, R1, R2
from lsvib.core.root import next_guess
from lsvib.core.status import Found

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_GRAZE = int(Found.GRAZE)
_LOST = int(Found.UNDECIDED)
_POSITIVE, _TOUCHES, _ROOT, _UNDECIDED = range(4)
_STEPS = 1_000_000
_LONGEST = 1e4  # of the factor by which the tests may pass, so that a step grows at most 70-fold
_BEYOND_ROUNDING = 128.0  # the same where the whole step is within rounding: the next one is eight times as long
_GROWTH = 8.0  # of the exponent of a growing term within one step


class Work(NamedTuple):
    """Room for one search at a time, for up to g guards and p pairs."""

    amplitudes: np.ndarray  # (g, p, orders, 6)
    rounding: np.ndarray  # (g,)
    forms: np.ndarray  # (g, 2p + 1)
    nodes: np.ndarray  # (2, g, 6) guards and derivatives at both ends of a step
    factors: np.ndarray  # (3, p, 3) decay factors at both ends, and the largest between
    states: np.ndarray  # (3, 2p) modal states


@allocating_kernel
def workspace(flow, guards):
    """Return room for searches with up to so many guards."""
    pairs = flow.oscillators.shape[1]
    return Work(
        np.empty((guards, pairs, modal.ORDERS, 6)),
        np.empty(guards),
        np.empty((guards, 2 * pairs + 1)),
        np.empty((2, guards, 6)),
        np.empty((3, pairs, 3)),
        np.empty((3, 2 * pairs)),
    )


@allocating_kernel
def first_crossing(flow, mode, state, guards, on_surface, limit):
    """As :func:`search`, in room of its own."""
    return search(flow, mode, state, guards, on_surface, limit, workspace(flow, guards.shape[0]))


@kernel
def search(flow, mode, state, guards, on_surface, limit, work):
    """Find the first of several guards that falls through zero, or touches it from above, within ``limit`` [s].

    Arguments: flow tables, mode, state (n), guards (g, n + 1), each positive at the start or – where ``on_surface`` (g)
    – zero and not falling; that array is overwritten; ``Work``. Returns (``Found``, index of the guard, time [s]).
    """
    pairs, count = flow.pairs[mode], guards.shape[0]
    rows, size = flow.oscillators[mode, :pairs], 2 * pairs
    amplitudes, rounding = work.amplitudes[:count, :pairs], work.rounding
    forms, states = work.forms[:count, : size + 1], work.states[:, :size]
    values, ahead = work.nodes[0, :count], work.nodes[1, :count]
    factors = work.factors[:, :pairs]
    decays, decays_ahead, largest = factors[0], factors[1], factors[2]
    start, there, scratch = states[0], states[1], states[2]
    modal.apply(flow.to_modal[mode], state, start)
    _prepare(flow, mode, rows, start, guards, on_surface, forms, amplitudes, values, rounding)
    modal.flow_with_decays(rows, start, 0.0, there, decays)
    longest = _longest_step(rows)
    a, step = 0.0, min(limit, longest, _first_step(rows, values, amplitudes))
    for _ in range(_STEPS):
        if a >= limit or (limit == math.inf and _never(rows, start, forms, amplitudes, decays, a)):
            return _NONE, -1, limit
        b = limit if a + step >= limit else a + step
        modal.flow_with_decays(rows, start, b, there, decays_ahead)
        for pair in range(pairs):
            for k in range(3):
                largest[pair, k] = max(decays[pair, k], decays_ahead[pair, k])
        outcome, stretch = _POSITIVE, _LONGEST
        for guard in range(count):
            modal.derivatives(rows, there, forms, guard, ahead)
            decision, slack = _decide(
                rows, values, ahead, amplitudes, guard, (decays, decays_ahead, largest), b - a, rounding[guard],
                on_surface[guard],
            )  # fmt: skip
            stretch = min(stretch, slack)
            if decision == _TOUCHES and outcome == _POSITIVE:
                return _GRAZE, guard, 0.5 * (a + b)
            outcome = max(outcome, decision)
            if decision == _UNDECIDED:
                break
        if outcome == _UNDECIDED:
            step = (b - a) * max(0.1, min(0.5, 0.7 * math.sqrt(stretch)))
            if a + step == a:
                return _first_below(ahead, b)
            continue
        if outcome == _ROOT:
            return _earliest(rows, start, forms, ahead, a, b, scratch)
        for guard in range(count):
            on_surface[guard] = on_surface[guard] and ahead[guard, 0] <= rounding[guard]
        a, step = b, min(longest, (b - a) * max(1.0, 0.7 * math.sqrt(stretch)))
        values, ahead, decays, decays_ahead = ahead, values, decays_ahead, decays
    return _LOST, -1, limit


@kernel
def _prepare(flow, mode, rows, start, guards, on_surface, forms, amplitudes, values, rounding):
    """Write the guards in modal form, their bounds' factors, their values at time zero and their rounding."""
    size = start.size
    for guard in range(guards.shape[0]):
        form = forms[guard]
        modal.in_modal_form(flow, mode, guards[guard], form)
        modal.derivatives(rows, start, forms, guard, values)
        total = abs(form[size])
        for pair in range(rows.shape[0]):
            row = rows[pair]
            u, w = start[2 * pair], start[2 * pair + 1]
            value = form[2 * pair] * u + form[2 * pair + 1] * w
            rate = form[2 * pair] * w - form[2 * pair + 1] * (row[A0] * u + row[A1] * w)
            modal.amplitudes(row, value, rate, amplitudes[guard, pair])
            total += abs(form[2 * pair] * u) + abs(form[2 * pair + 1] * w)
        rounding[guard] = 8.0 * EPS * total
        if on_surface[guard]:
            values[guard, 0] = 0.0
            values[guard, 1] = max(values[guard, 1], 0.0)


@kernel
def _fastest(rows):
    """Largest rate [1/s] of a mode."""
    fastest = 0.0
    for pair in range(rows.shape[0]):
        row = rows[pair]
        fastest = max(fastest, abs(row[R1]), abs(row[R2]), abs(row[ALPHA]) + row[BETA])
    return fastest


@kernel
def _longest_step(rows):
    """Step [s] on which no term grows beyond e⁸."""
    growing = 0.0
    for pair in range(rows.shape[0]):
        row = rows[pair]
        growing = max(growing, -row[ALPHA] if row[BETA] > 0.0 else row[R1])
    return _GROWTH / growing if growing > 0.0 else math.inf


@kernel
def _first_step(rows, values, amplitudes):
    """Step [s] on which the complex pairs alone let the guards be decided."""
    shortest = math.inf
    for guard in range(values.shape[0]):
        best = 0.0
        for k in range(3):
            curve = 0.0
            for pair in range(rows.shape[0]):
                if rows[pair, BETA] > 0.0:
                    curve += modal.bound(amplitudes[guard, pair, k + 2], 1.0, 0.0, 0.0)
            best = max(best, 4.0 * abs(values[guard, k]) / curve if curve > 0.0 else math.inf)
        shortest = min(shortest, math.sqrt(best))
    if 0.0 < shortest < math.inf:
        return shortest
    fastest = _fastest(rows)
    return 1.0 / fastest if fastest > 0.0 else 1.0


@kernel
def _enclosure(rows, here, there, amplitudes, guard, decays, k, eighth):
    """Bounds from below and above of the k-th derivative of a guard on a step; ``decays`` at both ends, and largest."""
    least, most = min(here[guard, k], there[guard, k]), max(here[guard, k], there[guard, k])
    smooth, rough = 0.0, 0.0  # bounds of the second derivative of the complex and of the real pairs
    below, above = min(here[guard, k + 3], there[guard, k + 3]), max(here[guard, k + 3], there[guard, k + 3])
    for pair in range(rows.shape[0]):
        largest = decays[2][pair]
        bound = modal.bound(amplitudes[guard, pair, k + 2], largest[0], largest[1], largest[2])
        if rows[pair, BETA] > 0.0:
            smooth += bound
        else:
            rough += bound
            low, high = modal.range_of_terms(amplitudes[guard, pair, k], decays[0][pair], decays[1][pair])
            below, above = below + low, above + high
    low, high = least - (smooth + rough) * eighth, most + (smooth + rough) * eighth
    if below - smooth * eighth > low:
        low = min(below - smooth * eighth, least)
    if above + smooth * eighth < high:
        high = max(above + smooth * eighth, most)
    return least, low, most, high


@kernel
def _margin(end, bound):
    """How many times the width of an enclosure fits between zero and the end that is nearest to it."""
    width = abs(end - bound)
    return abs(end) / width if width > 0.0 else _LONGEST


@kernel
def _decide(rows, here, there, amplitudes, guard, decays, step, rounding, starts_on_surface):
    """Decide what a guard does on one step, see the module docstring; also by which factor the tests pass or fail."""
    eighth = 0.125 * step * step
    least, low, _, _ = _enclosure(rows, here, there, amplitudes, guard, decays, 0, eighth)
    if low > 0.0:
        return _POSITIVE, _margin(least, low)
    after = _ROOT if there[guard, 0] <= 0.0 else _POSITIVE
    slowest, slow, fastest, fast = _enclosure(rows, here, there, amplitudes, guard, decays, 1, eighth)
    if slow > 0.0:
        return _POSITIVE, _margin(slowest, slow)
    if fast < 0.0:
        return after, _margin(fastest, fast)
    flattest, flat, steepest, steep = _enclosure(rows, here, there, amplitudes, guard, decays, 2, eighth)
    if flat > 0.0 and here[guard, 1] >= 0.0:
        return _POSITIVE, _margin(flattest, flat)
    if steep < 0.0:
        return after, _margin(steepest, steep)
    slack = 0.0
    if least > 0.0:
        slack = _margin(least, low)
    if slowest > 0.0:
        slack = max(slack, _margin(slowest, slow))
    if fastest < 0.0:
        slack = max(slack, _margin(fastest, fast))
    if least - low < rounding:
        # On so short a step the guard is its chord to rounding: it rests on zero, or it touches it.
        if least > rounding:
            return _POSITIVE, _BEYOND_ROUNDING
        if there[guard, 0] <= -rounding:
            return _ROOT, _BEYOND_ROUNDING
        return _POSITIVE if starts_on_surface else _TOUCHES, _BEYOND_ROUNDING
    return _UNDECIDED, slack


@kernel
def _never(rows, start, forms, amplitudes, decays, t):
    """True if every pair comes to a limit and the guards stay positive on the way there and in it.

    A pair without stiffness, q″ = −a₁ q′, comes to q + q′/a₁ if a₁ > 0, and stays where it is if q′ = 0.
    """
    for pair in range(rows.shape[0]):
        a0, a1 = rows[pair, A0], rows[pair, A1]
        if a0 != 0.0 and not (a1 > 0.0 and (rows[pair, BETA] > 0.0 or rows[pair, R1] < 0.0)):
            return False
        if a0 == 0.0 and not a1 > 0.0 and start[2 * pair + 1] != 0.0:
            return False
    for guard in range(forms.shape[0]):
        level = forms[guard, start.size] - modal.tail_bound(rows, amplitudes, guard, decays, t)
        for pair in range(rows.shape[0]):
            if rows[pair, A0] == 0.0:
                rate, g_q = start[2 * pair + 1], forms[guard, 2 * pair]
                level += g_q * start[2 * pair]
                if rate != 0.0:
                    way = rate / rows[pair, A1]
                    level += g_q * way
                    level -= abs(forms[guard, 2 * pair + 1] * rate - g_q * way) * decays[pair, 1]
        if not level > 0.0:
            return False
    return True


@kernel
def _first_below(ahead, b):
    """Guard that is lowest at a node where no further halving is possible."""
    lowest = 0
    for guard in range(ahead.shape[0]):
        if ahead[guard, 0] < ahead[lowest, 0]:
            lowest = guard
    return _CROSSING, lowest, b


@kernel
def _earliest(rows, start, forms, ahead, a, b, scratch):
    """The earliest root on a decided step; a guard that is positive at the earliest one so far has none before it."""
    first, when = -1, b
    for guard in range(forms.shape[0]):
        if first >= 0 and ahead[guard, 0] <= 0.0:
            modal.flow_pairs(rows, start, when, scratch)
            modal.derivatives(rows, scratch, forms, guard, ahead)
        if ahead[guard, 0] <= 0.0:
            first, when = guard, _root(rows, start, forms, guard, a, when, scratch, ahead)
    return _CROSSING, first, when


@kernel
def _root(rows, start, forms, guard, low, high, scratch, out):
    """Root of a guard that is positive from ``low`` on and not after its root; ``out`` holds its row at ``high``."""
    rate, t = _fastest(rows), high
    for count in range(300):
        value, slope, curvature = out[guard, 0], out[guard, 1], out[guard, 2]
        if value > 0.0:
            low = t
        elif value == 0.0:
            return t
        else:  # negative, or overflown far beyond the root
            high = t
        t, found = next_guess(t, value, slope, curvature, low, high, rate, count)
        if found:
            return t
        modal.flow_pairs(rows, start, t, scratch)
        modal.derivatives(rows, scratch, forms, guard, out)
    return t
