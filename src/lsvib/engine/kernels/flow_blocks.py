r"""Flow of a mode by matrix exponentials of blocks: it carries what the modal form cannot.

The mode x′ = A x + b, written as a homogeneous field of (x, 1), is split into blocks of rates that lie close together,
z_c′ = B_c z_c (:mod:`lsvib.engine.exact.block_form`). Nothing is asked of the rates within a block: they may coincide,
with chains of any length. e^{B_c t} is the Taylor polynomial of degree 18 in B_c t / 2^s, squared s times, with s such
that ‖B_c t‖ ≤ 2^s; its remainder is then below 1.06 / 19! < 10⁻¹⁷.

Each block comes with a norm |R_c z_c| that obeys |R_c z_c(a + τ)| ≤ e^{σ_c τ} |R_c z_c(a)|;
:mod:`lsvib.engine.kernels.search_blocks` isolates roots with that.

Everything is written element by element: numba's own products of matrices need scipy, and its assignment of slices
compiles for minutes.
"""

import math

import numpy as np

from lsvib.engine.kernels.affine import apply
from lsvib.engine.kernels.jit import allocating_kernel, kernel

_DEGREE = 18  # of the Taylor polynomial


@kernel
def _multiply(left, right, low, high, factor, one, out):
    """Write ``factor`` · left · right + ``one`` · I of the blocks at ``low:high`` to the same place of ``out``."""
    for i in range(low, high):
        for j in range(low, high):
            total = 0.0
            for m in range(low, high):
                total += left[i, m] * right[m, j]
            out[i, j] = total * factor + (one if i == j else 0.0)


@kernel
def _exponential(matrix, low, high, t, out, scratch):
    """Write e^{B t} of the block at ``low:high`` of ``matrix`` to the same place of ``out``."""
    if high == low + 1:
        out[low, low] = math.exp(matrix[low, low] * t)
        return
    size = 0.0
    for i in range(low, high):
        row = 0.0
        for j in range(low, high):
            row += abs(matrix[i, j])
        size = max(size, row * t)
    squarings = max(0, math.ceil(math.log2(size))) if 1.0 < size < math.inf else 0
    step = t * 0.5**squarings
    for i in range(low, high):
        for j in range(low, high):
            out[i, j] = 1.0 if i == j else 0.0
    for k in range(_DEGREE, 0, -2):  # Horner: I + (B h / k) (…)
        _multiply(matrix, out, low, high, step / k, 1.0, scratch)
        _multiply(matrix, scratch, low, high, step / (k - 1), 1.0, out)
    for _ in range(squarings):
        _multiply(out, out, low, high, 1.0, 0.0, scratch)
        for i in range(low, high):
            for j in range(low, high):
                out[i, j] = scratch[i, j]


@kernel
def _propagator(flow, mode, t, work):
    """Write e^{B t} of all blocks to ``work[0]``; ``work`` (2, q, q)."""
    edges, count = flow.edges[mode], work.shape[1]
    for i in range(count):
        for j in range(count):
            work[0, i, j] = 0.0
    for block in range(edges.size - 1):
        if edges[block] < edges[block + 1]:
            _exponential(flow.matrix[mode], edges[block], edges[block + 1], t, work[0], work[1])


@kernel
def carry(flow, mode, start, t, out, work):
    """Write the block coordinates (q) a time t [s] after ``start`` to ``out``."""
    _propagator(flow, mode, t, work)
    for i in range(start.size):
        total = 0.0
        for j in range(start.size):
            total += work[0, i, j] * start[j]
        out[i] = total


@allocating_kernel
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    count = flow.matrix.shape[1]
    start, there = np.empty(count), np.empty(count)
    apply(flow.to_blocks[mode], state, start)
    carry(flow, mode, start, t, there, np.empty((2, count, count)))
    apply(flow.from_blocks[mode], there, out)


@allocating_kernel
def magnitudes(flow, mode, state, stay, scale):
    """Write to ``scale`` (n) the sizes of the terms that the state after a stay [s] in ``mode`` is summed from."""
    count = flow.matrix.shape[1]
    start, work = np.empty(count), np.empty((2, count, count))
    apply(flow.to_blocks[mode], state, start)
    _propagator(flow, mode, stay, work)
    for i in range(state.size):
        scale[i] = abs(flow.from_blocks[mode, i, count])
    for j in range(count):
        size = 0.0
        for k in range(count):
            size += abs(work[0, j, k] * start[k])
        for i in range(state.size):
            scale[i] += abs(flow.from_blocks[mode, i, j]) * size
