"""The modal form of one mode of many drives at once, in pairs of doubles with bounds of their errors.

It is :mod:`lsvib.engine.exact.modal_form` again, with arrays of :class:`lsvib.engine.exact.pair_arrays.Pairs` in place
of 60 digits, where all rates are simple (:mod:`lsvib.engine.exact.rate_patterns`). Forms that are safe are those of 60
digits to rounding; their oscillators may stand in another order. Everything else – rates that nearly coincide, choices
that 32 digits do not decide, a condition that is too large – is unsafe.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from lsvib.engine.exact.factors import projector
from lsvib.engine.exact.field import WORST_CONDITION, amplification
from lsvib.engine.exact.modal_form import ModalMode
from lsvib.engine.exact.pair_arrays import Pairs, double
from lsvib.engine.exact.pair_matrices import (
    Matrix,
    dot,
    high,
    is_zero,
    over,
    picked,
    plain,
    polynomial,
    product,
    summed,
    times,
)
from lsvib.engine.exact.rate_patterns import CLEAR, Pattern, Rates, patterns_of, rates_of
from lsvib.engine.kernels import columns

_LENGTH = 0.01  # part of the longest row of a subspace from which on a row is no rounding
_LITTLE = 2.0**-51  # bound of the error of an entry, relative to its row: two units in the last place
_EQUAL_ANGLES = 1e-11  # cosines that differ by less may be equal but for the rounding of doubles


class ManyModes(NamedTuple):
    """One mode of many drives (k): for each of them its modal form, None where 60 digits are needed."""

    modes: list[ModalMode | None]

    @property
    def condition(self) -> np.ndarray:
        """Largest amplification of rounding (k), infinite where there is no form."""
        return np.array([np.inf if mode is None else mode.condition for mode in self.modes])

    @property
    def time_scales(self) -> list[np.ndarray]:
        """The shortest time scale [s] of each drive (k)."""
        return [np.array([np.inf if mode is None else min(mode.time_scales) for mode in self.modes])]


def modal_modes(
    rows: Sequence[Sequence[Any]], sizes: Sequence[Any], frozen: Mapping[int, Any], unsafe: np.ndarray
) -> ManyModes:
    """Decompose the field of one mode of many drives.

    Arguments: rows of A and b (n, n + 1), of numbers and ``Pairs`` (k); sizes of the coordinates (n), numbers or arrays
    of doubles (k); ``frozen``, coordinates that keep a value; ``unsafe`` (k), what is known to be.
    """
    field = _Field.of(rows, sizes, frozen, unsafe)
    found: list[ModalMode | None] = [None] * unsafe.size
    with np.errstate(all="ignore"):  # what overflows or divides by zero is unsafe
        rates = rates_of(field.matrix, unsafe)
        patterns = patterns_of(rates)
        for pattern in sorted(set(patterns) - {None}):
            members = np.flatnonzero([one == pattern for one in patterns])
            own = np.zeros(members.size, dtype=bool)
            made = _decomposed(field.at(members, own), rates.at(members, own), pattern, own)
            for place in np.flatnonzero(~own):
                found[members[place]] = made.mode(place)
    return ManyModes(found)


class _Field(NamedTuple):
    """The coordinates that may change, A and b among them, the sizes of all, what is kept, and the whole field."""

    alive: list[int]
    matrix: Matrix
    push: list[Any]
    sizes: list[np.ndarray]
    kept: dict[int, Any]
    rows: Matrix

    @classmethod
    def of(cls, rows, sizes, frozen, unsafe) -> "_Field":
        """Return the field from what :func:`modal_modes` is given."""
        n, rows = len(rows), [[plain(x) for x in row] for row in rows]
        alive = [i for i in range(n) if i not in frozen]
        push = [summed([rows[i][n], *(times(rows[i][j], x) for j, x in frozen.items())]) for i in alive]
        columns_of_sizes = [np.broadcast_to(np.asarray(x, dtype=float), unsafe.shape) for x in sizes]
        return cls(
            alive, [[rows[i][j] for j in alive] for i in alive], push, columns_of_sizes, dict(frozen),
            rows,
        )  # fmt: skip

    def at(self, members: np.ndarray, unsafe: np.ndarray) -> "_Field":
        """Return the field of some drives (j, indices), with a record of what is unsafe of its own."""

        def part(x: Any) -> Any:
            return x.at(members, unsafe) if isinstance(x, Pairs) else x

        return _Field(
            self.alive,
            [[part(x) for x in row] for row in self.matrix],
            [part(x) for x in self.push],
            [size[members] for size in self.sizes],
            {i: part(x) for i, x in self.kept.items()},
            [[part(x) for x in row] for row in self.rows],
        )


class _ManyPieces(NamedTuple):
    """A pair or a single: its row of the oscillator table, or (rate, push); rows into and out of its coordinates."""

    row: list[Any]
    into: Matrix  # (1 or 2, n + 1)
    out: Matrix  # (n, 2 or 3), the constant last


def _decomposed(field: _Field, rates: Rates, pattern: Pattern, unsafe: np.ndarray) -> "_Tables":
    """Form the tables of drives whose rates are taken together in one way; marks what is unsafe."""
    factors = []
    for j in pattern.upper:
        x, y = rates.parts[j]
        factors.append([1, -2 * x, x * x + y * y])
    for a, b in pattern.together:
        (x, _), (y, _) = rates.parts[a], rates.parts[b]
        factors.append([1, -(x + y), x * y])
    factors += [[1, -rates.parts[j][0]] for j in pattern.alone]
    factors += [[1, 0]] * rates.zeros
    square = product(field.matrix, field.matrix)
    pairs, singles = [], []
    for k, factor in enumerate(factors):
        space = projector(factors, k, lambda part: polynomial(part, field.matrix, square), product)
        if len(factor) == 2:
            alone = k - len(pattern.upper) - len(pattern.together)
            slow = alone >= len(pattern.slow) or pattern.slow[alone]
            singles.append(_single(field, factor, space, slow, unsafe))
            continue
        if k < len(pattern.upper):
            x, y = rates.parts[pattern.upper[k]]
            row = {columns.BETA: y, columns.ALPHA: -x}
        else:
            (x, _), (y, _) = (rates.parts[j] for j in pattern.together[k - len(pattern.upper)])
            row = {columns.DELTA: (x - y) / 2, columns.ALPHA: -(x + y) / 2, columns.R1: x, columns.R2: y}
        row |= {columns.A0: factor[2], columns.A1: factor[1], columns.TIME_SCALE: 1 / abs(factor[2]).sqrt()}
        pairs.append(_pair(field, factor, space, [row.get(i, 0) for i in range(columns.COUNT)], unsafe))
    return _Tables.of(field, pairs, singles, unsafe)


def _single(field: _Field, factor: list, projector: Matrix, slow: bool, unsafe: np.ndarray) -> _ManyPieces:
    """Return the exponential of one rate."""
    n = len(projector)
    diagonal = np.stack([np.abs(high(projector[i][i], unsafe.size)) for i in range(n)], axis=1)
    chosen = np.argmax(diagonal, axis=1)
    _must_differ(diagonal, chosen, CLEAR, unsafe)
    covector = [picked([projector[i][j] for i in range(n)], chosen, unsafe) for j in range(n)]
    block = 1 / picked([projector[i][i] for i in range(n)], chosen, unsafe)
    vector = [times(picked(projector[a], chosen, unsafe), block) for a in range(n)]
    push = dot(covector, field.push)
    rate = -factor[1]
    if is_zero(rate):
        shift, left = 0, push
    elif slow and not is_zero(push):  # without its equilibrium where that is far away, as for one drive
        reach = sum(np.abs(high(x, unsafe.size)) * field.sizes[i] for i, x in zip(field.alive, covector, strict=True))
        away = np.abs(high(push, unsafe.size)) / np.abs(high(rate, unsafe.size))
        unsafe |= np.abs(away - reach) <= CLEAR * reach
        without = np.where(away > reach, 1, 0)
        shift, left = picked([push / rate, 0], without, unsafe), picked([0, push], without, unsafe)
    else:
        shift, left = over(push, rate), 0
    return _ManyPieces([rate, left], [[*covector, shift]], [[x, -times(x, shift)] for x in vector])


def _pair(field: _Field, factor: list, projector: Matrix, row: list, unsafe: np.ndarray) -> _ManyPieces:
    """Return the oscillator of a factor of degree two."""
    _, a1, a0 = factor
    n, scale = len(projector), [field.sizes[i] for i in field.alive]
    weights = [Pairs.exactly(s, unsafe) for s in scale]
    turned = product(projector, field.matrix)
    first = [[over(x, weights[i]) for x in projector[i]] for i in range(n)]
    second = [[over(x, weights[i]) for x in turned[i]] for i in range(n)]
    both = [*((i, None) for i in range(n)), *combinations(range(n), 2)]
    chosen = _best_row(first, second, both, scale, np.sqrt(np.abs(high(a0, unsafe.size))), unsafe)
    rows = []
    for table in (first, second):
        candidates = [
            table[i] if j is None else [summed([x, y]) for x, y in zip(table[i], table[j], strict=True)]
            for i, j in both
        ]
        rows.append([picked([one[m] for one in candidates], chosen, unsafe) for m in range(n)])
    heavy = [[times(times(x, w), w) for x, w in zip(one, weights, strict=True)] for one in rows]
    gram = [[dot(one, other) for other in heavy] for one in rows]
    norm = gram[0][0] * gram[1][1] - gram[0][1] * gram[1][0]
    inverse = [[gram[1][1] / norm, -gram[0][1] / norm], [-gram[1][0] / norm, gram[0][0] / norm]]
    spread = [[dot(projector[i], one) for one in heavy] for i in range(n)]
    vectors = [[dot(spread[i], [inverse[0][m], inverse[1][m]]) for m in (0, 1)] for i in range(n)]
    push = dot(rows[0], field.push)
    rest = (a1 * push + dot(rows[1], field.push)) / a0  # equilibrium of q
    out = [[*v, summed([times(v[0], rest), -times(v[1], push)])] for v in vectors]
    return _ManyPieces(row, [[*rows[0], -rest], [*rows[1], push]], out)


def _best_row(first: Matrix, second: Matrix, both: list, scale: list, unit: np.ndarray, unsafe: np.ndarray):
    """Choose among rows ℓΠ the one that is as independent of ℓAΠ as possible, as for one drive; indices (k)."""

    def scaled(table: Matrix, factor: Any) -> np.ndarray:
        """Return the candidates of all drives in sizes of the coordinates, (k, candidates, n)."""
        one = [
            np.stack([high(x, unsafe.size) * s * factor for x, s in zip(row, scale, strict=True)], axis=-1)
            for row in table
        ]
        return np.stack([one[i] if j is None else one[i] + one[j] for i, j in both], axis=1)

    here, there = scaled(first, 1.0), scaled(second, 1.0 / unit)
    length, other = np.sqrt((here * here).sum(axis=2)), np.sqrt((there * there).sum(axis=2))
    longest = length.max(axis=1, keepdims=True)
    unsafe |= (np.abs(length - _LENGTH * longest) <= CLEAR * longest).any(axis=1)
    cosine = np.abs((here * there).sum(axis=2)) / (length * other)
    cosine[~(length > _LENGTH * longest)] = np.inf
    chosen = np.argmin(cosine, axis=1)
    least = np.take_along_axis(cosine, chosen[:, None], axis=1)
    own = np.take_along_axis(here, chosen[:, None, None], axis=1)
    rival = (cosine <= least + _EQUAL_ANGLES) & (here != own).any(axis=2)  # the same row twice is no rival
    unsafe |= rival.any(axis=1) | ~np.isfinite(least[:, 0])
    return chosen


def _must_differ(values: np.ndarray, chosen: np.ndarray, margin: float, unsafe: np.ndarray) -> None:
    """Mark entries whose largest value (k, n) another one comes close to."""
    largest = np.take_along_axis(values, chosen[:, None], axis=1)
    near = values >= largest * (1 - margin)
    unsafe |= (near.sum(axis=1) != 1) | ~np.isfinite(largest[:, 0])


class _Tables(NamedTuple):
    """The modal forms of many drives, arrays as those of :class:`lsvib.engine.exact.modal_form.ModalMode`."""

    oscillators: np.ndarray
    rates: np.ndarray
    pushes: np.ndarray
    to_modal: np.ndarray
    from_modal: np.ndarray
    field: np.ndarray
    condition: list[float]

    @classmethod
    def of(cls, field: _Field, pairs: list[_ManyPieces], singles: list[_ManyPieces], unsafe: np.ndarray) -> "_Tables":
        """Put the pieces together, rounded to doubles; marks what a rounding leaves open."""
        n, size, alive = len(field.rows), unsafe.size, field.alive
        count, sizes = 2 * len(pairs) + len(singles), np.stack([*field.sizes, np.ones(unsafe.size)], axis=1)
        into, out, offset = [], [[0] * count for _ in range(n)], [field.kept.get(i, 0) for i in range(n)]
        for piece in [*pairs, *singles]:
            first = len(into)
            for k, row in enumerate(piece.into):
                whole = [0] * n + [row[-1]]
                for j, i in enumerate(alive):
                    whole[i], out[i][first + k] = row[j], piece.out[j][k]
                into.append(whole)
            for j, i in enumerate(alive):
                offset[i] = summed([offset[i], piece.out[j][-1]])
        to_modal = _rounded(into, sizes, unsafe)
        reach = np.einsum("kij,kj->ki", np.abs(to_modal), sizes)
        columns_of_out = [[*row, x] for row, x in zip(out, offset, strict=True)]
        from_modal = _rounded(columns_of_out, np.concatenate([reach, np.ones((size, 1))], axis=1), unsafe)
        oscillators, rates = np.zeros((size, len(pairs), columns.COUNT)), np.zeros((2, size, len(singles)))
        for j, piece in enumerate(pairs):
            for i, x in enumerate(piece.row):
                oscillators[:, j, i] = _nearly(x, np.abs(high(x, size)), unsafe)
        for j, piece in enumerate(singles):
            rate, push = piece.row
            rates[0, :, j] = _nearly(rate, np.abs(high(rate, size)), unsafe)
            turnover = np.abs(high(push, size)) + np.abs(rates[0, :, j]) * reach[:, 2 * len(pairs) + j]
            rates[1, :, j] = _nearly(push, turnover, unsafe)
        table = np.zeros((size, n, n + 1))
        for i in range(n):
            for j in range(n + 1):
                table[:, i, j] = double(field.rows[i][j])
        sizes = sizes[:, :-1]
        condition = [
            np.inf if bad else amplification(back[:, :-1], there, own)
            for bad, back, there, own in zip(unsafe.tolist(), from_modal, to_modal, sizes, strict=True)
        ]
        unsafe |= ~(np.array(condition) < WORST_CONDITION)
        return cls(oscillators, rates[0], rates[1], to_modal, from_modal, table, condition)

    def mode(self, place: int) -> ModalMode:
        """Return the modal form of one drive."""
        return ModalMode(*(column[place] for column in self))


def _rounded(rows: Matrix, sizes: np.ndarray, unsafe: np.ndarray) -> np.ndarray:
    """Round a table (rows, m) of numbers that are applied to coordinates of certain sizes (k, m); doubles (k, rows, m).

    An entry that is not sure to the last bit is good if its error is far below the rounding of the sum of its row.
    """
    found = np.stack([np.stack([high(x, unsafe.size) for x in row], axis=-1) for row in rows], axis=1)
    totals = np.einsum("kij,kj->ki", np.abs(found), sizes)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            _nearly(x, totals[:, i] / sizes[:, j], unsafe)
    return found


def _nearly(x: Any, size: np.ndarray, unsafe: np.ndarray) -> np.ndarray:
    """Round a number to doubles (k); marks those that are in error by more than ``_LITTLE`` of a size."""
    if not isinstance(x, Pairs):
        return np.full(unsafe.size, float(x))
    unsafe |= ~(x.bound <= _LITTLE * size) | ~np.isfinite(x.high)
    return x.high
