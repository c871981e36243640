"""When a motion carried in blocks will no longer meet a guard, by the rates of its mode.

The search for events proves that a motion settles from bounds of whole blocks
(:mod:`lsvib.engine.kernels.flow_blocks`). A block that holds the constant of the field, or rates far apart, has a bound
that grows although nothing in it does, so the proof fails and the search goes on for ever. Here the parts of a guard
along the eigenvectors of each block are taken one by one: with the rates λ_j and the parts g_j of the guard at the
start, it stays above  g_0 − Σ |g_j| e^{Re λ_j t}.
"""

import math
from itertools import pairwise

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.tables import BlockFlow

_ZERO = 1e-13  # part of the size of a block below which an eigenvalue of it is rounding
_NONE = 1e-25  # part of the fastest rate below which a rate is none: blocks are made from 120 digits
_PARALLEL = 1e10  # condition of eigenvectors that leaves parts some digits
_ROUNDING = 1e-14  # of parts, relative, times that condition
_DOUBLINGS = 200  # of the time that is tried; the first is that of the fastest rate


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
    lost = _ROUNDING * condition * (np.abs(rows[:, -1]) + np.abs(parts).sum(axis=1))
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
