"""The tables of a mode whose friction depends on the sliding speed, from its fields with two constant coefficients."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from lsvib.systems.exact.arithmetic import Row, added, double, doubles, place_of_largest
from lsvib.systems.kernels import law
from lsvib.systems.kernels.law import FROM, PIECE, TO
from lsvib.systems.kernels.layout import TaylorFlow


@dataclasses.dataclass(frozen=True)
class TaylorMode:
    """One mode of a :class:`lsvib.systems.kernels.layout.TaylorFlow`: its tables in doubles.

    ``pieces`` (p, PIECE), none where the mode does not slip. ``settled``: x₀, S and L of the region that no motion
    leaves. Of many systems any table may have one more axis for them, the first.
    """

    field: np.ndarray
    push: np.ndarray
    contact: np.ndarray
    speed: np.ndarray
    feedback: Any = 0.0
    pieces: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, PIECE)))
    settled: tuple[np.ndarray, np.ndarray, Any] | None = None
    condition: float = 1.0

    @property
    def time_scales(self) -> tuple[Any, ...]:
        """Return the shortest time [s] of the motion without friction, over a radian."""
        fastest = np.abs(np.linalg.eigvals(_numbers(self.field[..., :-1]))).max(axis=-1)
        with np.errstate(divide="ignore"):
            return (1 / fastest,)

    @staticmethod
    def together(modes: Sequence["TaylorMode"], rows: Sequence[Sequence[Row]]) -> tuple[TaylorFlow, list[Row]]:
        """Return the flow tables of some modes, of many systems with one more axis; their guards need nothing else."""
        n = modes[0].push.shape[-1]
        none = np.zeros(n), np.zeros((n, n)), -1.0
        pieces, many = [mode.pieces for mode in modes], np.broadcast_shapes(*(mode.pieces.shape[:-2] for mode in modes))
        places, forms, levels = zip(*(mode.settled or none for mode in modes), strict=True)
        flow = TaylorFlow(
            field=_together([mode.field for mode in modes], 2),
            push=_together([mode.push for mode in modes], 1),
            contact=_together([mode.contact for mode in modes], 1),
            speed=_together([mode.speed for mode in modes], 1),
            feedback=_together([mode.feedback for mode in modes], 0),
            piece_start=np.cumsum([0, *(own.shape[-2] for own in pieces)]).astype(np.int64),
            pieces=np.concatenate([np.broadcast_to(own, (*many, *own.shape[-2:])) for own in pieces], axis=-2),
            settled_place=_together(places, 1),
            settled_form=_together(forms, 2),
            settled_level=_together(levels, 0),
        )
        return flow, []


def still_mode(rows: Sequence[Row]) -> TaylorMode:
    """Return a mode without friction from the rows of its field (n, n + 1)."""
    n = len(rows)
    table = doubles([x for row in rows for x in row], (n, n + 1))
    return TaylorMode(table, np.zeros(n), np.zeros(n + 1), np.zeros(n + 1))


@dataclasses.dataclass(frozen=True)
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
        place = place_of_largest([abs(double(x)) for x in contact])
        feedback = added(contact[place] / pressed[place], -1) / probe
        share = probe / (1 + feedback * probe) * contact[place]
        push = tuple(added(row[place], -other[place]) / share for row, other in zip(rubbed, free, strict=True))
        return cls(tuple(free), contact, probe, feedback, push)

    def part(self, without: Row, rubbed: Row) -> tuple[Any, ...]:
        """Return the row that counts η times of a quantity, from its rows without friction and with the probe."""
        share = self.probe / (1 + self.feedback * self.probe)
        return tuple(added(y, -x) / share for x, y in zip(without, rubbed, strict=True))

    def mode(self, speed: Row, pieces: np.ndarray) -> TaylorMode:
        """Return the mode whose sliding speed is the row ``speed`` [m/s], under the ``pieces`` of a law."""
        n = len(self.free)
        return TaylorMode(
            field=doubles([x for row in self.free for x in row], (n, n + 1)),
            push=doubles(self.push, (n,)),
            contact=doubles(self.contact, (n + 1,)),
            speed=doubles(speed, (n + 1,)),
            feedback=double(self.feedback),
            pieces=pieces,
        )


def _together(tables: Sequence[Any], dimensions: int) -> np.ndarray:
    """Put tables of so many dimensions for one system together along a new axis before these."""
    return np.stack(np.broadcast_arrays(*tables), axis=-1 - dimensions)


def settled_region(
    mode: TaylorMode, guards: Sequence[np.ndarray], place: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x₀, S (n, n) and a level L such that a motion with yᵀ S y ≤ L, y = x − x₀, stays near x₀ for ever.

    ``guards`` (n + 1 each) are positive in the mode, and ``place`` (n) is x₀, its equilibrium. With the linear field A
    there, Aᵀ S + S A = −W, and what is left of the field, d (Δη q̃ + q₀ (Δη − η′ σ̃)), is bounded by the first two
    derivatives of η: yᵀ S y falls as long as it is below L. L is zero where x₀ is not stable, so that only x₀ stays.
    Of many systems all may have one more axis for them, the first.
    """
    n, whole = mode.push.shape[-1], np.append(place, np.ones((*place.shape[:-1], 1)), axis=-1)
    sigma = _dot(mode.speed, whole)
    mu, first, piece = coefficient(mode.pieces, sigma)
    (steep, bent), feedback = law.bounds(piece), np.asarray(mode.feedback)
    one = 1 + feedback * mu
    reaches = sigma / 2, abs(one) / np.maximum(2 * abs(feedback) * steep, 1e-300), sigma - piece[FROM]
    reach = np.minimum.reduce(np.broadcast_arrays(*reaches, piece[TO] - sigma))
    slope = first / one**2
    steep, bent = 4 * steep / one**2, 4 * bent / one**2 + 16 * abs(feedback) * steep**2 / abs(one) ** 3
    force, unit = _dot(mode.contact, whole), np.eye(n)
    pressed = (mu / one)[..., None] * mode.contact[..., :-1] + (slope * force)[..., None] * mode.speed[..., :-1]
    matrix = _numbers(mode.field[..., :-1] + mode.push[..., :, None] * pressed[..., None, :])
    values = np.linalg.eigvals(matrix)
    # a damping that is no more than the rounding of the rates is none, and leaves the equation of S without a solution
    stable = (reach > 0) & (values.real.max(axis=-1) < -1e-14 * abs(values).max(axis=-1))
    matrix = np.where(stable[..., None, None], matrix, -unit)
    sizes = np.abs(np.linalg.eig(matrix)[1]).max(axis=-1)  # of the coordinates to each other, but of a chain
    sizes = np.where(sizes.min(axis=-1, keepdims=True) < 1e-12 * sizes.max(axis=-1, keepdims=True), 1.0, sizes)
    weight = unit / sizes[..., None, :] ** 2
    turned = np.swapaxes(matrix, -1, -2)
    flat = np.einsum("ij,...kl->...ikjl", unit, turned) + np.einsum("...ij,kl->...ikjl", turned, unit)
    flat = flat.reshape(*matrix.shape[:-2], n * n, n * n)
    form = np.linalg.solve(flat, -weight.reshape(*matrix.shape[:-2], n * n, 1)).reshape(matrix.shape)
    form = (form + np.swapaxes(form, -1, -2)) / 2
    stable &= np.isfinite(form).all(axis=(-1, -2)) & (np.linalg.eigvalsh(_numbers(form)).min(axis=-1) > 0)
    form = np.where(stable[..., None, None], form, unit)
    inverse = np.linalg.inv(form)

    def length(row: np.ndarray) -> np.ndarray:
        """Return the largest value of a linear function where yᵀ S y = 1."""
        found: np.ndarray = np.sqrt(np.maximum(_dot((row[..., None, :] @ inverse)[..., 0, :], row), 0.0))
        return found

    falls = np.linalg.eigvals(inverse @ weight).real.min(axis=-1)  # yᵀ W y over yᵀ S y
    away = length(mode.speed[..., :-1])
    rest = steep * away * length(mode.contact[..., :-1]) + 0.5 * abs(force) * bent * away**2
    pushed = 2 * np.sqrt(_dot((mode.push[..., None, :] @ form)[..., 0, :], mode.push)) * rest
    levels = [_over(0.5 * falls, pushed), _over(reach, away)]
    levels += [_over(_dot(row, whole), length(row[..., :-1])) for row in guards]
    level = 0.9 * np.maximum(np.minimum.reduce(np.broadcast_arrays(*levels)), 0.0) ** 2
    return place, form, np.where(stable, level, 0.0)


def _dot(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("...i,...i->...", left, right))


def _over(room: np.ndarray, size: np.ndarray) -> np.ndarray:
    """How often something fits into a room; without end if it is nothing."""
    with np.errstate(all="ignore"):
        return np.where(size > 0, room / size, np.inf)


def _numbers(matrix: np.ndarray) -> np.ndarray:
    """Return matrices for LAPACK, the identity in place of one that is not finite, which is refused later."""
    return np.where(np.isfinite(matrix).all(axis=(-1, -2))[..., None, None], matrix, np.eye(matrix.shape[-1]))


def coefficient(pieces: np.ndarray, sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return μ and μ′ of a law by its pieces (..., p, PIECE) at a sliding speed [m/s] (...), and columns there."""
    place = (pieces[..., 1:, FROM] <= sigma[..., None]).sum(axis=-1)
    pieces = np.broadcast_to(pieces, (*place.shape, *pieces.shape[-2:]))
    here = np.moveaxis(np.take_along_axis(pieces, place[..., None, None], axis=-2)[..., 0, :], -1, 0)
    return *law.at(here, sigma, np.exp), here
