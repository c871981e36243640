r"""Curves in the phase plane made of arcs of a flow and straight segments: crossings, areas, points – all exact.

A curve is a list of pieces, each beginning where the one before ends; the region that it bounds lies on its *right*: a
motion turns clockwise in the phase plane. By Green's theorem the area is then ∮ w du; with du = w dt and the balance of
energy of the oscillator  u″ + a₁ u′ + a₀ u = b

    ∫ w du = ∫ w² dt = −Δ(w²/2 + a₀ u²/2 − b u) / a₁         along an arc,

evaluated with 60 digits, and more for a small a₁. Along a line w = const, from u = −∞ on, the region is
entered where a curve rises and left where one falls; if it is left once more than it is entered, it holds u = −∞.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpf

from lsvib.engine.kernels import flow_planar, layout, search_planar
from lsvib.engine.kernels.flow_planar import level
from lsvib.engine.kernels.layout import Found

_DIGITS = 60  # of an area: the strips under its boundary nearly cancel, in a narrow window to 24 digits and 20 more


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
    """Return the area [rad²/s] to the right of closed curves (flow table, curves), by Green's theorem.

    Neighbouring pieces meet to rounding; a straight line closes each gap, so that it counts for no more than it holds.
    """
    total = mpf(0)
    with mp.workdps(_DIGITS):
        for curve in curves:
            for piece, following in zip(curve, [*curve[1:], curve[0]], strict=True):
                strip, end = _strip(flow, piece)
                total += strip + _under_line(end, _digits(following.start))
    return float(total)


def _digits(point) -> tuple[mpf, mpf]:
    return mpf(float(point[0])), mpf(float(point[1]))


def _under_line(start: tuple[mpf, mpf], end: tuple[mpf, mpf]) -> mpf:
    """∫ w du along a straight line."""
    return (start[1] + end[1]) * (end[0] - start[0]) / 2


def _strip(flow: np.ndarray, piece: Piece) -> tuple[mpf, tuple[mpf, mpf]]:
    """∫ w du along a piece, and its end: of the end in double, the difference of energies would keep too few digits."""
    u, w = _digits(piece.start)
    if isinstance(piece, Segment):
        end = _digits(piece.end)
        return _under_line((u, w), end), end
    a0, a1, b = (mpf(float(flow[piece.mode, k])) for k in (layout.A0, layout.A1, layout.B))
    little = mp.log10(a1 * a1 / abs(a0)) / 2 if a1 else 0
    with mp.workdps(_DIGITS + max(0, -int(little))):  # the division by a₁ costs as many digits
        time, root, y = mpf(piece.duration), mp.sqrt(mp.mpc(a1 * a1 / 4 - a0)), u - b / a0
        decay = mp.exp(-a1 * time / 2)
        s = mp.re(decay * (mp.sinh(root * time) / root if root else time))  # critical damping has a double root
        even = mp.re(decay * mp.cosh(root * time))  # S′ = even − a₁ S / 2 of the response S to a blow
        y_end, w_end = y * (even + a1 / 2 * s) + w * s, w * (even - a1 / 2 * s) - a0 * y * s
        if a1:
            strip = (w * w - w_end * w_end + a0 * (y * y - y_end * y_end)) / (2 * a1)
        else:  # energy stays, and ∫ w² dt + a₀ ∫ y² dt is it twice over time, ∫ w² dt − a₀ ∫ y² dt = Δ(y w)
            strip = ((w * w + a0 * y * y) * time + y_end * w_end - y * w) / 2
    return strip, (y_end + b / a0, w_end)


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
    acceleration = np.array([-row[layout.A0], -row[layout.A1], row[layout.B]])
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
