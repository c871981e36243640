"""One name for each kernel that depends on the kind of flow; the choice is made by type when a kernel is compiled.

A flow is either a plain table of oscillators (two states, :mod:`lsvib.core.planar`) or a ``ModalFlow``
(:mod:`lsvib.core.modal`). Since the choice is by type, a planar model compiles none of the modal kernels.
"""

import numpy as np
from numba import types
from numba.extending import overload

from lsvib.core import modal, planar, walk
from lsvib.core.jit import kernel
from lsvib.core.status import Found

_NONE = int(Found.NONE)


@kernel
def _planar_first_crossing(flow, mode, state, guards, on_surface, limit):
    found, first, when = _NONE, -1, limit
    for guard in range(guards.shape[0]):
        outcome, t = planar.crossing(flow, mode, state, guards[guard], on_surface[guard], when)
        if outcome != _NONE:
            found, first, when = outcome, guard, t
    return found, first, when


def _by_kind(planar_kernel, modal_kernel):
    """Return a function for Python that chooses by type, registered so that kernels choose when they are compiled."""

    def choose(flow, *arguments):
        return (planar_kernel if isinstance(flow, np.ndarray) else modal_kernel)(flow, *arguments)

    def choose_typed(flow, *arguments):
        chosen = planar_kernel if isinstance(flow, types.Array) else modal_kernel
        return lambda flow, *arguments: chosen(flow, *arguments)

    overload(choose)(choose_typed)
    return choose


advance = _by_kind(planar.advance, modal.advance)
magnitudes = _by_kind(planar.magnitudes, modal.magnitudes)
guard_at = _by_kind(planar.guard_at, modal.guard_at)
first_crossing = _by_kind(_planar_first_crossing, walk.first_crossing)
extremes = _by_kind(planar.extremes, walk.extremes)
