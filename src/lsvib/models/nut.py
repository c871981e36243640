r"""Rotating nut: the nut is held against rotation by a spring and a damper only (Sect. 5.8, eq. 8.33).

          Ω t                θ                          x = r_m tan λ (θ − θ_2), θ_2
    motor ──/\/\/\── k ──▶ (I) screw ═══threads═══▶ [m, I_2] nut ──▶ R
                            c, T_0 to ground          along: c_x, F_0 to ground
                                                      turning: k_2 ∥ c_2 to ground

State (u, w, φ, ψ): u = z − z_0 [rad] and w = u′ [rad/s] as in the rigid drive; φ [rad] is the angle θ_2 of the nut less
its angle in steady sliding, and ψ = φ′ [rad/s]. The threads slip in the direction of ω = θ′ − θ_2′. With the axial
contact force n = N (cos λ + s μ sin λ), the law s = sgn ω sgn N, T = −k z − c θ′, S_2 = −k_2 θ_2 − c_2 θ_2′ and
P = R − c_x x′ − F_0 sgn ω,

    I θ″ = T − T_0 sgn θ′ − r_m ξ_s n,      I_2 θ_2″ = S_2 + r_m ξ_s n,      m x″ = P − n,
    n = Q / Γ̂_s,      Γ̂_s = I_eff − ξ_s tan λ m r_m²,      I_eff = I I_2 / (I + I_2),               (8.33: Γ̂_s < 0)
    Q = I_eff [P − m r_m tan λ (T / I − S_2 / I_2)],

where T in Q includes the friction T_0 of the bearing.

Friction. The motion is linear for each combination of the signs of ω and Q, and of θ′ where there is T_0. While ω = 0
screw and nut turn together, (I + I_2) θ″ = T + S_2, and the nut does not move along the axis. The threads carry the
torque τ = I_eff (T / I − S_2 / I_2). Static friction holds while neither slip forward nor slip backward can start, that
is, while τ lies between r_m ξ (R + F_0) and r_m ξ (R − F_0), each with the law of that slip. This assumes that slide
and threads oppose one and the same impending motion; a slide that pushed the other way could jam the threads at a
larger τ, at which slip is possible, too. At rest the share of the slide in R is not determined; the n that is given is
that of a slide without a share.

Painlevé region, Γ̂₊ ≤ 0. In a seizure the axial impulse J = m r_m tan λ ω stops the travel of the nut, x′ → 0, and its
moment r_m ξ J brings screw and nut to their common speed (I θ′ + I_2 θ_2′) / (I + I_2); springs, dampers and F_0 give
no impulse. Both conditions hold for ξ = I_eff / (m r_m² tan λ), which is not larger than ξ₊. The torque T_0 is allowed
only if Γ̂₊ > 0: a bearing that holds the screw changes the effective inertia, and with it whether the threads seize, so
the rule for the motion after an impact does not cover it.
"""

from collections.abc import Mapping
from typing import Any

from flint import arb

from lsvib.engine.automaton import Automaton, scaled
from lsvib.engine.exact.arithmetic import sign
from lsvib.errors import InputError
from lsvib.models.drive import NutDrive
from lsvib.models.mechanics import LinearParts, Polynomial, constant, plus
from lsvib.models.two_bodies import Solution, TwoBodies
from lsvib.models.two_body_model import TwoBodyPowers, event_enum, mode_enum, two_body_model

NutMode = mode_enum("NutMode", ("rest",), "screw")
NutEvent = event_enum("NutEvent", "bearing")


class _Nut(TwoBodies):
    """Newton's laws as rows over (u, w, φ, ψ, 1)."""

    states = ("angle_deviation", "velocity_deviation", "nut_angle", "nut_rate")
    modes, events, second, snaps, turns_over = NutMode, NutEvent, "screw", (3, 1), False
    limiting = "bearing_friction"

    def __init__(self, drive: NutDrive, slide: bool, bearing: bool) -> None:
        super().__init__(drive, slide, bearing)
        d = self.d
        total = d.screw_inertia + d.nut_inertia
        inertia = d.screw_inertia * d.nut_inertia / total
        self.paradox = self.in_paradox(inertia, d.mass)
        if self.bears and self.paradox:
            most = float(inertia / self.turned)
            raise InputError(
                f"bearing_friction = {drive.bearing_friction:g} needs mass < {most:.6g} kg in model "
                "nut: above, the threads can seize, and what follows is not determined while the bearing holds the "
                "screw."
            )
        self.angle = (0, 0, 1, 0, self.twist / d.nut_stiffness)
        self.slip = plus(self.speed, (0, 0, 0, -1, 0))
        self.nut_speed = scaled(self.slip, self.reach)
        self.sliding = self.speed
        speed = abs(float(d.input_speed))
        self.sizes = (0.1, speed, 0.1 * min(float(d.coupling_stiffness / d.nut_stiffness), 1.0), speed)
        common = plus(scaled(self.speed, d.screw_inertia / total), (0, 0, 0, d.nut_inertia / total, 0))
        self.impact = ((1, 0, 0, 0, 0), plus(common, constant(-d.input_speed)), (0, 0, 1, 0, 0), common)

    def _force(self, direction: int) -> arb:
        """R ∓ F_0 [N], which the threads carry as slip in a direction begins from rest."""
        return self.d.axial_force - self.slide * direction

    def released(self, direction: int, side: int) -> int:
        """The sign of R ∓ F_0; without that force the threads resist."""
        return sign(self._force(direction), "axial_force") or -direction

    def solve(self, direction: int, law: int, way: int, mu: arb | None = None) -> Solution:
        """Newton's laws for θ″, θ_2″, n, the torque that the threads take, and the friction of the bearing."""
        d, zero = self.d, constant(0)
        rests, held = direction == 0, self.bears and way == 0
        turning = zero if held else self.speed
        rate = turning if rests else (0, 0, 0, 1, 0)
        travel = zero if rests else plus(scaled(turning, self.reach), scaled(rate, -self.reach))
        torque = plus(scaled(self.deflection, -d.coupling_stiffness), scaled(turning, -d.support_damping))
        spring = plus(scaled(self.angle, -d.nut_stiffness), scaled(rate, -d.nut_damping))
        push = plus(constant(self._force(direction)), scaled(travel, -d.translation_damping))
        threads = (1, -1, 0, 0, 0) if rests else (0, 0, -self.lever(law, mu), 1, 0)
        bearing = (1, 0, 0, 0, 0) if held else (0, 0, 0, 0, 1)
        return self.solution(
            direction and law,
            held,
            rests and held,
            rate,
            [
                (d.screw_inertia, 0, 0, 1, 1),
                (0, d.nut_inertia, 0, -1, 0),
                (d.mass * self.reach, -d.mass * self.reach, 1, 0, 0),
                threads,
                bearing,
            ],
            [torque, spring, push, zero, zero if held else constant(self.bearing * way)],
        )

    def holds(self, way: int) -> dict[int, dict[int, tuple]]:
        """Static friction that is left: ±(r_m ξ_s (R ∓ F_0) − τ) with s = ± sgn(R ∓ F_0)."""
        torque = self.solve(0, 1, way).torque

        def left(direction: int) -> tuple:
            """Return what is left before the threads slip in a direction, as a row."""
            force = self._force(direction)
            law = 1 if sign(direction * force, "axial_force") > 0 else -1
            most = self.d.pitch_radius * self.xi_rest[law] * force
            return scaled(plus(constant(most), scaled(torque, -1)), direction)

        return {0: {direction: left(direction) for direction in (1, -1)}}

    def tied(self, slip: bool, second: bool) -> tuple[tuple, ...]:
        """θ_2′ = θ′ where ``slip`` is zero, θ′ = 0 where ``second`` is."""
        speed = constant(-self.d.input_speed) if second else (0, 1, 0, 0, 0)
        common = constant(0) if second else self.speed
        return (1, 0, 0, 0, 0), speed, (0, 0, 1, 0, 0), common if slip else (0, 0, 0, 1, 0)


def _characteristic(p: Mapping[str, Any], parts: LinearParts) -> Polynomial:
    """−h A B + (I_2 s² + c_2 s + k_2) D, which is g det(M s² + C s + K) with the matrices above (8.33)."""
    own = (p["nut_inertia"], p["nut_damping"], p["nut_stiffness"])
    return parts.coupled(-parts.h, own, parts.screw)  # the threads slip at θ′ − θ_2′


class NutPowers(TwoBodyPowers):
    """Powers of the drive with a rotating nut: the nut turns at ψ = θ_2′, and the threads slip at θ′ − θ_2′."""

    inertia = "nut_inertia"

    def __init__(self, drive: NutDrive, automaton: Automaton) -> None:
        super().__init__(drive, automaton)
        self.slip = self.screw - self.second
        self.nut = self.reach * self.slip


MODEL = two_body_model(
    _Nut,
    drive=NutDrive,
    quantities={
        "nut_angle": ("angle of the nut from steady sliding", "rad", r"$\varphi$"),
        "nut_rate": ("angular speed of the nut", "rad s-1", r"$\dot\varphi$"),
    },
    characteristic=_characteristic,
    constraint="Γ̂₊ = I I_2 / (I + I_2) − ξ₊ tan λ m r_m² = 0 (eq. 8.33)",
    powers=NutPowers,
    equations="Sect. 5.8, eq. 8.33",
    section="5.8",
)
