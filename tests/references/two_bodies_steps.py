"""Reference for the drives with axial support and with rotating nut: a fixed fine step, trial of modes.

The motion x' = A x + b is advanced by the Taylor series of the flow with a fixed step, conditions are looked at after
each step, and the first one violated is bisected. Newton's laws are those of
:mod:`references.two_bodies_laws`.
"""

from dataclasses import dataclass

import numpy as np

from references.two_bodies_laws import TwoBodiesTrueDrive

LOOK_AHEAD = 1e-8  # [s], the moment after which a mode must fulfil its conditions


@dataclass
class SteppedEvent:
    time: float
    mode_after: tuple
    state: np.ndarray
    seizure: bool


class SteppedDrive(TwoBodiesTrueDrive):
    """The drive in doubles, its modes made once."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.cache = {}

    def data(self, mode):
        """Return A and b of a mode, its guards and the rows of its conditions, made once."""
        if mode not in self.cache:
            table = np.array([self.row(lambda x, i=i: self.field(mode, x)[i]) for i in range(4)])
            conditions = self.conditions(mode)
            self.cache[mode] = (
                table[:, :4],
                table[:, 4],
                np.array([c[0] for c in conditions]),
                [c[1] for c in conditions],
            )
        return self.cache[mode]

    def advance(self, mode, x, t):
        """Return the state a short time t [s] after x in a mode, by the series of the flow."""
        A, b, _, _ = self.data(mode)
        term, total = t * (A @ x + b), x.copy()
        for k in range(2, 60):
            total = total + term
            term = t / k * (A @ term)
            if np.abs(term).max() == 0 or (np.abs(term) <= 1e-19 * np.abs(total)).all():
                break
        return total

    def lasts(self, mode, x, zero):
        """A mode lasts if its flow fulfils its conditions a moment later; speeds that it ties must be zero."""
        d, _, a = mode
        ties = ({0} if d == 0 else set()) | ({1} if a == 0 else set())
        if not ties <= zero:
            return False
        rows = self.data(mode)[2]
        later = self.advance(mode, x, LOOK_AHEAD)
        return bool((rows[:, :4] @ later + rows[:, 4] > 0).all())


def simulate(drive, start, t_end, step):
    """Follow a motion; returns (final state, mode, events)."""
    x, t, events = np.array(start, dtype=float), 0.0, []
    zero = set()
    slip = drive.speeds(x)[0]
    mode = (int(np.sign(slip)), -int(np.sign(slip)), None) if drive.painleve and slip else drive.choose(x, zero)
    while True:
        A, b, rows, kinds = drive.data(mode)
        augmented = np.zeros((5, 5))
        augmented[:4, :4], augmented[:4, 4] = A * step, b * step
        power, flow = np.eye(5), np.eye(5)
        for k in range(1, 40):
            power = power @ augmented / k
            flow = flow + power
        full = np.append(x, 1.0)
        origin, count = t, 0
        while True:
            ahead = flow @ full
            inside = rows @ ahead > 0
            if t + step >= t_end or not inside.all():
                break
            full, count = ahead, count + 1
            t = origin + count * step
        x = full[:4]
        low, high = 0.0, min(step, t_end - t)
        end = drive.advance(mode, x, high)
        if (rows[:, :4] @ end + rows[:, 4] > 0).all():
            return end, mode, events
        for _ in range(200):
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            there = drive.advance(mode, x, middle)
            low, high = (middle, high) if (rows[:, :4] @ there + rows[:, 4] > 0).all() else (low, middle)
        x, t = drive.advance(mode, x, high), t + high
        fired = int(np.argmin(rows[:, :4] @ x + rows[:, 4] > 0))
        zero = ({0} if mode[0] == 0 else set()) | ({1} if mode[2] == 0 else set())
        if kinds[fired] is not None:
            zero.add(kinds[fired])
        seizure = drive.painleve and mode[0] != 0 and kinds[fired] is None
        after = None
        if seizure:
            x, after = drive.impact(x)
            zero = {0}
        x = drive.tie(x, zero)
        mode = drive.choose(x, zero, after)
        events.append(SteppedEvent(t, mode, x, seizure))
