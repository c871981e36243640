"""The command line: JSON keys, exit codes, one sentence for bad input, no file then; the dataset of ``simulate``."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from references.command_line import DRIVE, GRID, MOTION, refused

import lsvib
from lsvib.data.writer import read_dataset
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import rigid_automaton
from lsvib.engine.motion import follow
from lsvib.errors import InputError
from lsvib.figures.compute import compute_figure
from lsvib.figures.configuration import check

CONFIG = Path(__file__).parents[2] / "config" / "config.yaml"
UNITS = {
    "time": "s",
    "angle_deviation": "rad",
    "velocity_deviation": "rad s-1",
    "normal_force": "N",
    "coupling_torque": "N m",
    "mode": "1",
    "event_time": "s",
    "event_kind": "1",
    "event_sign": "1",
    "event_mode": "1",
    "event_angle_deviation_before": "rad",
    "event_angle_deviation_after": "rad",
    "event_velocity_deviation_before": "rad s-1",
    "event_velocity_deviation_after": "rad s-1",
}


def test_config_json(run):
    table = json.loads(run("config", "--set", "lead_angle_deg=4", "--json")[1])
    assert list(table) == list(RigidParameters.model_fields)
    assert table["lead_angle"]["value"] == np.radians(4)
    assert table["mass"] == {"value": 1.0, "unit": "kg", "symbol": "m", "allowed": "1e-18 <= mass <= 1e+09"}


def test_simulate(run, tmp_path):
    code, out, error = run("simulate", "--model", "rigid", *MOTION, "--samples", "21", "--out", "m.nc", "--json")
    assert (code, error) == (0, "")
    summary = json.loads(out)
    assert {"final_state", "events", "attractor", "peak_normal_force", "status"} <= set(summary)
    motion = follow(
        rigid_automaton(RigidParameters.of(mass=11, support_damping=1e-3, axial_force=-10)), (0.1, 0.0), 0.1
    )
    assert [summary["final_state"][key] for key in ("u", "w")] == motion.end_state.tolist()
    assert summary["attractor"] == "sprag_slip_cycle"
    assert summary["status"] == "time_reached"
    assert sum(summary["events"].values()) == len(motion.time)
    with xr.open_dataset(tmp_path / "m.nc") as data:
        assert set(UNITS) <= set(data.variables)
        assert {name: data[name].attrs["units"] for name in UNITS if name != "time"} == {
            name: unit for name, unit in UNITS.items() if name != "time"
        }
        assert data["angle_deviation"].dims == ("time",)
        assert data.attractor.attrs["flag_meanings"].split()[1 + int(data.attractor)] == summary["attractor"]
        assert float(data.amplitude) > 0 < float(data.period)
        assert float(data.mass) == 11.0
        assert "coupling_deflection" in data
        assert data.sizes["time"] == 21
        assert data["event_time"].dims == ("event",)
        assert data.sizes["event"] == len(motion.time)
        np.testing.assert_array_equal(data["event_time"], motion.time)
        np.testing.assert_array_equal(data["angle_deviation"], motion.at(np.linspace(0, 0.1, 21))[0][:, 0])
        assert json.loads(data.attrs["parameters"])["mass"] == 11
        kinds = dict(
            zip(data["event_kind"].attrs["flag_meanings"].split(), data["event_kind"].attrs["flag_values"], strict=True)
        )
        counted = {name: int(np.sum(data["event_kind"] == value)) for name, value in kinds.items()}
    assert {name: n for name, n in counted.items() if n} == summary["events"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.nc"]


def test_simulate_from_python_is_the_same():
    data = lsvib.simulate(
        mass=11, support_damping=1e-3, axial_force=-10, start={"u": 0.1, "w": 0}, duration=0.1, samples=21
    )
    motion = follow(
        rigid_automaton(RigidParameters.of(mass=11, support_damping=1e-3, axial_force=-10)), (0.1, 0.0), 0.1
    )
    np.testing.assert_array_equal(data["angle_deviation"], motion.at(np.linspace(0, 0.1, 21))[0][:, 0])


def test_simulate_from_a_scene_file(run, tmp_path):
    (tmp_path / "scene.yaml").write_text(
        "drive: {mass: 11, support_damping: 1.0e-3, axial_force: -10}\nstart: {u: 0.1, w: 0}\nduration: 9\n"
    )
    direct = json.loads(run("simulate", *MOTION, "--out", "a.nc", "--json")[1])
    assert (
        json.loads(run("simulate", "--scene", "scene.yaml", "--duration", "0.1", "--out", "b.nc", "--json")[1])
        == direct
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["thresholds", "--set", "masss=1"], "masss is not a known key"),
        (
            ["thresholds", "--set", "mass=5kg"],
            "mass = '5kg' is not a number; the allowed range is 1e-18 <= mass <= 1e+09",
        ),
        (["thresholds", "--set", "mass"], "'mass' is not of the form KEY=VALUE"),
        (["thresholds", "--solve", "stuck"], "threshold = 'stuck' is not one of those of model rigid: onset, kine"),
        (["thresholds", "--solve", "stick", "--for", "weight"], "unknown = 'weight' is not a parameter of model rigid"),
        (["thresholds", "--solve", "stick"], "conditions (8.19) hold for no axial force"),
        (["thresholds", "--for", "mass"], "--for mass needs --solve"),
        (["stability", "--set", "friction_coefficient=10.3"], "friction_coefficient = 10.3 is outside"),
        (["stability", "--set", "axial_force=0"], "axial_force"),
        (["stability", "--model", "elastic"], "model = 'elastic' is not one of rigid, threads, support, nut"),
        (["thresholds", "--model", "nut", "--set", "axial_force=0"], "axial_force balances damping and friction"),
        (["thresholds", "--model", "nut", "--set", "screw_mass=1"], "screw_mass is not a known key"),
        (["config", "--set", "mass=nan"], "mass = 'nan' is not a number"),
        (["simulate", *MOTION, "--set", "friction_coefficient=11", "--out", "x.nc"], "< cot(lead_angle)"),
        (["simulate", *MOTION, "--set", "colour=1", "--out", "x.nc"], "colour is not a known key"),
        (["simulate", *MOTION, "--out", "none/x.nc"], "none"),
        (["simulate", *DRIVE, "--start", "u=0.1", "--duration", "1", "--out", "x.nc"], "start"),
        (["simulate", *DRIVE, "--start", "u=1e300", "w=0", "--duration", "1", "--out", "x.nc"], "1e+300"),
        (["simulate", *DRIVE, "--start", "u=0", "w=0", "--duration", "-1", "--out", "x.nc"], "duration = -1"),
        (["simulate", *DRIVE, "--start", "u=0", "w=0", "--duration", "soon", "--out", "x.nc"], "soon"),
        (["simulate", *MOTION, "--samples", "1", "--out", "x.nc"], "samples = 1"),
        (["simulate", *MOTION, "--resume", "never", "--out", "x.nc"], "resume = 'never'"),
        (["simulate", *MOTION, "--model", "elastic", "--out", "x.nc"], "model = 'elastic'"),
        (["simulate", *MOTION], "--out"),
        (["simulate", "--scene", "none.yaml", "--out", "x.nc"], "none.yaml"),
        (["figure", "8.6", "--config", "none.yaml"], "none.yaml"),
        (["figure", "limit_process", "--config", str(CONFIG), "--set", "mass=9"], "The limit process needs a drive"),
        (["figure", "attraction", "--config", str(CONFIG)], "figure attraction is not one of 8.1"),
        (["figure", "stability_sweeps", "--config", str(CONFIG), "--set", "mass=9"], "has no drive of its own"),
        (["figure", "8.8", "--config", str(CONFIG), "--out", str(CONFIG)], "config.yaml is not a folder"),
        (["simulate", *MOTION, "--out", str(CONFIG / "x.nc")], "Cannot write"),
        (["simulate", *MOTION, "--out", "."], "not the name of a file"),
        (["simulate", *MOTION, "--set", "duration=1", "--out", "x.nc"], "duration is not a known key"),
        (["simulate", *MOTION, "--set", "drive=1", "--out", "x.nc"], "drive is not a known key"),
        (["simulate", *MOTION, "--model", "threads", "--resume", "at_once", "--out", "x.nc"], "resume = 'at_once'"),
        (["thresholds", "--set", "self=1"], "self is not a known key"),
        (["config", "--set", "lead_angle_deg=95"], "outside the allowed range 5.72958e-05 <= "),
        (["config", "--set", "input_speed=0"], "1e-12 <= |input_speed| <= 1e+09"),
        (["attraction", *GRID, "--set", "mass=11", "--figure", "map.pdf", "--out", "x.nc"], ".png"),
        (["nonsense"], "nonsense"),
        (["thresholds", "--nonsense"], "--nonsense"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(run, arguments, words):
    assert words in refused(run, *arguments)


def test_unknown_figure_is_refused_with_all_that_there_are(run):
    sentence = refused(run, "figure", "8.99")
    assert sentence.startswith("lsvib: figure 8.99 is not one of 8.1, 8.2, ")
    assert "8.15, basin_sweep, " in sentence


@pytest.mark.parametrize("key", ["count", "drive"])
def test_settings_of_a_figure_are_refused_as_the_workflow_refuses_them(run, tmp_path, key):
    """A misspelt key and a missing one: the sentence is that of the whole configuration."""
    settings = yaml.safe_load(CONFIG.read_text())
    if key == "count":
        settings["fig8_08"]["mass"]["cuont"] = settings["fig8_08"]["mass"].pop("count")
    else:
        del settings["fig8_08"]["drive"]
    (tmp_path / "figures.yaml").write_text(yaml.safe_dump(settings))
    with pytest.raises(InputError) as of_the_workflow:
        check(settings)
    assert refused(run, "figure", "8.8", "--config", "figures.yaml").rstrip() == f"lsvib: {of_the_workflow.value}"


def test_command_and_python_make_the_same_file(run, tmp_path):
    assert run("figure", "8.3", "--out", "built")[0] == 0
    given = yaml.safe_load(CONFIG.read_text())["fig8_03"]
    compute_figure("fig8_03", given, "other.nc", "other.json")
    one, other = read_dataset("built/fig8_03.nc"), read_dataset("other.nc")
    assert one.identical(other)
    assert json.loads(one.attrs["settings"]) == given


def test_folders_of_the_workflow_are_refused(run, tmp_path):
    (tmp_path / "Snakefile").touch()
    for folder in ("datasets", "figures", "checks"):
        sentence = refused(run, "figure", "8.3", "--out", f"results/{folder}")
        assert "belongs to the workflow" in sentence
    assert run("figure", "8.3", "--out", "results")[0] == 0
    assert {path.name for path in (tmp_path / "results").iterdir()} == {
        "fig8_03.nc", "fig8_03_checks.json", "fig8_03.png", "fig8_03.pdf"
    }  # fmt: skip


@pytest.mark.parametrize(
    "words",
    [
        "simulate --duration 0.1 --start u=0.1 w=0 --out results/datasets/file.nc",
        "sweep --over mass=1:20:2 --out results/datasets/file.nc",
        "attraction --grid u=-1:1:2 w=-1:1:2 --out results/attraction/map.nc",
        "attraction --grid u=-1:1:2 w=-1:1:2 --out map.nc --figure results/figures/attraction.png",
        "chart --x mass=1:20:2 --y axial_force=-60:60:2 --out results/chart/chart.nc",
        "follow --over mass=10.2:14 --set mass=11 --out results/datasets/file.nc",
        "resilience --over axial_force=-33:-1:2 --out results/datasets/file.nc",
        "assess sheet.yaml --out results/assessments/sheet",
    ],
)
def test_no_command_writes_to_folders_of_the_workflow(run, tmp_path, words):
    (tmp_path / "Snakefile").touch()
    assert "belongs to the workflow" in refused(run, *words.split())


@pytest.mark.parametrize("number", ["8.3", "fig8_03"])
def test_figure_by_number_or_name(run, tmp_path, number):
    section = yaml.safe_load(CONFIG.read_text())["fig8_03"]
    for axis in ("inertia", "damping"):
        section[axis]["count"] = 41
    (tmp_path / "figures.yaml").write_text(yaml.safe_dump({"figures": ["fig8_03"], "fig8_03": section}))
    code, out, _ = run("figure", number, "--config", "figures.yaml", "--out", "built")
    assert code == 0
    assert ": true (" in out
    assert Path("built/fig8_03.png").is_file()


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_a_failed_check_is_exit_code_2_in_either_form(run, tmp_path, form):
    """Another friction than the chapter's in the file of settings, which is not ``--set``: 10.1 kg is missed."""
    section = yaml.safe_load(CONFIG.read_text())["fig8_08"]
    section["mass"]["count"], section["drive"] = 21, {"friction_coefficient": 0.3}
    (tmp_path / "figures.yaml").write_text(yaml.safe_dump({"figures": ["fig8_08"], "fig8_08": section}))
    code, _, err = run("figure", "8.8", "--config", "figures.yaml", "--out", "built", *form)
    assert code == 2
    assert "a check failed" in err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("drive: {mass: [1\n", "not valid YAML"),
        ("- 1\n", "does not hold names and values"),
        ("drive: {mass: 11, weight: 2}\nstart: {u: 0, w: 0}\nduration: 1\n", "weight is not a known key"),
        ("drive: 5\nstart: {u: 0, w: 0}\nduration: 1\n", "drive = 5 does not hold names and values"),
        ("drive: [1, 2]\nstart: {u: 0, w: 0}\nduration: 1\n", "drive = [1, 2] does not hold"),
        ("model: [rigid]\nstart: {u: 0, w: 0}\nduration: 1\n", "model = ['rigid'] is not one of"),
        ("1: 2\nstart: {u: 0, w: 0}\nduration: 1\n", "1 is not a known key"),
        ("drive: {mass: 11}\nphysics: [support_damping, axial_force]\nstart: {u: 0, w: 0}\nduration: 1\n", "list rest"),
    ],
)
def test_corrupt_scene_is_refused(run, tmp_path, text, words):
    (tmp_path / "scene.yaml").write_text(text)
    assert words in refused(run, "simulate", "--scene", "scene.yaml", "--out", "x.nc")


def test_installed_command_and_help():
    """In a process of its own: exit code and streams, not only what ``main`` raises."""
    command = [sys.executable, "-c", "from lsvib.command.app import main; main()"]
    bad = subprocess.run([*command, "config", "--set", "mass=-1"], capture_output=True, text=True)
    assert (bad.returncode, bad.stdout) == (2, "")
    assert bad.stderr == "lsvib: mass = -1.0 is outside the allowed range 1e-18 <= mass <= 1e+09.\n"
    for name in ("thresholds", "stability", "simulate", "figure", "attraction", "config"):
        shown = subprocess.run([*command, name, "--help"], capture_output=True, text=True, check=True).stdout
        assert f"lsvib {name}" in shown
        assert "Example" in shown
