"""Random drives such as catalogues offer, with compliant threads, support or nut, and starts of each; seeded.

Screws of 6–60 mm with leads of 1–25 mm (at most 1.2 diameters) and 0.1–1.5 m of steel, friction 0.05–0.35, couplings
and motors of the usual sizes for them, dampings from nearly none to strong.
"""

import math

import numpy as np

from lsvib.models.drive import Drive
from references.wide_drives import sizes_of

MODELS = ("threads", "support", "nut")
_STEEL = 7850.0  # density [kg/m3]


def catalogue_drive(model: str, seed: int, index: int, starts: int = 4) -> tuple[Drive, np.ndarray]:
    """Draw drive ``index`` of a seed, the same whatever else is drawn, and so many starts of it (starts, 4)."""
    rng = np.random.default_rng([seed, MODELS.index(model), index])

    def power(low: float, high: float) -> float:
        """Draw a number between two ends, its logarithm uniform."""
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    diameter, length = power(6e-3, 60e-3), power(0.1, 1.5)
    radius = 0.5 * (diameter - power(0.5e-3, 0.12 * diameter))
    lead = power(1e-3, min(25e-3, 1.2 * diameter))
    volume = math.pi / 4 * diameter**2 * length
    inertia = _STEEL * volume * diameter**2 / 8 * (1 + power(0.05, 1.0))
    stiffness = power(0.3, 30.0) * (diameter / 10e-3) ** 3 * 10
    mass = power(1.0, 200.0) * (diameter / 10e-3) ** 2
    values = {
        "pitch_radius": radius,
        "lead_angle": math.atan(lead / (2 * math.pi * radius)),
        "screw_inertia": inertia,
        "coupling_stiffness": stiffness,
        "support_damping": 2 * power(1e-4, 0.1) * math.sqrt(inertia * stiffness),
        "friction_coefficient": rng.uniform(0.05, 0.35),
        "input_speed": float(rng.choice([-1.0, 1.0])) * power(1.0, 150.0),
        "mass": mass,
        "translation_damping": float(rng.choice([0.0, 1.0])) * power(1.0, 500.0),
        "axial_force": float(rng.choice([-1.0, 1.0])) * power(0.2, 20.0) * mass,
    }
    drive = Drive.of({**values, **_MORE[model](power, values, volume)})
    scales = np.abs(sizes_of(drive))
    factors = np.array([[power(0.05, 5.0) * rng.choice([-1.0, 1.0]) for _ in scales] for _ in range(starts)])
    return drive, scales * factors


def _threads(power, values, volume):
    stiffness = power(2e7, 1e9)
    damping = 2 * power(5e-3, 0.5) * math.sqrt(stiffness * values["mass"])
    return {"contact_stiffness": stiffness, "contact_damping": damping}


def _support(power, values, volume):
    stiffness, mass = power(1e7, 3e8), _STEEL * volume
    damping = 2 * power(1e-3, 0.1) * math.sqrt(stiffness * mass)
    return {"screw_mass": mass, "support_stiffness": stiffness, "axial_support_damping": damping}


def _nut(power, values, volume):
    inertia = values["screw_inertia"] * power(0.1, 3.0)
    stiffness = values["coupling_stiffness"] * power(0.3, 100.0)
    damping = 2 * power(1e-3, 0.1) * math.sqrt(inertia * stiffness)
    return {"nut_inertia": inertia, "nut_stiffness": stiffness, "nut_damping": damping}


_MORE = {"threads": _threads, "support": _support, "nut": _nut}
