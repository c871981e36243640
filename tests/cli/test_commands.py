"""Commands: JSON keys, words, files and pictures, and that none contradicts another or the methods of a drive."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from references.command_line import DRIVE, GRID, refused
from references.drives import DRIVES, GIVEN, threads_drive

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
        low, high = solution.enclosure
        assert f"lead_angle = {solution.value!r} rad, between {low!r} and {high!r}\n" in text
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


def test_attraction_json_and_dataset(run):
    code, out, error = run("attraction", *DRIVE, *GRID, "--quantities", "time", "seizures", "first_event",
                           "--out", "map.nc", "--figure", "map.png", "--json")  # fmt: skip
    assert code == 0
    result = json.loads(out)
    keys = {"cells", "fractions", "unresolved", "unresolved_because", "exact_basin_area", "cells_per_second"}
    assert set(result) == keys
    assert result["cells"] == 1200
    assert result["unresolved"] == 0
    assert sum(result["fractions"].values()) == pytest.approx(1.0, abs=1e-15)
    assert error.splitlines()[-1] == "100 % of 30 rows"
    with xr.open_dataset("map.nc") as written:
        assert written.label.dims == ("velocity_deviation", "angle_deviation")
        assert written.angle_deviation.values[0] == -0.1 + 0.5 * 0.2 / 40
        assert (written.label == 0).mean().item() == result["fractions"]["steady_sliding"]
        assert written.fraction.sel(attractor=2).item() == result["fractions"]["sprag_slip_cycle"]
        names = {"settling_time", "seizures", "first_event", "cycle_angle", "contact_line_angle"}
        assert names | {"friction_coefficient"} <= set(written)
        assert np.isfinite(written.settling_time).all()
    assert Path("map.png").stat().st_size > 10_000
    assert Path("map.pdf").is_file()


def test_attraction_text_says_shares_of_cells(run):
    lines = run("attraction", *DRIVE, *GRID, "--out", "map.nc")[1].splitlines()
    found = [line.rsplit(": ", 1)[1].split() for line in lines if "% of" in line]
    assert sum(float(words[0]) for words in found) == pytest.approx(100, rel=1e-5)
    for words in found:
        assert words[1:] == ["%", "of", "1200", "cells"]
        cells = float(words[0]) * 12
        assert cells == pytest.approx(round(cells), rel=1e-5)


def test_cycles_and_follow(run):
    """``lsvib cycles`` lists the pair near the fold; ``lsvib follow`` goes from one through the fold to the other."""
    drive = ["--set", "mass=11", "--set", "support_damping=2e-3", "--set", "axial_force=-18.37"]
    listed = json.loads(run("cycles", *drive, "--json")[1])["cycles"]
    assert [cycle["attracting"] for cycle in listed] == [True, False]
    keys = {"label", "attracting", "period", "multipliers", "amplitude", "state", "residual"}
    assert all(keys <= set(cycle) for cycle in listed)
    assert "repelling" in run("cycles", *drive)[1]
    over = ["--over", "axial_force=-18.38:-18.36", "--points", "30"]
    branch = json.loads(run("follow", *drive, *over, "--out", "branch.nc", "--json")[1])
    assert {point["attracting"] for point in branch["points"]} == {True, False}
    assert "fold" in [change["kind"] for change in branch["changes"]]
    assert "KEY=LOW:HIGH" in refused(run, "follow", *drive, "--over", "axial_force=-18")
    assert "1 <= cycle <= 2" in refused(run, "follow", *drive, *over, "--cycle", "3")


def test_resilience(run):
    """The command says what the method says, in numbers and in text, and writes a sweep to a file."""
    drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
    window = ("--window", "u=-0.3:0.3", "w=-150:150")
    one = (*DRIVE, *window)
    code, out, error = run("resilience", *one, "--json")
    expected = drive.resilience({"u": (-0.3, 0.3), "w": (-150, 150)})
    assert (code, error, json.loads(out)) == (0, "", json.loads(json.dumps(expected.to_json())))
    text = run("resilience", *one)[1]
    assert f"largest tolerated perturbation of the speed: {expected.speed:.12g} rad/s\n" in text
    over = ("--over", "axial_force=-40:-10:2", "--out", "reserve.nc")
    result = json.loads(run("resilience", *DRIVE[:4], *over, "--json")[1])
    assert result == {"points": 2, "not_covered": 0}
    with xr.open_dataset("reserve.nc") as found:
        assert found.fatal_speed.values.tolist() == [float("inf"), expected.speed]


def test_where_every_perturbation_is_tolerated_none_has_a_limit(run):
    """In words, not as infinite numbers and states that are none; JSON has null for them."""
    text = run("resilience", "--set", "mass=1")[1]
    assert text.count(": none\n") == 1  # the boundary of the region
    assert text.count(": unlimited\n") == 3  # of each of the perturbations
    assert "inf" not in text.replace("boundary of the region of attraction", "")
    assert "nan" not in text
    assert json.loads(run("resilience", "--set", "mass=1", "--json")[1])["energy"] is None
