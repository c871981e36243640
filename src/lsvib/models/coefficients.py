"""Coefficients of the rigid drive's equations of motion (8.13)–(8.17), to 50 digits. Needs no engine."""

from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

from lsvib.engine.exact.precision import PLACES
from lsvib.models import mechanics
from lsvib.models.drive import Drive, once


@dataclass(frozen=True)
class Coefficients:
    """Numbers that the equations of motion are made of, as decimals (SI units; indices + and − are the laws)."""

    xi: dict[int, Decimal]
    gamma: dict[int, Decimal]  # Γ_s [kg m²]
    damping: dict[int, Decimal]  # C_s [N m s/rad]
    steady_law: int  # s_0 = sgn(R̃ Ω)
    net_force: Decimal  # R̃ [N]
    deflection: Decimal  # z_0 [rad]
    q_row: tuple[Decimal, Decimal, Decimal]  # Q as an affine function of (u, w)

    @property
    def paradox(self) -> bool:
        """True in the Painlevé region, Γ₊ ≤ 0."""
        return self.gamma[1] <= 0


@once
def coefficients(drive: Drive) -> Coefficients:
    """Return the coefficients of eqs (8.13)–(8.17) for a drive, to 50 digits."""
    return coefficients_of(drive.exact())


def coefficients_of(d: Any) -> Coefficients:
    """Return the coefficients from exact parameters, of one drive or of many (:mod:`lsvib.models.many`)."""
    with localcontext(prec=PLACES):
        r, tan = d.pitch_radius, d.tan_lead
        xi = {s: mechanics.friction_factor(d.friction_coefficient, tan, s) for s in (1, -1)}
        gamma = {s: mechanics.effective_inertia(d.screw_inertia, d.mass, r, tan, xi[s]) for s in xi}
        damping = {s: mechanics.effective_damping(d.support_damping, d.translation_damping, r, tan, xi[s]) for s in xi}
        net_force = d.axial_force - r * tan * d.translation_damping * d.input_speed
        law = -1 if net_force * d.input_speed < 0 else 1
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
