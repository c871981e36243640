"""The attractor of a motion with more than two states."""

import math

import numpy as np

from lsvib.cycles import drift_more_states
from lsvib.cycles.cones import growing, has_grown, keeps_proportion, shrinking
from lsvib.cycles.drift_more_states import LAST_WINDOW
from lsvib.cycles.family_edges import comes_to_edge
from lsvib.cycles.patience import FEW, follow_patiently, in_a_row
from lsvib.cycles.recurrences import long_cycle, recurrence
from lsvib.cycles.return_map import conserves
from lsvib.cycles.settling import settled
from lsvib.cycles.steady_states import Attractor, Doubt, SteadyState, out_of_range
from lsvib.cycles.trends import stays
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.status import Status
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Budget, Motion, enter
from lsvib.errors import DivergenceError, EngineError

CHUNK = 64  # events that are looked at first; every further look takes twice as many
LONG = 1000  # events after which returns that hardly move are leapt over
_LATER = 37  # events after which leaps begin again; no multiple of the number of events in a usual return
# Of its budget a motion is followed further at last, in blocks and elsewhere: one to three seconds at most; and this
# may be spent in all, so that no motion takes five seconds.
_FURTHER = (1.7, 1.1)
_IN_ALL = 2.7
_TURN = 0.1  # part of that work, more, with which turns that have grown alike are held against those beside them
_MANY = 4  # longest windows of trends in which a cycle is looked for then, and ...
_LEVEL = 3  # ... the last of them, which show that a motion without one has no trend
_EDGE = 0.1  # part of the budget in which a motion that nothing damps may come to the edge of a neutral family
_APART = 0.05  # change from return to return, in sizes of the motion, with which no cycle is near after many events


def at_equilibrium(automaton: Automaton, state: np.ndarray) -> bool:
    """Whether a motion with more than two states starts in steady sliding, to the last bit."""
    if state.size == 2 or state.any():
        return False
    return not automaton.tables.flow.field[enter(automaton, state)[0], :, -1].any()


def of_more_states(
    automaton: Automaton, state: np.ndarray, mode: int | None, budget: Budget, further: bool = True
) -> SteadyState:
    """Find the attractor of a motion with more than two states; a bit more than twice the budget may be spent.

    Where nothing is told by then, the motion is followed ``further``, from where it has come to without leaps: it may
    be about to settle, on a long cycle, or without trend since it has grown.
    """
    all_of_it, in_blocks = budget.left, isinstance(automaton.tables.flow, BlockFlow)
    in_all = _IN_ALL * all_of_it

    def ended(part: Motion, apart: float = _APART) -> SteadyState | None:
        """Return what a part of the motion shows it to end in; a motion that moves ``apart`` is on no cycle."""
        if part.status == Status.SETTLED:
            return settled(automaton, part)
        found = shrinking(part, budget) or growing(part, budget)
        return found if found is not None or has_grown(part) else recurrence(automaton, part, budget, apart)

    found: SteadyState | drift_more_states.Recurrence | None = None
    course: drift_more_states.Course | None = None
    if conserves(automaton):
        found = comes_to_edge(automaton, state, mode, Budget(_EDGE * all_of_it))
    doubt = Doubt.EVENTS
    used, chunk = 0, FEW if in_blocks else CHUNK
    try:
        while found is None and used < LONG:
            motion = follow_patiently(automaton, state, math.inf, mode=mode, max_events=chunk, budget=budget)
            found, state, mode = ended(motion, math.inf), motion.end_state, motion.end_mode
            used, chunk = used + motion.time.size, 2 * chunk
        if found is None:
            again, course = Budget(budget.left), drift_more_states.Course(motion)
            found = drift_more_states.pursue(course, budget, ended)
            if course.leapt and found is not None:  # a leap loses the phase of fast oscillations
                in_all, budget = in_all - (again.left - budget.left), again
                later = follow_patiently(automaton, state, math.inf, mode=mode, max_events=_LATER, budget=budget)
                second = drift_more_states.pursue(drift_more_states.Course(later), budget, ended)
                found, doubt = (found, doubt) if _name(second) == _name(found) else (None, Doubt.FORK)
    except DivergenceError:
        return out_of_range(automaton, state)
    except EngineError as error:
        found, doubt = None, Doubt.of(error)
    if found is None and doubt == Doubt.EVENTS and further:
        if course is not None and not course.leapt:
            state, mode = course.motion.end_state, course.motion.end_mode
        left = in_all - (all_of_it - budget.left)
        found = _further(automaton, state, mode, min(_FURTHER[0 if in_blocks else 1] * all_of_it, left))
    if isinstance(found, drift_more_states.Recurrence):
        return SteadyState(Attractor.RECURRENT, found.state)
    return found or SteadyState.unresolved(state, doubt)


def _further(
    automaton: Automaton, state: np.ndarray, mode: int | None, work: float
) -> SteadyState | drift_more_states.Recurrence | None:
    """Return what a motion settles in, its cycle of thousands of events, or its end without trend or cycle.

    None if none of these shows with that work. A motion that has come back to one state three times has twice as much
    again, to tell whether those beside it do.
    """
    budget, chunk, parts, windows = Budget(work), LONG, list[Motion](), 0
    try:
        while True:
            motion = follow_patiently(automaton, state, math.inf, mode=mode, max_events=chunk, budget=budget)
            if motion.status == Status.SETTLED:
                return settled(automaton, motion)
            found = growing(motion, Budget(_TURN * work))
            if found is not None:
                return found
            state, mode = motion.end_state, motion.end_mode
            if chunk < LAST_WINDOW:
                chunk = min(8 * chunk, LAST_WINDOW)
                continue
            parts, windows = [*parts[1 - _MANY :], motion], windows + 1
            grows = keeps_proportion(motion) and not conserves(automaton)
            recurs = len(parts) == _MANY and not grows and stays(parts[-_LEVEL:])
            if recurs or windows == 1 or windows % _MANY == 0:
                found = long_cycle(in_a_row(parts), Budget(2 * work))
                if found is not None or recurs:
                    return found or drift_more_states.Recurrence(state)
    except EngineError:  # the budget is spent, as a rule
        return None


def _name(found: SteadyState | drift_more_states.Recurrence | None) -> Attractor:
    """Return the label of a result of leaps."""
    if isinstance(found, SteadyState):
        return found.label
    return Attractor.UNRESOLVED if found is None else Attractor.RECURRENT
