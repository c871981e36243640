r"""The energy balance of a motion: what input and axial force supply, and where it goes.

With θ′ the speed of the screw, x′ of the nut, z = θ − Ω t, and the mechanical energy

    E = I θ′²/2 + m x′²/2 + k z²/2     [+ k_c δ²/2]     [+ m_1 x_1′²/2 + k_1 x_1²/2]     [+ I_2 θ_2′²/2 + k_2 θ_2²/2],

Newton's laws (Sect. 5.3, eqs 8.1, 8.13; 8.6; Sect. 5.6, eq. 8.23; Sect. 5.8, eq. 8.33), each times its speed, give

    E′ = −k z Ω + R x′ − c θ′² − c_x x′² − c_c δ′² − c_1 x_1′² − c_2 θ_2′² − F_0 |x′| − T_0 |θ′| − D.

The coupling torque −k z turns the input at Ω. With rigid threads, which slip at the speed ω (θ′, or θ′ − θ_2′), D = μ
|N| r_m |ω| / cos λ. With compliant threads, δ = e cos λ and e′ = x′ − r_m tan λ θ′, friction acts on the screw in the
direction of θ′, so that D = μ |N| sgn θ′ (r_m θ′ / cos λ + e′ sin λ), and at rest D = F e′ sin λ with the friction
F = (−k z / r_m + N sin λ) / cos λ that holds the screw. A seizure stops ω by an impulse and takes M ω²/2,

    M = I + m r_m² tan² λ,      I + m̃ r_m² tan² λ  (support),      I_eff + m r_m² tan² λ  (nut).

Speeds, z and N are the engine's observables, all else is formed here from the parameters. |N| and |θ′| are absolute
values, not products with the signs that the mode stands for.

What the balance sees: wrong coefficients of a field, a wrong law or mode, a wrong reset, a wrong flow. What it does
not: an event that is late by a little, or one after which the same laws go on; and nothing below ``rounding``.
"""

import math
from typing import NamedTuple

import numpy as np

from benchmarks.sweeps.energy_quadrature import Terms, rates, residual
from lsvib.drives.friction import friction_factor
from lsvib.drives.parameters import DriveParameters, NutParameters, SupportParameters, ThreadsParameters
from lsvib.engine.automaton import Automaton
from lsvib.engine.motion import Motion


class Balance(NamedTuple):
    """Change of energy less work supplied plus losses, of the largest of these, and what rounding may make of it [1].

    ``rounding``: last places of the terms that speeds and forces are summed from, times the work they do, and of the
    clock, times power; both are nan if the motion would need too many nodes.
    """

    residual: float
    rounding: float


def balance(
    motion: Motion, drive: DriveParameters, physics: tuple[str, ...] = (), known: Terms | None = None
) -> Balance:
    """Balance the energy of a motion over its whole duration; ``physics`` has the words of frictions that are there.

    ``known``: the :func:`terms` of the drive, where many of its motions are asked for.
    """
    return Balance(*residual(motion, known or terms(motion.automaton, drive, physics)))


def terms(automaton: Automaton, drive: DriveParameters, physics: tuple[str, ...] = ()) -> Terms:
    """Energy and powers of a drive as products of affine functions of the state (see the module's docstring)."""
    seen, n = automaton.observables, len(automaton.states)
    unit, d = np.eye(n + 1), drive
    tan, cos, sin = math.tan(d.lead_angle), math.cos(d.lead_angle), math.sin(d.lead_angle)
    reach, rubbing = d.pitch_radius * tan, d.friction_coefficient * d.pitch_radius / cos
    speed, spring, normal = seen["screw_speed"][0], seen["coupling_deflection"][0], seen["normal_force"]
    one = unit[n]
    nut, slip = reach * speed, speed
    inertia, moved = d.screw_inertia, d.mass
    stored, lost, rubbed = [], [], []
    holding = np.zeros((len(automaton.codes), n + 1))
    sliding = rubbing * speed
    if isinstance(d, ThreadsParameters):
        nut = reach * speed + unit[3]
        stored.append((0.5 * d.contact_stiffness, cos * unit[2]))
        lost.append((d.contact_damping, cos * unit[3]))
        sliding = rubbing * speed + d.friction_coefficient * sin * unit[3]
        rest = np.isin(automaton.codes, automaton.rest_codes)
        friction = (-d.coupling_stiffness / d.pitch_radius * spring + sin * normal) / cos
        holding[rest] = friction[rest]
    elif isinstance(d, SupportParameters):
        nut, moved = reach * speed + unit[3], d.mass * d.screw_mass / (d.mass + d.screw_mass)
        force, _ = _steady(d, physics, reach)
        stored += [(0.5 * d.screw_mass, unit[3])]
        stored += [(0.5 * d.support_stiffness, unit[2] + force / d.support_stiffness * one)]
        lost.append((d.axial_support_damping, unit[3]))
    elif isinstance(d, NutParameters):
        slip = speed - unit[3]
        nut, sliding, inertia = reach * slip, rubbing * slip, inertia * d.nut_inertia / (inertia + d.nut_inertia)
        force, law = _steady(d, physics, reach)
        twist = d.pitch_radius * friction_factor(d.friction_coefficient, tan, law) * force
        stored += [(0.5 * d.nut_inertia, unit[3]), (0.5 * d.nut_stiffness, unit[2] + twist / d.nut_stiffness * one)]
        lost.append((d.nut_damping, unit[3]))
    stored += [(0.5 * d.screw_inertia, speed), (0.5 * d.mass, nut), (0.5 * d.coupling_stiffness, spring)]
    lost += [(d.support_damping, speed), (d.translation_damping, nut)]
    rubbed.append((normal, slip, sliding))
    for word, what in (("slide_friction", nut), ("bearing_friction", speed)):
        if word in physics:
            rubbed.append((np.broadcast_to(getattr(d, word) * one, normal.shape), what, what))
    supplied = [(-d.coupling_stiffness * d.input_speed, spring, one), (d.axial_force, nut, one)]
    return Terms(
        energy=np.array([np.sqrt(factor) * row for factor, row in stored]),
        left=np.array([*(factor * row for factor, row, _ in supplied), *(-factor * row for factor, row in lost)]),
        right=np.array([*(row for *_, row in supplied), *(row for _, row in lost)]),
        pressing=np.array([row for row, *_ in rubbed]),
        direction=np.array([row for _, row, _ in rubbed]),
        sliding=np.array([row for *_, row in rubbed]),
        holding=holding,
        approach=-sin * unit[3] if n == 4 else np.zeros(n + 1),
        seized=np.sqrt(0.5 * (inertia + moved * reach**2)) * slip,
        rates=rates(automaton.tables.flow),
    )


def _steady(drive: DriveParameters, physics: tuple[str, ...], reach: float) -> tuple[float, int]:
    """Axial force [N] that the threads carry in steady sliding, and its law."""
    turning = 1 if drive.input_speed > 0 else -1
    force = drive.axial_force - reach * drive.translation_damping * drive.input_speed
    force -= drive.slide_friction * turning * ("slide_friction" in physics)
    return force, -1 if force * turning < 0 else 1
