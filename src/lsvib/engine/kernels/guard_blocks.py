r"""Guards in a mode whose flow is carried in blocks: their values and derivatives, and bounds of these.

In the norm of each block, |z_c(a + τ)| ≤ e^{σ_c τ} |z_c(a)| (:mod:`lsvib.engine.kernels.flow_blocks`). With the norm of
rows that belongs to it, a guard g = g₀ + Σ_c g_c z_c obeys, for any h and any j ≤ k,

    |g^{(k)}| ≤ M_k = Σ_c max(1, e^{σ_c h}) min_j |g_c B_c^{k−j}| |B_c^j z_c(a)|      on [a, a + h].

The norm of a block's part stands at the block's first place; the other places are zero.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.engine.kernels.affine import apply
from lsvib.engine.kernels.flow_blocks import carry, change
from lsvib.engine.kernels.flow_planar import EPS
from lsvib.engine.kernels.jit import allocating_kernel, inlined_kernel, kernel

ORDERS = 5  # derivatives 0 to 4
_NOISE = 64.0  # relative rounding of a block's coordinates, in units of EPS; more by the angle that they have turned
_SUM = 8.0  # relative rounding of a sum, in units of EPS
_LARGEST = 1e200  # beyond it a coordinate is about to overflow


class BlockSums(NamedTuple):
    """Up to g guards in a mode of q block coordinates, and their values at up to three times."""

    start: np.ndarray  # (q,) the block coordinates at time zero
    states: np.ndarray  # (3, q) and at a time
    starts: np.ndarray  # (g,) each guard at time zero, from the state itself
    known: np.ndarray  # (g,) not a number: of no guard more is known than the state holds
    constants: np.ndarray  # (g,) g₀
    weights: np.ndarray  # (g, orders, q) g_c B_c^k
    sizes: np.ndarray  # (g, orders, q) the norms of these
    moved: np.ndarray  # (orders, q) bounds of |B_c^k z_c| at the start of a step, the rounding of z included
    rounding_at_start: np.ndarray  # (g,) size of a guard at time zero below which it is rounding only
    rounding: np.ndarray  # (g,) the same on the present step
    values: np.ndarray  # (3, g, 3) a guard and its first two derivatives at a time
    vectors: np.ndarray  # (4, q) scratch space
    matrices: np.ndarray  # (2, q, q) scratch space
    steps: np.ndarray  # (1,) steps that searches may still take; infinite at first


@allocating_kernel
def room_for(flow, guards):
    """Return uninitialised ``BlockSums`` for so many guards, with steps without end."""
    size = flow.matrix.shape[1]
    return BlockSums(
        np.empty(size),
        np.empty((3, size)),
        np.empty(guards),
        np.full(guards, math.nan),
        np.empty(guards),
        np.empty((guards, ORDERS, size)),
        np.empty((guards, ORDERS, size)),
        np.empty((ORDERS, size)),
        np.empty(guards),
        np.empty(guards),
        np.empty((3, guards, 3)),
        np.empty((4, size)),
        np.empty((2, size, size)),
        np.full(1, math.inf),
    )


@kernel
def prepare(flow, mode, state, guards, sums):
    """Form the parts of guards (g, n + 1) from a state (n), and their values at time zero as node 0."""
    table, edges = flow.from_blocks[mode], flow.edges[mode]
    n, size = state.size, sums.start.size
    apply(flow.to_blocks[mode], state, sums.start)
    for i in range(size):
        sums.states[0, i] = sums.start[i]
    for guard in range(guards.shape[0]):
        weights = sums.weights[guard]
        sums.constants[guard] = guards[guard, n]
        for i in range(n):
            sums.constants[guard] += guards[guard, i] * table[i, size]
        for j in range(size):
            weights[0, j] = 0.0
            for i in range(n):
                weights[0, j] += guards[guard, i] * table[i, j]
        for k in range(1, ORDERS):
            for j in range(size):
                weights[k, j] = 0.0
                for i in range(size):
                    weights[k, j] += weights[k - 1, i] * flow.matrix[mode, i, j]
        for k in range(ORDERS):
            _norms(flow.row_norm[mode], True, weights[k], edges, sums.sizes[guard, k])
        evaluate(flow, mode, sums, guard, 0)
        sums.rounding_at_start[guard] = rounding_at(flow, mode, sums, guard, 0)


@kernel
def _norms(triangle, lower, vector, edges, out):
    """Write the norm of each block's part of T v, with T lower or else upper triangular, to its first place.

    The other places are zero. Of the zeros of T nothing is added, as what they multiply may be infinite.
    """
    for i in range(out.size):
        out[i] = 0.0
    for block in range(edges.size - 1):
        first, last, total = edges[block], edges[block + 1], 0.0
        for i in range(first, last):
            begin, end, part = (first, i + 1, 0.0) if lower else (i, last, 0.0)
            for j in range(begin, end):
                part += triangle[i, j] * vector[j]
            total += part * part
        if total > 0.0:
            out[first] = math.sqrt(total)


@kernel
def stand(flow, mode, sums, node, t):
    """Make ready what bounds on a step from the node at t [s] need. False: a coordinate is about to overflow."""
    matrix, edges, factor, rates = flow.matrix[mode], flow.edges[mode], flow.norm[mode], flow.rate[mode]
    now, following, noise, moved = sums.vectors[0], sums.vectors[1], sums.vectors[2], sums.moved
    for i in range(now.size):
        now[i] = sums.states[node, i]
        if not abs(now[i]) < _LARGEST:
            return False
    _norms(factor, False, now, edges, noise)
    for k in range(ORDERS):
        _norms(factor, False, now, edges, moved[k])
        for i in range(now.size):
            total = 0.0
            for j in range(now.size):
                total += matrix[i, j] * now[j]
            following[i] = total
        now, following = following, now
        for block in range(edges.size - 1):
            first, last = edges[block], edges[block + 1]
            if first < last:
                moved[k, first] += EPS * (_NOISE + rates[first] * t) * noise[first]
                noise[first] *= rates[first]
    return True


@kernel
def bound(flow, mode, sums, guard, k, step):
    """Return M_k of a guard on a step [s], see the module docstring."""
    sizes, moved, growth, total = sums.sizes[guard], sums.moved, flow.growth[mode], 0.0
    for place in range(growth.size):
        least = sizes[k, place] * moved[0, place]
        for j in range(1, k + 1):
            least = min(least, sizes[k - j, place] * moved[j, place])
        if least > 0.0:
            total += least * math.exp(max(0.0, growth[place] * step))
    return total


@kernel
def go_to(flow, mode, sums, t, node):
    """Write the block coordinates at time t [s] as a node."""
    carry(flow, mode, sums.start, t, sums.states[node], sums.matrices)


@kernel
def evaluate(flow, mode, sums, guard, node):
    """Write a guard and its first two derivatives at a node to ``values``."""
    for k in range(3):
        total = sums.constants[guard] if k == 0 else 0.0
        for i in range(sums.start.size):
            total += sums.weights[guard, k, i] * sums.states[node, i]
        sums.values[node, guard, k] = total


@kernel
def rounding_at(flow, mode, sums, guard, node):
    """Return the size of a guard at a node below which it is rounding only."""
    total = abs(sums.constants[guard])
    for i in range(sums.start.size):
        total += abs(sums.weights[guard, 0, i] * sums.states[node, i])
    return _SUM * EPS * total


@kernel
def changed(flow, mode, sums, index, guard, t):
    """Return a guard at time t [s], and its rounding, as :func:`lsvib.engine.kernels.guard_sums.changed` does."""
    moves, sizes = sums.vectors[0], sums.vectors[1]
    change(flow, mode, sums.start, t, moves, sizes, sums.matrices)
    value, total = sums.starts[index], abs(sums.starts[index])
    for j in range(moves.size):
        value += sums.weights[index, 0, j] * moves[j]
        total += abs(sums.weights[index, 0, j]) * sizes[j]
    return value, _SUM * EPS * total


@kernel
def lowest_from(flow, mode, sums, guard, node, t):
    """Return a lower bound of a guard for all times from the node at t [s] on; −∞ if a block that moves may grow."""
    edges, growth, level = flow.edges[mode], flow.growth[mode], sums.constants[guard]
    for block in range(edges.size - 1):
        first, last = edges[block], edges[block + 1]
        if first == last:
            continue
        if last == first + 1 and flow.matrix[mode, first, first] == 0.0:
            level += sums.weights[guard, 0, first] * sums.states[node, first]
        elif growth[first] < 0.0:
            level -= sums.sizes[guard, 0, first] * sums.moved[0, first]
        else:
            return -math.inf
    return level


@inlined_kernel
def rounding_at_start(flow, sums, guard):
    """Return the size of a guard at time zero below which it is rounding only."""
    return sums.rounding_at_start[guard]


@inlined_kernel
def looseness(flow):
    """Return how many times the rounding of its sum a guard may be wrong: an exponential of a block has lost more."""
    return _NOISE / _SUM
