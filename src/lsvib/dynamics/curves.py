r"""Regions of the phase plane bounded by arcs of a flow and straight segments: areas, points, windows, to rounding.

A curve is a list of pieces, each beginning where the one before ends; the region that it bounds lies on its *right*: a
motion turns clockwise in the phase plane. The area is then ∮ w du (docs/basin.md). Along a line w = const, from u = −∞
on, the region is entered where a curve rises and left where one falls; if it is left once more than it is entered, it
holds u = −∞. The flow is that of oscillators or, under a friction law, the series of −x′: a motion along a cycle that
repels keeps its digits backwards only. Such a curve is closed and has its region on the left.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from lsvib import numbers
from lsvib.errors import InputError
from lsvib.systems.automaton import Automaton
from lsvib.systems.flow import Flow
from lsvib.systems.kernels.layout import FIRST_MODEL_KIND, Status, Tables
from lsvib.systems.motion import follow


@dataclass(frozen=True)
class Segment:
    """A straight piece from ``start`` to ``end`` (2) [rad, rad/s]; a vertical one may begin or end at w = ±∞."""

    start: np.ndarray
    end: np.ndarray


@dataclass(frozen=True)
class Arc:
    """The motion from ``start`` to ``end`` (2) [rad, rad/s] in ``duration`` [s], in a ``mode`` of a flow."""

    mode: int
    start: np.ndarray
    end: np.ndarray
    duration: float


Piece = Arc | Segment
Curve = list[Piece]


class Window(NamedTuple):
    """A rectangle in the phase plane: u from ``left`` to ``right`` [rad], w from ``bottom`` to ``top`` [rad/s].

    >>> lsvib.Window(-0.3, 0.3, -150, 150).area == lsvib.Window.of({"u": (-0.3, 0.3), "w": (-150, 150)}).area
    True
    """

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def of(cls, given: Any) -> Self:
        """Make a window from another, or from ``{"u": (low, high), "w": (low, high)}``; raises ``InputError``."""
        if isinstance(given, Window):
            given = {"u": (given.left, given.right), "w": (given.bottom, given.top)}
        if not isinstance(given, Mapping) or set(given) != {"u", "w"}:
            raise InputError(f"window = {numbers.shown(given)} is not a range of u and one of w.")
        ends: list[float] = []
        for name in ("u", "w"):
            pair = given[name]
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise InputError(f"window {name} = {numbers.shown(pair)} is not a pair of low and high ends.")
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
        """Whether a state (u [rad], w [rad/s]) lies inside."""
        return bool(self.left < state[0] < self.right and self.bottom < state[1] < self.top)


Part = Window | Mapping[str, tuple[float, float]]
"""A part of the phase plane, as users give it: ends of u [rad] and w [rad/s]."""

_NOTHING = np.array([0.0, 0.0, 1.0])  # a row that never falls through zero


def _watching(flow: Flow, row: np.ndarray) -> Automaton:
    """Return an automaton that stays in each mode of a flow; an event is where a row (3) falls through zero."""
    count = len(flow.field)
    each, none, bounds = np.arange(count), np.zeros(count, dtype=np.int64), np.arange(count + 1)
    tables = Tables(
        flow=flow.tables,
        surfaces=row[None], snap=np.array([int(abs(row[1]) > abs(row[0]))]), guard_start=bounds,
        guard_surface=none, guard_sign=np.ones(count), guard_transition=each, guard_parts=np.empty((count, 0)),
        transition_reset=none - 1, resets=np.empty((0, 2, 3)), branch_start=bounds, branch_mode=each,
        branch_kind=none + FIRST_MODEL_KIND, branch_sign=none, condition_start=0 * bounds,
        condition_row=np.empty((0, 3)), condition_test=none[:0], beyond_accumulation=none - 1, shortest_stay=0.0,
    )  # fmt: skip
    return Automaton(tables, each, ("u", "w"), {})


def states_on(flow: Flow, arc: Arc, times: ArrayLike) -> np.ndarray:
    """Return the states (k, 2) on an arc at ascending times (k) [s] after its start."""
    states, _ = follow(_watching(flow, _NOTHING), arc.start, arc.duration, mode=arc.mode).at(times)
    return states


def state_on(flow: Flow, arc: Arc, time: float) -> np.ndarray:
    """Return the state (2) on an arc at a time [s] after its start."""
    return np.asarray(states_on(flow, arc, [time])[0])


def sign_changes(flow: Flow, arc: Arc, row: np.ndarray) -> list[float]:
    """Return the times [s] in (0, duration) at which an affine function (3) of the state changes sign along an arc."""
    times: list[float] = []
    time, state, sign = 0.0, arc.start, -1.0 if row[:2] @ arc.start + row[2] < 0 else 1.0
    while True:
        stop = FIRST_MODEL_KIND, -1
        found = follow(_watching(flow, sign * row), state, arc.duration - time, mode=arc.mode, stop=stop)
        time, state, sign = time + found.end_time, found.end_state, -sign
        if found.status != Status.STOP_EVENT or time >= arc.duration:
            return times
        if time > 0:
            times.append(time)


def sampled(flow: Flow, curves: Iterable[Curve], count: int = 100) -> np.ndarray:
    """Return points (n, 2) along curves for drawing, ``count`` to an arc, with a row of NaN between two curves."""
    points: list[Any] = []
    for curve in curves:
        points += [[math.nan, math.nan]] if points else []
        for piece in curve:
            if isinstance(piece, Arc):
                points += [*states_on(flow, piece, np.linspace(0.0, piece.duration, count))]
            else:
                points += [piece.start, piece.end]
    return np.array(points).reshape(-1, 2)


def area(flow: Flow, curves: Iterable[Curve]) -> float:
    """Return the area [rad²/s] to the right of closed curves (flow, curves), by Green's theorem.

    Neighbouring pieces meet to rounding; a straight line closes each gap, so that it counts for no more than it holds.
    """
    return abs(math.fsum(strip for curve in curves for strip in _strips(flow, curve)))


def _strips(flow: Flow, curve: Curve) -> Iterator[float]:
    """Yield ∫ (w − level) du along the pieces of a closed curve, and along the lines that close its gaps."""
    level = float(curve[0].start[1])  # so that what lies below a narrow window does not count, and is not rounded
    form = np.array([[[0.0, 0.0, 0.0], [0.0, 1.0, -level], [0.0, 0.0, 0.0]]])

    def under_line(start: np.ndarray, end: np.ndarray) -> float:
        return float(((start[1] - level) + (end[1] - level)) * (end[0] - start[0]) / 2)

    for piece, following in zip(curve, [*curve[1:], curve[0]], strict=True):
        end = piece.end
        if isinstance(piece, Segment):
            yield under_line(piece.start, end)
        else:  # du = ±w dt; a stiff arc that was followed backwards does not quite lead to its end
            end, way = state_on(flow, piece, piece.duration), float(flow.field[piece.mode, 0, 1])
            yield way * float(flow.integral(piece.mode, piece.start, piece.duration, form)[0])
        yield under_line(end, following.start)


def contains(flow: Flow, curves: Iterable[Curve], state: np.ndarray) -> bool:
    """Return whether the region to the right of curves holds a state (2)."""
    u, w = float(state[0]), float(state[1])
    left, total = 0, 0
    for piece in (piece for curve in curves for piece in curve):
        for entry, place in passes(flow, piece, 1, w):
            total += entry
            left += entry if place < u else 0
    return abs(left + (total < 0)) == 1


def passes(flow: Flow, piece: Piece, axis: int, value: float) -> Iterator[tuple[int, float]]:
    """Yield where u (``axis`` 0) or w (1) passes a value on a piece: 1 if it rises or −1, and the other coordinate."""
    ends, other = [bool(piece.start[axis] > value), bool(piece.end[axis] > value)], 1 - axis
    if isinstance(piece, Segment):
        across, along = piece.end[axis] - piece.start[axis], piece.end[other] - piece.start[other]
        if ends[0] != ends[1]:  # the piece may begin or end at infinity
            share = (value - piece.start[axis]) / across if along else 0.0
            yield (1 if ends[1] else -1), float(piece.start[other] + along * share)
        return
    row = np.array([1.0 - axis, float(axis), -value])
    times = np.array([0.0, *sign_changes(flow, piece, row), piece.duration])
    between = (states_on(flow, piece, 0.5 * (times[1:] + times[:-1]))[:, axis] > value).tolist()
    for time, (before, after) in zip(times, itertools.pairwise([ends[0], *between, ends[1]]), strict=True):
        if before != after:  # at an end, if that lies on the value
            yield (1 if after else -1), float(state_on(flow, piece, time)[other])


def clip(flow: Flow, curve: Curve, window: Window) -> Curve:
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


def inside(flow: Flow, curves: Iterable[Curve], window: Window) -> tuple[list[Curve], list[Curve]]:
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


def _middle(flow: Flow, piece: Piece) -> np.ndarray:
    if isinstance(piece, Segment):
        return np.asarray(0.5 * (piece.start + piece.end))
    return state_on(flow, piece, 0.5 * piece.duration)


def _cut(flow: Flow, piece: Piece, window: Window) -> list[Piece]:
    """Cut a piece where it crosses the lines through the edges of a window; cuts lie on them to the last bit."""
    lines = [(0, window.left), (0, window.right), (1, window.bottom), (1, window.top)]
    parts: list[Piece]
    cuts = []
    if isinstance(piece, Arc):
        for axis, place in lines:
            row = np.array([1.0 - axis, float(axis), -place])
            cuts += [(time, axis, place) for time in sign_changes(flow, piece, row)]
        cuts.sort()
        times = np.array([0.0, *(time for time, _, _ in cuts), piece.duration])
        pairs = itertools.pairwise([piece.start, *states_on(flow, piece, times[1:-1]), piece.end])
        parts = [Arc(piece.mode, *pair, time) for pair, time in zip(pairs, np.diff(times).tolist(), strict=True)]
    else:
        # in place of infinite ends points beyond the window and beyond the other end
        height, ends = window.top - window.bottom, (piece.start, piece.end)
        places = [window.bottom, window.top, *(point[1] for point in ends if math.isfinite(point[1]))]
        low, high = min(places) - height, max(places) + height
        piece = Segment(*(np.array([point[0], np.clip(point[1], low, high)]) for point in ends))
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
