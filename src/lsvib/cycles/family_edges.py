r"""Motions that nothing damps and that come to the edge of a neutral family.

A mode in which nothing damps has equilibrium values g of its guards, positive, and oscillations with the amplitudes A_i
in a guard. It is never left if all g > Σ A_i: such motions are a neutral family. With several frequencies all phases
are met, so that a motion beyond that reaches the guard again, the later the less it is beyond; and friction takes a
part of the rest each time, until nothing is left. The waits grow without bound: the motion is told by Σ A_i / g − 1,
which falls from stay to stay to a small part of what it was.
"""

import math
from itertools import pairwise

import numpy as np

from lsvib.cycles.patience import follow_patiently
from lsvib.cycles.steady_states import Attractor, SteadyState
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.columns import ALPHA, BETA
from lsvib.engine.kernels.tables import ModalFlow
from lsvib.engine.motion import Budget
from lsvib.errors import EngineError

_BEYOND = 1e-6  # Σ A_i / g − 1 with which a motion has come to the edge
_STAYS, _LESS = 4, 0.5  # over so many stays in the mode it has fallen each time, and to this part or less
_EVENTS = 200  # within which a motion comes there: it takes some dozens


def comes_to_edge(automaton: Automaton, state: np.ndarray, mode: int | None, budget: Budget) -> SteadyState | None:
    """Return the neutral family to whose edge a motion from a state (n) comes; None if it does not, with that work."""
    flow = automaton.tables.flow
    if not isinstance(flow, ModalFlow):
        return None
    lasting = (flow.pairs > 1) & (flow.singles == 0) & (flow.oscillators[:, :, ALPHA] == 0).all(axis=1)
    beyond: dict[int, list[float]] = {}
    for _ in range(_EVENTS if lasting.any() else 0):
        try:
            motion = follow_patiently(automaton, state, math.inf, mode=mode, max_events=1, budget=budget)
        except EngineError:  # the budget is spent, as a rule
            return None
        if motion.time.size == 0:
            return None
        state, mode = motion.end_state, motion.end_mode
        if lasting[mode]:
            seen = beyond.setdefault(mode, [])
            seen.append(_beyond(automaton, mode, state))
            last = seen[-_STAYS:]
            falls = all(0 < later < earlier for earlier, later in pairwise(last)) and last[-1] <= _LESS * last[0]
            if len(last) == _STAYS and falls and last[-1] <= _BEYOND:
                return SteadyState(Attractor.NEUTRAL_FAMILY, state, multiplier=1.0)
    return None


def _beyond(automaton: Automaton, mode: int, state: np.ndarray) -> float:
    """Return the largest Σ A_i / g − 1 of the guards of a mode; infinite if one has no g > 0."""
    tables, flow = automaton.tables, automaton.tables.flow
    turning = flow.oscillators[mode, : flow.pairs[mode], BETA]
    modal = flow.to_modal[mode, : 2 * turning.size, :-1] @ state + flow.to_modal[mode, : 2 * turning.size, -1]
    amplitudes = np.hypot(modal[0::2], modal[1::2] / turning)
    guards = slice(tables.guard_start[mode], tables.guard_start[mode + 1])
    rows = tables.guard_sign[guards, None] * tables.surfaces[tables.guard_surface[guards]]
    parts = rows[:, :-1] @ flow.from_modal[mode, :, : 2 * turning.size]
    swings = np.hypot(parts[:, 0::2], parts[:, 1::2] * turning) @ amplitudes
    field = flow.field[mode]
    values = rows[:, :-1] @ np.linalg.solve(field[:, :-1], -field[:, -1]) + rows[:, -1]
    return float(np.max(swings / values - 1)) if (values > 0).all() else math.inf
