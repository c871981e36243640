"""Malformed data sheets: one sentence that names the entry, exit code 2, and nothing written.

Quantities and threads as people write them: read, or refused with what to write instead.
"""

import copy
import math
from pathlib import Path

import pytest
import yaml
from references.command_line import refused

from lsvib.assess.fields import NotQuantity, quantity
from lsvib.assess.sheet import Load
from lsvib.assess.threads import thread_size

BASE = {
    "name": "a drive",
    "thread": {"lead": "2 mm", "pitch_diameter": "9 mm"},
    "screw": {"length": "300 mm"},
    "coupling": {"stiffness": "20 N*m/rad"},
    "load": {"mass": "5 kg", "force": ["0 N", "50 N"]},
    "operation": {"speed": "10 mm/s"},
    "friction": {"coefficient": 0.15},
}
GONE = object()

# Place, what stands there instead, and words that the sentence must hold.
CASES = [
    ("load", GONE, "load is missing"),
    ("load", {"orientation": "vertical", "force": "5 N"}, "load.orientation needs load.mass"),
    ("load", {}, "load has neither force nor mass"),
    ("load.mass", GONE, "a report needs what vibration needs; the sheet does not give load.mass"),
    ("thread.colour", "red", "thread.colour is not a known key"),
    ("load", 5, "does not hold names and values"),
    ("load.mass", 5, "has no unit"),
    ("load.mass", "5 N", "is not a mass"),
    ("load.mass", "5,5 kg", "is not a mass"),
    ("load.mass", "-5 kg", "outside the allowed range"),
    ("load.mass", "nan kg", "is not a mass"),
    ("load.mass", "10 kg**99999999", "is not a mass"),
    ("load.mass", "10 kg^(9^9^9^9)", "is not a mass"),
    ("load.mass", "10 kg**9**9**9", "is not a mass"),
    ("load.mass", "5 bananas", "is not known"),
    ("load.mass", None, "load.mass"),
    ("load.mass", ["6 kg", "5 kg"], "do not ascend"),
    ("load.mass", {"low": "5 kg"}, "a distribution has"),
    ("load.mass", {"mean": "5 kg", "std": "2 kg"}, "standard deviations"),
    ("friction.coefficient", {"median": 0.2, "factor": 2}, "reaches 3.2 at four standard deviations"),
    ("load.orientation", "sideways", "horizontal or vertical"),
    ("thread.lead_angle", "5 deg", "both given"),
    ("thread.pitch_diameter", GONE, "none of size, nominal_diameter, pitch_diameter"),
    ("thread", {"size": "Tr 10x7"}, "not in the catalogue"),
    ("thread", {"size": "M8.5"}, "is not the name of a thread"),
    ("thread", {"lead": "8 mm", "nominal_diameter": "8 mm"}, "needs thread.pitch, or thread.starts beside thread.lead"),
    ("thread", {"size": "M20x2"}, "M20 has the coarse pitch 2.5 mm"),
    ("thread", {"lead": "8 mm", "pitch": "2 mm", "starts": 3, "pitch_diameter": "7 mm"}, "is not thread.starts times"),
    ("screw", {"length": "300 mm", "material": "cheese"}, "is not one of"),
    ("screw.ends", "loose", "screw.ends = 'loose' is not one of fixed-free"),
    ("screw.ends", "fixed-free", "screw.ends needs screw.root_diameter"),
    ("screw", {"inertia": "1e-6 kg*m^2", "ends": "fixed-free"}, "screw.ends needs screw.unsupported_length"),
    ("screw", {"length": "1 m", "density": "8 g/cm^3", "ends": "fixed-free"}, "needs screw.material instead"),
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
    ("friction", {"curve": [["1 m/s", 0.2], ["0 m/s", 0.1]]}, "do not ascend"),
    ("friction.coefficient", 20.0, "friction.coefficient"),
    ("sources", {"load.colour": "a catalogue"}, "does not give"),
]


def changed(place: str, value: object) -> dict:
    """The data sheet with one entry replaced."""
    sheet = copy.deepcopy(BASE)
    *parts, last = place.split(".")
    at = sheet
    for part in parts:
        at = at[part]
    if value is GONE:
        del at[last]
    else:
        at[last] = value
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
    ("text", "words"), [("", "names and values"), ("a: [1\n", "YAML"), ("a: 1\na: 2\n", "given twice")]
)
def test_a_file_that_is_no_sheet_is_refused(run, text, words):
    assert words in refused_sheet(run, text)


@pytest.mark.parametrize(("option", "words"), [(("--samples", "100"), "power of two"), (("--seed", "-1"), "seed")])
def test_a_bad_option_is_refused(run, option, words):
    assert words in refused_sheet(run, yaml.safe_dump(BASE), *option)


def test_a_file_that_is_not_ours_is_not_replaced(run, tmp_path):
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "assessment.json").write_text("a letter", encoding="utf-8")
    assert "remove it first" in refused_sheet(run, yaml.safe_dump(BASE))


@pytest.mark.parametrize(("text", "expected"), [("99.9 %", 0.999), ("9.99e1 %", 0.999), ("35. %", 0.35)])
def test_a_percentage_is_the_nearest_double(text, expected):
    """99.9 % is the end of the range of efficiencies, which a division by 100 would miss."""
    assert quantity(text, "") == (expected, "")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 mm / s", "m/s", 0.01),
        ("1e-6 kg * m^2", "kg m^2", 1e-6),
        ("5 N/mm2", "Pa", 5e6),
        ("7850 kg/m3", "kg/m^3", 7850.0),
        ("1/2 inch", "m", 0.0127),
        ("2 tpi", "m", 0.0127),
        ("14TPI", "m", 0.0254 / 14),
        ("−5 N", "N", -5.0),
        ("1e3 N*s/m", "N s/m", 1e3),
        ("2e2 mm^2/mm", "m", 0.2),
        *((f"2{text}", "kg m^2", 2.0) for text in (" kg*m^2", " kg*m**2", " kg*m^(2)", "000 g*m^2", " kg/m^-2")),
    ],
)
def test_a_quantity_is_read(text, unit, value):
    assert quantity(text, unit)[0] == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("0,15", "", "a comma where 0.15 has a point"),
        ("5,5 kg", "kg", "a comma where 5.5 kg has a point"),
        ("1_0 N", "N", "not known"),
        ("٣ N", "N", "is not a force"),
        ("1 m2", "m", "is not a length"),
        ("1/0 inch", "m", "not known"),
        ("0 tpi", "m", "not known"),
        ("2 tpi", "N", "is not a force"),
        # Pint counts no radian, so that N m deg would pass for 0.017 N m/rad.
        ("30 N*m*deg", "N m/rad", "is not"),
        ("1 deg*deg/s", "rad/s", "is not"),
        ("1 deg^2", "rad", "is not"),
    ],
)
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
    with pytest.raises(NotQuantity, match="written with its pitch, such as Tr 8x8 P2"):
        thread_size("Tr 8x8")
    with pytest.raises(NotQuantity, match="diameters go from Tr 8 to Tr 300"):
        thread_size("Tr 400x8")
