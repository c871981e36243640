r"""Drives with two coordinates whose threads stay rigid – axial support, rotating nut – as mechanical systems.

The threads slip with a speed ω in the direction d = sgn ω under the law s = d sgn n, where n is the axial contact
force, or they rest. A second body may slide against the ground with Coulomb friction; then its direction a is part of
the mode, with a = 0 while it is held. A model solves Newton's laws in each mode, and
:mod:`lsvib.models.two_bodies` makes the automaton from these solutions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

from flint import arb

from lsvib.engine.automaton import Row, scaled
from lsvib.engine.exact.arithmetic import ball, sign
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, FIRST_MODEL_KIND, GRAZE_KIND
from lsvib.models.drive import ExactParameters

DIRECTIONS = {1: "forward", -1: "backward"}
HELD = {**DIRECTIONS, 0: "held"}
SIGNS = {1: "positive", -1: "negative"}
SLIPS = tuple((d, q) for d in DIRECTIONS for q in SIGNS)
_CANCELLED = 1e-40  # radius of a sum that holds zero, relative to its terms: fewer digits do not show that it is zero


@dataclass(frozen=True)
class Solution:
    """Newton's laws solved in one mode: affine functions of the state, constant last.

    ``law``: s, 0 at rest; ``field``: rate of the state; ``frozen``: coordinates that keep a value; ``contact``: n [N];
    ``torque``: what the contact (at rest with the bearing) takes from the screw [N m]; ``slip_rate``: ω′;
    ``second_rate`` and ``second_force``: acceleration and friction of the second body.
    """

    law: int
    field: tuple[Row, ...]
    frozen: Mapping[int, arb]
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
    return (0, 0, 0, 0, value)


def plus(*rows: Row) -> tuple:
    """Return the sum of rows; terms that cancel leave exactly zero."""
    return tuple(_settled(sum(column, arb(0)), column) for column in zip(*rows, strict=True))


def _settled(total: arb, terms: Sequence) -> arb:
    """Return a sum, exactly zero if its ball holds zero: tan λ is transcendental, so that its terms cancel for ever."""
    if not total.contains(0) or total.is_zero():
        return total
    if total.rad() > _CANCELLED * max(abs(ball(x)).mid() for x in terms):
        sign(total)  # too few digits are left
    return arb(0)


def solved(matrix: Sequence[Sequence], sides: Sequence[Row]) -> list[tuple]:
    """Solve linear equations whose right-hand sides are rows, by elimination.

    What cancels is exactly zero, so that steady sliding is an equilibrium to the last bit.
    """
    n = len(matrix)
    table = [[ball(x) for x in (*left, *right)] for left, right in zip(matrix, sides, strict=True)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(table[i][k]).mid())
        table[k], table[pivot] = table[pivot], table[k]
        first = table[k][k]
        table[k] = [x / first for x in table[k]]
        for i in range(n):
            if i != k:
                factor = table[i][k]
                pairs = [(x, -factor * y) for x, y in zip(table[i], table[k], strict=True)]
                table[i] = [_settled(x + y, (x, y)) for x, y in pairs]
    return [tuple(row[n:]) for row in table]
