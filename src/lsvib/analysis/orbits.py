"""Cycles of models with many states, and how far two orbits lie apart in the phase plane.

A contact of finite stiffness creeps: in slip its deflection follows the rate k_c / c_c, so that the return map of a
cycle of period T has the multiplier exp(−T k_c / c_c), which is close to one in the viscous limit. All other multipliers
are small. The fixed point is therefore extrapolated along the slow direction (Aitken's method for vectors): with the
last steps d₁, d₂ of the map and λ = d₁·d₂ / d₁·d₁, it lies near x + λ / (1 − λ) d₂.
"""

import math

import numpy as np

from lsvib.analysis.cycles import SteadyState, steady_state
from lsvib.core.status import Status
from lsvib.errors import EngineError
from lsvib.models.automaton import Automaton
from lsvib.models.motion import Motion, follow

_APPROACH = 64  # events after which the return map is watched
_RETURNS = 4  # of the map before each extrapolation, in which the fast multipliers die out
_ROUNDS = 12
_SAME = 1e-13  # relative change of the section state in one return that is rounding
_LEAST = 65  # samples of an arc of a curve


def settled_orbit(automaton: Automaton, state, *, max_events: int = 20_000) -> SteadyState:
    """Return the attractor of the motion from ``state`` (n), as :func:`lsvib.analysis.cycles.steady_state` does.

    The slow direction of the return map is extrapolated first, which only changes where the search starts.
    """
    try:
        start, mode = _extrapolated(automaton, np.array(state, dtype=float))
    except EngineError:
        start, mode = state, None
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
            back = follow(automaton, path[-1], math.inf, mode=mode, stop=(kind, mode), max_events=1000)
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
    """Return points (u, w) [rad, rad/s] along a motion, shape (k, 2): its arcs' ends and about ``count`` between."""
    modes, starts, ends, durations = motion.arcs()
    least = max(2, min(_LEAST, count // durations.size))
    shares = least + np.floor(count * durations / max(durations.sum(), 1e-300)).astype(int)
    bounds = np.concatenate([[motion.start_time], motion.time, [motion.end_time]])
    times = np.concatenate([np.linspace(a, b, n) for a, b, n in zip(bounds[:-1], bounds[1:], shares, strict=True)])
    states, _ = motion.at(times)
    last = np.cumsum(shares) - 1
    states[last - shares + 1], states[last] = starts, ends
    return states[:, :2]


def orbit_distance(one: np.ndarray, other: np.ndarray, scales, stride: int = 1) -> float:
    """Return the Hausdorff distance [1] of two curves, (k, 2) and (l, 2), in coordinates divided by ``scales`` (2).

    It is the largest distance of a point of either curve from the other one, which is taken as the polygon through its
    points; jumps, along which only the rate changes, are part of the polygon. Of the points of a curve every
    ``stride``-th is measured.
    """
    one, other = one / np.asarray(scales), other / np.asarray(scales)
    return max(_farthest(one[::stride], other), _farthest(other[::stride], one))


def _farthest(points: np.ndarray, polygon: np.ndarray) -> float:
    """Largest distance of points from a polygon: each from the two sides that meet in the nearest corner."""
    start, along = polygon[:-1], np.diff(polygon, axis=0)
    length = np.einsum("ij,ij->i", along, along)
    nearest = np.argmin(np.einsum("ij,ij->i", polygon, polygon) - 2 * points @ polygon.T, axis=1)
    squares = np.full(len(points), np.inf)
    for side in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(along) - 1)):
        offset = points - start[side]
        part = np.einsum("ij,ij->i", offset, along[side]) / np.where(length[side] > 0, length[side], 1.0)
        miss = offset - np.clip(part, 0, 1)[:, None] * along[side]
        squares = np.minimum(squares, np.einsum("ij,ij->i", miss, miss))
    return float(np.sqrt(squares.max()))


def rest_duration(motion: Motion) -> float:
    """Return the total time [s] that a motion spends at rest."""
    modes, _, _, durations = motion.arcs()
    return float(durations[np.isin(motion.automaton.codes[modes], motion.automaton.rest_codes)].sum())
