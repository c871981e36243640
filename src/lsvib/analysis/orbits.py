"""Cycles of models with many states, and how far two orbits lie apart in the phase plane.

A contact of finite stiffness creeps: in slip its deflection follows at the rate k_c / c_c, so that the return map of a
cycle of period T has the multiplier exp(−T k_c / c_c), close to one in the viscous limit. All other multipliers are
small. The fixed point is therefore extrapolated along the slow direction (Aitken's method for vectors): with the last
steps d₁, d₂ of the map and λ = d₁·d₂ / d₁·d₁, it lies near x + λ / (1 − λ) d₂.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from lsvib.analysis.cycles import SteadyState, steady_state
from lsvib.core.status import Status
from lsvib.errors import EngineError
from lsvib.models.automaton import Automaton
from lsvib.models.motion import Motion, follow

_APPROACH = 64  # events after which the return map is watched; a return that takes more is not extrapolated
_RETURNS = 4  # of the map before each extrapolation, in which the fast multipliers die out
_ROUNDS = 12
_BLOCK = 8  # points whose distances are formed at once, so that the arrays stay in the cache
_SAME = 1e-13  # relative change of the section state in one return that is rounding
_MEASURED = 40  # points of a curve, besides its arcs' ends, whose distance is measured


def settled_orbit(automaton: Automaton, state, *, max_events: int = 20_000) -> SteadyState:
    """Return the attractor of the motion from ``state`` (n), as :func:`lsvib.analysis.cycles.steady_state` does.

    The slow direction of the return map is extrapolated first, which only changes where the search starts.
    """
    try:
        start, mode = _extrapolated(automaton, np.array(state, dtype=float))
    except EngineError:
        start, mode = state, None
    with np.errstate(invalid="ignore"):  # of an elastic contact e = 0 at every N = 0, so that it has no scale there
        return steady_state(automaton, start, mode=mode, max_events=max_events)


def _extrapolated(automaton: Automaton, state: np.ndarray) -> tuple[np.ndarray, int | None]:
    """A state near the fixed point of the return map, and its mode; the motion's last state where none is found."""
    motion = follow(automaton, state, math.inf, max_events=_APPROACH)
    if motion.status == Status.SETTLED:
        return state, None
    recent = np.stack([motion.kind, motion.mode], axis=1)[motion.time.size // 2 :]
    pairs, counts = np.unique(recent, axis=0, return_counts=True)
    kind, mode = pairs[np.argmin(counts)].tolist()
    point = motion.after[(motion.kind == kind) & (motion.mode == mode)][-1]
    for _ in range(_ROUNDS):
        path = [point]
        for _ in range(_RETURNS):
            back = follow(automaton, path[-1], math.inf, mode=mode, stop=(kind, mode), max_events=_APPROACH)
            if back.status != Status.STOP_EVENT:
                return motion.end_state, motion.end_mode
            path.append(back.end_state)
        size = np.maximum(np.abs(path[-1]), 1e-300)
        before, last = (path[-2] - path[-3]) / size, (path[-1] - path[-2]) / size
        point = path[-1]
        if np.abs(last).max() <= _SAME:
            break
        slope = float(before @ last) / float(before @ before)
        if 0 < slope < 1:
            point = point + slope / (1 - slope) * (path[-1] - path[-2])
    return point, mode


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
    start, (along_x, along_y) = polygon[:-1], np.diff(polygon, axis=0).T
    length = along_x**2 + along_y**2
    length[length == 0] = 1.0
    largest = 0.0
    for first in range(0, len(points), _BLOCK):
        x, y = (points[first : first + _BLOCK, None] - start).transpose(2, 0, 1)
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
    """Return how often a motion comes to rest."""
    codes = motion.automaton.codes[motion.arcs()[0]]
    return int(np.isin(codes, motion.automaton.rest_codes).sum())
