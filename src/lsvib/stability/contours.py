"""Where a function of two parameters vanishes: points of the curve to rounding, joined to lines.

The function is evaluated at the nodes of a grid. On every side of a cell at whose ends it differs in sign, the root is
found by bracketing; the roots on the sides of a cell are joined. So all points lie on the curve, and only what lies
between them is interpolated. A curve that enters and leaves a cell through one side is missed.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from lsvib.dynamics.forward_slip import bracketed_root

PlaneFunction = Callable[[float, float], float]
_TOLERANCE = 1e-13  # rounding of the place
_Key = tuple[int, int, int]  # of a side: node, and 0 along x, 1 along y


def contour(
    function: PlaneFunction, x: Sequence[float], y: Sequence[float], values: np.ndarray, tolerance: float = _TOLERANCE
) -> list[np.ndarray]:
    """Return the lines on which a function of x and y vanishes, each as points (k, 2).

    Arguments: ``function``, nan where it is not defined; ``x`` (n) and ``y`` (m), ascending, with its ``values``
    (m, n); relative ``tolerance`` of a place on a side of a cell. A line ends at the edge of the grid, or within a cell
    of where the function is not defined.
    """
    sides: dict[_Key, np.ndarray] = {}
    neighbours: dict[_Key, list[_Key]] = {}
    for j in range(len(y) - 1):
        for i in range(len(x) - 1):
            crossed = [key for key in _sides(i, j) if _changes(values, key)]
            for key in crossed:
                if key not in sides:
                    sides[key] = _root(function, x, y, key, tolerance)
            for a, b in _joined(crossed, values[j, i]):
                neighbours.setdefault(a, []).append(b)
                neighbours.setdefault(b, []).append(a)
    return [np.array([sides[key] for key in line]) for line in _lines(neighbours)]


def _sides(i: int, j: int) -> tuple[_Key, ...]:
    """The sides of a cell, in their order around it."""
    return (i, j, 0), (i + 1, j, 1), (i, j + 1, 0), (i, j, 1)


def _ends(key: _Key) -> tuple[tuple[int, int], tuple[int, int]]:
    """The nodes (i, j) at the ends of a side."""
    i, j, along = key
    return (i, j), (i + 1 - along, j + along)


def _changes(values: np.ndarray, key: _Key) -> bool:
    (i, j), (k, n) = _ends(key)
    a, b = values[j, i], values[n, k]
    return bool(math.isfinite(a) and math.isfinite(b) and (a > 0) != (b > 0))


def _root(function: PlaneFunction, x: Sequence[float], y: Sequence[float], key: _Key, tolerance: float) -> np.ndarray:
    """The point of a side at which the function vanishes."""
    (i, j), (k, n) = _ends(key)
    low, high = np.array([x[i], y[j]]), np.array([x[k], y[n]])

    def along(part: float) -> float:
        return function(*(low + part * (high - low)))

    part = bracketed_root(along, 0.0, 1.0, tolerance)
    return low + part * (high - low)


def _joined(crossed: list[_Key], corner: float) -> list[tuple[_Key, _Key]]:
    """Pairs of crossed sides of a cell that belong together; of four, those that cut off the corners unlike (i, j)."""
    if len(crossed) == 2:
        return [(crossed[0], crossed[1])]
    if len(crossed) == 4:
        bottom, right, top, left = crossed
        return [(bottom, right), (top, left)] if corner > 0 else [(bottom, left), (top, right)]
    return []


def _lines(neighbours: dict[_Key, list[_Key]]) -> list[list[_Key]]:
    """Chains of points, open ones from their ends, closed ones back to where they begin."""
    left, lines = {key: list(others) for key, others in neighbours.items()}, []

    def walk(key: _Key) -> list[_Key]:
        """Follow the chain from a point and take its links away."""
        line = [key]
        while left[line[-1]]:
            following = left[line[-1]].pop(0)
            left[following].remove(line[-1])
            line.append(following)
        return line

    for ends in (True, False):
        for key in neighbours:
            if left[key] and (not ends or len(neighbours[key]) == 1):
                lines.append(walk(key))
    return lines
