"""The share of a window that settles, estimated from random starts as basin stability is, beside the exact one."""

import math
from dataclasses import replace

import numpy as np

from lsvib.basins.clipping import Window
from lsvib.basins.mapper import mapper
from lsvib.basins.planar_mapper import PlanarMapper
from lsvib.basins.resilience import Resilience, resilience
from lsvib.basins.shares import SampledShare, wilson
from lsvib.cycles.attractors import Attractor
from lsvib.drives.parameters import RigidParameters


def resilience_beside_samples(
    drive: RigidParameters, window: Window | None = None, samples: int = 0, seed: int = 0
) -> Resilience:
    """Return what the steady sliding of a rigid drive survives, with so many random starts in the window beside it.

    Arguments: as of :func:`lsvib.basins.resilience.resilience`; number of ``samples``, 0 for none; their ``seed``.
    Raises ``InputError`` and ``EngineError``.
    """
    found = resilience(drive, window)
    if window is None or not samples:
        return found
    return replace(found, sampled=sampled_share(drive, window, samples, seed))


def sampled_share(drive: RigidParameters, window: Window, samples: int, seed: int) -> SampledShare:
    """Return the share of random starts in a window that settle, by the labels of their motions.

    The labels are those of maps (:class:`lsvib.basins.planar_mapper.PlanarMapper`); the boundary plays no part.
    """
    mapped = mapper(drive)
    assert isinstance(mapped, PlanarMapper)
    rng = np.random.default_rng(seed)
    u = rng.uniform(window.left, window.right, samples)
    w = rng.uniform(window.bottom, window.top, samples)
    labels = mapped.labels_of(u, w)
    unresolved = int(np.sum(labels == Attractor.UNRESOLVED))
    hits, count = int(np.sum(labels == Attractor.STEADY_SLIDING)), samples - unresolved
    low, high = wilson(np.array(hits), np.array(count))
    return SampledShare(hits / count if count else math.nan, float(low), float(high), hits, samples, unresolved, seed)
