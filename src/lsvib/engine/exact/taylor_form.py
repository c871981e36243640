"""The tables of a mode whose friction depends on the sliding speed, from its fields with two constant coefficients."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lsvib.engine.exact.arithmetic import ball, doubles
from lsvib.engine.kernels.layout import CONSTANT, EXPONENT, FADE, FROM, LINEAR, PIECE, RISE, TO, TaylorFlow

Row = Sequence[Any]


@dataclass(frozen=True)
class TaylorMode:
    """One mode of a :class:`lsvib.engine.kernels.layout.TaylorFlow`: its tables in doubles.

    ``pieces`` (p, PIECE), none where the mode does not slip. ``settled``: x₀, S and L of the region that no motion
    leaves.
    """

    field: np.ndarray
    push: np.ndarray
    contact: np.ndarray
    speed: np.ndarray
    feedback: float = 0.0
    pieces: np.ndarray = field(default_factory=lambda: np.zeros((0, PIECE)))
    settled: tuple[np.ndarray, np.ndarray, float] | None = None
    condition: float = 1.0

    @property
    def time_scales(self) -> tuple[float, ...]:
        """Return the shortest time [s] of the motion without friction, over a radian."""
        fastest = np.abs(np.linalg.eigvals(self.field[:, :-1])).max()
        return (1 / float(fastest) if fastest > 0 else math.inf,)


def still_mode(rows: Sequence[Row]) -> TaylorMode:
    """Return a mode without friction from the rows of its field (n, n + 1)."""
    n = len(rows)
    table = doubles([x for row in rows for x in row], (n, n + 1))
    return TaylorMode(table, np.zeros(n), np.zeros(n + 1), np.zeros(n + 1))


@dataclass(frozen=True)
class Split:
    """What friction does in a mode, by two constant coefficients, in balls: x′ = P + η d q with η = μ / (1 + B μ).

    ``free`` are the rows of P, ``contact`` is q, the contact force without friction; ``probe`` [1] is the other
    coefficient and ``share`` its η. An affine quantity is its own without friction and η times its ``part``.
    """

    free: tuple[Row, ...]
    contact: Row
    probe: Any
    feedback: Any
    push: tuple[Any, ...]

    @classmethod
    def of(cls, free: Sequence[Row], contact: Row, rubbed: Sequence[Row], pressed: Row, probe: Any) -> "Split":
        """Split the fields and contact forces without friction (``free``, ``contact``) and with the coefficient μ."""
        place = max(range(len(contact)), key=lambda j: abs(float(contact[j])))
        feedback = (ball(contact[place]) / pressed[place] - 1) / probe
        share = probe / (1 + feedback * probe)
        push = tuple(
            (ball(row[place]) - ball(other[place])) / (share * contact[place])
            for row, other in zip(rubbed, free, strict=True)
        )
        return cls(tuple(free), contact, probe, feedback, push)

    def part(self, without: Row, rubbed: Row) -> tuple[Any, ...]:
        """Return the row that counts η times of a quantity, from its rows without friction and with the probe."""
        share = self.probe / (1 + self.feedback * self.probe)
        return tuple((ball(y) - ball(x)) / share for x, y in zip(without, rubbed, strict=True))

    def mode(self, speed: Row, pieces: np.ndarray) -> TaylorMode:
        """Return the mode whose sliding speed is the row ``speed`` [m/s], under the ``pieces`` of a law."""
        n = len(self.free)
        return TaylorMode(
            field=doubles([x for row in self.free for x in row], (n, n + 1)),
            push=doubles(self.push, (n,)),
            contact=doubles(self.contact, (n + 1,)),
            speed=doubles(speed, (n + 1,)),
            feedback=float(self.feedback),
            pieces=pieces,
        )


def taylor_flow(modes: Sequence[TaylorMode]) -> TaylorFlow:
    """Return the flow tables of some modes."""
    n = len(modes[0].push)
    settled = [mode.settled or (np.zeros(n), np.zeros((n, n)), -1.0) for mode in modes]
    alike = ("field", "push", "contact", "speed", "feedback")
    return TaylorFlow(
        **{name: np.array([getattr(mode, name) for mode in modes]) for name in alike},
        piece_start=np.cumsum([0, *(len(mode.pieces) for mode in modes)]).astype(np.int64),
        pieces=np.concatenate([mode.pieces for mode in modes]),
        settled_place=np.array([place for place, _, _ in settled]),
        settled_form=np.array([form for _, form, _ in settled]),
        settled_level=np.array([level for _, _, level in settled]),
    )


def settled_region(
    mode: TaylorMode, guards: Sequence[np.ndarray], place: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return x₀, S (n, n) and a level L such that a motion with yᵀ S y ≤ L, y = x − x₀, stays near x₀ for ever.

    ``guards`` (n + 1 each) are positive in the mode, and ``place`` (n) is x₀, its equilibrium. With the linear field A
    there, Aᵀ S + S A = −W, and what is left of the field, d (Δη q̃ + q₀ (Δη − η′ σ̃)), is bounded by the first two
    derivatives of η: yᵀ S y falls as long as it is below L. L is zero where x₀ is not stable, so that only x₀ stays.
    """
    n, whole = len(mode.push), np.append(place, 1.0)
    sigma = float(mode.speed @ whole)
    piece = mode.pieces[np.searchsorted(mode.pieces[1:, FROM], sigma, side="right")]
    mu, first = _law(piece, sigma)
    # bounds of both derivatives on the piece
    steep, bent = abs(piece[LINEAR]) + piece[RISE] * piece[FADE], 2 * piece[RISE] * piece[FADE] ** 2
    one = 1 + mode.feedback * mu
    reach = min(sigma / 2, abs(one) / max(2 * abs(mode.feedback) * steep, 1e-300), sigma - piece[FROM])
    reach = min(reach, piece[TO] - sigma)
    slope = first / one**2
    steep, bent = 4 * steep / one**2, 4 * bent / one**2 + 16 * abs(mode.feedback) * steep**2 / abs(one) ** 3
    force = float(mode.contact @ whole)
    matrix = mode.field[:, :-1] + np.outer(mode.push, mu / one * mode.contact[:-1] + slope * force * mode.speed[:-1])
    if np.linalg.eigvals(matrix).real.max() >= 0 or reach <= 0:
        return place, np.eye(n), 0.0
    sizes = np.abs(np.linalg.eig(matrix)[1]).max(axis=1)  # of the coordinates to each other
    weight = np.diag(1 / sizes**2)
    unit = np.eye(n)
    flat = np.kron(unit, matrix.T) + np.kron(matrix.T, unit)
    form = np.linalg.solve(flat, -weight.ravel()).reshape(n, n)
    form = (form + form.T) / 2
    if np.linalg.eigvalsh(form).min() <= 0:
        return place, np.eye(n), 0.0
    inverse = np.linalg.inv(form)

    def length(row: np.ndarray) -> float:
        """Return the largest value of a linear function where yᵀ S y = 1."""
        return math.sqrt(max(row @ inverse @ row, 0.0))

    falls = np.linalg.eigvals(inverse @ weight).real.min()  # yᵀ W y over yᵀ S y
    away = length(mode.speed[:-1])
    rest = steep * away * length(mode.contact[:-1]) + 0.5 * abs(force) * bent * away**2
    pushed = 2 * math.sqrt(mode.push @ form @ mode.push) * rest
    levels = [0.5 * falls / pushed if pushed > 0 else math.inf, reach / away if away > 0 else math.inf]
    levels += [row @ whole / length(row[:-1]) for row in guards if length(row[:-1]) > 0]
    return place, form, 0.9 * max(min(levels), 0.0) ** 2


def eta(flow: TaylorFlow, states: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Return η [1] at states (k, n) in modes (k); zero in a mode that does not slip."""
    found = np.zeros(len(states))
    for k, (state, mode) in enumerate(zip(states, modes, strict=True)):
        pieces = flow.pieces[flow.piece_start[mode] : flow.piece_start[mode + 1]]
        if len(pieces):
            sigma = float(flow.speed[mode, :-1] @ state + flow.speed[mode, -1])
            piece = pieces[np.searchsorted(pieces[1:, FROM], sigma, side="right")]
            mu, _ = _law(piece, sigma)
            found[k] = mu / (1 + flow.feedback[mode] * mu)
    return found


def _law(piece: np.ndarray, sigma: float) -> tuple[float, float]:
    """Return μ of a piece of a law and its derivative at a sliding speed [m/s]."""
    value, slope = piece[CONSTANT] + piece[LINEAR] * sigma, piece[LINEAR]
    if piece[RISE]:
        fade, ratio = piece[FADE], piece[FADE] * sigma
        squared = piece[EXPONENT] == 2
        decay = piece[RISE] * math.exp(-(ratio**2 if squared else ratio))
        value, slope = value + decay, slope - decay * fade * (2 * ratio if squared else 1)
    return value, slope
