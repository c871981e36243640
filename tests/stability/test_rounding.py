"""What half a unit of the last digit of each value of Table 8.1 explains of the distances between print and thresholds.

The numbers are those of docs/physics.md, "What the rounding of Table 8.1 explains".
"""

import math

import pytest

from lsvib import Drive
from lsvib.drives import chapter
from lsvib.drives.mechanics import coefficients
from lsvib.numbers import bisected
from lsvib.stability.force_thresholds import threshold_force
from lsvib.stability.threshold import solve_threshold

HALF_UNITS = {  # of the values as Table 8.1 prints them: 5.18 mm, 5.57 degree, 3.12e-6, 0.218; and 1, 2e-4, 40
    "pitch_radius": 0.005e-3, "lead_angle": math.radians(0.005), "screw_inertia": 0.005e-6,
    "friction_coefficient": 0.0005, "coupling_stiffness": 0.5, "support_damping": 0.5e-4, "input_speed": 0.5,
}  # fmt: skip
PRECISE = [*HALF_UNITS][:4]
PRINTED = {  # half a unit of the last digit of the threshold itself, its name and unknown, and the table of the page
    "critical_mass": (0.005, "kinematic_constraint", "mass", (0.0787, 0, 0, 0)),
    "critical_friction": (0.0005, "kinematic_constraint", "friction_coefficient", (0.00075, 0, 0, 0)),
    "onset_force": (0.5, "onset", "axial_force", (0.038, 0, 0, 0.253)),
    "stick_force": (0.05, "stick", "axial_force", (0.101, 1.01, 2.59, 0.44)),
    "detach_force": (0.05, "detach", "axial_force", (0.143, 1.01, -1.18, 0.58)),
}
UNEXPLAINED = {"stick_force": 0.02, "detach_force": 0.01}  # which the chapter calls approximate
SUPPORT = {**chapter.PARTS["support"], "screw_mass": 11.6}


@pytest.mark.parametrize("name", PRINTED)
def test_the_printed_thresholds_are_allowed_what_rounding_explains(name):
    """But for two that it does not explain."""
    own, threshold, unknown, page = PRINTED[name]
    claim = chapter.claims()[chapter.THRESHOLDS[name]]
    found = solve_threshold(Drive.of(claim.drive, **SUPPORT if "screw_mass" in claim.drive else {}), threshold, unknown)
    solution = found.solutions[0]
    slopes = solution.derivatives
    change = {key: slopes[key].value * step for key, step in HALF_UNITS.items() if key != unknown}
    together = sum(abs(change.get(key, 0.0)) for key in PRECISE)
    computed = (together, *(change.get(key, 0.0) for key in [*HALF_UNITS][4:]))
    assert computed == pytest.approx(page, rel=0.05, abs=5e-5)
    assert name != "critical_mass" or solution.value - together > 10.02  # not even so the 10 kg of Fig. 8.14
    off, allowed = abs(claim.value - solution.value), together + own
    assert (off > allowed) is (name in UNEXPLAINED)
    assert claim.tolerance == (UNEXPLAINED.get(name) or pytest.approx(allowed / claim.value, rel=0.01))
    if name in UNEXPLAINED:
        assert off < claim.tolerance * claim.value
        assert f"{100 * allowed / claim.value:.2f} %" in claim.reason


def test_one_damping_gives_both_forces_but_not_the_printed_effective_damping():
    drive, half = Drive.of(chapter.claims()[chapter.THRESHOLDS["stick_force"]].drive), HALF_UNITS["support_damping"]
    printed = chapter.claims()[chapter.THRESHOLDS["stick_force"]].value

    def smaller(damping: float) -> bool:
        return threshold_force(drive.replace(support_damping=damping), "stick") < printed

    low, high = drive.support_damping - half, drive.support_damping + half
    damping = bisected(lambda c: smaller(c) == smaller(high), low, high)
    other = drive.replace(support_damping=damping)
    assert round(damping, 6) == 1.88e-4
    assert abs(threshold_force(other, "detach") - chapter.claims()[chapter.THRESHOLDS["detach_force"]].value) <= 0.05
    claim = chapter.claims()["fig8_06.damping_plus"]
    assert abs(float(coefficients(other).damping[1]) / claim.value - 1) > claim.tolerance
