"""Parameters over their full ranges, many decades of each, drawn at random."""

import math

import numpy as np

from benchmarks.sweeps.families import power, sign

ZERO_DAMPING = 0.25  # share of drives without a damping
_ZERO_FORCE = 0.1  # share of drives without an axial force


def zero_or(rng, share: float, low: float, high: float) -> float:
    """Draw zero in a share of all draws, else a number whose decimal logarithm is uniform between two bounds."""
    return 0.0 if rng.random() < share else power(rng, low, high)


def rigid_values(rng: np.random.Generator) -> dict[str, float]:
    """Draw the parameters of a rigid drive over decades; dampings and axial force are zero in a share of the drives."""
    lead = math.radians(power(rng, math.log10(0.5), math.log10(45.0)))
    friction = power(rng, -3, math.log10(0.9)) if rng.random() < 0.5 else rng.uniform(0.001, 0.9)
    force = sign(rng) * zero_or(rng, _ZERO_FORCE, -3, 6)
    return {
        "pitch_radius": power(rng, -3, math.log10(0.05)),
        "lead_angle": lead,
        "friction_coefficient": min(friction, 0.999 / math.tan(lead)),
        "mass": power(rng, -2, 4),
        "screw_inertia": power(rng, -9, 1),
        "coupling_stiffness": power(rng, -3, 6),
        "support_damping": zero_or(rng, ZERO_DAMPING, -9, 2),
        "translation_damping": zero_or(rng, ZERO_DAMPING, -4, 6),
        "axial_force": force,
        "input_speed": sign(rng) * power(rng, -2, 4),
    }
