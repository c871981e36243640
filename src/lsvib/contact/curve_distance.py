"""Curves of motions in the phase plane, how far two of them lie apart, and how much of a motion is rest."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from lsvib.engine.motion import Motion

_BLOCK = 8  # points whose distances are formed at once, so that the arrays stay in the cache
_MEASURED = 40  # points of a curve whose distance from the other is measured, besides the ends of its arcs


def curve(motion: Motion, count: int) -> np.ndarray:
    """Return points (u, w) [rad, rad/s] along a motion, shape (k, 2), both ends of each arc among them.

    ``count`` points are shared out by duration, and half as many evenly among the arcs.
    """
    _, starts, ends, durations = motion.arcs()
    shares = max(2, count // (2 * durations.size)) + np.floor(count * durations / durations.sum()).astype(int)
    bounds = np.concatenate([[motion.start_time], motion.time, [motion.end_time]])
    times = np.concatenate([np.linspace(a, b, n) for a, b, n in zip(bounds[:-1], bounds[1:], shares, strict=True)])
    states, _ = motion.at(times)
    last = np.cumsum(shares) - 1
    states[last - shares + 1], states[last] = starts, ends
    return states[:, :2]


def farthest(points: np.ndarray, polygon: np.ndarray) -> float:
    """Return the largest distance of points (k, 2) from an open polygon through the corners (l, 2)."""
    corner_x, corner_y = np.ascontiguousarray(polygon.T)  # numbers that lie side by side are worked on twice as fast
    along_x, along_y = np.diff(corner_x), np.diff(corner_y)
    length = along_x**2 + along_y**2
    length[length == 0] = 1.0
    largest = 0.0
    for first in range(0, len(points), _BLOCK):
        block = points[first : first + _BLOCK]
        x, y = block[:, :1] - corner_x[:-1], block[:, 1:] - corner_y[:-1]
        part = np.clip((x * along_x + y * along_y) / length, 0.0, 1.0)
        squares = (x - part * along_x) ** 2 + (y - part * along_y) ** 2
        largest = max(largest, float(squares.min(axis=1).max()))
    return math.sqrt(largest)


@dataclass(frozen=True)
class Orbit:
    """The curve of a motion in the phase plane, in scales of u [rad] and w [rad/s]: a polygon, and points to measure.

    Jumps, along which only the rate changes, are sides of the polygon.
    """

    scales: tuple[float, float]
    polygon: np.ndarray
    points: np.ndarray

    @classmethod
    def of(cls, motion: Motion, scales: tuple[float, float], corners: int = 800) -> Self:
        """Sample a motion with about so many ``corners``, both ends of its arcs included."""
        return cls(scales, *(curve(motion, count) / np.array(scales) for count in (corners, _MEASURED)))

    def distance(self, other: Self) -> float:
        """Return the Hausdorff distance [1]: the largest distance of a point of either curve from the other one."""
        return max(farthest(self.points, other.polygon), farthest(other.points, self.polygon))


def rest_duration(motion: Motion) -> float:
    """Return the total time [s] that a motion spends at rest."""
    modes, _, _, durations = motion.arcs()
    return float(durations[np.isin(motion.automaton.codes[modes], motion.automaton.rest_codes)].sum())


def rest_count(motion: Motion) -> int:
    """Return how often a motion comes to rest; a rest that only begins as the motion ends is none."""
    modes, _, _, durations = motion.arcs()
    codes = motion.automaton.codes[modes[durations > 0]]
    return int(np.isin(codes, motion.automaton.rest_codes).sum())
