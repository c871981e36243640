"""Boundary-refined maps: a map of very many cells at the cost of its boundaries.

A block of level l is a square of 2^l × 2^l cells and has the label of one of its cells, near its middle. All blocks of
the coarsest level are computed. A block is divided into four of the next level if one of its eight neighbours has
another label. A new block may in turn have another label than a neighbour that was not divided: then the part of that
neighbour which touches it is computed as well, and so on, so that a boundary is followed wherever it goes. At the
finest level every cell with a neighbour of another label is therefore computed, and what is not computed is cut off
from every other label by cells that are. The map differs from the full one only by a region, or a hole, that no cell
computed at any level has hit; a seeded sample of cells looks for such, and is followed from any cell that it finds.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lsvib.basins.grid import Grid
from lsvib.basins.planar_mapper import PlanarMapper
from lsvib.cycles.attractors import Attractor

_COARSEST = 256  # blocks along an axis of the coarsest level, about; all of them are computed
_STRIPE = 512  # rows that are expanded at a time, so that memory stays bounded
_SAMPLE = 20_000  # cells drawn at random that are computed to check the map
_NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]


class Blocks(NamedTuple):
    """Blocks of one level, sorted by ``key`` = row · columns + column of the blocks: (n) and their labels (n)."""

    key: np.ndarray
    label: np.ndarray


def count(labels: np.ndarray) -> dict[Attractor, int]:
    """Return the number of cells of each attractor."""
    return {kind: int(np.count_nonzero(labels == kind)) for kind in Attractor}


@dataclass(frozen=True)
class RefinedMap:
    """A map as blocks of every level, ``levels[l]``; a block of a finer level lies upon those of coarser ones."""

    grid: Grid
    levels: tuple[Blocks, ...]
    corrected: int

    @property
    def computed(self) -> int:
        """Number of cells that were computed."""
        return sum(blocks.key.size for blocks in self.levels)

    def counts(self) -> dict[Attractor, int]:
        """Return the number of cells of the full grid with each label."""
        total = dict.fromkeys(Attractor, 0)
        for first in range(0, self.grid.y.count, _STRIPE):
            for kind, n in count(self.expand(slice(first, first + _STRIPE))).items():
                total[kind] += n
        return total

    def expand(self, rows: slice = slice(None)) -> np.ndarray:
        """Return the labels of these rows of the full grid, int8 (rows, columns)."""
        top, bottom, _ = rows.indices(self.grid.y.count)
        window = np.empty((max(0, bottom - top), self.grid.x.count), dtype=np.int8)
        for level in reversed(range(len(self.levels))):
            i, j = np.divmod(self.levels[level].key, _width(self.grid, level))
            size = 1 << level
            near = ((i + 1) * size > top) & (i * size < bottom)
            if level == 0:
                window[i[near] - top, j[near]] = self.levels[0].label[near]
                continue
            for row, column, label in zip(
                i[near] * size - top, j[near] * size, self.levels[level].label[near], strict=True
            ):
                window[max(row, 0) : row + size, column : column + size] = label
        return window


def refine(mapper: PlanarMapper, grid: Grid) -> RefinedMap:
    """Map a grid, computing only what lies near boundaries between labels, and a random sample of cells as a check.

    The cells computed have the same bits as in :meth:`PlanarMapper.cells`.
    """
    top = max(0, (max(grid.x.count, grid.y.count) // _COARSEST).bit_length() - 1)
    levels = [Blocks(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int8)) for _ in range(top + 1)]
    wanted = np.arange(_width(grid, top) * _height(grid, top))
    for level in reversed(range(top + 1)):
        _follow(mapper, grid, levels, level, wanted)
        if level > 0:
            wanted = _children(grid, level, _mixed(grid, levels, level))
    rng = np.random.default_rng(0)  # one sample for all, so that equal maps are equal files
    row, column = rng.integers(grid.y.count, size=_SAMPLE), rng.integers(grid.x.count, size=_SAMPLE)
    new = np.setdiff1d(row * grid.x.count + column, levels[0].key)  # each once, and none that is computed already
    row, column = np.divmod(new, grid.x.count)
    wrong = mapper.labels_at(grid, row, column) != _labels(grid, levels, 0, row, column)
    if wrong.any():
        _follow(mapper, grid, levels, 0, new[wrong])
    return RefinedMap(grid, tuple(levels), int(wrong.sum()))


def _width(grid: Grid, level: int) -> int:
    return -(-grid.x.count >> level)


def _height(grid: Grid, level: int) -> int:
    return -(-grid.y.count >> level)


def _follow(mapper: PlanarMapper, grid: Grid, levels: list[Blocks], level: int, wanted: np.ndarray) -> None:
    """Compute blocks of a level, and all blocks that touch one of another label, until there are no more."""
    half = (1 << level) >> 1
    while wanted.size:
        i, j = np.divmod(wanted, _width(grid, level))
        row = np.minimum((i << level) + half, grid.y.count - 1)
        column = np.minimum((j << level) + half, grid.x.count - 1)
        labels = mapper.labels_at(grid, row, column)
        key = np.concatenate([levels[level].key, wanted])
        order = np.argsort(key)
        levels[level] = Blocks(key[order], np.concatenate([levels[level].label, labels])[order])
        strangers = [
            near[theirs != labels[source]] for source, near, theirs in _neighbours(grid, levels, level, wanted)
        ]
        wanted = np.setdiff1d(np.concatenate(strangers), levels[level].key)


def _neighbours(grid: Grid, levels: list[Blocks], level: int, key: np.ndarray):
    """Yield, for each of eight directions, the indices of the blocks that have a neighbour there, its key and label."""
    width, height = _width(grid, level), _height(grid, level)
    row, column = np.divmod(key, width)
    for down, right in _NEIGHBOURS:
        i, j = row + down, column + right
        source = np.flatnonzero((i >= 0) & (i < height) & (j >= 0) & (j < width))
        i, j = i[source], j[source]
        yield source, i * width + j, _labels(grid, levels, level, i, j)


def _labels(grid: Grid, levels: list[Blocks], level: int, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Labels of blocks of a level, from the finest blocks of this or a coarser level that cover them."""
    labels, missing = np.empty(row.size, dtype=np.int8), np.ones(row.size, dtype=bool)
    for above in range(level, len(levels)):
        if not levels[above].key.size:
            continue
        key = (row >> above - level) * _width(grid, above) + (column >> above - level)
        place = np.minimum(np.searchsorted(levels[above].key, key), levels[above].key.size - 1)
        here = missing & (levels[above].key[place] == key)
        labels[here] = levels[above].label[place[here]]
        missing &= ~here
    return labels


def _mixed(grid: Grid, levels: list[Blocks], level: int) -> np.ndarray:
    """Keys of the blocks of a level that have a neighbour of another label."""
    blocks = levels[level]
    mixed = np.zeros(blocks.key.size, dtype=bool)
    for source, _, theirs in _neighbours(grid, levels, level, blocks.key):
        mixed[source] |= theirs != blocks.label[source]
    return blocks.key[mixed]


def _children(grid: Grid, level: int, key: np.ndarray) -> np.ndarray:
    """Keys of the four blocks of the next finer level that each block is divided into."""
    row, column = np.divmod(key, _width(grid, level))
    i = np.concatenate([2 * row + k for k in (0, 0, 1, 1)])
    j = np.concatenate([2 * column + k for k in (0, 1, 0, 1)])
    inside = (i < _height(grid, level - 1)) & (j < _width(grid, level - 1))
    return np.unique(i[inside] * _width(grid, level - 1) + j[inside])
