"""Modal forms of one mode of many systems at once, in arrays of extended precision: the tables of a sweep.

They are those of :mod:`lsvib.systems.exact.modal_form` to 1e-12, or they are refused: the condition of a form that does
not hold so many digits is infinite, and that system is made in balls. LAPACK finds the eigenvectors to doubles; two
steps of Newton's method for all of them at once – X ← X (1 + F) with F_ij = (Y A X)_ij / (λ_j − λ_i), Y = X⁻¹ –
double the digits each, up to those of ``np.longdouble``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lsvib.systems.exact.field import APART, SLOW, WORST_CONDITION, amplification
from lsvib.systems.kernels import layout
from lsvib.systems.kernels.layout import ModalFlow

_EPS = np.finfo(np.longdouble).eps
_HELD = 1e-12  # relative error that a rate may have
_NOTHING = 64 * _EPS  # of the terms of a sum: rounding
_ROUND = 1e-3  # β of a pair over |λ|: three digits are lost where its two rates nearly coincide


@dataclass(frozen=True)
class ModalModes:
    """One mode of k systems with n states, in modal form: its ``flow`` with the systems along the first axis (k).

    ``coordinates``: number of modal ones; ``exact``: V and v₀ before they were rounded; ``condition`` (k) is infinite
    where a form does not hold to 1e-12.
    """

    flow: ModalFlow
    condition: np.ndarray
    exact: np.ndarray
    coordinates: int

    @property
    def time_scales(self) -> list[np.ndarray]:
        """Return the shortest time scale [s] of the pairs and of the singles carried about their equilibrium (k)."""
        oscillators, rates = self.flow.oscillators, self.flow.rates
        scales = np.where(oscillators[..., layout.A0] > 0, oscillators[..., layout.TIME_SCALE], np.inf)
        about = np.where((rates != 0.0) & (self.flow.pushes == 0.0), np.abs(rates), 0.0)
        with np.errstate(divide="ignore"):
            return [np.hstack([scales, 1.0 / about]).min(axis=1)]

    @staticmethod
    def together(modes: Sequence["ModalModes"], rows: Sequence[Sequence[Any]]) -> tuple[ModalFlow, list[Any]]:
        """Return the flow tables of some modes, and their guards, by rows, in modal coordinates."""
        flow = ModalFlow(*(np.stack(own, axis=1) for own in zip(*(mode.flow for mode in modes), strict=True)))
        return flow, guard_columns(modes, rows)


def table(rows: Sequence[Sequence[Any]]) -> np.ndarray:
    """Return rows of arrays (k) and numbers in extended precision, shape (k, rows, columns)."""
    flat = [np.asarray(x, dtype=np.longdouble) for row in rows for x in row]
    stacked = np.stack(np.broadcast_arrays(*flat), axis=-1)
    return stacked.reshape(*stacked.shape[:-1], len(rows), -1)


def modal_modes(rows: Sequence[Sequence[Any]], sizes: Sequence[Any], kept: Mapping[int, Any]) -> ModalModes:
    """Return a mode of many systems: rows of A and b (n, n + 1), sizes (n), kept values are arrays (k) or numbers."""
    field = table(rows)
    many, n = field.shape[:2]
    size = np.broadcast_to(np.maximum(table([sizes])[:, 0], np.finfo(float).tiny), (many, n))
    alive = [i for i in range(n) if i not in kept]
    count, scale, push = len(alive), size[:, alive], field[:, alive, n]
    for i, value in kept.items():
        push = push + field[:, alive, i] * np.reshape(value, (-1, 1))
    push, matrix = push / scale, field[:, alive][:, :, alive] * scale[:, None, :] / scale[:, :, None]
    safe = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(push).all(axis=1)
    matrix[~safe] = np.diag(np.arange(1.0, count + 1))
    rates, left, right, held = _eigenvectors(matrix)
    oscillators, singles = np.zeros((many, n // 2, layout.COUNT)), np.zeros((2, many, n))
    into, out = (np.zeros((many, count, count + 1), dtype=np.longdouble) for _ in range(2))  # in sizes of coordinates
    pairs = (rates.imag > 0).sum(axis=1)
    for i in range(count):
        here = np.flatnonzero(rates[:, i].imag > 0)
        if here.size:
            oscillators[here, i], into[here, 2 * i : 2 * i + 2], vectors = _pair(
                rates[here, i], left[here, i], right[here, :, i], push[here]
            )
            out[here, :, 2 * i : 2 * i + 2] = vectors[..., :2]
            out[here, :, count] += vectors[..., 2]
        here = np.flatnonzero(rates[:, i].imag == 0)
        if here.size:
            place = pairs[here] + i
            single, into[here, place], vectors = _single(
                rates[here], i, left[here, i].real, right[here, :, i].real, push[here]
            )
            singles[:, here, place - 2 * pairs[here]] = single
            out[here, :, place] = vectors[..., 0]
            out[here, :, count] += vectors[..., 1]
    to_modal, exact = np.zeros((many, n, n + 1)), np.zeros((many, n, n + 1), dtype=np.longdouble)
    to_modal[:, :count, n] = into[..., count]
    exact[:, alive, n] = out[..., count] * scale
    for j, i in enumerate(alive):
        to_modal[:, :count, i] = into[..., j] / scale[:, j, None]
        exact[:, i, :count] = out[:, j, :count] * scale[:, j, None]
    for i, value in kept.items():
        exact[:, i, n] = value
    condition = amplification(exact.astype(float)[..., :-1], to_modal, size.astype(float))
    condition[~(safe & held & (condition < WORST_CONDITION))] = np.inf
    tables = *singles, to_modal, exact.astype(float), field.astype(float)
    return ModalModes(ModalFlow(pairs, count - 2 * pairs, oscillators, *tables), condition, exact, count)


def _eigenvectors(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return rates (k, n), left rows (k, n, n), right vectors (k, n, n) of matrices (k, n, n), and which hold (k).

    Rates with a positive imaginary part come first, then real ones; those that are zero are so to the last bit. Several
    of zero have any vectors that span their space.
    """
    rates, right = np.linalg.eig(matrix.astype(float))
    rates, right = rates.astype(np.clongdouble), right.astype(np.clongdouble)
    sizes = np.abs(rates)
    small = sizes <= 1e-12 * sizes.max(axis=1, keepdims=True)  # zero, as far as doubles can say
    rates = np.where(small, 0, rates)
    kind = np.select([rates.imag > 0, rates.imag == 0], [0, 1], 2)
    order = np.lexsort((np.where(kind == 1, -rates.real, rates.imag), kind))
    rates, right = np.take_along_axis(rates, order, 1), np.take_along_axis(right, order[:, None, :], 2)
    small = np.take_along_axis(small, order, 1)
    for many in set(small.sum(axis=1).tolist()) - {0, 1}:  # of which LAPACK gives no vectors that are independent
        here = small.sum(axis=1) == many
        own = np.swapaxes(right[here], 1, 2)
        own[small[here]] = np.linalg.svd(matrix[here].astype(float))[2][:, -many:].reshape(-1, matrix.shape[1])
        right[here] = np.swapaxes(own, 1, 2)
    both = small[:, :, None] & small[:, None, :]
    real, unit = rates.imag == 0, np.eye(matrix.shape[1])
    with np.errstate(all="ignore"):
        try:
            left = np.linalg.inv(right.astype(complex)).astype(np.clongdouble)
        except np.linalg.LinAlgError:  # a chain
            left = np.linalg.pinv(right.astype(complex)).astype(np.clongdouble)
        for _ in range(2):
            left = left @ (2 * unit - right @ left)
            turned = left @ matrix @ right
            rates = np.einsum("kii->ki", turned)
            step = np.where(both | (unit == 1), 0, turned / (rates[:, None, :] - rates[:, :, None]))
            right = right + right @ step
            left = left - step @ left
        left = left @ (2 * unit - right @ left)
        sizes = np.abs(rates)
        error = _EPS * np.einsum("kij,kjl,kli->ki", np.abs(left), np.abs(matrix), np.abs(right))
        # Rates of zero are nothing but rounding, and several have no chain.
        left_over = np.abs(left @ matrix @ right) > _NOTHING * sizes.max(axis=1)[:, None, None]
        held = ~(both & left_over).any(axis=(1, 2)) & (small | (error <= _HELD * sizes)).all(axis=1)
        held &= (np.abs(step) < 1e-6).all(axis=(1, 2))  # the square of the last step is what is left to do
        held &= (real | (np.abs(rates.imag) >= _ROUND * sizes)).all(axis=1)
        # Whether a pair is damped at all the trace says, if all other rates are zero; elsewhere that is for balls.
        lone = ((rates.imag > 0).sum(axis=1) == 1) & (small | ~real).all(axis=1)
        rates.real = np.where(lone[:, None] & ~real, np.einsum("kii->k", matrix)[:, None] / 2, rates.real)
        held &= lone | (real | (np.abs(rates.real) > 1e9 * error)).all(axis=1)
        gaps = np.abs(rates[:, :, None] - rates[:, None, :])
        near = gaps <= np.where(real[:, :, None] & real[:, None, :], APART, _ROUND) * sizes[:, :, None]
    held &= ~(near & ~both & (unit == 0)).any(axis=(1, 2))
    rates = np.where(small, 0, np.where(real, rates.real, rates))
    return rates, left, right, held


def _pair(rate: np.ndarray, left: np.ndarray, right: np.ndarray, push: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return oscillator rows (k, columns), rows into its coordinates (k, 2, n + 1), and vectors back (k, n, 3).

    With γ the part of a coordinate in the eigenvector, q = 2 Re(γ y x) is what the pair has in that coordinate; of all
    coordinates the one is taken for which q and q′ are as independent as possible.
    """
    size = np.abs(rate)
    first = 2 * (right[:, :, None] * left[:, None, :]).real
    second = 2 * ((rate / size)[:, None, None] * right[:, :, None] * left[:, None, :]).real
    lengths = (first**2).sum(axis=2)
    with np.errstate(all="ignore"):
        cosine = (first * second).sum(axis=2) ** 2 / (lengths * (second**2).sum(axis=2))
    cosine[~(lengths > 1e-4 * lengths.max(axis=1, keepdims=True))] = np.inf
    best, all_of_them = np.argmin(cosine, axis=1), np.arange(len(rate))
    row, turned = first[all_of_them, best], size[:, None] * second[all_of_them, best]
    back = right / right[all_of_them, best, None]
    alpha, beta = -rate.real[:, None], rate.imag[:, None]
    vectors = np.stack([back.real + alpha / beta * back.imag, back.imag / beta], axis=-1)
    a1, a0 = -2 * rate.real, size**2
    own = (row * push).sum(axis=1)
    rest = (a1 * own + (turned * push).sum(axis=1)) / a0
    into = np.stack([np.c_[row, -rest], np.c_[turned, own]], axis=1)
    shift = vectors[..., 0] * rest[:, None] - vectors[..., 1] * own[:, None]
    table = np.zeros((len(rate), layout.COUNT))
    table[:, layout.A0], table[:, layout.A1], table[:, layout.ALPHA] = a0, a1, -rate.real
    table[:, layout.BETA], table[:, layout.TIME_SCALE] = rate.imag, 1 / size
    return table, into, np.concatenate([vectors, shift[..., None]], axis=-1)


def _single(rates: np.ndarray, i: int, left: np.ndarray, right: np.ndarray, push: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return rate and push (2, k) of the i-th rate, the row into its coordinate (k, n + 1), vectors back (k, n, 2)."""
    rate, all_of_them = rates[:, i].real, np.arange(len(rates))
    best = np.argmax(np.abs(right * left), axis=1)
    factor = right[all_of_them, best, None]
    row, vector = left * factor, right / factor
    own, terms = (row * push).sum(axis=1), np.abs(row * push).sum(axis=1)
    own[np.abs(own) <= _NOTHING * terms] = 0
    # As for one system: the equilibrium of a slow exponential may lie far away, and then it is carried without it.
    sizes = np.abs(rates)
    larger = np.where(sizes > (1 + 1e-12) * np.abs(rate)[:, None], sizes, np.inf).min(axis=1)
    slow = np.isfinite(larger) & (larger > SLOW * np.abs(rate))
    without = (rate == 0) | (slow & (np.abs(own) > np.abs(rate) * np.abs(row).sum(axis=1)))
    with np.errstate(all="ignore"):
        shift = np.where(without, 0, own / rate)
    vectors = np.stack([vector, -vector * shift[:, None]], axis=-1)
    return np.stack([rate, np.where(without, own, 0)]), np.c_[row, shift], vectors


def guard_columns(modes: Sequence[ModalModes], rows: Sequence[Sequence[Sequence[Any]]]) -> list[list[np.ndarray]]:
    """Return the guards of all modes in modal coordinates, from their rows (n + 1) by mode: lists of n + 1 arrays (k).

    An entry that is nothing but rounding is zero; one that is too close to that is not a number.
    """
    found = []
    for mode, guards in zip(modes, rows, strict=True):
        n, count = mode.flow.field.shape[1], mode.coordinates
        for guard in guards:
            weights = table([guard])[:, 0]
            columns = [np.zeros(1)] * (n + 1)
            for j in range(count + 1):
                terms = weights[:, :n] * mode.exact[:, :, j if j < count else n]
                if j == count:
                    terms = np.append(terms, np.broadcast_to(weights[:, n:], (len(terms), 1)), axis=1)
                total, size = terms.sum(axis=1), np.abs(terms).sum(axis=1)
                unsure = np.abs(total) < 1e11 * _EPS * size
                columns[j] = np.where(np.abs(total) <= _NOTHING * size, 0, np.where(unsure, np.nan, total))
            found.append(columns)
    return found
