"""The choice of a kernel by the kind of flow, made by type when what calls it is compiled.

A flow is a plain table of oscillators (two states, :mod:`lsvib.engine.kernels.flow_planar`) or a ``ModalFlow``
(:mod:`lsvib.engine.kernels.flow_modal`).
"""

import numpy as np
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global


def by_kind(planar_kernel, modal_kernel):
    """Return a function for Python that chooses by type, registered so that kernels choose when they are compiled.

    The flow is its first argument.
    """

    def choose(flow, *arguments):
        return (planar_kernel if isinstance(flow, np.ndarray) else modal_kernel)(flow, *arguments)

    class Choice(AbstractTemplate):
        """A call of the chosen kernel itself. An overload would call it in a function that is compiled with it."""

        key = choose

        def generic(self, arguments, keywords):
            return self._kernel(arguments).get_call_type(self.context, arguments, keywords)

        def get_impl_key(self, signature):
            return self._kernel(signature.args).get_impl_key(signature)

        def _kernel(self, arguments):
            return types.Dispatcher(planar_kernel if isinstance(arguments[0], types.Array) else modal_kernel)

    infer_global(choose, types.Function(Choice))
    return choose
