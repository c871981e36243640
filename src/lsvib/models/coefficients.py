"""Coefficients of the rigid drive's equations of motion (8.13)–(8.17), as balls of 150 digits."""

from dataclasses import dataclass
from typing import Any

from flint import arb

from lsvib.engine.exact.arithmetic import many_digits, sign
from lsvib.models import mechanics
from lsvib.models.drive import Drive, once


@dataclass(frozen=True)
class Coefficients:
    """Numbers that the equations of motion are made of, as balls (SI units; indices + and − are the laws)."""

    xi: dict[int, arb]
    gamma: dict[int, arb]  # Γ_s [kg m²]
    damping: dict[int, arb]  # C_s [N m s/rad]
    steady_law: int  # s_0 = sgn(R̃ Ω)
    net_force: arb  # R̃ [N]
    deflection: arb  # z_0 [rad]
    q_row: tuple[arb, arb, arb]  # Q as an affine function of (u, w)

    def slack(self, law: int) -> arb | int:
        """Return ξ_0 − ξ_s [1], exactly zero for the law of steady sliding."""
        return 0 if law == self.steady_law else self.xi[self.steady_law] - self.xi[law]

    @property
    def paradox(self) -> bool:
        """True in the Painlevé region, Γ₊ ≤ 0."""
        return sign(self.gamma[1], "mass") <= 0


@once
def coefficients(drive: Drive) -> Coefficients:
    """Return the coefficients of eqs (8.13)–(8.17) for a drive, as balls."""
    return coefficients_of(drive.exact())


def coefficients_of(d: Any) -> Coefficients:
    """Return the coefficients from parameters as balls, arrays of doubles or power series."""
    with many_digits():
        r, tan = d.pitch_radius, d.tan_lead
        xi = {s: mechanics.friction_factor(d.friction_coefficient, tan, s) for s in (1, -1)}
        gamma = {s: mechanics.effective_inertia(d.screw_inertia, d.mass, r, tan, xi[s]) for s in xi}
        damping = {s: mechanics.effective_damping(d.support_damping, d.translation_damping, r, tan, xi[s]) for s in xi}
        net_force = d.axial_force - r * tan * d.translation_damping * d.input_speed
        law = -1 if sign(net_force * d.input_speed, "axial_force") < 0 else 1
        return Coefficients(
            xi=xi,
            gamma=gamma,
            damping=damping,
            steady_law=law,
            net_force=net_force,
            deflection=-(damping[law] * d.input_speed + r * xi[law] * d.axial_force) / d.coupling_stiffness,
            q_row=(
                r * tan * d.mass * d.coupling_stiffness,
                r * tan * (d.mass * d.support_damping - d.screw_inertia * d.translation_damping),
                gamma[law] * net_force,
            ),
        )


def steady_force(c: Coefficients, d: Any) -> Any:
    """Return |N_0| of steady sliding [N] (eq. 8.15): N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω."""
    return abs(c.net_force / (d.cos_lead + c.steady_law * d.friction_coefficient * d.sin_lead))
