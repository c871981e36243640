"""Motion in a single mode: its derivative by its start, its rate, and what it ends in if it never leaves.

``flow`` is of one kind, or, for ``field`` and ``stays``, of any (:class:`lsvib.systems.kernels.machine.AnyFlow`).
"""

import math
from enum import IntEnum

from lsvib.systems.kernels import flow_planar, saltation_taylor
from lsvib.systems.kernels.flow_planar import OVERFLOW, level, summed
from lsvib.systems.kernels.jit import by_kind, entry, kernel, on_stack
from lsvib.systems.kernels.layout import A0, A1, ALPHA, BETA, EQUILIBRIUM, B


class Outcome(IntEnum):
    """What a motion ends in, and why that is unresolved."""

    SLIDES = 0  # what never leaves its mode slides steadily, rests, oscillates for ever or grows
    RESTS = 1
    OSCILLATES = 2
    GROWS = 3
    CYCLE = 4
    KNOWN = 5  # it joins a known cycle
    SPENT = 6  # the budget is spent,
    SPENT_STEADILY = 7  # by a vibration that hardly changes,
    SEARCH_SPENT = 8  # or by the search for one event
    ACCUMULATES = 9  # events accumulate, and the model does not say what follows
    LOST = 10  # the engine has no answer
    OPEN = 11  # no mode fits the start


@kernel
def _planar_flow(flow, mode, start, time, out, size):
    c, s, s_rate = flow_planar.responses(flow[mode], time)
    out[0, 0], out[0, 1], out[1, 0], out[1, 1] = c, s, -flow[mode, A0] * s, s_rate
    for i in range(2):
        for j in range(2):
            size[i, j] = abs(out[i, j])


@kernel
def _modal_flow(flow, mode, start, time, out, size):
    n, pairs, singles = out.shape[0], flow.pairs[mode], flow.singles[mode]
    into, back = flow.to_modal[mode], flow.from_modal[mode]
    carried = on_stack((2 * pairs + singles, 2))  # of one column: its values and their sizes
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


@kernel
def _planar_field(flow, mode, state, rate, size):
    row = flow[mode]
    rate[0], size[0] = state[1], abs(state[1])
    rate[1] = row[B] - row[A0] * state[0] - row[A1] * state[1]
    size[1] = abs(row[B]) + abs(row[A0] * state[0]) + abs(row[A1] * state[1])


@kernel
def _modal_field(flow, mode, state, rate, size):
    for i in range(state.size):
        rate[i], size[i] = summed(flow.field[mode, i], state, state)


@kernel
def _stays_planar(flow, mode, state):
    row = flow[mode]
    if state[0] == row[EQUILIBRIUM] and state[1] == 0.0:
        return Outcome.SLIDES, 0.0
    if row[ALPHA] < 0.0:
        return Outcome.GROWS, 0.0
    lasts = row[ALPHA] == 0.0 and row[BETA] > 0.0
    return (Outcome.OSCILLATES, row[BETA]) if lasts else (Outcome.SLIDES, 0.0)


@kernel
def _excited(flow, mode, k, state):
    """Whether a modal coordinate of a state is not zero to rounding."""
    value, size = level(flow.to_modal[mode, k], state, state)
    return abs(value) > size


@kernel
def _stays_modal(flow, mode, state):
    pairs, lasting, frequency = flow.pairs[mode], 0, 0.0
    for single in range(flow.singles[mode]):
        if flow.rates[mode, single] > 0.0 and _excited(flow, mode, 2 * pairs + single, state):
            return Outcome.GROWS, 0.0
    for pair in range(pairs):
        damping, turning = flow.oscillators[mode, pair, ALPHA], flow.oscillators[mode, pair, BETA]
        if not (_excited(flow, mode, 2 * pair, state) or _excited(flow, mode, 2 * pair + 1, state)):
            continue
        # damping over frequency that is zero in a modal form, which is made from 150 digits
        if abs(damping) > 1e-30 * turning:
            if damping < 0.0:
                return Outcome.GROWS, 0.0
        elif turning > 0.0:
            lasting, frequency = lasting + 1, turning
    return (Outcome.OSCILLATES, frequency if lasting == 1 else 0.0) if lasting > 0 else (Outcome.SLIDES, 0.0)


# The derivative of the state after a time by that at the start, e^{At} of a linear flow, and the sizes of the terms of
# its entries, both (n, n).
derivative = by_kind(_planar_flow, _modal_flow, saltation_taylor.derivative)


@entry
def field(flow, mode, state, rate, size):
    """Write x′ at a state, and the sizes of its terms, both (n)."""
    if flow.planar.size > 0:
        _planar_field(flow.planar, mode, state, rate, size)
    elif flow.modal.field.size > 0:
        _modal_field(flow.modal, mode, state, rate, size)
    else:
        saltation_taylor.field(flow.taylor, mode, state, rate, size)


@kernel
def stays(flow, mode, state):
    """Return what a motion that never leaves its mode ends in, and the frequency [1/s] of what lasts, 0 if several."""
    if flow.planar.size > 0:
        return _stays_planar(flow.planar, mode, state)
    if flow.modal.field.size > 0:
        return _stays_modal(flow.modal, mode, state)
    return Outcome.SLIDES, 0.0  # by the region that no motion leaves; without end nothing else is known of it
