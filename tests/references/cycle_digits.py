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

from lsvib.engine.kernels.layout import GRAZE_KIND
from lsvib.models.model import model_of
from references.drives import name_of
from references.exponential_sums import Function
from references.four_states_digits import FourStatesDrive, mode_name

DIGITS = 110  # a fourfold multiplier 0 scatters by the fourth root of what the differences are wrong by, 1e-45
STEP = mpf(10) ** -45
CLOSED = mpf(10) ** -40  # residual of a period
PLACES = 24  # of each arc at which the guards of its mode must be positive


class CycleDigits:
    """A cycle of the library, solved again; ``physics``: the frictions of a second body that its drive has."""

    def __init__(self, cycle, physics=()):
        orbit, model = cycle.orbit, model_of(cycle.drive)
        own = orbit.kind != GRAZE_KIND
        codes = orbit.automaton.codes
        modes = [codes[orbit.start_mode], *codes[orbit.mode[own]]]
        times = np.concatenate([[0.0], orbit.time[own]])
        with mp.workdps(DIGITS):
            self.drive = FourStatesDrive(name_of(cycle.drive), dict(cycle.drive), physics)
            named = {mode_name(mode, name_of(cycle.drive)): mode for mode in self.drive.modes()}
            self.modes = [self.drive.mode(named[model.modes(int(code)).name.lower()]) for code in modes]
            assert self.modes[0] == self.modes[-1]
            self.stays = [mpf(float(stay)) for stay in np.diff(times)]
            self.seizures = np.isin(orbit.kind[own], orbit.automaton.sprag_kinds).tolist()
            self.fired = [self._nearest(mode, x) for mode, x in zip(self.modes, orbit.before[own], strict=False)]
            self.start = np.array([mpf(float(x)) for x in cycle.state], dtype=object)
            self.size = [mpf(float(x)) for x in cycle.section.size]

    def _nearest(self, mode, x):
        x = [float(value) for value in x]
        away = []
        for row in mode.rows:
            terms = [float(g) * c for g, c in zip(row, [*x, 1.0], strict=True)]
            size = sum(map(abs, terms))
            away.append(abs(sum(terms)) / size if size else 1.0)
        return int(np.argmin(away))

    def period(self, x, look=False):
        """State after one period from x; the times of the events are kept as the next guess."""
        for k, fired in enumerate(self.fired):
            mode = self.modes[k]
            arc = mode.arc(x)
            guards = [Function(arc, row) for row in mode.rows]
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
            x = np.array(arc.state(t), dtype=object)
            stopped = {mode.kinds[fired]} - {None}
            x = self.drive.impact(x)[0] if self.seizures[k] else self.drive.tie(x, mode.ties | stopped)
        return x

    def _derivative(self, x, end):
        found = mp.zeros(4)
        for j in range(4):
            beside = x.copy()
            beside[j] += STEP * self.size[j]
            ahead = self.period(beside)
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
                x = np.array([a + s * d for a, s, d in zip(x, self.size, step, strict=True)], dtype=object)
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
