r"""Cases of compliant threads at the edge: contacts over eleven decades, and rates of slip that coincide.

With ν = cos λ (cos λ + s μ sin λ) the characteristic polynomial of slip under law s is (see
:func:`lsvib.steady_sliding.linearised.threads_model`)

    g(σ) + (k_c + c_c σ) h(σ),      g = (I σ² + c σ + k)(m σ² + c_x σ),      h = ν (Γ_s σ² + C_s σ + k).

So σ is a rate if k_c + c_c σ = q(σ) with q = −g/h; a double one if c_c = q′(σ) as well; a triple one if q″(σ) = 0, too.
"""

import math

import numpy as np
from mpmath import mp, mpf

from benchmarks.sweeps.families import MOST_TURNS, Case, CaseFamily, CaseGroup, power, sign
from benchmarks.sweeps.taylor import DIGITS
from lsvib.drives.parameters import ThreadsParameters
from lsvib.engine.exact.polynomials import multiplied
from lsvib.steady_sliding.linearised import threads_model

_LOW, _HIGH = 1e-3, 1e14  # of k_c [N/m] and c_c [N s/m]


def contact(rng) -> Case:
    """k_c and c_c from 1e3 to 1e14."""
    stiffness, damping = power(rng, 3, 14), power(rng, 3, 14)
    mass, force = rng.choice([5.0, 10.2, 11.0, 15.0]), rng.choice([100.0, 10.0, -50.0])
    drive = ThreadsParameters.of(mass=mass, axial_force=force, contact_stiffness=stiffness, contact_damping=damping)
    # So many radians of the contact where it vibrates, else of the drive.
    rate = math.sqrt(0.4 * stiffness)
    vibrates = damping < 4.0 * stiffness / rate
    duration = min(0.01, rng.uniform(5, 40) / rate) if vibrates else 0.01
    start = (rng.uniform(-0.2, 0.2), rng.uniform(-120, 60), 0.0, 0.0)
    return Case(CaseFamily.CONTACT, CaseGroup.ONLY, math.log10(stiffness), drive, start, duration)


def double_rate(rng) -> Case:
    """c_c or k_c – for three rates, both – at which rates coincide, rounded once, then moved by 10^level of itself."""
    while True:
        group = CaseGroup(rng.integers(CaseGroup.DOUBLE_BY_DAMPING, CaseGroup.TRIPLE + 1))
        law = sign(rng)
        drive = ThreadsParameters.of(
            mass=rng.uniform(0.5, 20.0),
            friction_coefficient=rng.uniform(0.05, 0.5),
            support_damping=power(rng, -4.5, -2.0),
            translation_damping=rng.integers(2) * rng.uniform(50.0, 2000.0),
            axial_force=sign(rng) * power(rng, 0.0, 2.3),
            input_speed=sign(rng) * rng.uniform(5.0, 80.0),
        )
        other = power(rng, 2, 9)  # the parameter that is not solved for
        found = coinciding(drive, law, group, other)
        if found:
            break
    stiffness, damping = found[rng.integers(len(found))]
    level = rng.uniform(-17, -1)
    factor = 1 + sign(rng) * 10.0**level
    if group == CaseGroup.DOUBLE_BY_STIFFNESS:
        drive = drive.replace(contact_stiffness=stiffness * factor, contact_damping=damping)
    else:
        drive = drive.replace(contact_stiffness=stiffness, contact_damping=damping * factor)
    start = (rng.uniform(-0.2, 0.2), drive.input_speed * rng.uniform(-3, 2), 0.0, 0.0)
    swing = math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
    duration = swing * rng.uniform(1.0, 8.0)
    turns = max(np.abs(np.linalg.eigvals(threads_model(drive, s).jacobian()).imag).max() for s in (1, -1)) / math.tau
    return Case(
        CaseFamily.DOUBLE_RATE_OF_THREADS, group, level, drive, start, min(duration, MOST_TURNS / (turns or 1e-9))
    )


def coinciding(drive: ThreadsParameters, law: int, group: CaseGroup, other: float) -> list[tuple[float, float]]:
    """Pairs (k_c, c_c) at which two real rates of slip under a law coincide, or three (``CaseGroup.TRIPLE``).

    ``other``: k_c [N/m] if c_c is solved for (``DOUBLE_BY_DAMPING``), c_c [N s/m] if k_c is (``DOUBLE_BY_STIFFNESS``).
    """
    with mp.workdps(DIGITS):
        g, h = _polynomials(drive, law)
        first = np.polysub(multiplied(np.polyder(g), h), multiplied(g, np.polyder(h)))  # −q′ h²
        if group == CaseGroup.TRIPLE:
            condition = np.polysub(multiplied(np.polyder(first), h), multiplied(2 * np.polyder(h), first))
        elif group == CaseGroup.DOUBLE_BY_DAMPING:  # q − k_c = σ q′
            condition = np.polysub([*first, mpf(0)], multiplied(h, np.polysub(g, [-mpf(other) * x for x in h])))
        else:
            condition = np.polysub(first, [-mpf(other) * x for x in multiplied(h, h)])
        found = []
        for root in _roots(condition):
            rate = mp.re(root)
            if abs(mp.im(root)) > mpf(10) ** -15 * abs(root) or not rate < 0:
                continue
            value, slope = np.polyval(h, rate), -np.polyval(first, rate) / np.polyval(h, rate) ** 2
            quotient = -np.polyval(g, rate) / value
            damping = {
                CaseGroup.DOUBLE_BY_STIFFNESS: mpf(other),
                CaseGroup.DOUBLE_BY_DAMPING: (quotient - other) / rate,
            }
            damping = damping.get(group, slope)
            stiffness = mpf(other) if group == CaseGroup.DOUBLE_BY_DAMPING else quotient - damping * rate
            if all(_LOW < x < _HIGH for x in (stiffness, damping)):
                found.append((float(stiffness), float(damping)))
        return found


def _polynomials(drive: ThreadsParameters, law: int) -> tuple[list, list]:
    """Return the polynomials g and h of the module's docstring, highest power first."""
    p = {key: mpf(value) for key, value in drive}
    tan, cos, sin = (f(p["lead_angle"]) for f in (mp.tan, mp.cos, mp.sin))
    mu = law * p["friction_coefficient"]
    lever = (mu - tan) / (1 + mu * tan) * tan * p["pitch_radius"] ** 2
    screw = [p["screw_inertia"], p["support_damping"], p["coupling_stiffness"]]
    rigid = [screw[0] - lever * p["mass"], screw[1] - lever * p["translation_damping"], screw[2]]
    nu = cos * (cos + mu * sin)
    return multiplied(screw, [p["mass"], p["translation_damping"], mpf(0)]), [nu * x for x in rigid]


def _roots(polynomial: np.ndarray) -> list:
    """Roots other than zero, in units in which the outermost coefficients are of one size."""
    polynomial = np.trim_zeros(polynomial)
    degree = len(polynomial) - 1
    unit = abs(polynomial[-1] / polynomial[0]) ** (mpf(1) / degree)
    companion = mp.zeros(degree)
    for k in range(degree):
        companion[0, k] = -polynomial[k + 1] * unit ** (-k - 1) / polynomial[0]
        if k:
            companion[k, k - 1] = mpf(1)
    return [unit * root for root in mp.eig(companion, left=False, right=False)]
