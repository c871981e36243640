"""Cycles of drives with four states and their multipliers with 40 digits, from Newton's laws of the references.

The library says in which modes a cycle is and for how long about; everything else is computed anew: fields and guards
of the modes and the impact of a seizure by ``references``, the closed form of each arc by eigenvectors, the
times of events by Newton's method on the guards, the state by Newton's method on the return. The derivative of the
return is a difference with a step of 1e-45 of the state, and the multipliers are its eigenvalues. No saltation matrix
and no derivative of a flow enters.
"""

from functools import cached_property

import numpy as np
from mpmath import mp, mpf

from references.threads_digits import Function, ThreadsTrueDrive
from references.two_bodies_digits import ClosedFormDrive
from lsvib.drives.registry import find_model
from lsvib.engine.kernels.status import GRAZE_KIND

DIGITS = 110  # a fourfold multiplier 0 scatters by the fourth root of what the differences are wrong by, 1e-45
STEP = mpf(10) ** -45
CLOSED = mpf(10) ** -40  # residual of a period
PLACES = 24  # of each arc at which the guards of its mode must be positive
_WAYS = {"forward": 1, "backward": -1, "held": 0, "positive": 1, "negative": -1}


class _Threads:
    def __init__(self, drive, physics):
        self.drive = ThreadsTrueDrive(dict(drive))
        self.kinds = {}

    def mode(self, words):
        direction = 0 if words[0] == "rest" else _WAYS[words[1]]
        return direction, _WAYS[words[-1]]

    def rows(self, mode):
        return [([side * x for x in row], None) for row, side in self.drive.guards(mode)]

    def arc(self, mode, x):
        return self.drive.arc(mode, x)

    def after(self, mode, fired, x, seizure):
        return (x[0], -self.drive.Omega, x[2], x[3]) if mode[0] and fired == 1 else x


class _TwoBodies:
    def __init__(self, drive, physics):
        self.drive = ClosedFormDrive(drive.model, dict(drive), physics)

    def mode(self, words):
        second = None
        if "nut" in words or "screw" in words:
            *words, _, how = words
            second = _WAYS[how]
        if words[0] == "rest":
            return 0, _WAYS[words[1]] if len(words) > 1 else 0, second
        return _WAYS[words[1]], _WAYS[words[2]], second

    def rows(self, mode):
        found = self.drive.mode(mode)
        return list(zip(found.rows, found.kinds, strict=True))

    def arc(self, mode, x):
        return self.drive.mode(mode).arc(x)

    def after(self, mode, fired, x, seizure):
        here, x = self.drive.mode(mode), np.array(x, dtype=object)
        kind = here.kinds[fired]
        if seizure:
            x, _ = self.drive.impact(x)
            return tuple(self.drive.tie(x, {0}))
        return tuple(self.drive.tie(x, set(here.ties) | ({kind} if kind is not None else set())))


class CycleDigits:
    """A cycle of the library, solved again; ``physics``: the frictions of a second body that its drive has."""

    def __init__(self, cycle, physics=()):
        orbit, model = cycle.orbit, find_model(cycle.drive.model)
        own = orbit.kind != GRAZE_KIND
        codes = orbit.automaton.codes
        modes = [codes[orbit.start_mode], *codes[orbit.mode[own]]]
        times = np.concatenate([[0.0], orbit.time[own]])
        with mp.workdps(DIGITS):
            self.reference = (_Threads if cycle.drive.model == "threads" else _TwoBodies)(cycle.drive, physics)
            self.modes = [self.reference.mode(model.modes(int(code)).name.lower().split("_")) for code in modes]
            assert self.modes[0] == self.modes[-1]
            self.stays = [mpf(float(stay)) for stay in np.diff(times)]
            self.seizures = np.isin(orbit.kind[own], orbit.automaton.sprag_kinds).tolist()
            self.rows = {mode: self.reference.rows(mode) for mode in self.modes}
            self.fired = [self._nearest(mode, x) for mode, x in zip(self.modes, orbit.before[own], strict=False)]
            self.start = tuple(mpf(float(x)) for x in cycle.state)
            self.size = [mpf(float(x)) for x in cycle.section.size]

    def _nearest(self, mode, x):
        """The guard that an event is on."""
        x = [float(value) for value in x]
        away = []
        for row, _ in self.rows[mode]:
            terms = [float(g) * c for g, c in zip(row, [*x, 1.0], strict=True)]
            size = sum(map(abs, terms))
            away.append(abs(sum(terms)) / size if size else 1.0)
        return int(np.argmin(away))

    def period(self, x, look=False):
        """State after one period from x; the times of the events are kept as the next guess."""
        for k, fired in enumerate(self.fired):
            mode = self.modes[k]
            arc = self.reference.arc(mode, x)
            guards = [Function(arc, row) for row, _ in self.rows[mode]]
            guard, t = guards[fired], self.stays[k]
            for _ in range(12):
                step = guard(t) / guard(t, 1)
                t -= step
                if abs(step) <= mpf(10) ** -(DIGITS - 30) * abs(t):
                    break
            else:
                raise ArithmeticError("Newton's method does not find an event")
            if look:
                for part in range(1, PLACES):
                    assert all(f(t * part / PLACES) > 0 for f in guards), "an event was left out"
            self.stays[k] = t
            x = self.reference.after(mode, fired, arc.state(t), self.seizures[k])
        return x

    def _derivative(self, x, end):
        found = mp.zeros(4)
        for j in range(4):
            beside = list(x)
            beside[j] += STEP * self.size[j]
            ahead = self.period(tuple(beside))
            for i in range(4):
                found[i, j] = (ahead[i] - end[i]) / STEP / self.size[i]
        return found

    @cached_property
    def solved(self):
        """State (4), period and derivative of the return in sizes of the motion, of the cycle itself."""
        with mp.workdps(DIGITS):
            x = self.start
            end = self.period(x)
            slopes = self._derivative(x, end)
            for _ in range(12):
                gap = mp.matrix([(b - a) / s for a, b, s in zip(x, end, self.size, strict=True)])
                if max(abs(g) for g in gap) <= CLOSED:
                    break
                step = mp.lu_solve(mp.eye(4) - slopes, gap)
                x = tuple(a + s * d for a, s, d in zip(x, self.size, step, strict=True))
                end = self.period(x)
            else:
                raise ArithmeticError("Newton's method does not find the cycle")
            end = self.period(x, look=True)
            return x, sum(self.stays), self._derivative(x, end)

    @cached_property
    def multipliers(self):
        """The three multipliers, complex doubles, the largest first; of the four eigenvalues the least is the trivial
        one, that of a section."""
        with mp.workdps(DIGITS):
            found = [complex(z) for z in mp.eig(self.solved[2], left=False, right=False)]
        return np.array(sorted(found, key=lambda z: (-abs(z), z.imag))[:3])
