"""Data sheets of the chapter's drive, and what they say."""

from lsvib.assess import drive as sheets
from lsvib.assess.sheet import Sheet

CHAPTER = {
    "name": "Table 8.1",
    "thread": {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm"},
    "screw": {"inertia": "3.12e-6 kg*m^2"},
    "coupling": {"stiffness": "1 N*m/rad"},
    "load": {"mass": "1 kg", "force": "-50 N"},
    "operation": {"speed": "40 rad/s", "direction": "out"},
    "friction": {"coefficient": 0.218},
    "damping": {"rotational": "2e-4 N*m*s/rad"},
}
# Of friction, the law of the powered seat.
LAW = {"coefficient": 0.218, "stribeck_rise": 0.0203, "stribeck_speed": "0.013704 m/s", "slope": "-0.0858859895667 s/m"}


def sheet(**changes) -> Sheet:
    """The chapter's drive with parts replaced."""
    return Sheet.of({**CHAPTER, **changes})


def values_of(given: Sheet) -> dict:
    """Its quantities at the middle values."""
    return {key: float(value) for key, value in sheets.quantities(given, sheets.nominal_draw(given)).items()}
