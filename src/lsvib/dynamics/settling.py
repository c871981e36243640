"""What a motion ends in that stays in one mode for ever."""

import math

import numpy as np

from lsvib.dynamics.attractor import Attractor, SteadyState, out_of_range
from lsvib.dynamics.poincare_map import ROUNDING
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import layout
from lsvib.engine.motion import Motion, follow

# Damping over frequency that is zero: modes of two states are rounded once, others are made from 60 digits, which leave
# less than the second number.
_UNDAMPED = (0.0, 1e-30)


def settled(automaton: Automaton, motion: Motion) -> SteadyState:
    """Return the attractor of a motion that never leaves its last mode.

    The mode is a sum of oscillators: one with two states, one for each pair of rates with more. The attractor is rest
    in a mode at rest; steady sliding if every excited oscillator is damped; unbounded if one of them grows – unresolved
    where energy is bounded, since only rounding hides the next event –; and a
    neutral family if one of them goes on for ever. The family has a period if only one does: several frequencies have
    none in common. With more than two states a damping below 1e-30 of the frequency counts as none.
    """
    flow, mode, state = automaton.tables.flow, motion.end_mode, motion.end_state
    if automaton.codes[mode] in automaton.rest_codes:
        return SteadyState(Attractor.REST, state)
    if isinstance(flow, np.ndarray):
        rows, equilibrium = flow[mode][None], np.array([flow[mode, layout.EQUILIBRIUM], 0.0])
        excited = np.array([(state != equilibrium).any()])
    else:
        pairs = flow.pairs[mode]
        rows, table = flow.oscillators[mode, :pairs], flow.to_modal[mode, : 2 * pairs + flow.singles[mode]]
        equilibrium = _equilibrium(flow.field[mode])
        rounding = ROUNDING * (np.abs(table[:, :-1]) @ np.abs(state) + np.abs(table[:, -1]))
        moved = np.abs(table[:, :-1] @ state + table[:, -1]) > rounding
        if (moved[2 * pairs :] & (flow.rates[mode, : flow.singles[mode]] > 0)).any():
            return out_of_range(automaton, state)
        excited = moved[: 2 * pairs].reshape(-1, 2).any(axis=1)
    damping = rows[:, layout.ALPHA]
    undamped = np.abs(damping) <= _UNDAMPED[state.size > 2] * rows[:, layout.BETA]
    if (excited & ~undamped & (damping < 0)).any():
        return out_of_range(automaton, state)
    lasting = np.flatnonzero(excited & undamped & (rows[:, layout.BETA] > 0))
    if lasting.size == 0:
        return SteadyState(Attractor.STEADY_SLIDING, equilibrium)
    if lasting.size > 1:
        return SteadyState(Attractor.NEUTRAL_FAMILY, state, multiplier=1.0)
    orbit = follow(automaton, state, 2 * math.pi / rows[lasting[0], layout.BETA], mode=mode)
    return SteadyState(Attractor.NEUTRAL_FAMILY, state, orbit, 1, 0.0, 0.0, 1.0)


def _equilibrium(field: np.ndarray) -> np.ndarray:
    """Return where A x + b = 0 (n), from the field (n, n + 1) of a mode.

    If doubles do not tell its rows apart, that is the solution with no share of what they leave open: deviations from
    steady sliding, which is zero.
    """
    try:
        return np.linalg.solve(field[:, :-1], -field[:, -1])
    except np.linalg.LinAlgError:
        return np.linalg.lstsq(field[:, :-1], -field[:, -1])[0]
