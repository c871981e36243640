"""Runge–Kutta of order four with a fixed step, compiled: the signs of the guards are looked at after each step.

When a guard has become negative the step is cut where a straight line between its two values is zero (``plain``), or
the cut is refined by three steps of the secant method (``refined``); the state is put on the surface, and the mode
changes as the automaton says, which includes the stick test. Two crossings within one step go unseen.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.jit import allocating_kernel, kernel
from benchmarks.record import Record
from benchmarks.rivals.hybrid import Clock, Hybrid, Recorder
from lsvib.engine.kernels.event_loop import apply_reset, choose_branch, put_on_surface
from lsvib.engine.motion import enter

_DONE, _FULL, _LOST = 0, 1, 2  # outcomes: the end; no room for more events; no mode fits the state
_REFINEMENTS = 3  # secant steps towards a guard's zero: each adds digits until those of the step are reached


def prepare(hybrid: Hybrid, setting: float, clock: Clock, max_events: int, refined: bool = False) -> Callable:
    """Return a function that runs the scene with the step ``setting`` [s]."""
    scene, automaton = hybrid.scene, hybrid.automaton

    def run() -> Callable[[], Record]:
        """March to the end of the scene with steps of one length."""
        mode, state = enter(automaton, scene.state)
        record = Recorder(hybrid, mode, state.copy())
        times, kinds = np.empty(max_events), np.empty(max_events, dtype=np.int8)
        modes, starts = np.empty(max_events, dtype=np.int64), np.empty((max_events, state.size))
        status, count = _march(
            automaton.tables, hybrid.fields, mode, state, setting, scene.duration, _REFINEMENTS if refined else 0,
            times, kinds, modes, starts,
        )  # fmt: skip

        def result() -> Record:
            """What is compared."""
            for k in range(count):
                record.add(times[k], kinds[k], modes[k], starts[k])
            return record.close(scene.duration, state, ("", "too many events", "the motion is lost")[status])()

        return result

    return run


@kernel
def _rate(field, state, out):
    n = state.size
    for i in range(n):
        total = field[i, n]
        for j in range(n):
            total += field[i, j] * state[j]
        out[i] = total


@kernel
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


@kernel
def _guard(tables, guard, state):
    row = tables.surfaces[tables.guard_surface[guard]]
    value = row[state.size]
    for i in range(state.size):
        value += row[i] * state[i]
    return tables.guard_sign[guard] * value


@kernel
def _cut(tables, field, guard, state, h, refinements, rates, trial, out):
    """Fraction of the step at which a guard is zero."""
    before = max(_guard(tables, guard, state), 0.0)
    after = _guard(tables, guard, out)
    low, high, fraction = 0.0, 1.0, before / (before - after)
    for _ in range(refinements):
        _step(field, state, fraction * h, rates, trial, out)
        value = _guard(tables, guard, out)
        if value > 0.0:
            low, before = fraction, value
        else:
            high, after = fraction, value
        if before == after:
            break
        fraction = (low * after - high * before) / (after - before)
    return fraction


@allocating_kernel
def _march(tables, fields, mode, state, step, t_end, refinements, times, kinds, modes, starts):
    """Follow the motion; ``state`` (n) becomes the final one. Returns (status, number of events)."""
    n = state.size
    rates, trial, ahead, scratch = np.empty((4, n)), np.empty(n), np.empty(n), np.empty(n)
    origin, count, event, now = 0.0, 0, 0, 0.0
    while True:
        now = origin + count * step
        h = min(step, t_end - now)
        last = now + h >= t_end
        field = fields[mode]
        _step(field, state, h, rates, trial, ahead)
        fired, first = -1, 2.0
        for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
            after = _guard(tables, guard, ahead)
            if after < 0.0:
                before = max(_guard(tables, guard, state), 0.0)
                if before / (before - after) < first:
                    fired, first = guard, before / (before - after)
        if fired >= 0:
            fraction = _cut(tables, field, fired, state, h, refinements, rates, trial, ahead)
            h, last = fraction * h, False
            _step(field, state, h, rates, trial, ahead)
        for i in range(n):
            state[i] = ahead[i]
            if not abs(state[i]) < 1e30:
                return _LOST, event
        count += 1
        if last:
            return _DONE, event
        if fired >= 0:
            if event == times.size:
                return _FULL, event
            origin, count = now + h, 0
            if h > 0.0:  # else it was entered beyond the guard, where a jump is due
                put_on_surface(tables, fired, state, np.abs(state))
            apply_reset(tables, tables.guard_transition[fired], state, scratch)
            branch = choose_branch(tables, tables.guard_transition[fired], state, np.abs(state))
            if branch < 0:
                return _LOST, event
            mode = tables.branch_mode[branch]
            times[event], kinds[event], modes[event] = origin, tables.branch_kind[branch], mode
            starts[event] = state
            event += 1
