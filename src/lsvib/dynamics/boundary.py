"""The basin of steady sliding in the rigid drive: its exact boundary, also under a friction law, its area (Sect. 8.7).

The boundary is found by following one motion backwards in time; docs/basin.md says where it may come from, and proves
that this is enough. Let Ω > 0 (otherwise the drive is mirrored), and Q = q_u u + q_w w + q_0 (eq. 8.17). For Γ₊ > 0 it
is a motion that starts near the equilibrium, also under a law; for Γ₊ ≤ 0, the Painlevé region, with R̃ Ω < 0, it is the
motion that touches Q = 0, at a point T.
"""

import math
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import ArrayLike, NDArray

from lsvib.drives import friction
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import Coefficients, coefficients
from lsvib.drives.names import MotionMode
from lsvib.dynamics.curves import Arc, Curve, Part, Segment, Window, area, clip, contains, inside, sampled
from lsvib.dynamics.cycles import swing
from lsvib.dynamics.reversed_time import BEGINNING, backward_automaton, backward_under_law
from lsvib.errors import EngineError, InputError, LsvibError
from lsvib.stability.conditions import stability
from lsvib.systems.attractor import steady_state
from lsvib.systems.automaton import Automaton
from lsvib.systems.exact.arithmetic import many_digits
from lsvib.systems.flow import Flow
from lsvib.systems.kernels.layout import Status
from lsvib.systems.motion import Motion, follow


class AttractsNothing(InputError):
    """Steady sliding is not asymptotically stable, so it has no basin; ``neutral``: motions near it do not grow."""

    def __init__(self, why: str, neutral: bool) -> None:
        super().__init__(f"steady sliding of this drive attracts no motion: {why}.")
        self.neutral = neutral


class Boundary(IntEnum):
    """What bounds the basin."""

    NONE = 0  # steady sliding is globally stable, under a friction law from up to 10⁵ Ω
    TOUCHING_MOTION = 1  # the motion that touches Q = 0, and the line Q = 0; no motion that has been at rest settles
    TOUCHING_SLIP = 2  # the slip from θ′ = 0 that touches Q = 0
    CYCLE = 3  # a cycle that repels


@dataclass(frozen=True)
class Basin:
    """The basin of attraction of the steady sliding of ``drive`` (Sect. 8.7), in the plane of u [rad] and w [rad/s].

    ``boundary`` says what bounds it; ``curves`` are the boundary, with the basin on their right, each closed or from
    infinity to infinity; if friction depends on the speed it is followed backwards, with the basin on its left. Parts
    of the plane are given as :class:`lsvib.Window` or as ``{"u": (low, high), "w": (low, high)}`` (docs/basin.md).

    >>> basin = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10).basin()
    >>> f"{basin.area():.6f} rad²/s", f"{basin.fraction({'u': (-0.1, 0.1), 'w': (-80, 80)}):.6f}", basin.line().shape
    ('0.955325 rad²/s', '0.029854', (102, 2))
    """

    drive: Drive
    boundary: Boundary
    curves: tuple[Curve, ...] = field(repr=False)

    @cached_property
    def flow(self) -> Flow:
        """The flow of the arcs: that of the automaton, reversed in time if friction depends on the speed."""
        law = friction.depends_on_speed(self.drive)
        return (backward_under_law(self.drive) if law else automaton_of(self.drive)).flow

    def contains(self, state: "ArrayLike") -> bool:
        """Whether the motion from ``state`` (u [rad], w [rad/s]) settles; on the boundary itself either answer."""
        return not self.curves or contains(self.flow, self.curves, np.asarray(state, dtype=float))

    def clipped(self, window: Part) -> list[Curve]:
        """Return the closed curves around the part of the basin that lies in a window; raises ``InputError``."""
        window = Window.of(window)
        everything: Curve = [Segment(np.array([-1e300, -math.inf]), np.array([-1e300, math.inf]))]  # to its right
        return [clip(self.flow, curve, window) for curve in self.curves or [everything]]

    def line(self, window: Part | None = None, count: int = 100) -> np.ndarray:
        """Return points (n, 2) [rad, rad/s] of the boundary in a window, by default around its bends; NaN in gaps."""
        if window is None:
            points = sampled(self.flow, self.curves)
            low, high = (end(points[np.isfinite(points).all(axis=1)], axis=0) for end in (np.min, np.max))
            window = Window(*np.stack([1.2 * low - 0.2 * high, 1.2 * high - 0.2 * low], axis=1).ravel().tolist())
        closed, paths = inside(self.flow, self.curves, Window.of(window))
        return sampled(self.flow, [*closed, *paths], count)

    def area(self, window: Part | None = None) -> float:
        """Return the area ∮ w du [rad²/s] of the basin, possibly infinite, or in a window; raises ``InputError``."""
        if window is not None:
            return area(self.flow, self.clipped(window))
        bounded = self.curves and all(math.isfinite(curve[0].start[1]) for curve in self.curves)
        return area(self.flow, self.curves) if bounded else math.inf

    def fraction(self, window: Part) -> float:
        """Return the share [1] of a window in the basin; raises ``InputError`` if it is too narrow for doubles."""
        window = Window.of(window)
        if not self.curves:
            return 1.0
        # The last digits of a window and of the boundary are relative to their largest |u| [rad] and |w| [rad/s].
        points = np.abs([*sampled(self.flow, self.curves), (window.left, window.bottom), (window.right, window.top)])
        least = 1e-10 * np.where(np.isfinite(points), points, 0.0).max(axis=0)  # a share is then still good to 1e-4
        sides = ("u", window.left, window.right, least[0]), ("w", window.bottom, window.top, least[1])
        for name, low, high, narrowest in sides:
            if high - low < narrowest:
                raise InputError(
                    f"window {name} = {float(low)!r} to {float(high)!r} is too narrow for the boundary of the basin; "
                    f"the allowed range of high - low is at least {narrowest:g}."
                )
        return min(max(self.area(window) / window.area, 0.0), 1.0)


def basin(drive: Drive) -> Basin:
    """Compute the basin of steady sliding as :meth:`lsvib.Drive.basin`; it is the same under both resume rules."""
    if not drive.rigid:
        raise InputError(
            "the boundary of the basin is computed only for rigid drives without friction of slide, bearing and "
            "collar; for others, map the basin with attraction."
        )
    if wanted := friction.refusal(drive, law=True):
        raise InputError(f"the boundary of the basin {wanted}.")
    if drive.input_speed < 0:
        return _mirrored(basin(drive.replace(input_speed=-drive.input_speed, axial_force=-drive.axial_force)), drive)
    c = coefficients(drive)
    if c.net_force == 0:
        raise InputError(
            "axial_force balances the translation damping exactly, so the contact carries no force and no friction."
        )
    law = friction.depends_on_speed(drive)
    damping, gamma = c.damping[c.steady_law], c.gamma[c.steady_law]
    if not law and (damping <= 0 or gamma <= 0):
        raise AttractsNothing("its effective damping or inertia is not positive", neutral=damping == 0 < gamma)
    find = _under_law if law else _in_paradox if c.paradox else _continuous
    boundary, curves = find(drive, c)
    return Basin(drive, boundary, tuple(curves))


def known_basin(drive: Drive) -> Basin | None:
    """Return the basin of a drive of any model; None where :func:`basin` raises, as its boundary is not known."""
    try:
        return basin(drive)
    except LsvibError:
        return None


def _under_law(drive: Drive, c: Coefficients) -> tuple[Boundary, list[Curve]]:
    """Return the basin under a friction law, likewise; the motion starts where the engine proves that it settles."""
    flow: Any = automaton_of(drive).tables.flow
    mode = int(np.argmax(flow.settled_level))
    if not (level := float(flow.settled_level[mode])) > 0:
        if not (found := stability(drive)).stable:
            raise AttractsNothing("perturbations do not die away", max(x.real for x in found.eigenvalues) == 0)
        raise InputError("no start near steady sliding is known to settle, so its basin cannot be computed.")
    start = 0.5 * math.sqrt(level / flow.settled_form[mode, 0, 0])
    arcs = _wind_up(drive, backward_under_law(drive), np.array([start, 0.0]), mode)
    return (Boundary.CYCLE, [[*arcs]]) if arcs else (Boundary.NONE, [])


def _continuous(drive: Drive, c: Coefficients) -> tuple[Boundary, list[Curve]]:
    """Return the basin for Γ₊ > 0: the inside of the cycle on to which a motion winds that is followed backwards."""
    with many_digits():
        turns = c.damping[1] >= 0 or c.damping[1] ** 2 < 4 * drive.exact().coupling_stiffness * c.gamma[1]
    if not turns:
        raise InputError(
            f"translation_damping = {drive.translation_damping:g} is so large that slip under law + may grow for ever "
            "without turning back; the basin of such a drive cannot be computed."
        )
    if automaton_of(drive).contracts:  # areas shrink everywhere, so there is no closed orbit
        return Boundary.NONE, []
    back = backward_automaton(drive)
    mode = MotionMode.SLIP_FORWARD_NEGATIVE if c.steady_law < 0 else MotionMode.SLIP_FORWARD_POSITIVE
    # Slip from (start, 0) never leaves |u| <= start, |w| <= start √(k/Γ_0).
    rate = math.sqrt(drive.coupling_stiffness / float(c.gamma[c.steady_law]))
    q_u, q_w, q_0 = (abs(float(x)) for x in c.q_row)
    change = q_u + q_w * rate
    start = 0.5 * min(q_0 / change if change else math.inf, drive.input_speed / rate)
    arcs = _wind_up(drive, back, np.array([start, 0.0]), _row_of(back, mode))
    return (Boundary.CYCLE, [[*arcs]]) if arcs else (Boundary.NONE, [])


def _in_paradox(drive: Drive, c: Coefficients) -> tuple[Boundary, list[Curve]]:
    """Return the basin in the Painlevé region, from the motion that touches Q = 0."""
    touch = _touch(drive, c)
    if touch is None:
        return Boundary.NONE, []
    back = backward_automaton(drive, touch[0])
    end = np.array([float(touch[0]), float(touch[1])])
    start, mode = end * [1, -1], _row_of(back, MotionMode.SLIP_FORWARD_NEGATIVE)
    trace = _traced(back, start, mode, 2)
    if trace is None or trace.time.size == 0:
        return Boundary.NONE, []  # The motion comes from far away, so slip from θ′ = 0 never gets as far as T.
    arcs = _forward_arcs(trace, drive)
    ended = trace.automaton.codes[trace.end_mode] == BEGINNING
    if trace.before[0, 1] != drive.input_speed:  # The motion comes from Q = 0.
        return Boundary.TOUCHING_MOTION, [[arcs[-1], Segment(end, arcs[-1].start)]]
    if c.q_row[1] <= 0:
        raise InputError(
            f"translation_damping = {drive.translation_damping:g} is not below support_damping * mass / screw_inertia, "
            "so seizures lead to backward slip; the basin of such a drive cannot be computed."
        )
    with many_digits():  # else slip from θ′ = 0 may settle although release from rest does not
        upper, d = 1 if drive.axial_force >= 0 else -1, drive.exact()
        torque = c.damping[-1] * d.input_speed + d.pitch_radius * c.slack(upper) * d.axial_force
        released = torque / d.coupling_stiffness
    if not float(trace.before[0, 0]) < released:
        raise InputError(
            f"axial_force = {drive.axial_force:g} has the sign of input_speed, but the net force has not, and rest "
            "does not settle; the basin of such a drive cannot be computed."
        )
    if ended and trace.before[-1, 1] == drive.input_speed and trace.end_state[0] < touch[0]:
        raise InputError(
            f"support_damping = {drive.support_damping:g} is so large that slip from screw speed 0 cannot be traced "
            "back in double precision; the basin of such a drive cannot be computed."
        )
    if not ended:
        arcs = _wind_up(drive, back, start, mode)
        if not arcs:
            return Boundary.NONE, []
    # slip from (x, −Ω), continued along the line u = x, on which seizures end and begin
    slip, (q_u, q_w, q_0) = arcs[-1], map(float, c.q_row)
    x = slip.start[0]
    seizure = np.array([x, -(q_u * x + q_0) / q_w])
    low, high = np.array([x, -math.inf]), np.array([x, math.inf])
    curve: Curve = [Segment(low, slip.start), slip, Segment(slip.end, seizure), Segment(seizure, high)]
    return (Boundary.TOUCHING_SLIP if ended else Boundary.CYCLE), [curve]


def _touch(drive: Drive, c: Coefficients) -> tuple[arb, arb] | None:
    """Return the state in which slip touches Q = 0 from within; None if slip never crosses Q = 0 outwards."""
    d = drive.exact()  # on the line u″ = R̃ / (m r_m tan λ) − c_x w / m under either law, so Q′ = κ w + ρ along it
    q_u, q_w, q_0 = c.q_row
    with many_digits():
        kappa = q_u - q_w * d.translation_damping / d.mass
        rho = q_w * c.net_force / (d.mass * d.pitch_radius * d.tan_lead)
        at_stand = rho - kappa * d.input_speed
        if at_stand <= 0 and kappa <= 0:
            return None
        if at_stand >= 0 or kappa <= 0:
            raise InputError(
                f"translation_damping = {drive.translation_damping:g} is so large that slip crosses the line of no "
                "contact force in the opposite direction; the basin of such a drive cannot be computed."
            )
        w = -rho / kappa
        return -(q_w * w + q_0) / q_u, w


def _wind_up(drive: Drive, back: Automaton, start: NDArray[np.float64], mode: int) -> list[Arc]:
    """Return one turn of the cycle on to which a motion backwards winds; none if it grows or does not come back."""
    law, state, used, chunk = friction.depends_on_speed(drive), start, 0, 32
    # The turns only grow (docs/basin.md). By 1e9 the constants of the drive no longer count, and they grow for ever.
    far, scale = 1e9 * max(np.abs(start).max(), law * drive.input_speed), swing(drive)[0] / drive.input_speed
    most = 100_000 if law else 2_000_000  # events, some seconds: turns that still grow hardly do
    while used < most and chunk:
        trace = _traced(back, state, mode, chunk)
        if law and (trace is None or trace.status == Status.SETTLED):  # go on up to the last event before
            chunk //= 2
            continue
        if trace is None or trace.status == Status.SETTLED or np.abs(trace.after).max() > far:
            return []
        state, mode = trace.end_state, trace.end_mode
        found = steady_state(back, state, mode=mode, max_events=3000 if law else 1)
        # An event that recurs at once, within a small part of a time scale of slip, is not a turn, which has some six.
        # Under a law what a turn gains beside a cycle has to be more than the rounding of the motions.
        gain = abs(1 - abs(found.multiplier)) * np.abs(found.state / swing(drive)).max()
        real = found.residual < 1e-9 and found.period > 1e-3 * found.returns * scale and not (law and gain < 1e-12)
        if found.orbit is not None and real:
            once = found.orbit.time.size // found.returns
            turn = follow(back, found.orbit.start_state, math.inf, mode=found.orbit.start_mode, max_events=once)
            return _traced_arcs(turn) if law else _forward_arcs(turn, drive)
        used, chunk = used + chunk, 2 * chunk
    if not chunk and np.abs(state).max() > 1e-4 * far:  # what divides the modes is lost in rounding
        return []
    if not chunk:
        raise InputError(
            "followed back from steady sliding, the motion reaches speeds at which this friction law enters the "
            "Painlevé region, or never turns; the basin of such a drive cannot be computed."
        )
    raise InputError(
        f"support_damping = {drive.support_damping:g} and translation_damping = {drive.translation_damping:g} change a "
        "motion so little in each turn that the boundary of the basin cannot be followed to its end."
    )


def _traced(back: Automaton, state: NDArray[np.float64], mode: int, events: int) -> Motion | None:
    """Follow a motion backwards over some events; None if it leaves the range of numbers, as it does far away."""
    try:
        return follow(back, state, math.inf, mode=mode, max_events=events)
    except EngineError:
        return None


def _forward_arcs(trace: Motion, drive: Drive) -> list[Arc]:
    """Return the arcs of a motion backwards as arcs forward in time, the earliest first; none has zero duration."""
    codes, turned = trace.automaton.codes, np.array([1.0, -1.0])
    return [
        Arc(_row_of(automaton_of(drive), codes[arc.mode]), arc.end * turned, arc.start * turned, arc.duration)
        for arc in _traced_arcs(trace)[::-1]
    ]


def _traced_arcs(trace: Motion) -> list[Arc]:
    """Return the arcs of a motion, none of zero duration."""
    arcs = zip(*trace.arcs(), strict=True)
    return [Arc(int(mode), start, end, float(time)) for mode, start, end, time in arcs if time > 0]


def _row_of(automaton: Automaton, mode: int) -> int:
    return int(np.flatnonzero(automaton.codes == mode)[0])


def _mirrored(found: Basin, drive: Drive) -> Basin:
    """Return the basin of a drive from that of the drive with Ω and R reversed: the plane turned by half a turn."""
    automaton = automaton_of(drive)

    def turned(piece: Segment | Arc) -> Segment | Arc:
        if isinstance(piece, Segment):
            return Segment(-piece.start, -piece.end)
        # with both signs reversed
        code = MotionMode.SLIP_BACKWARD_NEGATIVE - int(automaton_of(found.drive).codes[piece.mode])
        return Arc(_row_of(automaton, code), -piece.start, -piece.end, piece.duration)

    curves = tuple([turned(piece) for piece in curve] for curve in found.curves)
    return Basin(drive, found.boundary, curves)
