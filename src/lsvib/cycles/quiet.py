"""How long a motion with more than two states surely meets no guard, by the parts of its mode.

The search for events walks in steps on which it bounds whole guards. Where rates lie far apart, or an oscillation that
hardly decays has just touched a guard, these steps stay short, and a search may take more of them than is allowed.
Here every guard is taken apart: with the rates λ_j of the mode and the parts g_j of the guard,

    g(t) = g_0 + Σ Re(g_j e^{λ_j t}).

On a step [a, b] a part with |λ_j| (b − a) < √8 bends away from its chord by |g_j λ_j²| (b − a)² / 8 at most, and any
other part stays within its size |g_j| e^{Re λ_j t}. So steps grow as the parts that turn fast die away, or as the sum
of all parts leaves the guard room.
"""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from lsvib.cycles.kernels.quiet_walk import walk
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.columns import A0, A1, ALPHA, BETA, R1, R2
from lsvib.engine.kernels.tables import BlockFlow, ModalFlow
from lsvib.engine.motion import Budget

_ZERO = 1e-13  # part of the size of a block below which an eigenvalue of it is rounding
_UNSURE = 1e-14  # the same for its real part, of which only the sign matters
_DUST = 1e-60  # part of the largest entry of all blocks that is what 120 digits leave of zero
_NONE = 1e-25  # part of the fastest rate below which a rate is none: blocks are made from 120 digits
_CHAIN = 3  # longest chain of zeros: 1, t and t²
_PARALLEL = 1e10  # condition of eigenvectors that leaves parts some digits
_LOST = 1e-14  # of parts, relative, times that condition
_STEPS = 2000  # of one walk
_START, _STEP = 300.0, 0.5  # work of a walk and of each of its steps: 600 microseconds and one
_TURN = 8.0  # angle of the fastest part that a step must have: the search itself takes shorter ones, in less time
_END = 1e15  # of the time of the slowest part; a motion that meets no guard until then has died away long before


# Matrix (d, d), its rates (d) and eigenvectors (d, d), none of a chain of zeros, coordinates (d), way back (n, d).
Uncoupled = tuple[np.ndarray, tuple[np.ndarray, np.ndarray] | None, np.ndarray, np.ndarray]


class Parts(NamedTuple):
    """A motion in one mode, part by part.

    ``rates`` (q) [1/s], none of them zero; ``along`` (n, q), the parts of the state; ``drift`` (n, 3), the factors of
    1, t and t² in what has no rate; ``condition`` [1] of the eigenvectors that they come from.
    """

    rates: np.ndarray
    along: np.ndarray
    drift: np.ndarray
    condition: float


def parts_of(flow: ModalFlow | BlockFlow, mode: int, state: np.ndarray) -> Parts | None:
    """Return the parts of the motion from a state (n) in a mode; None if two rates are too near to tell apart."""
    place = np.append(state, 1.0)
    in_blocks = isinstance(flow, BlockFlow)
    drift = np.zeros((state.size, 3))
    drift[:, 0] = (flow.from_blocks if in_blocks else flow.from_modal)[mode][:, -1]
    rates, along, condition = [np.zeros(0)], [np.zeros((state.size, 0))], 1.0
    try:
        blocks = list(_blocks(flow, mode, place) if in_blocks else _modes(flow, mode, place))
    except np.linalg.LinAlgError:  # a rate beside what winds up is zero, too
        return None
    for matrix, own, start, out in blocks:
        if own is None:  # a chain of zeros
            once = matrix @ start
            drift += out @ np.column_stack([start, once, 0.5 * matrix @ once])
            continue
        values, vectors = own
        if (values == 0).sum() > 1:  # they may be a chain, of which the eigenvectors show nothing
            return None
        scales = np.abs(vectors).max(axis=1, keepdims=True)
        if not (scales > 0).all():
            return None
        condition = max(condition, float(np.linalg.cond(vectors / scales)))
        if not condition < _PARALLEL:
            return None
        moved = (out @ vectors) * np.linalg.solve(vectors.astype(complex), start)
        drift[:, 0] += moved[:, values == 0].real.sum(axis=1)
        rates.append(values[values != 0])
        along.append(moved[:, values != 0])
    found = Parts(np.concatenate(rates).astype(complex), np.concatenate(along, axis=1), drift, condition)
    return found if np.isfinite(found.along).all() and np.isfinite(drift).all() else None


def _blocks(flow: BlockFlow, mode: int, place: np.ndarray) -> Iterator[Uncoupled]:
    """Yield the blocks of a mode from a state and 1 (n + 1).

    A real part of which rounding leaves no sign is made positive, so that nothing is told from it for ever.
    """
    start, largest = flow.to_blocks[mode] @ place, np.abs(flow.matrix[mode]).max()
    for first, last in pairwise(flow.edges[mode]):
        if first == last:
            continue
        block, out = flow.matrix[mode, first:last, first:last], flow.from_blocks[mode][:, first:last]
        block, here = np.where(np.abs(block) <= _DUST * largest, 0.0, block), start[first:last]
        size = np.abs(block).max()
        unit = block / size if size > 0 else block
        if np.abs(unit @ unit @ unit).max() <= _NONE:
            yield block, None, here, out
            continue
        winds = _winds(block)
        if winds.any():  # y = T z + what decays by itself, with y′ = A y + C z, z′ = N z and A T + C = T N
            own, push, chain = block[~winds][:, ~winds], block[~winds][:, winds], block[winds][:, winds]
            once = np.linalg.solve(own, push)
            twice = np.linalg.solve(own, once @ chain)
            along = -once - twice - np.linalg.solve(own, twice @ chain)
            yield chain, None, here[winds], out[:, winds] + out[:, ~winds] @ along
            block, here, out = own, here[~winds] - along @ here[winds], out[:, ~winds]
            size = np.abs(block).max()
        values, vectors = np.linalg.eig(block)
        real = np.where(np.abs(values.real) <= _UNSURE * size, _UNSURE * size, values.real)
        moves = np.abs(values) > max(_ZERO * size, _NONE * largest)
        yield block, (np.where(moves, real + 1j * values.imag, 0.0), vectors), here, out


def _winds(block: np.ndarray) -> np.ndarray:
    """Return the coordinates (d) of a block that are polynomials of time whatever the others do, such as u at rest.

    Up to t² they are chains of three, as those of a block without any other coordinate.
    """
    found = np.zeros(len(block), dtype=bool)
    for _ in range(_CHAIN):
        found = ~block[:, ~found].any(axis=1)
    return found


def _modes(flow: ModalFlow, mode: int, place: np.ndarray) -> Iterator[Uncoupled]:
    """Yield the pairs and singles of a mode; a single with a push of its own has a constant beside it."""
    start, ways, k = flow.to_modal[mode] @ place, flow.from_modal[mode], 0
    for row in flow.oscillators[mode, : flow.pairs[mode]]:
        values = np.array([row[R1], row[R2]], dtype=complex)
        if row[BETA] > 0:
            values = -row[ALPHA] + 1j * row[BETA] * np.array([1.0, -1.0])
        matrix = np.array([[0.0, 1.0], [-row[A0], -row[A1]]])
        chain = None if row[A0] == row[A1] == 0 else (values, np.array([np.ones(2), values]))
        yield matrix, chain, start[k : k + 2], ways[:, k : k + 2]
        k += 2
    for rate, push in zip(flow.rates[mode, : flow.singles[mode]], flow.pushes[mode], strict=False):
        matrix, here = np.array([[rate, push], [0.0, 0.0]]), np.array([start[k], 1.0])
        out = np.column_stack([ways[:, k], np.zeros(len(ways))])
        vectors = np.array([[1.0, -push / rate], [0.0, 1.0]]) if rate else None
        yield matrix, None if vectors is None else (np.array([rate, 0.0]), vectors), here, out
        k += 1


class Guards(NamedTuple):
    """Guards of a mode along a motion: ``drift`` (g, 3), ``parts`` (g, q) with ``rates`` (q), ``sizes`` (g, 3) of both.

    The sizes are those of the terms that the drift is summed from, with the parts among the first; ``lost`` [1] is the
    share of them that is rounding.
    """

    drift: np.ndarray
    parts: np.ndarray
    rates: np.ndarray
    sizes: np.ndarray
    lost: float


def guards_along(automaton: Automaton, mode: int, found: Parts) -> Guards:
    """Take the guards of a mode apart."""
    tables = automaton.tables
    guards = range(tables.guard_start[mode], tables.guard_start[mode + 1])
    rows = np.array([tables.guard_sign[k] * tables.surfaces[tables.guard_surface[k]] for k in guards])
    parts, drift = rows[:, :-1] @ found.along, rows[:, :-1] @ found.drift
    sizes = np.abs(rows[:, :-1]) @ np.abs(found.drift)
    drift[:, 0] += rows[:, -1]
    sizes[:, 0] += np.abs(rows[:, -1]) + np.abs(rows[:, :-1]) @ np.abs(found.along).sum(axis=1)
    return Guards(drift, parts, found.rates, sizes, _LOST * found.condition)


def quiet_until(automaton: Automaton, mode: int, state: np.ndarray, budget: Budget) -> float:
    """Return a time [s] up to which a motion from a state (n) in a mode surely meets no guard; it may be infinite.

    It is zero where that cannot be told. Raises ``WorkSpentError`` if the budget does not suffice.
    """
    budget.spend(_START)
    found = parts_of(automaton.tables.flow, mode, state)
    if found is None:
        return 0.0
    guards = guards_along(automaton, mode, found)
    if found.rates.size == 0:
        return _quiet_drift(guards)
    fastest, slowest = np.abs(guards.rates).max(), np.abs(guards.rates).min()
    time, steps = walk(*guards, _TURN / fastest, _END / slowest, _STEPS)
    budget.spend(_STEP * steps)
    return float(time)


def _quiet_drift(guards: Guards) -> float:
    """Return :func:`quiet_until` of a motion without any rate, such as a rest: its guards are polynomials of time.

    What is below each of them by its rounding falls to zero at a known time. A guard that is zero for ever never falls.
    """
    until = math.inf
    for drift, sizes in zip(guards.drift, guards.sizes, strict=True):
        if not drift.any():
            continue
        lower = drift - guards.lost * sizes
        if not lower[0] > 0:
            return 0.0
        roots = np.roots(lower[::-1])
        until = min([until, *roots[(roots.imag == 0) & (roots.real > 0)].real])
    return float(until)


def beats(automaton: Automaton, mode: int, state: np.ndarray) -> bool:
    """Whether undamped oscillations of different frequencies reach beyond a guard together.

    If their frequencies are incommensurate their phases come as near to any others as one likes (Kronecker's theorem),
    so that the motion meets the guard some time, however late.
    """
    found = parts_of(automaton.tables.flow, mode, state)
    if found is None or found.drift[:, 1:].any():
        return False
    guards = guards_along(automaton, mode, found)
    lasting = (guards.rates.real == 0) & (guards.rates.imag > 0)
    if np.unique(guards.rates[lasting].imag).size < 2:
        return False
    sizes = 2 * np.abs(guards.parts[:, lasting])
    return bool((sizes.sum(axis=1) > guards.drift[:, 0] + guards.lost * guards.sizes[:, 0]).any())
