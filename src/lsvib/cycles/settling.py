"""What a motion ends in that stays in one mode for ever; and when one carried in blocks does, by the rates of its mode.

The search for events proves that a motion settles from bounds of whole blocks
(:mod:`lsvib.engine.kernels.flow_blocks`). A block that holds the constant of the field, or rates far apart, has a bound
that grows although nothing in it does, so the proof fails and the search goes on for ever. Here the parts of a guard
along the eigenvectors of each block are taken one by one: with the rates λ_j and the parts g_j of the guard at the
start, it stays above  g_0 − Σ |g_j| e^{Re λ_j t}.
"""

import math
from itertools import pairwise

import numpy as np

from lsvib.cycles.return_map import ROUNDING
from lsvib.cycles.steady_states import Attractor, SteadyState
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import columns
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Motion, follow

_ZERO = 1e-13  # part of the size of a block below which an eigenvalue of it is rounding
_NONE = 1e-25  # part of the fastest rate below which a rate is none: blocks are made from 120 digits
_PARALLEL = 1e10  # condition of eigenvectors that leaves parts some digits
_LOST = 1e-14  # of parts, relative, times that condition
_DOUBLINGS = 200  # of the time that is tried; the first is that of the fastest rate
_UNDAMPED = 1e-30  # damping over frequency that is zero: a mode is made from 60 digits, which leave less than that


def settles_after(automaton: Automaton, mode: int, state: np.ndarray) -> float | None:
    """Return the time [s] from which on no guard of a mode can fire; None if that cannot be told.

    None as well if a part of the motion from ``state`` (n) grows, or goes on for ever.
    """
    flow, tables = automaton.tables.flow, automaton.tables
    if not isinstance(flow, BlockFlow) or automaton.codes[mode] in automaton.rest_codes:
        return None
    found = _parts(flow, mode, np.append(state, 1.0))
    if found is None:
        return None
    rates, along, condition = found
    guards = range(tables.guard_start[mode], tables.guard_start[mode + 1])
    rows = np.array([tables.guard_sign[k] * tables.surfaces[tables.guard_surface[k]] for k in guards])
    parts = rows[:, :-1] @ along
    constant = np.abs(rates) == 0
    levels = rows[:, -1] + rows[:, :-1] @ flow.from_blocks[mode][:, -1] + parts[:, constant].real.sum(axis=1)
    lost = _LOST * condition * (np.abs(rows[:, -1]) + np.abs(parts).sum(axis=1))
    sizes, decays = np.abs(parts[:, ~constant]), rates[~constant].real
    if not (levels > lost).all():
        return None
    time = 1.0 / np.abs(rates).max()
    for _ in range(_DOUBLINGS):
        if (sizes @ np.exp(decays * time) < levels - lost).all():
            return time
        time *= 2.0
    return None


def _parts(flow: BlockFlow, mode: int, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Return the rates (q) of a mode, the parts (n, q) of a state along their eigenvectors, and these' condition.

    One rate is zero, that of the constant. None if another one does not decay, or eigenvectors are nearly parallel.
    """
    edges = flow.edges[mode]
    start = flow.to_blocks[mode] @ state
    rates, along, condition = [], [], 1.0
    for first, last in pairwise(edges):
        if first == last:
            continue
        block, out = flow.matrix[mode, first:last, first:last], flow.from_blocks[mode][:, first:last]
        values, vectors = np.linalg.eig(block)
        condition = max(condition, float(np.linalg.cond(vectors)))
        if not condition < _PARALLEL:
            return None
        values = np.where(np.abs(values) <= _ZERO * np.abs(block).max(), 0.0, values)
        rates.append(values)
        along.append((out @ vectors) * np.linalg.solve(vectors.astype(complex), start[first:last]))
    found, moved = np.concatenate(rates), np.concatenate(along, axis=1)
    found = np.where(np.abs(found) <= _NONE * np.abs(found).max(), 0.0, found)
    if np.count_nonzero(found == 0) > 1 or not (found[found != 0].real < 0).all():
        return None
    return (found, moved, condition) if all(math.isfinite(x) for x in np.abs(moved).ravel()) else None


def settled(automaton: Automaton, motion: Motion) -> SteadyState:
    """Return the attractor of a motion that never leaves its last mode.

    The mode is a sum of oscillators: one with two states, one for each pair of rates with more. The attractor is rest
    in a mode at rest; steady sliding if every excited oscillator is damped; unbounded if one of them grows; and a
    neutral family if one of them goes on for ever. The family has a period if only one does: several frequencies have
    none in common.
    """
    flow, mode, state = automaton.tables.flow, motion.end_mode, motion.end_state
    if automaton.codes[mode] in automaton.rest_codes:
        return SteadyState(Attractor.REST, state)
    if isinstance(flow, BlockFlow):  # such a mode settles only if everything that moves dies away
        field = flow.field[mode]
        return SteadyState(Attractor.STEADY_SLIDING, np.linalg.solve(field[:, :-1], -field[:, -1]))
    if isinstance(flow, np.ndarray):
        rows, equilibrium = flow[mode][None], np.array([flow[mode, columns.EQUILIBRIUM], 0.0])
        excited = np.array([(state != equilibrium).any()])
    else:
        pairs, field = flow.pairs[mode], flow.field[mode]
        rows, table = flow.oscillators[mode, :pairs], flow.to_modal[mode, : 2 * pairs + flow.singles[mode]]
        equilibrium = np.linalg.solve(field[:, :-1], -field[:, -1])
        rounding = ROUNDING * (np.abs(table[:, :-1]) @ np.abs(state) + np.abs(table[:, -1]))
        moved = np.abs(table[:, :-1] @ state + table[:, -1]) > rounding
        if (moved[2 * pairs :] & (flow.rates[mode, : flow.singles[mode]] > 0)).any():
            return SteadyState(Attractor.UNBOUNDED, state)
        excited = moved[: 2 * pairs].reshape(-1, 2).any(axis=1)
    damping = rows[:, columns.ALPHA]
    undamped = np.abs(damping) <= (ROUNDING if state.size == 2 else _UNDAMPED) * rows[:, columns.BETA]
    if (excited & ~undamped & (damping < 0)).any():
        return SteadyState(Attractor.UNBOUNDED, state)
    lasting = np.flatnonzero(excited & undamped & (rows[:, columns.BETA] > 0))
    if lasting.size == 0:
        return SteadyState(Attractor.STEADY_SLIDING, equilibrium)
    if lasting.size > 1:
        return SteadyState(Attractor.NEUTRAL_FAMILY, state, multiplier=1.0)
    orbit = follow(automaton, state, 2 * math.pi / rows[lasting[0], columns.BETA], mode=mode)
    return SteadyState(Attractor.NEUTRAL_FAMILY, state, orbit, 1, 0.0, 0.0, 1.0)
