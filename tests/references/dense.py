"""The drive with compliant threads by dense evaluation in many digits, for modes that have no eigenvectors.

The drive, its fields, guards and laws are those of :mod:`references.threads_digits`. The flow is mpmath's
matrix exponential over a step of 1/40 of the fastest time scale, applied again and again. A guard is evaluated at every
step with its derivative: between two steps of one sign it is searched for a minimum where the derivative changes from
falling to rising. A root is then refined to 40 digits by secant steps inside its bracket.
"""

from mpmath import mp, mpf

from references.threads_digits import (
    SPARE_DIGITS,
    ThreadsTrueDrive,
    ThreadsTrueEvent,
    ThreadsTruth,
    name,
)

STEPS_PER_SCALE = 40


class _Field:
    def __init__(self, drive, mode):
        law = mode[0] * mode[1]
        A, b = drive.matrix((lambda x: drive.slip(law, x)) if law else drive.rest)
        self.matrix = mp.matrix(5)
        for i in range(4):
            self.matrix[i, 4] = b[i]
            for j in range(4):
                self.matrix[i, j] = A[i, j]
        # The rates, not the norm: coordinates are of very different sizes.
        self.step = 1 / (STEPS_PER_SCALE * max(abs(r) for r in mp.eig(A, left=False, right=False)))
        self.flow = mp.expm(self.matrix * self.step)
        rows = [(mp.matrix([row]), side) for row, side in drive.guards(mode)]
        self.guards = [(row, row * self.matrix, side) for row, side in rows]

    def after(self, x, t):
        return mp.expm(self.matrix * t) * x


def _refined(field, row, x, low, high, sign):
    """Time in (low, high) at which sign × row · x falls through zero."""

    def value(t):
        return sign * (row * field.after(x, t))[0]

    f_low, f_high = value(low), value(high)
    assert f_low > 0 >= f_high
    for count in range(400):
        t = low + (high - low) * f_low / (f_low - f_high) if count % 3 else (low + high) / 2
        f = value(t)
        if f > 0:
            low, f_low = t, f
        else:
            high, f_high = t, f
        if high - low < mpf(10) ** -38 * high or f == 0:
            return high
    raise ArithmeticError("a root was not refined")


def _fall(field, row, slope, side, x, ahead, fresh):
    """Time within one step at which a guard falls through zero, or None; ``fresh``: it may be zero at the start."""
    now, then = side * (row * x)[0], side * (row * ahead)[0]
    if then <= 0:
        return _refined(field, row, x, field.step * mpf(10) ** -12 if fresh else mpf(0), field.step, side)
    assert fresh or now > 0
    falls, rises = -side * (slope * x)[0], side * (slope * ahead)[0]
    if falls > (rises * mpf(10) ** -20 if fresh else 0) and rises > 0:  # released from rest, the speed has no slope
        bottom = _refined(field, slope, x, mpf(0), field.step, -side)
        if side * (row * field.after(x, bottom))[0] <= 0:
            return _refined(field, row, x, mpf(0), bottom, side)
    return None


def simulate(parameters, state, t_end, *, dps=40):
    """Follow the motion from ``state`` (u, w, e, v) at t = 0 to t_end."""
    with mp.workdps(dps + SPARE_DIGITS):
        drive, fields, events = ThreadsTrueDrive(parameters), {}, []
        x, t, t_end = mp.matrix([*map(mpf, state), 1]), mpf(0), mpf(t_end)
        mode, fresh = drive.mode_at(tuple(x[:4])), True
        while True:
            if mode not in fields:
                fields[mode] = _Field(drive, mode)
            field = fields[mode]
            ahead = field.flow * x
            falls = [_fall(field, *guard, x, ahead, fresh) for guard in field.guards]
            when, fired = min((f, k) for k, f in enumerate([*falls, field.step]) if f is not None)
            if t + when >= t_end:
                x = field.after(x, t_end - t)
                return ThreadsTruth(t_end, tuple(x[:4]), name(mode), events, [], drive)
            t, x, fresh = t + when, ahead if fired == len(falls) else field.after(x, when), fired < len(falls)
            if not fresh:
                continue
            direction, contact = mode
            if direction == 0:
                kind, mode = "release", ((1, -1)[fired], contact)
            elif fired == 0:
                kind, mode = "contact_reversal", (direction, -contact)
            else:
                x[1] = -drive.Omega
                mode = drive.mode_at(tuple(x[:4]))
                kind = "reversal" if mode[0] else "stick"
            events.append(ThreadsTrueEvent(t, kind, tuple(x[:4]), name(mode)))
