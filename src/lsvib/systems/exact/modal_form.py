"""From a linear field x′ = A x + b to the modal tables of :mod:`lsvib.systems.kernels.flow_modal`, in many digits.

The characteristic polynomial is split into factors: s² + a₁ s + a₀ for two complex rates or the two closest real ones,
s − r for a single real rate, s for zero. With P the product of the other factors, Π = m(A) P(A) projects on the
subspace of a factor, where m is the inverse of P modulo the factor (:mod:`lsvib.systems.exact.field`). None of this is
sensitive where the two rates of a factor coincide. On the subspace, q = ℓΠx with a row ℓ obeys the scalar equation of
the factor, so (q, q′) is an oscillator, or q alone is an exponential. Rates of zero without a chain share a factor, and
each of them gets such a row.

A mode that would lose more than six digits in states of the typical sizes of the coordinates is refused: its rates
coincide, or lie too far apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Any, ClassVar, NamedTuple

import numpy as np
from flint import arb, arb_mat

from lsvib.errors import EngineError
from lsvib.systems.exact.arithmetic import Number, Row, added, alike, doubles, many_digits, real_rates, root, sign
from lsvib.systems.exact.field import WORST_CONDITION, Field, Subspace, amplification, subspaces
from lsvib.systems.exact.modal_arrays import ModalModes, modal_modes
from lsvib.systems.kernels import layout
from lsvib.systems.kernels.layout import ModalFlow

_NOTHING = 1e-40  # of the terms of a sum: the rounding of coefficients


@dataclass(frozen=True)
class ModalMode:
    """One mode in modal form, with p pairs, s singles and q = 2p + s coordinates.

    Oscillator rows (p), rates and pushes (s), W and w₀ (q, n + 1), V and v₀ (n, q + 1), A and b (n, n + 1), see
    :class:`lsvib.systems.kernels.layout.ModalFlow`. ``condition`` is the largest amplification of rounding,
    max_i Σ_j |V_ij| (|W| x)_j / x_i, for states of the sizes x. ``exact``: V and v₀ before they were rounded.
    """

    oscillators: np.ndarray
    rates: np.ndarray
    pushes: np.ndarray
    to_modal: np.ndarray
    from_modal: np.ndarray
    field: np.ndarray
    condition: float
    exact: list[list[arb]]

    @property
    def time_scales(self) -> list[float]:
        """Time scales [s] of the pairs, and of the singles that are carried about their equilibrium."""
        about = self.rates[(self.rates != 0.0) & (self.pushes == 0.0)]
        return [*self.oscillators[:, layout.TIME_SCALE], *(1.0 / np.abs(about))]

    @staticmethod
    def together(modes: Sequence["ModalMode"], rows: Sequence[Sequence[Row]]) -> tuple[ModalFlow, Sequence[Row]]:
        """Return the flow tables of some modes, and their guards, by rows, in modal coordinates where these tell."""
        return modal_flow(modes), guard_forms(modes, rows) or []


@dataclass(frozen=True)
class PlanarMode:
    """One mode with two states, an oscillator: its row of the flow table, in doubles.

    ``exact``: equilibrium and rates r₁ > r₂ in balls, or None where it has no equilibrium or no two real rates.
    """

    row: np.ndarray
    exact: tuple[Number, Number, Number] | None = None
    condition: ClassVar[float] = 1.0

    @property
    def time_scales(self) -> list[Any]:
        """Its time scale [s], of many systems an array."""
        return [self.row[..., layout.TIME_SCALE]]

    @classmethod
    @many_digits()
    def of(cls, inertia: Number, damping: Number, stiffness: Number, force: Number) -> "PlanarMode":
        """Return  inertia·u″ + damping·u′ + stiffness·u = force  (any consistent units, inertia ≠ 0).

        The characteristic roots are formed in balls, free of cancellation.
        """
        inertia, damping, stiffness, force = alike(inertia, damping, stiffness, force)
        square = stiffness / inertia
        row: list[Any] = [0.0] * layout.COUNT
        row[layout.A0], row[layout.A1], row[layout.B] = square, damping / inertia, force / inertia
        row[layout.ALPHA] = alpha = damping / inertia / 2
        # rates that no digit tells apart are one
        discriminant = added(damping * damping, -4 * inertia * stiffness) / (4 * inertia * inertia)
        if (real := sign(discriminant, "a damping")) < 0:
            row[layout.BETA] = root(-discriminant)
        else:
            row[layout.DELTA] = root(discriminant)
            row[layout.R1], row[layout.R2] = real_rates(alpha, square, row[layout.DELTA])
        if sign(stiffness):
            row[layout.EQUILIBRIUM] = force / stiffness
            row[layout.TIME_SCALE] = 1 / root(abs(square))
        exact = (row[layout.EQUILIBRIUM], row[layout.R1], row[layout.R2]) if real > 0 and sign(stiffness) else None
        return cls(doubles(row, (layout.COUNT,)), exact)

    @staticmethod
    def together(modes: Sequence["PlanarMode"], rows: Sequence[Sequence[Row]]) -> tuple[np.ndarray, Sequence[Row]]:
        """Return the flow table of some modes, of one system or many, and the parts of their guards, by rows."""
        parts = [mode._guard_parts(row) for mode, own in zip(modes, rows, strict=True) for row in own]
        return np.stack(np.broadcast_arrays(*(mode.row for mode in modes)), axis=-2), parts

    def _guard_parts(self, row: Row) -> Row:
        """Return a guard at the equilibrium, and along either eigenvector (1, r): differences that may cancel."""
        if self.exact is None:
            return 0, 0, 0
        (place, rate, constant), (equilibrium, slow, fast) = row, self.exact
        pairs = (place * equilibrium, constant), (place, rate * slow), (place, rate * fast)
        return tuple(added(*pair, least=1e14) for pair in pairs)  # of terms that have lost digits themselves


def modal_mode(field: Field) -> ModalMode:
    """Decompose a field.

    Raises ``ArithmeticError`` if rates coincide with a chain, other than two real ones, or if rates of different
    factors lie so close together that double precision cannot carry the modal form (condition above 1e6).
    """
    with many_digits():
        push, pairs, singles, alive = field.push(), [], [], field.alive
        rows = tuple(tuple(arb(field.rows[i][j]).mid().man_exp() for j in alive) for i in alive)
        for space, frame in _spaces(rows, tuple(field.scale())):
            if frame is not None:
                pairs.append(_pair(push, space.factor, frame))
            else:
                singles += _singles(push, space, field.scale())
        mode = _tables(field, pairs, singles)
    if not mode.condition < WORST_CONDITION:
        raise ArithmeticError(f"condition {mode.condition:.1e}")
    return mode


class _Frame(NamedTuple):
    """A row ℓΠ of the subspace of a pair, the row ℓΠA, and the vectors (n, 2) that give states back from both."""

    row: arb_mat
    turned: arb_mat
    vectors: arb_mat


@lru_cache(maxsize=8)  # of a model, whose modes have six matrices at most
def _spaces(rows: tuple[Any, ...], scale: tuple[float, ...]) -> list[tuple[Subspace, _Frame | None]]:
    """Return the subspaces of a matrix, by its rows of midpoints (mantissa, exponent), with the frames of pairs.

    Most modes of a model differ from another one by their constants only, so the answers are kept.
    """
    matrix = arb_mat([[arb(x) for x in row] for row in rows])
    found = subspaces(matrix, list(scale))
    if sum(space.rank for space in found) != len(rows) or not all(space.rank > 0 for space in found):
        raise ArithmeticError("no digit is left of a subspace")
    return [(space, _frame(matrix, space, scale) if len(space.factor) == 3 else None) for space in found]


class _Piece(NamedTuple):
    """A pair or a single: its row of the oscillator table, or (rate, push); rows into and out of its coordinates."""

    row: np.ndarray
    into: list[list[arb]]  # (1 or 2, n + 1)
    out: list[list[arb]]  # (n, 2 or 3), the constant last


def _singles(push: list[arb], space: Subspace, scale: list[float]) -> list[_Piece]:
    """Return the exponentials of the subspace of one rate, as many as the subspace has dimensions."""
    projector, rate, n = space.projector, -space.factor[1], len(push)

    def minor(rows: tuple[int, ...]) -> float:
        scaled = arb_mat([[projector[i, j] * scale[j] / scale[i] for j in rows] for i in rows])
        return abs(float(scaled.det()))

    chosen = max(combinations(range(n), space.rank), key=minor)
    block = arb_mat([[projector[i, j] for j in chosen] for i in chosen]).inv()
    singles = []
    for k, i in enumerate(chosen):
        # Coordinates q = Π x at the chosen rows; the vectors that give them back are dual to these rows.
        vector = [sum((projector[a, j] * block[m, k] for m, j in enumerate(chosen)), arb(0)) for a in range(n)]
        row = [projector[i, j] for j in range(n)]
        own, terms = _dot(row, push), sum(abs(float(x * y)) for x, y in zip(row, push, strict=True))
        own = own if abs(float(own)) > _NOTHING * terms else arb(0)
        # The equilibrium of a slow exponential may lie far away, and then it is carried without it. Near by it is not:
        # what dies away would leave the rounding of its start behind.
        size = sum(abs(float(x)) * s for x, s in zip(row, scale, strict=True))
        without = not float(rate) or (space.slow and abs(float(own)) > abs(float(rate)) * size)
        shift, left = (arb(0), own) if without else (own / rate, arb(0))
        singles.append(_Piece(_floats([rate, left]), [[*row, shift]], [[x, -x * shift] for x in vector]))
    return singles


def _frame(matrix: arb_mat, space: Subspace, scale: Sequence[float]) -> _Frame:
    n = len(scale)
    weights = arb_mat([[arb(scale[i]) ** 2 * int(i == j) for j in range(n)] for i in range(n)])
    row = _row_of_pair(matrix, space, scale)
    turned = row * matrix
    rows = arb_mat([row.entries(), turned.entries()])
    return _Frame(row, turned, space.projector * weights * rows.transpose() * (rows * weights * rows.transpose()).inv())


def _pair(push: list[arb], factor: list[arb], frame: _Frame) -> _Piece:
    _, a1, a0 = factor
    row, turned, vectors = frame.row.entries(), frame.turned.entries(), frame.vectors
    own = _dot(row, push)
    rest = (a1 * own + _dot(turned, push)) / a0  # equilibrium of q
    out = [[vectors[i, 0], vectors[i, 1], vectors[i, 0] * rest - vectors[i, 1] * own] for i in range(len(push))]
    return _Piece(PlanarMode.of(1, a1, a0, 0).row, [[*row, -rest], [*turned, own]], out)


def _row_of_pair(matrix: arb_mat, space: Subspace, scale: Sequence[float]) -> arb_mat:
    """Return a row ℓΠ of the subspace of a pair that is as independent of ℓΠA as possible."""
    n, unit = len(scale), space.factor[2].sqrt()
    single = [[arb(int(i == j)) / scale[j] for j in range(n)] for i in range(n)]
    candidates = single + [[x + y for x, y in zip(*two, strict=True)] for two in combinations(single, 2)]
    rows = [arb_mat([candidate]) * space.projector for candidate in candidates]
    first = [[(x * s).mid() for x, s in zip(row.entries(), scale, strict=True)] for row in rows]
    lengths = [float(_dot(one, one).sqrt()) for one in first]

    def cosine(k: int) -> float:
        """Return the square of the cosine of the angle between ℓΠ and ℓΠA."""
        second = [(x * s / unit).mid() for x, s in zip((rows[k] * matrix).entries(), scale, strict=True)]
        return float(_dot(first[k], second) ** 2 / (_dot(first[k], first[k]) * _dot(second, second)))

    # Rows that are nearly orthogonal to the subspace consist of rounding.
    return rows[min((k for k in range(len(rows)) if lengths[k] > max(lengths) / 100), key=cosine)]


def _dot(left: Sequence[arb], right: Sequence[arb]) -> arb:
    return sum((x * y for x, y in zip(left, right, strict=True)), arb(0))


def _floats(numbers: Row) -> np.ndarray:
    return np.array([float(x) for x in numbers])


def _tables(field: Field, pairs: list[_Piece], singles: list[_Piece]) -> ModalMode:
    n, count, alive = len(field.rows), 2 * len(pairs) + len(singles), field.alive
    to_modal, exact = np.zeros((count, n + 1)), [[arb(0)] * (count + 1) for _ in range(n)]
    for i, value in field.kept.items():
        exact[i][count] = arb(value)
    first = 0
    for piece in [*pairs, *singles]:
        for k, row in enumerate(piece.into):
            to_modal[first + k, [*alive, n]] = _floats(row)
            for j, i in enumerate(alive):
                exact[i][first + k] = piece.out[j][k]
        for j, i in enumerate(alive):
            exact[i][count] += piece.out[j][-1]
        first += len(piece.into)
    from_modal = np.array([_floats(row) for row in exact])
    condition = float(amplification(from_modal[:, :-1], to_modal, field.sizes))
    rates, pushes = np.array([single.row for single in singles]).reshape(-1, 2).T.copy()
    oscillators = np.array([pair.row for pair in pairs]).reshape(-1, layout.COUNT)
    rows = np.array([_floats(row) for row in field.rows])
    return ModalMode(oscillators, rates, pushes, to_modal, from_modal, rows, condition, exact)


def linear_mode(
    rows: Sequence[Row], sizes: Sequence[float], frozen: Mapping[int, arb | float] | None, movable: str
) -> ModalMode | ModalModes:
    """Return a mode of a model.

    Arguments: rows of A and b (n, n + 1), balls or floats; typical sizes of the coordinates (n); ``frozen``,
    coordinates that keep a value in this mode, with that value; ``movable``, the parameter to change where two rates
    coincide.
    Raises ``EngineError`` for a mode whose rates double precision cannot distinguish.
    """
    if any(isinstance(x, np.ndarray) for row in rows for x in row):
        return modal_modes(rows, sizes, frozen or {})
    field = Field.of(rows, sizes, frozen)
    try:
        return modal_mode(field)
    except ArithmeticError as error:
        raise EngineError(
            f"two rates of one mode of motion cannot be distinguished in double precision ({error}); change {movable}."
        ) from None


def guard_forms(modes: Sequence[ModalMode], rows: Sequence[Sequence[Row]]) -> list[list[float]] | None:
    """Return the guards of all modes in modal coordinates (g, q + 1), from their rows (n + 1) of balls by mode.

    An entry that the doubles of the tables give to 1e-12 is the one that they give. None if all are so. An entry that
    is nothing but the rounding of the coefficients is zero: a speed that dies away would seem to stop there.
    """
    width, found, lost = max(len(mode.to_modal) for mode in modes) + 1, [], False
    with many_digits():
        for mode, guards in zip(modes, rows, strict=True):
            count = len(mode.to_modal)
            for guard in guards:
                *exact, constant = map(arb, guard)
                plain, form = _floats(exact), [0.0] * width
                for j in range(count + 1):
                    own = constant if j == count else 0
                    terms = [*(x * row[j] for x, row in zip(exact, mode.exact, strict=True)), own]
                    rounded = float(plain @ mode.from_modal[:, j]) + float(own)
                    true, size = float(sum(terms, arb(0))), sum(abs(float(x)) for x in terms)
                    true = true if abs(true) > _NOTHING * size else 0.0
                    unsure = abs(true - rounded) > 1e-12 * abs(true)
                    form[j], lost = true if unsure else rounded, lost or unsure
                found.append(form)
    return found if lost else None


def modal_flow(modes: Sequence[ModalMode]) -> ModalFlow:
    """Put modes together in one table; modes with fewer pairs or singles leave the rest zero."""
    filled, constants = ("oscillators", "rates", "pushes", "to_modal"), [mode.from_modal[:, -1:] for mode in modes]
    return ModalFlow(
        pairs=np.array([len(mode.oscillators) for mode in modes]),
        singles=np.array([mode.rates.size for mode in modes]),
        **{name: _filled([getattr(mode, name) for mode in modes]) for name in filled},
        from_modal=np.concatenate([_filled([mode.from_modal[:, :-1] for mode in modes]), constants], axis=2),
        field=np.array([mode.field for mode in modes]),
    )


def _filled(tables: Sequence[np.ndarray]) -> np.ndarray:
    """Return tables in one, the smaller ones filled up with zeros."""
    found = np.zeros((len(tables), *np.max([table.shape for table in tables], axis=0)))
    for own, table in zip(found, tables, strict=True):
        own[tuple(map(slice, table.shape))] = table
    return found
