"""The limit cycle of slip without rest for Γ₊ > 0 > C₊ and R̃ Ω > 0, by its two half returns (Sect. 8.5).

Without θ′ = 0 the drive is a plane system, linear on either side of Q = 0 and continuous there, and everything in it is
in proportion to R̃. Under law s, Q is an oscillator about E_s = Γ_s R̃ > 0; both laws have the same Q′ on Q = 0. A motion
that leaves Q = 0 with the slope v and comes back for the first time after τ does so with

    v = −E (1 − C) / S,        v̂ = v S′ + E a₀ S                                  (responses C, S at τ).

The cycle is a pair of times at which v̂₊ = v₋ and v̂₋ = v₊. There is exactly one if slip under law + turns and large
motions decay, π α₊ / β₊ + π α₋ / β₋ > 0, and none otherwise: two zones, one equilibrium, which repels (Freire, Ponce,
Rodrigo and Torres 1998).
"""

from typing import Any, NamedTuple

from lsvib.dynamics.forward_slip import ForwardDrive, bracketed_root, double, many
from lsvib.errors import NoThreshold

_NEWTON = 8  # steps at most; three steps lead from an error of 1e-7 to all 50 digits
_EXACT = 1e-35  # relative residual of a solution; the coefficients have 50 digits
_SEARCHES = (
    # The arithmetic, the smallest phase beyond half a turn that is tried, and the relative error of Newton's start.
    (double, 1e-10, 1e-7),
    (many, 1e-40, 1e-20),  # where large motions hardly decay, or rates lie so far apart that double precision fails
)


class Half(NamedTuple):
    """Slopes with which a half return leaves Q = 0 and comes back, and their derivatives with respect to its time."""

    leaves: Any
    comes: Any
    leaves_rate: Any
    comes_rate: Any


def half_return(slip: Any, height: Any, time: Any) -> Half:
    """Return the half return that takes ``time`` [s], with the equilibrium at Q = ``height``.

    ``slip`` is one of :mod:`lsvib.dynamics.forward_slip`, or has its ``a0``, ``a1`` and ``responses`` in another
    arithmetic.
    """
    c, s, s_rate = slip.responses(time)
    leaves = -height * (1 - c) / s
    leaves_rate = -height * (slip.a0 * s * s - (1 - c) * s_rate) / (s * s)
    comes_rate = leaves_rate * s_rate - leaves * (slip.a1 * s_rate + slip.a0 * s) + height * slip.a0 * s_rate
    return Half(leaves, leaves * s_rate + height * slip.a0 * s, leaves_rate, comes_rate)


def decay_of_large_motions(drive: ForwardDrive):
    """Logarithm by which a large motion has decayed after a turn; infinite where slip under law − does not turn."""
    plus, minus = drive.slip(1), drive.slip(-1)
    return many.pi * (plus.alpha / plus.beta + minus.alpha / minus.beta) if minus.turns else many.inf


class SlowestPoint(NamedTuple):
    """Smallest ``rate`` w [rad/s] on the cycle at R̃ = 1 N, where the motion is under ``law``.

    ``times`` [s] of the half returns under law + and law −; ``at`` [s], the time from Q = 0 to this point.
    """

    rate: Any
    law: int
    times: tuple[Any, Any]
    at: Any


def slowest_point(drive: ForwardDrive) -> SlowestPoint:
    """Return the point of the cycle at which the screw is slowest; the conditions of the module docstring must hold.

    Raises ``NoThreshold`` where 50 digits do not hold the cycle.
    """
    for context, nearest, close in _SEARCHES:
        times = _polished(drive, _times(drive, context, nearest, close))
        if times is not None:
            found = (_slowest(drive, law, time) for law, time in zip((1, -1), times, strict=True))
            rate, law, at = min(found, key=lambda point: point[0])
            return SlowestPoint(rate, law, times, at)
    raise NoThreshold(
        "the force is not known: the rates of slip lie too far apart for 50 digits, in which the two halves of its "
        "limit cycle do not meet."
    )


def _times(drive: ForwardDrive, context, nearest: float, close: float):
    """Approximate times [s] of the two half returns; None if the arithmetic has too few digits for them."""
    plus, minus = drive.slip(1, context), drive.slip(-1, context)
    heights = {law: context.mpf(drive.inertia[law] / drive.inertia[-1]) for law in (1, -1)}

    def long_time(phase):
        return (context.pi + phase) / plus.beta

    def short_time(logit):
        return (
            context.pi / minus.beta / (1 + context.exp(-logit)) if minus.turns else context.exp(logit) / minus.a0**0.5
        )

    def time_below(slope):
        """Time after which a motion that leaves Q = 0 downwards with a slope comes back."""

        def balance(logit):
            c, s, _ = minus.responses(short_time(logit))
            rise, fall = heights[-1] * (1 - c), -slope * s
            return (rise - fall) / (rise + fall)

        # Slip that turns comes back within half a turn, perhaps hardly earlier; other slip comes back at some time.
        low, high = context.log(nearest), -context.log(nearest) if minus.turns else 1
        while not minus.turns and balance(high) < 0:
            low, high = high, high + 1
        return short_time(bracketed_root(balance, low, high, close))

    def excess(logarithm):
        above = half_return(plus, heights[1], long_time(context.exp(logarithm)))
        below = half_return(minus, heights[-1], time_below(above.comes))
        return (below.comes - above.leaves) / (abs(below.comes) + abs(above.leaves))

    try:
        # Beyond this phase a motion under law + that leaves Q = 0 upwards does not come back: C = 1, so that v = 0.
        grazing = context.mpf(drive.slip(1).recurrence() * drive.slip(1).beta - many.pi)
        low, high = context.log(nearest), context.log(grazing * (1 - 1e-9))
        if not excess(low) < 0 < excess(high):
            return None
        time = long_time(context.exp(bracketed_root(excess, low, high, close)))
        return time, time_below(half_return(plus, heights[1], time).comes)
    except (OverflowError, ZeroDivisionError):
        return None


def _polished(drive: ForwardDrive, times):
    """Refine the two times to all digits by Newton's method; None if it does not lead to a cycle."""
    if times is None:
        return None
    plus, minus = drive.slip(1), drive.slip(-1)
    first, second = (many.mpf(x) for x in times)
    for _ in range(_NEWTON):
        above = half_return(plus, drive.inertia[1], first)
        below = half_return(minus, drive.inertia[-1], second)
        gaps = above.comes - below.leaves, below.comes - above.leaves
        size = abs(above.leaves) + abs(above.comes)
        if not (above.leaves > 0 > above.comes and many.pi < plus.beta * first < 2 * many.pi):
            return None
        if max(abs(gap) for gap in gaps) < _EXACT * size:
            return (first, second) if second > 0 and (not minus.turns or minus.beta * second < many.pi) else None
        determinant = above.comes_rate * below.comes_rate - below.leaves_rate * above.leaves_rate
        first -= (gaps[0] * below.comes_rate + gaps[1] * below.leaves_rate) / determinant
        second -= (gaps[1] * above.comes_rate + gaps[0] * above.leaves_rate) / determinant
    return None


def _slowest(drive: ForwardDrive, law: int, time):
    """Smallest w [rad/s] on the half of the cycle under a law, at R̃ = 1 N, with the law and the time [s] from Q = 0."""
    slip = drive.slip(law)
    y, w = leaving(slip, drive.contact, drive.inertia[law], half_return(slip, drive.inertia[law], time))
    slowest = w, law, many.mpf(0)
    for at in slip.stationary(y, w, (0, 1)):
        if at >= time:
            break
        slowest = min(slowest, (slip.state(y, w, at)[1], law, at), key=lambda point: point[0])
    return slowest


def leaving(slip: Any, contact: Any, height: Any, half: Half) -> tuple[Any, Any]:
    """State (u − u_e, w) in which a half return leaves Q = 0; u_e [rad] is the equilibrium of its law.

    Arguments: slip under the law, as of :func:`half_return`; row (q_u, q_w) of Q; ``height``, Q at the equilibrium; the
    half return. With y = u − u_e, Q = q_u y + q_w w + height and Q′ = q_u w − q_w (a₀ y + a₁ w); here Q = 0, Q′ = v.
    """
    q_u, q_w = contact
    w = (half.leaves - q_w * slip.a0 * height / q_u) / (q_u - q_w * slip.a1 + q_w**2 * slip.a0 / q_u)
    return -(q_w * w + height) / q_u, w
