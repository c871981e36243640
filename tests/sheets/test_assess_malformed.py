"""Malformed data sheets: one sentence that names the entry, exit code 2, nothing written; quantities as they are read.

Friction and efficiency against published tables, the rule of a third, and the force balance of a flank.
"""

import copy
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from references.command_line import refused
from references.random_sheets import LAW, sheet

from lsvib.drives import friction
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.fields import NotQuantity, quantity
from lsvib.sheets.formulas import (
    coefficient_from_efficiency,
    lifting_efficiency,
    lowering_efficiency,
    square_coefficient,
)
from lsvib.sheets.from_rest import Starter, from_rest
from lsvib.sheets.sheet import Load
from lsvib.sheets.threads import thread_size

BASE = {
    "name": "a drive", "thread": {"lead": "2 mm", "pitch_diameter": "9 mm"}, "screw": {"length": "300 mm"},
    "coupling": {"stiffness": "20 N*m/rad"}, "load": {"mass": "5 kg", "force": ["0 N", "50 N"]},
    "operation": {"speed": "10 mm/s"}, "friction": {"coefficient": 0.15},
}  # fmt: skip
GONE = object()

FIXED = {"length": "300 mm", "ends": "fixed-supported"}
MOTOR = {"inertia": "2e-6 kg*m^2", "speed_gain": "1e-4 N*m*s/rad", "integral_gain": "0.0224 N*m/rad"}
COLLAR = {"collar": {"coefficient": 0.1, "mean_diameter": "20 mm"}}  # beside a contact
LAWS = [
    ({"stribeck_speed": GONE}, "friction.stribeck_rise needs friction.stribeck_speed"),
    ({"stribeck_rise": GONE}, "friction.stribeck_speed and friction.stribeck_exponent need friction.stribeck_rise"),
    ({"stribeck_speed": "0.01 s"}, "friction.stribeck_speed = '0.01 s' is not a speed"),
    ({"stribeck_exponent": 3}, "friction.stribeck_exponent = 3 is not one of 1 or 2"),
    ({"static": 0.23}, "friction.static, at least 0.23, is not above the friction of slow sliding"),
    ({"coefficient": GONE, "efficiency": 0.3}, "friction.efficiency and friction.stribeck_rise are both given"),
]
FALLS = [["1 mm/s", 0.2], ["2 mm/s", 0.17], ["3 mm/s", 0.14], ["4 mm/s", 0.11]]
# Place, what stands there instead, and words that the sentence must hold.
CASES = [
    ("load", GONE, "load is missing"),
    ("load", {"orientation": "vertical", "force": "5 N"}, "load.orientation needs load.mass"),
    ("load", {}, "load has neither force nor mass"),
    ("thread.pitch_diameter", None, "give one of them, or friction.efficiency with the lead."),
    ("thread.colour", "red", "thread.colour is not a known key"),
    ("load", 5, "is not a set of names and values"),
    ("load.mass", 5, "has no unit"),
    ("load.mass", "5 N", "is not a mass"),
    ("load.mass", "5,5 kg", "is not a mass"),
    ("load.mass", "-5 kg", "outside the allowed range"),
    ("load.mass", "nan kg", "is not a mass"),
    ("load.mass", "10 kg**99999999", "is not a mass"),
    ("load.mass", "10 kg^(9^9^9^9)", "is not a mass"),
    ("load.mass", "10 kg**9**9**9", "is not a mass"),
    ("load.mass", "5 bananas", "= '5 bananas' has the unit 'bananas', which is not known; 20 kg would do."),
    ("load.force", "5 kg", "load.force = '5 kg' is a mass; as a force write 5 kgf."),
    ("load.mass", "5 tons", "= '5 tons' has an ambiguous unit; write t, short_ton or long_ton."),
    ("load.mass", "9 gr", "ambiguous unit; write g or grain"),
    ("name", None, "name = None is not text."),
    ("name", "", "name = '' is not text of one character or more."),
    ("sources", {"load.mass": 5}, "sources.load.mass = 5 is not text."),
    ("screw", {1: 2}, "screw.1 is not a known key; the known keys are inertia"),
    ("friction", {"pairing": ["iglidur_b"]}, "friction.pairing = ['iglidur_b'] is not known"),
    ("motor", {"inertia": "2e-6 kg*m^2", "bandwidth": 50}, "motor.bandwidth = 50 has no unit; write it with one, such"),
    ("thread.pitch_diameter", "14000 mm", "thread.pitch_diameter = 14 m is outside the allowed range 1e-05 m <= value"),
    ("bearing", {"collar": {"coefficient": 0.1, "mean_diameter": "9 m"}}, "bearing.collar.mean_diameter = 9 m is out"),
    ("screw.diameter", "14 m", "screw.diameter = 14 m is outside"),
    ("operation.speed", "1e4 m/s", "is outside the allowed range 0 m/s < value <= 1000 m/s"),
    ("load.mass", ["6 kg", "5 kg"], "are not in ascending order"),
    ("load.mass", {"low": "5 kg"}, "a distribution has"),
    ("load.mass", {"mean": "5 kg", "std": "2 kg"}, "standard deviations"),
    ("friction.coefficient", {"median": 0.2, "factor": 2}, "reaches 3.2 at four standard deviations"),
    ("load.orientation", "sideways", "horizontal or vertical"),
    ("thread.lead_angle", "5 deg", "both given"),
    ("thread.pitch_diameter", GONE, "none of size, nominal_diameter, pitch_diameter"),
    ("thread", {"size": "Tr 10x7"}, "not in the catalogue"),
    ("thread", {"size": "G 1/2"}, "is not the name of a thread"),
    ("thread", {"lead": "8 mm", "nominal_diameter": "8 mm"}, "needs thread.pitch, or thread.starts with thread.lead"),
    ("thread", {"size": "M20x3"}, "M20 has the pitches 2.5, 2, 1.5, 1 mm"),
    ("thread", {"lead": "8 mm", "pitch": "2 mm", "starts": 3, "pitch_diameter": "7 mm"}, "is not thread.starts times"),
    ("screw", {"length": "300 mm", "material": "cheese"}, "is not one of"),
    ("screw.ends", "loose", "screw.ends = 'loose' is not one of fixed-free"),
    ("screw.ends", "fixed-free", "screw.ends needs screw.root_diameter"),
    ("screw", {"inertia": "1e-6 kg*m^2", "ends": "fixed-free"}, "screw.ends needs screw.unsupported_length"),
    (
        "screw",
        {"length": "1 m", "density": "8 g/cm^3", "ends": "fixed-free"},
        "needs screw.modulus and screw.yield_stre",
    ),
    ("nut", {"material": "iglidur_b"}, "nut.length is missing"),
    ("nut", {"length": "9 mm", "material": "cheese"}, "nut.material = 'cheese' is not one of iglidur_j"),
    ("nut", {"length": "9 mm", "pv_limit": "5 MPa"}, "is not a pressure times a speed, such as 0.15 MPa*m/s"),
    ("friction", {"pairing": "cheese_dry"}, "friction.pairing = 'cheese_dry' is not known"),
    ("friction.pairing", "iglidur_b", "friction.pairing and friction.coefficient are both given"),
    ("coupling.stiffness", "20 N/m", "is not a torsional stiffness"),
    ("operation.speed", "10 mm", "is not a rotational speed or a speed"),
    ("operation.speed", ["10 mm/s", "60 rpm"], "mixes two kinds"),
    ("friction", {}, "none of coefficient"),
    ("friction", {"efficiency": "120 %"}, "outside the allowed range"),
    ("friction", {"curve": [["2 m/s", 0.2], ["1 m/s", 0.1]]}, "do not ascend"),
    ("friction", {"curve": [["0 m/s", 0.2], ["1 m/s", 0.1]]}, "give static friction as static"),
    ("friction", {"curve": FALLS[:3]}, "friction.curve needs points at four sliding speeds"),
    ("friction", {"curve": [["1 m", 0.2]]}, "friction.curve = '1 m' is not a speed, such as 10 mm/s"),
    ("friction", {"curve": [["1 m/s", 0.0]]}, "a coefficient outside the allowed range 1e-4 <= value <= 3"),
    ("friction", {"curve": FALLS, "efficiency": "40 %"}, "friction.curve and friction.efficiency are both given"),
    ("friction", {"curve": FALLS}, "friction.curve ends at 0.004 m/s, and the law that fits it falls to zero"),
    ("friction.coefficient", 20.0, "friction.coefficient"),
    *(("friction", LAW | more, words) for more, words in LAWS),
    ("screw", FIXED | {"root_diameter": "50 mm"}, "screw.root_diameter = 50 mm is not below the diameter of the"),
    ("screw", FIXED | {"unsupported_length": "5 m"}, "screw.unsupported_length = 5 m is above screw.length"),
    ("screw", FIXED | {"root_diameter": "1e-320 m"}, "outside the allowed range"),
    ("coupling.damping", "1e-4 N*m*s/rad", "coupling.damping needs a motor with inertia and control"),
    ("motor", MOTOR | {"bandwidth": "10 Hz"}, "motor.integral_gain and motor.bandwidth are both given; give one"),
    ("motor", {"steps_per_turn": 200}, "motor has none of inertia, rated_torque, peak_torque, holding_torque"),
    ("operation", {"move": {"distance": "1 m"}, "speed": "1 rpm"}, "operation.move has its own speed and ramps"),
    ("operation", {"move": {"distance": "1 m", "time": "1 s", "speed": "9 m/s"}}, "operation.move is inconsistent"),
    ("operation", {"move": {"distance": "1 m", "time": "1 s", "acceleration_time": "1 s"}}, "is inconsistent"),
    ("motor", {"torque_curve": [["9 rpm", "1 N*m"], ["3 rpm", "1 N*m"]]}, "motor.torque_curve needs two points"),
    ("motor", MOTOR | {"steps_per_turn": 200}, "motor.steps_per_turn makes the motor a stepper"),
    ("bearing", COLLAR, "bearing.collar cannot be assessed with a compliant support or contact"),
    ("guide", {"static": "5 N"}, "guide has none of friction, coefficient; give one"),
    ("guide", {"friction": ["4 N", "6 N"], "static": "5 N"}, "guide.static, at least 5 N, is below the friction in mo"),
    ("bearing", {"static": "5 mN*m"}, "bearing.static needs bearing.torque, the friction torque while the screw"),
    ("bearing", {"torque": "6 mN*m", "static": "5 mN*m"}, "at least 0.005 N m, is below the friction in motion, bear"),
    ("sources", {"load.colour": "a catalogue"}, "not in the sheet"),
]


def changed(place: str, value: object) -> dict:
    sheet = copy.deepcopy(BASE)
    *parts, last = place.split(".")
    at = sheet
    for part in parts:
        at = at[part]
    if value is GONE:
        del at[last]
    else:
        at[last] = {k: v for k, v in value.items() if v is not GONE} if isinstance(value, dict) else value
    if value is COLLAR:
        sheet["contact"] = {"stiffness": "1e8 N/m", "damping": "1e3 N*s/m"}
    return sheet


def refused_sheet(run, text: str, *options: str) -> str:
    """Assess a sheet, which must be refused; the one sentence that is said."""
    Path("drive.yaml").write_text(text, encoding="utf-8")
    return refused(run, "assess", "drive.yaml", "--out", "report", *options)


@pytest.mark.parametrize(("place", "value", "words"), CASES)
def test_a_malformed_entry_is_refused_in_one_sentence(run, place, value, words):
    assert words in refused_sheet(run, yaml.safe_dump(changed(place, value)))


def test_friction_that_jams_every_thread_is_refused(run):
    """μ ≥ cot λ: no torque turns the screw."""
    sheet = changed("friction.coefficient", 2.0) | {"thread": {"lead_angle": "40 deg", "pitch_diameter": "9 mm"}}
    assert "jam" in refused_sheet(run, yaml.safe_dump(sheet))


@pytest.mark.parametrize(
    ("text", "words", "option"),
    [("", "names and values", ""), ("a: [1\n", "YAML", ""), ("a: 1\na: 2\n", "given twice", ""),
     (yaml.safe_dump(BASE), "power of two", "--samples 100"), (yaml.safe_dump(BASE), "seed", "--seed -1")],
)  # fmt: skip
def test_a_file_that_is_no_sheet_and_a_bad_option_are_refused(run, text, words, option):
    assert words in refused_sheet(run, text, *option.split())


@pytest.mark.parametrize(("text", "expected"), [("99.9 %", 0.999), ("9.99e1 %", 0.999), ("35. %", 0.35)])
def test_a_percentage_is_the_nearest_double(text, expected):
    """99.9 % is the end of the range of efficiencies, which a division by 100 would miss."""
    assert quantity(text, "") == (expected, "")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 mm / s", "m/s", 0.01), ("1e-6 kg * m^2", "kg m^2", 1e-6), ("5 N/mm2", "Pa", 5e6), ("−5 N", "N", -5.0),
        ("7850 kg/m3", "kg/m^3", 7850.0), ("1/2 inch", "m", 0.0127), ("2 tpi", "m", 0.0127),
        ("14TPI", "m", 0.0254 / 14), ("1e3 N*s/m", "N s/m", 1e3), ("2e2 mm^2/mm", "m", 0.2), ("5 t", "kg", 5e3),
        *((f"2{text}", "kg m^2", 2.0) for text in (" kg*m^2", " kg*m**2", " kg*m^(2)", "000 g*m^2", " kg/m^-2")),
    ],
)  # fmt: skip
def test_a_quantity_is_read(text, unit, value):
    assert quantity(text, unit)[0] == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("0,15", "", "write 0.15"), ("5,5 kg", "kg", "write 5.5 kg"),
        ("1_0 N", "N", "not known"), ("٣ N", "N", "is not a force"), ("1 m2", "m", "is not a length"),
        ("1/0 inch", "m", "not known"), ("0 tpi", "m", "not known"), ("2 tpi", "N", "is not a force"),
        # Pint counts no radian, so that N m deg would pass for 0.017 N m/rad.
        ("30 N*m*deg", "N m/rad", "is not"), ("1 deg*deg/s", "rad/s", "is not"), ("1 deg^2", "rad", "is not"),
    ],
)  # fmt: skip
def test_what_is_no_quantity_is_refused(text, unit, words):
    with pytest.raises(NotQuantity, match=words):
        quantity(text, unit)


def test_the_orientation_may_begin_with_a_capital():
    load = Load.model_validate({"mass": "1 kg", "orientation": "Vertical"})
    assert load.orientation.nominal == pytest.approx(math.pi / 2)


def test_threads_of_catalogues_are_known():
    assert thread_size("M20") == thread_size("M20x2.5")
    assert thread_size("Tr 12x4").pitch_diameter == pytest.approx(10e-3)
    assert thread_size("Tr 100x12").root_diameter == pytest.approx(87e-3)  # ISO 2904: d_3
    with pytest.raises(NotQuantity, match="it goes from Tr 8 to Tr 300"):
        thread_size("Tr 400x8")


# PBC Linear, white paper "Lead Screw Efficiency": per cent by lead [mm]; diameters 6, 10, 12, 16 mm.
COATED = {
    1: (39, 28, 24, 19), 2: (60, 45, 40, 33), 4: (71, 61, 56, 49), 5: (76, 66, 62, 55), 6: (77, 69, 65, 58),
    8: (81, 74, 71, 65), 10: (84, 78, 75, 69), 12: (84, 80, 77, 72), 16: (None, 84, 81, 77), 25: (None, 86, 85, 83),
}  # fmt: skip
UNCOATED = {
    1: (30, 21, 18, 14), 2: (51, 36, 31, 25), 4: (62, 52, 47, 40), 5: (68, 57, 53, 45), 6: (70, 61, 56, 49),
    8: (75, 66, 62, 56), 10: (78, 71, 67, 61), 12: (81, 74, 70, 64), 16: (None, 78, 75, 70), 25: (None, 83, 81, 77),
}  # fmt: skip
# Trapezoidal screws, transdev.co.uk: thread, lead angle [degree, minute], efficiency at friction 0.1 and 0.2.
TRAPEZOIDAL = [
    ("Tr 10x2", (4, 2), 0.41, 0.26), ("Tr 10x4 P2", (8, 3), 0.58, 0.40), ("Tr 12x3", (5, 12), 0.47, 0.31),
    ("Tr 12x6 P3", (10, 19), 0.63, 0.46), ("Tr 14x4", (6, 3), 0.51, 0.34), ("Tr 16x4", (5, 12), 0.47, 0.31),
    ("Tr 18x4", (4, 33), 0.44, 0.28), ("Tr 20x4", (4, 3), 0.41, 0.26), ("Tr 20x8 P4", (8, 3), 0.58, 0.40),
    ("Tr 22x5", (4, 40), 0.45, 0.28), ("Tr 24x5", (4, 14), 0.42, 0.27),
]  # fmt: skip


def rows(table: dict):
    """Lead and diameter [mm] and efficiency [per cent] of a table."""
    for lead, row in table.items():
        yield from ((lead, d, eta) for d, eta in zip((6, 10, 12, 16), row, strict=True) if eta is not None)


@pytest.mark.parametrize(("table", "low", "high"), [(COATED, 0.069, 0.085), (UNCOATED, 0.092, 0.123)])
def test_friction_follows_from_published_efficiencies(table, low, high):
    """μ from each entry of PBC's table, up to the rounding of the entry to whole per cent, and back to the entry."""
    for lead, diameter, eta in rows(table):
        angle = math.atan(lead / (math.pi * diameter))
        found = coefficient_from_efficiency(eta / 100, angle)
        ends = [coefficient_from_efficiency((eta + part) / 100, angle) for part in (0.5, -0.5)]
        if (lead, diameter) in [(2, 10), (1, 16), (10, 6)]:
            assert low - 0.0005 <= found <= high + 0.0005
        assert ends[0] < high + 0.01
        assert ends[1] > low - 0.02
        assert round(100 * lifting_efficiency(found, angle)) == eta


@pytest.mark.parametrize(("name", "angle", "at_01", "at_02"), TRAPEZOIDAL)
def test_trapezoidal_threads_have_the_published_lead_angle_and_efficiency(name, angle, at_01, at_02):
    """The published efficiencies leave the flank angle out; the lead angle is printed to a minute."""
    size = thread_size(name)
    lead_angle = math.atan(size.lead / (math.pi * size.pitch_diameter))
    assert math.degrees(lead_angle) == pytest.approx(angle[0] + angle[1] / 60, abs=1 / 60)  # some are cut off
    for coefficient, eta in ((0.1, at_01), (0.2, at_02)):
        assert lifting_efficiency(coefficient, lead_angle) == pytest.approx(eta, abs=0.0051)


def test_the_rule_of_a_third_is_a_friction_of_0106():
    """Lead < diameter / 3 is self-locking exactly for μ > 1 / (3 π)."""
    angle = math.atan(1 / (3 * math.pi))
    assert lowering_efficiency(0.1062, angle) < 0 < lowering_efficiency(0.1060, angle)


def test_a_flank_angle_raises_friction_as_in_the_force_balance():
    """Against the balance of forces on a flank, with its normal vector from a cross product."""
    lead_angle, half_angle, mu = 0.12, math.radians(15), 0.17
    along = np.array([0.0, math.cos(lead_angle), math.sin(lead_angle)])  # radial, around, axial
    radial = np.array([math.cos(half_angle), 0.0, math.sin(half_angle)])
    normal = np.cross(along, radial)
    normal *= math.copysign(1, normal[2]) / np.linalg.norm(normal)
    force = normal - mu * along  # of the screw on the nut's flank when lifting
    eta = math.tan(lead_angle) * force[2] / -force[1]
    square = square_coefficient(mu, lead_angle, half_angle)
    assert lifting_efficiency(square, lead_angle) == pytest.approx(eta, rel=1e-14)


SLOW = {"speed": "10 rad/s", "direction": "out"}


def test_the_fall_of_the_law_decides_from_the_onset_force_on():
    """At 10 rad/s C_0 + S vanishes at R = 64.305 N, where the law is that of the powered seat, without drag."""
    given = sheet(friction=LAW, operation=SLOW)
    draw = Draw.of(given)
    found = [float(Operation(draw, 1, 10.0, -force).reserves["falling_friction"]) for force in (64.304, 64.307)]
    assert found[0] > 0 > found[1]
    below, above = (Operation(draw, 1, 10.0, -force).motion() for force in (62.0, 67.0))
    assert (below.attractor, above.attractor) == ("steady sliding", "stick slip cycle")
    assert above.load_speed[0] == 0 < above.amplitude


def test_a_start_from_rest_keeps_jerking_up_to_the_stated_speed():
    """On either side of it by two parts in a thousand; small perturbations decay there, as steady sliding is stable."""
    given = sheet(friction={**LAW, "static": 0.4}, operation=SLOW, load={"mass": "1 kg", "force": "-60 N"})
    draw = Draw.of(given)
    edge = from_rest(draw, Starter(given)).even_speed
    moved = [Operation(draw, 1, part * edge, -60.0).motion(None) for part in (0.998, 1.002)]
    assert [one.vibrates for one in moved] == [True, False]
    assert Operation(draw, 1, 0.998 * edge, -60.0).motion().attractor == "steady sliding"


@pytest.mark.parametrize("exponent", [1, 2])
def test_a_flank_angle_raises_all_of_the_law_alike(exponent):
    """The drive that is followed has, at any speed, the coefficient and the slope that the reserves use."""
    law = {**LAW, "static": 0.25, "stribeck_exponent": exponent}
    thread = {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm", "half_angle": "25 deg"}
    given, flat = sheet(friction=law, thread=thread), sheet(friction=law)
    drive, level = (Operation(Draw.of(one), 1, 3.0, 20.0).rigid for one in (given, flat))
    factor = square_coefficient(1.0, drive.lead_angle, math.radians(25))
    for key in ("friction_coefficient", "static_friction_coefficient", "stribeck_rise", "friction_slope"):
        assert getattr(drive, key) == pytest.approx(factor * getattr(level, key), rel=1e-14)
    assert (drive.stribeck_speed, drive.stribeck_exponent) == (0.013704, exponent)
    coefficient, slope = Operation(Draw.of(given), 1, 3.0, 20.0).friction
    speed = friction.steady_speed(drive.replace(input_speed=3.0).exact())
    expected = float(friction.coefficient(drive.exact(), speed))
    assert coefficient == pytest.approx(expected, rel=1e-14)
    assert slope == pytest.approx(float(friction.unbounded(drive.exact(), speed)[1]), rel=1e-14)
