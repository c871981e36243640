"""`lsvib thresholds` and `lsvib stability`: JSON keys, words, and that neither contradicts the other."""

import json

import pytest
from references.command_line import DRIVE
from references.parts import DRIVES, GIVEN, threads_drive

import lsvib
from lsvib.models.drive import PARTS, Drive


def test_thresholds_json(run):
    code, out, error = run("thresholds", "--set", "translation_damping=1000", "--json")
    assert (code, error) == (0, "")
    drive = lsvib.Drive(translation_damping=1000)
    table = json.loads(out)
    assert table == json.loads(json.dumps({name: found.to_json() for name, found in drive.thresholds().items()}))
    printed = {name: entry["printed"] for name, entry in table.items() if entry["printed"]}
    assert set(printed) == {"kinematic_constraint", "onset", "stick", "detach"}
    for name, claim in printed.items():
        assert claim["passed"] is True
        assert claim["relative_error"] == abs(table[name]["value"] - claim["value"]) / claim["value"]
    assert {name: table[name]["unit"] for name in printed} == {
        "kinematic_constraint": "kg", "onset": "N", "stick": "N", "detach": "N",
    }  # fmt: skip


def test_thresholds_away_from_the_chapter(run):
    table = json.loads(run("thresholds", "--set", "translation_damping=2000", "--json")[1])
    assert not any(table[name]["printed"] for name in ("onset", "stick", "detach"))
    assert table["onset"]["value"] == pytest.approx(40.413221118359644, rel=1e-14)  # twice that of c_x = 1000
    table = json.loads(run("thresholds", "--set", "support_damping=1", "--json")[1])
    assert table["stick"]["value"] is None
    assert table["stick"]["reason"].endswith(".")


@pytest.mark.parametrize("key", ["mass", "friction_coefficient", "damper"])
@pytest.mark.parametrize("part", ["threads", "support", "nut"])
def test_thresholds_of_a_drive_with_a_part(run, part, key):
    drive = DRIVES[part](mass=4)
    key = PARTS[part][-1] if key == "damper" else key
    arguments = ("thresholds", *GIVEN[part], "--set", "mass=4", "--for", key)
    table = json.loads(run(*arguments, "--json")[1])
    assert table == json.loads(json.dumps({name: found.to_json() for name, found in drive.thresholds(key).items()}))
    assert list(table) == ["even_speed", "onset", "kinematic_constraint", "flutter"]
    text = run(*arguments)[1]
    for name, entry in table.items():
        assert (entry["value"] is not None) or entry["reason"].endswith(".")
        unit = "" if entry["unit"] == "1" else f" {entry['unit']}"  # a pure number stands alone
        shown = entry["reason"] if entry["value"] is None else f"{key} = {entry['value']:.12g}{unit}"
        assert any(line.split(maxsplit=1)[0] == name and shown in line for line in text.splitlines())
    assert text.count(" stability ") == sum(len(entry["stable_intervals"]) for entry in table.values())


def test_a_threshold_solved_for_a_parameter(run):
    arguments = ("thresholds", "--solve", "kinematic_constraint", "--for", "lead_angle", "--set", "mass=11")
    code, out, error = run(*arguments, "--json")
    assert (code, error) == (0, "")
    found = lsvib.Drive(mass=11).threshold("kinematic_constraint", "lead_angle")
    assert json.loads(out) == json.loads(json.dumps(found.to_json()))
    text = run(*arguments)[1]
    assert text.startswith("kinematic_constraint: 2 solutions for lead_angle. All of them: ")
    for solution in found.solutions:
        assert (
            f"lead_angle = {solution.value!r} rad, between {solution.enclosure[0]!r} and {solution.enclosure[1]!r}\n"
            in text
        )
        assert f"  d/d mass = {solution.derivatives['mass'].value:.12g} rad kg-1\n" in text
    onset = ("thresholds", *GIVEN["threads"], "--set", "mass=9", "--solve", "onset", "--for", "contact_damping")
    own = threads_drive(mass=9).stability().quantities["least_contact_damping"].value
    assert json.loads(run(*onset, "--json")[1])["solutions"][0]["value"] == own


def test_stability_does_not_contradict_itself(run):
    """Above the least damping of an infinitely stiff contact, below that of this one."""
    code, text, _ = run(
        "stability", "--set", "contact_stiffness=1e8", "--set", "mass=9", "--set", "contact_damping=5e4"
    )
    assert code == 0
    assert text.startswith("steady sliding is unstable (flutter)")
    assert "contact_flutter: holds" in text
    assert "least_contact_damping: 371157.682934 N s m-1" in text
    assert run("stability", "--set", "support_damping=0")[1].startswith("steady sliding is neutral (centre)")
    text = run("stability", *GIVEN["support"], "--set", "support_damping=0")[1]
    assert text.startswith("steady sliding is neutral\n")
    assert "without any damping: neutral" in text


def test_text_output(run):
    code, out, _ = run("thresholds", "--set", "translation_damping=1000")
    assert code == 0
    heading, *lines = out.splitlines()
    assert heading.split() == ["threshold", "solved", "for", "remarks"]
    assert [line.split()[0] for line in lines if not line.startswith(" ")] == list(lsvib.Drive().thresholds())
    assert out.count("pass") == 4
    assert "unstable" in run("stability", "--set", "mass=11")[1]
    assert len(run("config")[1].splitlines()) == 1 + len(Drive.model_fields)


def test_stability_json(run):
    table = json.loads(run("stability", *DRIVE[:2], "--json")[1])
    assert table["paradox_region"] is True
    assert table["stable"] is False
    assert table["conditions"]["kinematic_constraint"]["hold"] is True
    assert [set(pair) for pair in table["eigenvalues"]] == [{"real", "imaginary"}] * 2
    assert table["quantities"]["effective_inertia_plus"]["value"] < 0


def test_a_drive_is_described(run):
    """Its equations have the numbers that were given, and a part that is not there no line."""
    code, out, _ = run("describe", *GIVEN["support"], *GIVEN["threads"], "--set", "slide_friction=2", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["parts"] == ["a compliant axial support", "compliant threads"]
    assert "11.6 x_1″ = n − 1e+06 x_1" in found["equations"]
    assert "1 x″ = 50 − 2 sgn x′ − n" in found["equations"]
    assert list(found["coordinates"])[2:] == ["screw_shift", "shift_rate", "thread_mismatch", "mismatch_rate"]
    assert found["steady"]["screw_shift"] == pytest.approx(48 / 1e6, rel=1e-12)
    assert len(found["modes"]) == 24
    text = run("describe")[1]
    assert "nothing but the coupling" in text
    assert "Γ₊ = " in text
    assert "x_1" not in text
