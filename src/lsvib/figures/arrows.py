"""Arrows of time on the lines of a panel, and words beside a line, each where the picture has room for it."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

_STEP = 0.01  # distance of the points that are compared, in sides of the panel
_ROOM = 0.05  # distance from everything else that is enough
_OWN = 0.1  # length of a line around a point that does not count as another line
_START = 0.12  # length from the start of a line on which no arrow stands, since the start has a mark
_RIM = 0.04  # arrows keep so far from the rim
_ASIDE = 0.055  # distance of a word's middle from its line
_WORD = np.array([0.5, 1.0])  # a word needs twice as much room along the abscissa
_WORD_ROOM = 0.08
_WORD_RIM = np.array([0.09, 0.05])
_CANDIDATES = 150  # places compared on one line

Line = tuple[np.ndarray, np.ndarray, str | None]


def draw_arrows(axes: Axes, lines: Sequence[Line], size: float = 10.0) -> None:
    """Draw one arrow on each line, in the direction of its points and within the limits that the panel has now.

    A line is x, y, both of shape (n) and with NaN where it is broken, and a colour; one without a colour gets no arrow
    but is kept clear of. ``size`` of the arrows in points.
    """
    corner, sides = _frame(axes)
    paths = [_evenly((np.column_stack([x, y]) - corner) / sides) for x, y, _ in lines]
    for number, (path, (_, _, colour)) in enumerate(zip(paths, lines, strict=True)):
        if colour is None:
            continue
        place = _roomiest(path, [other[:, :2] for k, other in enumerate(paths) if k != number])
        if place is not None:
            tail, head = (corner + sides * path[k, :2] for k in (place - 1, place))
            style = {"arrowstyle": "-|>", "color": colour, "linewidth": 0, "mutation_scale": size}
            axes.annotate("", head, tail, arrowprops=style | {"shrinkA": 0, "shrinkB": 0}, zorder=3.2)


def name_sides(axes: Axes, ends: np.ndarray, words: tuple[str, str], lines: Sequence[Line]) -> None:
    """Write a word on each side of a straight line, to its right and to its left as seen along the line.

    ``ends``: both ends (2, 2) of the line in the limits that the panel has now; ``lines``: what the words keep clear
    of, as in :func:`draw_arrows`. A word that is empty is left out.
    """
    corner, sides = _frame(axes)
    first, last = (ends - corner) / sides
    normal = np.array([last[1] - first[1], first[0] - last[0]]) / np.hypot(*(last - first))
    clouds = np.concatenate([_evenly((np.column_stack([x, y]) - corner) / sides)[:, :2] for x, y, _ in lines])
    for word, side in zip(words, (1, -1), strict=True):
        spots = first + np.linspace(0.05, 0.95, _CANDIDATES)[:, None] * (last - first) + side * _ASIDE * normal
        spots = spots[((spots > _WORD_RIM) & (spots < 1 - _WORD_RIM)).all(axis=1)]
        if word and spots.size:
            room = [np.hypot(*((clouds - spot) * _WORD).T).min(initial=_WORD_ROOM) for spot in spots]
            place = corner + sides * spots[int(np.argmax(room))]
            patch = {"facecolor": "#FFFFFFD0", "linewidth": 0, "pad": 0.8}
            axes.text(*place, word, ha="center", va="center", bbox=patch, zorder=4)


def _frame(axes: Axes) -> tuple[np.ndarray, np.ndarray]:
    """Return the corner of the panel in data, (2), and its width and height, (2), negative where an axis is turned."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    return np.array([left, low]), np.array([right - left, high - low])


def _evenly(path: np.ndarray) -> np.ndarray:
    """Return points in even steps along a line (n, 2), each with its distance from the line's start: shape (m, 3)."""
    pieces, length = [np.empty((0, 3))], 0.0
    for piece in np.split(path, np.flatnonzero(np.isnan(path).any(axis=1))):
        piece = piece[np.isfinite(piece).all(axis=1)]
        if len(piece) > 1:
            ends = np.append(0.0, np.cumsum(np.hypot(*np.diff(piece, axis=0).T)))
            s = np.arange(0.0, ends[-1], _STEP)
            pieces.append(np.column_stack([*(np.interp(s, ends, z) for z in piece.T), s + length]))
            length += ends[-1]
    return np.concatenate(pieces)


def _roomiest(path: np.ndarray, others: Sequence[np.ndarray]) -> int | None:
    """Return the first point of a path with room around it, else the one with most; none if no point is in view."""
    inside = ((path[:, :2] > _RIM) & (path[:, :2] < 1 - _RIM)).all(axis=1) & (
        path[:, 2] > np.minimum(_START, path[-1:, 2] / 3)
    )
    # the point before it lies on the same piece
    inside &= np.append(False, np.abs(np.diff(path[:, 2]) - _STEP) < 1e-9 * _STEP + 1e-12)
    found = np.flatnonzero(inside)
    if not found.size:
        return None
    found = found[:: -(-found.size // _CANDIDATES)]
    room = np.full(found.size, _ROOM)
    for k, point in enumerate(found):
        x, y, s = path[point]
        own = path[np.abs(path[:, 2] - s) > _OWN, :2]
        for cloud in (own, *others):
            if cloud.size:
                room[k] = min(room[k], np.hypot(*(cloud - (x, y)).T).min())
    return int(found[np.argmax(room)])
