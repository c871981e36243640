"""The axial force below which steady sliding is globally stable in the Painlevé region (Γ₊ ≤ 0, end of Sect. 8.7).

With R̃ < 0 (Ω > 0) all slip is that of law −1 about steady sliding, one damped oscillator whatever R is; R moves the
line Q = Q_uw(u, w) + Γ₋ R̃ = 0, at which slip seizes, and, for R > 0, the end of rest. As docs/basin.md proves, a motion
that does not settle either rests again and again, or slips for ever between seizures without rest, and both go on under
larger forces. So the threshold is the smaller one of the forces at which the first of each begins.
"""

import math
from typing import Any

from lsvib.dynamics.forward_slip import ForwardDrive, many
from lsvib.engine.automaton import oscillator
from lsvib.engine.kernels import flow_planar, layout
from lsvib.errors import NoThreshold
from lsvib.stability.motion_equations import ReturnEquations, Start

_GRID = 240  # durations of slip in equal ratios, of which the best is refined
_FARTHEST = 700.0  # logarithm of the ratio of the longest duration to the shortest; that of the largest double is 709
_GOLDEN = 0.3819660112501051  # (3 − √5) / 2
_REFINEMENTS = 40  # They leave 4e-9 of the bracket; near a maximum the value is then wrong by the square of that.
_NEWTON = 200  # steps at most; on a convex function they approach the root from one side, at last quadratically
_EXACT = 1e-40  # relative size of the last step; the coefficients have 50 digits
_NONE = Start("", many.inf)


def start(forward: ForwardDrive) -> Start:
    """Return the threshold with its equations; its force is infinite if there is none below R_on.

    Requires Γ₊ ≤ 0 and C₋ > 0. Raises ``NoThreshold`` for the drives with q_w < 0 for which cycles without rest cannot
    be excluded, where Newton's method does not come to its end, and where slip is beyond the range of doubles.
    """
    if forward.outward <= 0:
        return _NONE  # slip seizes while u falls, so each seizure is left of the last, and their number is finite
    found = rest_goes_on_from(forward)
    if forward.contact[1] > 0:
        found = min(found, fold(forward)[0], key=lambda at: at.force)
    elif forward.contact[1] < 0:
        _require_rest_in_every_cycle(forward, found.force)
    return found if found.force < forward.onset else _NONE


def rest_goes_on_from(forward: ForwardDrive) -> Start:
    """Smallest R < R_on [N] at which slip from the end of rest seizes; infinite if there is none.

    For R ≤ 0 rest ends at u = C₋ Ω / k; for R > 0 it ends farther left, by r (ξ₊ − ξ₋) R / k. Raises ``NoThreshold`` if
    Newton's method does not find it.
    """
    slip, inertia = forward.slip(-1), forward.inertia[-1]
    first = forward.damping[-1] * forward.speed / forward.stiffness
    found = slip.peak(first, -forward.speed, forward.contact)
    if found is not None and forward.onset < found[0] / inertia:
        return Start("rest seizes", forward.onset - found[0] / inertia, (found[1],))
    # Among 0 ≤ R < R_on: the largest Q_uw of that slip is the maximum of functions that are linear in R, so convex.
    reach = forward.radius * (forward.xi[1] - forward.xi[-1]) / forward.stiffness
    force = forward.onset
    for _ in range(_NEWTON):
        if force <= 0:
            # Without c_x there is no force with the motion.
            return Start("rest seizes", force, (found[1],)) if forward.onset > 0 else _NONE
        found = slip.peak(first - reach * force, -forward.speed, forward.contact)
        if found is None or (force == forward.onset and found[0] <= 0):
            return _NONE
        c, s, _ = slip.responses(found[1])
        slope = inertia - reach * (forward.contact[0] * c - forward.contact[1] * slip.a0 * s)
        step = (found[0] - inertia * (forward.onset - force)) / slope
        force -= step
        if abs(step) <= _EXACT * forward.onset:
            return Start("rest seizes with the motion", force, (found[1],))
    raise NoThreshold(
        "the force from which slip from the end of rest seizes is not known: Newton's method has not come to its end; "
        "please report it."
    )


def fold(forward: ForwardDrive) -> tuple[Start, Any]:
    """Smallest R [N] at which slip can seize again and again without rest, infinite if there is none; q_w > 0.

    Two cycles of seizures meet there. Returns it with the u [rad] at which they seize. Raises ``NoThreshold`` where
    slip is beyond the range of doubles.
    """
    try:
        widest, x, time = widest_return(forward)
    except (ZeroDivisionError, OverflowError):
        raise NoThreshold(
            "the force from which slip seizes again and again is not known: its durations lie so far apart that "
            "doubles do not hold them."
        ) from None
    return Start("fold", forward.onset - widest / forward.inertia[-1], (time,)), x


def widest_return(forward: ForwardDrive):
    """Largest Q_uw at which slip from θ′ = 0 at u = x < C₋ Ω / k [rad] first comes back to u = x; q_w > 0.

    Returns it with that x and the time τ [s] of the slip, which starts at x = −Ω S / (1 − C) and has the rate
    w = −Ω S′ − a₀ x S as it comes back, so that the maximum is one over τ. It is found in double precision; its value
    is formed with 50 digits. Minus infinity if no slip comes back.
    """
    row = oscillator(*forward.decimals, 0)
    speed, (q_u, q_w), a0 = float(forward.speed), (float(x) for x in forward.contact), float(row[layout.A0])
    largest = float(forward.damping[-1] * forward.speed / forward.stiffness)

    def height(time: float) -> float:
        """Q_uw of the slip that comes back after a time; minus infinity if it starts or returns where none can."""
        _, s, s_rate = flow_planar.responses(row, time)
        x = -speed * s / (a0 * flow_planar.integrated_response(row, time))
        w = -speed * s_rate - a0 * x * s
        return q_u * x + q_w * w if x < largest and w > 0 else -math.inf

    # Q_uw ≤ q_u x + q_w Ω, since slip decays, and x lies between −2 Ω / (a₀ τ) and −Ω / (a₀ τ) as long as τ is short
    # against the slowest time: the maximum is not earlier. Slip that turns comes back within a turn; other slip has all
    # but stopped after 40 times its slowest time.
    turns = row[layout.BETA] > 0
    slowest = row[layout.TIME_SCALE] if turns else -1 / row[layout.R1]
    low = 0.1 * min(q_u / (a0 * q_w), slowest)
    high = 2 * float(many.pi) / row[layout.BETA] if turns else 40 * slowest
    if not 0 < low < high < many.inf or math.log(high) - math.log(low) > _FARTHEST:
        raise OverflowError
    times = [low * (high / low) ** (k / _GRID) for k in range(_GRID)]
    heights = [height(time) for time in times]
    count = next((k for k, value in enumerate(heights) if value == -math.inf), len(heights))
    if count == 0:
        return -many.inf, many.nan, many.nan
    best = max(range(count), key=heights.__getitem__)
    low, high = times[max(best - 1, 0)], times[best + 1] if best + 1 < _GRID else high
    for _ in range(_REFINEMENTS):
        left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
        low, high = (left, high) if height(left) < height(right) else (low, right)
    time = 0.5 * (low + high)
    time = many.mpf(time if height(time) >= heights[best] else times[best])
    back = ReturnEquations(forward.slip(-1), forward.contact, forward.speed, time)
    return back.h, back.x, time


def _require_rest_in_every_cycle(forward: ForwardDrive, force) -> None:
    """Refuse the drives with q_w < 0 that may have cycles without rest, by the sufficient conditions of docs/basin.md.

    ``force`` [N] is the threshold by rest. The largest u that slip from (−u_p, −Ω), u_p = C₋ Ω / k, reaches on the
    right bounds that of all other slip; the gap is u_c − u_p.
    """
    slip, speed = forward.slip(-1), forward.speed
    first = forward.damping[-1] * speed / forward.stiffness
    found = slip.peak(-first, -speed, (1, 0))
    if found is None or found[0] <= 0:
        return  # slip never gets to the right of u_p, where backward slip begins
    if found[0] < first:
        if force < 0:
            return
        overshoot = many.exp(-many.pi * slip.alpha / slip.beta) if slip.turns else many.mpf(0)
        swing = slip.peak(0, -speed, (1, 0))[0]
        if overshoot <= 0.5 and overshoot * first + swing <= 2 * first:
            return
    if force < 0:
        slope = -forward.contact[1] / forward.contact[0]
        gap = -force * forward.inertia[-1] / (forward.stiffness * forward.mass * forward.lever)
        if gap > min(slope * speed / 2, 25 * slope**3 * slip.a0 * speed / 8):
            return
    raise NoThreshold(
        "the drive has support_damping * mass < translation_damping * screw_inertia and so little damping that cycles "
        "of seizures without rest are not excluded; such drives are not covered."
    )
