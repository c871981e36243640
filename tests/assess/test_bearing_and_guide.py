"""Thrust collar, bearing and guide in the assessment: examples of textbooks, and the drive that is followed."""

import math

import pytest
from references.chapter_sheet import values_of

from lsvib.assess.assessment import assess
from lsvib.assess.mechanisms import corners, drive_of, reserves
from lsvib.assess.sheet import Sheet
from lsvib.assess.statics import lets_go, statics
from lsvib.errors import InputError
from lsvib.stability.conditions import stability

# Examples of power screws that FOSSEE has solved (Scilab-TBC-Uploads 764, chapter 6), and Shigley's. They take the half
# angle of a trapezoidal flank in the axial section, we in the normal one: within 2 parts in 10⁴ the same.
PRINTED = {
    "double start 2 x 12 on 100 mm, no collar (6.2)": (
        {
            "thread": {"pitch_diameter": "94 mm", "lead": "24 mm", "half_angle": "15 deg"},
            "load": {"force": "300 kN"},
            "operation": {"speed": "1 rpm", "direction": "both"},
            "friction": {"coefficient": 0.15},
        },
        {"lifting_torque": 3378.2, "lowering_torque": 1030.7, "lifting_efficiency": 0.339},
    ),
    "single start 52 x 8, collar 100 / 60 mm (6.6)": (
        {
            "thread": {"pitch_diameter": "48 mm", "lead": "8 mm", "half_angle": "15 deg"},
            "load": {"force": "2 kN"},
            "operation": {"speed": "30 rpm", "direction": "out"},
            "friction": {"coefficient": 0.15},
            "bearing": {"collar": {"coefficient": 0.12, "mean_diameter": "80 mm"}},
        },
        {"lifting_power": 61.8, "lifting_efficiency": 0.1294},
    ),
    "44 mm mean, lead 8 mm, collar radius 40 mm, 5 m/min": (
        {
            "thread": {"pitch_diameter": "44 mm", "lead": "8 mm"},
            "load": {"force": "500 N"},
            "operation": {"speed": "5 m/min", "direction": "out"},
            "friction": {"coefficient": 0.15},
            "bearing": {"collar": {"coefficient": 0.15, "mean_diameter": "80 mm"}},
        },
        {"lifting_power": 347.3, "lifting_efficiency": 0.120},
    ),
    "32 x 4 double, 6.4 kN, collar 40 mm (Shigley)": (
        {
            "thread": {"pitch_diameter": "30 mm", "lead": "8 mm"},
            "load": {"force": "6.4 kN"},
            "operation": {"speed": "1 rpm", "direction": "both"},
            "friction": {"coefficient": 0.08},
            "bearing": {"collar": {"coefficient": 0.08, "mean_diameter": "40 mm"}},
        },
        {"lifting_torque": 26.18, "lowering_torque": 9.77, "lifting_efficiency": 0.311},
    ),
}


@pytest.mark.parametrize(("entries", "printed"), PRINTED.values(), ids=PRINTED)
def test_torque_power_and_efficiency_of_textbooks(entries, printed):
    rows = statics(Sheet.of({"name": "of a book", **entries})).rows
    for key, value in printed.items():
        digits = len(f"{value:g}".replace("0.", "").replace(".", ""))
        half = 0.51 * 10.0 ** (math.floor(math.log10(value)) - digits + 1)
        assert rows[key].worst == pytest.approx(value, abs=max(half, 2e-4 * value)), key


@pytest.mark.parametrize(
    ("lead", "diameter", "friction"), [("24 mm", "46 mm", 0.15), ("8 mm", "30 mm", 0.08)], ids=["24 on 46", "8 on 30"]
)
def test_a_collar_holds_what_the_threads_do_not(lead, diameter, friction):
    sheet = {
        "name": "held by its collar",
        "thread": {"lead": lead, "pitch_diameter": diameter},
        "load": {"force": "1 kN"},
        "operation": {"speed": "30 rpm", "direction": "both"},
        "friction": {"coefficient": friction},
    }
    collar = {"bearing": {"collar": {"coefficient": friction, "mean_diameter": diameter}}}
    bare, held = (statics(Sheet.of({**sheet, **more})) for more in ({}, collar))
    assert (bare.back_drives, held.back_drives) == ("at the middle values", False)
    assert "holding_torque" in bare.rows
    assert "holding_torque" not in held.rows


DRIVE = {
    "name": "with all that rubs",
    "thread": {"lead": "4 mm", "pitch_diameter": "14 mm", "half_angle": "15 deg"},
    "screw": {"inertia": "1e-5 kg*m^2"},
    "coupling": {"stiffness": "20 N*m/rad"},
    "load": {"mass": "20 kg", "force": "100 N", "orientation": "horizontal"},
    "operation": {"speed": "100 rpm", "direction": "both"},
    "friction": {"coefficient": 0.15},
    "damping": {"rotational": "1e-3 N*m*s/rad", "translational": "50 N*s/m"},
    "bearing": {
        "torque": "10 mN*m",
        "viscous": "1e-3 N*m*s/rad",
        "collar": {"coefficient": 0.1, "mean_diameter": "20 mm"},
    },
    "guide": {"friction": "30 N"},
}


def test_the_drive_that_is_followed_has_them_and_reserves_agree_with_its_eigenvalues():
    sheet = Sheet.of(DRIVE)
    for mass in (5.0, 20.0, 60.0, 300.0):
        values = {**values_of(sheet), "mass": mass}
        for corner in corners(sheet, values):
            drive = drive_of(sheet, values, *corner)
            assert (drive.bearing_friction, drive.slide_friction) == (0.01, 30.0)
            assert (drive.collar_friction, drive.collar_radius) == (0.1, 0.01)
            assert drive.support_damping == 2e-3
            own = reserves(sheet, values, *corner)
            stable = min(float(own[name]) for name in ("kinematic_constraint", "negative_damping")) > 0
            assert stability(drive).stable == stable


def test_torques_count_bearing_and_guide():
    rows = statics(Sheet.of(DRIVE)).rows
    radius, angle, speed = 7e-3, math.atan(4 / (14 * math.pi)), 100 * math.pi / 30
    mu = 0.15 * math.sqrt(1 + (math.cos(angle) * math.tan(math.radians(15))) ** 2)
    force = 100 + 30 + 50 * radius * math.tan(angle) * speed
    threads = force * (radius * math.tan(angle + math.atan(mu)) + 0.1 * 0.01)
    assert rows["lifting_torque"].worst == pytest.approx(threads + 0.01 + 2e-3 * speed, rel=1e-12)
    useful = 100 * radius * math.tan(angle)
    spent = 130 * (radius * math.tan(angle + math.atan(mu)) + 0.1 * 0.01) + 0.01
    assert rows["lifting_efficiency"].worst == pytest.approx(useful / spent, rel=1e-12)


def test_stress_of_load_and_torque_in_the_root():
    """With a root of 28 mm, 6.4 kN and 26.18 N m are 10.4 and 6.07 MPa (Shigley, example of power screws)."""
    entries, _ = PRINTED["32 x 4 double, 6.4 kN, collar 40 mm (Shigley)"]
    row = statics(Sheet.of({"name": "of a book", **entries, "screw": {"root_diameter": "28 mm"}})).rows["root_stress"]
    assert row.worst == pytest.approx(math.hypot(10.39e6, math.sqrt(3) * 6.074e6), rel=1e-3)
    assert row.limit == 250e6  # of A36
    assert not row.exceeded


def test_a_whole_assessment_with_all_that_rubs():
    """Steady with 2 kg; with 20 kg the collar takes its critical mass below that, and it vibrates."""
    light = assess(Sheet.of({**DRIVE, "load": {**DRIVE["load"], "mass": "2 kg"}}), samples=64)
    found = assess(Sheet.of(DRIVE), samples=64)
    assert (light.verdict, found.verdict) == ("steady", "vibrates")
    assert light.starting.jerks is False
    bare = {key: value for key, value in DRIVE.items() if key != "bearing"}
    assert assess(Sheet.of(bare), samples=64).verdict == "steady"
    assert not lets_go(found.sheet, found.values, {"friction": 0.14})


def test_a_collar_beside_parts_that_comply_is_refused():
    with pytest.raises(InputError, match=r"^bearing.collar is not judged beside a support or contact that complies"):
        Sheet.of({**DRIVE, "contact": {"stiffness": "1e8 N/m", "damping": "1e3 N*s/m"}})
