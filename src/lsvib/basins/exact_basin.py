r"""The region of attraction of steady sliding in the rigid drive: its boundary in closed form, its area (Sect. 8.7).

The boundary is found by following one motion backwards in time; docs/basin.md proves that this is enough. Let Ω > 0
(otherwise the drive is mirrored), let M_0 be the slip mode that holds the equilibrium, and Q = q_u u + q_w w + q_0
(eq. 8.17). There are two cases.

* Γ₊ > 0. The motion depends continuously on its start, so the basin is the inside of the innermost closed orbit, or the
  whole plane if there is none. A motion that starts near the equilibrium and is followed backwards winds on to that
  orbit, or grows without bound.
* Γ₊ ≤ 0, the Painlevé region, with R̃ Ω < 0. The motion that touches Q = 0, at a point T, is followed backwards. If it
  comes from Q = 0 itself, no motion that has stood still settles, and this motion and the line Q = 0 enclose the basin.
  Otherwise it comes from θ′ = 0, from a state (x, −Ω), and every motion that stands or lands there with u > x settles.
  If a seizure that ends in that state begins beyond T, the slip before the seizure is followed backwards in turn, and
  so on, until x reaches a cycle without rest, which repels, or goes to −∞. A seizure changes w only, so beyond M_0 the
  boundary goes on along the line u = x.
"""

import math
from dataclasses import dataclass
from decimal import Decimal, localcontext
from enum import IntEnum

import numpy as np

from lsvib.basins.clipping import Window, clip, inside
from lsvib.basins.curves import Arc, Curve, Segment, area, contains, sampled
from lsvib.basins.reversed_time import BEGINNING, backward_automaton
from lsvib.cycles import leaps
from lsvib.cycles.attractors import steady_state
from lsvib.cycles.return_map import ReturnSection
from lsvib.cycles.return_section import section_key
from lsvib.drives.coefficients import Coefficients, coefficients
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import MotionMode, rigid_automaton
from lsvib.engine.automaton import Automaton
from lsvib.engine.exact.precision import PLACES
from lsvib.engine.kernels import columns
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import Motion, follow
from lsvib.errors import EngineError, InputError

_NEAR = 0.5  # distance from the equilibrium at which the motion backwards starts, in distances to the first guard
_EVENTS = 32  # of a motion backwards, after which its return map is looked at
_ROUNDS = 200  # of _EVENTS events each, about half a second, after which turns that hardly grow are leapt over
_LEAPS = 4  # leaps and rounds in turn, after which the boundary is given up: each leap ends where the events change
_PATIENCE = 10.0  # time that a turn may take after a leap, in times of the longest turn seen
_FAR = 1e9  # growth of the turns after which they grow for ever: the constants of the drive are 1e-9 of the state
_CLOSED = 1e-9  # relative gap of an orbit that is closed
_BRIEF = 1e-3  # shortest turn, in time scales of slip; a turn has about 2π of them


class AttractsNothing(InputError):
    """Steady sliding is not asymptotically stable, so it has no basin."""


class Boundary(IntEnum):
    """What bounds the basin."""

    NONE = 0  # steady sliding is globally stable
    TOUCHING_MOTION = 1  # the motion that touches Q = 0, and the line Q = 0; no motion that has stood still settles
    TOUCHING_SLIP = 2  # the slip from θ′ = 0 that touches Q = 0
    CYCLE = 3  # a cycle that repels


@dataclass(frozen=True)
class Basin:
    """The region of attraction of steady sliding of ``drive``.

    ``boundary`` says what bounds it; ``curves`` are the boundary, with the basin on their right, each closed or from
    infinity to infinity; ``flow`` is the flow table of the drive's automaton, to which the arcs refer.
    """

    drive: RigidParameters
    boundary: Boundary
    curves: tuple[Curve, ...]
    flow: np.ndarray

    @property
    def bounded(self) -> bool:
        """Whether the basin has a finite area."""
        return bool(self.curves) and all(math.isfinite(curve[0].start[1]) for curve in self.curves)

    def contains(self, state) -> bool:
        """Whether the motion from ``state`` (u [rad], w [rad/s]) settles; on the boundary itself either answer."""
        return not self.curves or contains(self.flow, self.curves, state)

    def clipped(self, window: Window) -> list[Curve]:
        """Return the closed curves around the part of the basin that lies in a window."""
        return clip(self.flow, self.curves, window) if self.curves else clip(self.flow, [_everything()], window)

    def line(self, window: Window, count: int = 100) -> np.ndarray:
        """Return points (n, 2) of the boundary in a window for drawing, NaN where it is interrupted."""
        closed, paths = inside(self.flow, self.curves, window)
        return sampled(self.flow, [*closed, *paths], count)

    def area(self, window: Window | None = None) -> float:
        """Return the area [rad²/s] of the basin, or of its part in a window; infinite if it is not bounded."""
        if window is not None:
            return area(self.flow, self.clipped(window))
        return area(self.flow, self.curves) if self.bounded else math.inf

    def fraction(self, window: Window) -> float:
        """Return the share [1] of a window that belongs to the basin."""
        return self.area(window) / window.area


def basin(drive: RigidParameters) -> Basin:
    """Compute the region of attraction of steady sliding of the rigid drive.

    It is the same under both rules of resuming after a seizure. Raises ``InputError`` where steady sliding attracts
    nothing, and for the few drives whose basin has another shape (see docs/basin.md); ``EngineError`` where the engine
    cannot follow the boundary.
    """
    if drive.input_speed < 0:
        return _mirrored(basin(drive.replace(input_speed=-drive.input_speed, axial_force=-drive.axial_force)), drive)
    c = coefficients(drive)
    _require_attraction(c)
    find = _in_paradox if c.paradox else _continuous
    boundary, curves = find(drive, c)
    return Basin(drive, boundary, tuple(curves), rigid_automaton(drive).tables.flow)


def _require_attraction(c: Coefficients) -> None:
    if c.net_force == 0:
        raise InputError(
            "axial_force balances the translation damping exactly, so the contact carries no force and no law holds."
        )
    if c.damping[c.steady_law] <= 0 or c.gamma[c.steady_law] <= 0:
        raise AttractsNothing(
            "steady sliding attracts nothing in this drive: its effective damping or inertia is not positive."
        )


def _continuous(drive: RigidParameters, c: Coefficients) -> tuple[Boundary, list[Curve]]:
    """Return the basin for Γ₊ > 0: the inside of the cycle on to which a motion winds that is followed backwards."""
    if c.damping[1] < 0 and c.damping[1] ** 2 >= 4 * drive.exact().coupling_stiffness * c.gamma[1]:
        raise InputError(
            f"translation_damping = {drive.translation_damping:g} is so large that slip under law + may grow for ever "
            "without a turn; the basin of such a drive is not covered."
        )
    back = backward_automaton(drive)
    mode = MotionMode.SLIP_FORWARD_NEGATIVE if c.steady_law < 0 else MotionMode.SLIP_FORWARD_POSITIVE
    # Slip from (start, 0) never leaves |u| <= start, |w| <= start √(k/Γ_0).
    rate = math.sqrt(drive.coupling_stiffness / float(c.gamma[c.steady_law]))
    q_u, q_w, q_0 = (abs(float(x)) for x in c.q_row)
    start = _NEAR * min(q_0 / (q_u + q_w * rate), drive.input_speed / rate)
    orbit = _wind_up(drive, back, [start, 0.0], _index(back, mode))
    if orbit is None:
        return Boundary.NONE, []
    return Boundary.CYCLE, [_forward_arcs(orbit, rigid_automaton(drive))]


def _in_paradox(drive: RigidParameters, c: Coefficients) -> tuple[Boundary, list[Curve]]:
    """Return the basin in the Painlevé region, from the motion that touches Q = 0."""
    touch = _touch(drive, c)
    if touch is None:
        return Boundary.NONE, []
    back, drive_forward = backward_automaton(drive, touch[0]), rigid_automaton(drive)
    start, mode = np.array([float(touch[0]), -float(touch[1])]), _index(back, MotionMode.SLIP_FORWARD_NEGATIVE)
    trace = _trace(back, start, mode, 2)
    if trace is None or trace.time.size == 0:
        return Boundary.NONE, []  # The motion comes from far away, so slip from θ′ = 0 never gets as far as T.
    end = start * [1, -1]
    arcs = _forward_arcs(trace, drive_forward)
    ended = trace.automaton.codes[trace.end_mode] == BEGINNING
    if trace.before[0, 1] != drive.input_speed:  # The motion comes from Q = 0.
        return Boundary.TOUCHING_MOTION, [[*arcs[-1:], Segment(end, arcs[-1].start)]]
    _require_rest_in_basin(drive, c, float(trace.before[0, 0]))
    if c.q_row[1] == 0:
        return Boundary.NONE, []
    if not ended:
        orbit = _wind_up(drive, back, start, mode)
        if orbit is None:
            return Boundary.NONE, []
        arcs = _forward_arcs(orbit, drive_forward)
    if c.q_row[1] < 0:
        raise EngineError("a cycle without rest whose seizures end backward slip was not thought possible; report it.")
    return (Boundary.TOUCHING_SLIP if ended else Boundary.CYCLE), [_with_seizures(arcs[-1], c)]


def _touch(drive: RigidParameters, c: Coefficients) -> tuple[Decimal, Decimal] | None:
    """Return the state in which slip touches Q = 0 from within; None if slip never crosses Q = 0 outwards.

    On the line u″ = R̃ / (m r_m tan λ) − c_x w / m under either law, so Q′ = κ w + ρ along it.
    """
    d = drive.exact()
    q_u, q_w, q_0 = c.q_row
    with localcontext(prec=PLACES):
        kappa = q_u - q_w * d.translation_damping / d.mass
        rho = q_w * c.net_force / (d.mass * d.pitch_radius * d.tan_lead)
        at_stand = rho - kappa * d.input_speed
        if at_stand <= 0 and kappa <= 0:
            return None
        if at_stand >= 0 or kappa <= 0:
            raise InputError(
                f"translation_damping = {d.translation_damping:g} is so large that slip crosses the line of no contact "
                "force in another sense than is usual; the basin of such a drive is not covered."
            )
        w = -rho / kappa
        return -(q_w * w + q_0) / q_u, w


def _require_rest_in_basin(drive: RigidParameters, c: Coefficients, edge: float) -> None:
    """Refuse drives with R > 0 > R̃ in which slip from θ′ = 0 may settle although release from rest does not."""
    d = drive.exact()
    with localcontext(prec=PLACES):
        upper = 1 if d.axial_force >= 0 else -1
        released = (
            c.damping[-1] * d.input_speed + d.pitch_radius * (c.xi[-1] - c.xi[upper]) * d.axial_force
        ) / d.coupling_stiffness
    if not edge < released:
        raise InputError(
            f"axial_force = {drive.axial_force:g} has the sign of input_speed although the net force has not, and rest "
            "does not settle; the basin of such a drive is not covered."
        )


def _wind_up(drive: RigidParameters, back: Automaton, state, mode: int) -> Motion | None:
    """Return one turn of the cycle on to which a motion backwards winds; None if it grows or does not come back.

    The turns only grow (docs/basin.md). Once they have grown by ``_FAR`` the constants of the drive no longer count:
    each turn is in proportion to the one before, so they grow for ever. Turns that hardly grow, as with little damping,
    are leapt over along their return map (:mod:`lsvib.cycles.leaps`).
    """
    start = state = np.array(state, dtype=float)
    scale = back.tables.flow[mode, columns.TIME_SCALE]
    for _ in range(_LEAPS):
        for _ in range(_ROUNDS):
            trace = _trace(back, state, mode, _EVENTS)
            if (
                trace is None
                or trace.status == Status.SETTLED
                or np.abs(trace.after).max() > _FAR * np.abs(start).max()
            ):
                return None
            state, mode = trace.end_state, trace.end_mode
            found = steady_state(back, state, mode=mode, max_events=1)
            # An event that recurs at once is not a turn.
            if found.orbit is not None and found.residual < _CLOSED and found.period > _BRIEF * found.returns * scale:
                once = found.orbit.time.size // found.returns
                return follow(back, found.orbit.start_state, math.inf, mode=found.orbit.start_mode, max_events=once)
        section = _section(trace)
        leap = None if section is None else leaps.drift(section, 0.0, _FAR)
        if leap is None:
            break
        if leap.end == leaps.End.GROWS:
            return None
        state, mode = section.state(np.array([leap.place])), section.key[1]
        if leap.end == leaps.End.CLOSES:
            return follow(back, state, math.inf, mode=mode, stop=section.key, max_events=_EVENTS)
    raise InputError(
        f"support_damping = {drive.support_damping:g} and translation_damping = {drive.translation_damping:g} change a "
        "motion so little in a turn that the boundary of the basin cannot be followed to its end."
    )


def _section(trace: Motion) -> ReturnSection | None:
    """Return the section of the rarest events of a motion backwards, at its last return; None if it is no line."""
    key = section_key(trace)
    if key is None:
        return None
    there = np.flatnonzero((trace.kind == key[0]) & (trace.mode == key[1]))
    longest = np.diff(trace.time[there]).max(initial=0.0)
    size = np.abs(trace.after).max(axis=0)
    section = ReturnSection(trace.automaton, key, trace.after[there[-1]], size, 1, _PATIENCE * longest)
    return section if section.dimension == 1 else None


def _trace(back: Automaton, state: np.ndarray, mode: int, events: int) -> Motion | None:
    """Follow a motion backwards over some events; None if it leaves the range of numbers, as it does far away."""
    try:
        return follow(back, state, math.inf, mode=mode, max_events=events)
    except EngineError:
        return None


def _forward_arcs(trace: Motion, drive_forward: Automaton) -> list[Arc]:
    """Return the arcs of a motion backwards as arcs forward in time, the earliest first; none has zero duration."""
    codes = drive_forward.codes.tolist()
    turned = np.array([1.0, -1.0])
    return [
        Arc(codes.index(trace.automaton.codes[mode]), end * turned, start * turned, float(duration))
        for mode, start, end, duration in zip(*trace.arcs(), strict=True)
        if duration > 0
    ][::-1]


def _with_seizures(slip: Arc, c: Coefficients) -> Curve:
    """Return the boundary along slip from (x, −Ω), continued along the line u = x, on which seizures end and begin."""
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    x = slip.start[0]
    seizure = np.array([x, -(q_u * x + q_0) / q_w])
    return [
        Segment(np.array([x, -math.inf]), slip.start),
        slip,
        Segment(slip.end, seizure),
        Segment(seizure, np.array([x, math.inf])),
    ]


def _everything() -> Curve:
    """Return a curve that has the whole plane on its right."""
    low, high = np.array([-1e300, -math.inf]), np.array([-1e300, math.inf])
    return [Segment(low, high)]


def _index(automaton: Automaton, mode: MotionMode) -> int:
    return automaton.codes.tolist().index(int(mode))


def _mirrored(found: Basin, drive: RigidParameters) -> Basin:
    """Return the basin of a drive from that of the drive with Ω and R reversed: the plane turned by half a turn."""
    codes = rigid_automaton(found.drive).codes.tolist()
    automaton = rigid_automaton(drive)

    def turned(piece: Segment | Arc) -> Segment | Arc:
        """A piece of the boundary, turned by half a turn, with the mode that has both signs reversed."""
        if isinstance(piece, Segment):
            return Segment(-piece.start, -piece.end)
        code = MotionMode.SLIP_BACKWARD_NEGATIVE - codes[piece.mode]
        return Arc(_index(automaton, code), -piece.start, -piece.end, piece.duration)

    curves = tuple([turned(piece) for piece in curve] for curve in found.curves)
    return Basin(drive, found.boundary, curves, automaton.tables.flow)
