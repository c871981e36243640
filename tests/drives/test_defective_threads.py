"""Compliant threads with rates that coincide: parameter sets for each way, against a 40-digit reference.

With c̃ = c/I, k̃ = k/I, γ = ν c_c, η = ν k_c, ν = cos λ (cos λ + s μ sin λ) / m and β = 1 − m r_m tan λ ℓ / [I (cos λ +
s μ sin λ)], ℓ = r_m (s μ cos λ − sin λ), the characteristic polynomial of slip under law s without c_x is

    s⁴ + (c̃ + β γ) s³ + (k̃ + c̃ γ + β η) s² + (k̃ γ + c̃ η) s + k̃ η.

Four coefficients, four parameters: any rates that leave these positive can be had. The parameters are rounded to
double, which parts n-fold rates by about the n-th root of its rounding. Tolerances are those of ``reference.threads``.
"""

import pytest
from mpmath import mp, mpf
from references.dense import simulate
from references.threads_comparison import compare

from lsvib.drives.parameters import ThreadsParameters
from lsvib.engine.kernels.tables import BlockFlow

BASE = ThreadsParameters.of(mass=2.0, axial_force=100.0)


def tuned(law, rates, guess):
    """Drive with k = 1 N m/rad whose rates of slip under a law are in proportion to four given ones."""
    with mp.workdps(40):
        angle, mu = mpf(BASE.lead_angle), mpf(BASE.friction_coefficient)
        radius, inertia, mass = mpf(BASE.pitch_radius), mpf(BASE.screw_inertia), mpf(BASE.mass)
        axial = mp.cos(angle) + law * mu * mp.sin(angle)
        lever = radius * (law * mu * mp.cos(angle) - mp.sin(angle))
        beta, nu = 1 - mass * radius * mp.tan(angle) * lever / (inertia * axial), mp.cos(angle) * axial / mass
        wanted = [mpf(1)]
        for rate in rates:
            wanted = [x - rate * y for x, y in zip([*wanted, 0], [0, *wanted], strict=True)]
        _, a3, a2, a1, a0 = (mp.re(x) for x in wanted)
        c, k, gamma, eta = mp.findroot(
            lambda c, k, g, e: (c + beta * g - a3, k + c * g + beta * e - a2, k * g + c * e - a1, k * e - a0), guess
        )
        unit = 1 / mp.sqrt(inertia * k)
        values = {
            "support_damping": inertia * c * unit,
            "contact_stiffness": eta * unit**2 / nu,
            "contact_damping": gamma * unit / nu,
        }
        return BASE.replace(**{key: float(x) if abs(x) > mpf(10) ** -30 else 0.0 for key, x in values.items()})


DRIVES = {
    "four equal real rates, condition 5e13": (1, [-1] * 4, (2, 1, 2, 1)),
    "three equal real rates": (1, [-1, -1, -1, -3], (2, 1, 3, 3)),
    "three equal real rates, law -1": (-1, [-1, -1, -1, -0.3], (2, 1, 1.3, 0.3)),
    "two equal complex pairs": (1, [-0.1 + 1j, -0.1 - 1j] * 2, (0.2, 1, 0.2, 1)),
    "undamped, on the boundary of flutter": (1, [1j, -1j] * 2, (0.01, 1, -0.01, 1)),
    "two rates next to none": None,
}
BACKWARD, WOUND_UP = (-0.05, -60.0, 1e-3, 1e-3), (0.1, 30.0, 0.0, -1e-2)


def drive_of(name):
    if DRIVES[name] is None:
        return BASE.replace(contact_stiffness=1e-9, contact_damping=0.0)
    return tuned(*DRIVES[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", DRIVES)
def test_motion(name):
    result = compare(drive_of(name), BACKWARD, 0.006, simulate)
    assert isinstance(result.motion.automaton.tables.flow, BlockFlow)
    assert result.faults(name) == []
    assert result.kinds


@pytest.mark.long
@pytest.mark.parametrize("start", [BACKWARD, WOUND_UP])
@pytest.mark.parametrize("name", DRIVES)
def test_longer_motion(name, start):
    assert compare(drive_of(name), start, 0.05, simulate).faults(name) == []
