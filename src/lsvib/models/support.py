r"""Axial support: the screw can shift along its axis against a spring and a damper (Sect. 5.6, eqs 8.23–8.32).

          Ω t                θ, x_1                     x = r_m tan λ θ + x_1
    motor ──/\/\/\── k ──▶ (I, m_1) screw ═══threads═══▶ [m] nut ──▶ R
                            turning: c, T_0 to ground      c_x, F_0 to ground
                            along: k_1 ∥ c_1 to ground

State (u, w, y, v): u = z − z_0 [rad] and w = u′ [rad/s] as in the rigid drive; y [m] is the shift x_1 of the screw less
its shift in steady sliding, and v = y′ [m/s]. With the axial contact force n = N (cos λ + s μ sin λ), the torque
T = −k z − c θ′ of coupling and damper, the force S = k_1 x_1 + c_1 x_1′ of the support, and P = R − c_x x′,

    I θ″ = T − T_0 sgn θ′ − r_m ξ_s n,      m_1 x_1″ = n − S,      m x″ = P − F_0 sgn x′ − n,
    n = Q / [(m + m_1) Γ̃_s],      Γ̃_s = I − ξ_s tan λ m̃ r_m²,      m̃ = m m_1 / (m + m_1),         (8.27, 8.28)
    Q = I (m_1 P + m S) − m m_1 r_m tan λ T,

where P and T in Q include the friction F_0 of the slide and T_0 of the bearing. Linearised about steady sliding, with n
eliminated, these equations have the matrices M and K of (8.23).

Friction. The motion is linear for each combination of the signs of θ′ and Q, and of x′ where there is F_0. While the
screw does not turn it shifts together with the nut, and n = A = (m_1 P + m S) / (m + m_1). Static friction holds as
long as T = −k z lies between r_m A ξ₋ − T_0 and r_m A ξ₊ + T_0 (for A > 0). The shares of threads and bearing in T are
then not determined; the N that is given is that of a bearing without a share.

Painlevé region, Γ̃₊ ≤ 0. In a seizure the axial impulse J = m̃ r_m tan λ θ′ stops the screw and shifts it,
x_1′ → x_1′ + J / m_1. The friction factor that this takes, ξ = I / (m̃ r_m² tan λ), is not larger than ξ₊. The force F_0
is allowed only if I > ξ₊ tan λ m_1 r_m²: otherwise the threads jam while the slide is held, when its mass is in effect
infinite, and the motion is not determined.
"""

import math
from collections.abc import Mapping
from typing import Any

from flint import arb

from lsvib.engine.automaton import Automaton, scaled
from lsvib.engine.exact.arithmetic import sign
from lsvib.errors import InputError
from lsvib.models.drive import SupportDrive
from lsvib.models.mechanics import LinearParts, Polynomial, constant, plus
from lsvib.models.two_bodies import Solution, TwoBodies
from lsvib.models.two_body_model import TwoBodyPowers, event_enum, mode_enum, two_body_model

SupportMode = mode_enum("SupportMode", ("rest_positive", "rest_negative"), "nut")
SupportEvent = event_enum("SupportEvent", "slide")


class _Support(TwoBodies):
    """Newton's laws as rows over (u, w, y, v, 1)."""

    states = ("angle_deviation", "velocity_deviation", "screw_shift", "shift_rate")
    modes, events, second, snaps = SupportMode, SupportEvent, "nut", (1, 3)
    limiting = "slide_friction"

    def __init__(self, drive: SupportDrive, slide: bool, bearing: bool) -> None:
        super().__init__(drive, slide, bearing)
        d = self.d
        reduced = d.mass * d.screw_mass / (d.mass + d.screw_mass)
        self.paradox = self.in_paradox(d.screw_inertia, reduced)
        if self.slides and sign(d.screw_inertia - self.turned * d.screw_mass, "screw_mass") <= 0:
            most = float(d.screw_inertia / self.turned)
            raise InputError(
                f"slide_friction = {drive.slide_friction:g} needs screw_mass < {most:.6g} kg "
                "in model support: above, the threads jam while the slide is held, and the motion is not determined."
            )
        self.shift = (0, 0, 1, 0, self.force / d.support_stiffness)
        self.nut_speed = self.sliding = plus(scaled(self.speed, self.reach), (0, 0, 0, 1, 0))  # x′
        self.slip, self.turns_over = self.speed, self.bears
        rate = float(self.reach * abs(d.input_speed))
        loaded = (abs(float(d.axial_force)) + 1) / float(d.support_stiffness)
        swing = rate * math.sqrt(float(d.screw_mass / d.support_stiffness))
        self.sizes = (0.1, abs(float(d.input_speed)), max(loaded, swing), rate)  # 0.1 rad: cycles of Table 8.1
        kick = d.mass * self.reach / (d.mass + d.screw_mass)
        self.impact = (*self.tied(True, False)[:3], plus((0, 0, 0, 1, 0), scaled(self.speed, kick)))

    def solve(self, direction: int, law: int, way: int, mu: arb | None = None) -> Solution:
        """Newton's laws for θ″, x_1″, n, the torque of friction on the screw, and the friction of the slide."""
        d, zero = self.d, constant(0)
        rests, held = direction == 0, self.slides and way == 0
        turning = self.speed if direction else zero
        rate = scaled(turning, -self.reach) if held else (0, 0, 0, 1, 0)
        travel = zero if held else plus(scaled(turning, self.reach), rate)
        torque = plus(scaled(self.deflection, -d.coupling_stiffness), scaled(turning, -d.support_damping))
        support = plus(scaled(self.shift, d.support_stiffness), scaled(rate, d.axial_support_damping))
        push = plus(constant(d.axial_force), scaled(travel, -d.translation_damping))
        threads = (1, 0, 0, 0, 0) if rests else (0, 0, -self.lever(law, mu), 1, 0)
        slide = (self.reach, 1, 0, 0, 0) if held else (0, 0, 0, 0, 1)
        return self.solution(
            direction and law,
            rests,
            rests and held,
            rate,
            [
                (d.screw_inertia, 0, 0, 1, 0),
                (0, d.screw_mass, -1, 0, 0),
                (d.mass * self.reach, d.mass, 1, 0, 1),
                threads,
                slide,
            ],
            [
                torque,
                scaled(support, -1),
                push,
                zero if rests else constant(self.bearing * direction),
                zero if held else constant(self.slide * way),
            ],
        )

    def holds(self, way: int) -> dict[int, dict[int, tuple]]:
        """Static friction that is left: ±(r_m A ξ_s − T) + T_0 with s = ± sgn A."""
        rest = self.solve(0, 1, way)

        def left(side: int, direction: int) -> tuple:
            """Return what is left before the threads slip in a direction, on a side of the contact, as a row."""
            threads = scaled(rest.contact, self.d.pitch_radius * self.xi_rest[direction * side])
            return plus(scaled(plus(threads, scaled(rest.torque, -1)), direction), constant(self.bearing))

        return {side: {direction: left(side, direction) for direction in (1, -1)} for side in (1, -1)}

    def released(self, direction: int, side: int) -> int:
        """The side of rest."""
        return side

    def tied(self, slip: bool, second: bool) -> tuple[tuple, ...]:
        """θ′ = 0 where ``slip`` is zero, x′ = 0 where ``second`` is."""
        speed = constant(-self.d.input_speed) if slip else (0, 1, 0, 0, 0)
        held = constant(0) if slip else scaled(self.speed, -self.reach)
        return (1, 0, 0, 0, 0), speed, (0, 0, 1, 0, 0), held if second else (0, 0, 0, 1, 0)


def _characteristic(p: Mapping[str, Any], parts: LinearParts) -> Polynomial:
    """g A B + (m_1 s² + c_1 s + k_1) D, which is g det(M s² + C s + K) with the matrices of (8.23)."""
    return parts.coupled(parts.g, (p["screw_mass"], p["axial_support_damping"], p["support_stiffness"]))


class SupportPowers(TwoBodyPowers):
    """Powers of the drive with axial support: the screw shifts along its axis at v = x_1′, and the nut with it."""

    inertia = "screw_mass"

    def __init__(self, drive: SupportDrive, automaton: Automaton) -> None:
        super().__init__(drive, automaton)
        self.nut = self.nut + self.second


MODEL = two_body_model(
    _Support,
    drive=SupportDrive,
    quantities={
        "screw_shift": ("axial shift of the screw from steady sliding", "m", "$y$"),
        "shift_rate": ("rate of the axial shift of the screw", "m s-1", r"$\dot y$"),
    },
    characteristic=_characteristic,
    constraint="Γ̃₊ = I − ξ₊ tan λ m̃ r_m² = 0 with m̃ = m m_1 / (m + m_1) (eqs 8.27, 8.28)",
    powers=SupportPowers,
    equations="eqs 8.23-8.32",
    section="5.6",
)
