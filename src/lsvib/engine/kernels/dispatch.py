"""One name for each kernel that depends on the kind of flow (:mod:`lsvib.engine.kernels.jit`).

Since the choice is made by type when a kernel is compiled, a model compiles none of the kernels of the other kinds.
"""

import math

import numpy as np

from lsvib.engine.kernels import flow_modal, flow_planar, guard_sums, search_modal, search_planar
from lsvib.engine.kernels.flow_planar import level
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, by_kind, inlined_kernel, kernel
from lsvib.engine.kernels.layout import Found

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_LOST = int(Found.UNDECIDED)
_MANY = 1_000_000  # extremes in one arc


@allocating_kernel
def _no_workspace(flow, guards):
    return np.empty(0)


@kernel
def _planar_allow(flow, work, steps):
    pass  # the search for roots of two states has no steps


@kernel
def _allow(flow, work, steps):
    work.steps[0] = steps


@kernel
def _planar_steps_left(flow, work):
    return math.inf


@inlined_kernel
def _steps_left(flow, work):
    return work.steps[0]


@inlined_kernel
def _planar_search(flow, mode, state, guards, on_surface, limit, work):
    found, first, when = _NONE, -1, limit
    for guard in range(guards.shape[0]):
        outcome, t = search_planar.crossing(flow, mode, state, guards[guard], on_surface[guard], when)
        if outcome != _NONE:
            found, first, when = outcome, guard, t
    return found, first, when


@inlined_kernel
def _planar_travel(flow, mode, state, stay, scale, work):
    flow_planar.magnitudes(flow, mode, state, stay, scale)
    flow_planar.advance(flow, mode, state, stay, state)


@kernel
def _planar_is_still(flow, mode, state):
    return False  # the search for roots of two states sees it by itself


@inlined_kernel
def _modal_travel(flow, mode, state, stay, scale, work):
    flow_modal.travel(flow, mode, state, stay, scale, work.states)


advance = by_kind(flow_planar.advance, flow_modal.advance)
travel = by_kind(_planar_travel, _modal_travel)
workspace = by_kind(_no_workspace, guard_sums.room_for)
allow = by_kind(_planar_allow, _allow)
steps_left = by_kind(_planar_steps_left, _steps_left)
slopes_at = by_kind(flow_planar.slopes_at, flow_modal.slopes_at)
is_still = by_kind(_planar_is_still, flow_modal.is_still)
search = by_kind(_planar_search, search_modal.search)


@allocating_entry
def _searched_extremes(flow, mode, state, functional, duration):
    """Smallest and largest value of an affine function of the state over [0, duration] in a mode.

    The rate of the function is affine in the state as well; its roots are isolated one after the other.
    Arguments: ``functional`` (n + 1), finite duration [s]. Returns (smallest, largest), infinite if the search for a
    root does not end, or there are a million.
    """
    n = state.size
    work, guards, on_surface = workspace(flow, 1), np.zeros((1, n + 1)), np.zeros(1, dtype=np.bool_)
    rate, here, sizes = np.zeros(n + 1), np.empty(n), np.empty(n)
    moves = False
    for j in range(n + 1):
        for i in range(n):
            rate[j] += functional[i] * flow.field[mode, i, j]
        moves = moves or rate[j] != 0.0
    for i in range(n):  # element by element: whole arrays compile numba's texts of errors as well
        here[i] = state[i]
    low = high = level(functional, here, here)[0]
    if not moves:
        return low, high
    passed, sign = 0.0, 0.0
    for _ in range(_MANY):
        for i in range(n):
            sizes[i] = abs(here[i])
        value, size = level(rate, here, sizes)
        slope, _, _, _ = flow_modal.slopes_at(flow, mode, here, sizes, rate)
        on_surface[0] = sign != 0.0 or abs(value) <= size
        if sign == 0.0:
            sign = math.copysign(1.0, slope if on_surface[0] else value)
        for j in range(n + 1):
            guards[0, j] = sign * rate[j]
        found, _, stay = search(flow, mode, here, guards, on_surface, duration - passed, work)
        if found == _LOST:
            return -math.inf, math.inf
        if found == _NONE:
            break
        passed += stay
        advance(flow, mode, here, stay, here)
        value, _ = level(functional, here, here)
        low, high = min(low, value), max(high, value)
        if found == _CROSSING:
            sign = -sign
    else:
        return -math.inf, math.inf
    advance(flow, mode, state, duration, here)
    value, _ = level(functional, here, here)
    return min(low, value), max(high, value)


extremes = by_kind(search_planar.extremes, _searched_extremes)


@allocating_entry
def extremes_of_arcs(flow, modes, starts, durations, functionals):
    """Smallest and largest value over many arcs of a function that is affine in the state in each mode.

    Arguments: for each arc its mode (k), the state at its start (k, n) and its duration [s] (k); ``functionals``
    (modes, n + 1). Returns (smallest, largest), infinite if those of an arc are.
    """
    low, high = math.inf, -math.inf
    for k in range(modes.size):
        a, b = extremes(flow, modes[k], starts[k], functionals[modes[k]], durations[k])
        low, high = min(low, a), max(high, b)
    return low, high
