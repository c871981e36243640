"""What the chapter prints, and for which drives: the yardstick of the checks."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """A printed number: value, unit, source, the drive where it is not Table 8.1, relative tolerance and its reason."""

    value: float
    unit: str
    source: str
    drive: dict[str, float]
    tolerance: float = 0.02
    reason: str = "printed with ≈; 2 % allows for the reading of a printed axis"


_NEGATIVE_DAMPING = {"mass": 1.0, "translation_damping": 1e3}

THRESHOLDS = {
    "critical_mass": Claim(10.10, "kg", "Sect. 8.6.1, eq. 8.20", {}),
    "critical_friction": Claim(0.285, "1", "Fig. 8.15, eqs 8.27 and 8.28", {"mass": 15.0, "screw_mass": 11.6}),
    "onset_force": Claim(20.0, "N", "Sect. 8.5.1, Fig. 8.6", _NEGATIVE_DAMPING),
    "stick_force": Claim(34.5, "N", "Sect. 8.5.1, Fig. 8.6", _NEGATIVE_DAMPING),
    "detach_force": Claim(46.5, "N", "Sect. 8.5.1, Fig. 8.6", _NEGATIVE_DAMPING),
}

# Sect. 8.7 describes the threshold of global stability without a number; the drive is that of Fig. 8.14 beyond m_cr.
GLOBAL_STABILITY = {"mass": 11.0, "support_damping": 1e-3}
