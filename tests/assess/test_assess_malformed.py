"""Malformed data sheets: one sentence that names the entry, exit code 2, and nothing written."""

import copy
from pathlib import Path

import pytest
import yaml
from references.command_line import refused

from lsvib.assess.fields import quantity

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
