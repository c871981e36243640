"""Floquet multipliers of a cycle on a section of return, and how wrong they may be.

The multipliers are the n − 1 eigenvalues of P′, zero where the section has fewer dimensions than n − 1. Their error
has three parts: the rounding of the product, carried along entry by entry and weighted with the condition of the
eigenvalue; what the uncertainty of the fixed point changes; and, for defective eigenvalues, the root of the former.
Of stiff contacts that bound of the rounding is too large by ten decades, because it does not see that the fast motion
has died away; there the rounding is measured instead, by how P′ scatters between places that differ by rounding.
"""

import math

import numpy as np

from lsvib.dynamics.poincare_map import Derivative, Section, derivative, eigenvalues
from lsvib.engine.kernels import flow_planar
from lsvib.engine.motion import Motion

AT_REST = 4 * flow_planar.EPS  # of a step of Newton's method: rounding
_SENSITIVITY = 1e-6  # step in y by which the change of P′ along the section is measured
_PROMISED = 1e-10  # size of the rounding of P′ below which its bound is good enough
_BESIDE = 1e-12  # steps in y over which P′ is linear to 1e-23 or so: what is left of second differences is rounding
_SCATTERS = 5  # such places
_SAFE = 30.0  # by which rounding may exceed a few samples of it, and by which that of the tables counts


def section_derivative(section: Section, orbit: Motion) -> Derivative:
    """Return P′ (d, d) of a section along a motion that returns to it, with the bound of its rounding."""
    total, axes, along = derivative(orbit), section.axes, section.directions
    return Derivative(axes @ total.matrix @ along, np.abs(axes) @ total.rounding @ np.abs(along))


def multipliers(section: Section, orbit: Motion, residual: float) -> tuple[np.ndarray, float]:
    """Return the n − 1 multipliers of a cycle, the largest first, and a bound of their errors [1]; nan without P′."""
    count = max(section.origin.size - 1, section.dimension)
    found = section_derivative(section, orbit)
    if not np.isfinite(found.matrix).all():
        return np.full(count, math.nan, dtype=complex), math.nan
    if section.dimension == 0:
        return np.zeros(count, dtype=complex), 0.0
    values, condition = eigenvalues(found.matrix)
    lost = found.rounding * orbit.automaton.condition
    if not np.linalg.norm(lost) <= _PROMISED:
        lost = np.fmin(lost, _scatter(section, orbit, found.matrix))
    uncertain = (residual + AT_REST) / max(_least(np.eye(section.dimension) - found.matrix), flow_planar.EPS)
    place = section.place(orbit.start_state)
    for direction in np.eye(section.dimension):
        beside = section.come_back(section.state(place + _SENSITIVITY * direction))
        if beside is not None:
            change = np.abs(section_derivative(section, beside).matrix - found.matrix) / _SENSITIVITY
            lost = lost + np.where(np.isfinite(change), change, 0.0) * min(uncertain, _SENSITIVITY)
    size = float(np.linalg.norm(lost))
    error = min(condition * size, max(size, size ** (1 / len(found.matrix))) * len(found.matrix) + size)
    padded = np.concatenate([values, np.zeros(count - len(values))])
    return padded[np.argsort(-np.abs(padded), kind="stable")], error


def _scatter(section: Section, orbit: Motion, slopes: np.ndarray) -> np.ndarray:
    """Return the rounding of P′ (d, d) as second differences between places side by side show it; nan without them.

    That of the tables, which all places share, is a relative change of the drive by it, and is added.
    """
    place, found = section.place(orbit.start_state), []
    for k in range(_SCATTERS):
        beside = section.come_back(section.state(place + k * _BESIDE))
        if beside is None:
            return np.full_like(slopes, math.nan)
        found.append(section_derivative(section, beside).matrix)
    noise = np.abs(np.diff(found, 2, axis=0)).max(axis=0)
    tables = flow_planar.EPS * orbit.automaton.condition * orbit.time.size * float(np.abs(slopes).max())
    return _SAFE * (noise + tables)


def _least(matrix: np.ndarray) -> float:
    return float(np.linalg.svd(matrix, compute_uv=False).min())
