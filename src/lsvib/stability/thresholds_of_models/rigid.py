"""The rigid drive: the thresholds of the chapter (Sects 8.5 to 8.8)."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from lsvib.errors import NoThreshold
from lsvib.models import chapter
from lsvib.models.drive import Drive, RigidDrive, SupportDrive
from lsvib.stability import force_thresholds as forces
from lsvib.stability.conditions import critical_friction, critical_friction_by_eigenvalues, critical_mass

_COMPUTE: dict[str, Callable[[Any], float | None]] = {
    "critical_mass": critical_mass,
    "critical_friction": lambda drive: critical_friction(drive, getattr(drive, "screw_mass", math.inf)),
    "onset_force": forces.onset_force,
    "stick_force": forces.stick_force,
    "detach_force": forces.detach_force,
    "global_stability_force": forces.global_stability_force,
}
_STATEMENTS = {  # for input_speed > 0; for input_speed < 0 all forces change sign
    "onset_force": "Steady sliding attracts what is near under every smaller force and repels it under larger ones.",
    "stick_force": "From the onset to this force slip has an attracting cycle that does not come to rest; "
    "beyond it slip comes to a stand.",
    "detach_force": "From the onset to this force slip from the end of rest reaches N = 0; beyond it the stick-slip "
    "cycle does not.",
    "global_stability_force": "Under every smaller force all motions end in steady sliding; from this force to the "
    "onset, R = r_m tan(lead_angle) c_x Omega, some do not.",
}
_ABSENT = {
    "critical_mass": "The drive is not self-locking, so no mass makes the effective inertia vanish.",
    "critical_friction": "No friction coefficient below cot(lead_angle) makes the effective inertia vanish.",
}
WITHOUT_EFFECT = {"axial_force": "the forces of the rigid drive are thresholds of axial_force"}
"""Parameters of which a change moves none of these thresholds, and why."""


def thresholds(changes: Mapping[str, Any], itself: bool) -> dict[str, dict[str, Any]]:
    """Return the chapter's thresholds, as :func:`lsvib.stability.threshold_table.threshold_table` has them.

    Arguments: changes to the chapter's drives; whether these are all the parameters of a drive that stands for
    ``itself``, so that every threshold is its own. Raises ``InputError`` for unacceptable parameters.
    """
    table = {
        name: _entry(name, changes, claim.drive, claim.unit, claim.source, claim)
        for name, claim in chapter.THRESHOLDS.items()
    }
    if itself:
        table["critical_friction"] = _entry("critical_friction", changes, {}, "1", "eq. 8.20")
    name = "global_stability_force"
    return table | {name: _entry(name, changes, chapter.GLOBAL_STABILITY, "N", "end of Sect. 8.7")}


def _entry(
    name: str,
    changes: Mapping[str, Any],
    start: Mapping[str, Any],
    unit: str,
    source: str,
    claim: chapter.Claim | None = None,
) -> dict[str, Any]:
    """The entry of a threshold of the drive ``start`` with changes; ``claim``: what the chapter prints, if it does."""
    kind = SupportDrive if "screw_mass" in start else RigidDrive
    original = kind.of(start)
    drive = original.replace(
        **{key: value for key, value in changes.items() if key != "screw_mass" or kind is SupportDrive}
    )
    value, reason = _value_or_reason(name, drive)
    claim = claim if drive == original else None
    error = abs(value - claim.value) / claim.value if claim and value is not None else None
    entry = {
        "value": value,
        "unit": unit,
        "expected": claim and claim.value,
        "tolerance": claim and claim.tolerance,
        "relative_error": error,
        "passed": claim and (error is not None and error <= claim.tolerance),
        "source": source,
    }
    if name in _STATEMENTS:
        entry["statement"] = _STATEMENTS[name]
    if isinstance(drive, SupportDrive):
        entry["by_eigenvalues"] = critical_friction_by_eigenvalues(drive)
    if reason:
        entry["reason"] = reason
    return entry


def _value_or_reason(name: str, drive: Drive) -> tuple[float | None, str | None]:
    """A threshold, or None and why there is none."""
    try:
        value = _COMPUTE[name](drive)
    except NoThreshold as absent:
        return None, str(absent)
    return value, None if value is not None else _ABSENT[name]
