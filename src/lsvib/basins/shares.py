"""Shares that are estimated from samples, with their intervals."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_QUANTILE = 1.959964  # of the normal distribution, for an interval of 95 %


@dataclass(frozen=True)
class SampledShare:
    """A share estimated from random starts: ``hits`` of ``samples`` settle, a ``share`` of them [1].

    ``low`` and ``high`` end the interval of 95 % (Wilson 1927); ``unresolved`` starts lie on a boundary to rounding and
    are not counted; ``seed`` of the random numbers.
    """

    share: float
    low: float
    high: float
    hits: int
    samples: int
    unresolved: int
    seed: int


def wilson(part: NDArray[Any], total: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return both ends of the interval of 95 % of a share, ``part`` of ``total`` (Wilson 1927); nan where that is 0."""
    n, z = np.where(total, total, np.nan), _QUANTILE
    share = part / n
    middle = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
