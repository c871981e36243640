"""Malformed data sheets: one sentence that names the entry, exit code 2, and nothing written."""

import copy
import warnings

import pytest
import yaml
from cyclopts import CycloptsError

pytest.importorskip("pint")
pytest.importorskip("scipy")

from lsvib.assess.sheet import Sheet
from lsvib.assess.units import NotQuantity, quantity
from lsvib.command.assess import app
from lsvib.command.terminal import told

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

# Place, what stands there instead, and a word that the sentence must hold.
CASES = [
    ("thread", GONE, "thread is missing"),
    ("load", GONE, "load is missing"),
    ("load.mass", GONE, "load.mass is missing"),
    ("coupling", {}, "coupling.stiffness is missing"),
    ("operation", {}, "operation.speed is missing"),
    ("name", "", "name"),
    ("name", ["a"], "name"),
    ("colour", "red", "colour is not a known key"),
    ("thread.colour", "red", "thread.colour is not a known key"),
    ("load.weight", "5 kg", "load.weight is not a known key"),
    ("thread", "Tr 10x2", "does not hold names and values"),
    ("load", 5, "does not hold names and values"),
    ("load.mass", 5, "has no unit"),
    ("load.mass", "5", "has no unit"),
    ("load.mass", "5 m", "is not a mass"),
    ("load.mass", "5 N", "is not a mass"),
    ("load.mass", "five kg", "is not a mass"),
    ("load.mass", "5,5 kg", "is not a mass"),
    ("load.mass", "0 kg", "outside the allowed range"),
    ("load.mass", "-5 kg", "outside the allowed range"),
    ("load.mass", "1e12 kg", "outside the allowed range"),
    ("load.mass", "nan kg", "is not a mass"),
    ("load.mass", float("nan"), "load.mass"),
    ("load.mass", float("inf"), "load.mass"),
    ("load.mass", "5 bananas", "is not known"),
    ("load.mass", "5 kg; import os", "load.mass"),
    ("load.mass", True, "load.mass"),
    ("load.mass", None, "load.mass"),
    ("load.mass", ["5 kg"], "is not a range of two"),
    ("load.mass", ["5 kg", "6 kg", "7 kg"], "is not a range of two"),
    ("load.mass", ["6 kg", "5 kg"], "do not ascend"),
    ("load.mass", ["5 kg", "6 m"], "load.mass"),
    ("load.mass", {"low": "5 kg"}, "a distribution has"),
    ("load.mass", {}, "a distribution has"),
    ("load.mass", {"mean": "5 kg", "std": "2 kg"}, "standard deviations"),
    ("load.mass", {"mean": "5 kg", "std": "-1 kg"}, "not above 0"),
    ("load.orientation", {"mean": "80 deg", "std": "5 deg"}, "reaches 100 deg at four standard deviations"),
    ("friction.coefficient", {"median": 0.2, "factor": 2}, "reaches 3.2 at four standard deviations"),
    ("load.mass", {"median": "5 kg", "factor": 0.9}, "not above 1"),
    ("load.mass", {"median": "5 kg", "factor": "2 kg"}, "factor"),
    ("load.mass", {"low": "5 kg", "mode": "4 kg", "high": "6 kg"}, "do not ascend"),
    ("load.orientation", "sideways", "load.orientation"),
    ("load.orientation", "120 deg", "outside the allowed range"),
    ("load.orientation", "sideways", "horizontal or vertical"),
    ("load.orientation", ["-120 deg", "0 deg"], "outside the allowed range"),
    ("load.orientation", "4 kg", "is not an angle"),
    ("load.orientation", 4, "has no unit"),
    ("load.orientation", True, "load.orientation"),
    ("load.force", "5 kg", "is not a force"),
    ("thread.lead", "2 deg", "is not a length"),
    ("thread.lead_angle", "5 deg", "both given"),
    ("thread.lead", GONE, "has no lead"),
    ("thread.pitch_diameter", GONE, "both missing"),
    ("thread.nominal_diameter", "10 mm", "both given"),
    ("thread.half_angle", "80 deg", "outside the allowed range"),
    ("thread.half_angle", "15", "has no unit"),
    ("thread.size", "Tr 10x2", "both given"),
    ("thread", {"size": "Tr 10x7"}, "not in the catalogue"),
    ("thread", {"size": "Tr 11.5x2"}, "is not the name of a thread"),
    ("thread", {"size": "M8"}, "is not the name of a thread"),
    ("thread", {"size": 10}, "is not the name of a thread"),
    ("thread", {"size": "Acme 1/2-9"}, "not in the catalogue"),
    ("thread", {"size": "Tr 8x7 P2"}, "1 to 8 times"),
    ("thread", {"size": "Tr 8x2", "starts": 4}, "the name of a size tells them"),
    ("thread", {"lead": "8 mm", "pitch": "2 mm", "starts": 3, "pitch_diameter": "7 mm"}, "is not thread.starts times"),
    ("thread", {"nominal_diameter": ["2 mm", "9 mm"], "pitch": "5 mm"}, "not above half the pitch"),
    ("thread.starts", 1.5, "thread.starts"),
    ("thread.starts", 0, "outside the allowed range"),
    ("screw", {}, "both missing"),
    ("screw", {"length": "300 mm", "inertia": "1e-6 kg*m^2"}, "both given"),
    ("screw", {"length": "300 mm", "material": "cheese"}, "is not one of"),
    ("screw", {"length": "300 mm", "material": "steel", "density": "7850 kg/m^3"}, "both given"),
    ("coupling.stiffness", "20 N/m", "is not a torsional stiffness"),
    ("coupling.gear_ratio", "0", "outside the allowed range"),
    ("operation.speed", "10 mm", "is not a rotational speed or a speed"),
    ("operation.speed", "0 rpm", "outside the allowed range"),
    ("operation.speed", ["10 mm/s", "60 rpm"], "mixes two kinds"),
    ("operation.direction", "up", "is not one of"),
    ("friction", {}, "none of coefficient"),
    ("friction", {"coefficient": 0.1, "efficiency": "40 %"}, "give one of them"),
    ("friction.coefficient", "0.15 mm", "friction.coefficient"),
    ("friction.coefficient", -0.1, "outside the allowed range"),
    ("friction", {"efficiency": "120 %"}, "outside the allowed range"),
    ("friction", {"curve": [["0 m/s", 0.2]]}, "at least two pairs"),
    ("friction", {"curve": [["1 m/s", 0.2], ["0 m/s", 0.1]]}, "do not ascend"),
    ("friction", {"curve": [["0 m/s", 0.2], ["1 m/s", 0.1]], "slope": "-1 s/m"}, "both given"),
    ("friction.curve_factor", 1.1, "needs friction.curve"),
    ("friction", {"curve": [["0 m/s", 0.2], ["1 m/s", 0.1]], "curve_factor": 0}, "outside the allowed range"),
    ("friction.slope", "-1", "has no unit"),
    ("friction.slope", "-1 s", "is not a slope"),
    ("damping", {"rotational": "-1e-4 N*m*s/rad"}, "outside the allowed range"),
    ("damping", {"translational": "5 N/m"}, "is not a damping"),
    ("contact", {}, "contact.stiffness is missing"),
    ("contact", "soft", "does not hold names and values"),
    ("support", {"stiffness": "0 N/m"}, "outside the allowed range"),
    ("sources", {"load.colour": "a catalogue"}, "does not give"),
    ("assumptions", {"load": 5}, "assumptions.load"),
]


def changed(place: str, value: object) -> dict:
    """The data sheet with one entry replaced."""
    sheet = copy.deepcopy(BASE)
    if place == "thread.lead" and value == "2 deg":
        sheet["thread"] = {"lead": value, "pitch_diameter": "9 mm"}
        return sheet
    *parts, last = place.split(".")
    at = sheet
    for part in parts:
        at = at[part]
    if value is GONE:
        del at[last]
    else:
        at[last] = value
    return sheet


def refused(arguments: list, monkeypatch, capsys) -> str:
    """What the command says on the error stream; it must end with exit code 2."""
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)  # which the command replaces
    tokens = ["assess", *map(str, arguments)]
    with pytest.raises(SystemExit) as end:
        told(lambda: app(tokens, exit_on_error=False, print_error=False), CycloptsError)
    assert end.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(("place", "value", "word"), CASES)
def test_a_malformed_entry_is_refused_in_one_sentence(place, value, word, tmp_path, monkeypatch, capsys):
    """One sentence, and nothing written."""
    file = tmp_path / "drive.yaml"
    file.write_text(yaml.safe_dump(changed(place, value)), encoding="utf-8")
    error = refused([file, "--out", tmp_path / "report"], monkeypatch, capsys)
    assert error.count("\n") == 1
    assert error.startswith("lsvib: ")
    assert error.rstrip().endswith(".")
    assert "Traceback" not in error
    assert word in error
    assert list(tmp_path.iterdir()) == [file]


def test_friction_that_jams_every_thread_is_refused(tmp_path, monkeypatch, capsys):
    """μ ≥ cot λ: no torque turns the screw."""
    sheet = changed("friction.coefficient", 2.0)
    sheet["thread"] = {"lead_angle": "40 deg", "pitch_diameter": "9 mm"}
    file = tmp_path / "drive.yaml"
    file.write_text(yaml.safe_dump(sheet), encoding="utf-8")
    assert "jam" in refused([file, "--out", tmp_path / "report"], monkeypatch, capsys)
    assert list(tmp_path.iterdir()) == [file]


def test_a_percentage_is_the_nearest_double():
    """99.9 % is the end of the range of efficiencies, which a division by 100 would miss."""
    for text, expected in (("99.9 %", 0.999), ("9.99e1 %", 0.999), ("+.1e+2 %", 0.1), ("35. %", 0.35)):
        assert quantity(text, "") == (expected, "")
    friction = Sheet.of(changed("friction", {"efficiency": ["10 %", "99.9 %"]})).friction
    assert (friction.efficiency.low, friction.efficiency.high) == (0.1, 0.999)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("30 N*m*deg", "N m/rad"),
        ("30 N*m*rad", "N m/rad"),
        ("30 N*m/deg^2", "N m/rad"),
        ("1 N*m*s*deg", "N m s/rad"),
        ("1 deg*deg/s", "rad/s"),
        ("1 sr", "rad"),
        ("1 deg^2", "rad"),
    ],
)
def test_a_power_of_an_angle_is_not_the_angle(text, unit):
    """Pint counts no radian, so that N m deg would pass for 0.017 N m/rad."""
    with pytest.raises(NotQuantity):
        quantity(text, unit)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "names and values"),
        ("- 1\n", "names and values"),
        ("a: [1\n", "YAML"),
        ("a: 1\na: 2\n", "given twice"),
        ("5", "names"),
    ],
)
def test_a_file_that_is_no_sheet_is_refused(text, word, tmp_path, monkeypatch, capsys):
    """Files that hold something else."""
    file = tmp_path / "drive.yaml"
    file.write_text(text, encoding="utf-8")
    error = refused([file, "--out", tmp_path / "report"], monkeypatch, capsys)
    assert error.count("\n") == 1
    assert word in error
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--samples", "100"], "power of two"),
        (["--samples", "32"], "samples"),
        (["--samples", "many"], "samples"),
        (["--seed", "-1"], "seed"),
    ],
)
def test_a_bad_option_is_refused(options, word, tmp_path, monkeypatch, capsys):
    """Options out of range."""
    file = tmp_path / "drive.yaml"
    file.write_text(yaml.safe_dump(BASE), encoding="utf-8")
    assert word in refused([file, "--out", tmp_path / "report", *options], monkeypatch, capsys)
    assert list(tmp_path.iterdir()) == [file]


def test_a_file_that_is_not_ours_is_not_replaced(tmp_path, monkeypatch, capsys):
    """A page of somebody else's stays."""
    file, out = tmp_path / "drive.yaml", tmp_path / "report"
    file.write_text(yaml.safe_dump(BASE), encoding="utf-8")
    out.mkdir()
    (out / "assessment.json").write_text("a letter", encoding="utf-8")
    assert "remove it first" in refused([file, "--out", out], monkeypatch, capsys)
    assert (out / "assessment.json").read_text(encoding="utf-8") == "a letter"
