"""The exact curves, by name, at which a drive changes what it does, in the plane of two of its parameters.

Rigid drive (:mod:`lsvib.stability.force_thresholds` proves what each one divides):

* ``kinematic``: Γ₊ = 0, the Painlevé region begins;
* ``onset``: R̃ = 0, where Γ₊ ≤ 0 or C₊ < 0, so that steady sliding is unstable on the side R̃ Ω > 0;
* ``negative_damping``: C₊ = 0, where Γ₊ > 0 and R̃ Ω > 0;
* ``stick``, ``detach``, ``global_stability``: R is the force of that name;
* ``stick_slip_birth``, for Γ₊ > 0 > C₊ and R̃ Ω < 0, where steady sliding attracts what is near: whether slip from the
  end of rest comes back to θ′ = 0. Orbits do not cross; so if it does, what is outside of it stays there and ends on a
  cycle, and if not, whatever rests ends in steady sliding.

Compliant threads: ``flutter``, where steady sliding changes its stability, from the full characteristic polynomial.
Where the contact carries no force, the law is that of the slightest force against the motion; a plane without any force
has no such curve.
"""

import math
from collections.abc import Callable
from enum import IntEnum
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from lsvib.dynamics.attractor import Attractor
from lsvib.dynamics.sweep import endings_at_once
from lsvib.engine.automaton import Automaton, one_of_many
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import follow
from lsvib.errors import InputError, NoThreshold
from lsvib.models.drive import Drive, zero_if_close
from lsvib.models.many import ManyDrives, groups
from lsvib.models.mechanics import Coefficients, coefficients, effective_damping, effective_inertia, friction_factor
from lsvib.models.model import find_model
from lsvib.models.rigid import EventKind, MotionMode, rigid_automaton
from lsvib.stability import force_thresholds
from lsvib.stability.curves import contour
from lsvib.stability.linear import steady_law
from lsvib.stability.spectrum import DIGITS, hurwitz, polynomial, rationals, tangents

LOGARITHMIC = ("contact_stiffness", "contact_damping")
"""Parameters that span many decades, so that their axes have equal ratios in place of equal steps."""
_NODES = 96  # along each side of the plane; a curve is missed only between two nodes
_COSTLY_NODES = 32  # for a threshold of both parameters, some milliseconds at each node
_ROUNDED, _BISECTED = 1e-13, 1e-9  # of places between two nodes: to rounding; where each step gains one bit only
_TURNS = 400  # most events of slip: what still neither stops nor settles is on a cycle, or comes nearer to one slowly
_STOPS = (EventKind.STICK, EventKind.REVERSAL, EventKind.ACCUMULATION)  # θ′ = 0
_KEPT = 4096  # thresholds that are kept while a curve is traced; without R they are the same along it


class ChartBoundary(IntEnum):
    """Names of the curves."""

    ONSET = 0
    STICK = 1
    DETACH = 2
    GLOBAL_STABILITY = 3
    KINEMATIC = 4
    NEGATIVE_DAMPING = 5
    STICK_SLIP_BIRTH = 6
    FLUTTER = 7


_FORCES: dict[ChartBoundary, Callable[[Drive], float]] = {
    ChartBoundary.STICK: force_thresholds.stick_force,
    ChartBoundary.DETACH: force_thresholds.detach_force,
    ChartBoundary.GLOBAL_STABILITY: force_thresholds.global_stability_force,
}
AxisSpan = tuple[str, tuple[float, float]]


def curves_of(drive: Drive) -> tuple[ChartBoundary, ...]:
    """Return the names of the curves that a drive can have; none if its model has no charts."""
    return tuple(ChartBoundary[name.upper()] for name in find_model(drive.model).curves)


def boundary_curves(
    drive: Drive, x: AxisSpan, y: AxisSpan, kinds: tuple[ChartBoundary, ...] | None = None
) -> dict[ChartBoundary, list[np.ndarray]]:
    """Return the lines, points (k, 2) each, by the name of the curve, in a window of two parameters.

    Arguments: a drive of the rigid model or with compliant threads; name and ends of either axis [SI unit]; which of
    the curves, by default all that the drive can have. The function that vanishes on a curve is evaluated with many
    digits at every point of it.
    """
    names, found = (x[0], y[0]), {}
    for kind in kinds or curves_of(drive):
        if kind is ChartBoundary.FLUTTER and not _carries_force(drive, x, y):
            continue
        costly = kind is ChartBoundary.FLUTTER or (kind in _FORCES and "axial_force" not in names)
        nodes = [nodes_between(*ends, _COSTLY_NODES if costly else _NODES, name) for name, ends in (x, y)]
        function = _function(drive, kind, names)
        if kind in _SIGNS:
            values = _SIGNS[kind](_many(drive, names, nodes))
        elif kind in _FORCES and "axial_force" in names:
            values = _over_force(function, names, nodes)
        elif kind is ChartBoundary.STICK_SLIP_BIRTH:
            values = _after_rest(drive, names, nodes)
        else:
            values = np.array([[function(a, b) for a in nodes[0]] for b in nodes[1]])
        lines = contour(function, *nodes, values, _BISECTED if kind is ChartBoundary.STICK_SLIP_BIRTH else _ROUNDED)
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


def _after_rest(drive: Drive, names: tuple[str, str], nodes: list) -> np.ndarray:
    """What :func:`stops_again` says at the nodes, by the motions of all of them from the middle of rest.

    Where it takes long to find what such a motion ends on, as next to a cycle that attracts slowly, it is enough to
    see whether slip from the end of rest stops.
    """
    v = _many(drive, names, nodes)
    where = np.broadcast_to((v.inertia > 0) & (v.damping < 0) & (v.drag < 0), v.shape)
    values, grids = np.full(v.shape, np.nan), dict(zip(names, np.meshgrid(*nodes), strict=True))
    if not where.any():
        return values
    drives = ManyDrives(dict(drive) | {name: grid[where] for name, grid in grids.items()})
    d = SimpleNamespace(**drives.values)
    tangent = np.tan(d.lead_angle)
    plus, minus = (friction_factor(d.friction_coefficient, tangent, law) for law in (1, -1))
    damping = effective_damping(d.support_damping, d.translation_damping, d.pitch_radius, tangent, minus)
    middle = (damping * d.input_speed - 0.5 * d.pitch_radius * (plus - minus) * d.axial_force) / d.coupling_stiffness
    middles = np.stack([middle, -d.input_speed], axis=1)
    ends, is_open = endings_at_once(drives, middles, "contact_sign", work=2000.0)
    is_open |= ends.attractor == Attractor.UNRESOLVED
    found = np.where(ends.attractor == Attractor.STEADY_SLIDING, -1.0, np.where(ends.attractor > 0, 1.0, 0.0))
    found[is_open] = np.nan
    for group in groups(drives, "contact_sign", np.flatnonzero(is_open)):
        for k in np.flatnonzero(group.safe):
            one, speed = one_of_many(group.automaton, k), d.input_speed[group.members[k]]
            found[group.members[k]] = _slip_stops(one, speed)
    for k in np.flatnonzero(np.isnan(found)):  # of drives whose tables need 50 digits
        found[k] = stops_again(drives.one(k))
    values[where] = found
    return values


def _many(drive: Drive, names: tuple[str, str], nodes: list) -> SimpleNamespace:
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


_SIGNS: dict[ChartBoundary, Callable[[SimpleNamespace], np.ndarray]] = {
    ChartBoundary.KINEMATIC_CONSTRAINT: lambda v: _where(v, v.inertia, True),
    ChartBoundary.NEGATIVE_DAMPING: lambda v: _where(v, v.damping, (v.inertia > 0) & (v.drag > 0)),
    ChartBoundary.ONSET: lambda v: _where(v, v.drag, (v.inertia <= 0) | (v.damping < 0)),
}
_EXACT: dict[ChartBoundary, Callable[[Coefficients], float]] = {
    ChartBoundary.KINEMATIC_CONSTRAINT: lambda c: float(c.gamma[1]),
    ChartBoundary.NEGATIVE_DAMPING: lambda c: float(c.damping[1]),
    ChartBoundary.ONSET: lambda c: float(c.net_force),
}


def _function(drive: Drive, kind: ChartBoundary, names: tuple[str, str]) -> Callable[[float, float], float]:
    """The function of two parameters that vanishes on a curve; nan where there is no such threshold."""
    force = _FORCES.get(kind)
    if kind is ChartBoundary.STICK and "axial_force" not in names:
        force = _stick_or_onset
    force = _kept(force) if force is not None else None

    def function(first: float, second: float) -> float:
        """Return the value at a place of the plane, of the sign that the exact condition has there."""
        place = zip(names, (first, second), strict=True)
        changed = drive.replace(**{name: zero_if_close(type(drive), name, float(value)) for name, value in place})
        if force is not None:
            return changed.axial_force - force(changed.replace(axial_force=0.0))
        if kind is ChartBoundary.STICK_SLIP_BIRTH:
            return stops_again(changed)
        if kind is ChartBoundary.FLUTTER:
            law = _law_or_none(changed) or 1
            exact = polynomial(type(changed), rationals(changed), law, tangents(changed, DIGITS)[0])
            return float(min((*exact[:4], hurwitz(exact))))
        sign = math.copysign(1.0, changed.input_speed) if kind is ChartBoundary.ONSET else 1.0
        return sign * _EXACT[kind](coefficients(changed))

    return function


def _law_or_none(drive: Drive) -> int | None:
    """The law of steady sliding, None where the contact carries no force."""
    try:
        return steady_law(drive)
    except InputError:
        return None


def _carries_force(drive: Drive, x: AxisSpan, y: AxisSpan) -> bool:
    """Whether the contact carries a force somewhere in a window; R̃ is linear in each parameter that it depends on."""
    places = ({x[0]: first, y[0]: second} for first in x[1] for second in y[1])
    return any(_law_or_none(drive.replace(**place)) is not None for place in places)


def _kept(force: Callable[[Drive], float]) -> Callable[[Drive], float]:
    """A threshold, nan where there is none; drives that were asked for are not computed again."""

    @lru_cache(maxsize=_KEPT)
    def of(drive: Drive) -> float:
        """Return the threshold of a drive, or nan."""
        try:
            return force(drive)
        except NoThreshold:
            return math.nan

    return of


def _stick_or_onset(drive: Drive) -> float:
    """The force of ``stick``; that of the onset, to which it tends, where slip without rest has no cycle.

    Beyond the onset motions then come to rest at once. Where R is an axis that is no other curve than the onset.
    """
    try:
        return force_thresholds.stick_force(drive)
    except NoThreshold:
        return force_thresholds.onset_force(drive)


def stops_again(drive: Drive) -> float:
    """Return 1 if slip from the end of rest comes back to θ′ = 0, −1 if it ends in steady sliding; else 0.

    nan but for Γ₊ > 0 > C₊ and R̃ Ω < 0, and where nothing damps slip under law −.
    """
    c = coefficients(drive)
    if c.paradox or not c.damping[1] < 0 < c.damping[-1] or not float(c.net_force) * drive.input_speed < 0:
        return math.nan
    return _slip_stops(rigid_automaton(drive), drive.input_speed)


def _slip_stops(automaton: Automaton, speed: float) -> float:
    """Return 1 if slip from the end of rest comes back to θ′ = 0, −1 if it settles, 0 if it does neither for long.

    It starts on θ′ = 0 where the screw would stay, and orbits do not cross: what has not come back after a turn never
    does.
    """
    (rest,) = np.flatnonzero(automaton.codes == MotionMode.REST)
    tables = automaton.tables
    row = tables.surfaces[tables.guard_surface[tables.guard_start[rest]]]  # of the end of rest
    before = math.copysign(float(tables.flow[0, layout.TIME_SCALE]), speed) * abs(speed)
    motion = follow(automaton, (-row[2] / row[0] + before, -speed), math.inf, mode=int(rest), max_events=_TURNS)
    if np.isin(motion.kind, _STOPS).any():
        return 1.0
    return -1.0 if motion.status == Status.SETTLED else 0.0
