"""Constants of the drives with four states for :mod:`judge.second_opinions.strides`, from Newton's laws of the
references.

Each mode of a drive has its field x′ = A x + b, its conditions as affine functions of the state, the derivatives of
these along the field, and a ladder of propagators exp(2^j h A): from far below the fastest time to the longest motion.
The references form A, b and conditions with 40 digits; from there on numbers are pairs of doubles.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf

from judge.second_opinions import double_doubles
from judge.second_opinions.jit import allocating_kernel
from lsvib.bench.reference import threads_digits
from lsvib.bench.reference.exponential_sums import affine
from lsvib.bench.reference.two_bodies_digits import ClosedFormDrive
from lsvib.bench.sweeps.taylor import DIGITS

ABSENT, FORCE = -2, -1  # kinds of conditions; 0, 1: a speed (of slip, of the second body)
ORDERS = 5  # of derivatives of a condition, from 0
_ROWS = 5  # of conditions, at most
_FIRST = 2e-5  # shortest step, of the fastest time; five terms of a series then are exact
_TERMS = 9  # of the series of the shortest step; five would do


class Ladders(NamedTuple):
    """Modes (m) of a drive. A pair of doubles is the last axis of length 2."""

    direction: np.ndarray  # (m,) of slip, 0: rest
    contact: np.ndarray  # (m,) sign of the contact force
    second: np.ndarray  # (m,) direction of the second body, 0: held, or no friction knows it
    has_second: bool
    ties: np.ndarray  # (m,) bits of the speeds that are zero in the mode
    kinds: np.ndarray  # (m, _ROWS) of the conditions
    rows: np.ndarray  # (m, _ROWS, ORDERS, 5, 2) positive in the mode, and derivatives
    sizes: np.ndarray  # (m, _ROWS, ORDERS, 5) what the rows are summed from, by magnitude
    fields: np.ndarray  # (m, 4, 5, 2)
    shortest: np.ndarray  # (m,) [s] first rung, a power of two
    tables: np.ndarray  # (m, rungs, 4, 5, 2) exp(2^j h A) − 1
    speeds: np.ndarray  # (2, 5, 2) as functions of the state; the second 0 where no friction knows it
    ties_of: np.ndarray  # (4, 4, 5, 2) the state with the speeds of some bits put on zero
    impulse: np.ndarray  # (4,) change of state by a seizure, for a slip of 1; its force has the slip's sign
    paradox: bool


class _Solving(ClosedFormDrive):
    """The reference's drive; equations with the same left side are eliminated once."""

    def __init__(self, *arguments) -> None:
        super().__init__(*arguments)
        self.inverses: dict[tuple, list] = {}

    def solve(self, rows, sides):
        """Solve rows · x = sides for x, by the inverse of the rows, which is kept."""
        key = tuple(map(tuple, rows))
        if key not in self.inverses:
            self.inverses[key] = _inverse(rows)
        used = [(j, side) for j, side in enumerate(sides) if side]
        return [sum((row[j] * side for j, side in used), mpf(0)) for row in self.inverses[key]]


def _inverse(rows):
    n = len(rows)
    # The equations have units of their own: each is divided by its largest term, so that pivots can be compared.
    tops = [max(map(abs, row)) for row in rows]
    work = [
        [r / top for r in row] + [mpf(i == j) / top for j in range(n)]
        for i, (row, top) in enumerate(zip(rows, tops, strict=True))
    ]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(work[i][k]))
        work[k], work[pivot] = work[pivot], work[k]
        head = work[k][k]
        work[k] = [x / head for x in work[k]]
        for i in range(n):
            factor = work[i][k]
            if i != k and factor:
                work[i] = [x - factor * y if y else x for x, y in zip(work[i], work[k], strict=True)]
    return [row[n:] for row in work]


def ladders(model: str, parameters: dict[str, float], frictions: Sequence[str], longest: float) -> Ladders:
    """Form the constants of a drive [SI units] with some ``frictions`` for motions up to ``longest`` [s]."""
    with mp.workdps(DIGITS + threads_digits.SPARE_DIGITS):
        two = model != "threads"
        found = _two_bodies(_Solving(model, parameters, frictions)) if two else _threads(parameters)
    count = len(found["direction"])
    fields = found["fields"]
    fastest = [np.abs(np.linalg.eigvals(field[:, :4, 0])).max() for field in fields]
    shortest = np.array([2.0 ** math.floor(math.log2(_FIRST / max(rate, 1 / longest))) for rate in fastest])
    rungs = math.ceil(math.log2(longest / shortest.min())) + 1
    sizes = np.zeros((count, _ROWS, ORDERS, 5))
    tables = np.empty((count, rungs, 4, 5, 2))
    _fill(fields, found["kinds"], found["rows"], sizes, shortest, longest, tables)
    return Ladders(**found, sizes=sizes, shortest=shortest, tables=tables)


@allocating_kernel
def _fill(fields, kinds, rows, sizes, shortest, longest, tables):
    """Derivatives of the conditions, magnitudes of their terms, and the propagators."""
    for m in range(len(fields)):
        for r in range(kinds.shape[1]):
            if kinds[m, r] == ABSENT:
                continue
            sizes[m, r, 0] = np.abs(rows[m, r, 0, :, 0])
            for k in range(1, ORDERS):
                double_doubles.composed(rows[m, r, k - 1], fields[m], rows[m, r, k])
                for j in range(5):
                    for i in range(4):
                        sizes[m, r, k, j] += sizes[m, r, k - 1, i] * abs(fields[m, i, j, 0])
        double_doubles.exponential(fields[m], shortest[m], _TERMS, tables[m, 0])
        for j in range(1, tables.shape[1]):
            if shortest[m] * 2.0 ** (j - 1) > longest:
                break
            double_doubles.doubled(tables[m, j - 1], tables[m, j])


def _pairs(rows) -> np.ndarray:
    """Rows of numbers of many digits as an array of pairs."""
    return np.array([[double_doubles.pair(x) for x in row] for row in rows])


def _packed(modes, ties, fields, conditions, **others) -> dict:
    count = len(modes)
    kinds, rows = np.full((count, _ROWS), ABSENT), np.zeros((count, _ROWS, ORDERS, 5, 2))
    for m, found in enumerate(conditions):
        for r, (row, kind) in enumerate(found):
            kinds[m, r], rows[m, r, 0] = kind, _pairs([row])[0]
    return {
        "direction": np.array([mode[0] for mode in modes]),
        "contact": np.array([mode[1] for mode in modes]),
        "second": np.array([(mode[2] or 0) if len(mode) > 2 else 0 for mode in modes]),
        "has_second": len(modes[0]) > 2 and modes[0][2] is not None,
        "ties": np.array([sum(1 << k for k in tied) for tied in ties]),
        "kinds": kinds,
        "rows": rows,
        "fields": np.array([_pairs(field) for field in fields]),
        **others,
    }


def _threads(parameters) -> dict:
    drive = threads_digits.ThreadsTrueDrive(parameters)
    modes = [(d, q) for d in (1, -1, 0) for q in (1, -1)]
    fields = [affine((lambda x, s=d * q: drive.slip(s, x)) if d else drive.rest) for d, q in modes]
    conditions = [  # at rest N may turn as well, but there both limits of friction are reached before
        [([side * g for g in row], k - 1 if d else FORCE) for k, (row, side) in enumerate(drive.guards((d, q)))]
        for d, q in modes
    ]
    unit = affine(lambda x: x)
    still = [unit[0], [mpf(0)] * 4 + [-drive.Omega], unit[2], unit[3]]
    speed = [mpf(0), mpf(1), mpf(0), mpf(0), drive.Omega]
    return _packed(
        modes,
        [() if d else (0,) for d, _ in modes],
        fields,
        conditions,
        speeds=_pairs([speed, [mpf(0)] * 4 + [mpf(1)]]),
        ties_of=np.array([_pairs(still if bits & 1 else unit) for bits in range(4)]),
        impulse=np.zeros(4),
        paradox=False,
    )


def _two_bodies(drive: _Solving) -> dict:
    modes = drive.modes()
    conditions = [
        [(list(row), FORCE if kind is None else kind) for row, kind in drive.conditions(mode)] for mode in modes
    ]
    second = drive.row(lambda x: drive.speeds(x)[1]) if drive.second else [mpf(0)] * 4 + [mpf(1)]
    ties_of = []
    for bits in range(4):
        zero = {k for k in (0, 1) if bits >> k & 1}
        ties_of.append(_pairs(affine(lambda x, zero=zero: drive.tie(np.array(x, dtype=object), zero))))
    impulse = np.zeros(4)
    if drive.painleve:
        before = np.array([mpf(0), 1 - drive.Omega, mpf(0), mpf(0)], dtype=object)
        slip = drive.speeds(before)[0]
        impulse = ((drive.impact(before)[0] - before) / slip).astype(float)
    return _packed(
        modes,
        [[k for k, there in ((0, d == 0), (1, a == 0)) if there] for d, _, a in modes],
        [drive.row_of_field(mode) for mode in modes],
        conditions,
        speeds=np.array([_pairs([row])[0] for row in (drive.row(lambda x: drive.speeds(x)[0]), second)]),
        ties_of=np.array(ties_of),
        impulse=impulse,
        paradox=bool(drive.painleve),
    )
