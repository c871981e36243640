"""A motor in the data sheet: its control on the side of the screw, and what it changes."""

import math
import re

import pytest
from references import chapter_sheet
from references.command_line import complaint

from lsvib.assess.assessment import assess
from lsvib.assess.mechanisms import corners, drive_of, reserves
from lsvib.assess.report import report
from lsvib.assess.sheet import Sheet
from lsvib.stability.conditions import stability

GAINS = {"inertia": "2e-6 kg*m^2", "speed_gain": "1e-4 N*m*s/rad", "integral_gain": "0.0224 N*m/rad"}
MEASURED = {  # drive 1 of T-RO 2021, whose record shows the integral gain of its controller, on a coupling
    "name": "drive 1",
    "thread": {"lead": "2 mm", "pitch_diameter": "11 mm", "half_angle": "15 deg"},
    "screw": {"inertia": "2.186e-6 kg*m^2"},
    "coupling": {"stiffness": "20 N*m/rad", "damping": "1e-4 N*m*s/rad"},
    "motor": GAINS,
    "load": {"mass": "0.276 kg", "force": "0.9414 N", "orientation": "horizontal"},
    "operation": {"speed": ["2 rpm", "20 rpm"], "direction": "back"},
    "friction": {"coefficient": 0.58, "static": 0.88},
    "damping": {"rotational": "1e-4 N*m*s/rad"},
}


def values_of(**changes) -> dict[str, float]:
    return chapter_sheet.values_of(Sheet.of({**MEASURED, **changes}))


def test_gains_bandwidth_and_stepper_on_the_side_of_the_screw():
    geared = values_of(coupling={**MEASURED["coupling"], "gear_ratio": 3})
    assert geared["motor_inertia"] == pytest.approx(9 * 2e-6)
    assert (geared["integral_gain"], geared["speed_gain"]) == pytest.approx((9 * 0.0224, 9e-4))
    loop, both = values_of(motor={"inertia": "2e-6 kg*m^2", "bandwidth": "10 Hz"}), 2e-6 + 2.186e-6
    assert loop["speed_gain"] == pytest.approx(2 * math.pi * 10 * both)
    assert loop["speed_gain"] ** 2 == pytest.approx(4 * both * loop["integral_gain"])  # damped critically
    stepper = values_of(motor={"inertia": "2e-6 kg*m^2", "holding_torque": "0.5 N*m", "steps_per_turn": 200})
    assert (stepper["integral_gain"], stepper["speed_gain"]) == (25.0, 0.0)


def test_a_stiff_coupling_gives_the_drive_without_motor():
    """One body of both inertias on the gains; what it does from rest agrees to the compliance of the coupling."""
    found = assess(Sheet.of(MEASURED), samples=64)
    one = {key: value for key, value in MEASURED.items() if key != "motor"}
    one |= {"coupling": {"stiffness": "0.0224 N*m/rad"}, "damping": {"rotational": "2e-4 N*m*s/rad"}}
    one |= {"screw": {"inertia": "4.186e-6 kg*m^2"}}
    expected = assess(Sheet.of(one), samples=64)
    assert found.verdict == expected.verdict == "jerks"
    assert found.starting.even_speed == pytest.approx(expected.starting.even_speed, rel=5e-3)
    assert found.starting.motion.frequency == pytest.approx(expected.starting.motion.frequency, rel=5e-3)
    assert found.sheet.parts == ("motor",)


@pytest.mark.parametrize("support", [None, {"stiffness": "1e6 N/m", "damping": "20 N*s/m"}], ids=["rigid", "support"])
def test_reserves_are_those_of_the_whole_drive(support):
    """A weak speed loop and friction that falls, or damping of the load: unstable exactly where a reserve says so."""
    seen = set()
    for rise, drag in ((0.0, "1 N*s/m"), (0.3, "1 N*s/m"), (0.0, "3e4 N*s/m")):
        more = {"stribeck_rise": rise, "stribeck_speed": "10 mm/s"} if rise else {}
        entries = {**MEASURED, "friction": {"coefficient": 0.3, **more}, "operation": {"speed": "20 rpm"}}
        entries["motor"] = {**GAINS, "speed_gain": "1e-6 N*m*s/rad"}
        entries["load"] = {**MEASURED["load"], "force": "400 N"}
        entries["damping"] = {"rotational": "1e-5 N*m*s/rad", "translational": drag}
        if support:
            entries |= {"support": support, "screw": {"inertia": "2.186e-6 kg*m^2", "mass": "0.2 kg"}}
        sheet = Sheet.of(entries)
        values = chapter_sheet.values_of(sheet)
        for corner in corners(sheet, values):
            own = {name: float(value) for name, value in reserves(sheet, values, *corner).items()}
            stable = min(value for name, value in own.items() if name not in ("law", "after_perturbation")) > 0
            assert stability(drive_of(sheet, values, *corner, sheet.parts)).stable == stable
            seen.add(stable)
    assert seen == {True, False}


def test_wrong_motors_are_refused():
    for motor, said in (
        (None, "coupling.damping needs motor, against which it acts"),
        ({**GAINS, "bandwidth": "10 Hz"}, "motor.integral_gain and motor.bandwidth are both given; give one of them"),
        ({"inertia": "2e-6 kg*m^2"}, "motor has none of integral_gain, bandwidth, holding_torque"),
        ({**GAINS, "steps_per_turn": 200}, "motor.steps_per_turn is that of a stepper"),
    ):
        entries = {key: value for key, value in {**MEASURED, "motor": motor}.items() if value}
        assert complaint(Sheet.of, entries).startswith(said)


def test_the_report_says_which_oscillations_the_control_reaches():
    """That of both on the gains is damped by them, that of the screw against the motor on the coupling hardly."""
    found = assess(Sheet.of(MEASURED), samples=64)
    page = report(found, [])
    with_gain, without = re.search(r"damping ratios: ([^;]*); without[^:]*: ([^.]*\.?[^;]*?)\. What it", page).groups()
    slow, fast = (tuple(map(float, re.findall(r"ζ = ([0-9.e-]+)", text))) for text in (with_gain, without))
    assert slow[0] == pytest.approx(2 * fast[0], rel=0.05)  # c and K_p are alike
    assert slow[1] < 1.6 * fast[1]
