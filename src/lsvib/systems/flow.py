"""The flow of the modes of an automaton, as it is asked from Python: linear, or in series under a friction law.

Kernels see its ``tables`` only, and choose by their type. What needs kernels imports them in the function, so that
tables are made without numba. Tables of many systems have one more axis, the first.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from lsvib.systems.exact.taylor_form import coefficient
from lsvib.systems.kernels import layout
from lsvib.systems.kernels.layout import ModalFlow, TaylorFlow


class Linear:
    """x′ = A x + b in each mode: pairs of modal coordinates, each an oscillator, and single exponentials.

    Two states are one oscillator, whose coordinates are its modal ones: the fast lane of kernels, where ``tables`` is
    an array of such rows. ``form`` are modal tables in either case, and ``field`` is A and b (m, n, n + 1).
    """

    by_speed = False

    def __init__(self, tables: Any) -> None:
        self.tables, self.planar = tables, isinstance(tables, np.ndarray)
        self.form: ModalFlow = _as_modal(tables) if self.planar else tables
        self.field, self.numbers = self.form.field, [tables] if self.planar else [*tables]  # the latter are all finite

    def each(self, change: Callable[[np.ndarray, int], Any]) -> Any:
        """Return tables made from these, one by one, by a function of a table and its dimensions for one system."""
        if self.planar:
            return change(self.tables, layout.DIMENSIONS["flow"])
        return ModalFlow(*map(change, self.tables, layout.MODAL_DIMENSIONS))

    def conserves(self, modes: np.ndarray) -> Any:
        """Whether some modes preserve areas or volumes, because nothing damps; of many systems for each (k)."""
        return ~np.trace(self.field[..., modes, :, :-1], axis1=-2, axis2=-1).any(axis=-1)

    def equilibrium(self, mode: int) -> np.ndarray:
        """Return where A x + b = 0 (n) in a mode; steady sliding where it lies on a surface (mode −1).

        If doubles do not tell the rows of A apart, that is the solution with no share of what they leave open:
        deviations from steady sliding, which is zero.
        """
        if mode < 0:
            return np.zeros(self.field.shape[1])
        matrix, constant = self.field[mode][:, :-1], self.field[mode][:, -1]
        try:
            return np.linalg.solve(matrix, -constant) + 0.0  # no zero has a sign
        except np.linalg.LinAlgError:
            return np.asarray(np.linalg.lstsq(matrix, -constant)[0])

    def share(self, states: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Return η of :class:`Series` [1], which no linear flow has, at states (k, n) in modes (k)."""
        return np.zeros(len(states))

    def integral(self, mode: int, state: np.ndarray, time: float, forms: Any) -> np.ndarray:
        r"""Return ∫ (x, 1)ᵀ Q (x, 1) dt (k) over a time [s] from a state (n), of forms Q (k, n + 1, n + 1).

        With Y the flow e^{Mt} of the modal coordinates and a one,

            ∫₀ᵀ Yᵀ Q Y dt = W(T),      W(2h) = W(h) + Y(h)ᵀ W(h) Y(h),

        starts from a step so short that Gauss' rule with eight nodes is exact to rounding, and doubles: nothing is
        sampled, and neither equal rates nor rates decades apart are special.
        """
        if time == 0.0:
            return np.zeros(len(forms))
        form, rows, rates = self.form, *self._rates(mode)
        n, q = state.size, 2 * len(rows) + rates.size
        unit = np.eye(max(n, q) + 1)
        out = np.concatenate([form.from_modal[mode][:, :q], form.from_modal[mode][:, -1:]], axis=1)
        into, out = np.vstack([form.to_modal[mode, :q], unit[n, : n + 1]]), np.vstack([out, unit[q, : q + 1]])
        inner = out.T @ np.asarray(forms) @ out
        pairs = np.hypot(rows[:, layout.ALPHA], rows[:, layout.BETA]) + rows[:, layout.DELTA]
        fastest = float(np.max(np.concatenate([np.abs(pairs), np.abs(rates)]), initial=0.0))
        # phase of the first step at the fastest rate: the rule is then wrong by less than 1e-20
        doublings = max(0, math.ceil(math.log2(max(fastest * time / 0.5, 1e-300))))
        step = time * 0.5**doublings
        total = np.zeros_like(inner)
        for node, weight in zip(*np.polynomial.legendre.leggauss(8), strict=True):  # exact up to the 15th power of time
            moved = self._propagator(mode, 0.5 * step * (1.0 + node))
            total += 0.5 * step * weight * (moved.T @ inner @ moved)
        for k in range(doublings):
            moved = self._propagator(mode, step * 2.0**k)
            total = total + moved.T @ total @ moved
        start = into @ np.append(state, 1.0)
        return np.asarray(np.einsum("i,kij,j->k", start, total, start))

    def _rates(self, mode: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows of the oscillators of a mode, and the rates of its exponentials."""
        form = self.form
        return form.oscillators[mode, : form.pairs[mode]], form.rates[mode, : form.singles[mode]]

    def _propagator(self, mode: int, time: float) -> np.ndarray:
        """Return the affine flow of a mode over a time [s] in its modal coordinates with a one, (q + 1, q + 1)."""
        from lsvib.systems.kernels import flow_planar

        rows, rates = self._rates(mode)
        found = np.eye(2 * len(rows) + rates.size + 1)
        for k, row in enumerate(rows):
            here, (c, s, s_rate) = slice(2 * k, 2 * k + 2), flow_planar.responses(row, time)
            found[here, here] = [[c, s], [-row[layout.A0] * s, s_rate]]
            if b := row[layout.B]:  # else a rest may be so long that t² is beyond all numbers
                found[here, -1] = b * flow_planar.integrated_response(row, time), b * s
        for k, (rate, push) in enumerate(zip(rates.tolist(), self.form.pushes[mode], strict=False), 2 * len(rows)):
            more = math.expm1(min(rate * time, flow_planar.OVERFLOW))
            found[k, k], found[k, -1] = 1.0 + more, push * (more / rate if rate else time)
        return found


def _as_modal(rows: np.ndarray) -> ModalFlow:
    """Return a table of oscillators, one a mode, as modal tables."""
    modes = rows.shape[:-1]
    field, unit = np.zeros((*modes, 2, 3)), np.broadcast_to(np.eye(2, 3), (*modes, 2, 3))
    field[..., 0, 1] = 1.0
    field[..., 1, :] = rows[..., [layout.A0, layout.A1, layout.B]] * [-1.0, -1.0, 1.0]
    none, one = np.zeros((*modes, 0)), np.ones(modes, dtype=np.int64)
    return ModalFlow(one, 0 * one, rows[..., None, :], none, none, unit, unit, field)


class Series:
    """x′ = P(x) + η d q(x) in each mode, as :class:`lsvib.systems.kernels.layout.TaylorFlow` says; ``field`` is P."""

    by_speed = True

    def __init__(self, tables: TaylorFlow) -> None:
        self.tables, self.field = tables, tables.field
        self.numbers = [*tables._replace(pieces=tables.push)]  # are all finite; the last piece of a law has no end

    def each(self, change: Callable[[np.ndarray, int], Any]) -> Any:
        """Return tables made from these, as :meth:`Linear.each` does."""
        return TaylorFlow(*map(change, self.tables, layout.TAYLOR_DIMENSIONS))

    def conserves(self, modes: np.ndarray) -> Any:
        """Whether nothing damps, of many systems for each (k): friction that depends on speed does, or excites."""
        return np.zeros(self.field.shape[:-3], dtype=bool)

    def equilibrium(self, mode: int) -> np.ndarray:
        """Return the equilibrium (n) that motions stay near for ever."""
        return np.array(self.tables.settled_place[np.argmax(self.tables.settled_level)])

    def share(self, states: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Return η [1] at states (k, n) in modes (k); zero in a mode that does not slip."""
        flow, found = self.tables, np.zeros(len(states))
        for mode in np.unique(modes):
            pieces, here = flow.pieces[flow.piece_start[mode] : flow.piece_start[mode + 1]], modes == mode
            if len(pieces):
                mu, _, _ = coefficient(pieces, states[here] @ flow.speed[mode, :-1] + flow.speed[mode, -1])
                found[here] = mu / (1 + flow.feedback[mode] * mu)
        return found

    def integral(self, mode: int, state: np.ndarray, time: float, forms: Any) -> np.ndarray:
        """Return the integrals of :meth:`Linear.integral` by Gauss' rule on each step of the series, to rounding.

        In place of a form there may be two (2, n + 1, n + 1), the second of which counts η times.
        """
        from lsvib.systems.kernels import flow_taylor

        if time == 0.0:
            return np.zeros(len(forms))
        room, flow = 64, self.tables
        places, weights = np.polynomial.legendre.leggauss(12)
        while True:
            states, steps = np.empty((room * 12, state.size)), np.empty(room)
            count = flow_taylor.nodes(flow, mode, state, time, 0.5 * (1.0 + places), states, steps)
            if count <= room:
                break
            room = count
        states, weights = states[: count * 12], (0.5 * steps[:count, None] * weights).ravel()
        whole = np.column_stack([states, np.ones(len(states))])
        shares = np.stack([np.ones(len(states)), self.share(states, np.full(len(states), mode))])
        pairs = np.array([form if form.ndim == 3 else [form, 0 * form] for form in forms])
        values = np.einsum("ji,kpil,jl->kpj", whole, pairs, whole)
        return np.asarray(np.einsum("kpj,pj,j->k", values, shares, weights))


Flow = Linear | Series
