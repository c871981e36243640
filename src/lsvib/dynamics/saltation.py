r"""The derivative of a motion with respect to its start: the flow of a mode, and the saltation matrix of an event.

In a mode x′ = A x + b, so that neighbours separate as e^{Aτ}. A neighbour meets the surface gᵀx + g₀ = 0 of an event
earlier or later; seen from event to event, with the field f before it and the affine reset x ↦ R x + r of the event,

    D = R (I − f gᵀ / gᵀf) e^{Aτ}

is the derivative of the state after the event with respect to that after the one before. Times and the field after the
event do not enter: the product over a period is the derivative of the Poincaré map, whose eigenvalues are the Floquet
multipliers without the trivial 1. (With it, the saltation matrix is R + (f⁺ − R f) gᵀ / gᵀf.) Release from rest of the
rigid drive has g = ±(1, 0) and f = (−Ω, 0), so that D is zero: a rest phase makes a cycle superstable.
"""

import math
from dataclasses import dataclass

import numpy as np

from lsvib.dynamics.kernels import saltation
from lsvib.engine.motion import Motion


@dataclass(frozen=True)
class Derivative:
    """Derivative ``matrix`` (n, n) of a state with respect to an earlier one; a bound (n, n) of its ``rounding``."""

    matrix: np.ndarray
    rounding: np.ndarray


def derivative(motion: Motion) -> Derivative:
    """Return the derivative of the state after a motion's last event with respect to its start.

    nan if an event has none. The start's own mode is kept: neighbours start in it. A rounding beyond all numbers is
    infinite or nan: a surface is hardly crossed there.
    """
    n = motion.start_state.size
    matrix, rounding = np.empty((n, n)), np.empty((n, n))
    saltation.derivative(
        motion.automaton.tables, motion.start_mode, motion.start_time, motion.time, motion.kind, motion.mode,
        motion.before, matrix, rounding,
    )  # fmt: skip
    return Derivative(matrix, rounding)


def eigenvalues(matrix: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the eigenvalues of a real matrix, complex, and the largest condition of one, |y| |x| / |yᵀx|."""
    if len(matrix) == 1:
        return matrix[0].astype(complex), 1.0
    values, right = np.linalg.eig(matrix)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return values.astype(complex), math.inf
    with np.errstate(over="ignore"):  # hypot alone keeps the squares of large entries within the range of numbers
        conditions = np.hypot.reduce(np.abs(left), axis=1) * np.hypot.reduce(np.abs(right), axis=0)
    return values.astype(complex), float(np.max(conditions))
