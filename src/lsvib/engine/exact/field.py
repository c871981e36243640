"""The field x′ = A x + b of a mode in many digits, as balls of the library FLINT (Arb): a midpoint and a radius."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from lsvib.engine.exact.arithmetic import ball

WORST_CONDITION = 1e6  # rounding grows by so much at most: 1e-9 of the sizes of the coordinates

Rows = Sequence[Sequence[arb | float | int]]


@dataclass(frozen=True)
class Field:
    """The field of a mode.

    ``rows`` of A and b (n, n + 1), balls or floats; typical ``sizes`` of the coordinates (n); ``kept``, the
    coordinates that do not change in the mode, with their values.
    """

    rows: Rows
    sizes: np.ndarray
    kept: Mapping[int, arb | float]

    @classmethod
    def of(cls, rows: Rows, sizes: Sequence[float], kept: Mapping[int, arb | float] | None = None) -> "Field":
        """Make a field; a size that has underflown is the least double."""
        positive = np.maximum(np.asarray(sizes, dtype=float), np.finfo(float).tiny)
        return cls(tuple(tuple(row) for row in rows), positive, dict(kept or {}))

    @property
    def alive(self) -> list[int]:
        """Return the coordinates that may change."""
        return [i for i in range(len(self.rows)) if i not in self.kept]

    def matrix(self) -> tuple[tuple[arb | float | int, ...], ...]:
        """Return A between the coordinates that may change."""
        return tuple(tuple(self.rows[i][j] for j in self.alive) for i in self.alive)

    def push(self) -> list[arb]:
        """Return b of the coordinates that may change, with the share of those that do not."""
        own = ((self.rows[i][-1], self.rows[i]) for i in self.alive)
        return [ball(last) + sum((ball(row[j]) * ball(x) for j, x in self.kept.items()), arb(0)) for last, row in own]

    def scale(self) -> list[float]:
        """Return the sizes of the coordinates that may change."""
        return [float(self.sizes[i]) for i in self.alive]

    def table(self) -> np.ndarray:
        """Return A and b (n, n + 1) in doubles."""
        return np.array([[float(x) for x in row] for row in self.rows])


def balls(rows: Rows) -> arb_mat:
    """Return a matrix of numbers in the digits of the context."""
    return arb_mat([[ball(x) for x in row] for row in rows])


def homogeneous(field: Field) -> arb_mat:
    """Return the field of (x, 1) between the coordinates that may change, in units of their sizes."""
    units = [*map(arb, field.scale()), arb(1)]
    rows = [[*map(ball, row), last] for row, last in zip(field.matrix(), field.push(), strict=True)]
    found = [[x * units[j] / units[i] for j, x in enumerate(row)] for i, row in enumerate(rows)]
    return arb_mat([*found, [0] * len(units)])


def amplification(out: np.ndarray, into: np.ndarray, sizes: np.ndarray) -> float:
    """Return the largest amplification of rounding into other coordinates and back, max_i Σ_j |V_ij| (|W| x)_j / x_i.

    Arguments: V (n, p), W (p, n or n + 1, the last for constants), sizes x (n). Infinite beyond the range of doubles.
    """
    given = np.append(sizes, 1.0)[: into.shape[1]]
    with np.errstate(over="ignore", invalid="ignore"):
        found = float(np.max(np.abs(out) @ (np.abs(into) @ given) / sizes))
    return found if found == found else math.inf
