r"""Defining equations of the thresholds of the rigid drive that depend on a motion, for numbers with derivatives.

All are written for Ω > 0; for Ω < 0 the drive is mirrored. Slip under law s is the oscillator Γ_s y″ + C_s y′ + k y = 0
about its equilibrium y = 0, where Q = q_u y + q_w w + Γ_s R̃; S is its impulse response, C = S′ + a₁ S.
The inner unknowns are times [s]. Slip from θ′ = 0 that is back at the same y after τ started at

    x(τ) = −Ω S / (1 − C)    and has    w = −Ω S′ − a₀ x S,    h(τ) = q_u x + q_w w    then.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from lsvib.dynamics.slip_cycle import half_return, leaving
from lsvib.engine.exact.duals import Dual, cosine_of_root, exponential, sine_ratio_of_root, tangent
from lsvib.models import mechanics
from lsvib.stability.solve import Equations


class Start(NamedTuple):
    """A threshold of the axial force, from which Newton's method starts: the ``system`` of equations, the ``force`` R
    [N] of the drive mirrored to Ω > 0, infinite if there is none, and the inner unknowns, ``times`` [s]."""

    system: str
    force: Any
    times: tuple[Any, ...] = ()


class DualSlip:
    """Slip under one law: a₀ = k / Γ, a₁ = C / Γ, and its responses as functions of a time with derivatives."""

    def __init__(self, inertia: Dual, damping: Dual, stiffness: Dual) -> None:
        self.a0, self.a1 = stiffness / inertia, damping / inertia

    def responses(self, time: Dual) -> tuple[Dual, Dual, Dual]:
        """Return C, S and S′ at a time [s]; one formula whether slip turns or not."""
        half = self.a1 / 2
        z = (self.a0 - half**2) * time**2
        decay = exponential(-(half * time))
        c, s = decay * cosine_of_root(z), decay * time * sine_ratio_of_root(z)
        return c + half * s, s, c - half * s

    def state(self, y: Dual, w: Dual, time: Dual) -> tuple[Dual, Dual]:
        """Return (y, w) a time [s] after the state (y, w)."""
        c, s, s_rate = self.responses(time)
        return y * c + w * s, w * s_rate - self.a0 * y * s


class DualDrive:
    """Constants of the rigid drive (eqs 8.13–8.17) with derivatives, mirrored so that Ω > 0; ``sense`` is sgn Ω."""

    def __init__(self, p: Mapping[str, Dual], sense: int) -> None:
        t, self.radius, self.stiffness = tangent(p["lead_angle"]), p["pitch_radius"], p["coupling_stiffness"]
        self.lever = self.radius * t
        self.speed, self.force = p["input_speed"] * sense, p["axial_force"] * sense
        self.net = self.force - self.lever * p["translation_damping"] * self.speed
        self.xi = {law: mechanics.friction_factor(p["friction_coefficient"], t, law) for law in (1, -1)}
        self.inertia: dict[int, Dual] = {}
        self.damping: dict[int, Dual] = {}
        for law, xi in self.xi.items():
            self.inertia[law] = mechanics.effective_inertia(p["screw_inertia"], p["mass"], self.radius, t, xi)
            self.damping[law] = mechanics.effective_damping(
                p["support_damping"], p["translation_damping"], self.radius, t, xi
            )
        self.contact = (
            self.lever * p["mass"] * self.stiffness,
            self.lever * (p["mass"] * p["support_damping"] - p["screw_inertia"] * p["translation_damping"]),
        )

    def slip(self, law: int) -> DualSlip:
        """Return slip under a law."""
        return DualSlip(self.inertia[law], self.damping[law], self.stiffness)

    def end_of_rest(self, law: int) -> Dual:
        """Deflection y [rad] from the equilibrium of a law at which rest ends where T_r reaches r_m ξ₊ R: C_s Ω / k
        under law +, and less by r_m (ξ₊ − ξ₋) R / k under law −."""
        first = self.damping[law] * self.speed / self.stiffness
        return first if law > 0 else first - self.radius * (self.xi[1] - self.xi[-1]) * self.force / self.stiffness

    def end_against(self) -> Dual:
        """Deflection y [rad] from the equilibrium of law − at which rest ends for R ≤ 0: C₋ Ω / k."""
        return self.damping[-1] * self.speed / self.stiffness


def _stick(law: int) -> Callable[[DualDrive, Sequence[Dual]], list[Dual]]:
    """The cycle of slip by its two half returns; at the time ``at`` under a law w is stationary, and w = −Ω."""

    def equations(d: DualDrive, inner: Sequence[Dual]) -> list[Dual]:
        """Return what vanishes: both halves close, w is stationary, and the screw just stops there."""
        halves = {s: half_return(d.slip(s), d.inertia[s], time) for s, time in zip((1, -1), inner[:2], strict=True)}
        slip = d.slip(law)
        y, w = slip.state(*leaving(slip, d.contact, d.inertia[law], halves[law]), inner[2])
        return [
            halves[1].comes - halves[-1].leaves,
            halves[-1].comes - halves[1].leaves,
            slip.a0 * y + slip.a1 * w,
            d.net * w + d.speed,
        ]

    return equations


def _touches(
    law: int, start: Callable[[DualDrive], Dual], stops: bool = False
) -> Callable[[DualDrive, Sequence[Dual]], list[Dual]]:
    """Slip from the end of rest touches Q = 0, where Q′ = 0 and Q = 0; or it ``stops`` just where Q = 0."""

    def equations(d: DualDrive, inner: Sequence[Dual]) -> list[Dual]:
        """Return what vanishes at the time ``inner[0]`` after the end of rest: Q′, or θ′, and Q."""
        slip, (q_u, q_w) = d.slip(law), d.contact
        y, w = slip.state(start(d), -d.speed, inner[0])
        q_rate = q_u * w + q_w * (-slip.a0 * y - slip.a1 * w)
        return [w + d.speed if stops else q_rate, q_u * y + q_w * w + d.inertia[law] * d.net]

    return equations


class ReturnEquations:
    """Slip under law − from θ′ = 0 that is back at the same y after a time, in any arithmetic.

    ``x``, the start [rad]; ``w``, the rate there on coming back [rad/s]; ``h``, the part of Q that depends on the
    state, then, with its derivative ``h_rate`` by the time; ``q_rate``, Q′ along the slip as it comes back.
    """

    def __init__(self, slip: Any, contact: tuple[Any, Any], speed: Any, time: Any) -> None:
        self.slip, self.contact, self.speed = slip, contact, speed
        self.responses = c, s, s_rate = slip.responses(time)
        self.x = -speed * s / (1 - c)
        self.w = -speed * s_rate - slip.a0 * self.x * s
        self.h = contact[0] * self.x + contact[1] * self.w

    @property
    def h_rate(self) -> Any:
        """The derivative of ``h`` by the time."""
        slip, (c, s, s_rate) = self.slip, self.responses
        x_rate = -self.speed * (s_rate * (1 - c) - slip.a0 * s * s) / (1 - c) ** 2  # C′ = −a₀ S
        w_rate = self.speed * (slip.a1 * s_rate + slip.a0 * s) - slip.a0 * (x_rate * s + self.x * s_rate)
        return self.contact[0] * x_rate + self.contact[1] * w_rate

    @property
    def q_rate(self) -> Any:
        return self.contact[0] * self.w - self.contact[1] * (self.slip.a0 * self.x + self.slip.a1 * self.w)


def _comes_back(
    zero: Callable[[DualDrive, ReturnEquations], Dual],
) -> Callable[[DualDrive, Sequence[Dual]], list[Dual]]:
    """A cycle of seizures, Q = 0 on coming back, on which something else vanishes as well."""

    def equations(d: DualDrive, inner: Sequence[Dual]) -> list[Dual]:
        back = ReturnEquations(d.slip(-1), d.contact, d.speed, inner[0])
        return [zero(d, back), back.h + d.inertia[-1] * d.net]

    return equations


_STICK = "v̂₊(τ₁) = v₋(τ₂), v̂₋(τ₂) = v₊(τ₁): the cycle of slip; on it under law {} w′(τ₃) = 0 and w(τ₃) = −Ω (Sect. 8.5)"
_SYSTEMS: dict[str, tuple[str, Callable[[DualDrive, Sequence[Dual]], list[Dual]]]] = {
    "stick+": (_STICK.format("+"), _stick(1)),
    "stick-": (_STICK.format("−"), _stick(-1)),
    "detach": (
        "slip under law + from the end of rest, u = C₊ Ω / k, has Q′(τ) = 0 and Q(τ) = 0 (eq. 8.17, Sect. 8.5)",
        _touches(1, lambda d: d.end_of_rest(1)),
    ),
    "detach at rest": (
        "slip under law + from the end of rest, u = C₊ Ω / k, has θ′(τ) = 0 and Q(τ) = 0 (eq. 8.17, Sect. 8.5)",
        _touches(1, lambda d: d.end_of_rest(1), stops=True),
    ),
    "rest seizes": (
        "slip under law − from the end of rest, u = C₋ Ω / k, has Q′(τ) = 0 and Q(τ) = 0 (eq. 8.17, Sect. 8.7)",
        _touches(-1, DualDrive.end_against),
    ),
    "rest seizes with the motion": (
        "slip under law − from the end of rest, u = [C₋ Ω − r_m (ξ₊ − ξ₋) R] / k, has Q′(τ) = 0 and Q(τ) = 0 "
        "(eq. 8.17, Sect. 8.7)",
        _touches(-1, lambda d: d.end_of_rest(-1)),
    ),
    "fold": (
        "slip under law − from (x, −Ω) back at u = x after τ: dh/dτ = 0 and Q(τ) = h(τ) + Γ₋ R̃ = 0 "
        "(eq. 8.17, Sect. 8.7)",
        _comes_back(lambda d, back: back.h_rate),  # seizures that lead to each other meet
    ),
    "cycle_birth": (
        "slip under law − from (x, −Ω) back at u = x after τ: Q′(τ) = 0 and Q(τ) = h(τ) + Γ₋ R̃ = 0 "
        "(eq. 8.17, Sect. 8.7)",
        _comes_back(lambda d, back: back.q_rate),  # the cycle touches Q = 0 where it seizes
    ),
    "rest lost": (
        "slip under law − from the end of rest, x = C₋ Ω / k, is back at u = x after τ with Q(τ) = 0 (eq. 8.17)",
        _comes_back(lambda d, back: back.x - d.end_against()),
    ),
    "rest lost with the motion": (
        "slip under law − from the end of rest, x = [C₋ Ω − r_m (ξ₊ − ξ₋) R] / k, is back at u = x after τ with "
        "Q(τ) = 0 (eq. 8.17)",
        _comes_back(lambda d, back: back.x - d.end_of_rest(-1)),
    ),
}


def words(system: str) -> str:
    """Return the equations of a system in words."""
    return _SYSTEMS[system][0]


def equations(system: str, sense: int) -> Equations:
    """Return the equations of a system for drives with sgn Ω = ``sense``."""
    of: Any = _SYSTEMS[system][1]
    return lambda parameters, inner: of(DualDrive(parameters, sense), inner)
