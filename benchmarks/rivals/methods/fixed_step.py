"""Runge–Kutta of order four with a fixed step, compiled: the signs of the guards are looked at after each step.

When a guard has become negative the step is cut where a straight line between its two values is zero (``plain``), or
the cut is refined by three steps of the secant method (``refined``). Two crossings within one step go unseen.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid, Integrate
from lsvib.systems.kernels.jit import allocating_entry, entry

_REFINEMENTS = 3  # secant steps towards a guard's zero: each adds digits until those of the step are reached
_LOST = -2  # where the state is beyond all numbers


def integrator(hybrid: Hybrid, setting: float, clock: Clock, refined: bool = False) -> Integrate:
    """Return what follows one mode with the step ``setting`` [s]."""
    refinements = _REFINEMENTS if refined else 0

    def integrate(mode: int, now: float, state: Sequence[float], end: float):
        here, out = hybrid.modes[mode], np.array(state)
        time, guard = _march(hybrid.fields[mode], here.guards, out, setting, end - now, refinements)
        if guard == _LOST:
            raise GaveUp("the motion is lost")
        return (end if guard < 0 else now + time), out.tolist(), None if guard < 0 else guard

    return integrate


@entry
def _rate(field, state, out):
    n = state.size
    for i in range(n):
        total = field[i, n]
        for j in range(n):
            total += field[i, j] * state[j]
        out[i] = total


@entry
def _step(field, state, h, rates, trial, out):
    """One step of the classical method."""
    n = state.size
    _rate(field, state, rates[0])
    for i in range(n):
        trial[i] = state[i] + 0.5 * h * rates[0, i]
    _rate(field, trial, rates[1])
    for i in range(n):
        trial[i] = state[i] + 0.5 * h * rates[1, i]
    _rate(field, trial, rates[2])
    for i in range(n):
        trial[i] = state[i] + h * rates[2, i]
    _rate(field, trial, rates[3])
    for i in range(n):
        out[i] = state[i] + h / 6.0 * (rates[0, i] + 2.0 * (rates[1, i] + rates[2, i]) + rates[3, i])


@entry
def _value(guard, state):
    value = guard[state.size]
    for i in range(state.size):
        value += guard[i] * state[i]
    return value


@entry
def _cut(field, guard, state, h, refinements, rates, trial, out):
    """Fraction of the step at which a guard is zero."""
    before = max(_value(guard, state), 0.0)
    after = _value(guard, out)
    low, high, fraction = 0.0, 1.0, before / (before - after)
    for _ in range(refinements):
        _step(field, state, fraction * h, rates, trial, out)
        value = _value(guard, out)
        if value > 0.0:
            low, before = fraction, value
        else:
            high, after = fraction, value
        if before == after:
            break
        fraction = (low * after - high * before) / (after - before)
    return fraction


@allocating_entry
def _march(field, guards, state, step, duration, refinements):
    """Follow a mode for so long; ``state`` (n) becomes the final one. Returns (time, guard that is zero, or −1)."""
    n = state.size
    rates, trial, ahead = np.empty((4, n)), np.empty(n), np.empty(n)
    count = 0
    while True:
        now = count * step
        h = min(step, duration - now)
        _step(field, state, h, rates, trial, ahead)
        fired, first = -1, 2.0
        for guard in range(len(guards)):
            after = _value(guards[guard], ahead)
            if after < 0.0:
                before = max(_value(guards[guard], state), 0.0)
                if before / (before - after) < first:
                    fired, first = guard, before / (before - after)
        if fired >= 0:
            h *= _cut(field, guards[fired], state, h, refinements, rates, trial, ahead)
            _step(field, state, h, rates, trial, ahead)
        for i in range(n):
            state[i] = ahead[i]
            if not abs(state[i]) < 1e30:
                return now, _LOST
        count += 1
        if fired >= 0 or now + h >= duration:
            return now + h, fired
