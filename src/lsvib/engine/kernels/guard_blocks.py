r"""Guards in a mode whose flow is carried in blocks: their values and derivatives, bounds of these, what they prove.

In the norm of each block, |z_c(a + τ)| ≤ e^{σ_c τ} |z_c(a)| (:mod:`lsvib.engine.kernels.flow_blocks`). With the norm of
rows that belongs to it, a guard g = g₀ + Σ_c g_c z_c obeys, for any h and any j ≤ k,

    |g^{(k)}| ≤ M_k = Σ_c max(1, e^{σ_c h}) min_j |g_c B_c^{k−j}| |B_c^j z_c(a)|      on [a, a + h].

With |f − chord of f| ≤ max|f″| h²/8 for any f, a guard that is not negative at a is decided on [a, b] if

    min(g_a, g_b)   > M₂ h²/8      g stays positive: no root;
    min(g′_a, g′_b) > M₃ h²/8      g rises: no root;
    max(g′_a, g′_b) < −M₃ h²/8     g falls: one root if g_b ≤ 0, else none;
    min(g″_a, g″_b) > M₄ h²/8      g is convex: no root if it also starts without falling.
"""

import math

from lsvib.engine.kernels.flow_planar import EPS
from lsvib.engine.kernels.jit import kernel

POSITIVE, TOUCHES, ROOT, UNDECIDED = range(4)
ORDERS = 5  # derivatives 0 to 4
NOISE = 64.0  # relative rounding of a block's coordinates, in units of EPS; more by the angle that they have turned
LONGEST = 64.0  # largest factor by which a test counts as passed: the next step is at most 0.7 √64 = 5.6 times as long


@kernel
def forms(flow, mode, guards, weights, constants, sizes):
    """Write g_c B_c^k to ``weights`` (g, k, q), g₀ to ``constants`` (g), and the norms of the former to ``sizes``.

    The norm of a block's part stands at the block's first place; the other places are zero.
    """
    table, edges = flow.from_blocks[mode], flow.edges[mode]
    n, size = guards.shape[1] - 1, table.shape[1] - 1
    for guard in range(guards.shape[0]):
        constants[guard] = guards[guard, n]
        for i in range(n):
            constants[guard] += guards[guard, i] * table[i, size]
        for j in range(size):
            weights[guard, 0, j] = 0.0
            for i in range(n):
                weights[guard, 0, j] += guards[guard, i] * table[i, j]
        for k in range(1, ORDERS):
            for j in range(size):
                weights[guard, k, j] = 0.0
                for i in range(size):
                    weights[guard, k, j] += weights[guard, k - 1, i] * flow.matrix[mode, i, j]
        for k in range(ORDERS):
            _norms(flow.row_norm[mode], True, weights[guard, k], edges, sizes[guard, k])


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
def derivative_sizes(flow, mode, z, t, out, noise, moving):
    """Write bounds of |B_c^k z_c| (k, q) at time ``t``, the rounding of z included, to each block's first place.

    ``noise`` (q) and ``moving`` (2, q) are scratch space.
    """
    matrix, edges, factor, rates = flow.matrix[mode], flow.edges[mode], flow.norm[mode], flow.rate[mode]
    now, following = moving[0], moving[1]
    for i in range(z.size):
        now[i] = z[i]
    _norms(factor, False, z, edges, noise)
    for k in range(ORDERS):
        _norms(factor, False, now, edges, out[k])
        for i in range(z.size):
            total = 0.0
            for j in range(z.size):
                total += matrix[i, j] * now[j]
            following[i] = total
        now, following = following, now
        for block in range(edges.size - 1):
            first, last = edges[block], edges[block + 1]
            if first < last:
                out[k, first] += EPS * (NOISE + rates[first] * t) * noise[first]
                noise[first] *= rates[first]


@kernel
def bound(sizes, moved, growth, k, step):
    """Return M_k of a guard on a step [s], see the module docstring."""
    total = 0.0
    for place in range(growth.size):
        least = sizes[k, place] * moved[0, place]
        for j in range(1, k + 1):
            least = min(least, sizes[k - j, place] * moved[j, place])
        if least > 0.0:
            total += least * math.exp(max(0.0, growth[place] * step))
    return total


@kernel
def decide(here, there, sizes, moved, growth, step, rounding, starts_on_surface):
    """Decide what a guard does on one step, by the tests of the module docstring.

    ``here`` and ``there`` (3) are the guard and two derivatives at the ends of the step [s]. Returns the decision and
    the factor by which the test passes that decides; at most 1 if none does.
    """
    eighth = 0.125 * step * step
    second = bound(sizes, moved, growth, 2, step) * eighth
    least = min(here[0], there[0])
    if least > second:
        return POSITIVE, least / second if second > 0.0 else LONGEST
    third = bound(sizes, moved, growth, 3, step) * eighth
    slowest = min(here[1], there[1])
    if slowest > third:
        return POSITIVE, slowest / third if third > 0.0 else LONGEST
    fall = -max(here[1], there[1])
    if fall > third:
        return ROOT if there[0] <= 0.0 else POSITIVE, fall / third if third > 0.0 else LONGEST
    slack = max(least / second, slowest / third, fall / third, 0.0)
    if here[1] >= 0.0:
        fourth = bound(sizes, moved, growth, 4, step) * eighth
        curve = min(here[2], there[2])
        if curve > fourth:
            return POSITIVE, curve / fourth if fourth > 0.0 else LONGEST
        slack = max(slack, curve / fourth)
    if second < rounding:
        # On so short a step the guard is its chord to rounding: it rests on zero, or it touches it.
        if least > rounding:
            return POSITIVE, LONGEST
        if there[0] <= -rounding:
            return ROOT, LONGEST
        falls = there[0] >= 0.0 and there[1] <= 0.0  # and may die away without ever touching zero
        return POSITIVE if starts_on_surface or falls else TOUCHES, LONGEST
    return UNDECIDED, slack


@kernel
def values(weights, constants, z, out):
    """Write each guard and its first two derivatives to its row of ``out`` (g, 3)."""
    for guard in range(constants.size):
        for k in range(3):
            total = constants[guard] if k == 0 else 0.0
            for i in range(z.size):
                total += weights[guard, k, i] * z[i]
            out[guard, k] = total


@kernel
def rounding(weights, constant, z):
    """Return the size of the rounding of a guard with these weights (q)."""
    total = abs(constant)
    for i in range(z.size):
        total += abs(weights[i] * z[i])
    return 8.0 * EPS * total


@kernel
def fastest(matrix):
    """Return a bound of the rates [1/s] of a mode: the largest row sum of its matrix."""
    fastest = 0.0
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += abs(matrix[i, j])
        fastest = max(fastest, total)
    return fastest


@kernel
def never(flow, mode, z, weights, constants, sizes, moved):
    """Return whether all blocks that move die away, and the guards stay positive until they have."""
    edges, growth = flow.edges[mode], flow.growth[mode]
    for guard in range(constants.size):
        level = constants[guard]
        for block in range(edges.size - 1):
            first, last = edges[block], edges[block + 1]
            if first == last:
                continue
            if last == first + 1 and flow.matrix[mode, first, first] == 0.0:
                level += weights[guard, 0, first] * z[first]
            elif growth[first] < 0.0:
                level -= sizes[guard, 0, first] * moved[0, first]
            else:
                return False
        if not level > 0.0:
            return False
    return True
