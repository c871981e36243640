r"""Motions that shrink to steady sliding on the surface N = 0, or grow for ever, turn by turn alike.

Where steady sliding carries no force, as with R = 0, both laws of slip have their equilibrium on the surface between
them. As long as a motion passes only such surfaces, its return map is homogeneous: P(λ y) = λ P(y) for λ > 0. So n
returns that lead to a smaller copy, Pⁿ(y) = λⁿ y with λ < 1, are followed by their copies for ever: the motion ends in
steady sliding, whatever number of returns that takes. Guards that do not pass through the equilibrium are not met,
because such a guard is positive at the equilibrium and at the state, and so on the whole line between them.
The direction of y need not be exact if it is attracted. By Euler's theorem P′ y = P(y), so that at an exact direction λ
is a multiplier of P; the direction is attracted if all others are well below it.

Far out the constants of modes and surfaces are next to none, and the return map is homogeneous as well. A motion that
grows there, in a direction that attracts, grows for ever, if the model lets energy grow: of compliant threads.

Where several parts shrink alike no direction is attracted. Then leaps lead to smaller and smaller states
(:mod:`lsvib.cycles.drift_more_states`), and a motion that has dwindled by so much that rounding would have grown
instead, if it could, ends in steady sliding as well. That is evidence, not a proof.
"""

from typing import NamedTuple

import numpy as np

from lsvib.cycles.return_section import ROUNDING, Section, section_key
from lsvib.cycles.steady_states import Attractor, SteadyState, out_of_range
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar
from lsvib.engine.motion import Budget, Motion

_CLEAR = 16 * flow_planar.EPS  # rounding of a return, in sizes of the motion, for each event and unit of the condition
_ALIKE = 0.1  # part of 1 − λⁿ and of λⁿ by which n returns may differ from λⁿ y, in sizes of y
_FEWEST = 8  # returns to the section: the later half of them is compared
_INSIDE = 0.9  # largest other multiplier, relative to λ: the direction is reached in a few dozen returns
_LEADING = 1e-3  # relative difference of the leading multiplier from λ: the direction is exact but for less than that
# Part of the terms of a field or a guard that its constant may be where it is far out. It moves a direction that
# attracts by so little, and less from turn to turn.
_FAR_OUT = 1e-6
_GROWN = 3.0  # factor by which speeds and mismatch have grown within a part of a motion in which no cycle is looked for
# Part of its size to which a motion has dwindled: what does not shrink is there at least as rounding, 1e-16 of the
# rest, and would be all that is left after half as many decades.
_DWINDLED = 1e-30


def shrinking(motion: Motion, budget: Budget) -> SteadyState | None:
    """Return steady sliding if the last returns of a motion with more than two states show that it shrinks to that."""
    automaton, turns = motion.automaton, _turns(motion)
    if turns is None or automaton.tables.flow.field[turns.modes[-turns.period :], :, -1].any():
        return None
    last = zip(turns.modes[-turns.period :], turns.states[-turns.period :], strict=True)
    if not all(_through_zero(motion, *one) for one in last) or not _growth(automaton, turns, budget) < 0:
        return None
    return SteadyState(Attractor.STEADY_SLIDING, np.zeros(motion.end_state.size))


def growing(motion: Motion, budget: Budget) -> SteadyState | None:
    """Return that a motion is unbounded if its last returns show it, far beyond all constants of the drive."""
    automaton = motion.automaton
    if automaton.passive or not _far_out(motion, np.abs(motion.after).max(axis=0, initial=0.0)):
        return None
    turns = _turns(motion)
    if turns is None or not _far_out(motion, np.abs(turns.states[: turns.period]).max(axis=0)):
        return None
    return out_of_range(automaton, motion.end_state) if _growth(automaton, turns, budget) > 0 else None


def has_grown(motion: Motion) -> bool:
    """Whether a motion that may grow for ever has grown so much in its later half that no cycle is near.

    The angle by which the coupling is wound up need not have grown.
    """
    if motion.automaton.passive or motion.time.size < 2:
        return False
    early, late = (np.abs(half).max(axis=0) for half in np.array_split(motion.after, 2))
    return bool((late[1:] > _GROWN * early[1:]).all())


class _Turns(NamedTuple):
    """The later half of the returns of a motion to a section, all with the same events.

    ``states`` (k + 1, n) are those after the events from the first return to the last one, ``modes`` (k) those after
    all but the last; a return has ``period`` events, and all of them take ``duration`` [s].
    """

    key: tuple[int, int]
    states: np.ndarray
    modes: np.ndarray
    period: int
    duration: float


def _turns(motion: Motion) -> _Turns | None:
    """Return the later half of the returns of a motion if they are alike and no event moves the state."""
    key = section_key(motion)
    if key is None:
        return None
    at = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    if at.size < _FEWEST:
        return None
    first, last, period = at[at.size // 2], at[-1], int(at[-1] - at[-2])
    states, modes = motion.after[first : last + 1], motion.mode[first:last]
    if modes.size % period or (modes != np.tile(modes[-period:], modes.size // period)).any():
        return None
    around = np.abs(motion.before[first + 1 : last + 1]) + np.abs(states[1:])
    if (np.abs(motion.before[first + 1 : last + 1] - states[1:]) > ROUNDING * around.max(axis=0)).any():
        return None
    return _Turns(key, states, modes, period, float(motion.time[last] - motion.time[first]))


def _growth(automaton: Automaton, turns: _Turns, budget: Budget) -> float:
    """Return λⁿ − 1 of turns that lead to a copy λⁿ y of a state y, beyond rounding; 0 if y does not attract."""
    states, modes = turns.states, turns.modes
    size = np.abs(states).max(axis=0)
    size[size == 0] = 1.0  # a coordinate that is zero at every event may have any scale
    start, change = states[0] / size, (states[-1] - states[0]) / size
    growth = float(start @ change / (start @ start))
    rounding = _CLEAR * automaton.condition * modes.size
    unlike = np.abs(change - growth * start).max() / np.abs(start).max()
    if not (growth > -1 and abs(growth) > rounding and unlike <= _ALIKE * min(abs(growth), 1 + growth)):
        return 0.0
    section = Section(automaton, turns.key, states[-1], size, 1, turns.duration, budget)
    slopes, _ = section.slopes(np.zeros(section.dimension))
    if not np.isfinite(slopes).all():
        return 0.0
    *others, leading = np.sort(np.abs(np.linalg.eigvals(slopes)))
    factor = (1 + growth) ** (turns.period / modes.size)  # λ
    attracted = abs(leading - factor) <= _LEADING * factor and all(other < _INSIDE * factor for other in others)
    return growth if attracted else 0.0


def _far_out(motion: Motion, size: np.ndarray) -> bool:
    """Whether a motion of a size (n) hardly feels the constants of the modes that it passes, nor of any surface."""
    tables = motion.automaton.tables
    rows = np.concatenate([*tables.flow.field[np.unique(motion.mode)], tables.surfaces])
    return bool((np.abs(rows[:, -1]) <= _FAR_OUT * (np.abs(rows[:, :-1]) @ size)).all())


class Dwindling:
    """The largest size that a motion has had since it passes only modes and surfaces without constants."""

    def __init__(self, automaton: Automaton) -> None:
        self._size = np.zeros(len(automaton.states))
        self._never = bool(automaton.tables.flow.field[:, :, -1].any(axis=1).all())  # every mode has constants

    def done(self, motion: Motion) -> bool:
        """Whether the next part of a motion shows that it dwindles to nothing."""
        if self._never or not motion.time.size or not keeps_proportion(motion):
            self._size[:] = 0.0
            return False
        early, late = (np.abs(half).max(axis=0, initial=0.0) for half in np.array_split(motion.after, 2))
        self._size = np.maximum(self._size, early)
        return bool((late <= _DWINDLED * self._size).all() and (late <= early).all() and (late < early).any())


def keeps_proportion(motion: Motion) -> bool:
    """Whether a motion passes only modes and surfaces without constants: then it grows, shrinks or stays as it is."""
    tables = motion.automaton.tables
    if tables.flow.field[np.unique(motion.mode), :, -1].any():
        return False
    rows = tables.surfaces[tables.surfaces[:, -1] != 0]
    values = motion.after @ rows[:, :-1].T + rows[:, -1]
    sizes = np.abs(motion.after) @ np.abs(rows[:, :-1]).T + np.abs(rows[:, -1])
    return bool((np.abs(values) > ROUNDING * sizes).all())


def _through_zero(motion: Motion, mode: int, state: np.ndarray) -> bool:
    """Whether all surfaces on which a mode ends in a state pass through zero, and the mode holds there."""
    tables = motion.automaton.tables
    guards = slice(tables.guard_start[mode], tables.guard_start[mode + 1])
    rows = tables.guard_sign[guards, None] * tables.surfaces[tables.guard_surface[guards]]
    values = rows[:, :-1] @ state + rows[:, -1]
    met = np.abs(values) <= ROUNDING * (np.abs(rows[:, :-1]) @ np.abs(state) + np.abs(rows[:, -1]))
    return bool(met.any() and not rows[met, -1].any() and (rows[:, -1] >= 0).all())
