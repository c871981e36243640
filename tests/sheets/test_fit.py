"""The fit of friction to measured torque: a measured screw, and laws that are known."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from references.measured import LAW, SPEEDS, square, torque, write_tables
from references.sizes import sizes

import lsvib
from lsvib.answers.io import read_dataset
from lsvib.errors import InputError
from lsvib.sheets.fit_output import as_json, blocks, flank_law, sentences
from lsvib.sheets.fit_sheet import fit_sheet
from lsvib.sheets.formulas import square_coefficient
from lsvib.sheets.sheet import Friction
from lsvib.sheets.torque.law import fitted
from lsvib.sheets.torque.measured import BREAKAWAY, Measured, halves, steady_torque
from lsvib.sheets.torque.tables import Recording, steady_point

ROOT = Path(__file__).parents[2]
SCREW = ROOT / "examples" / "measured_screw" / "measured_screw.yaml"
RPM = math.pi / 30
KNOWN = LAW | {key: LAW[key] * square() for key in ("friction_coefficient", "stribeck_rise", "friction_slope")}


@pytest.fixture(scope="module")
def screw():
    return fit_sheet(SCREW)


def test_the_measured_screw_is_fitted_at_both_ends(screw):
    """Of 30 means of 3 mN m, as the files at 2 rpm jerk; the published law, its bearing given, leaves as little."""
    assert len(screw.points) == 30
    assert set(screw.fit.ends) == {"threads", "bearing"}
    for end in screw.fit.ends.values():
        assert end.rms <= 0.045e-3
        assert np.abs(end.residual).max() <= 0.12e-3
        assert end.values["stribeck_rise"] > 4 * end.errors["stribeck_rise"]
    assert screw.fit.not_separable == (("friction_coefficient", "coulomb"), ("friction_slope", "viscous"), BREAKAWAY)
    assert sum("not separable" in sentence for sentence in sentences(screw)) == 2
    assert not any("poorly" in sentence for sentence in sentences(screw))


def test_the_half_sums_of_the_measured_screw_are_those_computed_apart(screw):
    """Means of the rows in four digits, in the README of the data."""
    found = {round(speed / RPM): (both, load) for speed, both, load in halves(screw.fit.measured) * [1, 1e3, 1e3]}
    known = {10: 3.0892, 20: 3.0272, 40: 2.9133, 50: 2.9061, 100: 3.0328, 199: 3.5677}
    assert {rpm: found[rpm][0] for rpm in known} == pytest.approx(known, abs=6e-5)
    assert min(found, key=lambda rpm: found[rpm][0]) == 50
    assert found[10][1] == pytest.approx(0.5 * (2.7611 - 3.4172), abs=6e-5)


def test_the_jerks_of_the_measured_screw(screw, tmp_path):
    """Period and stiffness of both records; their numbers, and a data sheet that jerks where the screw did."""
    result = as_json(screw)
    json.dumps(result, allow_nan=False)
    jerks = {record["file"]: record for record in result["records"] if record["kind"] == "jerks"}
    assert set(jerks) == {"drive1/2.csv", "drive1/n2.csv"}
    for record_ in jerks.values():
        assert 1 / record_["period"] == pytest.approx(2.489, abs=0.5 / 64)  # half of what the spectrum of 64 s resolves
        assert record_["stiffness"] == pytest.approx(0.0215, abs=0.0015)
        assert set(record_["standard_errors"]) >= {"period", "stiffness", "breakaway", "after"}
    assert {record["kind"] for record in result["records"] if record["file"] not in jerks} == {"even"}
    told = result["stick_slip"]
    assert told["stiffness"] == pytest.approx(0.0215, abs=0.0015)
    assert told["bounds"][0] < told["damping"] < told["bounds"][1]
    assert 2 * RPM < told["even_speed"] < 10 * RPM
    off = {end: [abs(model / seen - 1) for seen, model in one.periods] for end, one in screw.jerks.items()}
    assert max(off["bearing"]) < 0.01 < 0.07 < max(off["threads"])
    assert all(one.by_periods < 0.5 * one.damping[0] for one in screw.jerks.values())
    assert any("is not all in the threads" in text for text in sentences(screw))
    assert any("jerks up to at least 30.6 rpm" in text for text in sentences(screw))
    parts = yaml.safe_load(blocks(result))
    data = {
        "name": "as measured", "thread": {"lead": "2 mm", "pitch_diameter": "11 mm", "half_angle": "15 deg"},
        "screw": {"inertia": "2.186e-6 kg*m^2"}, "operation": {"speed": ["2 rpm", "20 rpm"]},
        "load": {"mass": "0.276 kg", "force": "-0.9414 N", "orientation": "horizontal"},
        **{key: parts[key] for key in ("friction", "coupling", "damping")},
    }  # fmt: skip
    assert [float(end.split()[0]) for end in data["damping"]["rotational"]] == pytest.approx(told["bounds"], rel=1e-5)
    assert all(set(entry) == {"mean", "std"} for entry in [data["coupling"]["stiffness"], data["friction"]["static"]])
    (tmp_path / "sheet.yaml").write_text(yaml.safe_dump(data))
    verdict = lsvib.assess(tmp_path / "sheet.yaml", None, samples=64)
    assert verdict["verdict"] == "jerks"
    assert verdict["from_rest"]["even_speed"] == pytest.approx(told["even_speed"], rel=0.02)


@pytest.mark.slow
def test_the_published_bearing_gives_a_friction_near_the_published(screw, tmp_path):
    """Published: 0.27, with a rise of 0.1; friction of the carriage is apart there, and one of the bearing here."""
    sheet = yaml.safe_load(SCREW.read_text())
    sheet["measurements"]["files"] = "examples/measured_screw/drive1/*.csv"
    sheet["bearing"] = {"coulomb": "1 mN*m", "viscous": "3e-5 N*m*s/rad"}
    path = tmp_path / "sheet.yaml"
    path.write_text(yaml.safe_dump(sheet))
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    found = fit_sheet(path)
    assert found.fit.not_separable == (BREAKAWAY,)
    assert found.fit.main.values["friction_coefficient"] == pytest.approx(0.27, abs=0.05)
    assert "; static friction above sliding in the threads." in blocks(as_json(found))


def test_the_blocks_are_taken_by_data_sheet_scene_and_shell(screw, run):
    """And a data sheet's friction of the flanks is that of the drive's square thread."""
    result = as_json(screw)
    text = yaml.safe_load(blocks(result))
    friction = Friction.model_validate(text["friction"])
    assert friction.problem() is None
    angle = screw.fit.measured.lead_angle
    drive = lsvib.Drive(**text["drive"])
    keys = {"coefficient": "friction_coefficient", "stribeck_rise": "stribeck_rise", "slope": "friction_slope"}
    for entry, key in keys.items():
        flank = getattr(friction, entry).nominal
        assert square_coefficient(flank, angle, math.radians(15)) == pytest.approx(getattr(drive, key), rel=1e-5)
    apart = yaml.safe_load(blocks(result | {"bearing": {"coulomb": 1e-3, "viscous": 3e-5}}))
    assert apart["bearing"] == {"torque": "0.001 N*m", "viscous": "3e-05 N*m*s/rad"}
    assert lsvib.Drive(**apart["drive"]).bearing_friction == 1e-3
    held = yaml.safe_load(blocks(result | {"bearing": {"coulomb": 1e-3, "viscous": 0.0, "static": 2e-3}}))
    assert held["bearing"] == {"torque": "0.001 N*m", "static": "0.002 N*m"}
    assert lsvib.Drive(**held["drive"]).bearing_static_friction == 2e-3
    assert "bearing" not in text
    options = blocks(result).splitlines()[-1].removeprefix("# ").split()
    code, out, _ = run("config", *options, "--json")
    assert code == 0
    assert json.loads(out)["stribeck_speed"]["value"] == pytest.approx(drive.stribeck_speed)


def test_the_command_writes_all_and_says_what_it_found(screw, run):
    code, out, error = run("fit", str(SCREW), "--out", "fitted")
    assert (code, error) == (0, "")
    assert "not separable" in out
    assert "Left out of drive1/n2.csv: the screw jerks 2.49 times a second" in out
    files = {path.name for path in Path("fitted").iterdir()}
    assert files == {"fit.nc", "fit.json", "fit.png", "fit.pdf", "friction.yaml"}
    found = json.loads(Path("fitted/fit.json").read_text())
    assert found == json.loads(json.dumps(as_json(screw)))
    assert {"friction", "bearing", "rms", "largest_residual", "points", "not_separable"} <= set(found)
    data = read_dataset("fitted/fit.nc")
    assert float(np.sqrt(np.mean(data.residual[0] ** 2))) == pytest.approx(found["rms"])
    assert float(data.fitted_stribeck_rise[0]) == found["friction"]["stribeck_rise"]
    assert np.isnan(data.correlation[0]).sum() == 7 * 7 - 5 * 5


def test_torque_is_that_of_the_wedge():
    speed = np.array([*-SPEEDS, *SPEEDS])
    for load in (300.0, -300.0):
        measured = Measured(speed, speed, np.full(speed.size, load), 9e-3, math.atan(4e-3 / (math.pi * 18e-3)))
        assert steady_torque(KNOWN, measured, speed, load) == pytest.approx(torque(speed, load), rel=1e-12)


def test_two_loads_tell_threads_from_bearing(tmp_path):
    """Without noise the law comes back; of one load it does not, unless the zero of the torque is known."""
    found = fit_sheet(write_tables(tmp_path / "two", noise=0.0))
    assert found.fit.not_separable == ()
    # The samples scatter by 1 % in speed, and their mean torque is not quite that at their mean speed.
    assert {key: found.fit.main.values[key] for key in KNOWN} == pytest.approx(KNOWN, rel=1e-3)
    assert fit_sheet(write_tables(tmp_path / "one", [600.0])).fit.not_separable
    known_zero = fit_sheet(write_tables(tmp_path / "zero", [600.0], noise=1e-4, offset="4 mN*m"))
    assert ("friction_coefficient", "coulomb") not in known_zero.fit.not_separable
    one_way = fit_sheet(write_tables(tmp_path / "way", [600.0], SPEEDS, noise=1e-3, bearing={"coulomb": "24 mN*m"}))
    assert any("Only one direction" in sentence for sentence in sentences(one_way))
    assert "offset" not in one_way.fit.unknown


def test_an_outlier_and_a_flat_law_are_seen(tmp_path):
    path = write_tables(tmp_path / "a", noise=0.01)
    spoilt = tmp_path / "a" / "load300" / "05.csv"
    rows = [line.split(",") for line in spoilt.read_text().splitlines()[1:]]
    spoilt.write_text("".join(f"{speed},{float(value) - 400}\n" for speed, value in rows))
    found = fit_sheet(path).fit
    assert int(np.argmin(found.main.residual)) == SPEEDS.size - 1 - 5  # points ascend in load and speed
    assert found.main.values["friction_coefficient"] == pytest.approx(0.15 * square(), abs=0.01)
    clean = fitted(replace(found.measured, torque=torque(found.measured.speed, 600.0, {**LAW, "stribeck_rise": 0.0}),
                           load=np.full(found.measured.speed.size, 600.0)), {"offset": 0.004})  # fmt: skip
    assert not clean.rise_seen
    assert set(clean.main.drive()) == {"friction_coefficient", "friction_slope"}


def test_transients_spikes_and_breakaway_are_left_out_of_the_mean(tmp_path):
    time = np.arange(200.0)
    speed = np.where(time < 20, 0.0, np.minimum((time - 20) * 0.5, 5.0)) + 0.01 * np.sin(time)
    held = np.where(time < 20, 0.1 * time, 1.5) + 0.01 * np.cos(time)
    held[100] = 40.0
    point = steady_point(Recording("a", speed, held))
    assert point.spikes == 1
    assert 25 <= point.transient <= 35
    assert point.samples == 199 - point.transient
    assert point.torque == pytest.approx(1.5, abs=2e-3)
    assert point.breakaway == pytest.approx(1.9, abs=0.02)


MOTIONS = {  # speed over the wanted one, of 400 samples
    "ramp": np.linspace(0.01, 1.0, 400),
    "slow down": np.linspace(1.0, 0.8, 400),
    "last quarter at rest": np.repeat([1.0, 0.0], [300, 100]),
    "end at rest": np.repeat([1.0, 0.0], [385, 15]),
    "mostly at rest": np.repeat([0.0, 1.0], [228, 172]),
    "forth and back": np.repeat([1.0, -1.0], [250, 150]),
}


@pytest.mark.parametrize("speed", MOTIONS.values(), ids=MOTIONS)
def test_a_file_that_does_not_run_steadily_is_refused(speed):
    noisy = -200.0 * speed * (1 + 0.002 * np.random.default_rng(0).standard_normal(400))
    with pytest.raises(InputError, match=r"05\.csv does not run at one speed"):
        steady_point(Recording("05.csv", noisy, np.ones(noisy.size)))


def test_a_screw_that_jerks_steadily_is_kept():
    """Twelve jerks of 30 % of the time in thousands of samples; and 1000 files of 40 samples of much noise."""
    time = np.arange(5000.0)
    jerks = np.where((time * 12 / time.size) % 1 < 0.3, 1.0, 0.02)
    assert steady_point(Recording("2", jerks, np.ones(time.size))).samples == time.size
    random = np.random.default_rng(0)
    for _ in range(1000):
        steady_point(Recording("few", 1 + 0.27 * random.standard_normal(40), np.ones(40)))


def test_what_was_left_out_is_said(tmp_path):
    path = write_tables(tmp_path, noise=1e-3)
    folder = tmp_path / "load300"
    (folder / "03.csv").write_text("rpm,mN m\n" + "0,20\n" * 30)
    (folder / "04.csv").write_text((folder / "04.csv").read_text().replace("-", "−") + "broken,5\n1,2,3\n")
    found = fit_sheet(path)
    assert len(found.points) == 4 * SPEEDS.size - 1
    assert found.left_out == [
        "load300/03.csv: rows of a screw at rest (30)",
        "load300/04.csv: rows without numbers, or with more or fewer columns (2)",
    ]


def test_a_breakaway_gives_the_static_coefficient(tmp_path):
    """Files that begin at rest, under a torque that rises to that of a static coefficient of 0.25."""
    path = write_tables(tmp_path, noise=1e-3)
    for load in (300.0, 900.0):
        for k, sense in ((20, 1), (6, -1)):
            file = tmp_path / f"load{load:g}" / f"{k:02}.csv"
            law = {**LAW, "friction_coefficient": 0.25, "stribeck_rise": 0.0, "friction_slope": 0.0, "viscous": 0.0}
            peak = float(torque(np.array(sense * 1.0), load, law)) * 1e3
            rest = "".join(f"0,{peak * share:.9g}\n" for share in (0.2, 0.6, 1.0))
            header, rows = file.read_text().split("\n", 1)
            file.write_text(f"{header}\n{rest}{rows}")
    found = fit_sheet(path)
    static, error = found.fit.main.static["static_friction_coefficient"]
    assert static == pytest.approx(0.25 * square(), rel=0.02)
    assert flank_law(found, found.fit.main)["static"]["mean"] == pytest.approx(0.25, rel=0.02)
    assert 0 < error < 0.02
    assert any("upper bound" in text for text in sentences(found))
    # A torque that no friction explains, such as a glitch of the sensor, is left out.
    first = tmp_path / "load300" / "20.csv"
    first.write_text(first.read_text().replace("0,", "0,1e9\n0,", 1))
    again = fit_sheet(path)
    assert again.fit.main.static["static_friction_coefficient"][0] == pytest.approx(static, rel=0.02)
    assert any("or so large that the screw jams (1)" in text for text in sentences(again))


def test_a_table_of_many_speeds_is_a_point_a_row(tmp_path):
    path = write_tables(tmp_path, noise=0.0, samples=3)
    sheet = yaml.safe_load(path.read_text())
    for block in sheet["measurements"]:
        folder = tmp_path / block["files"].split("/")[0]
        rows = [line for file in sorted(folder.glob("*.csv")) for line in file.read_text().splitlines()[1:]]
        (tmp_path / f"{folder.name}.txt").write_text(
            "speed;torque\n" + "\n".join(rows).replace(",", ";").replace(".", ",")
        )
        block |= {"files": f"{folder.name}.txt", "separator": ";", "decimal": ","}
    path.write_text(yaml.safe_dump(sheet))
    found = fit_sheet(path)
    assert len(found.points) == 2 * 2 * SPEEDS.size * 3
    assert found.fit.main.values["coulomb"] == pytest.approx(LAW["coulomb"], rel=0.01)
    # And a servo that starts, runs and stops, in one file, is none.
    speed = np.concatenate([np.linspace(0, 200, 40), np.full(60, 200.0), np.linspace(200, 0, 40)])
    (tmp_path / "load300.txt").write_text("\n".join(f"{w:.0f};{100 + w:.0f}" for w in speed))
    with pytest.raises(InputError, match=r"load300.txt looks like a record over time"):
        fit_sheet(path)


@pytest.mark.parametrize(("loads", "names"), [((300.0, 900.0), ("fit",)), ((300.0,), ("threads", "bearing"))])
def test_a_bad_row_changes_little_and_is_said(tmp_path, loads, names):
    """One torque of 28 for each load is 2.5 times too large; the rest scatters by 0.05 % or less."""
    path = write_tables(tmp_path, loads, noise=1e-4, samples=5)
    for load in loads:
        spoilt = tmp_path / f"load{load:g}" / "20.csv"
        header, *rows = spoilt.read_text().splitlines()
        cells = [row.split(",") for row in rows]
        spoilt.write_text("\n".join([header, *(f"{speed},{2.5 * float(value)}" for speed, value in cells)]))
    found = fit_sheet(path)
    assert tuple(found.fit.ends) == names
    for end in found.fit.ends.values():
        assert end.values["stribeck_rise"] == pytest.approx(LAW["stribeck_rise"] * square(), rel=0.05)
        assert end.values["stribeck_speed"] == pytest.approx(LAW["stribeck_speed"], rel=0.1)
    assert any(text.startswith("The law fits poorly") and "20.csv" in text for text in sentences(found))


def test_loads_of_both_signs_are_told_by_their_directions(tmp_path):
    found = fit_sheet(write_tables(tmp_path / "signs", (300.0, -300.0), noise=1e-4))
    result = as_json(found)
    assert result["loads"] == [-300.0, 300.0]
    assert np.diff(result["loads_of_directions"]) == pytest.approx(600.0)


@pytest.mark.parametrize("trials", sizes([], [50], [400]))
def test_the_law_lies_within_its_stated_errors(trials, tmp_path):
    """In 95 % of sets of files, each number within 1.96 standard errors; less four deviations of the binomial's own.

    56 points less 7 numbers leave 49 degrees, with which 1.96 standard errors hold 94.4 %.
    """
    inside = dict.fromkeys(KNOWN, 0)
    for trial in range(trials):
        random = np.random.default_rng(trial)
        main = fit_sheet(write_tables(tmp_path / str(trial), noise=0.02, samples=10, random=random)).fit.main
        for key in KNOWN:
            inside[key] += abs(main.values[key] - KNOWN[key]) <= 1.96 * main.errors[key]
    print(inside)
    least = trials * (0.944 - 4 * math.sqrt(0.95 * 0.05 / trials))
    assert {key: count for key, count in inside.items() if count < least} == {}


def breaking_loose(loads, random, static=0.3, holds=0.3, error=0.01):
    """A law measured under two loads, and breakaway torques of both directions under some."""
    radius, angle = 9e-3, math.atan(4e-3 / (math.pi * 18e-3))
    speed, load = (x.ravel() for x in np.meshgrid([*-SPEEDS, *SPEEDS], [300.0, 900.0]))
    rows = [
        (s, s * (holds + radius * w * math.tan(math.atan(static) + s * angle)) * (1 + error * random.normal()), w)
        for w in loads
        for s in (1.0, -1.0)
    ]
    measured = Measured(speed, speed, load, radius, angle, np.array(rows), loose=error)
    torques = steady_torque({**KNOWN, "offset": 0.0}, measured, speed, load)
    return fitted(replace(measured, torque=torques + 0.01 * random.normal(size=speed.size)), {"stribeck_exponent": 1})


@pytest.mark.parametrize("trials", sizes([], [60], [400]))
def test_static_friction_of_threads_and_bearing_is_told_by_two_loads(trials):
    """In 95 % of sets of four breakaway torques within 1.96 standard errors, less four deviations of the count."""
    sets = [breaking_loose((300.0, 900.0), np.random.default_rng(trial)) for trial in range(trials)]
    found = np.array([[one.main.static[name] for name in BREAKAWAY] for one in sets])
    inside = (np.abs(found[..., 0] - 0.3) <= 1.96 * found[..., 1]).sum(axis=0)
    assert (inside >= trials * (0.95 - 4 * math.sqrt(0.95 * 0.05 / trials))).all()


def test_one_load_tells_both_ends_of_static_friction():
    """Their sum: the truth lies between them; and what is not above sliding is none."""
    found = breaking_loose((300.0,), np.random.default_rng(1))
    assert found.not_separable == (BREAKAWAY,)
    threads, bearing = (found.ends[end] for end in ("threads", "bearing"))
    assert set(threads.static) | set(bearing.static) == set(BREAKAWAY)
    assert threads.static[BREAKAWAY[0]][0] > 0.3
    assert bearing.bearing()[BREAKAWAY[1]] > 0.3 > bearing.values["coulomb"]
    held = 0.3 + 9e-3 * 300 * math.tan(math.atan(0.3))
    slow = bearing.values["friction_coefficient"] + bearing.values["stribeck_rise"]
    assert bearing.static[BREAKAWAY[1]][0] + 9e-3 * 300 * slow == pytest.approx(held, rel=0.02)
    low = breaking_loose((300.0, 900.0), np.random.default_rng(1), static=0.1, holds=0.0)
    assert low.main.static == {}


def test_tables_without_any_noise_make_json(tmp_path, run):
    """No residual, no scatter: nothing that JSON does not know."""
    path = write_tables(tmp_path, noise=0.0, samples=1, friction={"stribeck_rise": 0, "coefficient": 0.15})
    code, out, _ = run("fit", str(path), "--json")
    assert (code, json.loads(out)) == (0, json.loads(json.dumps(as_json(fit_sheet(path)))))
    assert json.loads(out)["measured"][0]["torque_scatter"] is None


def test_an_exponent_that_the_points_do_not_tell_is_said(tmp_path):
    """Noise of a tenth of the torque hides which exponent it is; without noise it is known."""
    noisy = fit_sheet(write_tables(tmp_path / "noisy", noise=0.1, samples=2, friction=None))
    assert noisy.fit.rival is not None or not noisy.fit.rise_seen
    quiet = fit_sheet(write_tables(tmp_path / "quiet", noise=1e-4, friction=None))
    assert quiet.fit.rival is None
    assert quiet.fit.main.values["stribeck_exponent"] == 1
    said = [any("exponent of the rise is not known" in text for text in sentences(one)) for one in (noisy, quiet)]
    assert said == [noisy.fit.rival is not None, False]


def test_nothing_is_copied_from_a_law_that_does_not_fit(screw):
    result = as_json(screw)
    assert "stribeck_rise" in blocks(result)
    assert blocks(result | {"rms": result["typical_torque"]}).count("\n") == 1
