"""Labels along a section: a function that is constant between finitely many places, and what is done with such ones."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lsvib.basins.kernels.itinerary import GRAZED
from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED


class Pieces(NamedTuple):
    """A function that is constant between ``edges`` (n + 1), with ``labels`` (n)."""

    edges: list[float]
    labels: list[int]


def touching(piece: tuple[float, float, int], sliver: float) -> bool:
    """Return whether the motions of a piece touch a guard or meet a corner to within rounding."""
    low, high, label = piece
    return label in (GRAZED, UNKNOWN) and high - low <= sliver + sliver * abs(low)


def merged(edges: list[float], labels: list[int], sliver: float) -> Pieces:
    """Join neighbours of one label; a piece that touches a guard or a corner takes the label of both neighbours."""
    pieces = Pieces(edges, labels)
    for _ in range(2):
        edges, labels = pieces
        keep = [k for k in range(len(labels)) if k == 0 or labels[k] != labels[k - 1]]
        edges, labels = [*(edges[k] for k in keep), edges[-1]], [labels[k] for k in keep]
        for k in range(1, len(labels) - 1):
            if touching((edges[k], edges[k + 1], labels[k]), sliver) and labels[k - 1] == labels[k + 1]:
                labels[k] = labels[k - 1]
        pieces = Pieces(edges, labels)
    return Pieces(edges, [UNRESOLVED if label == GRAZED else label for label in labels])


def completed(pieces: Pieces, other: Pieces) -> Pieces:
    """Return labels along a section from two searches: those of the second where the first left them unresolved."""
    cuts = np.unique([*pieces.edges, *other.edges])
    middles = 0.5 * (cuts[:-1] + cuts[1:])
    labels = [
        np.array([*one.labels, UNRESOLVED])[np.searchsorted(one.edges[:-1], middles, "right") - 1]
        for one in (pieces, other)
    ]
    best = np.where(labels[0] == UNRESOLVED, labels[1], labels[0])
    keep = np.flatnonzero(np.append(True, best[1:] != best[:-1]))
    return Pieces([*map(float, cuts[keep]), float(cuts[-1])], [*map(int, best[keep])])


def opened(pieces: Pieces, narrow: float) -> Pieces:
    """Return pieces of which unresolved ones are unknown, but those of a relative width up to ``narrow``."""
    low, high = np.array(pieces.edges[:-1]), np.array(pieces.edges[1:])
    wide = (np.array(pieces.labels) == UNRESOLVED) & (high - low > narrow * np.maximum(np.abs(low), np.abs(high)))
    return Pieces(pieces.edges, [*map(int, np.where(wide, UNKNOWN, pieces.labels))])


def agreed(runs: Sequence[Pieces], rounding: float) -> Pieces:
    """Return the labels on which several searches agree; the rest, widened by ``rounding``, is unresolved."""
    low, high = max(run.edges[0] for run in runs), min(run.edges[-1] for run in runs)
    cuts = np.unique(np.clip(np.concatenate([run.edges for run in runs]), low, high))
    seen = np.array([np.take(run.labels, np.searchsorted(run.edges, cuts[:-1], "right") - 1) for run in runs])
    common = np.where((seen == seen[0]).all(axis=0), seen[0], UNRESOLVED)
    edges, labels = [cuts[0]], [common[0]]
    for cut, label in zip(cuts[1:-1], common[1:], strict=True):
        if label == labels[-1]:
            continue
        if labels[-1] != UNRESOLVED:
            edges.append(cut - rounding)
            labels.append(UNRESOLVED)
        if label != UNRESOLVED:
            edges.append(cut + rounding)
            labels.append(label)
    return Pieces([*map(float, edges), float(cuts[-1])], [*map(int, labels)])
