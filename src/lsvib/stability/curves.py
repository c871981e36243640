"""The exact curves, by name, at which a drive changes what it does, in the plane of two of its parameters.

docs/charts.md lists their equations and what they divide; :mod:`lsvib.stability.force_thresholds` says what each force
divides. Where the contact of compliant threads carries no force, the law is that of the slightest force against the
motion; a plane without any force has no such curve.

Curves are traced by contourpy; on every side of a cell that one crosses the root is bracketed with the exact condition.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from enum import IntEnum
from functools import cache, lru_cache
from itertools import product
from typing import Any

import numpy as np
from contourpy import contour_generator

from lsvib.drives import friction
from lsvib.drives.drive import LOGARITHMIC, Drive, once, zero_if_close
from lsvib.drives.mechanics import LinearParts, coefficients
from lsvib.drives.model import model_of
from lsvib.drives.thresholds import TABLE
from lsvib.errors import NoThreshold
from lsvib.stability.force_thresholds import threshold_force
from lsvib.stability.solve import bracketed_root
from lsvib.stability.spectrum import enclosed, margins, polynomial, sliding_law
from lsvib.stability.starting import runs_evenly
from lsvib.systems.exact.arithmetic import many_digits

_ROUNDED = 1e-13  # of a place between two nodes, relative


class ChartBoundary(IntEnum):
    """Names of the curves."""

    ONSET = 0
    STICK = 1
    DETACH = 2
    GLOBAL_STABILITY = 3
    KINEMATIC_CONSTRAINT = 4
    NEGATIVE_DAMPING = 5
    EVEN_SPEED = 6
    FLUTTER = 7


_FORCES = (ChartBoundary.STICK, ChartBoundary.DETACH, ChartBoundary.GLOBAL_STABILITY)
AxisSpan = tuple[str, tuple[float, float]]
PlaneFunction = Callable[[float, float], float]


def boundary_curves(drive: Drive, x: AxisSpan, y: AxisSpan) -> dict[ChartBoundary, list[np.ndarray]]:
    """Return the lines, points (k, 2) each, by the name of the curve, in a window of two parameters.

    Arguments: a drive of the rigid model or with compliant threads; name and ends of either axis [SI unit]. The
    function that vanishes on a curve is evaluated with many digits at every point of it.
    """
    names, found = (x[0], y[0]), {}
    corners = [drive.replace(**{x[0]: first, y[0]: second}) for first, second in product(x[1], y[1])]
    functions: dict[int, dict[ChartBoundary, PlaneFunction]] = {33: {}, 65: {}}  # by the number of nodes along an axis
    for kind in sorted(ChartBoundary[name.upper()] for name in model_of(drive).curves):
        holds = TABLE[kind.name.lower()]
        if holds.constant and any(friction.refusal(corner, holds.rest) for corner in corners):
            continue
        # R̃ is linear in each parameter that it depends on.
        if kind is ChartBoundary.FLUTTER and not any(map(sliding_law, corners)):
            continue
        slow = kind in (ChartBoundary.EVEN_SPEED, ChartBoundary.FLUTTER)
        slow = slow or (kind in _FORCES and "axial_force" not in names)
        functions[33 if slow else 65][kind] = _function(drive, kind, names)
    spacings = [np.geomspace if name in LOGARITHMIC else np.linspace for name in names]
    for count, own in functions.items():
        nodes = [spaced(*ends, count) for spaced, (_, ends) in zip(spacings, (x, y), strict=True)]
        values = np.array([[[function(a, b) for function in own.values()] for a in nodes[0]] for b in nodes[1]])
        for place, (kind, function) in enumerate(own.items()):
            bisected = kind is ChartBoundary.EVEN_SPEED  # each step gains one bit only
            if lines := contour(function, nodes[0], nodes[1], values[..., place], 1e-9 if bisected else _ROUNDED):
                found[kind] = lines
    return dict(sorted(found.items()))


def contour(
    function: PlaneFunction, x: np.ndarray, y: np.ndarray, values: np.ndarray, tolerance: float = _ROUNDED
) -> list[np.ndarray]:
    """Return the lines on which a function of x and y vanishes, each as points (k, 2).

    Arguments: ``function``, nan where it is not defined; ``x`` (n) and ``y`` (m), ascending, with its ``values``
    (m, n); relative ``tolerance`` of a place on a side of a cell. A line ends at the edge of the grid, or within a cell
    of where the function is not defined.
    """

    @cache
    def root(i: float, j: float) -> tuple[float, float]:
        """The point of a side, by its middle in numbers of nodes, at which the function vanishes."""
        low = np.array([x[math.floor(i)], y[math.floor(j)]])
        step = np.array([x[math.ceil(i)], y[math.ceil(j)]]) - low
        part = bracketed_root(lambda part: function(*(low + part * step)), 0.0, 1.0, tolerance)
        first, second = low + part * step
        return first, second

    # Of the values the signs alone, so that the lines cross every side in its middle, and it is known which one.
    signs = np.ma.masked_array(np.where(values > 0, 1.0, -1.0), mask=~np.isfinite(values))
    lines: Any = contour_generator(z=signs, name="serial", corner_mask=False).lines(0.0)
    return [np.array([root(i, j) for i, j in line.tolist()]) for line in lines]


def _function(drive: Drive, kind: ChartBoundary, names: tuple[str, str]) -> PlaneFunction:
    """The function of two parameters that vanishes on a curve; nan where there is no such threshold."""
    # Where R is no axis, slip without a cycle comes to rest as soon as it is beyond the onset, to which the force of
    # ``stick`` tends there; where it is one, that is no other curve than the onset.
    instead = "onset" if kind is ChartBoundary.STICK and "axial_force" not in names else None

    @lru_cache(maxsize=4096)  # without R a threshold is the same along it
    def force(changed: Drive) -> float:
        for name in (kind.name.lower(), instead):
            with suppress(NoThreshold):
                return threshold_force(changed, name) if name else math.nan
        return math.nan

    def function(first: float, second: float) -> float:
        """Return the value at a place of the plane, of the sign that the exact condition has there."""
        changed = _at(drive, *zip(names, (float(first), float(second)), strict=True))
        if kind in _FORCES:
            return changed.axial_force - force(_at(changed, ("axial_force", 0.0)))
        if kind is ChartBoundary.EVEN_SPEED:
            return starts_evenly(changed)
        if kind is ChartBoundary.FLUTTER:
            values, tangent = enclosed(changed)[0]
            exact = LinearParts.of(values, sliding_law(changed) or 1, tangent).polynomial()
            return float(min(margins(exact, neutral=False)))
        return _closed_form(changed, kind)

    return function


@once
def _at(drive: Drive, *place: tuple[str, float]) -> Drive:
    return drive.replace(**{name: zero_if_close(name, value) for name, value in place})


def _closed_form(drive: Drive, kind: ChartBoundary) -> float:
    """Γ₊, C₊ or R̃ Ω of a rigid drive; nan where its zero changes nothing.

    Where friction depends on the speed the onset is where C_0 + S changes its sign, or R̃ Ω or Γ₊ beside C_0 + S > 0.
    """
    c = coefficients(drive)
    inertia, damping = float(c.gamma[1]), float(c.damping[1])
    if kind is ChartBoundary.KINEMATIC_CONSTRAINT:
        return inertia
    with many_digits():
        drag = float(c.net_force * drive.input_speed)
    if kind is ChartBoundary.NEGATIVE_DAMPING:
        return damping if inertia > 0 and drag > 0 else math.nan
    if friction.depends_on_speed(drive) and not (inertia <= 0 < drag):
        return -float(polynomial(drive.exact(), 1 if drag > 0 else -1)[1])
    return drag if inertia <= 0 or damping < 0 else math.nan


def starts_evenly(drive: Drive) -> float:
    """Return 1 if the motion from rest of a drive ends in steady sliding, −1 if it does not.

    nan where that is not known, and where steady sliding does not attract: there it is no boundary of its own.
    """
    law, c = sliding_law(drive), coefficients(drive)
    if not law or not (c.gamma[law] > 0 and c.damping[law] > 0):
        return math.nan
    even = runs_evenly(drive)
    return math.nan if even is None else 1.0 if even else -1.0
