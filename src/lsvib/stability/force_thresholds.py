"""The axial forces at which the steady state changes kind, from closed forms and return maps (Poincaré maps).

Every ``*_start`` says which statement its force divides, and on which forces, and returns where Newton's method starts
(:class:`~lsvib.stability.motion_equations.Start`). All is written for Ω > 0; for Ω < 0 the drive is mirrored, and all
forces change sign. Each raises ``NoThreshold`` where there is no such force.

In the Painlevé region with R̃ < 0 all slip is that of law −1 about steady sliding, one damped oscillator whatever R is;
R moves the line Q = Q_uw(u, w) + Γ₋ R̃ = 0, at which slip seizes, and, for R > 0, the end of rest. docs/thresholds.md
says what happens there, and at which cycles.
"""

import math
from collections.abc import Callable
from itertools import takewhile
from typing import Any

from flint import arb

from lsvib.drives.complaints import allowed_range
from lsvib.drives.drive import Drive
from lsvib.errors import NoThreshold
from lsvib.stability.motion_equations import Return, Start
from lsvib.stability.slip import CLOSE, SlipDrive, slowest_point
from lsvib.stability.solve import bracketed_root
from lsvib.systems.exact.arithmetic import many_digits

_NONE = Start("", arb.pos_inf())


def threshold_force(drive: Drive, name: str) -> float:
    """Return an axial force [N] by the name of its threshold, as :data:`STARTS` has it: its value alone.

    For charts of many drives; ``drive.threshold(name)`` encloses it. Raises ``NoThreshold``.
    """
    with many_digits():
        return math.copysign(1.0, drive.input_speed) * float(STARTS[name](drive).force)


def _negatively_damped(drive: Drive, rest: bool = False) -> SlipDrive:
    """Constants of a drive with Γ₊ > 0 > C₊; ``rest`` as of :meth:`SlipDrive.of`."""
    d = SlipDrive.of(drive, rest)
    if not d.inertia[1] > 0:
        raise NoThreshold(
            "the drive is in the Painlevé region (effective inertia of law + not positive), outside conditions (8.19)."
        )
    if not d.damping[1] < 0:
        raise NoThreshold(
            "the effective damping of law + is not negative, so no axial force satisfies conditions (8.19)."
        )
    return d


def _apart(start: Start, d: SlipDrive) -> Start:
    """Refuse a force of the mirrored drive that is the onset to the last digit, or that exceeds all allowed forces."""
    if float(start.force) == float(d.onset):
        raise NoThreshold("it would equal the onset, R = r_m tan(lead_angle) c_x Omega, to rounding.")
    if abs(start.force) > 1e12:
        raise NoThreshold(f"the force would be outside the allowed range {allowed_range(Drive, 'axial_force')}.")
    return start


def stick_start(drive: Drive) -> Start:
    """Axial force at which the slip cycle first touches θ′ = 0.

    From the onset to this force a cycle of slip without θ′ = 0 attracts motions from near steady sliding; beyond it, up
    to any force, they come to θ′ = 0. Without that guard the motion scales with R̃, so that R̃ = Ω / |w_1| with the
    extreme velocity w_1 of the cycle at R̃ = 1 N.
    """
    d = _negatively_damped(drive)
    plus, minus = d.slip(1), d.slip(-1)
    if not plus.turns:
        raise NoThreshold(
            "slip of this drive grows under law + without turning back, so no limit cycle of slip can touch rest."
        )
    # The logarithm by which a large motion has decayed after a turn; infinite where slip under law − does not turn.
    decay = arb.pi() * (plus.alpha / plus.beta + minus.alpha / minus.beta) if minus.turns else arb.pos_inf()
    if abs(decay) <= 1e-12:  # rounding
        raise NoThreshold(
            "growth under law + and decay under law - balance to rounding in large motions of this drive, so whether "
            "slip without rest has a limit cycle is undecided."
        )
    if decay < 0:
        raise NoThreshold("slip of this drive without rest has no limit cycle, so at no force does one touch rest.")
    rate, law, times = slowest_point(d)
    return _apart(Start("stick+" if law > 0 else "stick-", d.onset - d.speed / rate, times), d)


def detach_start(drive: Drive) -> Start:
    """Axial force beyond which the stick–slip cycle no longer reaches N = 0.

    From the onset to this force slip from the end of rest reaches N = 0 before it ends, and so does every cycle with
    rest; beyond it, up to any force, that slip stays in N ≠ 0 and ends in rest: one stick–slip cycle, without N = 0.
    Rest ends at u = C₊ Ω / k whatever R is, and the slip under law + that follows depends on R only through N; so it
    touches Q = Q_uw(u, w) + Γ₊ R̃ = 0 at R̃ = −min Q_uw / Γ₊.
    """
    d = _negatively_damped(drive, rest=True)
    slip = d.slip(1)
    if not slip.turns:
        raise NoThreshold(
            "slip of this drive grows under law + without turning back to rest, so every cycle with rest reaches "
            "N = 0, whatever the force."
        )
    start = d.end_without_force(1), -d.speed
    end = slip.recurrence()
    times = [end, *takewhile(lambda time: time < end, slip.stationary(*start, d.contact))]
    states = (slip.state(*start, time) for time in times)
    lowest, at = min(((d.contact[0] * u + d.contact[1] * w, time) for (u, w), time in zip(states, times, strict=True)),
                     key=lambda pair: pair[0])  # fmt: skip
    if not lowest < 0:
        raise NoThreshold("no axial force beyond the onset makes slip from the end of rest reach N = 0.")
    force = d.onset - lowest / d.inertia[1]
    # Slip ends in rest if T_r is not below r ξ₋ R there, that is u − C₊ Ω / k not above r (ξ₊ − ξ₋) R / k.
    if slip.state(*start, end)[0] - start[0] > d.reach * force:
        raise NoThreshold(
            "at the force beyond which slip from the end of rest no longer reaches N = 0, it ends in backward slip, "
            "not in rest; cycles of such drives cannot be computed."
        )
    return _apart(Start("detach" if at < end else "detach at rest", force, (at,)), d)


def global_stability_start(drive: Drive) -> Start:
    """Axial force below which steady sliding is globally stable and above which it is not (end of Sect. 8.7).

    Under any force below it every motion ends in steady sliding, under any from it to R_on = r_m tan λ c_x Ω some do
    not; beyond R_on steady sliding is unstable (Lemma 8.1). This holds for the rule ``resume="contact_sign"``, and for
    R < 0 under both rules. As docs/basin.md proves, a motion that does not settle either rests again and again, or
    slips for ever between seizures without rest, and both go on under larger forces: the threshold is the smaller one
    of the forces at which the first of each begins. For the few drives with m c < c_x I for which this is not proved
    there is none.
    """
    d = SlipDrive.of(drive, rest=True)
    if not d.inertia[1] <= 0:
        raise NoThreshold(
            "the drive is not in the Painlevé region (effective inertia of law + positive), where no motion seizes."
        )
    if not d.damping[-1] > 0:
        raise NoThreshold("without damping, steady sliding attracts no motion.")
    found = _NONE
    if d.outward > 0:  # else slip seizes while u falls: each seizure is left of the last, and their number is finite
        found = _rest_goes_on_from(d)
        if d.contact[1] > 0:
            widest, time = widest_return(d)
            fold = Start("fold", d.onset - widest / d.inertia[-1], (time,))  # two cycles of seizures without rest meet
            found = min(found, fold, key=lambda at: at.force)
        elif d.contact[1] < 0:
            slope = -d.contact[1] / d.contact[0]
            gap = -found.force * d.inertia[-1] / (d.stiffness * d.mass * d.lever)  # u_c − u_p of docs/basin.md
            if not gap > min(slope * d.speed / 2, 25 * slope**3 * d.slip(-1).a0 * d.speed / 8):
                raise NoThreshold(
                    "the drive has support_damping * mass < translation_damping * screw_inertia, so "
                    "cycles of seizures without rest are not ruled out; such drives cannot be computed."
                )
    if not found.force < d.onset:
        with_motion = " and every one with it below the onset, R = r_m tan(lead_angle) c_x Omega"
        raise NoThreshold(
            "steady sliding is globally stable under every axial force against the motion"
            f"{with_motion if drive.translation_damping else ''}."
        )
    return _apart(found, d)


def _rest_goes_on_from(d: SlipDrive) -> Start:
    """Smallest R < R_on [N] at which slip from the end of rest seizes; infinite if there is none."""
    slip, inertia = d.slip(-1), d.inertia[-1]
    found = slip.peak(d.end_without_force(), -d.speed, d.contact)
    if found is not None and d.onset < found[0] / inertia:
        return Start("rest seizes", d.onset - found[0] / inertia, (found[1],))

    def excess(force: arb) -> Any:
        """By how much slip from the end of rest goes beyond Q = 0."""
        found = slip.peak(d.end_of_rest(force), -d.speed, d.contact)
        return (arb(-1) if found is None else found[0]) - inertia * (d.onset - force)

    # Among 0 ≤ R < R_on: the largest Q_uw of that slip is the maximum of functions that are linear in R, so convex.
    if not (d.onset > 0 and excess(d.onset) > 0):
        return _NONE
    force = bracketed_root(excess, arb(0), d.onset, CLOSE)
    found = slip.peak(d.end_of_rest(force), -d.speed, d.contact)
    return _NONE if found is None else Start("rest seizes", force, (found[1],))


def _durations(d: SlipDrive) -> list[arb]:
    """Durations [s] of slip under law − from θ′ = 0 until it is back at the same u, 240 in equal ratios; q_w > 0.

    Q_uw ≤ q_u x + q_w Ω, since slip decays, and x lies between −2 Ω / (a₀ τ) and −Ω / (a₀ τ) as long as τ is short
    against the slowest time: nothing happens earlier. Slip that turns comes back within a turn; other slip has all but
    stopped after 40 times its slowest time.
    """
    slip, (q_u, q_w) = d.slip(-1), d.contact
    slowest = 1 / slip.a0.sqrt() if slip.turns else -1 / slip.rates[0]
    low, high = 0.1 * min(q_u / (slip.a0 * q_w), slowest), 2 * arb.pi() / slip.beta if slip.turns else 40 * slowest
    step = (high / low).log() / 240
    return [(low * (k * step).exp()).mid() for k in range(240)]


def widest_return(d: SlipDrive) -> tuple[arb, arb]:
    """Largest Q_uw at which slip from θ′ = 0 at u = x < C₋ Ω / k [rad] first comes back to u = x; q_w > 0.

    Returns it with the time τ [s] of the slip. Minus infinity if no slip comes back.
    """
    largest, times = d.end_without_force(), _durations(d)

    def comes_back(back: Return) -> bool:
        return bool(back.x < largest and back.w > 0)

    returns = list(takewhile(comes_back, (Return(d, time) for time in times)))
    if not returns:
        return arb.neg_inf(), arb.nan()
    best = max(range(len(returns)), key=lambda k: float(returns[k].h))
    low, high, beyond = times[max(best - 1, 0)], times[best], times[min(best + 1, len(times) - 1)]
    if comes_back(Return(d, beyond)):
        high = beyond
    else:  # as far as slip comes back
        for _ in range(60):
            middle = ((high + beyond) / 2).mid()
            high, beyond = (middle, beyond) if comes_back(Return(d, middle)) else (high, middle)

    time = low if Return(d, low).h_rate < 0 else high
    if Return(d, low).h_rate > 0 > Return(d, high).h_rate:
        time = bracketed_root(lambda time: Return(d, time).h_rate, low, high, CLOSE)
    return Return(d, time).h, time


STARTS: dict[str, Callable[[Any], Start]] = {
    "onset": lambda drive: Start("", _negatively_damped(drive).onset),  # (8.15, 8.19)
    "stick": stick_start,
    "detach": detach_start,
    "global_stability": global_stability_start,
}
"""Thresholds that are forces in closed form, for rigid drives mirrored to Ω > 0; no other model has one of the name."""
