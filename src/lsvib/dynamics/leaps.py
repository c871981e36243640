"""Leaps of a motion with more than two states along a return map that hardly moves it.

A drive with little damping may need 10⁹ events before it settles. While its returns to a section have the same events,
the return map P is smooth. With its derivative P′ at y and the step Δ from there, the state L returns later is
y + (1 + P′ + … + P′^(L−1)) Δ; this is exact if P is linear. L is doubled from leap to leap as long as the steps that
are found after a leap are those that were foreseen. This is numerical evidence, not a proof: a narrow attractor on the
way may be leapt over.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.dynamics.poincare_map import Section, section_key
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import WorkSpentError

_WRONG = 0.2  # part of its way by which a leap may be wrong
_FARTHEST = 2.0  # longest way of a leap, in sizes of the motion: once across a swing
_STILL = 1e-12  # a step of this size, in sizes of the motion, is rounding
_RETURNS = 8  # returns that are followed after a leap, in which its error dies away; the last three must be alike
_DOUBLINGS = 5  # of the returns in the shortest leap, which costs about sixteen returns
_MOST = 30  # leaps in a row, after which the motion may have come near a cycle
_EVENTS = 4000  # most events in a return


class Leapt(NamedTuple):
    """Where leaps have led: the state (n) and the mode there."""

    state: np.ndarray
    mode: int


def leaps(motion: Motion, budget: Budget) -> Leapt | None:
    """Leap along the section of a motion's rarest events as far as that goes; None if it goes nowhere."""
    key = section_key(motion)
    if key is None:
        return None
    seen = (motion.kind == key[0]) & (motion.mode == key[1])
    place, longest = motion.after[seen][-1], float(np.diff(motion.time[seen]).max(initial=0.0))
    found, last, pattern, doublings = None, None, None, _DOUBLINGS + 1
    for _ in range(_MOST):
        states, patterns, size = _returns(motion.automaton, key, place, budget)
        alike = len(states) > _RETURNS and all(one == (pattern or patterns[-1]) for one in patterns[-3:])
        if not (alike and (last is None or last.foresaw(states, doublings))):
            doublings -= 2
            if last is None or doublings < _DOUBLINGS:
                break
            place = last.after(doublings)
            continue
        if last is not None:
            found = Leapt(states[-1], key[1])
        pattern = patterns[-1]
        last = _Linear.at(Section(motion.automaton, key, states[-1], size, 1, longest, budget), states)
        doublings = last.most(doublings + 1)
        if doublings < _DOUBLINGS:
            break
        place = last.after(doublings)
    return found


class _Linear(NamedTuple):
    """The return map near a place: its derivative (d, d) on a section, and the last step (d) there.

    Where the map has no derivative, because a motion beside does not come back, it is taken to shift all places alike.
    """

    section: Section
    slopes: np.ndarray
    step: np.ndarray

    @classmethod
    def at(cls, section: Section, states: list[np.ndarray]) -> "_Linear":
        """Linearise at the last state, the origin of ``section``."""
        slopes, _ = section.slopes(np.zeros(section.dimension))
        if not np.isfinite(slopes).all():
            slopes = np.eye(section.dimension)
        return cls(section, slopes, slopes @ -section.place(states[-2]))

    def _ahead(self, doublings: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the way (d) of 2^doublings returns, and the step (d) after them."""
        total, power = np.eye(len(self.slopes)), self.slopes
        with np.errstate(over="ignore", invalid="ignore"):  # the caller refuses a way that is too long or not a number
            for _ in range(doublings):
                total, power = total + power @ total, power @ power
            return total @ self.step, power @ self.step

    def length(self, place: np.ndarray) -> float:
        """Return the size of a step (d) on the section, in sizes of the motion; infinite where it left the numbers."""
        if not np.isfinite(place).all():
            return math.inf
        return float((np.abs(self.section.directions) @ np.abs(place) / self.section.size).max(initial=0.0))

    def most(self, doublings: int) -> int:
        """Return how often, at most ``doublings`` times, the returns may be doubled before the way is too long."""
        if not self.length(self.step) > _STILL:
            return 0
        while doublings > 0 and not self.length(self._ahead(doublings)[0]) <= _FARTHEST:
            doublings -= 1
        return doublings

    def after(self, doublings: int) -> np.ndarray:
        """Return the state (n) 2^doublings returns later."""
        return self.section.state(self._ahead(doublings)[0])

    def foresaw(self, states: list[np.ndarray], doublings: int) -> bool:
        """Whether the steps after a leap show that its error is a small part of its way.

        A step that is off by ε along an eigenvector of P′ with the multiplier λ belongs to a place that is off by
        ε / (1 − λ), but not by more than ε times the number of returns.
        """
        way, step = self._ahead(doublings)
        with np.errstate(over="ignore", invalid="ignore"):  # slopes across a touched surface may be huge
            expected = np.linalg.matrix_power(self.slopes, _RETURNS - 1) @ step
        if not np.isfinite(expected).all():
            return False
        gap = self.section.place(states[-1]) - self.section.place(states[-2]) - expected
        values, vectors = np.linalg.eig(self.slopes)
        try:
            parts = np.linalg.solve(vectors, gap)
        except np.linalg.LinAlgError:
            return False
        parts = parts / np.maximum(np.abs(1 - values), 0.5**doublings)
        return self.length(np.abs(vectors * parts).sum(axis=1)) <= _WRONG * self.length(way)


def _returns(
    automaton: Automaton, key: tuple[int, int], state: np.ndarray, budget: Budget
) -> tuple[list[np.ndarray], list[bytes], np.ndarray]:
    """Follow some returns; return the states (n) at them, the modes of each return, and the size (n) of the last ones.

    There are fewer states where a return does not end, or takes all that is left of the budget.
    """
    states, patterns, sizes = [state], [], [np.zeros_like(state)]
    for _ in range(_RETURNS):
        part = Budget(budget.left / _RETURNS)  # a return that takes more leaves no work for the others
        given = part.left
        try:
            motion = follow(automaton, states[-1], math.inf, mode=key[1], stop=key, max_events=_EVENTS, budget=part)
        except WorkSpentError:
            break
        finally:
            budget.spend(given - max(part.left, 0.0))
        if motion.status != Status.STOP_EVENT:
            break
        states.append(motion.end_state)
        patterns.append(motion.mode.tobytes())
        sizes.append(np.abs(motion.after).max(axis=0))
    size = np.max(sizes[-3:], axis=0)
    return states, patterns, np.where(size == 0, 1.0, size)  # a coordinate that is always zero may have any scale
