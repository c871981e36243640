"""The walk along a motion in one mode that finds out how long it surely meets no guard (:mod:`lsvib.cycles.quiet`)."""

import math

from lsvib.engine.kernels.jit import entry, kernel

_LONGER, _SHORTER = 2.0, 0.5  # factors from step to step
_EXPONENT = 700.0  # largest exponent of a growing part: e^700 is a double


@entry
def walk(drift, parts, rates, sizes, lost, turn, end, most):
    """Walk in steps on which no guard can fire, each twice as long as the last one or, where that fails, half.

    Arguments: those of guards as :class:`lsvib.cycles.quiet.Guards` has them, drift (g, 3), parts (g, q) and rates (q)
    as complex numbers, sizes (g, 3), lost [1]; shortest step ``turn`` [s]; the time ``end`` [s] at which the walk is
    given up; the most steps. Returns (time [s] up to which no guard fires, which may be infinite; steps taken).
    """
    time, step, settles = 0.0, turn, _may_settle(drift, rates)
    for taken in range(1, most + 1):
        if settles and _never(drift, parts, rates, sizes, lost, time):
            return math.inf, taken
        if not time <= end:
            return time, taken
        if _stays(drift, parts, rates, sizes, lost, time, time + step):
            time, step = time + step, _LONGER * step
        elif step * _SHORTER < turn or time + _SHORTER * step == time:
            return time, taken
        else:
            step *= _SHORTER
    return time, most


@kernel
def _may_settle(drift, rates):
    """Whether no part grows and nothing drifts."""
    settles = True
    for j in range(rates.size):
        settles = settles and not rates[j].real > 0.0
    for guard in range(drift.shape[0]):
        settles = settles and drift[guard, 1] == 0.0 and drift[guard, 2] == 0.0
    return settles


@kernel
def _never(drift, parts, rates, sizes, lost, time):
    """Whether no guard can fire from a time [s] on, by the sizes of parts of which none grows."""
    for guard in range(drift.shape[0]):
        size = 0.0
        for j in range(rates.size):
            size += abs(parts[guard, j]) * math.exp(rates[j].real * time)
        if not drift[guard, 0] - size > lost * sizes[guard, 0]:
            return False
    return True


@kernel
def _stays(drift, parts, rates, sizes, lost, first, last):
    """Whether all guards stay positive between two times [s]."""
    for guard in range(drift.shape[0]):
        at_first = drift[guard, 0] + drift[guard, 1] * first + drift[guard, 2] * first * first
        at_last = drift[guard, 0] + drift[guard, 1] * last + drift[guard, 2] * last * last
        room = abs(drift[guard, 2]) * (last - first) ** 2 / 4.0
        unsure = sizes[guard, 0] + sizes[guard, 1] * last + sizes[guard, 2] * last * last
        for j in range(rates.size):
            rate, part = rates[j], parts[guard, j]
            before = math.exp(min(rate.real * first, _EXPONENT))
            after = math.exp(min(rate.real * last, _EXPONENT))
            largest, speed = abs(part) * max(before, after), abs(rate)
            bend = (speed * (last - first)) ** 2 / 8.0
            unsure += largest * (1.0 + speed * last)
            if bend < 1.0:
                room += largest * bend
                at_first += before * (part.real * math.cos(rate.imag * first) - part.imag * math.sin(rate.imag * first))
                at_last += after * (part.real * math.cos(rate.imag * last) - part.imag * math.sin(rate.imag * last))
            else:
                room += largest
        if not min(at_first, at_last) - room > lost * unsure:
            return False
    return True
