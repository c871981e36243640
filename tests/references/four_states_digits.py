"""Reference with 40 digits for the drives with four states: closed forms, certified search.

Newton's laws, modes, their conditions, the rule that tries modes out and the impact are those of
``four_states_laws.py``; the closed form of the motion and the search for roots are those of ``exponential_sums.py``.
Speeds that a mode ties are eliminated from its field, so that the rates left over are the modal ones and one zero for
each tie. A mode follows if each of its conditions holds; a condition that is zero holds if its first derivative along
the mode's own flow that is not zero is positive.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from mpmath import mp, mpf

from references.exponential_sums import UNIT, Function, TrueArc, affine, first_root, summed
from references.four_states_laws import FourStatesLaws

SPARE_DIGITS = 30  # extra working digits beyond the dps asked for

_BEHIND = 30  # Digits behind a condition, of its terms, that an event, or the start, has put on zero.
_CORNER = mpf(10) ** -20  # of its terms: N that the next seizures take to zero, each of which squares it


@dataclass
class FourStatesEvent:
    """An event: its time, the modes around it, the state after it, and whether it was a seizure."""

    time: mpf
    mode_before: tuple
    mode_after: tuple
    state: tuple
    seizure: bool

    @property
    def kind(self):
        """What happens to the slip or to the contact; ``other`` where only a second friction changes."""
        before, after = self.mode_before, self.mode_after
        if self.seizure:
            return "seizure"
        if before[0] == after[0]:
            return "other" if before[1] == after[1] else "contact_reversal"
        return "release" if before[0] == 0 else "reversal" if after[0] else "stick"


@dataclass
class FourStatesTruth:
    """A motion with all of its digits: its end, its events and its arcs."""

    time: mpf
    state: tuple
    mode: tuple
    events: list
    arcs: list  # (mode, state at the start, duration)
    complete: bool  # False: stopped at max_events
    drive: object

    def sampled(self, parts):
        """States at these parts of every arc."""
        found = []
        for mode, state, stay in self.arcs:
            arc = self.drive.mode(mode).arc(state)
            found += [arc.state(stay * part) for part in parts if stay]
        return found


def mode_name(mode, model):
    """The library's name of a mode (d, q, a)."""
    slip, contact, second = mode
    ways = {1: "forward", -1: "backward", 0: "held"}
    words = ["slip", ways[slip]] if slip else ["rest"]
    words += ["positive" if contact > 0 else "negative"] if contact else []
    words += [] if second is None else ["nut" if model == "support" else "screw", ways[second]]
    return "_".join(words)


class FourStatesMode:
    """Field, closed form and conditions of a mode (d, q, a) of a drive."""

    def __init__(self, drive, mode):
        self.drive, self.mode = drive, mode
        d, _, a = mode
        self.ties = ({0} if d == 0 else set()) | ({1} if a == 0 else set())
        rows = drive.row_of_field(mode)
        self.A, self.b = [row[:4] for row in rows], [row[4] for row in rows]
        found = drive.conditions(mode)
        self.rows, self.kinds = [list(row) for row, _ in found], [kind for _, kind in found]

    @cached_property
    def tied(self):
        """Rows over (u, w, ., ., 1) of the speeds that the mode ties, by index."""
        rows = affine(lambda x: self.drive.tie(np.array(x, dtype=object), self.ties))
        return {i: row for i, row in enumerate(rows) if row != [*UNIT[i], 0]}

    @cached_property
    def spectrum(self):
        """Rates and eigenvectors of what is left, their inverse, and the constant; the tied rates are zero."""
        alive = [i for i in range(4) if i not in self.tied]
        reduced, constant = mp.zeros(len(alive)), mp.zeros(len(alive), 1)
        for m, i in enumerate(alive):
            constant[m] = self.b[i] + sum(self.A[i][t] * row[4] for t, row in self.tied.items())
            for n, j in enumerate(alive):
                reduced[m, n] = self.A[i][j] + sum(self.A[i][t] * row[j] for t, row in self.tied.items())
        rates, vectors = mp.eig(reduced)
        order = sorted(range(len(alive)), key=lambda k: abs(rates[k]))
        zero = set(order[: len(self.tied)])
        rates = [mpf(0) if k in zero else rate for k, rate in enumerate(rates)]
        return alive, rates, vectors, _inverse(vectors), constant

    def arc(self, x):
        """Closed form of the motion from the state x on."""
        alive, rates, vectors, inverse, constant = self.spectrum
        c0, c1 = [[] for _ in range(4)], [[] for _ in range(4)]  # the terms that they are summed from
        kept, columns = [], []
        for k, rate in enumerate(rates):
            vector = [mpf(0)] * 4
            for m, i in enumerate(alive):
                vector[i] = vectors[m, k]
            weights = [inverse[k, m] * x[i] for m, i in enumerate(alive)]
            push = summed(*(inverse[k, m] * constant[m] for m in range(len(alive))))
            for i, v in enumerate(vector):
                if rate == 0:
                    c0[i].append(mp.re(summed(*weights) * v))
                    c1[i].append(mp.re(push * v))
                else:
                    c0[i].append(-mp.re(push / rate * v))
            real = abs(mp.im(rate)) < mpf(10) ** -(mp.dps // 2) * abs(rate)
            if rate != 0 and (real or mp.im(rate) > 0):  # a conjugate pair is twice the real part of one of the two
                column = [(1 if real else 2) * summed(*weights, push / rate) * v for v in vector]
                kept.append(mp.re(rate) if real else rate)
                columns.append([mp.re(c) for c in column] if real else column)
        c0, c1 = [summed(*terms) for terms in c0], [summed(*terms) for terms in c1]
        for t, row in self.tied.items():
            c0[t], c1[t] = _at(row, c0), _at([*row[:4], mpf(0)], c1)
            for column in columns:
                column[t] = _at([*row[:4], mpf(0)], column)
        if not kept:  # nothing swings; a rate of no weight sets the scale of time
            stiffness, inertia = self.drive.p["coupling_stiffness"], self.drive.p["screw_inertia"]
            kept, columns = [-mp.sqrt(stiffness / inertia)], [[mpf(0)] * 4]
        return TrueArc(kept, columns, c0, c1)

    def lasts(self, x, zero):
        """Whether the mode's own flow keeps all its conditions; the speeds in ``zero`` are zero exactly."""
        if not self.ties <= zero:
            return False
        return all(self._sign(row, x, kind, zero) > 0 for row, kind in zip(self.rows, self.kinds, strict=True))

    def _sign(self, row, x, kind, exactly):
        """Sign of a condition at x, or of its first derivative that is not zero; see ``lasts`` for ``exactly``."""
        value, size, zero = _at(row, x), _size(row, [*map(abs, x)]), mpf(10) ** (_BEHIND - mp.dps)
        if kind is not None and x[1] == -self.drive.Omega:  # then the other speed is that of the second body alone
            value, size = (self.mode[0], None, self.mode[2])[2 * kind] * self.drive.speeds(x)[kind], mpf(0)
        if kind not in exactly and abs(value) > zero * size:
            return mp.sign(value)
        rows = [[*a, b] for a, b in zip(self.A, self.b, strict=True)]
        rate, sizes = [_at(r, x) for r in rows], [_size(r, [*map(abs, x)]) for r in rows]
        row = [*row[:4], mpf(0)]
        for _ in range(4):
            value = _at(row, rate)
            if abs(value) > zero * _size(row, sizes):  # sizes: of the terms that the derivative is summed from
                return mp.sign(value)
            rows = [[*a, mpf(0)] for a in self.A]
            rate, sizes = [_at(r, rate) for r in rows], [_size(r, sizes) for r in rows]
        return 1  # it rests on zero, as F_0 = 0 does


def _at(row, x):
    return summed(row[4], *(g * c for g, c in zip(row[:4], x, strict=True)))


def _inverse(matrix):
    """Inverse of a matrix, with zero where an entry is nothing but rounding."""
    found = mp.inverse(matrix)
    sizes = found.apply(abs) * matrix.apply(abs) * found.apply(abs)
    for i, j in product(range(found.rows), range(found.cols)):
        if abs(found[i, j]) < mpf(10) ** (20 - mp.dps) * sizes[i, j]:
            found[i, j] = mpf(0)
    return found


def _size(row, x):
    return sum((abs(g) * c for g, c in zip(row[:4], x, strict=True)), abs(row[4]))


class FourStatesDrive(FourStatesLaws):
    """The drive, its modes made once."""

    def __init__(self, model, parameters, frictions=()):
        super().__init__(model, parameters, frictions)
        self.known, self.solved, self.inverses = {}, {}, {}

    def solve(self, rows, sides):
        """Linear equations, with zero where an unknown is nothing but rounding; the matrices are few."""
        key = tuple(map(tuple, rows))
        if key not in self.inverses:
            self.inverses[key] = _inverse(mp.matrix(rows))
        inverse = self.inverses[key]
        return [summed(*(inverse[i, j] * side for j, side in enumerate(sides))) for i in range(len(sides))]

    def forces(self, mode, x, along=None):
        """Accelerations and forces at a state, from the affine functions of it that they are; solved once a mode."""
        key = mode, along
        if key not in self.solved:
            self.solved[key] = affine(lambda y: super(FourStatesDrive, self).forces(mode, y, along))
        return [_at(row, x) for row in self.solved[key]]

    def row(self, function):
        """An affine function of the state as a row."""
        return np.array(affine(lambda x: [function(x)])[0])

    def row_of_field(self, mode):
        """Rows of the field."""
        return affine(lambda x: self.field(mode, x))

    def mode(self, mode):
        """Field and conditions of a mode."""
        if mode not in self.known:
            self.known[mode] = FourStatesMode(self, mode)
        return self.known[mode]

    def lasts(self, mode, x, zero):
        """See :meth:`FourStatesMode.lasts`."""
        d, _, a = mode
        slip, second = self.speeds(x)[:2]
        if d and 0 not in zero and d * slip < 0:  # the usual reason, seen without making the mode
            return False
        if a and 1 not in zero and a * second < 0:
            return False
        return self.mode(mode).lasts(x, zero)

    def cornered(self, x):
        """The state after a seizure; where the next ones lead to the corner at which N is zero, it is put there.

        Without a load, N is zero where the speed of slip stays zero. Each seizure squares the distance from there.
        """
        row = self.mode((1, -1, None)).rows[1]
        if self.p["axial_force"] == 0 == self.along and abs(_at(row, x)) < _CORNER * _size(row, [*map(abs, x)]):
            put_on_zero(row, x)
        return x


def put_on_zero(row, x):
    """Move the place in ``x`` that a function of the state depends on most, so that it is zero to the last digit."""
    place = max((0, 2), key=lambda i: abs(row[i] * x[i]))
    if row[place] != 0:
        x[place] -= _at(row, x) / row[place]


def simulate(parameters, model, frictions, start, t_end, *, dps=40, max_events=60):
    """Follow the motion from ``start`` (u, w and the deviation and rate of the second body) at t = 0 to t_end."""
    with mp.workdps(dps + SPARE_DIGITS):
        drive = FourStatesDrive(model, parameters, frictions)
        x, t, t_end = np.array([mpf(value) for value in start], dtype=object), mpf(0), mpf(t_end)
        events, arcs = [], []
        speeds = drive.speeds(x)
        zero = {k for k in (0, 1) if speeds[k] == 0 and (k == 0 or drive.second)}
        direction = int(mp.sign(speeds[0]))
        mode = (direction, -direction, None) if drive.painleve and direction else drive.choose(x, zero)
        while len(events) < max_events:
            here = drive.mode(mode)
            if drive.painleve and direction and not events and _at(here.rows[1], x) < 0:
                stay, fired = mpf(0), 1  # a start where law -1 is not admissible
            else:
                arc = here.arc(x)
                # A touch stops and lets go again, or takes N to zero and back; but a seizure it makes or not.
                touch = [not drive.painleve or mode[0] == 0 or kind is not None for kind in here.kinds]
                tiny = [kind is not None and kind not in zero for kind in here.kinds]
                guards = [Function(arc, *guard) for guard in zip(here.rows, touch, tiny, strict=True)]
                stay, fired = first_root(guards, [1] * len(guards), t_end - t)
                arcs.append((mode, tuple(x), stay))
                x = np.array(arc.state(stay), dtype=object) if stay else x
            t += stay
            if fired is None:
                return FourStatesTruth(t_end, tuple(x), mode, events, arcs, True, drive)
            zero, after = set(here.ties), None
            if stay and here.kinds[fired] is None:  # what is left of it is the rounding of the clock, which may be fast
                put_on_zero(here.rows[fired], x)
            if here.kinds[fired] is not None:
                zero.add(here.kinds[fired])
            seized = drive.painleve and mode[0] != 0 and here.kinds[fired] is None
            if seized:
                x, after = drive.impact(x)
                zero = {0}
            x = drive.tie(x, zero)
            x = drive.cornered(x) if seized else x
            before, mode = mode, drive.choose(x, zero, after)
            events.append(FourStatesEvent(t, before, mode, tuple(x), seized))
        return FourStatesTruth(t, tuple(x), mode, events, arcs, False, drive)
