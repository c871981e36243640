"""Work along the arcs of a motion, by Gauss–Legendre quadrature of the engine's own closed forms.

Panels grow from both ends of an arc, the first as wide as the fastest rate of the mode asks for, and are cut where a
vibration that has not died away would turn too far in them. Twelve nodes integrate exp of up to ±4 within a panel to
1e-16. Time is counted from the start of each arc: the clock of the whole motion would not resolve a fast transient.
"""

import math
from typing import NamedTuple

import numpy as np

from benchmarks.jit import allocating_kernel, kernel
from lsvib.engine.kernels import columns, dispatch
from lsvib.engine.kernels.flow_planar import ROUNDING
from lsvib.engine.motion import Motion

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)  # the error falls with the 24th power of a panel's width
_FIRST = 1.5  # width of the first panel, in units of the fastest time
_GROWTH = 1.7  # of the next ones
_TURN = 3.5  # [rad] of a vibration in a panel
_GONE = 40.0  # e-foldings after which a vibration has died away
# Of a motion; one that needs more, because its rates lie too far apart, is left without a balance.
_MOST_PANELS = 100_000
_EPS = float(np.finfo(float).eps)


class Terms(NamedTuple):
    """Energy and power of a motion as products of affine functions of the state x, each a row over x and 1.

    Energy Σ (energy·x)²; power Σ (left·x)(right·x) − Σ |pressing·x| sgn(direction·x) (sliding·x) + (holding·x)
    (approach·x); a seizure takes (seized·x)². Shapes (terms, n + 1), but ``pressing`` (terms, modes, n + 1),
    ``holding`` (modes, n + 1), ``approach`` and ``seized`` (n + 1); ``rates``: see :func:`rates`.
    """

    energy: np.ndarray
    left: np.ndarray
    right: np.ndarray
    pressing: np.ndarray
    direction: np.ndarray
    sliding: np.ndarray
    holding: np.ndarray
    approach: np.ndarray
    seized: np.ndarray
    rates: np.ndarray


def residual(motion: Motion, terms: Terms) -> tuple[float, float]:
    """Residual of the balance and what rounding may make of it, both relative to the largest energy or work in it."""
    modes, starts, ends, durations = motion.arcs()
    clock = np.concatenate([motion.time, [motion.end_time]])
    seized = np.isin(motion.kind, motion.automaton.sprag_kinds)
    flow = motion.automaton.tables.flow
    return _residual(flow, terms, terms.rates, modes, starts, ends, durations, clock, seized, _NODES, _WEIGHTS)


def rates(flow) -> np.ndarray:
    """Decay, frequency and size [1/s] of the rates of each mode, shape (modes, 3, n)."""
    if isinstance(flow, np.ndarray):
        alpha, beta, first, second = (flow[:, k] for k in (columns.ALPHA, columns.BETA, columns.R1, columns.R2))
        turns = beta > 0
        first, second = np.where(turns, -alpha, first), np.where(turns, -alpha, second)
        rates = np.array([first + 1j * beta, second - 1j * beta]).T
    else:
        rates = np.linalg.eigvals(flow.field[:, :, :-1])
    return np.stack([np.abs(rates.real), np.abs(rates.imag), np.abs(rates)], axis=1)


@kernel
def _at(row, x):
    """Value of an affine function of the state, and the sum of the sizes of its terms."""
    n = x.size
    value, size = row[n], abs(row[n])
    for i in range(n):
        value += row[i] * x[i]
        size += abs(row[i] * x[i])
    return value, size


@kernel
def _energy(terms, x):
    """Energy, and the sum of the sizes that it is rounded by."""
    total, rounding = 0.0, 0.0
    for k in range(terms.energy.shape[0]):
        value, size = _at(terms.energy[k], x)
        total += value * value
        rounding += 2.0 * abs(value) * size
    return total, rounding


@kernel
def _sign(row, x, otherwise):
    """Sign of an affine function of the state; ``otherwise`` where it is rounding only."""
    value, size = _at(row, x)
    return otherwise if abs(value) <= ROUNDING * size else math.copysign(1.0, value)


@kernel
def _power(terms, mode, x, ways, weight, work):
    """Add weight × each power to ``work``; return the power, and the sum of the sizes that it is rounded by.

    ``ways``: signs of the directions in the middle of the arc. Where a body has just begun to slip, the sign is lost
    when the state is rounded.
    """
    total, rounding, count = 0.0, 0.0, terms.left.shape[0]
    for k in range(count):
        left, left_size = _at(terms.left[k], x)
        right, right_size = _at(terms.right[k], x)
        work[k] += weight * left * right
        total += left * right
        rounding += abs(left) * right_size + left_size * abs(right)
    for k in range(terms.sliding.shape[0]):
        force, force_size = _at(terms.pressing[k, mode], x)
        speed, speed_size = _at(terms.sliding[k], x)
        speed *= -_sign(terms.direction[k], x, ways[k])
        work[count + k] += weight * abs(force) * speed
        total += abs(force) * speed
        rounding += abs(force) * speed_size + force_size * abs(speed)
    force, force_size = _at(terms.holding[mode], x)
    speed, speed_size = _at(terms.approach, x)
    work[-1] += weight * force * speed
    return total + force * speed, rounding + abs(force) * speed_size + force_size * abs(speed)


@kernel
def _width(rates, passed, left):
    """Width [s] of the next panel, ``passed`` from the start and ``left`` to the middle of an arc."""
    fastest = 0.0
    for k in range(rates.shape[1]):
        fastest = max(fastest, rates[2, k])
    width = max(_FIRST / fastest if fastest > 0.0 else left, (_GROWTH - 1.0) * passed)
    for k in range(rates.shape[1]):
        if rates[1, k] > 0.0 and rates[0, k] * passed < _GONE:
            width = min(width, _TURN / rates[1, k])
    return min(width, left)


@allocating_kernel
def _residual(flow, terms, rates, modes, starts, ends, durations, clock, seized, nodes, weights):
    n = starts.shape[1]
    x, work = np.empty(n), np.zeros(terms.left.shape[0] + terms.sliding.shape[0] + 1)
    ways = np.empty(terms.sliding.shape[0])
    balance, size = _energy(terms, ends[-1])
    largest, rounding = balance, size
    first, size = _energy(terms, starts[0])
    balance, largest, rounding = balance - first, max(largest, first), rounding + size
    lost, panels = 0.0, 0
    for k in range(modes.size):
        mode, half = modes[k], 0.5 * durations[k]
        passed, largest_power = 0.0, 0.0
        dispatch.advance(flow, mode, starts[k], half, x)
        for j in range(ways.size):
            ways[j] = _sign(terms.direction[j], x, 0.0)
        while passed < half:
            width = _width(rates[mode], passed, half - passed)
            panels += 1
            if panels > _MOST_PANELS or not width > 0.0:
                return np.nan, np.nan
            for side in range(2):
                begin = passed if side == 0 else durations[k] - passed - width
                for j in range(nodes.size):
                    dispatch.advance(flow, mode, starts[k], begin + 0.5 * width * (1.0 + nodes[j]), x)
                    weight = 0.5 * width * weights[j]
                    power, size = _power(terms, mode, x, ways, weight, work)
                    balance -= weight * power
                    largest_power = max(largest_power, abs(power))
                    rounding += weight * size
            passed = passed + width if width < half - passed else half
        # The clock holds the end of the arc to its last place; so long the largest power may act too much.
        rounding += largest_power * abs(clock[k])
        if k + 1 < modes.size and seized[k]:
            loss, _ = _at(terms.seized, ends[k])
            lost += loss * loss
        here, _ = _energy(terms, ends[k])
        largest = max(largest, here)
    balance += lost
    largest = max(largest, lost)
    for k in range(work.size):
        largest = max(largest, abs(work[k]))
    if not largest > 0.0:
        return 0.0, 0.0
    return abs(balance) / largest, _EPS * rounding / largest
