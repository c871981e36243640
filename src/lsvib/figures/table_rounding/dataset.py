"""How far the rounding of Table 8.1 explains the distances between printed and computed thresholds."""

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import printed
from lsvib.datasets.attributes import Variables, drive_parameters, flagged, origin_of, parameter, variable, yes_no
from lsvib.datasets.checks import Check
from lsvib.models import chapter
from lsvib.models.drive import RigidDrive, SupportDrive
from lsvib.models.mechanics import coefficients
from lsvib.numbers import bisected
from lsvib.stability import force_thresholds
from lsvib.stability.conditions import critical_friction, critical_mass
from lsvib.stability.threshold import HALF_UNITS, ROUND, propagated, solve_threshold

# Half a unit of the last digit of the printed thresholds: 10.10 kg, 0.285, 20 N, 34.5 N, 46.5 N.
_PRINTED_HALF_UNITS = {
    "critical_mass": 0.005,
    "critical_friction": 0.0005,
    "onset_force": 0.5,
    "stick_force": 0.05,
    "detach_force": 0.05,
}
_PLACES = ("Sect. 8.5.1", "Fig. 8.15", "Sect. 8.6")  # that state what the drives of the thresholds have
_VARIED = ("mass", "translation_damping")  # in which they differ; the thresholds of R do not depend on it
_WORDS = {"critical_friction": "critical friction coefficient"}

_SOLVED = {  # name of each threshold among those that are solved for a parameter, and the parameter
    "critical_mass": ("kinematic_constraint", "mass"),
    "critical_friction": ("kinematic_constraint", "friction_coefficient"),
    "onset_force": ("onset", "axial_force"),
    "stick_force": ("stick", "axial_force"),
    "detach_force": ("detach", "axial_force"),
}

PrintedThreshold = IntEnum("PrintedThreshold", list(_PRINTED_HALF_UNITS), start=0)
Parameter = IntEnum("Parameter", list(HALF_UNITS), start=0)


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the thresholds, their distance from print, and what half a unit of each parameter changes, relative.

    ``settings``: ``drive``, changes of Table 8.1, from which each threshold takes its own masses and damping as the
    chapter states them. Raises ``InputError`` or ``NoThreshold`` for a drive without a threshold.
    """
    base = RigidDrive.of(settings["drive"])
    own = {name: chapter.THRESHOLDS[name].drive for name in _PRINTED_HALF_UNITS}
    drives = {name: base.replace(**{k: x for k, x in row.items() if k != "screw_mass"}) for name, row in own.items()}
    screw_mass = own["critical_friction"]["screw_mass"]
    functions = {
        "critical_mass": critical_mass,
        "critical_friction": lambda drive: critical_friction(drive, screw_mass),
        **{name: getattr(force_thresholds, name) for name in ("onset_force", "stick_force", "detach_force")},
    }
    computed = np.array([functions[name](drives[name]) for name in _PRINTED_HALF_UNITS])
    with_screw = SupportDrive.of(drives["critical_friction"], screw_mass=screw_mass)
    asked = drives | {"critical_friction": with_screw}
    solved = [solve_threshold(drive, *_SOLVED[name]) for name, drive in asked.items()]
    changes = np.array([list(propagated(found).values()) for found in solved])
    return xr.Dataset(
        _relative_to(computed, changes) | _table(base) | _matching(drives["stick_force"], functions),
        coords={
            "threshold": flagged("threshold", PrintedThreshold, "threshold", PrintedThreshold),
            "parameter": flagged("parameter", Parameter, "parameter of Table 8.1", Parameter),
            **_printed_and_computed(computed),
            **drive_parameters(
                list(drives.values()), "threshold", along=_VARIED, printed=_PLACES, no_effect=("axial_force",)
            ),
            "screw_mass": ((), screw_mass, parameter("screw_mass", origin_of("screw_mass", screw_mass, _PLACES))),
        },
        attrs={
            "title": "Rounding of Table 8.1 and the printed thresholds",
            "source": "lsvib, thresholds in closed form and by the return map, with exact derivatives",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Table 8.1, Sects 8.5.1, 8.6.1, Fig. 8.15",
        },
    )


def _relative_to(computed: np.ndarray, changes: np.ndarray) -> Variables:
    """Distances from print and changes (threshold, parameter), relative to the computed thresholds."""
    in_print = np.array([chapter.THRESHOLDS[name].value for name in _PRINTED_HALF_UNITS])
    half_units = np.array(list(_PRINTED_HALF_UNITS.values())) / computed
    half, change = "half a unit of the last printed digit of the threshold, relative", changes / computed[:, None]
    words = "change of the threshold by half a unit of the parameter's last printed digit"
    return {
        "print_residual": variable("threshold", in_print / computed - 1, "1", "printed less computed, relative"),
        "print_half_unit": variable("threshold", half_units, "1", half),
        "relative_change": variable(("threshold", "parameter"), change, "1", words),
    }


def _table(drive: RigidDrive) -> Variables:
    """The values of Table 8.1, half a unit of their last digit, and which of them have only one digit."""
    halves, few = np.array(list(HALF_UNITS.values())), [name in ROUND for name in HALF_UNITS]
    values = [np.degrees(drive.lead_angle) if n == "lead_angle_deg" else getattr(drive, n) for n in HALF_UNITS]
    units = "SI units, angle in degrees"
    return {
        "half_unit": variable("parameter", halves, "1", f"half a unit of the last printed digit, {units}"),
        "printed_value": variable("parameter", values, "1", f"value of the parameter, {units}"),
        "one_digit": yes_no("parameter", few, "printed without a digit but the leading one"),
    }


def _matching(drive: RigidDrive, functions: Mapping[str, Callable[[RigidDrive], float]]) -> Variables:
    """The damping with which the printed stick force is the computed one, and what else it would change."""
    damping = _damping_of(functions["stick_force"], chapter.THRESHOLDS["stick_force"].value, drive)
    other, unit = drive.replace(support_damping=damping), "N m s rad-1"
    force, plus = functions["detach_force"](other), float(coefficients(other).damping[1])
    words, that = "support damping at which the stick force is the printed one", "with that damping"
    return {
        "matching_support_damping": variable((), damping, unit, words, "$c$"),
        "matching_detach_force": variable((), force, "N", f"detach force {that}", "$R$"),
        "matching_effective_damping_plus": variable((), plus, unit, f"effective damping of law + {that}", "$C_+$"),
    }


def _printed_and_computed(computed: np.ndarray) -> Variables:
    """The thresholds in print, and computed, as scalars."""
    words = {n: n.replace("_", " ") for n in _PRINTED_HALF_UNITS}
    return {
        f"printed_{n}": printed.variable(chapter.THRESHOLDS[n], _WORDS.get(n, said)) for n, said in words.items()
    } | {
        f"computed_{n}": variable((), value, chapter.THRESHOLDS[n].unit, f"{said}, computed")
        for (n, said), value in zip(words.items(), computed, strict=True)
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check which residuals the rounding explains, and which it does not."""
    residual, precise = np.abs(dataset.print_residual.values), dataset.one_digit.values == 0
    # The most that the values with three digits and the threshold's own print explain.
    allowed = np.abs(dataset.relative_change.values[:, precise]).sum(axis=1) + dataset.print_half_unit.values
    mass, friction, onset, stick, detach = (int(PrintedThreshold[name]) for name in _PRINTED_HALF_UNITS)
    damping, half = float(dataset.matching_support_damping), HALF_UNITS["support_damping"]
    force, claim = float(dataset.matching_detach_force), chapter.EFFECTIVE_DAMPING[1]
    distance = abs(force - chapter.THRESHOLDS["detach_force"].value)
    plus = float(dataset.matching_effective_damping_plus)

    def words(*which: int) -> str:
        return "; ".join(f"{PrintedThreshold(k).name}: {residual[k]:.2e} against {allowed[k]:.2e}" for k in which)

    return [
        Check.holds(
            "10.10 kg and 0.285 lie as far from the computed values as the rounding of the table's values with three "
            "digits explains",
            "Table 8.1, Sect. 8.6.1, Fig. 8.15",
            words(mass, friction),
            bool((residual[[mass, friction]] <= allowed[[mass, friction]]).all()),
        ),
        Check.holds(
            "20 N lies as far from the computed value as its own two digits explain",
            "Sect. 8.5.1, Fig. 8.6",
            words(onset),
            bool(residual[onset] <= allowed[onset]),
        ),
        Check.holds(
            "34.5 N and 46.5 N lie farther from the computed values than the rounding of the values with three digits "
            "and their own explains",
            "Table 8.1, Sect. 8.5.1, Fig. 8.6",
            words(stick, detach),
            bool((residual[[stick, detach]] > allowed[[stick, detach]]).all()),
        ),
        Check.holds(
            "One support damping that rounds to the printed one would give both 34.5 N and 46.5 N to their last digit",
            "Table 8.1, Sect. 8.5.1, Fig. 8.6",
            f"c = {damping:.4g} N m s/rad gives 34.5 N and {force:.5g} N",
            abs(damping - float(dataset.support_damping)) <= half and distance <= _PRINTED_HALF_UNITS["detach_force"],
        ),
        Check.holds(
            "but not the printed effective damping C₊, so it is not the damping of the chapter",
            "Sect. 8.5.1",
            f"C₊ = {plus:.4g} N m s/rad, printed {claim.value:g}",
            abs(plus / claim.value - 1) > claim.tolerance,
        ),
    ]


def _damping_of(threshold: Callable[[RigidDrive], float], force: float, drive: RigidDrive) -> float:
    """Support damping within half a unit of the printed one at which a threshold is ``force``, by bisection."""
    half = HALF_UNITS["support_damping"]
    low, high = drive.support_damping - half, drive.support_damping + half
    rising = threshold(drive.replace(support_damping=high)) > threshold(drive.replace(support_damping=low))
    return bisected(lambda c: (threshold(drive.replace(support_damping=c)) < force) != rising, low, high)
