r"""Flow of a mode by matrix exponentials of blocks: it carries what the modal form cannot.

The mode x′ = A x + b, written as a homogeneous field of (x, 1), is split into blocks of rates that lie close together,
z_c′ = B_c z_c (:mod:`lsvib.engine.exact.block_form`). Nothing is asked of the rates within a block: they may coincide,
with chains of any length. e^{B_c t} is the Taylor polynomial of degree 18 in B_c t / 2^s, squared s times, with s such
that ‖B_c t‖ ≤ 2^s; its remainder is then below 1.06 / 19! < 10⁻¹⁷.

A coordinate that is the small difference of large terms, as a mismatch of 10⁻⁹ m beside a seat at 0.1 m, is moved by
the change of the block coordinates, (e^{B t} − 1) z. It has its own digits: D = e^{B t} − 1 is the same polynomial
without its first term, and D(2t) = D(t) (D(t) + 2).

Each block comes with a norm |R_c z_c| that obeys |R_c z_c(a + τ)| ≤ e^{σ_c τ} |R_c z_c(a)|;
:mod:`lsvib.engine.kernels.search_steps` isolates roots with that.

Everything is written element by element: numba's own products of matrices need scipy, and its assignment of slices
compiles for minutes.
"""

import math

import numpy as np

from lsvib.engine.kernels.affine import apply
from lsvib.engine.kernels.flow_modal import FAR
from lsvib.engine.kernels.flow_planar import OVERFLOW
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, entry, kernel

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
def _squarings(matrix, low, high, t):
    """Return ‖B t‖ of the block at ``low:high`` of ``matrix``, and how often a step of t / 2^s is squared."""
    size = 0.0
    for i in range(low, high):
        row = 0.0
        for j in range(low, high):
            row += abs(matrix[i, j])
        size = max(size, row * t)
    return size, max(0, math.ceil(math.log2(size))) if 1.0 < size < math.inf else 0


@kernel
def _exponential(matrix, low, high, t, out, scratch):
    """Write e^{B t} of the block at ``low:high`` of ``matrix`` to the same place of ``out``."""
    if high == low + 1:
        out[low, low] = math.exp(matrix[low, low] * t)
        return
    _, squarings = _squarings(matrix, low, high, t)
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


@entry
def carry(flow, mode, start, t, out, work):
    """Write the block coordinates (q) a time t [s] after ``start`` to ``out``."""
    _propagator(flow, mode, t, work)
    for i in range(start.size):
        total = 0.0
        for j in range(start.size):
            total += work[0, i, j] * start[j]
        out[i] = total


@kernel
def _increment(matrix, low, high, t, out, scratch):
    """Write e^{B t} − 1 of the block at ``low:high`` of ``matrix`` to the same place of ``out``; returns ‖B t‖ ≤ 1.

    The norm that is returned is cut off at 1: what rounds the exponential is that part of it.
    """
    size, squarings = _squarings(matrix, low, high, t)
    if high == low + 1:
        out[low, low] = math.expm1(min(matrix[low, low] * t, OVERFLOW))
        return min(size, 1.0)
    step = t * 0.5**squarings
    for i in range(low, high):
        for j in range(low, high):
            out[i, j] = matrix[i, j] * step / _DEGREE
    for k in range(_DEGREE - 1, 0, -1):  # Horner: (B h / k) (1 + …)
        for i in range(low, high):
            out[i, i] += 1.0
        _multiply(matrix, out, low, high, step / k, 0.0, scratch)
        for i in range(low, high):
            for j in range(low, high):
                out[i, j] = scratch[i, j]
    for _ in range(squarings):
        _multiply(out, out, low, high, 1.0, 0.0, scratch)
        for i in range(low, high):
            for j in range(low, high):
                out[i, j] = scratch[i, j] + 2.0 * out[i, j]
    return min(size, 1.0)


@kernel
def change(flow, mode, start, t, out, sizes, work):
    """Write the change of the block coordinates (q) within a time t [s] to ``out``, and the sizes of its terms."""
    edges = flow.edges[mode]
    for block in range(edges.size - 1):
        low, high = edges[block], edges[block + 1]
        if low == high:
            continue
        part = _increment(flow.matrix[mode], low, high, t, work[0], work[1])
        for i in range(low, high):
            out[i], sizes[i] = 0.0, 0.0
            for j in range(low, high):
                out[i] += work[0, i, j] * start[j]
                sizes[i] += (abs(work[0, i, j]) + part) * abs(start[j])


@allocating_kernel
def _move(flow, mode, state, t, scale):
    """Replace ``state`` by the one after a time t [s] in ``mode``, and the sizes in ``scale`` of what is moved."""
    n, count, table = state.size, flow.matrix.shape[1], flow.from_blocks[mode]
    start, there, moves, sizes = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    work, changed = np.empty((2, count, count)), False
    apply(flow.to_blocks[mode], state, start)
    carry(flow, mode, start, t, there, work)
    for i in range(n):
        total, size, before = table[i, count], abs(table[i, count]), state[i]
        for j in range(count):
            part = table[i, j] * there[j]
            total += part
            size += abs(part)
        state[i] = total
        if size > FAR * max(abs(before), abs(total)):
            if not changed:
                change(flow, mode, start, t, moves, sizes, work)
                changed = True
            total, size = before, abs(before)
            for j in range(count):
                total += table[i, j] * moves[j]
                size += abs(table[i, j]) * sizes[j]
            if math.isfinite(total):
                state[i], scale[i] = total, size


@allocating_entry
def advance(flow, mode, state, t, out):
    """Write the state after a time t [s] in ``mode`` to ``out`` (may be ``state`` itself)."""
    for i in range(state.size):
        out[i] = state[i]
    _move(flow, mode, out, t, np.empty(state.size))


@allocating_kernel
def travel(flow, mode, state, stay, scale):
    """Replace ``state`` by the one after a stay [s] in ``mode``, and write to ``scale`` (n) the sizes of its terms."""
    _magnitudes(flow, mode, state, stay, scale)
    _move(flow, mode, state, stay, scale)


@allocating_kernel
def _magnitudes(flow, mode, state, stay, scale):
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
