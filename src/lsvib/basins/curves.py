r"""Regions of the phase plane bounded by arcs of a flow and straight segments: areas, points, windows – all exact.

A curve is a list of pieces, each beginning where the one before ends; the region that it bounds lies on its *right*: a
motion turns clockwise in the phase plane. The area is then ∮ w du (docs/basin.md), in balls of 150 digits: the strips
under a boundary nearly cancel, in a narrow window to 24 digits, and a small a₁ costs 20 more. Along a line w = const,
from u = −∞ on, the region is entered where a curve rises and left where one falls; if it is left once more than it is
entered, it holds u = −∞.
"""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from flint import arb

from lsvib import numbers
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.kernels import flow_planar, layout, search_planar
from lsvib.errors import InputError
from lsvib.stability.slip import Slip


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


class Window(NamedTuple):
    """A rectangle in the phase plane: u from ``left`` to ``right`` [rad], w from ``bottom`` to ``top`` [rad/s]."""

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def of(cls, given: Any) -> Self:
        """Make a window from another, or from edges ``{"u": (low, high), "w": (low, high)}``; raises ``InputError``."""
        if isinstance(given, Window):
            given = {"u": (given.left, given.right), "w": (given.bottom, given.top)}
        if not isinstance(given, Mapping) or set(given) != {"u", "w"}:
            raise InputError(f"window = {numbers.shown(given)} does not give the ends of u and of w.")
        ends: list[float] = []
        for name in ("u", "w"):
            pair = given[name]
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise InputError(f"window {name} = {numbers.shown(pair)} is not a low and a high end.")
            low, high = (numbers.start(f"window {name}", value) for value in pair)
            if not low < high:
                raise InputError(f"window {name} = {low:g} to {high:g} is outside the allowed range low < high.")
            ends += [low, high]
        return cls(*ends)

    @property
    def area(self) -> float:
        """Area [rad²/s]."""
        return (self.right - self.left) * (self.top - self.bottom)

    def holds(self, state: np.ndarray) -> bool:
        """Whether a state (2) lies inside."""
        return bool(self.left < state[0] < self.right and self.bottom < state[1] < self.top)


Part = Window | Mapping[str, tuple[float, float]]
"""A part of the phase plane, as users give it: ends of u [rad] and w [rad/s]."""


def state_on(flow: np.ndarray, arc: Arc, time: float) -> np.ndarray:
    """Return the state (2) on an arc at a time [s] after its start."""
    state = np.empty(2)
    flow_planar.advance(flow, arc.mode, np.asarray(arc.start, dtype=float), time, state)
    return state


def sign_changes(flow: np.ndarray, arc: Arc, row: np.ndarray) -> list[float]:
    """Return the times [s] in (0, duration) at which an affine function (3) of the state changes sign along an arc."""
    times: list[float] = []
    time, state = 0.0, np.asarray(arc.start, dtype=float)
    value, size = flow_planar.level(row, state, np.abs(state))
    rate, rate_size, bend, _ = flow_planar.slopes_at(flow, arc.mode, state, np.abs(state), row)
    touches = abs(value) <= size
    sign = math.copysign(1.0, (rate if abs(rate) > rate_size else bend) if touches else value)
    while True:
        found, stay = search_planar.crossing(flow, arc.mode, state, sign * row, touches, arc.duration - time)
        time += stay
        if found == layout.Found.NONE or time >= arc.duration:
            return times
        if found == layout.Found.CROSSING:
            times.append(time)
            sign = -sign
        state, touches = state_on(flow, arc, time), True


def split(flow: np.ndarray, arc: Arc, times: Sequence[float]) -> list[Piece]:
    """Return an arc as arcs between ascending ``times`` [s] in (0, duration)."""
    bounds = [0.0, *times, arc.duration]
    states = [arc.start, *(state_on(flow, arc, t) for t in times), arc.end]
    return [Arc(arc.mode, states[k], states[k + 1], bounds[k + 1] - bounds[k]) for k in range(len(bounds) - 1)]


def sampled(flow: np.ndarray, curves: Iterable[Curve], count: int = 100) -> np.ndarray:
    """Return points (n, 2) along curves for drawing, ``count`` to an arc, with a row of NaN between two curves."""
    points: list[Any] = []
    for curve in curves:
        points += [[math.nan, math.nan]] if points else []
        for piece in curve:
            if isinstance(piece, Arc):
                points += [state_on(flow, piece, t) for t in np.linspace(0.0, piece.duration, count)]
            else:
                points += [piece.start, piece.end]
    return np.array(points).reshape(-1, 2)


def area(flow: np.ndarray, curves: Iterable[Curve]) -> float:
    """Return the area [rad²/s] to the right of closed curves (flow table, curves), by Green's theorem.

    Neighbouring pieces meet to rounding; a straight line closes each gap, so that it counts for no more than it holds.
    """
    with many_digits():
        total = arb(0)
        for curve in curves:
            for piece, following in zip(curve, [*curve[1:], curve[0]], strict=True):
                strip, end = _strip(flow, piece)
                total += strip + _under_line(end, _balls(following.start))
        return float(total)


def _balls(point: np.ndarray) -> tuple[arb, arb]:
    return arb(float(point[0])), arb(float(point[1]))


def _under_line(start: tuple[arb, arb], end: tuple[arb, arb]) -> arb:
    """∫ w du along a straight line."""
    return (start[1] + end[1]) * (end[0] - start[0]) / 2


def _strip(flow: np.ndarray, piece: Piece) -> tuple[arb, tuple[arb, arb]]:
    """∫ w du along a piece, and its end: of the end in double, the difference of energies would keep too few digits."""
    u, w = _balls(piece.start)
    if isinstance(piece, Segment):
        end = _balls(piece.end)
        return _under_line((u, w), end), end
    a0, a1, b = (arb(float(flow[piece.mode, k])) for k in (layout.A0, layout.A1, layout.B))
    time = arb(piece.duration)
    y = u - b / a0
    y_end, w_end = Slip(arb(1), a1, a0).state(y, w, time)
    if a1 == 0:  # energy stays, and ∫ w² dt + a₀ ∫ y² dt is it twice over time, ∫ w² dt − a₀ ∫ y² dt = Δ(y w)
        strip = ((w * w + a0 * y * y) * time + y_end * w_end - y * w) / 2
    else:
        strip = (w * w - w_end * w_end + a0 * (y * y - y_end * y_end)) / (2 * a1)
    return strip, (y_end + b / a0, w_end)


def contains(flow: np.ndarray, curves: Iterable[Curve], state: np.ndarray) -> bool:
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
    if part.start[1] == w:
        return float(part.start[0])
    if isinstance(part, Segment):
        if part.start[0] == part.end[0]:  # it may begin or end at infinity
            return float(part.start[0])
        share = (w - part.start[1]) / (part.end[1] - part.start[1])
        return float(part.start[0] + share * (part.end[0] - part.start[0]))
    row = math.copysign(1.0, part.start[1] - w) * np.array([0.0, 1.0, -w])
    found, time = search_planar.crossing(flow, part.mode, np.asarray(part.start), row, False, part.duration)
    return float(state_on(flow, part, time)[0] if found == layout.Found.CROSSING else part.end[0])


def clip(flow: np.ndarray, curve: Curve, window: Window) -> Curve:
    """Return the closed curve around the part of a region that lies in a window.

    ``curve``, with the region on its right, is closed or goes from one infinite w to the other. What lies outside is
    moved to the nearest point of the window, which is on an edge: no point within changes the side on which it lies.
    """
    low, high = np.array([window.left, window.bottom]), np.array([window.right, window.top])
    clipped: Curve = []
    for part in (part for piece in curve for part in _cut(flow, piece, window)):
        if window.holds(_middle(flow, part)):
            clipped.append(part)
        else:
            clipped.append(Segment(np.clip(part.start, low, high), np.clip(part.end, low, high)))
    if math.isinf(curve[0].start[1]):  # back along the edge on the right
        edge = window.right if curve[0].start[1] < 0 else window.left
        first, last = clipped[0].start, clipped[-1].end
        stops = [last, np.array([edge, last[1]]), np.array([edge, first[1]]), first]
        clipped += [Segment(one, other) for one, other in itertools.pairwise(stops)]
    return clipped


def inside(flow: np.ndarray, curves: Iterable[Curve], window: Window) -> tuple[list[Curve], list[Curve]]:
    """Return the parts of curves inside a window: the closed curves, and the paths from one edge to another."""
    closed, paths = [], []
    for curve in curves:
        parts = [(part, window.holds(_middle(flow, part))) for piece in curve for part in _cut(flow, piece, window)]
        if all(kept for _, kept in parts):
            closed.append([part for part, _ in parts])
        elif any(kept for _, kept in parts):
            gap = next(k for k, (_, kept) in enumerate(parts) if not kept)  # no run of kept pieces passes it
            runs = itertools.groupby(parts[gap:] + parts[:gap], key=lambda part: part[1])
            paths += [[part for part, _ in run] for kept, run in runs if kept]
    return closed, paths


def _middle(flow: np.ndarray, piece: Piece) -> np.ndarray:
    if isinstance(piece, Segment):
        return np.asarray(0.5 * (piece.start + piece.end))
    return state_on(flow, piece, 0.5 * piece.duration)


def _cut(flow: np.ndarray, piece: Piece, window: Window) -> list[Piece]:
    """Cut a piece where it crosses the lines through the edges of a window; cuts lie on them to the last bit."""
    lines = [(0, window.left), (0, window.right), (1, window.bottom), (1, window.top)]
    parts: list[Piece]
    cuts = []
    if isinstance(piece, Arc):
        for axis, place in lines:
            row = np.array([1.0 - axis, float(axis), -place])
            cuts += [(time, axis, place) for time in sign_changes(flow, piece, row)]
        cuts.sort()
        parts = split(flow, piece, [time for time, _, _ in cuts])
    else:
        piece = _finite(piece, window)
        for axis, place in lines:
            first, last = piece.start[axis] - place, piece.end[axis] - place
            if (first < 0) != (last < 0) and first != 0 and last != 0:
                cuts.append((first / (first - last), axis, place))
        cuts.sort()
        points = [piece.start, *(piece.start + share * (piece.end - piece.start) for share, _, _ in cuts), piece.end]
        parts = [Segment(one, other) for one, other in itertools.pairwise(points)]
    for k, (_, axis, place) in enumerate(cuts):
        point = parts[k].end.copy()
        point[axis] = place
        parts[k], parts[k + 1] = replace(parts[k], end=point), replace(parts[k + 1], start=point)
    return parts


def _finite(piece: Segment, window: Window) -> Segment:
    """Replace the infinite ends of a segment by points beyond the window and beyond the other end."""
    height, ends = window.top - window.bottom, (piece.start, piece.end)
    places = [window.bottom, window.top, *(point[1] for point in ends if math.isfinite(point[1]))]
    low, high = min(places) - height, max(places) + height
    return Segment(*(np.array([point[0], np.clip(point[1], low, high)]) for point in ends))
