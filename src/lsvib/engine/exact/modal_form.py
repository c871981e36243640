"""From a linear field x′ = A x + b to the modal tables of :mod:`lsvib.engine.kernels.flow_modal`, in 60 digits or more.

The characteristic polynomial is split into factors: s² + a₁ s + a₀ for two complex rates or the two closest real ones,
s − r for a single real rate, s for zero. With P the product of the other factors, Π = m(A) P(A) projects on the
subspace of a factor, where m is the inverse of P modulo the factor (:mod:`lsvib.engine.exact.factors`). None of this is
sensitive where the two rates of a factor coincide. On the subspace, q = ℓΠx with a row ℓ obeys the scalar equation of
the factor, so (q, q′) is an oscillator, or q alone is an exponential. Rates that are repeated without a chain share a
factor, and each of them gets such a row.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import mpmath
import numpy as np

from lsvib.engine.exact.factors import subspaces
from lsvib.engine.exact.field import DIGITS, WORST_CONDITION, Field, amplification, many_digits
from lsvib.engine.kernels import columns
from lsvib.engine.kernels.tables import ModalFlow

_LOST = 1e-12  # of an entry of a guard in modal coordinates: from here on it is computed with all digits
_NOTHING = mpmath.mpf(10) ** -40  # of the terms of such an entry: the rounding of coefficients, which have 50 digits
_KEPT = 8  # matrices whose subspaces are kept: with all frictions the modes of a model have six


@dataclass(frozen=True)
class ModalMode:
    """One mode in modal form, with p pairs, s singles and q = 2p + s coordinates.

    Oscillator rows (p), rates and pushes (s), W and w₀ (q, n + 1), V and v₀ (n, q + 1), A and b (n, n + 1), see
    :class:`lsvib.engine.kernels.tables.ModalFlow`. ``condition`` is the largest amplification of rounding,
    max_i Σ_j |V_ij| (|W| x)_j / x_i, for states of the sizes x, or of changes to them. ``exact``: V and v₀ before they
    were rounded, if known.
    """

    oscillators: np.ndarray
    rates: np.ndarray
    pushes: np.ndarray
    to_modal: np.ndarray
    from_modal: np.ndarray
    field: np.ndarray
    condition: float
    exact: mpmath.matrix | None = None

    @property
    def time_scales(self) -> list[float]:
        """Time scales [s] of the pairs, and of the singles that are carried about their equilibrium."""
        about = self.rates[(self.rates != 0.0) & (self.pushes == 0.0)]
        return [*self.oscillators[:, columns.TIME_SCALE], *(1.0 / np.abs(about))]


def modal_mode(
    field: Field, digits: int = DIGITS, reaches: Sequence[tuple[float, np.ndarray]] | None = None
) -> ModalMode:
    """Decompose a field in the given number of digits.

    Its loss of digits is judged by states of the sizes of the field, or by the changes until some times [s], with
    which states have come to other sizes (n) there (:func:`lsvib.engine.exact.reach.slow_reaches`).
    Raises ``ArithmeticError`` if rates coincide with a chain, other than two real ones, or if rates of different
    factors lie so close together that double precision cannot carry the modal form (condition above 1e6).
    """
    with mpmath.workdps(digits):
        matrix, constant, scale = field.reduced()
        pairs, singles = [], []
        for space in _spaces(tuple(matrix), tuple(scale), digits):
            if len(space.factor) == 3:
                pairs += [_pair(constant, space.factor, *frame) for frame in space.frames]
            else:
                singles += _singles(constant, -space.factor[1], space.projector, scale, space.slow, space.rank)
        mode = _tables(field, pairs, singles)
    if reaches is not None:
        mode = replace(mode, condition=max(_loss(mode, time, sizes) for time, sizes in reaches))
    if not mode.condition < WORST_CONDITION:
        raise ArithmeticError(f"rates of a mode nearly coincide (condition {mode.condition:.1e})")
    return mode


def _loss(mode: ModalMode, time: float, sizes: np.ndarray) -> float:
    """Return the amplification of the rounding of what changes until a time [s] in states of some sizes (n).

    Growth counts up to one time constant. What is moved by its change (:mod:`lsvib.engine.kernels.flow_modal`) may lose
    one digit more, and a coordinate that is not small enough for that four digits of its own.
    """
    pairs, rates, pushes = len(mode.oscillators), np.abs(mode.rates), np.abs(mode.pushes)
    rows = mode.oscillators
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        moves = np.abs(mode.to_modal) @ np.append(sizes, 1.0)
        turned = np.minimum(1.0, time / rows[:, columns.TIME_SCALE] + np.abs(rows[:, columns.A1]) * time)
        moves[: 2 * pairs] *= np.repeat(turned, 2)
        moves[2 * pairs :] = (rates * moves[2 * pairs :] + pushes) * np.minimum(time, 1 / rates)
        found = float(np.max(np.abs(mode.from_modal[:, :-1]) @ moves / sizes))
    return found if found == found else math.inf


class _Space(NamedTuple):
    """A subspace of a matrix: its factor, its projector, whether it is slow, its rank, and frames of its pairs.

    A frame is a row ℓ, the row ℓA, and the vectors (n, 2) that give states back from both.
    """

    factor: list
    projector: mpmath.matrix
    slow: bool
    rank: int
    frames: list[tuple[mpmath.matrix, mpmath.matrix, mpmath.matrix]]


@lru_cache(maxsize=_KEPT)
def _spaces(entries: tuple, scale: tuple, digits: int) -> list[_Space]:
    """Return the subspaces of a matrix, by its elements row by row, found with so many digits.

    Most modes of a model differ from another one by their constants only, so the answers are kept; ``digits`` is the
    precision that is set, and an argument because an answer holds for that alone.
    """
    n = len(scale)
    matrix, spaces = mpmath.matrix([list(entries[n * i : n * (i + 1)]) for i in range(n)]), []
    for factor, projector, slow in subspaces(matrix, list(scale)):
        rank = int(mpmath.nint(mpmath.re(sum(projector[i, i] for i in range(projector.rows)))))
        frames = _frames(matrix, factor, projector, scale, rank // 2) if len(factor) == 3 else []
        spaces.append(_Space(factor, projector, slow, rank, frames))
    if sum(space.rank for space in spaces) != n or not all(space.rank > 0 for space in spaces):
        raise ArithmeticError("no digit is left of a subspace")
    return spaces


class _Piece(NamedTuple):
    """A pair or a single: its row of the oscillator table, or (rate, push); rows into and out of its coordinates."""

    row: np.ndarray
    into: mpmath.matrix  # (1 or 2, n + 1)
    out: mpmath.matrix  # (n, 2 or 3), the constant last


def _singles(constant, rate, projector, scale, slow: bool, rank: int) -> list[_Piece]:
    """Return the exponentials of the subspace of one rate, as many as the subspace has dimensions."""
    rows = max(combinations(range(projector.rows), rank), key=lambda chosen: abs(_minor(projector, chosen, scale)))
    block = mpmath.matrix([[projector[i, j] for j in rows] for i in rows]) ** -1
    singles = []
    for k, i in enumerate(rows):
        # Coordinates q = Π x at the chosen rows; the vectors that give them back are dual to these rows.
        vector = [sum(projector[a, j] * block[m, k] for m, j in enumerate(rows)) for a in range(projector.rows)]
        covector = projector[i, :]
        push = (covector * constant)[0]
        # The equilibrium of a slow exponential may lie far away, and then it is carried without it. Near by it is not:
        # what dies away would leave the rounding of its start behind.
        size = sum(abs(x) * s for x, s in zip(covector, scale, strict=True))
        without = not rate or (slow and abs(push) > abs(rate) * size)
        shift, left = (mpmath.mpf(0), push) if without else (push / rate, mpmath.mpf(0))
        out = mpmath.matrix([[x, -x * shift] for x in vector])
        singles.append(_Piece(np.array([rate, left], dtype=float), mpmath.matrix([[*covector, shift]]), out))
    return singles


def _minor(projector, chosen, scale):
    """Return the determinant of the chosen rows and columns of a projector, in scaled coordinates."""
    return mpmath.det(mpmath.matrix([[projector[i, j] * scale[j] / scale[i] for j in chosen] for i in chosen]))


def _frames(matrix, factor, projector, scale, count: int) -> list:
    """Return frames of the oscillators of a factor of degree two that ``count`` pairs share, split off one by one."""
    weights, frames = mpmath.diag([s * s for s in scale]), []
    for left in reversed(range(count)):
        covector = _row_of_pair(matrix, factor, projector, scale)
        turned = covector * matrix
        rows = mpmath.matrix([list(covector), list(turned)])
        if left:
            vector = projector * weights * covector.T
            vectors = mpmath.matrix([list(vector), list(matrix * vector)]).T
            vectors = vectors * (rows * vectors) ** -1
            projector = projector - vectors * rows
        else:
            vectors = projector * weights * rows.T * (rows * weights * rows.T) ** -1
        frames.append((covector, turned, vectors))
    return frames


def _pair(constant, factor, covector, turned, vectors) -> _Piece:
    """Return the oscillator of a frame under a constant push."""
    _, a1, a0 = factor
    push = (covector * constant)[0]
    rest = (a1 * push + (turned * constant)[0]) / a0  # equilibrium of q
    into = mpmath.matrix([[*covector, -rest], [*turned, push]])
    out = [[vectors[i, 0], vectors[i, 1], vectors[i, 0] * rest - vectors[i, 1] * push] for i in range(vectors.rows)]
    return _Piece(_row(a0, a1), into, mpmath.matrix(out))


def _row_of_pair(matrix, factor, projector, scale) -> mpmath.matrix:
    """Return a row ℓΠ of the subspace of a pair that is as independent of ℓAΠ as possible."""
    unit = mpmath.sqrt(abs(factor[2]))
    rows = [[mpmath.mpf(i == j) / scale[j] for j in range(len(scale))] for i in range(len(scale))]
    candidates = rows + [[x + y for x, y in zip(*two, strict=True)] for two in combinations(rows, 2)]

    def length(candidate) -> mpmath.mpf:
        return mpmath.norm([x * s for x, s in zip(mpmath.matrix([candidate]) * projector, scale, strict=True)])

    def spread(candidate) -> mpmath.mpf:
        """Return the square of the sine of the angle between ℓΠ and ℓAΠ."""
        covector = mpmath.matrix([candidate]) * projector
        first = [x * s for x, s in zip(covector, scale, strict=True)]
        second = [x * s / unit for x, s in zip(covector * matrix, scale, strict=True)]
        product = sum(x * y for x, y in zip(first, second, strict=True))
        return 1 - product * product / (sum(x * x for x in first) * sum(x * x for x in second))

    # Rows that are nearly orthogonal to the subspace consist of rounding.
    longest = max(map(length, candidates))
    return mpmath.matrix([max((x for x in candidates if length(x) > longest / 100), key=spread)]) * projector


def _row(a0, a1) -> np.ndarray:
    """Return the row of the oscillator table for s² + a₁ s + a₀, without force."""
    row = np.zeros(columns.COUNT)
    alpha, discriminant = a1 / 2, a1 * a1 / 4 - a0
    row[columns.A0], row[columns.A1], row[columns.ALPHA] = float(a0), float(a1), float(alpha)
    if discriminant < 0:
        row[columns.BETA] = float(mpmath.sqrt(-discriminant))
    else:
        delta = mpmath.sqrt(discriminant)
        large = -(alpha + delta) if alpha >= 0 else -alpha + delta
        small = a0 / large
        row[columns.DELTA] = float(delta)
        row[columns.R1], row[columns.R2] = float(max(large, small)), float(min(large, small))
    row[columns.TIME_SCALE] = float(1 / mpmath.sqrt(abs(a0)))
    return row


def _tables(field: Field, pairs: list[_Piece], singles: list[_Piece]) -> ModalMode:
    n, count, alive = field.rows.rows, 2 * len(pairs) + len(singles), field.alive
    to_modal, exact = np.zeros((count, n + 1)), mpmath.zeros(n, count + 1)
    for i, value in field.kept.items():
        exact[i, count] = value
    first = 0
    for piece in [*pairs, *singles]:
        for k in range(piece.into.rows):
            for j, i in enumerate(alive):
                to_modal[first + k, i] = float(piece.into[k, j])
                exact[i, first + k] = piece.out[j, k]
            to_modal[first + k, n] = float(piece.into[k, len(alive)])
        for j, i in enumerate(alive):
            exact[i, count] += piece.out[j, piece.into.rows]
        first += piece.into.rows
    from_modal = np.array(exact.tolist(), dtype=float)
    condition = amplification(from_modal[:, :-1], to_modal, field.sizes)
    return ModalMode(
        np.array([pair.row for pair in pairs]).reshape(-1, columns.COUNT),
        *np.array([single.row for single in singles]).reshape(-1, 2).T.copy(),
        to_modal,
        from_modal,
        field.table(),
        condition,
        exact,
    )


def guard_forms(modes: Sequence[ModalMode], rows: Sequence[Sequence[Sequence]]) -> list[list[float]] | None:
    """Return the guards of all modes in modal coordinates (g, q + 1), from their rows (n + 1) of decimals by mode.

    An entry that the doubles of the tables give to 1e-12 is the one that they give. None if all are so. An entry that
    is nothing but the rounding of the coefficients is zero: a speed that dies away would seem to stop there.
    """
    width, found, lost = max(len(mode.to_modal) for mode in modes) + 1, [], False
    with mpmath.workdps(DIGITS):
        for mode, guards in zip(modes, rows, strict=True):
            table, count = mode.from_modal.tolist(), len(mode.to_modal)
            for guard in guards:
                *exact, constant = (many_digits(x) for x in guard)
                *plain, last = (float(x) for x in guard)
                form = [0.0] * width
                for j in range(count + 1):
                    place = j if j < count else -1
                    true, rounded = (constant, last) if j == count else (mpmath.mpf(0), 0.0)
                    terms = abs(true)
                    for i, weight in enumerate(plain):
                        term = exact[i] * mode.exact[i, place]
                        true, terms = true + term, terms + abs(term)
                        rounded += weight * table[i][place]
                    true = true if abs(true) > _NOTHING * terms else mpmath.mpf(0)
                    unsure = abs(true - rounded) > _LOST * abs(true)
                    form[j], lost = float(true) if unsure else rounded, lost or unsure
                found.append(form)
    return found if lost else None


def modal_flow(modes: Sequence[ModalMode]) -> ModalFlow:
    """Put modes together in one table; modes with fewer pairs or singles leave the rest zero."""
    pairs, singles = np.array([len(mode.oscillators) for mode in modes]), np.array([mode.rates.size for mode in modes])
    size, n = (2 * pairs + singles).max(), modes[0].field.shape[0]
    flow = ModalFlow(
        pairs,
        singles,
        np.zeros((len(modes), pairs.max(), columns.COUNT)),
        np.zeros((len(modes), singles.max())),
        np.zeros((len(modes), singles.max())),
        np.zeros((len(modes), size, n + 1)),
        np.zeros((len(modes), n, size + 1)),
        np.array([mode.field for mode in modes]),
    )
    for k, mode in enumerate(modes):
        own = len(mode.to_modal)
        flow.oscillators[k, : pairs[k]] = mode.oscillators
        flow.rates[k, : singles[k]], flow.pushes[k, : singles[k]] = mode.rates, mode.pushes
        flow.to_modal[k, :own] = mode.to_modal
        flow.from_modal[k, :, :own] = mode.from_modal[:, :-1]
        flow.from_modal[k, :, -1] = mode.from_modal[:, -1]
    return flow
