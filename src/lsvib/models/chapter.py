"""What the chapter prints, and for which drives: the yardstick of the checks."""

from dataclasses import dataclass

from lsvib.models.drive import Drive


@dataclass(frozen=True)
class Claim:
    """A printed number: value, unit, source, the drive where it is not Table 8.1, relative tolerance and its reason."""

    value: float
    unit: str
    source: str
    drive: dict[str, float]
    tolerance: float
    reason: str


_NEGATIVE_DAMPING = {"mass": 1.0, "translation_damping": 1e3}

# Values of parameters by the place that states them. Table 8.1 is the default of a drive.
STATED: dict[str, dict[str, tuple[float, ...]]] = {
    "Table 8.1": {
        name: (Drive.model_fields[name].default,)
        for name in (
            *("pitch_radius", "lead_angle", "screw_inertia", "coupling_stiffness", "support_damping"),
            *("friction_coefficient", "input_speed"),
        )
    },
    "Sect. 8.5.1": {key: (value,) for key, value in _NEGATIVE_DAMPING.items()},
    "Fig. 8.6": {"axial_force": (18.0, 25.0, 40.0)},
    "Sect. 8.6": {"translation_damping": (0.0,)},  # "for the remainder of the chapter"
    "Sect. 8.6.1": {"mass": (10.0, 11.0), "contact_stiffness": (1e8,), "contact_damping": (1e8,)},
    "Fig. 8.14": {"mass": (10.0,), "axial_force": (-50.0, -10.0), "support_damping": (1e-3,)},
    "Sect. 8.8.1": dict.fromkeys(("support_damping", "translation_damping", "axial_support_damping"), (0.0,)),
    "Fig. 8.15": {"mass": (15.0,), "screw_mass": (11.6,)},
}

# What half a unit of the last digit of the number itself and of r_m, λ, I and μ in Table 8.1 allows, all in one
# direction: tests/stability/test_rounding.py computes it.
_ROUNDING = "the rounding of the number and of the values of Table 8.1 with three digits (docs/physics.md)"
_READING = "not explained by rounding, which allows {}; called approximate and read from the axis of Fig. 8.6: {}"

THRESHOLDS = {
    "critical_mass": Claim(10.10, "kg", "Sect. 8.6.1, eq. 8.20", {}, 0.0083, _ROUNDING),
    "critical_friction": Claim(
        0.285, "1", "Fig. 8.15, eqs 8.27 and 8.28", {"mass": 15.0, "screw_mass": 11.6}, 0.0044, _ROUNDING
    ),
    "onset_force": Claim(20.0, "N", "Sect. 8.5.1, Fig. 8.6", _NEGATIVE_DAMPING, 0.027, _ROUNDING),
    "stick_force": Claim(34.5, "N", "Sect. 8.5.1, Fig. 8.6", _NEGATIVE_DAMPING, 0.02, _READING.format("0.44 %", "2 %")),
    "detach_force": Claim(
        46.5, "N", "Sect. 8.5.1, Fig. 8.6", _NEGATIVE_DAMPING, 0.01, _READING.format("0.41 %", "1 %")
    ),
}

# Not a threshold: the largest contact force on the cycle with k_c = c_c = 1e8 (SI).
PEAK_FORCE = Claim(
    *(320e3, "N", "Sect. 8.6.1, Fig. 8.10b", {"mass": 11.0}, 0.02),
    "printed with two digits, 1.6 %, and R, which moves it by 1.5 %, is not stated",
)

_TWO_DIGITS = "printed with two digits: half a unit of the last one"
_READ_AS = _NEGATIVE_DAMPING | {"mass": 8.0}  # the mass that the printed inertias belong to, not the stated one
EFFECTIVE_DAMPING = {  # by the sign of the law
    -1: Claim(1.0e-3, "N m s/rad", "Sect. 8.5.1", _NEGATIVE_DAMPING, 0.5e-4 / 1.0e-3, _TWO_DIGITS),
    1: Claim(-1.1e-4, "N m s/rad", "Sect. 8.5.1", _NEGATIVE_DAMPING, 0.5e-5 / 1.1e-4, _TWO_DIGITS),
}
EFFECTIVE_INERTIA = {
    -1: Claim(9.9e-6, "kg m2", "Sect. 8.5.1", _READ_AS, 0.5e-7 / 9.9e-6, _TWO_DIGITS),
    1: Claim(6.5e-7, "kg m2", "Sect. 8.5.1", _READ_AS, 0.5e-8 / 6.5e-7, _TWO_DIGITS),
}

TAN_LEAD = Claim(
    0.0975, "1", "Sect. 8.5.1", _NEGATIVE_DAMPING, 0.5e-4 / 0.0975, "printed with three digits: half a unit of the last"
)

# Every number that the chapter prints and that is no input: the thresholds first.
PRINTED = (*THRESHOLDS.values(), PEAK_FORCE, *EFFECTIVE_DAMPING.values(), *EFFECTIVE_INERTIA.values(), TAN_LEAD)

# Sect. 8.7 describes the threshold of global stability without a number; the drive is that of Fig. 8.14 beyond m_cr.
GLOBAL_STABILITY = {"mass": 11.0, "support_damping": 1e-3}

# Examples of parts: of Fig. 8.10, of Fig. 8.15 (k_1 is assumed), and of Sect. 5.8 the screw's own values, assumed.
PARTS = {
    "motor": {"motor_inertia": 1e-5, "integral_gain": 1.0, "speed_gain": 2e-3},
    "support": {"screw_mass": 11.6, "support_stiffness": 1e6, "axial_support_damping": 0.0},
    "nut": {"nut_inertia": 3.12e-6, "nut_stiffness": 1.0, "nut_damping": 2e-4},
    "threads": {"contact_stiffness": 1e8, "contact_damping": 1e8},
}


def drive_of(claim: Claim) -> Drive:
    """Return the drive that a claim is about."""
    return Drive.of(PARTS["support"] | claim.drive if "screw_mass" in claim.drive else claim.drive)
