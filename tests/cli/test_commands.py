"""Commands: each says what the method says, as JSON and in words; what words, files and pictures there are beside."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from references.command_line import DRIVE, GRID, refused
from references.drives import DRIVES, GIVEN, NEAR_FOLD, PARADOX, threads_drive

import lsvib
from lsvib import Drive
from lsvib.drives.description import description_of
from lsvib.drives.drive import PARTS

SLIDING = lsvib.Drive(translation_damping=1000)
FOLD = ("--set", "mass=11", "--set", "support_damping=2e-3", "--set", "axial_force=-18.37")
WINDOW = {"u": (-0.3, 0.3), "w": (-150, 150)}
UNKNOWN = (
    "threads mass, threads damper, support friction_coefficient, support damper, nut mass, nut friction_coefficient"
)
ANSWERS = {  # of a command: what the method of the drive gives
    "stability --set mass=11": lambda: lsvib.Drive(mass=11).stability(),
    "thresholds --solve kinematic_constraint --for lead_angle --set mass=11": (
        lambda: lsvib.Drive(mass=11).threshold("kinematic_constraint", "lead_angle")
    ),
    f"cycles {' '.join(FOLD)}": lambda: NEAR_FOLD.replace(axial_force=-18.37).cycles(),
    f"resilience {' '.join(DRIVE)} --window u=-0.3:0.3 w=-150:150": lambda: PARADOX.resilience(WINDOW),
    f"describe {' '.join(GIVEN['support'])}": lambda: description_of(DRIVES["support"]()),
}


@pytest.mark.parametrize("line", ANSWERS)
def test_a_command_says_what_the_method_says(run, line):
    answer, (code, out, error) = ANSWERS[line](), run(*line.split(), "--json")
    assert (code, error, json.loads(out)) == (0, "", json.loads(json.dumps(answer.to_json())))
    if hasattr(answer, "text"):
        assert run(*line.split())[1] == "\n".join([*answer.text(), ""])


def all_thresholds(drive, unknown=None) -> dict:
    return json.loads(json.dumps({name: found.to_json() for name, found in drive.thresholds(unknown).items()}))


def test_thresholds_in_a_table_and_as_numbers(run):
    arguments = ("thresholds", "--set", "translation_damping=1000")
    table = json.loads(run(*arguments, "--json")[1])
    assert table == all_thresholds(SLIDING)
    heading, *lines = run(*arguments)[1].splitlines()
    assert heading.split() == ["threshold", "solved", "for", "remarks"]
    assert [line.split()[0] for line in lines if not line.startswith(" ")] == list(table)
    table = json.loads(run("thresholds", "--set", "translation_damping=2000", "--json")[1])
    assert table["onset"]["value"] == pytest.approx(40.413221118359644, rel=1e-14)  # twice that of c_x = 1000


@pytest.mark.parametrize(("part", "key"), [case.split() for case in UNKNOWN.split(", ")])
def test_thresholds_of_a_drive_with_a_part(run, part, key):
    key = PARTS[part][-1] if key == "damper" else key
    arguments = ("thresholds", *GIVEN[part], "--set", "mass=4", "--for", key)
    table = json.loads(run(*arguments, "--json")[1])
    assert table == all_thresholds(DRIVES[part](mass=4), key)
    assert list(table) == ["even_speed", "onset", "kinematic_constraint", "flutter"]
    text = run(*arguments)[1]
    for name, entry in table.items():
        assert (entry["value"] is not None) or entry["reason"].endswith(".")
        unit = "" if entry["unit"] == "1" else f" {entry['unit']}"  # a pure number stands alone
        shown = entry["reason"] if entry["value"] is None else f"{key} = {entry['value']:.12g}{unit}"
        assert any(line.split(maxsplit=1)[0] == name and shown in line for line in text.splitlines())
    assert text.count(" stability ") == sum(len(entry["stable_intervals"]) for entry in table.values())


def test_a_threshold_in_words(run):
    text = run("thresholds", "--solve", "kinematic_constraint", "--for", "lead_angle", "--set", "mass=11")[1]
    assert text.startswith("kinematic_constraint: 2 solutions for lead_angle. All of them: ")
    for solution in lsvib.Drive(mass=11).threshold("kinematic_constraint", "lead_angle").solutions:
        low, high = solution.enclosure
        assert f"lead_angle = {solution.value!r} rad, between {low!r} and {high!r}\n" in text
        assert f"  d/d mass = {solution.derivatives['mass'].value:.12g} rad kg-1\n" in text
    onset = ("thresholds", *GIVEN["threads"], "--set", "mass=9", "--solve", "onset", "--for", "contact_damping")
    own = threads_drive(mass=9).stability().quantities["least_contact_damping"].value
    assert json.loads(run(*onset, "--json")[1])["solutions"][0]["value"] == own


@pytest.mark.parametrize(
    ("arguments", "first", "words"),
    [
        (("--set", "mass=11"), "steady sliding is unstable (saddle)", "kinematic constraint instability: occurs"),
        # Above the least damping of an infinitely stiff contact, below that of this one.
        (
            ("--set", "contact_stiffness=1e8", "--set", "mass=9", "--set", "contact_damping=5e4"),
            "steady sliding is unstable (flutter)", "least_contact_damping: 371157.682934 N s m-1",
        ),
        (("--set", "support_damping=0"), "steady sliding is neutral (centre)", ""),
        ((*GIVEN["support"], "--set", "support_damping=0"), "steady sliding is neutral\n", "critical_mass: "),
    ],
)  # fmt: skip
def test_stability_in_words(run, arguments, first, words):
    text = run("stability", *arguments)[1]
    assert text.startswith(first)
    assert words in text
    assert ("contact flutter instability: occurs" in text) == ("flutter" in first)


def test_stability_of_the_drive_of_a_scene(run):
    Path("scene.yaml").write_text("{drive: {mass: 11, axial_force: -10}, start: {u: 0, w: 1}, duration: 1}")
    said = run("stability", "--scene", "scene.yaml", "--set", "mass=9", "--json")[1]
    assert json.loads(said) == json.loads(json.dumps(Drive(mass=9, axial_force=-10).stability().to_json()))


def test_a_drive_is_described(run):
    """Its equations have the numbers that were given, and a part that is not there no line."""
    arguments = (*GIVEN["support"], *GIVEN["threads"], "--set", "slide_friction=2")
    found = json.loads(run("describe", *arguments, "--json")[1])
    assert found["parts"] == ["a compliant axial support", "compliant threads"]
    assert {"11.6 x_1″ = n − 1e+06 x_1", "1 x″ = 50 − 2 sgn x′ − n"} <= set(found["equations"])
    assert list(found["coordinates"])[2:] == ["screw_shift", "shift_rate", "thread_mismatch", "mismatch_rate"]
    assert found["steady"]["screw_shift"] == pytest.approx(48 / 1e6, rel=1e-12)
    assert len(found["modes"]) == 24
    rests = json.loads(run("describe", *arguments, "--set", "bearing_static_friction=0.03", "--json")[1])["equations"]
    assert "held: x′ = 0 while friction of the slide holds, up to 2 N" in rests
    assert "rest: the bearing holds up to 0.03 N m, and breaks loose together with the threads" in rests
    text = run("describe")[1]
    assert "the coupling only" in text
    assert "Γ₊ = " in text
    assert "x_1" not in text
    assert len(run("config")[1].splitlines()) == 1 + len(Drive.model_fields)


def test_a_map_its_file_and_picture_are_those_of_the_drive(run):
    arguments = ("attraction", *DRIVE, *GRID, "--quantities", "time", "seizures", "first_event", "--out", "map.nc")
    code, out, error = run(*arguments, "--figure", "map.png", "--json")
    result, rows = json.loads(out), []
    keys = ["cells", "fractions", "unresolved", "unresolved_because", "exact_basin_area", "cells_per_second"]
    assert (code, list(result), result["cells"], result["unresolved"]) == (0, keys, 1200, 0)
    assert sum(result["fractions"].values()) == pytest.approx(1.0, abs=1e-15)
    assert error.splitlines()[-1] == "100 % of 30 rows"
    window, more = {"u": (-0.1, 0.1, 40), "w": (-80.0, 80.0, 30)}, ["time", "seizures", "first_event"]
    found = PARADOX.attraction(window, quantities=more, progress=lambda *numbers: rows.append(numbers))
    with xr.open_dataset("map.nc") as written:
        assert written.label.dims == ("w", "u")
        assert written.u.values[0] == -0.1 + 0.5 * 0.2 / 40
        assert (written.label == 0).mean().item() == result["fractions"]["steady_sliding"]
        assert written.fraction.sel(attractor=2).item() == result["fractions"]["sprag_slip_cycle"]
        assert {"cycle_u", "contact_line_angle", "friction_coefficient"} <= set(written)
        assert np.isfinite(written.settling_time).all()
        assert found.drop_attrs().identical(written.load().drop_attrs())
    assert rows[-1] == (30, 30)
    assert found.basin_area.item() == result["exact_basin_area"]
    np.testing.assert_array_equal(PARADOX.attraction(window, workers=2).label, found.label)
    grid = lsvib.Grid(lsvib.Axis("u", -0.1, 0.1, 40), lsvib.Axis("w", -80.0, 80.0, 30))
    xr.testing.assert_identical(PARADOX.attraction(grid, quantities=more), found)
    assert Path("map.png").stat().st_size > 10_000
    assert Path("map.pdf").is_file()
    lines = run(*arguments)[1].splitlines()
    said = [line.rsplit(": ", 1)[1].split() for line in lines if "% of" in line]
    assert [words[1:] for words in said] == [["%", "of", "1200", "cells"]] * len(result["fractions"])
    shares = [float(words[0]) / 100 for words in said]
    assert shares == pytest.approx(list(result["fractions"].values()), rel=1e-5)


def test_a_sweep_and_its_file_are_those_of_the_drive(run):
    arguments = ["sweep", "--set", "translation_damping=1000", "--over", "axial_force=1:60:30"]
    result = json.loads(run(*arguments, "--over", "mass=1:2:2", "--out", "s.nc", "--json")[1])
    assert result["points"] == sum(result["attractors"].values()) == sum(result["behaviours"].values()) == 60
    assert "onset" in result["curves"]
    assert result["points_per_second"] > 0
    expected = SLIDING.sweep(axial_force=np.linspace(1, 60, 30), mass=np.linspace(1, 2, 2))
    assert lsvib.open("s.nc").drop_attrs().identical(expected.drop_attrs())
    assert [row["amplitude [rad]"] for row in result["rows"]] == expected.amplitude.values.ravel().tolist()
    assert {None} == {row["period [s]"] for row in result["rows"] if row["behaviour"] == "no_vibration"}
    text = run(*arguments, "--out", "s.csv")[1]
    assert text.splitlines()[1].split()[:3] == ["axial_force", "[N]", "behaviour"]
    assert "\n14 rows between these are omitted; " in text
    assert "points per second" in text
    heading, *rows = Path("s.csv").read_text().splitlines()
    assert heading.startswith("axial_force [N],attractor,amplitude [rad],period [s],multiplier,peak_normal_force [N],")
    assert (len(rows), rows[0][:24]) == (30, "1.0,steady_sliding,0.0,,")


def test_cycles_and_follow(run):
    """``lsvib cycles`` lists the pair near the fold; ``lsvib follow`` goes from one through the fold to the other."""
    text = run("cycles", *FOLD)[1]
    assert [text.count(f"sprag slip cycle, {kind}") for kind in ("attracting", "repelling")] == [1, 1]
    over = ["--over", "axial_force=-18.38:-18.36", "--points", "30"]
    _, out, progress = run("follow", *FOLD, *over, "--out", "branch.nc", "--json")
    branch = json.loads(out)
    assert progress.endswith("100 % of 60 points\n")
    assert {point["attracting"] for point in branch["points"]} == {True, False}
    assert "fold" in [change["kind"] for change in branch["changes"]]
    assert "KEY=LOW:HIGH" in refused(run, "follow", *FOLD, "--over", "axial_force=-18")
    assert "1 <= cycle <= 2" in refused(run, "follow", *FOLD, *over, "--cycle", "3")


def test_resilience_in_words(run):
    """Where every perturbation is tolerated none has a limit: in words, and null in JSON."""
    speed = PARADOX.resilience().speed
    assert f"largest tolerated perturbation of the speed: {speed:.12g} rad/s\n" in run("resilience", *DRIVE)[1]
    text = run("resilience", "--set", "mass=1")[1]
    assert text.count(": none\n") == 1  # the boundary of the region
    assert text.count(": unlimited\n") == 3  # of each of the perturbations
    assert "inf" not in text.replace("boundary of the region of attraction", "")
    assert "nan" not in text
    assert json.loads(run("resilience", "--set", "mass=1", "--json")[1])["energy"] is None
