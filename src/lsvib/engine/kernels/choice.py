"""The choice of a kernel by the kind of flow, made by type when what calls it is compiled.

A flow is a plain table of oscillators (two states, :mod:`lsvib.engine.kernels.flow_planar`), a ``ModalFlow``
(:mod:`lsvib.engine.kernels.flow_modal`), or a ``BlockFlow`` (:mod:`lsvib.engine.kernels.flow_blocks`).
"""

import numpy as np
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global

from lsvib.engine.kernels.tables import BlockFlow


def by_kind(planar_kernel, modal_kernel, block_kernel):
    """Return a function for Python that chooses by type, registered so that kernels choose when they are compiled.

    The flow is its first argument. A kernel that a kind of flow has no use for is None.
    """

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
