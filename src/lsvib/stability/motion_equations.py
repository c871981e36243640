"""Defining equations of the thresholds of the rigid drive that depend on a motion, in balls or power series.

All are written for Ω > 0 (:mod:`lsvib.stability.slip`, docs/thresholds.md). The inner unknowns are times [s].
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from lsvib.stability.slip import Slip, SlipDrive, half_return, leaving
from lsvib.stability.solve import Equations

_OfDrive = Callable[[SlipDrive, Sequence[Any]], list[Any]]


class Start(NamedTuple):
    """A threshold of the axial force, from which Newton's method starts: the ``system`` of equations, the ``force`` R
    [N] of the drive mirrored to Ω > 0, infinite if there is none, and the inner unknowns, ``times`` [s]."""

    system: str
    force: Any
    times: tuple[Any, ...] = ()


class Return:
    """Slip under law − from θ′ = 0 that is back at the same y after a time: x = −Ω S / (1 − C), w = −Ω S′ − a₀ x S.

    ``x``, the start [rad]; ``w``, the rate there on coming back [rad/s]; ``h``, q_u x + q_w w then.
    """

    def __init__(self, d: SlipDrive, time: Any) -> None:
        self.slip, self.speed, (self.q_u, self.q_w) = d.slip(-1), d.speed, d.contact
        slip = self.slip
        self.responses = c, s, s_rate = slip.responses(time)
        self.x = -self.speed * s / (1 - c)
        self.w = -self.speed * s_rate - slip.a0 * self.x * s
        self.h = self.q_u * self.x + self.q_w * self.w

    @property
    def h_rate(self) -> Any:
        """The derivative of ``h`` by the time."""
        slip, (c, s, s_rate) = self.slip, self.responses
        x_rate = -self.speed * (s_rate * (1 - c) - slip.a0 * s * s) / (1 - c) ** 2  # C′ = −a₀ S
        w_rate = self.speed * (slip.a1 * s_rate + slip.a0 * s) - slip.a0 * (x_rate * s + self.x * s_rate)
        return self.q_u * x_rate + self.q_w * w_rate


# Each of these returns what vanishes at the threshold, from a drive and the unknown times.


def _stick(law: int, d: SlipDrive, times: Sequence[Any]) -> list[Any]:
    """The cycle of slip by its two half returns; at a third time under a law w is stationary, and w = −Ω."""
    plus, minus = (half_return(d.slip(s), d.inertia[s], time) for s, time in zip((1, -1), times[:2], strict=True))
    slip, slope = d.slip(law), (plus if law > 0 else minus)[0]
    y, w = slip.state(*leaving(slip, d.contact, d.inertia[law], slope), times[2])
    return [plus[1] - minus[0], minus[1] - plus[0], slip.a0 * y + slip.a1 * w, d.net * w + d.speed]


def _touches(law: int, stops: bool, d: SlipDrive, times: Sequence[Any]) -> list[Any]:
    """Slip from the end of rest touches Q = 0, where Q′ = 0 and Q = 0; or it ``stops`` just where Q = 0."""
    slip, (q_u, q_w) = d.slip(law), d.contact
    y, w = slip.state(d.end_of_rest(d.force) if law < 0 else d.end_without_force(1), -d.speed, times[0])
    q_rate = q_u * w + q_w * (-slip.a0 * y - slip.a1 * w)
    return [w + d.speed if stops else q_rate, q_u * y + q_w * w + d.inertia[law] * d.net]


def _fold(d: SlipDrive, times: Sequence[Any]) -> list[Any]:
    """Two cycles of seizures that lead to each other, Q = 0 on coming back, meet."""
    back = Return(d, times[0])
    return [back.h_rate, back.h + d.inertia[-1] * d.net]


def _even(law: int, d: SlipDrive, times: Sequence[Any]) -> list[Any]:
    """Slip under a law from the release of static friction touches θ′ = 0; the time is that since then, backwards."""
    c, s, _ = Slip(d.inertia[law], -d.damping[law], d.stiffness).responses(times[0])
    return [c - 1, d.braked(d.static)[1] - d.braked(d.sliding)[1] + d.stiffness * s * d.speed]


_STICK = "v̂₊(τ₁) = v₋(τ₂), v̂₋(τ₂) = v₊(τ₁): the cycle of slip; on it under law {} w′(τ₃) = 0 and w(τ₃) = −Ω (Sect. 8.5)"
_FOLD = "slip under law − from (x, −Ω) back at u = x after τ: dh/dτ = 0, Q(τ) = h(τ) + Γ₋ R̃ = 0 (eq. 8.17, Sect. 8.7)"
_DETACH = "slip under law + from the end of rest, u = C₊ Ω / k, has {}(τ) = 0 and Q(τ) = 0 (eq. 8.17, Sect. 8.5)"
_END = "the end of rest, u = C₋ Ω / k, for R > 0 less r_m (ξ₊ − ξ₋) R / k,"
_SEIZES = f"slip under law − from {_END} has Q′(τ) = 0 and Q(τ) = 0 (eq. 8.17, Sect. 8.7)"
_EVEN = "slip under law {} touches θ′ = 0 a time τ after its release: C(−τ) = 1, T_r − T = k Ω S(−τ) of dry friction"

_SYSTEMS: dict[str, tuple[str, _OfDrive]] = {
    "stick+": (_STICK.format("+"), partial(_stick, 1)),
    "stick-": (_STICK.format("−"), partial(_stick, -1)),
    "detach": (_DETACH.format("Q′"), partial(_touches, 1, False)),
    "detach at rest": (_DETACH.format("θ′"), partial(_touches, 1, True)),
    "even+": (_EVEN.format("+"), partial(_even, 1)),
    "even-": (_EVEN.format("−"), partial(_even, -1)),
    "rest seizes": (_SEIZES, partial(_touches, -1, False)),
    "fold": (_FOLD, _fold),
}


def equations(system: str, sense: int) -> tuple[str, Equations]:
    """Return the equations of a system, in words and for drives with sgn Ω = ``sense``."""
    words, of = _SYSTEMS[system]
    return words, lambda parameters, inner: of(SlipDrive(parameters, sense), inner)
