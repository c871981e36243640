"""heyoka: Taylor series of a mode's field and guards, compiled with LLVM; roots isolated on the guards' polynomials.

The modes of a scene are integrators with terminal events, one for each guard; the automaton of :class:`Hybrid` leads
from one to the next. The numbers of a mode are heyoka's run-time parameters, so what is compiled depends on the pattern
of its zeros and on the tolerance only, and modes and scenes share it.
"""

from collections.abc import Iterator, Sequence
from copy import copy
from functools import cache

import heyoka as hy
import numpy as np

from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid, HybridMode, Integrate, eta

_FINEST = float(np.finfo(float).eps)  # tolerance; heyoka's own default, below it the order only grows
_CHUNK = 1000  # steps, about half a millisecond, after which the clock is looked at
_NUDGE = 1e-16  # of the terms of a guard: heyoka loses the second root of a polynomial that starts at exactly zero
_LIMIT = int(hy.taylor_outcome.time_limit)
_MORE = int(hy.taylor_outcome.step_limit)
_LOST = int(hy.taylor_outcome.err_nf_state)

hy.set_logger_level_critical()  # it warns of what is expected here, in the middle of what is timed

Pattern = tuple[tuple[bool, ...], ...]


def integrator(hybrid: Hybrid, setting: float, clock: Clock) -> Integrate:
    """Return what follows one mode with heyoka's adaptive Taylor integrator at tolerance ``setting``.

    The tolerance is relative to the largest coordinate, so that coordinates and guards are given in sizes of the scene
    (rounded to powers of two, which costs no digit). Everything is compiled here, not in what is timed.
    """
    scale = np.exp2(np.round(np.log2(hybrid.scene.scales)))
    units = scale.tolist()
    arcs = [_integrator(mode, scale, max(setting, _FINEST)) for mode in hybrid.modes]
    states = [arc.state for arc in arcs]  # views
    held = 0.0, 0.0  # time in twice the digits, as heyoka itself keeps it, from one arc to the next

    def integrate(mode: int, now: float, state: Sequence[float], end: float):
        nonlocal held
        arc, here = arcs[mode], states[mode]
        arc.dtime = held if held[0] == now else (now, 0.0)
        for k, unit in enumerate(units):
            here[k] = state[k] / unit
        while True:
            found, *_ = arc.propagate_until(end, max_steps=_CHUNK)
            clock.look()
            outcome = int(found)
            if outcome != _MORE:
                break
        if outcome == _LOST:
            raise GaveUp("the state is not finite")
        after = [x * unit for x, unit in zip(here.tolist(), units, strict=True)]
        if outcome == _LIMIT:
            return end, after, None
        held = arc.dtime
        return held[0], after, -outcome - 1  # what heyoka makes of the index of an event that ends a run

    return integrate


def _integrator(mode: HybridMode, scale: np.ndarray, tolerance: float) -> hy.taylor_adaptive:
    """Return the integrator of a mode in coordinates x/scale, each guard in sizes of its own terms."""
    field = np.column_stack([mode.matrix * scale, mode.constant]) / scale[:, None]
    guards = np.column_stack([mode.guards[:, :-1] * scale, mode.guards[:, -1]])
    if guards.size:
        guards /= np.exp2(np.round(np.log2(np.abs(guards).max(axis=1, keepdims=True))))
    tables, push, law = [field, guards], (), ()
    if mode.friction:
        *rows, push, law = mode.friction
        tables.append(np.array(rows) * [*scale, 1.0])
        push = tuple(push / scale)
    arc = copy(_compiled(*(tuple(map(tuple, table != 0)) for table in tables), push=push, law=law, tolerance=tolerance))
    arc.pars[:] = np.concatenate([table[table != 0] for table in tables])
    return arc


@cache
def _compiled(*rows: Pattern, push: tuple[float, ...], law: tuple[float, ...], tolerance: float) -> hy.taylor_adaptive:
    """Integrator of a mode with terminal events where guards fall through zero; ``rows``: where those of its field, of
    its guards and of its friction are not zero; these numbers are parameters, those of the law are constants.
    """
    states = hy.make_vars(*(f"x{k}" for k in range(len(rows[0]))))
    parameters = (hy.par[k] for k in range(sum(sum(row) for table in rows for row in table)))
    right, guards, *friction = ([_affine(row, states, parameters) for row in table] for table in rows)
    for sigma, force in friction:
        rubbed = eta(sigma, law, hy.exp) * force
        right = [x + weight * rubbed if weight else x for x, weight in zip(right, push, strict=True)]
    # No cooldown: of a guard that has just fired the driver has made sure that it is not about to fall, and a root at
    # which it rises has the other direction.
    events = [hy.t_event(x + _NUDGE, direction=hy.event_direction.negative, cooldown=0.0) for x in guards]
    return hy.taylor_adaptive(
        list(zip(states, right, strict=True)), [0.0] * len(states), t_events=events, tol=tolerance
    )


def _affine(row: tuple[bool, ...], states: list, parameters: Iterator) -> hy.expression:
    """Sum of parameters times coordinates, and of one more parameter, where they are not zero."""
    factors = [*states, hy.expression(1.0)]
    return hy.sum([next(parameters) * factor for there, factor in zip(row, factors, strict=True) if there])
