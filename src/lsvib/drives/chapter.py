"""What the chapter says, and for which drives: the yardstick of the checks.

Every claim that a check compares stands in ``config/chapter.yaml``, once, under its id; the file beside this module is
a link to it (an installed package holds a copy). It is read when a claim is first asked for.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Any, Self

from lsvib.drives.drive import Drive
from lsvib.drives.scene import read_yaml

FILE = Path(__file__).with_name("chapter.yaml")


@dataclass(frozen=True)
class Claim:
    """A claim, and for a number how far a check may be off: ``tolerance`` is relative, ``reason`` says why so much.

    ``value``: what the chapter prints, in ``unit``, nan of a sentence; ``digits``: the same with its final zeros;
    ``drive``: for which changes of the drive of Table 8.1; ``correction``: what is wrong, by kind. ``found``: what a
    check found, in words. Texts may leave something open, in braces, that :class:`lsvib.chapter.checks.Check` fills in.
    """

    id: str
    claim: str
    source: str
    value: float = float("nan")
    digits: str = ""
    unit: str = "1"
    tolerance: float = 1e-12
    reason: str = "both exact; rounding only"
    found: str = ""
    drive: dict[str, float] = field(default_factory=dict)
    correction: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Self:
        """Make a claim of its entry in the file; ``deviation`` there is the largest one allowed, in the unit."""
        known = {key.name: entry[key.name] for key in fields(cls) if key.name in entry}
        if "deviation" in entry:
            known["tolerance"] = entry["deviation"] / abs(entry["value"])
        return cls(**known)


@cache
def listed() -> dict[str, list[dict[str, Any]]]:
    """Return what the file holds: ``entries``, which are statements of the chapter, and ``ours``."""
    return read_yaml(FILE)


@cache
def claims() -> dict[str, Claim]:
    """Return what checks compare, by id: claims of the chapter, and ours."""
    return {entry["id"]: Claim.of(entry) for part in listed().values() for entry in part if "id" in entry}


THRESHOLDS = {
    "critical_mass": "fig8_08.critical_mass",
    "critical_friction": "fig8_15.critical_friction",
    "onset_force": "fig8_06.onset_force",
    "stick_force": "fig8_06.stick_force",
    "detach_force": "fig8_06.detach_force",
}
"""The thresholds that the chapter prints: their names, and the ids of the claims."""


def printed() -> list[Claim]:
    """Return every number that the chapter prints and that is no input: the thresholds first."""
    rest = [entry["id"] for entry in listed()["entries"] if "value" in entry and "id" in entry]
    return [claims()[id] for id in dict.fromkeys((*THRESHOLDS.values(), *rest))]


# Values of parameters by the place that states them. Table 8.1 is the default of a drive.
STATED: dict[str, dict[str, tuple[float, ...]]] = {
    "Table 8.1": {
        name: (Drive.model_fields[name].default,)
        for name in (
            *("pitch_radius", "lead_angle", "screw_inertia", "coupling_stiffness", "support_damping"),
            *("friction_coefficient", "input_speed"),
        )
    },
    "Sect. 8.5.1": {"mass": (1.0,), "translation_damping": (1e3,)},
    "Fig. 8.6": {"axial_force": (18.0, 25.0, 40.0)},
    "Sect. 8.6": {"translation_damping": (0.0,)},  # "for the remainder of the chapter"
    "Sect. 8.6.1": {"mass": (10.0, 11.0), "contact_stiffness": (1e8,), "contact_damping": (1e8,)},
    "Fig. 8.14": {"mass": (10.0,), "axial_force": (-50.0, -10.0), "support_damping": (1e-3,)},
    "Sect. 8.8.1": dict.fromkeys(("support_damping", "translation_damping", "axial_support_damping"), (0.0,)),
    "Fig. 8.15": {"mass": (15.0,), "screw_mass": (11.6,)},
}

# Examples of parts: of Fig. 8.10, of Fig. 8.15 (k_1 is assumed), and of Sect. 5.8 the screw's own values, assumed.
PARTS = {
    "motor": {"motor_inertia": 1e-5, "integral_gain": 1.0, "speed_gain": 2e-3},
    "support": {"screw_mass": 11.6, "support_stiffness": 1e6, "axial_support_damping": 0.0},
    "nut": {"nut_inertia": 3.12e-6, "nut_stiffness": 1.0, "nut_damping": 2e-4},
    "threads": {"contact_stiffness": 1e8, "contact_damping": 1e8},
}
