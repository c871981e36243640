"""Thresholds of cycles of seizures in the Painlevé region: where they are born, fold, and lose their rest.

Slip under law − from θ′ = 0 that is back at its first deflection after τ started at x(τ), with h(τ) = Q_uw then
(:mod:`lsvib.stability.motion_equations`). If Q = h + Γ₋ R̃ = 0 there it seizes in the state that it started from:
a cycle without rest. For R̃ < 0 < q_w two of these, one attracting and one repelling, exist on one side of the *fold*,
where dh/dτ = 0; the repelling one goes on until it touches Q = 0 where it seizes, Q′ = 0, its *birth* seen from there.
Slip from the end of rest that seizes just there leaves no time for rest: the *loss of the rest phase*.
"""

from collections.abc import Callable
from typing import Any

from lsvib.dynamics.forward_slip import ForwardDrive, bracketed_root, double, many
from lsvib.errors import NoThreshold
from lsvib.models.drive import RigidDrive
from lsvib.stability.force_thresholds import seizing
from lsvib.stability.motion_equations import ReturnEquations, Start

_GRID = 240  # durations of slip that are looked at, in ratio, before a root among them is refined
_CLOSE = 1e-13  # relative, of a root: Newton's method squares it in every step
_FEW_TURNS = 40.0  # slowest times after which slip without a turn has all but stopped
_FIRST = 0.1  # of the shortest time in which slip does anything: no root is earlier


def _forward(drive: RigidDrive) -> ForwardDrive:
    return seizing(drive, "without damping no cycle of this drive is isolated.")


def _without_rest(drive: RigidDrive) -> ForwardDrive:
    forward = _forward(drive)
    if forward.contact[1] <= 0 or forward.outward <= 0:
        raise NoThreshold(
            "the drive has support_damping * mass <= translation_damping * screw_inertia, or slip that leaves Q < 0 "
            "only backwards, so no cycle of seizures goes on without rest."
        )
    return forward


def end_of_rest(forward: ForwardDrive, force: Any) -> Any:
    """Deflection [rad] from the equilibrium of law − at which rest ends under a force R [N]."""
    first = forward.damping[-1] * forward.speed / forward.stiffness
    return first - forward.radius * (forward.xi[1] - forward.xi[-1]) * max(force, 0) / forward.stiffness


class _Returns:
    """Slip under law − from θ′ = 0, by the time [s] after which it is back at the deflection that it started from."""

    def __init__(self, forward: ForwardDrive, context: Any = many) -> None:
        self.slip: Any = forward.slip(-1, context)
        self.speed, q_u, q_w = (context.mpf(x) for x in (forward.speed, *forward.contact))
        self.contact = q_u, q_w
        slowest = 1 / self.slip.a0**0.5 if self.slip.turns else -1 / self.slip.slow
        first = min(q_u / (self.slip.a0 * q_w), slowest) if q_w > 0 else slowest
        self.ends = _FIRST * first, 2 * context.pi / self.slip.beta if self.slip.turns else _FEW_TURNS * slowest

    def at(self, time: Any) -> ReturnEquations:
        """Return the slip that comes back after a time."""
        return ReturnEquations(self.slip, self.contact, self.speed, time)


def _first_root(forward: ForwardDrive, function: Callable[[ReturnEquations], Any]) -> Any:
    """The first time at which a function of returns changes sign while slip comes back forward; None if there is none.

    In double precision as long as that can be: Newton's method goes on from there.
    """
    for context in (double, many):
        returns = _Returns(forward, context)
        try:
            bracket = _bracket(returns, function)
            if bracket is None:
                return None
            return many.mpf(bracketed_root(lambda time, at=returns.at: function(at(time)), *bracket, _CLOSE))
        except (ZeroDivisionError, OverflowError):  # 1 − C rounds to zero, or slip grows beyond all numbers
            continue
    return None


def _bracket(returns: _Returns, function: Callable[[ReturnEquations], Any]) -> tuple[Any, Any] | None:
    (low, high), last = returns.ends, None
    for k in range(_GRID):
        time = low * (high / low) ** (k / _GRID)
        back = returns.at(time)
        if back.w <= 0:
            return None
        value = function(back)
        if last is not None and (value > 0) != (last[1] > 0):
            return last[0], time
        last = time, value
    return None


def fold_start(drive: RigidDrive) -> Start:
    """Axial force R [N] at which two cycles of seizures without rest meet and vanish, for Ω > 0.

    Raises ``NoThreshold`` where there is none.
    """
    from lsvib.stability.force_thresholds import fold  # loads the engine

    forward = _without_rest(drive)
    found, x = fold(forward)
    if found.force == many.inf:
        raise NoThreshold("slip under law - never comes back to where it started, so no cycle goes on without rest.")
    return _before_rest(found, x, forward)


def cycle_birth_start(drive: RigidDrive) -> Start:
    """Axial force R [N] at which the repelling cycle without rest touches Q = 0 where it seizes, for Ω > 0.

    Raises ``NoThreshold`` where there is none.
    """
    forward = _without_rest(drive)
    returns = _Returns(forward)
    time = _first_root(forward, lambda back: back.q_rate)
    if time is None:
        raise NoThreshold("slip under law - that comes back to where it started never touches Q = 0 there.")
    back = returns.at(time)
    force = forward.onset - back.h / forward.inertia[-1]
    return _before_rest(Start("cycle_birth", force, (time,)), back.x, forward)


def _before_rest(start: Start, x: Any, forward: ForwardDrive) -> Start:
    """Refuse a cycle without rest that would begin where the screw rests, or where steady sliding is unstable."""
    if start.force >= forward.onset:
        raise NoThreshold("the force at which it would lie is not below the onset, R = r_m tan(lead_angle) c_x Omega.")
    if x >= end_of_rest(forward, start.force):
        raise NoThreshold("the cycle without rest would begin where the screw still rests, so there is none.")
    return start


def rest_left(drive: RigidDrive) -> tuple[Any, Start]:
    """Return Q as slip from the end of rest is back at that deflection, and the equations of its zero.

    Where Q < 0 it seizes later, and rests again; where Q > 0 it has seized before, and goes on without rest. Raises
    ``NoThreshold`` if it does not come back, or has met Q = 0 long before.
    """
    forward = _forward(drive)
    force = many.mpf(drive.axial_force) * (1 if drive.input_speed > 0 else -1)
    returns, begins = _Returns(forward), float(end_of_rest(forward, force))  # Newton's method adds the digits
    time = _first_root(forward, lambda back: back.x - begins)
    if time is None:
        raise NoThreshold("slip from the end of rest does not come back to where it started.")
    net = forward.inertia[-1] * (force - forward.onset)
    back = returns.at(time)
    if back.q_rate <= 0:
        raise NoThreshold("slip from the end of rest seizes long before it is back where it started, or never.")
    name = "rest lost with the motion" if force > 0 else "rest lost"
    return back.h + net, Start(name, force, (time,))
