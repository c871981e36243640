"""The exact curves, by name, at which a drive changes what it does, in the plane of two of its parameters.

Rigid drive (:mod:`lsvib.steady_sliding.thresholds` proves what each one divides):

* ``kinematic``: Γ₊ = 0, the Painlevé region begins;
* ``onset``: R̃ = 0, where Γ₊ ≤ 0 or C₊ < 0, so that steady sliding is unstable on the side R̃ Ω > 0;
* ``negative_damping``: C₊ = 0, where Γ₊ > 0 and R̃ Ω > 0;
* ``stick``, ``detach``, ``global_stability``: R is the force of that name;
* ``stick_slip_birth``, for Γ₊ > 0 > C₊ and R̃ Ω < 0, where steady sliding attracts what is near: whether slip from the
  end of rest comes to rest again. All rest ends in one state, so there is a stick–slip cycle if it does, and none if
  not.

Compliant threads: ``flutter``, where steady sliding changes its stability, from the full characteristic polynomial.
"""

import math
from collections.abc import Callable
from enum import IntEnum
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from lsvib.drives.coefficients import Coefficients, coefficients
from lsvib.drives.friction import effective_damping, effective_inertia, friction_factor
from lsvib.drives.parameters import RigidParameters, ThreadsParameters
from lsvib.drives.rigid import EventKind, MotionMode, rigid_automaton
from lsvib.engine.kernels import columns
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import follow
from lsvib.errors import NoThreshold
from lsvib.steady_sliding import thresholds
from lsvib.steady_sliding.characteristic import DIGITS, hurwitz, polynomial, rationals, tangents
from lsvib.steady_sliding.contours import contour
from lsvib.steady_sliding.linearised import steady_law

LOGARITHMIC = ("contact_stiffness", "contact_damping")
"""Parameters that span many decades, so that their axes have equal ratios in place of equal steps."""
_NODES = 96  # along each side of the plane; a curve is missed only between two nodes
_COSTLY_NODES = 32  # for a threshold of both parameters, some milliseconds at each node
_TURNS = 4000  # most events of slip that neither rests nor settles: it is on a cycle, to rounding
_KEPT = 4096  # thresholds that are kept while a curve is traced; without R they are the same along it


class Boundary(IntEnum):
    """Names of the curves."""

    ONSET = 0
    STICK = 1
    DETACH = 2
    GLOBAL_STABILITY = 3
    KINEMATIC = 4
    NEGATIVE_DAMPING = 5
    STICK_SLIP_BIRTH = 6
    FLUTTER = 7


_FORCES: dict[Boundary, Callable[[RigidParameters], float]] = {
    Boundary.STICK: thresholds.stick_force,
    Boundary.DETACH: thresholds.detach_force,
    Boundary.GLOBAL_STABILITY: thresholds.global_stability_force,
}
Plane = tuple[str, tuple[float, float]]


def boundary_curves(drive: RigidParameters, x: Plane, y: Plane) -> dict[Boundary, list[np.ndarray]]:
    """Return the lines, points (k, 2) each, by the name of the curve, in a window of two parameters.

    Arguments: a drive of the rigid model or with compliant threads; name and ends of either axis [SI unit]. The
    function that vanishes on a curve is evaluated with many digits at every point of it.
    """
    kinds = (Boundary.FLUTTER,) if isinstance(drive, ThreadsParameters) else tuple(Boundary)[: Boundary.FLUTTER]
    names, found = (x[0], y[0]), {}
    for kind in kinds:
        costly = kind in _FOLLOWED or (kind in _FORCES and "axial_force" not in names)
        nodes = [nodes_between(*ends, _COSTLY_NODES if costly else _NODES, name) for name, ends in (x, y)]
        function = _function(drive, kind, names)
        if kind in _SIGNS:
            values = _SIGNS[kind](_many(drive, names, nodes))
        elif kind in _FORCES and "axial_force" in names:
            values = _over_force(function, names, nodes)
        else:
            where = _stable_but_not_damped(_many(drive, names, nodes)) if kind is Boundary.STICK_SLIP_BIRTH else None
            values = _one_by_one(function, nodes, where)
        lines = contour(function, *nodes, values)
        if lines:
            found[kind] = lines
    return found


def nodes_between(low: float, high: float, count: int, name: str) -> np.ndarray:
    """Return values from end to end; of the stiffness and damping of a contact in equal ratios."""
    return np.geomspace(low, high, count + 1) if name in LOGARITHMIC else np.linspace(low, high, count + 1)


def _over_force(function: Callable[[float, float], float], names: tuple[str, str], nodes: list) -> np.ndarray:
    """Values of R − threshold at the nodes of a plane that has R as an axis: of the threshold one for each line."""
    if names[0] == "axial_force":
        return nodes[0] - np.array([nodes[0][0] - function(nodes[0][0], b) for b in nodes[1]])[:, None]
    return nodes[1][:, None] - np.array([nodes[1][0] - function(a, nodes[1][0]) for a in nodes[0]])


def _one_by_one(function: Callable[[float, float], float], nodes: list, where: np.ndarray | None) -> np.ndarray:
    """Values at the nodes, at some of them if ``where`` is given."""
    values = np.full((len(nodes[1]), len(nodes[0])), np.nan)
    for j, i in np.argwhere(np.ones(values.shape, dtype=bool) if where is None else where):
        values[j, i] = function(nodes[0][i], nodes[1][j])
    return values


def _stable_but_not_damped(v: SimpleNamespace) -> np.ndarray:
    """Where Γ₊ > 0 > C₊ and R̃ Ω < 0, in doubles."""
    return np.broadcast_to((v.inertia > 0) & (v.damping < 0) & (v.drag < 0), v.shape)


def _many(drive: RigidParameters, names: tuple[str, str], nodes: list) -> SimpleNamespace:
    """Γ₊, C₊ and R̃ Ω at the nodes, in doubles."""
    values = SimpleNamespace(**dict(drive) | dict(zip(names, np.meshgrid(*nodes), strict=True)))
    tangent, radius = np.tan(values.lead_angle), values.pitch_radius
    factor = friction_factor(values.friction_coefficient, tangent, 1)
    return SimpleNamespace(
        inertia=effective_inertia(values.screw_inertia, values.mass, radius, tangent, factor) + 0 * tangent,
        damping=effective_damping(values.support_damping, values.translation_damping, radius, tangent, factor),
        drag=(values.axial_force - radius * tangent * values.translation_damping * values.input_speed)
        * values.input_speed,
        shape=np.meshgrid(*nodes)[0].shape,
    )


def _where(v: SimpleNamespace, values: Any, holds: Any) -> np.ndarray:
    """Values at the nodes where a condition holds, nan elsewhere."""
    return np.where(np.broadcast_to(holds, v.shape), np.broadcast_to(values, v.shape), np.nan)


_SIGNS: dict[Boundary, Callable[[SimpleNamespace], np.ndarray]] = {
    Boundary.KINEMATIC: lambda v: _where(v, v.inertia, True),
    Boundary.NEGATIVE_DAMPING: lambda v: _where(v, v.damping, (v.inertia > 0) & (v.drag > 0)),
    Boundary.ONSET: lambda v: _where(v, v.drag, (v.inertia <= 0) | (v.damping < 0)),
}
_FOLLOWED = (Boundary.STICK_SLIP_BIRTH, Boundary.FLUTTER)  # of which every value takes a millisecond
_EXACT: dict[Boundary, Callable[[Coefficients], float]] = {
    Boundary.KINEMATIC: lambda c: float(c.gamma[1]),
    Boundary.NEGATIVE_DAMPING: lambda c: float(c.damping[1]),
    Boundary.ONSET: lambda c: float(c.net_force),
}


def _function(drive: RigidParameters, kind: Boundary, names: tuple[str, str]) -> Callable[[float, float], float]:
    """The function of two parameters that vanishes on a curve; nan where there is no such threshold."""
    force = _kept(_FORCES[kind]) if kind in _FORCES else None

    def function(first: float, second: float) -> float:
        changed = drive.replace(**{names[0]: float(first), names[1]: float(second)})
        if force is not None:
            return changed.axial_force - force(changed.replace(axial_force=0.0))
        if kind is Boundary.STICK_SLIP_BIRTH:
            return comes_to_rest_again(changed)
        if kind is Boundary.FLUTTER:
            exact = polynomial(type(changed), rationals(changed), steady_law(changed), tangents(changed, DIGITS)[0])
            return float(min((*exact[:4], hurwitz(exact))))
        sign = math.copysign(1.0, changed.input_speed) if kind is Boundary.ONSET else 1.0
        return sign * _EXACT[kind](coefficients(changed))

    return function


def _kept(force: Callable[[RigidParameters], float]) -> Callable[[RigidParameters], float]:
    """A threshold, nan where there is none; drives that were asked for are not computed again."""

    @lru_cache(maxsize=_KEPT)
    def of(drive: RigidParameters) -> float:
        try:
            return force(drive)
        except NoThreshold:
            return math.nan

    return of


def comes_to_rest_again(drive: RigidParameters) -> float:
    """Return 1 if slip from the end of rest comes to rest again, −1 if it ends in steady sliding; else 0.

    nan but for Γ₊ > 0 > C₊ and R̃ Ω < 0, and where nothing damps slip under law −.
    """
    c = coefficients(drive)
    if c.paradox or not c.damping[1] < 0 < c.damping[-1] or not c.net_force * drive.exact().input_speed < 0:
        return math.nan
    automaton = rigid_automaton(drive)
    (rest,) = np.flatnonzero(automaton.codes == MotionMode.REST)
    tables = automaton.tables
    row = tables.surfaces[tables.guard_surface[tables.guard_start[rest]]]  # of the end of rest
    before = math.copysign(float(tables.flow[0, columns.TIME_SCALE]), drive.input_speed) * abs(drive.input_speed)
    start = (-row[2] / row[0] + before, -drive.input_speed)
    motion = follow(automaton, start, math.inf, mode=int(rest), stop=(EventKind.STICK, -1), max_events=_TURNS)
    if motion.status == Status.SETTLED:
        return -1.0
    # Without R the band of rest is a point, and the screw comes to rest by an accumulation of reversals.
    return 1.0 if motion.status == Status.STOP_EVENT or (motion.mode == rest).any() else 0.0
