"""Affine functions of a state: rows of numbers, the constant after as many weights as the state has coordinates."""

from lsvib.engine.kernels.flow_planar import ROUNDING
from lsvib.engine.kernels.jit import inlined_entry, inlined_kernel


@inlined_kernel
def apply(table, vector, out):
    """Write the affine image of ``vector`` under the first columns and the last one of ``table`` to ``out``."""
    last = table.shape[1] - 1
    for i in range(out.size):
        total = table[i, last]
        for j in range(vector.size):
            total += table[i, j] * vector[j]
        out[i] = total


@inlined_entry
def level(row, state, scale):
    """Value of an affine function at a state (n), and the size below which it is rounding only.

    ``scale`` (n) are the magnitudes that the state was computed from; what stands in ``row`` behind n + 1 is not read.
    """
    value, size = row[state.size], abs(row[state.size])
    for i in range(state.size):
        value += row[i] * state[i]
        size += abs(row[i]) * scale[i]
    return value, ROUNDING * size
