"""The attractor of a motion with more than two states."""

import math

import numpy as np

from lsvib.dynamics.attractor import Doubt, SteadyState, out_of_range
from lsvib.dynamics.leaps import leaps
from lsvib.dynamics.recurrences import recurrence
from lsvib.dynamics.settling import settled
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import Budget, Motion, enter, follow
from lsvib.errors import DivergenceError, EngineError, WorkSpentError

CHUNK = 64  # events that are looked at first; every further look takes twice as many
LONG = 1000  # events after which returns that hardly move are leapt over
_LONGEST = 16_000  # events in a look
_SAME = 0.01  # relative difference of the sizes of two halves of a motion that hardly changes


def at_equilibrium(automaton: Automaton, state: np.ndarray) -> bool:
    """Whether a motion with more than two states starts in steady sliding, to the last bit."""
    if state.size == 2 or state.any():
        return False
    return not automaton.tables.flow.field[enter(automaton, state)[0], :, -1].any()


def of_more_states(automaton: Automaton, state: np.ndarray, mode: int | None, budget: Budget) -> SteadyState:
    """Find the attractor of a motion with more than two states, with the work of a budget.

    The motion is followed until it settles, or its return map has an attracting fixed point that it approaches. After a
    thousand events it leaps over returns that hardly move (:mod:`lsvib.dynamics.leaps`).
    """
    used, chunk, motion = 0, CHUNK, None
    try:
        while True:
            motion = follow(automaton, state, math.inf, mode=mode, max_events=chunk, budget=budget)
            if motion.status == Status.SETTLED:
                return settled(automaton, motion)
            if motion.status == Status.WORK_SPENT:
                return SteadyState.unresolved(motion.end_state, Doubt.WORK_BUDGET)
            found = recurrence(automaton, motion, budget)
            if found is not None:
                return found
            state, mode, used = motion.end_state, motion.end_mode, used + motion.time.size
            chunk = min(2 * chunk, _LONGEST)
            further = leaps(motion, budget) if used >= LONG else None
            if further is not None:
                state, mode, chunk = further.state, further.mode, LONG
    except DivergenceError:
        return out_of_range(automaton, state)
    except WorkSpentError:
        return SteadyState.unresolved(state, Doubt.RECURRENT if _hardly_changes(motion) else Doubt.EVENT_BUDGET)
    except EngineError as error:
        return SteadyState.unresolved(state, error)


def _hardly_changes(motion: Motion | None) -> bool:
    """Whether both halves of a motion have the same size in every coordinate."""
    if motion is None or motion.time.size < LONG:
        return False
    first, last = (np.abs(half).max(axis=0) for half in np.array_split(motion.after, 2))
    return bool((np.abs(last - first) <= _SAME * np.maximum(first, last)).all())
