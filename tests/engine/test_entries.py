"""Kernels that Python calls are entries; any other kernel is compiled once more where Python calls it."""

import numpy as np
import pytest

from lsvib.engine.kernels import event_loop, jit
from lsvib.engine.motion import tables_of

if jit.numba.config.DISABLE_JIT:
    pytest.skip("nothing is compiled", allow_module_level=True)


@pytest.mark.parametrize("kind", ["planar", "modal"])
def test_a_kernel_calls_the_kernel_of_the_kind_of_flow(kind):
    @jit.numba.njit
    def quarter(flow, state, out):
        event_loop.advance(flow, 0, state, 0.5 * np.pi, out)

    flow, out = tables_of(kind).flow, np.empty(2)
    quarter(flow, np.array([1.0, 0.0]), out)
    np.testing.assert_allclose(out, [0.0, -1.0], atol=1e-15)
