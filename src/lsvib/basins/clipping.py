"""The part of a region of the phase plane that lies in a window, again with closed curves around it."""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lsvib.basins.curves import Arc, Curve, Piece, Segment, contains, sign_changes, split, state_on


class Window(NamedTuple):
    """A rectangle in the phase plane: u from ``left`` to ``right`` [rad], w from ``bottom`` to ``top`` [rad/s]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def area(self) -> float:
        """Area [rad²/s]."""
        return (self.right - self.left) * (self.top - self.bottom)

    def holds(self, state: np.ndarray) -> bool:
        """Whether a state (2) lies inside."""
        return bool(self.left < state[0] < self.right and self.bottom < state[1] < self.top)

    def widened(self, width: float, height: float) -> "Window":
        """Return the window about the same middle that is at least so wide [rad] and high [rad/s]."""
        (left, right), (bottom, top) = (
            (low, high) if high - low >= least else (0.5 * (low + high - least), 0.5 * (low + high + least))
            for low, high, least in ((self.left, self.right, width), (self.bottom, self.top, height))
        )
        return Window(left, right, bottom, top)


def clip(flow: np.ndarray, curves: Sequence[Curve], window: Window) -> list[Curve]:
    """Return the closed curves around the part of a region that lies in a window.

    ``curves`` are closed or reach infinity at both ends, with the region on their right; so are the curves returned,
    which follow the edges of the window clockwise where the region goes on beyond them.
    """
    closed, paths = inside(flow, curves, window)
    if not paths and not closed:
        middle = [0.5 * (window.left + window.right), 0.5 * (window.bottom + window.top)]
        return [_edges(window, 0.0, 4.0)] if contains(flow, curves, middle) else []
    while paths:
        loop = paths.pop(0)
        while True:
            leaves = _place(window, loop[-1].end)
            ahead = {((_place(window, path[0].start) - leaves) % 4.0): path for path in [loop, *paths]}
            way = min(ahead)
            loop = [*loop, *_edges(window, leaves, way)]
            if ahead[way][0] is loop[0]:
                break
            paths = [path for path in paths if path is not ahead[way]]
            loop = [*loop, *ahead[way]]
        closed.append(loop)
    return closed


def inside(flow: np.ndarray, curves: Iterable[Curve], window: Window) -> tuple[list[Curve], list[Curve]]:
    """Return the parts of curves inside a window: the closed curves, and the paths from one edge to another."""
    closed, paths = [], []
    for curve in curves:
        parts = [(part, window.holds(_middle(flow, part))) for piece in curve for part in _cut(flow, piece, window)]
        if all(kept for _, kept in parts):
            closed.append([part for part, _ in parts])
        elif any(kept for _, kept in parts):
            paths += _runs(parts)
    return closed, paths


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
        parts = [*split(flow, piece, [time for time, _, _ in cuts])]
    else:
        piece = _finite(piece, window)
        for axis, place in lines:
            first, last = piece.start[axis] - place, piece.end[axis] - place
            if (first < 0) != (last < 0) and first != 0 and last != 0:
                cuts.append((first / (first - last), axis, place))
        cuts.sort()
        points = [piece.start, *(piece.start + share * (piece.end - piece.start) for share, _, _ in cuts), piece.end]
        parts = [Segment(points[k], points[k + 1]) for k in range(len(points) - 1)]
    for k, (_, axis, place) in enumerate(cuts):
        point = parts[k].end.copy()
        point[axis] = place
        parts[k], parts[k + 1] = replace(parts[k], end=point), replace(parts[k + 1], start=point)
    return parts


def _finite(piece: Segment, window: Window) -> Segment:
    """Replace the infinite ends of a segment by points just beyond the window."""
    height = window.top - window.bottom
    low, high = window.bottom - height, window.top + height

    def drawn(point: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Return the point itself; in place of infinity a point beyond the window and beyond the other end."""
        if math.isfinite(point[1]):
            return point
        bound = min(low, other[1] - height) if point[1] < 0 else max(high, other[1] + height)
        return np.array([point[0], bound])

    return Segment(drawn(piece.start, piece.end), drawn(piece.end, piece.start))


def _middle(flow: np.ndarray, piece: Piece) -> np.ndarray:
    if isinstance(piece, Segment):
        return np.asarray(0.5 * (piece.start + piece.end))
    return state_on(flow, piece, 0.5 * piece.duration)


def _runs(parts: list[tuple[Piece, bool]]) -> list[Curve]:
    """Return the unbroken runs of kept pieces; on a closed curve the last run may continue into the first."""
    first_gap = next(k for k, (_, kept) in enumerate(parts) if not kept)
    runs, run = [], []
    for part, kept in parts[first_gap:] + parts[:first_gap]:
        if kept:
            run.append(part)
        elif run:
            runs.append(run)
            run = []
    return [*runs, run] if run else runs


def _place(window: Window, point: np.ndarray) -> float:
    """Return how far round the window a point of its edge lies, clockwise from the top left corner: 0 to 4."""
    u = (point[0] - window.left) / (window.right - window.left)
    w = (window.top - point[1]) / (window.top - window.bottom)
    gaps = {u: abs(w), 1 + w: abs(1 - u), 3 - u: abs(1 - w), 4 - w: abs(u)}
    return float(min(gaps, key=gaps.__getitem__) % 4.0)


def _edges(window: Window, start: float, way: float) -> Curve:
    """Return the edges of a window as segments, clockwise from a place and over a length, of which 4 is once round."""
    (left, right, bottom, top) = window
    corners = np.array([(left, top), (right, top), (right, bottom), (left, bottom)], dtype=float)

    def point(place: float) -> np.ndarray:
        side, share = divmod(place % 4.0, 1.0)
        here, there = corners[int(side)], corners[(int(side) + 1) % 4]
        return np.asarray(here + share * (there - here))

    stops = [start, *(float(k) for k in range(math.floor(start) + 1, math.ceil(start + way))), start + way]
    return [Segment(point(a), point(b)) for a, b in itertools.pairwise(stops) if b > a]
