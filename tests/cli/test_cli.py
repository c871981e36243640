"""The command line: JSON keys, exit codes, one sentence for bad input, no file then; the dataset of ``simulate``."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from references.command_line import MOTION, refused

import lsvib
from lsvib.datasets.io import read_dataset
from lsvib.engine.motion import follow
from lsvib.figures.build import compute_figure
from lsvib.figures.configuration import standard_settings
from lsvib.models.drive import Drive
from lsvib.models.pairings import PAIRINGS
from lsvib.models.rigid import rigid_automaton

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
    assert list(table) == list(Drive.model_fields)
    assert table["lead_angle"]["value"] == np.radians(4)
    assert table["mass"] == {"value": 1.0, "unit": "kg", "symbol": "m", "allowed": "1e-18 <= mass <= 1e+09"}


def test_friction_by_name(run):
    """A listed pairing gives its parameters to the drive of any command; what is varied is not given by it."""
    listed = json.loads(run("pairings", "--json")[1])
    assert listed == {
        key: {"low": one.low, "high": one.high, "parameters": one.parameters(), "source": one.source}
        for key, one in PAIRINGS.items()
    }
    table = json.loads(run("config", "--set", "friction=powered_seat", "--json")[1])
    for key, value in PAIRINGS["powered_seat"].parameters().items():
        assert table[key]["value"] == value
    over = "sweep", "--set", "friction=powered_seat", "--over", "stribeck_rise=0:0.1:3"
    assert refused(run, *over) == "lsvib: stribeck_rise is varied and given by --set; give it once.\n"


def test_simulate(run, tmp_path):
    code, out, error = run("simulate", *MOTION, "--samples", "21", "--out", "m.nc", "--json")
    assert (code, error) == (0, "")
    summary = json.loads(out)
    assert {"final_state", "events", "attractor", "peak_normal_force", "status"} <= set(summary)
    drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
    motion = follow(rigid_automaton(drive), (0.1, 0.0), 0.1)
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
        assert data["event_time"].dims == ("event",)
        np.testing.assert_array_equal(data["event_time"], motion.time)
        np.testing.assert_array_equal(data["angle_deviation"], motion.at(np.linspace(0, 0.1, 21))[0][:, 0])
        own = drive.simulate({"u": 0.1, "w": 0.0}, 0.1, samples=21)
        assert all((data[name].values == own[name].values).all() for name in own.variables)
        assert json.loads(data.attrs["parameters"])["mass"] == 11
        kinds = dict(
            zip(data["event_kind"].attrs["flag_meanings"].split(), data["event_kind"].attrs["flag_values"], strict=True)
        )
        counted = {name: int(np.sum(data["event_kind"] == value)) for name, value in kinds.items()}
    assert {name: n for name, n in counted.items() if n} == summary["events"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.nc"]


def test_zero_has_no_sign(run):
    """The motion from steady sliding ends with w = −0 in doubles."""
    _, out, _ = run("simulate", "--start", "u=0", "w=0", "--duration", "0.5", "--out", "m.nc")
    assert "final state: u = 0, w = 0, slip" in out


def test_simulate_from_a_scene_file(run, tmp_path):
    (tmp_path / "scene.yaml").write_text(
        "drive: {mass: 11, support_damping: 1.0e-3, axial_force: -10}\nstart: {u: 0.1, w: 0}\nduration: 9\n"
    )
    direct = json.loads(run("simulate", *MOTION, "--out", "a.nc", "--json")[1])
    assert (
        json.loads(run("simulate", "--scene", "scene.yaml", "--duration", "0.1", "--out", "b.nc", "--json")[1])
        == direct
    )


def test_command_and_python_make_the_same_file(run, tmp_path):
    assert run("figure", "8.3", "--out", "built")[0] == 0
    given = standard_settings("fig8_03")
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


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_a_failed_check_is_exit_code_2_in_either_form(run, tmp_path, form):
    """Another friction than the chapter's in the file of settings, which is not ``--set``: 10.1 kg is missed."""
    section = yaml.safe_load(CONFIG.read_text())["fig8_08"]
    section["mass"]["count"], section["drive"] = 21, {"friction_coefficient": 0.3}
    (tmp_path / "figures.yaml").write_text(yaml.safe_dump({"figures": ["fig8_08"], "fig8_08": section}))
    code, _, err = run("figure", "8.8", "--config", "figures.yaml", "--out", "built", *form)
    assert code == 2
    assert "a check failed" in err


def test_installed_command_and_help():
    """In a process of its own: exit code and streams, not only what ``main`` raises."""
    command = [sys.executable, "-c", "from lsvib.cli.app import main; main()"]
    bad = subprocess.run([*command, "config", "--set", "mass=-1"], capture_output=True, text=True)
    assert (bad.returncode, bad.stdout) == (2, "")
    assert bad.stderr == "lsvib: mass = -1.0 is outside the allowed range 1e-18 <= mass <= 1e+09.\n"
    for name in ("thresholds", "stability", "simulate", "figure", "attraction", "config"):
        shown = subprocess.run([*command, name, "--help"], capture_output=True, text=True, check=True).stdout
        assert f"lsvib {name}" in shown
        assert "Example" in shown
