r"""Drives with two coordinates whose threads stay rigid – axial support, rotating nut – as mechanical systems.

The threads slip with a speed ω in the direction d = sgn ω under the law s = d sgn n, where n is the axial contact
force, or they rest. A second body may slide against the ground with Coulomb friction; then its direction a is part of
the mode, with a = 0 while it is held. A model solves Newton's laws in each mode, and
:mod:`lsvib.models.second_body.modes_and_guards` makes the automaton from these solutions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import IntEnum

from lsvib.engine.automaton import Row, scaled
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, FIRST_MODEL_KIND, GRAZE_KIND
from lsvib.models.drive import ExactParameters

DIRECTIONS = {1: "forward", -1: "backward"}
HELD = {**DIRECTIONS, 0: "held"}
SIGNS = {1: "positive", -1: "negative"}
SLIPS = tuple((d, q) for d in DIRECTIONS for q in SIGNS)
# Two numbers that differ by less than this share of the larger one are equal: what differs is the rounding of their 50
# digits.
_CANCELLED = Decimal("1e-40")


@dataclass(frozen=True)
class Solution:
    """Newton's laws solved in one mode: affine functions of the state, constant last.

    ``law``: s, 0 at rest; ``field``: rate of the state; ``frozen``: coordinates that keep a value; ``contact``: n [N];
    ``torque``: what the contact (at rest with the bearing) takes from the screw [N m]; ``slip_rate``: ω′;
    ``second_rate`` and ``second_force``: acceleration and friction of the second body.
    """

    law: int
    field: tuple[Row, ...]
    frozen: Mapping[int, Decimal]
    contact: Row
    torque: Row
    slip_rate: Row
    second_rate: Row
    second_force: Row


def mode_enum(name: str, rests: Sequence[str], second: str) -> type[IntEnum]:
    """Return the codes of a model's modes: slips and rests, alone and with each direction of the second body."""
    plain = [f"slip_{DIRECTIONS[d]}_{SIGNS[q]}" for d, q in SLIPS] + list(rests)
    names = plain + [f"{mode}_{second}_{how}" for how in HELD.values() for mode in plain]
    return IntEnum(name, {mode.upper(): code for code, mode in enumerate(names)})


def event_enum(name: str, friction: str) -> type[IntEnum]:
    """Return the kinds of a model's events; ``friction``: word for the friction of the second body."""
    kinds = ["CONTACT_REVERSAL", "STICK", "REVERSAL", "RELEASE", "SEIZURE"]
    kinds += [f"{friction}_{kind}".upper() for kind in ("stick", "reversal", "release")]
    own = {kind: FIRST_MODEL_KIND + i for i, kind in enumerate(kinds)}
    return IntEnum(name, {"GRAZE": GRAZE_KIND, "ACCUMULATION": ACCUMULATION_KIND, **own})


def normal_force(drive: ExactParameters, solution: Solution) -> tuple:
    """N: n / (cos λ + s μ sin λ) in slip, n cos λ − T sin λ / r_m at rest, where the threads carry the torque T."""
    if solution.law:
        push = drive.cos_lead + solution.law * drive.friction_coefficient * drive.sin_lead
        return scaled(solution.contact, 1 / push)
    tilted = scaled(solution.torque, -drive.sin_lead / drive.pitch_radius)
    return plus(scaled(solution.contact, drive.cos_lead), tilted)


def constant(value) -> tuple:
    """Return the row of a constant."""
    return (Decimal(0),) * 4 + (Decimal(value),)


def plus(*rows: Row) -> tuple:
    """Return the sum of rows; where terms cancel to within the rounding of their decimals it is exactly zero."""
    return tuple(_sum([Decimal(x) for x in column]) for column in zip(*rows, strict=True))


def _sum(terms: list[Decimal]) -> Decimal:
    total = sum(terms, Decimal(0))
    return Decimal(0) if abs(total) < _CANCELLED * max(map(abs, terms)) else total


def solved(matrix: Sequence[Sequence], sides: Sequence[Row]) -> list[tuple]:
    """Solve linear equations whose right-hand sides are rows, by elimination in decimal arithmetic.

    What cancels to within the rounding of all terms that it was formed from, step after step, is exactly zero: steady
    sliding is an equilibrium to the last bit, however large the forces over a small inertia are.
    """
    n = len(matrix)
    table = [[Decimal(x) for x in (*left, *right)] for left, right in zip(matrix, sides, strict=True)]
    sizes = [[abs(x) for x in row] for row in table]  # of the largest term of each sum
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(table[i][k]))
        table[k], table[pivot] = table[pivot], table[k]
        sizes[k], sizes[pivot] = sizes[pivot], sizes[k]
        first = table[k][k]
        table[k], sizes[k] = [x / first for x in table[k]], [x / abs(first) for x in sizes[k]]
        for i in range(n):
            if i != k:
                factor = table[i][k]
                sizes[i] = [max(x, abs(factor) * y) for x, y in zip(sizes[i], sizes[k], strict=True)]
                sums = [x - factor * y for x, y in zip(table[i], table[k], strict=True)]
                table[i] = [
                    Decimal(0) if abs(x) < _CANCELLED * size else x for x, size in zip(sums, sizes[i], strict=True)
                ]
    return [tuple(row[n:]) for row in table]
