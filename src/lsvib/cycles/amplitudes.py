"""The amplitudes of what a mode with more than two states is made of: oscillators, and what creeps.

A modal flow has them as its pairs and singles. A block of a flow in blocks holds rates that lie close together, and is
taken apart by its eigenvectors: y = Σ c_j v_j, where the c_j of conjugate rates are conjugate, and |c_j| is the
amplitude of an oscillator. Eigenvectors that are nearly parallel leave no such coordinates, and the block no parts.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from lsvib.engine.kernels.columns import ALPHA, BETA
from lsvib.engine.kernels.tables import BlockFlow, ModalFlow

_PARALLEL = 1e6  # condition of the eigenvectors of a block that leaves amplitudes ten digits
_TURNS = 1e-12  # part of the size of a block above which an imaginary part is none of its rounding


class Amplitudes(NamedTuple):
    """Oscillators of a mode, p of them, and s parts that die away or grow without turning, about their equilibrium.

    ``alpha`` (p) [1/s] is the damping of an oscillator and ``beta`` (p) [rad/s] its frequency, zero if it does not
    turn; ``rates`` (s) [1/s] are those of the others. ``into`` (2 p + s, n + 1) gives place and rate of an oscillator,
    and then the others, in a state and 1; ``out`` (n, 2 p + s) gives their part of the state.
    """

    alpha: np.ndarray
    beta: np.ndarray
    rates: np.ndarray
    into: np.ndarray
    out: np.ndarray

    def scaled(self, state: np.ndarray, factors: np.ndarray) -> np.ndarray:
        """Return a state (n) with the amplitudes of all oscillators, and the others, multiplied by factors (p + s)."""
        pairs = self.beta.size
        more = np.concatenate([np.repeat(factors[:pairs], 2), factors[pairs:]]) - 1
        return state + self.out @ (more * (self.into[:, :-1] @ state + self.into[:, -1]))


def amplitudes_of(flow: ModalFlow | BlockFlow, mode: int) -> Amplitudes:
    """Return the amplitudes of a mode, without those of parts that have no equilibrium, or one that lies far away."""
    if isinstance(flow, BlockFlow):
        return _of_blocks(flow, mode)
    pairs = int(flow.pairs[mode])
    own = np.flatnonzero((flow.pushes[mode] == 0) & (np.arange(flow.rates.shape[1]) < flow.singles[mode]))
    rows, places = flow.oscillators[mode, :pairs], np.concatenate([np.arange(2 * pairs), 2 * pairs + own])
    into, out = flow.to_modal[mode, places], flow.from_modal[mode][:, places]
    return Amplitudes(rows[:, ALPHA], rows[:, BETA], flow.rates[mode, own], into, out)


def _of_blocks(flow: BlockFlow, mode: int) -> Amplitudes:
    """Return the amplitudes of those oscillators of a mode in blocks that turn."""
    rates, into, out = list[complex](), list[np.ndarray](), list[np.ndarray]()
    for first, last in pairwise(flow.edges[mode]):
        if last - first < 2:
            continue
        block = flow.matrix[mode, first:last, first:last]
        values, vectors = np.linalg.eig(block)
        sizes = np.abs(vectors).max(axis=1, keepdims=True)
        if not sizes.all() or not np.linalg.cond(vectors / sizes) < _PARALLEL:
            continue
        rows = np.linalg.solve(vectors, flow.to_blocks[mode, first:last].astype(complex))
        columns = flow.from_blocks[mode, :, first:last] @ vectors
        for j in np.flatnonzero(values.imag > _TURNS * np.abs(block).max()):
            rate = values[j]
            rates.append(rate)
            # 2 Re(v c) with 2 c = y − i (y′ + α y) / β, so that y is the place of an oscillator and y′ its rate.
            into += [2 * rows[j].real, 2 * (rate * rows[j]).real]
            out += [columns[:, j].real - columns[:, j].imag * rate.real / rate.imag, columns[:, j].imag / rate.imag]
    found, n = np.array(rates, dtype=complex), flow.field.shape[1]
    into_all, out_all = np.reshape(into, (-1, n + 1)), np.reshape(np.transpose(out), (n, -1))
    return Amplitudes(-found.real, found.imag, np.zeros(0), into_all, out_all)
