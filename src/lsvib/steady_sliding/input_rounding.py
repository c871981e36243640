"""What the rounding of Table 8.1 does to a threshold: half a unit of each last digit, by central differences."""

from collections.abc import Callable, Mapping

from lsvib.drives.parameters import RigidParameters

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

# Central differences: a step of this part of half a unit leaves a relative error of (1e-3)^2 and keeps ten digits.
_STEP = 1e-3


def propagated(
    threshold: Callable[[RigidParameters], float], drive: RigidParameters, half_units: Mapping[str, float] = HALF_UNITS
) -> dict[str, float]:
    """Return the change of a threshold by half a unit of each parameter, ∂f/∂p · h, by name [unit of the threshold].

    Arguments: the threshold as a function of a drive; the drive, with the printed values; the half units h [SI, angle
    in degrees]. Raises what ``threshold`` raises at a drive next to the printed one.
    """
    return {
        name: (threshold(_moved(drive, name, _STEP * h)) - threshold(_moved(drive, name, -_STEP * h))) / (2 * _STEP)
        for name, h in half_units.items()
    }


def _moved(drive: RigidParameters, name: str, by: float) -> RigidParameters:
    if name == "lead_angle_deg":
        # 180 / pi to double precision: the angle is stored in radians.
        return drive.replace(lead_angle=drive.lead_angle + by / 57.29577951308232)
    return drive.replace(**{name: getattr(drive, name) + by})
