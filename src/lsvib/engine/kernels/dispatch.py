"""One name for each kernel that depends on the kind of flow; the choice is made by type when a kernel is compiled.

A flow is a plain table of oscillators (two states, :mod:`lsvib.engine.kernels.flow_planar`), a ``ModalFlow``
(:mod:`lsvib.engine.kernels.flow_modal`), or a ``BlockFlow`` (:mod:`lsvib.engine.kernels.flow_blocks`). Since the choice
is by type, a model compiles none of the kernels of the other kinds.
"""

import math

import numpy as np
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global

from lsvib.engine.kernels import (
    carried,
    flow_blocks,
    flow_modal,
    flow_planar,
    guard_sums,
    search_blocks,
    search_modal,
    search_planar,
)
from lsvib.engine.kernels.affine import level
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, kernel
from lsvib.engine.kernels.status import Found
from lsvib.engine.kernels.tables import BlockFlow

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)
_LOST = int(Found.UNDECIDED)
_MANY = 1_000_000  # extremes in one arc


@allocating_kernel
def _no_workspace(flow, guards):
    return np.empty(0)


@allocating_kernel
def _steps_alone(flow, guards):
    return np.full(1, math.inf)


@kernel
def _planar_allow(flow, work, steps):
    pass  # the search for roots of two states has no steps


@kernel
def _modal_allow(flow, work, steps):
    work.steps[0] = steps


@kernel
def _block_allow(flow, work, steps):
    work[0] = steps


@kernel
def _planar_steps_left(flow, work):
    return math.inf


@kernel
def _modal_steps_left(flow, work):
    return work.steps[0]


@kernel
def _block_steps_left(flow, work):
    return work[0]


@kernel
def _planar_search(flow, mode, state, guards, on_surface, limit, work):
    found, first, when = _NONE, -1, limit
    for guard in range(guards.shape[0]):
        outcome, t = search_planar.crossing(flow, mode, state, guards[guard], on_surface[guard], when)
        if outcome != _NONE:
            found, first, when = outcome, guard, t
    return found, first, when


@allocating_kernel
def _block_search(flow, mode, state, guards, on_surface, limit, work):
    return search_blocks.search(flow, mode, state, guards, on_surface, limit, work)


@kernel
def _planar_travel(flow, mode, state, stay, scale, work):
    flow_planar.magnitudes(flow, mode, state, stay, scale)
    flow_planar.advance(flow, mode, state, stay, state)


@kernel
def _planar_is_still(flow, mode, state):
    return False  # the search for roots of two states sees it by itself


@kernel
def _nothing(flow, *arguments):
    pass  # only modal flows carry guards from arc to arc


@kernel
def _as_the_state_says(flow, surface, sign, value, size, work):
    return math.nan, 0.0


@kernel
def _modal_travel(flow, mode, state, stay, scale, work):
    flow_modal.travel(flow, mode, state, stay, scale, work.states)


@allocating_kernel
def _block_travel(flow, mode, state, stay, scale, work):
    flow_blocks.travel(flow, mode, state, stay, scale)


def _by_kind(planar_kernel, modal_kernel, block_kernel):
    """Return a function for Python that chooses by type, registered so that kernels choose when they are compiled."""

    def chosen(is_array, flow_type):
        if is_array:
            return planar_kernel
        return block_kernel if flow_type is BlockFlow else modal_kernel

    def choose(flow, *arguments):
        return chosen(isinstance(flow, np.ndarray), type(flow))(flow, *arguments)

    class Choice(AbstractTemplate):
        """A call of the chosen kernel itself. An overload would call it in a function that is compiled with it."""

        key = choose

        def generic(self, arguments, keywords):
            return self._kernel(arguments).get_call_type(self.context, arguments, keywords)

        def get_impl_key(self, signature):
            return self._kernel(signature.args).get_impl_key(signature)

        def _kernel(self, arguments):
            flow = arguments[0]
            return types.Dispatcher(chosen(isinstance(flow, types.Array), getattr(flow, "instance_class", None)))

    infer_global(choose, types.Function(Choice))
    return choose


advance = _by_kind(flow_planar.advance, flow_modal.advance, flow_blocks.advance)
travel = _by_kind(_planar_travel, _modal_travel, _block_travel)
workspace = _by_kind(_no_workspace, guard_sums.room_for, _steps_alone)
allow = _by_kind(_planar_allow, _modal_allow, _block_allow)
steps_left = _by_kind(_planar_steps_left, _modal_steps_left, _block_steps_left)
slopes_at = _by_kind(flow_planar.slopes_at, flow_modal.slopes_at, flow_modal.slopes_at)
is_still = _by_kind(_planar_is_still, flow_modal.is_still, flow_modal.is_still)
search = _by_kind(_planar_search, search_modal.search, _block_search)
note = _by_kind(_nothing, carried.note, _nothing)
note_at_once = _by_kind(_nothing, carried.note_at_once, _nothing)
forget = _by_kind(_nothing, carried.forget, _nothing)
put_as_noted = _by_kind(_nothing, carried.put_as_noted, _nothing)
recalled = _by_kind(_as_the_state_says, carried.recalled, _as_the_state_says)
begin = _by_kind(_nothing, carried.begin, _nothing)
take_up = _by_kind(_nothing, carried.take_up, _nothing)
leave_behind = _by_kind(_nothing, carried.leave_behind, _nothing)


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


extremes = _by_kind(search_planar.extremes, _searched_extremes, _searched_extremes)
