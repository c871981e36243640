"""`lsvib thresholds` and `lsvib stability`: JSON keys, words, and that neither contradicts the other."""

import json

import pytest
from references.command_line import DRIVE

import lsvib
from lsvib.models.drive import RigidDrive
from lsvib.stability.threshold_table import threshold_table


def test_thresholds_json(run):
    code, out, error = run("thresholds", "--json")
    assert (code, error) == (0, "")
    table = json.loads(out)
    described = table.pop("global_stability_force")  # without a number in the chapter
    assert described["unit"] == "N"
    assert all(described[key] is None for key in ("expected", "tolerance", "relative_error", "passed"))
    assert set(table) == {"critical_mass", "critical_friction", "onset_force", "stick_force", "detach_force"}
    for entry in table.values():
        assert {"value", "unit", "expected", "tolerance", "relative_error", "passed"} <= set(entry)
        assert entry["passed"] is True
        assert entry["relative_error"] == abs(entry["value"] - entry["expected"]) / entry["expected"]
    assert {name: entry["unit"] for name, entry in table.items()} == {
        "critical_mass": "kg", "critical_friction": "1", "onset_force": "N", "stick_force": "N", "detach_force": "N",
    }  # fmt: skip


def test_thresholds_away_from_the_chapter(run):
    table = json.loads(run("thresholds", "--set", "translation_damping=2000", "--json")[1])
    for name in ("onset_force", "stick_force", "detach_force"):
        assert all(table[name][key] is None for key in ("expected", "tolerance", "relative_error", "passed"))
    assert table["onset_force"]["value"] == pytest.approx(40.413221118359644, rel=1e-14)  # twice that of c_x = 1000
    table = json.loads(run("thresholds", "--set", "support_damping=1", "--json")[1])
    assert table["stick_force"]["value"] is None
    assert table["stick_force"]["reason"].endswith(".")


@pytest.mark.parametrize(
    ("model", "damping", "unit"),
    [
        ("threads", "least_contact_damping", "N s m-1"),
        ("support", "least_axial_support_damping", "N s m-1"),
        ("nut", "least_nut_damping", "N m s rad-1"),
    ],
)
def test_thresholds_of_another_model(run, model, damping, unit):
    arguments = ("thresholds", "--model", model, "--set", "mass=4")
    table = json.loads(run(*arguments, "--json")[1])
    assert table == threshold_table({"mass": "4"}, model=model)
    assert {name: entry["unit"] for name, entry in table.items()} == {
        "critical_mass": "kg", "critical_friction": "1", damping: unit,
    }  # fmt: skip
    text = run(*arguments)[1]
    for name, entry in table.items():
        assert {"value", "unit", "stability", "stable_intervals"} <= set(entry)
        assert (entry["value"] is not None) or entry["reason"].endswith(".")
        unit = "" if entry["unit"] == "1" else f" {entry['unit']}"  # a pure number stands alone
        shown = "none" if entry["value"] is None else f"{entry['value']:.12g}{unit}"
        assert any(line.split(maxsplit=1) == [name, shown] for line in text.splitlines())
        assert text.count("stability from") == sum(len(entry["stable_intervals"]) for entry in table.values())


def test_a_threshold_solved_for_a_parameter(run):
    arguments = ("thresholds", "--solve", "kinematic_constraint", "--for", "lead_angle", "--set", "mass=11")
    code, out, error = run(*arguments, "--json")
    assert (code, error) == (0, "")
    found = lsvib.RigidDrive(mass=11).threshold("kinematic_constraint", "lead_angle")
    assert json.loads(out) == json.loads(json.dumps(found.to_json()))
    text = run(*arguments)[1]
    assert text.startswith("kinematic: 2 solutions for lead_angle. All of them: ")
    for solution in found.solutions:
        assert f"lead_angle = {solution.value!r} rad, in error by at most " in text
        assert f"  d/d mass = {solution.derivatives['mass'].value:.12g} rad/(kg)\n" in text
    onset = ("thresholds", "--model", "threads", "--set", "mass=9", "--solve", "onset", "--for", "contact_damping")
    own = threshold_table({"mass": 9.0}, model="threads")["least_contact_damping"]["value"]
    assert json.loads(run(*onset, "--json")[1])["solutions"][0]["value"] == own


def test_stability_does_not_contradict_itself(run):
    """Above the least damping of an infinitely stiff contact, below that of this one."""
    code, text, _ = run("stability", "--model", "threads", "--set", "mass=9", "--set", "contact_damping=5e4")
    assert code == 0
    assert text.startswith("steady sliding is unstable (flutter)")
    assert "contact_flutter: holds" in text
    assert "least_contact_damping: 371157.682934 N s m-1" in text
    assert run("stability", "--set", "support_damping=0")[1].startswith("steady sliding is neutral (centre)")
    text = run("stability", "--model", "support", "--set", "support_damping=0")[1]
    assert text.startswith("steady sliding is neutral\n")
    assert "without any damping: neutral" in text


def test_text_output(run):
    code, out, _ = run("thresholds")
    assert code == 0
    assert len(out.splitlines()) == 6
    assert out.count("pass") == 5
    assert "unstable" in run("stability", "--set", "mass=11")[1]
    assert len(run("config")[1].splitlines()) == len(RigidDrive.model_fields)


def test_stability_json(run):
    table = json.loads(run("stability", *DRIVE[:2], "--json")[1])
    assert table["paradox_region"] is True
    assert table["stable"] is False
    assert table["conditions"]["paradox"]["hold"] is True
    assert [set(pair) for pair in table["eigenvalues"]] == [{"real", "imaginary"}] * 2
    assert table["effective_inertia"]["plus"] < 0
