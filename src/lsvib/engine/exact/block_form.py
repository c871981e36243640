"""From a linear field to the tables of :mod:`lsvib.engine.kernels.flow_blocks`: blocks of rates that lie close
together.

The homogeneous field of (x, 1) has the rates of A and one more zero. The rates are put into groups: conjugate rates
belong together, and so do rates that lie near each other. Multiply the factors of all other groups: the columns V₀ and
rows W₀ of this product span the invariant subspaces of the group, whatever chains the group has, and with
W = (W₀ V₀)⁻¹ W₀ the block is B = W A V₀. If the projector V₀ W of a group amplifies rounding, the worst such group is
merged with its nearest one, until none does. So rates of 0 and 10⁻⁸ 1/s, which no motion of seconds can tell apart, end
up in one block, and a rate of 10¹¹ 1/s in another.

The d coordinates of a block are the projections of d homogeneous coordinates on its subspace, of those that are most
independent there, unless this makes |B| larger. With this choice a mismatch that is far larger than its typical size
does not spoil the other coordinates. The size of a block is |R y|, where R is the Cholesky factor of the P that solves
(B − σ)ᵀ P + P (B − σ) = −1; this brings the logarithmic norm of the block below σ. The smallest σ is taken for which R
is not too far from a multiple of the identity.
"""

import math
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import mpmath
import numpy as np

from lsvib.engine.exact.field import WORST_CONDITION, Field, amplification, homogeneous
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.errors import EngineError

_DIGITS = 120  # products of the factors of far groups use up some of them
_SAME = mpmath.mpf(10) ** -12  # relative size below which a rate, or its imaginary part, counts as zero
_APART = 0.25  # relative distance from which on two rates need not share a block
# Amplification of rounding by a group's projector above which the group is merged with its nearest one. It costs four
# digits at most, fewer than rates far apart in one block may cost.
_CONDITION = 1e4
_NORM_CONDITION = 200.0  # amplification by the norm of a block that is accepted whatever the block's own one is


class BlockMode(NamedTuple):
    """One mode in blocks: its tables, without the axis of the modes, and the largest amplification of rounding."""

    tables: BlockFlow
    condition: float


@dataclass(frozen=True)
class Block:
    """A block B = W A V of a matrix, the rows W that lead into it and the columns V that lead back."""

    matrix: mpmath.matrix  # (d, d)
    into: mpmath.matrix  # (d, p + 1), of coordinates in units of their sizes
    out: mpmath.matrix  # (p + 1, d)

    def turned(self, turn, back) -> "Block":
        """Return the block in the coordinates z = T y, from T and its inverse."""
        return Block(turn * self.matrix * back, turn * self.into, self.out * back)


@dataclass(frozen=True)
class _Norm:
    """The norm |R y| in which a block grows as e^{σt} at most."""

    factor: mpmath.matrix  # (d, d) R
    inverse: mpmath.matrix  # (d, d)
    growth: mpmath.mpf  # σ


def block_mode(field: Field) -> BlockMode:
    """Decompose a field. Raises ``EngineError`` if even so rounding is amplified by more than 1e6."""
    with mpmath.workdps(_DIGITS):
        matrix, push, sizes = field.reduced()
        rates = [*mpmath.eig(matrix, left=False, right=False), mpmath.mpf(0)]
        try:
            return _tables(field, [*sizes, mpmath.mpf(1)], _blocks(homogeneous(matrix, push, sizes), rates))
        except (ZeroDivisionError, ValueError, np.linalg.LinAlgError):  # no digit is left of the norm of a block
            raise EngineError(
                "the rates of a mode cannot be told apart with "
                f"{_DIGITS} digits; take parameters that lie less far apart."
            ) from None


def _blocks(matrix, rates) -> list[Block]:
    groups = _groups(rates)
    while True:
        blocks, losses = [], []
        for group in groups:
            try:
                blocks.append(block_of(matrix, group, [rate for g in groups if g is not group for rate in g]))
                losses.append(_amplification(blocks[-1]))
            except ZeroDivisionError:  # all digits
                losses.append(math.inf)
        worst = max(losses)
        if len(groups) == 1 or worst <= _CONDITION:
            return blocks
        group = groups.pop(losses.index(worst))
        nearest = min(groups, key=lambda other: min(abs(a - b) for a in group for b in other))
        nearest += group


def _groups(rates) -> list[list]:
    """Return groups of rates, in each of which every rate is near another one or the conjugate of one."""
    largest = max(abs(rate) for rate in rates)
    groups: list[list] = []
    for rate in rates:
        near = [g for g in groups if any(_near(rate, other, largest) for other in g)]
        groups = [g for g in groups if g not in near] + [[rate, *(other for g in near for other in g)]]
    return groups


def _near(a, b, largest) -> bool:
    distance = min(abs(a - b), abs(a - mpmath.conj(b)))
    return distance <= max(_APART * max(abs(a), abs(b)), _SAME * _SAME * largest)


def block_of(matrix, group, others) -> Block:
    """Return the block of a group of rates of a matrix (p + 1, p + 1), in the digits of the context.

    Raises ``ZeroDivisionError`` if these leave none of it.
    """
    product = mpmath.eye(matrix.rows)
    for rate in others:
        factor = matrix - rate * mpmath.eye(matrix.rows)
        product = product * (factor / mpmath.mnorm(factor, mpmath.inf))
    product = product.apply(mpmath.re)
    columns, rows = _basis(product, len(group)), _basis(product.T, len(group)).T
    rows = (rows * columns) ** -1 * rows
    chosen = max(combinations(range(matrix.rows), len(group)), key=lambda places: abs(_minor(columns, rows, places)))
    own = mpmath.matrix([[columns[i, j] for j in range(len(group))] for i in chosen])
    rows, columns = own * rows, columns * own**-1
    return Block(rows * matrix * columns, rows, columns)


def _minor(columns, rows, places):
    """Return the determinant of these rows and columns of the projector."""
    d = len(places)
    left = mpmath.matrix([[columns[i, j] for j in range(d)] for i in places])
    right = mpmath.matrix([[rows[i, j] for j in places] for i in range(d)])
    return mpmath.det(left) * mpmath.det(right)


def _basis(matrix, count: int) -> mpmath.matrix:
    """Orthonormal basis of the space that the columns of a matrix of rank ``count`` span, the longest ones first."""
    left = [matrix[:, j] for j in range(matrix.cols)]
    found = mpmath.zeros(matrix.rows, count)
    for k in range(count):
        longest = max(left, key=mpmath.norm)
        unit = longest / mpmath.norm(longest)
        found[:, k] = unit
        left = [column - unit * (unit.T * column)[0] for column in left]
    return found


def _amplification(block: Block) -> float:
    """Of rounding, by the way into a block and back; its coordinates and those of the state have size one."""
    size = block.out.rows
    return amplification(_floats(block.out), _floats(block.into), np.ones(size))


def _norm_of(block: Block) -> _Norm:
    """Return a norm in which the logarithmic norm of the block is below σ, with σ as small as possible."""
    d = block.matrix.rows
    rates = mpmath.eig(block.matrix, left=False, right=False) if d > 1 else [block.matrix[0, 0]]
    spectral = max(mpmath.re(rate) for rate in rates)
    size = mpmath.mnorm(block.matrix, mpmath.inf)
    if d == 1 or size == 0:
        return _Norm(mpmath.eye(d), mpmath.eye(d), spectral)
    fastest = max(abs(rate) for rate in rates)
    margin = -spectral / 2 if spectral < -_SAME * size else (fastest if fastest > _SAME * size else size) / 8
    most = max(_NORM_CONDITION, 4 * _amplification(block))
    while True:
        found = _lyapunov_norm(block.matrix, spectral + margin)
        if _amplification(block.turned(found.factor, found.inverse)) <= most or margin > 8 * size:
            return found
        margin *= 4


def _lyapunov_norm(matrix, growth) -> _Norm:
    d = matrix.rows
    shifted = matrix - growth * mpmath.eye(d)
    equations, right = mpmath.zeros(d * d), mpmath.zeros(d * d, 1)
    for i in range(d):
        for j in range(d):
            right[d * i + j] = -mpmath.mpf(i == j)
            for k in range(d):  # (Mᵀ P + P M)_ij
                equations[d * i + j, d * k + j] += shifted[k, i]
                equations[d * i + j, d * i + k] += shifted[k, j]
    solution = mpmath.lu_solve(equations, right)
    norm = mpmath.matrix([[(solution[d * i + j] + solution[d * j + i]) / 2 for j in range(d)] for i in range(d)])
    factor = mpmath.cholesky(norm / mpmath.mnorm(norm, mpmath.inf)).T
    return _Norm(factor, factor**-1, growth)


def _in_good_coordinates(block: Block, norm: _Norm) -> tuple[Block, _Norm]:
    """The block's own coordinates, or z = R y where these make |B| smaller.

    The exponential of B loses digits if the rates of |B|, which no choice of units changes, exceed those of B. In its
    own coordinates the B of a drive is close to triangular; the B of a chain in general position is not. Where it is
    triangular with zero rates, as at rest, its own coordinates stay: others would round u to the size of a constant.
    """
    d = block.matrix.rows
    own = _rate_of_sizes(block)
    turned = block.turned(norm.factor, norm.inverse)
    if float(_SAME * mpmath.mnorm(block.matrix, mpmath.inf)) < own > _rate_of_sizes(turned):
        return turned, _Norm(mpmath.eye(d), mpmath.eye(d), norm.growth)
    # Each coordinate in the unit whose norm is one, which makes B small.
    lengths = [mpmath.norm(norm.factor[:, j]) for j in range(d)]
    unit, inverse = mpmath.diag(lengths), mpmath.diag([1 / x for x in lengths])
    return block.turned(unit, inverse), _Norm(norm.factor * inverse, unit * norm.inverse, norm.growth)


def _rate_of_sizes(block: Block) -> float:
    """Return the largest rate [1/s] of |B|."""
    return float(np.abs(np.linalg.eigvals(np.abs(_floats(block.matrix)))).max())


def _floats(matrix) -> np.ndarray:
    return np.array(matrix.tolist(), dtype=float)


def _tables(field: Field, sizes: list, blocks: list[Block]) -> BlockMode:
    n, own = field.rows.rows, len(sizes)
    q = n + 1  # a mode in which some coordinates are kept is filled up with others that stay zero
    matrix, growth, edges = np.zeros((q, q)), np.zeros(q), np.full(q + 1, q)
    edges[: own + 1] = own
    norm, row_norm, rate = np.zeros((q, q)), np.zeros((q, q)), np.zeros(q)
    to_blocks, from_blocks = np.zeros((q, n + 1)), np.zeros((n, q + 1))
    places = [*field.alive, n]
    for i, value in field.kept.items():
        from_blocks[i, q] = float(value)
    first = 0
    for k, block in enumerate(blocks):
        d = block.matrix.rows
        part = slice(first, first + d)
        edges[k], first = first, first + d
        block, measure = _in_good_coordinates(block, _norm_of(block))
        matrix[part, part], norm[part, part] = _floats(block.matrix), _floats(measure.factor)
        row_norm[part, part] = _floats(measure.inverse).T
        # A little more than the growth, so that the bound covers the rounding of B.
        turned = _floats(measure.factor * block.matrix * measure.inverse)
        growth[part] = float(measure.growth) + 1e-14 * np.abs(turned).sum(axis=1)
        unit = np.frexp(np.abs(turned).max())[1]  # a power of two, so that no square overflows
        rate[part] = np.ldexp(np.linalg.norm(np.ldexp(turned, -unit)), unit)
        for j, place in enumerate(places):
            to_blocks[part, place] = [float(x / sizes[j]) for x in block.into[:, j]]
            if place < n:
                from_blocks[place, part] = [float(x * sizes[j]) for x in block.out[j, :]]
    condition = amplification(from_blocks[:, :own], to_blocks[:own], field.sizes)
    if not condition < WORST_CONDITION:
        raise EngineError(
            f"the coordinates of a mode cannot be told apart in double precision (condition {condition:.1e}); take "
            "parameters that lie less far apart."
        )
    tables = BlockFlow(matrix, norm, row_norm, rate, edges, growth, to_blocks, from_blocks, field.table())
    return BlockMode(tables, condition)


def block_flow(modes: list[BlockMode]) -> BlockFlow:
    """Put modes together in one table."""
    return BlockFlow(*map(np.array, zip(*(mode.tables for mode in modes), strict=True)))
