"""The axial forces at which the steady state changes kind: roots of closed-form conditions or of the return map.

Every function here says which statement its force divides, and on which forces. It is written for Ω > 0; for Ω < 0 the
drive is mirrored, and all forces change sign.
"""

import math
from itertools import takewhile

from lsvib.dynamics.forward_slip import ForwardDrive, many
from lsvib.dynamics.slip_cycle import decay_of_large_motions, slowest_point
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.errors import NoThreshold
from lsvib.models.drive import RigidDrive, allowed_range
from lsvib.models.mechanics import Coefficients, coefficients
from lsvib.stability.motion_equations import Start

__all__ = ["NoThreshold", "detach_force", "global_stability_force", "onset_force", "stick_force"]

_LARGEST_FORCE = 1e12  # N, the bound of ``axial_force``
_BALANCED = 1e-12  # large motions that decay by less in a turn doubles cannot distinguish from undamped ones


def _negatively_damped(drive: RigidDrive) -> Coefficients:
    """Coefficients of a drive with Γ₊ > 0 > C₊."""
    c = coefficients(drive)
    if c.paradox:
        raise NoThreshold(
            "the drive is in the Painleve region (effective inertia of law + not positive), outside conditions (8.19)."
        )
    if c.damping[1] >= 0:
        raise NoThreshold(
            "the effective damping of law + is not negative, so conditions (8.19) hold for no axial force."
        )
    return c


def seizing(drive: RigidDrive, undamped: str) -> ForwardDrive:
    """Return a drive mirrored to Ω > 0; refused outside the Painlevé region and, in words of its own, if undamped."""
    c = coefficients(drive)
    if not c.paradox:
        raise NoThreshold(
            "the drive is not in the Painleve region (effective inertia of law + positive), where no motion seizes."
        )
    if c.damping[-1] <= 0:
        raise NoThreshold(undamped)
    return ForwardDrive(drive, c)


def _apart(start: Start, forward: ForwardDrive) -> Start:
    """Refuse a force of the mirrored drive that is the onset to the last digit, or that exceeds all allowed forces."""
    if float(start.force) == float(forward.onset):
        raise NoThreshold(
            "the force at which it would lie equals the onset, R = r_m tan(lead_angle) c_x Omega, to rounding."
        )
    if abs(start.force) > _LARGEST_FORCE:
        raise NoThreshold(
            f"the force at which it would lie is outside the allowed range {allowed_range(RigidDrive, 'axial_force')}."
        )
    return start


def _force(value, drive: RigidDrive) -> float:
    """A force [N] of the mirrored drive as one of the drive itself."""
    return math.copysign(1.0, drive.input_speed) * float(value)


def onset_force(drive: RigidDrive) -> float:
    """Axial force R [N] at which N_0 = 0 and steady sliding loses stability, R = r_m tan λ c_x Ω (eqs 8.15, 8.19).

    Below it (R̃ < 0) steady sliding attracts what is near, above it (R̃ > 0) it repels, for all forces. Raises
    ``NoThreshold`` in the Painlevé region and where the effective damping of law + is not negative.
    """
    _negatively_damped(drive)
    d = drive.exact()
    with many_digits():
        return float(d.pitch_radius * d.tan_lead * d.translation_damping * d.input_speed)


def stick_force(drive: RigidDrive) -> float:
    """Axial force R [N] at which the slip cycle first touches θ′ = 0.

    From the onset to this force there is a cycle of slip that does not come to θ′ = 0 and that attracts motions from
    near steady sliding; beyond it, up to any force, there is none, and motions from near steady sliding come to θ′ = 0.
    Without that guard the motion scales with R̃, so that R̃ = Ω / |w_1| with the extreme velocity w_1 of the cycle at R̃ =
    1 N. Raises ``NoThreshold`` if slip has no such cycle.
    """
    return _force(stick_start(drive).force, drive)


def stick_start(drive: RigidDrive) -> Start:
    """Return :func:`stick_force` of the drive mirrored to Ω > 0, with its equations."""
    forward = ForwardDrive(drive, _negatively_damped(drive))
    if not forward.slip(1).turns:
        raise NoThreshold(
            "slip under law + grows without a turn for this drive, so slip has no limit cycle that could touch rest."
        )
    decay = decay_of_large_motions(forward)
    if abs(decay) <= _BALANCED:
        raise NoThreshold(
            "growth under law + and decay under law - balance to rounding in large motions of this drive, so whether "
            "slip without rest has a limit cycle is not decided."
        )
    if decay < 0:
        raise NoThreshold(
            "slip without rest has no limit cycle for this drive, so there is no force at which one touches rest."
        )
    point = slowest_point(forward)
    force = forward.onset + forward.speed / -point.rate
    return _apart(Start("stick+" if point.law > 0 else "stick-", force, (*point.times, point.at)), forward)


def detach_force(drive: RigidDrive) -> float:
    """Axial force R [N] beyond which the stick–slip cycle no longer reaches N = 0.

    From the onset to this force slip from the end of rest reaches N = 0 before it ends, and so does every cycle with
    rest; beyond it, up to any force, that slip stays in N ≠ 0 and ends in rest: one stick–slip cycle, without N = 0.
    Rest ends at u = C₊ Ω / k whatever R is, and the slip under law + that follows depends on R only through N; so it
    touches Q = Q_uw(u, w) + Γ₊ R̃ = 0 at R̃ = −min Q_uw / Γ₊. Raises ``NoThreshold`` if slip under law + does not come
    back to θ′ = 0, if it reaches N = 0 under no force beyond the onset, and if it does not end in rest at that force.
    """
    return _force(detach_start(drive).force, drive)


def detach_start(drive: RigidDrive) -> Start:
    """Return :func:`detach_force` of the drive mirrored to Ω > 0, with its equations."""
    forward = ForwardDrive(drive, _negatively_damped(drive))
    slip = forward.slip(1)
    if not slip.turns:
        raise NoThreshold(
            "slip under law + grows without a turn and does not come back to rest for this drive, so every cycle with "
            "rest reaches N = 0, whatever the force."
        )
    start = forward.damping[1] * forward.speed / forward.stiffness, -forward.speed
    end = slip.recurrence()
    times = [end, *takewhile(lambda time: time < end, slip.stationary(*start, forward.contact))]
    states = (slip.state(*start, time) for time in times)
    values = [forward.contact[0] * u + forward.contact[1] * w for u, w in states]
    if min(values) >= 0:
        raise NoThreshold("slip from the end of rest reaches N = 0 under no axial force beyond the onset.")
    force = forward.onset - min(values) / forward.inertia[1]
    # Slip ends in rest if T_r is not below r ξ₋ R there, that is u − C₊ Ω / k not above r (ξ₊ − ξ₋) R / k.
    overshoot = slip.state(*start, end)[0] - start[0]
    if forward.stiffness * overshoot > forward.radius * (forward.xi[1] - forward.xi[-1]) * force:
        raise NoThreshold(
            "at the force beyond which slip from the end of rest no longer reaches N = 0 that slip ends in slip "
            "backward, not in rest; the cycles of such drives are not covered."
        )
    lowest = times[values.index(min(values))]
    return _apart(Start("detach" if lowest < end else "detach at rest", force, (lowest,)), forward)


def global_stability_force(drive: RigidDrive) -> float:
    """Axial force R [N] below which steady sliding is globally stable and above which it is not (end of Sect. 8.7).

    The statement is about all forces with R̃ < 0, that is R < R_on = r_m tan λ c_x Ω: those against the motion, R < 0,
    and those with it that are smaller than what drags the nut, 0 ≤ R < R_on. Under any force below the threshold every
    motion ends in steady sliding; under any force from the threshold to R_on some do not. (Beyond R_on steady sliding
    is unstable, Lemma 8.1.) It holds for the rule ``resume="contact_sign"``, and for R < 0 under both rules. Raises
    ``NoThreshold`` outside the Painlevé region, without damping, where steady sliding is globally stable under every
    force with R̃ < 0, and for the few drives with m c < c_x I for which this is not proved; see docs/basin.md.
    """
    return _force(global_stability_start(drive).force, drive)


def global_stability_start(drive: RigidDrive) -> Start:
    """Return :func:`global_stability_force` of the drive mirrored to Ω > 0, with its equations."""
    forward = seizing(drive, "without damping steady sliding attracts nothing.")
    from lsvib.stability.force_thresholds import start  # loads the engine

    found = start(forward)
    if found.force == many.inf:
        with_motion = " and under every smaller one with it than the onset, R = r_m tan(lead_angle) c_x Omega"
        raise NoThreshold(
            "steady sliding is globally stable under every axial force against the motion"
            f"{with_motion if drive.translation_damping else ''}."
        )
    return _apart(found, forward)
