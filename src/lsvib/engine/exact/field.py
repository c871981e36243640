"""The field x′ = A x + b of a mode in many digits."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

import mpmath
import numpy as np

DIGITS = 60  # ten more than the coefficients have (PLACES); ``linear_mode`` tries 120 where these do not suffice
WORST_CONDITION = 1e6  # rounding grows by so much at most: 1e-9 of the sizes of the coordinates


@dataclass(frozen=True)
class Field:
    """The field of a mode.

    ``rows`` of A and b (n, n + 1); typical ``sizes`` of the coordinates (n); ``kept``, the coordinates that do not
    change in the mode, with their values.
    """

    rows: mpmath.matrix
    sizes: np.ndarray
    kept: dict[int, mpmath.mpf]

    @property
    def alive(self) -> list[int]:
        """Return the coordinates that may change."""
        return [i for i in range(self.rows.rows) if i not in self.kept]

    def reduced(self) -> tuple[mpmath.matrix, mpmath.matrix, list]:
        """Return A, b and the sizes of the coordinates that may change; b includes the share of those that do not."""
        n, alive = self.rows.rows, self.alive
        matrix = mpmath.matrix([[self.rows[i, j] for j in alive] for i in alive])
        push = [self.rows[i, n] + sum(self.rows[i, j] * x for j, x in self.kept.items()) for i in alive]
        return matrix, mpmath.matrix(push), [mpmath.mpf(float(self.sizes[i])) for i in alive]

    def table(self) -> np.ndarray:
        """Return A and b (n, n + 1) in doubles."""
        return np.array([[float(x) for x in self.rows[i, :]] for i in range(self.rows.rows)])


def homogeneous(matrix: mpmath.matrix, push: Sequence, sizes: Sequence) -> mpmath.matrix:
    """Return the field of (x, 1), of coordinates in units of their sizes, from what :meth:`Field.reduced` returns."""
    n, units = len(sizes), [*sizes, mpmath.mpf(1)]
    found = mpmath.zeros(n + 1)
    for i in range(n):
        for j, x in enumerate([*matrix[i, :], push[i]]):
            found[i, j] = x * units[j] / units[i]
    return found


def exact_field(rows: Sequence[Sequence], sizes: Sequence[float], frozen: Mapping[int, Decimal] | None = None) -> Field:
    """Make a field from rows.

    Arguments: rows of A and b, (n, n + 1), floats (taken exactly) or decimals; typical sizes of the coordinates (n);
    ``frozen``: coordinates that keep a value in this mode, with that value.
    """
    with mpmath.workdps(DIGITS):
        matrix = mpmath.matrix([[many_digits(x) for x in row] for row in rows])
        positive = np.maximum(np.asarray(sizes, dtype=float), np.finfo(float).tiny)  # where one has underflown
        return Field(matrix, positive, {i: many_digits(x) for i, x in (frozen or {}).items()})


def many_digits(number: int | float | Decimal) -> mpmath.mpf:
    """Return a number in the digits of the context; floats are taken exactly."""
    return mpmath.mpf(number) if isinstance(number, (int, float)) else mpmath.mpf(str(number))


def amplification(out: np.ndarray, into: np.ndarray, sizes: np.ndarray) -> float:
    """Return the largest amplification of rounding into other coordinates and back, max_i Σ_j |V_ij| (|W| x)_j / x_i.

    Arguments: V (n, p), W (p, n or n + 1, the last for constants), sizes x (n). Infinite beyond the range of doubles.
    """
    given = np.append(sizes, 1.0)[: into.shape[1]]
    with np.errstate(over="ignore", invalid="ignore"):
        found = float(np.max(np.abs(out) @ (np.abs(into) @ given) / sizes))
    return found if found == found else math.inf
