"""Arrows of time on the lines of a panel, and words beside a line, each where the picture has room for it.

Distances are those of the printed page, in points, of a panel as large as it is when the functions are called.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

_STEP = 1.5  # distance of the points that are compared [pt]
_ROOM = 9.0  # distance of an arrow from everything else that is enough [pt]
_OWN = 18.0  # length of a line around an arrow that does not count as another line [pt]
_START = 14.0  # length from the start of a line on which no arrow stands, since the start has a mark [pt]
_RIM = 3.0  # arrows keep so far from the rim [pt]
_PLACES = 150  # places compared on one line
_ASIDE = (1.2, 1.6, 2.0, 2.5, 3.0, 4.0)  # distances of a word's middle from its line, in sizes of the letters
_WORD = np.array([2.0, 0.8])  # half width and half height of a word like "N > 0", in sizes of the letters

DrawnLine = tuple[np.ndarray, np.ndarray, str | None]


def draw_arrows(axes: Axes, lines: Sequence[DrawnLine], size: float = 10.0) -> None:
    """Draw one arrow on each line, in the direction of its points and within the limits that the panel has now.

    A line is x, y, both of shape (n) and with NaN where it is broken, and a colour; one without a colour gets no arrow
    but is kept clear of. ``size`` of the arrows in points.
    """
    page = _Page(axes)
    paths = [_evenly(page.points(x, y)) for x, y, _ in lines]
    for number, (path, (_, _, colour)) in enumerate(zip(paths, lines, strict=True)):
        if colour is None:
            continue
        place = _roomiest(path, [other[:, :2] for k, other in enumerate(paths) if k != number], page.size)
        if place is not None:
            tail, head = (page.data(path[k, :2]) for k in (place - 1, place))
            style = {"arrowstyle": "-|>", "color": colour, "linewidth": 0, "mutation_scale": size}
            axes.annotate("", head, tail, arrowprops=style | {"shrinkA": 0, "shrinkB": 0}, zorder=3.2)


def name_sides(
    axes: Axes, ends: np.ndarray, words: tuple[str, str], lines: Sequence[DrawnLine], size: float = 8.0
) -> None:
    """Write a word on each side of a straight line, to its right and to its left as seen along the line.

    ``ends``: both ends (2, 2) of the line in the limits that the panel has now; ``lines``: what the words keep clear
    of, as in :func:`draw_arrows`; ``size`` of the letters in points. A word that is empty is left out.
    """
    page = _Page(axes)
    first, last = page.points(*ends.T)
    normal = np.array([last[1] - first[1], first[0] - last[0]]) / np.hypot(*(last - first))
    clouds = np.concatenate([_evenly(page.points(x, y))[:, :2] for x, y, _ in [(*ends.T, None), *lines]])
    half = _WORD * size
    for word, side in zip(words, (1, -1), strict=True):
        along = first + np.linspace(0.05, 0.95, _PLACES)[:, None] * (last - first)
        spots = np.concatenate([along + side * aside * size * normal for aside in _ASIDE])
        spots = spots[((spots > 1.1 * half) & (spots < page.size - 1.1 * half)).all(axis=1)]
        if word and spots.size:
            room = [np.abs((clouds - spot) / half).max(axis=1).min(initial=1.3) for spot in spots]
            place = page.data(spots[int(np.argmax(room))])
            patch = {"facecolor": "#FFFFFFD0", "linewidth": 0, "pad": 0.8}
            axes.text(*place, word, ha="center", va="center", bbox=patch, fontsize=size, zorder=4)


class _Page:
    """The panel on the page: points [pt] from its lower left corner, and back to data."""

    def __init__(self, axes: Axes) -> None:
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        self.corner, self.sides = np.array([left, low]), np.array([right - left, high - low])
        self.size = np.array([axes.bbox.width, axes.bbox.height]) * 72 / axes.figure.dpi

    def points(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the points (n, 2) of data x and y, each of shape (n)."""
        return (np.column_stack([x, y]) - self.corner) / self.sides * self.size

    def data(self, point: np.ndarray) -> np.ndarray:
        """Return the data (2) of a point (2)."""
        return self.corner + self.sides * point / self.size


def _evenly(path: np.ndarray) -> np.ndarray:
    """Return points in even steps along a line (n, 2), each with its distance from the line's start: shape (m, 3)."""
    pieces, length = [np.empty((0, 3))], 0.0
    for piece in np.split(path, np.flatnonzero(np.isnan(path).any(axis=1))):
        piece = piece[np.isfinite(piece).all(axis=1)]
        if len(piece) > 1:
            ends = np.append(0.0, np.cumsum(np.hypot(*np.diff(piece, axis=0).T)))
            s = np.arange(0.0, ends[-1], _STEP)
            pieces.append(np.column_stack([*(np.interp(s, ends, z) for z in piece.T), s + length]))
            length += ends[-1] + _STEP
    return np.concatenate(pieces)


def _roomiest(path: np.ndarray, others: Sequence[np.ndarray], size: np.ndarray) -> int | None:
    """Return the first point of a path with room around it, else the one with most; none if no point is in view."""
    inside = ((path[:, :2] > _RIM) & (path[:, :2] < size - _RIM)).all(axis=1)
    inside &= path[:, 2] > np.minimum(_START, path[-1:, 2] / 3)
    # The point before, at which the arrow starts, lies on the same piece: pieces are more than a step apart.
    inside &= np.append(False, np.diff(path[:, 2]) < 1.001 * _STEP)
    found = np.flatnonzero(inside)
    if not found.size:
        return None
    found = found[:: -(-found.size // _PLACES)]
    room = np.full(found.size, _ROOM)
    for k, point in enumerate(found):
        x, y, s = path[point]
        own = path[np.abs(path[:, 2] - s) > _OWN, :2]
        for cloud in (own, *others):
            if cloud.size:
                room[k] = min(room[k], np.hypot(*(cloud - (x, y)).T).min())
    return int(found[np.argmax(room)])
