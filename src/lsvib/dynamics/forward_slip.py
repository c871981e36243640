"""Slip under one friction law in closed form, with many digits: from it come the thresholds of the axial force.

Slip is the oscillator  Γ u″ + C u′ + k u = 0  about the equilibrium of its law. With S its impulse response and C = S′
+ a₁ S its response to a unit displacement (a₀ = k / Γ, a₁ = C / Γ), every linear function of the state along it has a
derivative  p S′ + q S, whose zeros are known in closed form.
"""

import math
from collections.abc import Callable, Iterator
from itertools import count
from types import SimpleNamespace
from typing import Any

from flint import arb
from mpmath import MPContext

from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import Coefficients

many = MPContext()  # a context of its own, because the precision of the global one belongs to the caller
many.dps = 50
double = SimpleNamespace(
    mpf=float, **{name: getattr(math, name) for name in ("exp", "log", "cos", "sin", "atan2", "pi")}
)
_CLOSE = 1e-9  # relative error of the start of Newton's method, which squares it in every step
_NEWTON = 8  # steps at most; three steps lead from an error of 1e-9 to all 50 digits
_EXACT = 1e-25  # relative size of the last step; the next one would be its square
_STEPS = 400  # of a bracketed search, which halves its bracket in every third step at least


class ForwardDrive:
    """Constants of a drive (eqs 8.13–8.17) with 50 digits, mirrored if need be so that Ω > 0.

    ``outward`` is κ = q_u − q_w c_x / m in Q′ = κ w + ρ on the line Q = 0; ``onset`` is R_on = r_m tan λ c_x Ω [N];
    ``lever`` r_m tan λ [m]; ``contact`` the row (q_u, q_w) of Q, whose
    constant depends on R; ``xi``, ``inertia`` Γ and ``damping`` C by law.
    """

    def __init__(self, drive: RigidDrive, c: Coefficients) -> None:
        d = drive.exact()
        self._slips: dict[tuple[int, bool], Slip] = {}
        self.xi, self.inertia, self.damping = (
            {law: exactly(value) for law, value in by_law.items()} for by_law in (c.xi, c.gamma, c.damping)
        )
        self.speed, self.stiffness, self.mass = (
            abs(exactly(d.input_speed)),
            exactly(d.coupling_stiffness),
            exactly(d.mass),
        )
        self.radius, self.screw_inertia = exactly(d.pitch_radius), exactly(d.screw_inertia)
        self.lever = self.radius * exactly(d.tan_lead)
        self.contact = exactly(c.q_row[0]), exactly(c.q_row[1])
        self.decimals = c.gamma[-1], c.damping[-1], d.coupling_stiffness  # of slip under law −1
        translation_damping = exactly(d.translation_damping)
        self.outward = self.contact[0] - self.contact[1] * translation_damping / self.mass
        self.onset = self.lever * translation_damping * self.speed

    def slip(self, law: int, context=many) -> "Slip":
        """Return slip under a law, in many digits or in double precision."""
        key = law, context is many
        if key not in self._slips:
            self._slips[key] = Slip(self.inertia[law], self.damping[law], self.stiffness, context)
        return self._slips[key]


def exactly(value: arb):
    """Return the midpoint of a ball in the digits of this module."""
    mantissa, exponent = value.mid().man_exp()
    return many.ldexp(many.mpf(int(mantissa)), int(exponent))


class Slip:
    """Closed-form slip with effective inertia Γ [kg m²], damping C [N m s/rad] and stiffness k [N m/rad]."""

    def __init__(self, inertia, damping, stiffness, context=many) -> None:
        self.context, self.terms = context, (inertia, damping, stiffness)
        a0, a1 = stiffness / inertia, damping / inertia
        square = (a1 / 2) ** 2 - a0
        self.turns = square < 0
        half = many.sqrt(abs(square))  # imaginary part of the rates, or half of their distance
        large = -a1 / 2 - (half if a1 >= 0 else -half)
        rates = (0, 0) if self.turns else sorted((large, a0 / large), reverse=True)
        self.a0, self.a1, self.alpha, self.beta, self.fast, self.slow = (
            context.mpf(x) for x in (a0, a1, a1 / 2, half, rates[1], rates[0])
        )

    def responses(self, time):
        """Return C, S and S′ at a time [s]."""
        context = self.context
        if self.turns:
            decay = context.exp(-self.alpha * time)
            c, s = decay * context.cos(self.beta * time), decay * context.sin(self.beta * time) / self.beta
            return c + self.alpha * s, s, c - self.alpha * s
        if self.beta == 0:
            c = context.exp(-self.alpha * time)
            return c * (1 + self.alpha * time), c * time, c * (1 - self.alpha * time)
        slow, fast, spread = context.exp(self.slow * time), context.exp(self.fast * time), 2 * self.beta
        return (
            (self.slow * fast - self.fast * slow) / spread,
            (slow - fast) / spread,
            (self.slow * slow - self.fast * fast) / spread,
        )

    def state(self, u: Any, w: Any, time: Any) -> tuple[Any, Any]:
        """Return (u, w) a time [s] after the deviation u [rad] from the equilibrium and the rate w [rad/s]."""
        c, s, s_rate = self.responses(time)
        return u * c + w * s, w * s_rate - self.a0 * u * s

    def stationary(self, u, w, row) -> Iterator:
        """Yield the times [s] > 0, in order, at which row[0] · u + row[1] · w is stationary; for ever if slip turns."""
        context = self.context
        force = -self.a0 * u - self.a1 * w
        p, q = row[0] * w + row[1] * force, -self.a0 * (row[0] * u + row[1] * w)
        if self.turns:
            phase = context.atan2(p, (self.alpha * p - q) / self.beta) % context.pi
            yield from ((phase + n * context.pi) / self.beta for n in count(0 if phase > 0 else 1))
        elif self.beta == 0:
            slope = q - self.alpha * p
            if slope != 0 and -p / slope > 0:
                yield -p / slope
        else:
            slow, fast = p * self.slow + q, p * self.fast + q
            if slow != 0 and fast / slow > 1:
                yield context.log(fast / slow) / (2 * self.beta)

    def peak(self, u, w, row):
        """Largest value that row[0] · u + row[1] · w has at a later local maximum, and its time [s]; None if at none.

        For slip that decays: its first maximum is then the largest.
        """
        times = self.stationary(u, w, row)
        for _ in range(2):
            time = next(times, None)
            if time is None:
                return None
            place, rate = self.state(u, w, time)
            acceleration = -self.a0 * place - self.a1 * rate
            if row[0] * acceleration - row[1] * (self.a0 * rate + self.a1 * acceleration) < 0:
                return row[0] * place + row[1] * rate, time
        return None

    def recurrence(self):
        """Time [s] at which C = 1 for the first time: motion from w′ = 0 comes back to its w. For slip that grows.

        It lies between half a turn and a whole one. Newton's method, in each digit that a bracket leaves open.
        """
        for slip in (Slip(*self.terms, double), self):
            turn = 2 * slip.context.pi / slip.beta
            try:
                time = bracketed_root(lambda time, slip=slip: slip.responses(time)[0] - 1, turn / 2, turn, _CLOSE)
                break
            except OverflowError:  # slip grows by more than double precision can hold
                continue
        time = self.context.mpf(time)
        for _ in range(_NEWTON):
            c, s, _ = self.responses(time)
            step = (1 - c) / (self.a0 * s)
            time -= step
            if abs(step) <= _EXACT * time:
                break
        return time


def bracketed_root(function: Callable, low, high, tolerance: float):
    """Root of a function between ``low`` and ``high``, where it has different signs, to a relative tolerance [1].

    Chandrupatla's method: inverse quadratic steps where they are safe, halves elsewhere.
    """
    a, b = high, low
    value_a, value_b = function(a), function(b)
    c, value_c, part = a, value_a, 0.5
    for _ in range(_STEPS):
        x = a + part * (b - a)
        value = function(x)
        if (value > 0) == (value_a > 0):
            c, value_c = a, value_a
        else:
            c, b, value_c, value_b = b, a, value_b, value_a
        a, value_a = x, value
        best = a if abs(value_a) < abs(value_b) else b
        limit = tolerance * abs(best) / abs(b - a) if b != a else 1
        if limit > 0.5 or value_a == 0 or value_b == 0:
            return best
        part = 0.5
        if value_c in (value_a, value_b):  # the function is flat to rounding
            continue
        share, rise = (a - b) / (c - b), (value_a - value_b) / (value_c - value_b)
        if rise**2 < share and (1 - rise) ** 2 < 1 - share:
            part = value_a / (value_b - value_a) * value_c / (value_b - value_c)
            part += (c - a) / (b - a) * value_a / (value_c - value_a) * value_b / (value_c - value_b)
            part = min(max(part, limit), 1 - limit)
    return best
