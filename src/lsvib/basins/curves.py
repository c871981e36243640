r"""Curves in the phase plane made of arcs of a flow and straight segments: crossings, areas, points – all exact.

A curve is a list of pieces, each beginning where the one before ends; the region that it bounds lies on its *right*: a
motion turns clockwise in the phase plane. By Green's theorem the area is then ∮ w du; with du = w dt and the balance of
energy of the oscillator  u″ + a₁ u′ + a₀ u = b

    ∫ w du = ∫ w² dt = −Δ(w²/2 + a₀ u²/2 − b u) / a₁         along an arc,

evaluated with 40 digits, of which a small a₁ may cost some. Along a line w = const, from u = −∞ on, the region is
entered where a curve rises and left where one falls; if it is left once more than it is entered, it holds u = −∞.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpf

from lsvib.engine.kernels import columns, flow_planar, search_planar
from lsvib.engine.kernels.affine import level
from lsvib.engine.kernels.status import Found

_DIGITS = 40  # digits of an area: the strips under the pieces of a boundary nearly cancel, which may cost 24 digits


@dataclass(frozen=True)
class Segment:
    """A straight piece from ``start`` to ``end`` (2) [rad, rad/s]; a vertical one may begin or end at w = ±∞."""

    start: np.ndarray
    end: np.ndarray


@dataclass(frozen=True)
class Arc:
    """The motion from ``start`` to ``end`` (2) [rad, rad/s] in ``duration`` [s]; ``mode`` is a row of a flow table."""

    mode: int
    start: np.ndarray
    end: np.ndarray
    duration: float


Piece = Arc | Segment
Curve = list[Piece]


def state_on(flow: np.ndarray, arc: Arc, time: float) -> np.ndarray:
    """Return the state (2) on an arc at a time [s] after its start."""
    state = np.empty(2)
    flow_planar.advance(flow, arc.mode, np.asarray(arc.start, dtype=float), time, state)
    return state


def sign_changes(flow: np.ndarray, arc: Arc, row: np.ndarray) -> list[float]:
    """Return the times [s] in (0, duration) at which an affine function (3) of the state changes sign along an arc."""
    times, time, state = [], 0.0, np.asarray(arc.start, dtype=float)
    value, size = level(row, state, np.abs(state))
    rate, rate_size, bend, _ = flow_planar.slopes_at(flow, arc.mode, state, np.abs(state), row)
    touches = abs(value) <= size
    sign = math.copysign(1.0, (rate if abs(rate) > rate_size else bend) if touches else value)
    while True:
        found, stay = search_planar.crossing(flow, arc.mode, state, sign * row, touches, arc.duration - time)
        time += stay
        if found == Found.NONE or time >= arc.duration:
            return times
        if found == Found.CROSSING:
            times.append(time)
            sign = -sign
        state, touches = state_on(flow, arc, time), True


def area(flow: np.ndarray, curves: Iterable[Curve]) -> float:
    """Return the area [rad²/s] to the right of closed curves (flow table, curves), by Green's theorem."""
    with mp.workdps(_DIGITS):
        return float(mp.fsum(_strip(flow, piece) for curve in curves for piece in curve))


def _strip(flow: np.ndarray, piece: Piece):
    """∫ w du along a piece."""
    (u, w), (u_end, w_end) = ([mpf(float(x)) for x in point] for point in (piece.start, piece.end))
    if isinstance(piece, Segment):
        return (w + w_end) * (u_end - u) / 2
    a0, a1, b = (mpf(float(flow[piece.mode, k])) for k in (columns.A0, columns.A1, columns.B))
    # The end to 40 digits: of the state in double, the difference of energies would keep too few.
    time, root = mpf(piece.duration), mp.sqrt(mp.mpc(a1 * a1 / 4 - a0))
    y, first, second = u - b / a0, -a1 / 2 + root, -a1 / 2 - root
    s = (mp.exp(first * time) - mp.exp(second * time)) / (first - second)
    s_rate = (first * mp.exp(first * time) - second * mp.exp(second * time)) / (first - second)
    y_end, w_end = mp.re(y * (s_rate + a1 * s) + w * s), mp.re(w * s_rate - a0 * y * s)
    return (w * w - w_end * w_end + a0 * (y * y - y_end * y_end)) / (2 * a1)


def contains(flow: np.ndarray, curves: Iterable[Curve], state) -> bool:
    """Return whether the region to the right of curves holds a state (2)."""
    u, w = float(state[0]), float(state[1])
    left, total = 0, 0
    for piece in (piece for curve in curves for piece in curve):
        for part in _rising_parts(flow, piece):
            first, last = part.start[1], part.end[1]
            if (first <= w) != (last <= w):
                entry = 1 if first < last else -1
                total += entry
                left += entry if _angle_at(flow, part, w) < u else 0
    return left + (total < 0) == 1


def _rising_parts(flow: np.ndarray, piece: Piece) -> list[Piece]:
    """Split a piece into parts on which w only rises or only falls."""
    if isinstance(piece, Segment):
        return [piece]
    row = flow[piece.mode]
    acceleration = np.array([-row[columns.A0], -row[columns.A1], row[columns.B]])
    return split(flow, piece, sign_changes(flow, piece, acceleration))


def _angle_at(flow: np.ndarray, part: Piece, w: float) -> float:
    """Return the deviation u at which a part, on which the rate only rises or only falls, has the rate w."""
    if isinstance(part, Segment):
        if part.start[0] == part.end[0]:
            return float(part.start[0])
        share = (w - part.start[1]) / (part.end[1] - part.start[1])
        return float(part.start[0] + share * (part.end[0] - part.start[0]))
    sign = 1.0 if part.start[1] > w else -1.0
    if part.start[1] == w:
        return float(part.start[0])
    found, time = search_planar.crossing(
        flow, part.mode, np.asarray(part.start), sign * np.array([0.0, 1.0, -w]), False, part.duration
    )
    return float(state_on(flow, part, time)[0] if found == Found.CROSSING else part.end[0])


def split(flow: np.ndarray, arc: Arc, times: Sequence[float]) -> list[Arc]:
    """Return an arc as arcs between ascending ``times`` [s] in (0, duration)."""
    bounds = [0.0, *times, arc.duration]
    states = [arc.start, *(state_on(flow, arc, t) for t in times), arc.end]
    return [Arc(arc.mode, states[k], states[k + 1], bounds[k + 1] - bounds[k]) for k in range(len(bounds) - 1)]


def sampled(flow: np.ndarray, curves: Iterable[Curve], count: int = 100) -> np.ndarray:
    """Return points (n, 2) along curves for drawing, ``count`` to an arc, with a row of NaN between two curves."""
    points = []
    for curve in curves:
        points += [[math.nan, math.nan]] if points else []
        for piece in curve:
            if isinstance(piece, Arc):
                points += [state_on(flow, piece, t) for t in np.linspace(0.0, piece.duration, count)]
            else:
                points += [piece.start, piece.end]
    return np.array(points).reshape(-1, 2)
