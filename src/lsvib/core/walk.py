"""The certain search for the first guard that fires in a mode with many states.

With M_k a bound of the k-th derivative of a guard g over [a, b] (:func:`lsvib.core.modal.bound`), h = b − a, and
|f − chord of f| ≤ max|f″| h²/8 for any f, the search walks from time zero in steps on which every guard is *decided*:

    min(g_a, g_b)   > M₂ h²/8      g stays positive: no root;
    min(g′_a, g′_b) > M₃ h²/8      g rises: no root, since it was positive (or zero) at a;
    max(g′_a, g′_b) < −M₃ h²/8     g falls: one root if g_b ≤ 0, else none;
    min(g″_a, g″_b) > M₄ h²/8      g is convex: no root if it also starts without falling.

A step on which a guard is undecided is halved, so no root is passed over. Where halving ends because the whole step is
below the rounding of the guard, the guard grazes. With infinite time the walk ends when the bounds of all parts
together are below the guards' constants.
"""

import math

import numpy as np

from lsvib.core import modal
from lsvib.core.jit import kernel
from lsvib.core.planar import ALPHA, BETA, EPS, R1, R2
from lsvib.core.status import Found

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_GRAZE = int(Found.GRAZE)
_POSITIVE, _ROOT, _UNDECIDED, _TOUCHES = range(4)
_STEPS = 1_000_000


@kernel
def first_crossing(flow, mode, state, guards, on_surface, limit):
    """Find the first of several guards that falls through zero, or touches it from above, within ``limit`` [s].

    Arguments: flow tables, mode, state (n), guards (g, n + 1), each positive at the start or – where ``on_surface`` (g)
    – zero and not falling. Returns (``Found``, index of the guard, time [s]).
    """
    rows = flow.oscillators[mode]
    pairs, count, size = rows.shape[0], guards.shape[0], flow.to_modal.shape[1]
    start, here, there = np.empty(size), np.empty(size), np.empty(size)
    modal.apply(flow.to_modal[mode], state, start)
    forms = np.empty((count, size + 1))
    amplitudes = np.empty((count, pairs, modal.ORDERS, 4))
    values, ahead = np.empty((count, 3)), np.empty((count, 3))
    decays, decays_ahead = np.empty((pairs, 3)), np.empty((pairs, 3))
    rounding = np.empty(count)
    _prepare(flow, mode, start, guards, on_surface, forms, amplitudes, values, rounding)
    for pair in range(pairs):
        modal.decays(rows[pair], 0.0, decays[pair])
    a, step = 0.0, _first_step(rows, limit)
    here[:] = start
    for _ in range(_STEPS):
        if limit == math.inf and _never(rows, forms, amplitudes, decays):
            return _NONE, -1, limit
        if a >= limit:
            return _NONE, -1, limit
        step = min(step, _reach(values, amplitudes, decays))
        b = limit if a + step >= limit else a + step
        modal.flow_pairs(rows, start, b, there)
        for pair in range(pairs):
            modal.decays(rows[pair], b, decays_ahead[pair])
        outcome = _POSITIVE
        for guard in range(count):
            modal.derivatives(rows, there, forms[guard], ahead[guard])
            decision = _decide(
                values[guard], ahead[guard], amplitudes[guard], decays, decays_ahead, b - a, rounding[guard],
                a == 0.0 and on_surface[guard],
            )  # fmt: skip
            if decision == _UNDECIDED:
                outcome = _UNDECIDED
                break
            outcome = max(outcome, decision) if decision == _ROOT or outcome != _ROOT else outcome
            if decision == _TOUCHES and outcome != _ROOT:
                return _GRAZE, guard, 0.5 * (a + b)
        if outcome == _UNDECIDED:
            step = 0.5 * (b - a)
            if a + step == a:
                return _first_below(ahead, b)
            continue
        if outcome == _ROOT:
            return _earliest(rows, start, forms, values, ahead, a, b, there)
        a, step = b, 4.0 * (b - a)
        values[:] = ahead
        decays[:] = decays_ahead
    return _NONE, -1, limit


@kernel
def _prepare(flow, mode, start, guards, on_surface, forms, amplitudes, values, rounding):
    """Write the guards in modal form, their bounds' factors, their values at time zero and their rounding."""
    rows = flow.oscillators[mode]
    size = start.size
    for guard in range(guards.shape[0]):
        form = forms[guard]
        modal.in_modal_form(flow, mode, guards[guard], form)
        modal.derivatives(rows, start, form, values[guard])
        total = abs(form[size])
        for pair in range(rows.shape[0]):
            row = rows[pair]
            u, w = start[2 * pair], start[2 * pair + 1]
            value = form[2 * pair] * u + form[2 * pair + 1] * w
            rate = form[2 * pair] * w - form[2 * pair + 1] * (row[0] * u + row[1] * w)
            modal.amplitudes(row, value, rate, amplitudes[guard, pair])
            total += abs(form[2 * pair] * u) + abs(form[2 * pair + 1] * w)
        rounding[guard] = 8.0 * EPS * total
        if on_surface[guard]:
            values[guard, 0] = 0.0
            values[guard, 1] = max(values[guard, 1], 0.0)


@kernel
def _first_step(rows, limit):
    """A step to begin with: of the order of the fastest time of the mode; the walk adapts it at once."""
    fastest = 0.0
    for pair in range(rows.shape[0]):
        row = rows[pair]
        fastest = max(fastest, abs(row[R1]), abs(row[R2]), abs(row[ALPHA]) + row[BETA])
    return min(limit, 1.0 / fastest) if fastest > 0.0 else min(limit, 1.0)


@kernel
def _reach(values, amplitudes, decays):
    """Longest step on which each guard has a fair chance to be decided, judged at the present node."""
    reach = math.inf
    for guard in range(values.shape[0]):
        second = modal.bound(amplitudes[guard], 2, decays, decays)
        third = modal.bound(amplitudes[guard], 3, decays, decays)
        sure = math.sqrt(4.0 * abs(values[guard, 0]) / second) if second > 0.0 else math.inf
        steady = math.sqrt(4.0 * abs(values[guard, 1]) / third) if third > 0.0 else math.inf
        if values[guard, 0] == 0.0 or sure < steady:
            sure = max(steady, sure)
        if sure > 0.0:
            reach = min(reach, sure)
    return reach


@kernel
def _decide(here, there, amplitudes, decays, decays_ahead, step, rounding, starts_on_surface):
    """Decide what a guard does on one step; see the module docstring."""
    eighth = 0.125 * step * step
    second = modal.bound(amplitudes, 2, decays, decays_ahead)
    if min(here[0], there[0]) > second * eighth:
        return _POSITIVE
    third = modal.bound(amplitudes, 3, decays, decays_ahead)
    if min(here[1], there[1]) > third * eighth:
        return _POSITIVE
    if max(here[1], there[1]) < -third * eighth:
        return _ROOT if there[0] <= 0.0 else _POSITIVE
    fourth = modal.bound(amplitudes, 4, decays, decays_ahead)
    if here[1] >= 0.0 and min(here[2], there[2]) > fourth * eighth:
        return _POSITIVE
    if second * eighth < rounding:
        # On so short a step the guard is its chord to rounding: it rests on zero, or it touches it.
        if min(here[0], there[0]) > rounding:
            return _POSITIVE
        if starts_on_surface:
            return _POSITIVE if there[0] > -rounding else _ROOT
        return _TOUCHES if there[0] > -rounding else _ROOT
    return _UNDECIDED


@kernel
def _never(rows, forms, amplitudes, decays):
    """True if every pair decays and what is left of the guards' moving parts is smaller than their constants."""
    for pair in range(rows.shape[0]):
        row = rows[pair]
        if not (row[ALPHA] > 0.0 and (row[BETA] > 0.0 or row[R1] < 0.0)):
            return False
    for guard in range(forms.shape[0]):
        if not forms[guard, forms.shape[1] - 1] > modal.bound(amplitudes[guard], 0, decays, decays):
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
def _earliest(rows, start, forms, values, ahead, a, b, scratch):
    """Root of each guard that is not positive at the end of a decided step; the earliest is returned."""
    first, when = -1, math.inf
    out = np.empty(3)
    for guard in range(forms.shape[0]):
        if ahead[guard, 0] <= 0.0:
            t = _root(rows, start, forms[guard], a, min(b, when), scratch, out)
            if t < when:
                first, when = guard, t
    return _CROSSING, first, when


@kernel
def _root(rows, start, form, low, high, scratch, out):
    """Root of a guard that falls from positive at ``low`` to not positive at ``high``: Halley's step, or bisection."""
    rate = 1.0 / _first_step(rows, math.inf)
    t = 0.5 * (low + high)
    for k in range(300):
        modal.flow_pairs(rows, start, t, scratch)
        modal.derivatives(rows, scratch, form, out)
        value, slope, curvature = out[0], out[1], out[2]
        if value > 0.0:
            low = t
        elif value == 0.0:
            return t
        else:  # negative, or overflown far beyond the root
            high = t
        new = t - 2.0 * value * slope / (2.0 * slope * slope - value * curvature)
        if low < new < high and (k < 8 or k % 2 == 0):
            if abs(new - t) * max(rate, abs(curvature / slope)) < 1e-5:
                return new
        else:
            new = 0.5 * (low + high)
            if new in (low, high):
                return new
        t = new
    return t
