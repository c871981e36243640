"""The modal form of one mode of many drives at once, in pairs of doubles with bounds of their errors.

It is :mod:`lsvib.engine.exact.modal_form` again, with arrays of :class:`lsvib.engine.exact.pair_arrays.Pairs` in place
of 60 digits, where all rates are simple: an entry whose tables are safe has those of 60 digits to the last bit. Rates
come from doubles by Newton's method and are enclosed: a disc of radius n |p / p′| around any number holds a root of a
polynomial p of degree n, and it holds just one if it is far from all others. Everything else – rates that nearly
coincide, choices that 32 digits do not decide, a condition that is too large – is unsafe.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np

from lsvib.engine.exact.factors import APART, SLOW, inverse_modulo, modulo, multiplied
from lsvib.engine.exact.field import WORST_CONDITION, amplification
from lsvib.engine.exact.modal_form import ModalMode
from lsvib.engine.exact.pair_arrays import Pairs, double
from lsvib.engine.kernels import columns

_NEWTONS = 5  # steps; each doubles the digits of a rate, of which LAPACK leaves three at least
_SEPARATE = 1e-10  # relative distance of two rates from which on they count as simple: half of their digits are left
_ZERO_RATE = 1e-20  # a rate that is smaller, relative to the largest one, may be rounding of zero
_CLEAR = 1e-9  # relative distance of two doubles, of rounding 1e-15 and some digits, whose order is certain
_LENGTH = 0.01  # part of the longest row of a subspace from which on a row is no rounding
_LITTLE = 2.0**-51  # bound of the error of an entry, relative to its row: two units in the last place
_EQUAL_ANGLES = 1e-11  # cosines that differ by less may be equal but for the rounding of doubles

Matrix = list[list[Any]]


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
        rates = _rates(field.matrix, unsafe)
        patterns = _patterns(rates)
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
        n, rows = len(rows), [[_plain(x) for x in row] for row in rows]
        alive = [i for i in range(n) if i not in frozen]
        push = [_sum([rows[i][n], *(_times(rows[i][j], x) for j, x in frozen.items())]) for i in alive]
        columns_of_sizes = [np.broadcast_to(np.asarray(x, dtype=float), unsafe.shape) for x in sizes]
        return cls(
            alive, [[rows[i][j] for j in alive] for i in alive], push, columns_of_sizes, dict(frozen),
            rows,
        )  # fmt: skip

    def at(self, members: np.ndarray, unsafe: np.ndarray) -> "_Field":
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


class _Rates(NamedTuple):
    """Rates that are not zero: real and imaginary parts of up to n, and how many zeros there are by structure.

    ``parts[j]`` are two ``Pairs`` (k); the imaginary part is exactly zero where the rate is real.
    """

    parts: list[tuple[Pairs, Pairs]]
    zeros: int

    def at(self, members: np.ndarray, unsafe: np.ndarray) -> "_Rates":
        return _Rates([(x.at(members, unsafe), y.at(members, unsafe)) for x, y in self.parts], self.zeros)

    def doubles(self) -> np.ndarray:
        """Return the rates (k, n) as complex doubles."""
        return np.stack([x.high + 1j * y.high for x, y in self.parts], axis=1)


def _rates(matrix: Matrix, unsafe: np.ndarray) -> _Rates:
    """Return the rates of A, the upper of two complex ones before the lower, as LAPACK has them; marks what is unsafe.

    A row of zeros is a rate of zero; no other rate may be zero.
    """
    n = len(matrix)
    moving = [i for i in range(n) if not all(map(_is_zero, matrix[i]))]
    inner = [[matrix[i][j] for j in moving] for i in moving]
    table = np.stack([np.stack([_high(x, unsafe.size) for x in row], axis=-1) for row in inner], axis=-2)
    unsafe |= ~np.isfinite(table).all(axis=(1, 2))
    table[unsafe] = np.eye(len(moving))
    start = np.linalg.eigvals(table).astype(complex)
    coefficients = _characteristic(inner, unsafe)
    parts = [_enclosed(coefficients, start[:, j], unsafe) for j in range(len(moving))]
    rates = _Rates(parts, n - len(moving))
    values = rates.doubles()
    size = np.abs(values)
    unsafe |= ~(size > _ZERO_RATE * size.max(axis=1, keepdims=True)).all(axis=1)
    for i, j in combinations(range(len(moving)), 2):
        distance = np.abs(values[:, i] - values[:, j])
        radius = parts[i][0].bound + parts[j][0].bound
        unsafe |= ~((distance > _SEPARATE * (size[:, i] + size[:, j])) & (distance > 4.0 * radius))
    return rates


def _characteristic(matrix: Matrix, unsafe: np.ndarray) -> list[Any]:
    """Coefficients of det(s − A), from the highest power, by principal minors."""
    n = len(matrix)

    @cache
    def minor(rows: tuple[int, ...], cols: tuple[int, ...]) -> Any:
        if not rows:
            return 1
        terms = []
        for place, column in enumerate(cols):
            x = matrix[rows[0]][column]
            if _is_zero(x):
                continue
            rest = _times(x, minor(rows[1:], (*cols[:place], *cols[place + 1 :])))
            terms.append(-rest if place % 2 else rest)
        return _sum(terms)

    found: list[Any] = [1]
    for order in range(1, n + 1):
        total = _sum([minor(chosen, chosen) for chosen in combinations(range(n), order)])
        found.append(-total if order % 2 else total)
    return [x if isinstance(x, Pairs) else Pairs.exactly(np.full(unsafe.size, float(x)), unsafe) for x in found]


def _enclosed(coefficients: list[Pairs], start: np.ndarray, unsafe: np.ndarray) -> tuple[Pairs, Pairs]:
    """Improve a root (k) of a polynomial, real where its imaginary part is zero, and enclose it."""
    size = len(coefficients) - 1
    derivative = [(size - j) * x.high for j, x in enumerate(coefficients[:-1])]
    x, y = Pairs.exactly(start.real.copy(), unsafe), Pairs.exactly(start.imag.copy(), unsafe)
    real = start.imag == 0.0
    for _ in range(_NEWTONS):
        up, across = _at(coefficients, x, y)
        z = x.high + 1j * y.high
        slope = np.zeros_like(z)
        for one in derivative:
            slope = slope * z + one
        step = (up.high + 1j * across.high) / slope
        x, y = _moved(x, step.real, unsafe), _moved(y, np.where(real, 0.0, step.imag), unsafe)
    up, across = _at(coefficients, x, y)
    steep, turned = _at([x * (size - j) for j, x in enumerate(coefficients[:-1])], x, y)
    value = np.abs(up.high) + up.bound + np.abs(across.high) + across.bound
    slope = np.maximum(np.abs(steep.high), np.abs(turned.high)) - (steep.bound + turned.bound)
    radius = np.where(slope > 0, 1.001 * size * value / slope, np.inf)  # 1.001 pays for the rounding of doubles
    return Pairs(x.high, x.low, radius, unsafe), Pairs(y.high, y.low, np.where(real, 0.0, radius), unsafe)


def _moved(x: Pairs, step: np.ndarray, unsafe: np.ndarray) -> Pairs:
    """Return x − step as numbers that are what they are."""
    there = x - Pairs.exactly(step, unsafe)
    return Pairs(there.high, there.low, np.zeros_like(there.high), unsafe)


def _at(coefficients: list[Pairs], x: Pairs, y: Pairs) -> tuple[Pairs, Pairs]:
    """Real and imaginary part of a polynomial at x + i y."""
    real, imaginary = coefficients[0], coefficients[0] * 0
    for one in coefficients[1:]:
        real, imaginary = real * x - imaginary * y + one, real * y + imaginary * x
    return real, imaginary


class _Pattern(NamedTuple):
    """Which rates make which factors, by their places among the rates: upper ones of complex pairs, pairs of real ones,
    single ones; and which of the single ones are slow."""

    upper: tuple[int, ...]
    together: tuple[tuple[int, int], ...]
    alone: tuple[int, ...]
    slow: tuple[bool, ...]


def _patterns(rates: _Rates) -> list[_Pattern | None]:
    """Return how the rates of each drive (k) are taken together; None where it is unsafe."""
    unsafe, values = rates.parts[0][0].unsafe, rates.doubles()
    return [None if bad else _pattern(row) for bad, row in zip(unsafe.tolist(), values.tolist(), strict=True)]


def _pattern(rates: list[complex]) -> _Pattern | None:
    upper = tuple(j for j, rate in enumerate(rates) if rate.imag > 0)
    real = sorted((j for j, rate in enumerate(rates) if rate.imag == 0), key=lambda j: -rates[j].real)
    if 2 * len(upper) + len(real) != len(rates):
        return None
    together, sizes = [], [abs(rate) for rate in rates]
    while len(real) > 1:
        gaps = [(rates[a].real - rates[b].real) / max(sizes[a], sizes[b]) for a, b in pairwise(real)]
        k = gaps.index(min(gaps))
        if any(i != k and abs(gap - gaps[k]) <= _CLEAR for i, gap in enumerate(gaps)) or abs(gaps[k] - APART) < _CLEAR:
            return None
        if gaps[k] > APART:
            break
        a, b = real.pop(k), real.pop(k)
        together.append((a, b))
    slow = []
    for j in real:
        if any(i != j and abs(size - sizes[j]) <= _CLEAR * size for i, size in enumerate(sizes)):
            return None
        least = min((size for size in sizes if size > sizes[j]), default=0.0)
        if abs(least - SLOW * sizes[j]) <= _CLEAR * least:
            return None
        slow.append(least > SLOW * sizes[j])
    return _Pattern(upper, tuple(together), tuple(real), tuple(slow))


class _Piece(NamedTuple):
    """A pair or a single: its row of the oscillator table, or (rate, push); rows into and out of its coordinates."""

    row: list[Any]
    into: Matrix  # (1 or 2, n + 1)
    out: Matrix  # (n, 2 or 3), the constant last


def _decomposed(field: _Field, rates: _Rates, pattern: _Pattern, unsafe: np.ndarray) -> "_Tables":
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
    square = _product(field.matrix, field.matrix)
    pairs, singles = [], []
    for k, factor in enumerate(factors):
        projector = _projector(field.matrix, square, factors, k)
        if len(factor) == 2:
            alone = k - len(pattern.upper) - len(pattern.together)
            slow = alone >= len(pattern.slow) or pattern.slow[alone]
            singles.append(_single(field, factor, projector, slow, unsafe))
            continue
        if k < len(pattern.upper):
            x, y = rates.parts[pattern.upper[k]]
            row = {columns.BETA: y, columns.ALPHA: -x}
        else:
            (x, _), (y, _) = (rates.parts[j] for j in pattern.together[k - len(pattern.upper)])
            row = {columns.DELTA: (x - y) / 2, columns.ALPHA: -(x + y) / 2, columns.R1: x, columns.R2: y}
        row |= {columns.A0: factor[2], columns.A1: factor[1], columns.TIME_SCALE: 1 / abs(factor[2]).sqrt()}
        pairs.append(_pair(field, factor, projector, [row.get(i, 0) for i in range(columns.COUNT)], unsafe))
    return _Tables.of(field, pairs, singles, unsafe)


def _projector(matrix: Matrix, square: Matrix, factors: list, k: int) -> Matrix:
    others, remainder = None, [1]
    for j, other in enumerate(factors):
        if j != k:
            part = _polynomial(other, matrix, square)
            others = part if others is None else _product(others, part)
            remainder = modulo(multiplied(remainder, other), factors[k])
    return _product(_polynomial(inverse_modulo(remainder, factors[k]), matrix, square), others)


def _single(field: _Field, factor: list, projector: Matrix, slow: bool, unsafe: np.ndarray) -> _Piece:
    """Return the exponential of one rate."""
    n = len(projector)
    diagonal = np.stack([np.abs(_high(projector[i][i], unsafe.size)) for i in range(n)], axis=1)
    chosen = np.argmax(diagonal, axis=1)
    _must_differ(diagonal, chosen, _CLEAR, unsafe)
    covector = [_picked([projector[i][j] for i in range(n)], chosen, unsafe) for j in range(n)]
    block = 1 / _picked([projector[i][i] for i in range(n)], chosen, unsafe)
    vector = [_times(_picked(projector[a], chosen, unsafe), block) for a in range(n)]
    push = _dot(covector, field.push)
    rate = -factor[1]
    shift = 0 if slow or _is_zero(rate) else push / rate
    left = push if slow or _is_zero(rate) else 0
    return _Piece([rate, left], [[*covector, shift]], [[x, -_times(x, shift)] for x in vector])


def _pair(field: _Field, factor: list, projector: Matrix, row: list, unsafe: np.ndarray) -> _Piece:
    """Return the oscillator of a factor of degree two."""
    _, a1, a0 = factor
    n, scale = len(projector), [field.sizes[i] for i in field.alive]
    weights = [Pairs.exactly(s, unsafe) for s in scale]
    turned = _product(projector, field.matrix)
    first = [[_over(x, weights[i]) for x in projector[i]] for i in range(n)]
    second = [[_over(x, weights[i]) for x in turned[i]] for i in range(n)]
    both = [*((i, None) for i in range(n)), *combinations(range(n), 2)]
    chosen = _best_row(first, second, both, scale, np.sqrt(np.abs(_high(a0, unsafe.size))), unsafe)
    rows = []
    for table in (first, second):
        candidates = [
            table[i] if j is None else [_sum([x, y]) for x, y in zip(table[i], table[j], strict=True)] for i, j in both
        ]
        rows.append([_picked([one[m] for one in candidates], chosen, unsafe) for m in range(n)])
    heavy = [[_times(_times(x, w), w) for x, w in zip(one, weights, strict=True)] for one in rows]
    gram = [[_dot(one, other) for other in heavy] for one in rows]
    norm = gram[0][0] * gram[1][1] - gram[0][1] * gram[1][0]
    inverse = [[gram[1][1] / norm, -gram[0][1] / norm], [-gram[1][0] / norm, gram[0][0] / norm]]
    spread = [[_dot(projector[i], one) for one in heavy] for i in range(n)]
    vectors = [[_dot(spread[i], [inverse[0][m], inverse[1][m]]) for m in (0, 1)] for i in range(n)]
    push = _dot(rows[0], field.push)
    rest = (a1 * push + _dot(rows[1], field.push)) / a0  # equilibrium of q
    out = [[*v, _sum([_times(v[0], rest), -_times(v[1], push)])] for v in vectors]
    return _Piece(row, [[*rows[0], -rest], [*rows[1], push]], out)


def _best_row(first: Matrix, second: Matrix, both: list, scale: list, unit: np.ndarray, unsafe: np.ndarray):
    """Choose among rows ℓΠ the one that is as independent of ℓAΠ as possible, as for one drive; indices (k)."""

    def scaled(table: Matrix, factor: Any) -> np.ndarray:
        one = [
            np.stack([_high(x, unsafe.size) * s * factor for x, s in zip(row, scale, strict=True)], axis=-1)
            for row in table
        ]
        return np.stack([one[i] if j is None else one[i] + one[j] for i, j in both], axis=1)  # (k, candidates, n)

    here, there = scaled(first, 1.0), scaled(second, 1.0 / unit)
    length, other = np.sqrt((here * here).sum(axis=2)), np.sqrt((there * there).sum(axis=2))
    longest = length.max(axis=1, keepdims=True)
    unsafe |= (np.abs(length - _LENGTH * longest) <= _CLEAR * longest).any(axis=1)
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
    def of(cls, field: _Field, pairs: list[_Piece], singles: list[_Piece], unsafe: np.ndarray) -> "_Tables":
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
                offset[i] = _sum([offset[i], piece.out[j][-1]])
        to_modal = _rounded(into, sizes, unsafe)
        reach = np.einsum("kij,kj->ki", np.abs(to_modal), sizes)
        columns_of_out = [[*row, x] for row, x in zip(out, offset, strict=True)]
        from_modal = _rounded(columns_of_out, np.concatenate([reach, np.ones((size, 1))], axis=1), unsafe)
        oscillators, rates = np.zeros((size, len(pairs), columns.COUNT)), np.zeros((2, size, len(singles)))
        for j, piece in enumerate(pairs):
            for i, x in enumerate(piece.row):
                oscillators[:, j, i] = _nearly(x, np.abs(_high(x, size)), unsafe)
        for j, piece in enumerate(singles):
            rate, push = piece.row
            rates[0, :, j] = _nearly(rate, np.abs(_high(rate, size)), unsafe)
            turnover = np.abs(_high(push, size)) + np.abs(rates[0, :, j]) * reach[:, 2 * len(pairs) + j]
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
    found = np.stack([np.stack([_high(x, unsafe.size) for x in row], axis=-1) for row in rows], axis=1)
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


def _high(x: Any, size: int) -> np.ndarray:
    return x.high.copy() if isinstance(x, Pairs) else np.full(size, float(x))


def _is_zero(x: Any) -> bool:
    """Whether a number is zero for every drive, by the structure of the model."""
    return not isinstance(x, Pairs) and not x


def _plain(x: Any) -> Any:
    """A number as it is, or an integer zero if it is exactly zero for every drive."""
    if isinstance(x, Pairs):
        return x if x.high.any() or x.bound.any() else 0
    return x or 0


def _times(x: Any, y: Any) -> Any:
    return 0 if _is_zero(x) or _is_zero(y) else x * y


def _over(x: Any, y: Any) -> Any:
    return 0 if _is_zero(x) else x / y


def _sum(terms: Sequence[Any]) -> Any:
    total: Any = 0
    for one in terms:
        if not _is_zero(one):
            total = one if _is_zero(total) else total + one
    return total


def _dot(left: Sequence[Any], right: Sequence[Any]) -> Any:
    return _sum([_times(x, y) for x, y in zip(left, right, strict=True)])


def _product(left: Matrix, right: Matrix) -> Matrix:
    return [[_dot(row, column) for column in zip(*right, strict=True)] for row in left]


def _polynomial(coefficients: Sequence[Any], matrix: Matrix, square: Matrix) -> Matrix:
    """A polynomial of degree two at most, from the highest power, of a matrix."""
    *high, last = coefficients
    powers = [square, matrix][2 - len(high) :]
    n = len(matrix)
    return [
        [
            _sum([*(_times(a, power[i][j]) for a, power in zip(high, powers, strict=True)), last if i == j else 0])
            for j in range(n)
        ]
        for i in range(n)
    ]


def _picked(candidates: Sequence[Any], chosen: np.ndarray, unsafe: np.ndarray) -> Any:
    """For each drive one of several numbers, by its place (k)."""
    if all(map(_is_zero, candidates)):
        return 0
    found = [np.zeros(unsafe.size) for _ in range(3)]
    for place, one in enumerate(candidates):
        here = chosen == place
        if not here.any():
            continue
        parts = (one.high, one.low, one.bound) if isinstance(one, Pairs) else (float(one), 0.0, 0.0)
        for mine, theirs in zip(found, parts, strict=True):
            mine[here] = theirs[here] if isinstance(theirs, np.ndarray) else theirs
    return Pairs(*found, unsafe)
