"""Reference with 40 digits for the drives with axial support and with rotating nut: closed forms, certified search.

Newton's laws, modes, their conditions, the rule that tries modes out and the impact are those of
``two_bodies_laws.py``, here in mpmath numbers; the closed form of the motion and the search for roots are those of
``exponential_sums.py``. Speeds that a mode ties are eliminated from its field, so that the rates left over are the
modal ones and one zero for each tie. A mode follows if each of its conditions holds; a condition that is zero holds if
its first derivative along the mode's own flow that is not zero is positive.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mpmath import mp, mpf

from lsvib.bench.reference.exponential_sums import UNIT, Function, ThreadsTrueArc, affine, first_root
from lsvib.bench.reference.threads_digits import SPARE_DIGITS
from lsvib.bench.reference.two_bodies_laws import TwoBodiesTrueDrive

_ZERO = mpf(10) ** -30  # of its terms: a condition that an event, or the start, has put on zero


@dataclass
class TwoBodiesTrueEvent:
    """An event: its time, the mode that follows, the state, and whether it was a seizure."""

    time: mpf
    mode_after: tuple
    state: tuple
    seizure: bool


@dataclass
class TwoBodiesTruth:
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


class TwoBodiesTrueMode:
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
        """Rates and eigenvectors of what is left, and the constant in eigenvectors; the tied rates are zero."""
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
        return alive, rates, vectors, mp.lu_solve(vectors, constant)

    def arc(self, x):
        """Closed form of the motion from the state x on."""
        alive, rates, vectors, push = self.spectrum
        weights = mp.lu_solve(vectors, mp.matrix([x[i] for i in alive]))
        c0, c1, kept, columns = [mpf(0)] * 4, [mpf(0)] * 4, [], []
        for k, rate in enumerate(rates):
            vector = [mpf(0)] * 4
            for m, i in enumerate(alive):
                vector[i] = vectors[m, k]
            if rate == 0:
                c0 = [c + mp.re(weights[k] * v) for c, v in zip(c0, vector, strict=True)]
                c1 = [c + mp.re(push[k] * v) for c, v in zip(c1, vector, strict=True)]
                continue
            c0 = [c - mp.re(push[k] / rate * v) for c, v in zip(c0, vector, strict=True)]
            real = abs(mp.im(rate)) < mpf(10) ** -(mp.dps // 2) * abs(rate)
            if real or mp.im(rate) > 0:  # a conjugate pair is twice the real part of one of the two
                column = [(1 if real else 2) * (weights[k] + push[k] / rate) * v for v in vector]
                kept.append(mp.re(rate) if real else rate)
                columns.append([mp.re(c) for c in column] if real else column)
        for t, row in self.tied.items():
            c0[t], c1[t] = _at(row, c0), _at([*row[:4], mpf(0)], c1)
            for column in columns:
                column[t] = sum(g * c for g, c in zip(row[:4], column, strict=True))
        if not kept:  # nothing swings; a rate of no weight sets the scale of time
            stiffness, inertia = self.drive.p["coupling_stiffness"], self.drive.p["screw_inertia"]
            kept, columns = [-mp.sqrt(stiffness / inertia)], [[mpf(0)] * 4]
        return ThreadsTrueArc(kept, columns, c0, c1)

    def lasts(self, x, zero):
        """Whether the mode's own flow keeps all its conditions; the speeds in ``zero`` are zero exactly."""
        if not self.ties <= zero:
            return False
        return all(self._sign(row, x, kind in zero) > 0 for row, kind in zip(self.rows, self.kinds, strict=True))

    def _sign(self, row, x, is_zero):
        """Sign of a function of the state at x, or of its first derivative that is not zero."""
        value, size = _at(row, x), _size(row, [*map(abs, x)])
        if not is_zero and abs(value) > _ZERO * size:
            return mp.sign(value)
        rows = [[*a, b] for a, b in zip(self.A, self.b, strict=True)]
        rate, sizes = [_at(r, x) for r in rows], [_size(r, [*map(abs, x)]) for r in rows]
        row = [*row[:4], mpf(0)]
        for _ in range(4):
            value = _at(row, rate)
            if abs(value) > _ZERO * _size(row, sizes):  # sizes: of the terms that the derivative is summed from
                return mp.sign(value)
            rows = [[*a, mpf(0)] for a in self.A]
            rate, sizes = [_at(r, rate) for r in rows], [_size(r, sizes) for r in rows]
        return 1  # it rests on zero, as F_0 = 0 does


def _at(row, x):
    return sum((g * c for g, c in zip(row[:4], x, strict=True)), row[4])


def _size(row, x):
    return sum((abs(g) * c for g, c in zip(row[:4], x, strict=True)), abs(row[4]))


class ClosedFormDrive(TwoBodiesTrueDrive):
    """The drive in mpmath numbers, its modes made once."""

    def __init__(self, model, parameters, frictions):
        super().__init__(model, parameters, frictions, exact=True)
        self.known, self.solved = {}, {}

    def forces(self, mode, x, along=None):
        """Accelerations and forces at a state, from the affine functions of it that they are; solved once a mode."""
        key = mode, along
        if key not in self.solved:
            self.solved[key] = affine(lambda y: super(ClosedFormDrive, self).forces(mode, y, along))
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
            self.known[mode] = TwoBodiesTrueMode(self, mode)
        return self.known[mode]

    def lasts(self, mode, x, zero):
        """See :meth:`TwoBodiesTrueMode.lasts`."""
        d, _, a = mode
        slip, second = self.speeds(x)[:2]
        if d and 0 not in zero and d * slip < 0:  # the usual reason, seen without making the mode
            return False
        if a and 1 not in zero and a * second < 0:
            return False
        return self.mode(mode).lasts(x, zero)


def simulate(parameters, model, frictions, start, t_end, *, dps=40, max_events=60):
    """Follow the motion from ``start`` (u, w and the deviation and rate of the second body) at t = 0 to t_end."""
    with mp.workdps(dps + SPARE_DIGITS):
        drive = ClosedFormDrive(model, parameters, frictions)
        x, t, t_end = np.array([mpf(value) for value in start], dtype=object), mpf(0), mpf(t_end)
        events, arcs = [], []
        speeds = drive.speeds(x)
        zero = {k for k in (0, 1) if speeds[k] == 0 and (k == 0 or drive.second)}
        direction = int(mp.sign(speeds[0]))
        mode = (direction, -direction, None) if drive.painleve and direction else drive.choose(x, zero)
        while len(events) < max_events:
            here, seized = drive.mode(mode), False
            if drive.painleve and direction and not events and _at(here.rows[1], x) < 0:
                stay, fired = mpf(0), 1  # a start where law -1 is not admissible
            else:
                arc = here.arc(x)
                stay, fired = first_root([Function(arc, row) for row in here.rows], [1] * len(here.rows), t_end - t)
                arcs.append((mode, tuple(x), stay))
                x = np.array(arc.state(stay), dtype=object)
            t += stay
            if fired is None:
                return TwoBodiesTruth(t_end, tuple(x), mode, events, arcs, True, drive)
            zero, after = set(here.ties), None
            if here.kinds[fired] is not None:
                zero.add(here.kinds[fired])
            seized = drive.painleve and mode[0] != 0 and here.kinds[fired] is None
            if seized:
                x, after = drive.impact(x)
                zero = {0}
            x = drive.tie(x, zero)
            mode = drive.choose(x, zero, after)
            events.append(TwoBodiesTrueEvent(t, mode, tuple(x), seized))
        return TwoBodiesTruth(t, tuple(x), mode, events, arcs, False, drive)
