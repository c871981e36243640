"""What the rounding of Table 8.1 does to a threshold: half a unit of each last digit, by exact derivatives."""

import math

from lsvib.results import SolvedThreshold

# Half a unit of the last digit of each value as Table 8.1 prints it: 5.18 mm, 5.57 degree, 3.12e-6, 1, 2e-4, 0.218, 40.
HALF_UNITS = {
    "pitch_radius": 0.005e-3,
    "lead_angle_deg": 0.005,
    "screw_inertia": 0.005e-6,
    "coupling_stiffness": 0.5,
    "support_damping": 0.5e-4,
    "friction_coefficient": 0.0005,
    "input_speed": 0.5,
}
ROUND = ("coupling_stiffness", "support_damping", "input_speed")
"""Values with no digit but the leading one, 1, 2e-4 and 40: they look chosen, and half a unit is up to half of them."""


def propagated(threshold: SolvedThreshold) -> dict[str, float]:
    """Return the change of a threshold by half a unit of each parameter, ∂f/∂p · h, by name [unit of the threshold].

    The threshold is solved at the drive with the printed values; the half units h are in SI, the angle's in degrees.
    Its own parameter changes nothing.
    """
    slopes = threshold.derivatives

    def slope(name: str) -> float:
        if name == "lead_angle_deg":
            return math.radians(slope("lead_angle"))
        return 0.0 if name == threshold.unknown else slopes[name].value or 0.0

    return {name: slope(name) * h for name, h in HALF_UNITS.items()}
