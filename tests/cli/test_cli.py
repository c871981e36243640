"""The command line: JSON keys, exit codes, one sentence for bad input; outputs are put in place all or none."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
import xarray as xr
import yaml
from references.command_line import MOTION, refused
from references.drives import PARADOX
from references.sizes import sizes

from lsvib import Drive
from lsvib.answers.attributes import counted
from lsvib.answers.io import read_dataset
from lsvib.chapter.build import compute_figure
from lsvib.chapter.configuration import DEFAULT, checked, standard_settings
from lsvib.drives.automata import automaton_of
from lsvib.drives.pairings import PAIRINGS
from lsvib.drives.scene import read_yaml
from lsvib.errors import LsvibError
from lsvib.files import check_outputs, replacing, uninterrupted
from lsvib.systems.motion import follow

CONFIG = Path(__file__).parents[2] / "config" / "config.yaml"


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
    assert refused(run, *over) == "lsvib: stribeck_rise is both varied and set; give it once.\n"


def test_simulate(run, tmp_path):
    """The file has all that the method gives, and the attractor that the summary names."""
    code, out, error = run("simulate", *MOTION, "--samples", "21", "--out", "m.nc", "--json")
    summary, motion = json.loads(out), follow(automaton_of(PARADOX), (0.1, 0.0), 0.1)
    assert (code, error) == (0, "")
    assert [summary["final_state"][key] for key in ("u", "w")] == motion.end_state.tolist()
    assert (summary["attractor"], summary["status"]) == ("sprag_slip_cycle", "time_reached")
    assert summary["peak_normal_force"] > 0
    own = PARADOX.simulate({"u": 0.1, "w": 0.0}, 0.1, samples=21)
    with xr.open_dataset(tmp_path / "m.nc", decode_timedelta=False) as data:
        for name, values in own.variables.items():
            np.testing.assert_array_equal(data[name], values)
            assert (data[name].dims, data[name].attrs["units"]) == (values.dims, values.attrs["units"])
        assert data.attractor.attrs["flag_meanings"].split()[1 + int(data.attractor)] == summary["attractor"]
        assert float(data.amplitude) > 0 < float(data.period)
        assert float(data.mass) == 11.0 == json.loads(data.attrs["parameters"])["mass"]
        assert "coupling_deflection" in data
        np.testing.assert_array_equal(data["event_time"], motion.time)
        np.testing.assert_array_equal(data["u"], motion.at(np.linspace(0, 0.1, 21))[0][:, 0])
        assert counted(own.event_kind) == summary["events"]
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
    scene = run("simulate", "--scene", "scene.yaml", "--duration", "0.1", "--out", "b.nc", "--json")[1]
    assert json.loads(scene) == direct


def test_command_and_python_make_the_same_file(run, tmp_path):
    """In a folder of the workflow's results that is not one of its own."""
    (tmp_path / "Snakefile").touch()
    assert run("figure", "8.3", "--out", "results")[0] == 0
    names = {"fig8_03.nc", "fig8_03_checks.json", "fig8_03.png", "fig8_03.pdf"}
    assert {path.name for path in (tmp_path / "results").iterdir()} == names
    given = standard_settings("fig8_03")
    compute_figure("fig8_03", given, "other.nc", "other.json")
    one, other = read_dataset("results/fig8_03.nc"), read_dataset("other.nc")
    assert one.identical(other)
    assert json.loads(one.attrs["settings"]) == given


@pytest.mark.parametrize("form", sizes([["--json"]], [[]]))
def test_a_failed_check_is_exit_code_2_in_either_form(run, tmp_path, form):
    """Another friction than the chapter's in the file of settings, which is not ``--set``: 10.1 kg is missed."""
    section = yaml.safe_load(CONFIG.read_text())["fig8_08"]
    section["mass"]["count"], section["drive"] = 21, {"friction_coefficient": 0.3}
    (tmp_path / "figures.yaml").write_text(yaml.safe_dump({"figures": ["fig8_08"], "fig8_08": section}))
    code, _, err = run("figure", "8.8", "--config", "figures.yaml", "--out", "built", *form)
    assert code == 2
    assert "a check failed" in err


def test_installed_command_and_help(run):
    """In a process of its own: exit code and streams, not only what ``main`` raises."""
    command = [sys.executable, "-c", "from lsvib.cli.app import main; main()"]
    bad = subprocess.run([*command, "config", "--set", "mass=-1"], capture_output=True, text=True)
    assert (bad.returncode, bad.stdout) == (2, "")
    assert bad.stderr == "lsvib: mass = -1.0 is outside the allowed range 1e-18 <= mass <= 1e+09 kg.\n"
    for name in ("thresholds", "stability", "simulate", "figure", "attraction", "config"):
        code, shown, error = run(name, "--help")
        assert (code, error) == (0, "")
        assert f"lsvib {name}" in shown
        assert "Example" in shown


def test_the_shell_completes_commands_and_options(run, tmp_path, monkeypatch):
    """What ``--install-completion`` writes, asked by bash as a press of the tab key asks it, also of a path."""
    monkeypatch.setenv("HOME", str(tmp_path))
    assert run("--install-completion", "--shell", "bash")[0] == 0
    ask = """. ~/.bashrc; function=$(complete -p lsvib | sed "s/.*-F //; s/ .*//")
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); $function lsvib; echo "${COMPREPLY[@]}" """
    for words, found in ((("st",), "stability"), (("simulate", "--du"), "--duration"), (("sweep", "--ov"), "--over")):
        done = subprocess.run(["bash", "-c", ask, "bash", ".venv/bin/lsvib", *words], capture_output=True, text=True)
        assert (done.stdout, done.stderr) == (f"{found}\n", "")
    monkeypatch.setenv("HOME", "/proc/none")
    assert refused(run, "--install-completion", "--shell", "bash").startswith("lsvib: Cannot write to /proc/none")


def test_links_are_followed_and_old_results_replaced(run, tmp_path):
    (tmp_path / "x.nc").symlink_to("deep/real.nc")  # of a file that is not there yet, in a folder that is not
    for out in ("x.nc", "x.nc", "deep/real.nc"):
        assert run("simulate", *MOTION, "--out", out)[0] == 0
    assert (tmp_path / "x.nc").is_symlink()
    assert (tmp_path / "deep" / "real.nc").read_bytes().startswith(b"\x89HDF")
    assert not list(tmp_path.rglob("*.part"))


def test_a_file_keeps_its_mode_and_what_a_killed_run_left_goes(run, tmp_path):
    """What another process writes at this time, such as a job that outlived its run, stays."""
    for name in ("x.nc", ".x.nc.1.part", ".x.nc.2.part"):
        (tmp_path / name).write_text("old")
    os.utime(tmp_path / ".x.nc.1.part", (0, 0))
    (tmp_path / "x.nc").chmod(0o640)
    assert run("simulate", *MOTION, "--out", "x.nc")[0] == 0
    assert (tmp_path / "x.nc").stat().st_mode & 0o777 == 0o640
    assert {path.name for path in tmp_path.iterdir()} == {"x.nc", ".x.nc.2.part"}


def test_an_interrupt_waits_for_the_end_of_a_write():
    ended = []

    def write():
        with uninterrupted():
            os.kill(os.getpid(), signal.SIGINT)
            ended.append(True)

    with pytest.raises(KeyboardInterrupt):
        write()
    assert ended


TWICE = """
import signal, sys
from lsvib.cli.app import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job in the background ignores it
for duration in ("1e-9", "1"):
    sys.argv[-4:] = ["--duration", duration, "--out", f"{duration}.nc"]
    main()
    print("done", flush=True)
"""


@pytest.mark.slow
def test_an_interrupt_ends_a_command_that_is_deep_in_a_kernel(tmp_path):
    """Drag turns so much faster than the screw that one search takes 10¹³ steps; a short command has compiled it."""
    stiff = ("--set", "translation_damping=1e15", "--set", "friction_slope=-1e-5", "--start", "u=0.1", "w=0")
    command = [sys.executable, "-c", TWICE, "simulate", *stiff, *4 * [""]]
    piped = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=tmp_path, **piped) as process:
        assert "done\n" in iter(process.stdout.readline, "")
        work = psutil.Process(process.pid)
        busy = work.cpu_times().user + 1.0  # s; by then it is in the kernel
        while work.cpu_times().user < busy:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        sent = time.monotonic()
        error = process.communicate(timeout=60)[1]
    assert (process.returncode, error.splitlines()[-1:]) == (130, ["lsvib: interrupted."])
    assert time.monotonic() - sent < 5
    assert [path.name for path in tmp_path.iterdir()] == ["1e-9.nc"]


def test_a_name_that_is_no_utf_8_is_refused(run):
    code, _, error = run("simulate", *MOTION, "--out", "x\udcff.nc")
    assert (code, "Cannot write x?.nc: 'utf-8' codec can't encode" in error) == (2, True)


@pytest.mark.parametrize("environment", [{"COLUMNS": "0"}, {"COLUMNS": "2"}, {"PYTHONIOENCODING": "ascii"}])
def test_help_is_written_whatever_the_terminal_says(environment):
    command, given = [sys.executable, "-m", "lsvib", "--help"], {**os.environ, **environment}
    done = subprocess.run(command, env=given, capture_output=True, timeout=60, check=False)
    assert (done.returncode, b"thresholds" in done.stdout) == (0, True)


@pytest.mark.parametrize("error", [LsvibError("no"), KeyboardInterrupt("no"), ValueError("no")])
def test_an_old_file_stays_when_the_work_fails(tmp_path, error):
    (tmp_path / "old.nc").write_text("old")

    def work():
        with replacing(tmp_path / "old.nc", tmp_path / "x.png") as (part, _):
            part.write_text("new")
            raise error

    with pytest.raises(type(error), match="no"):
        work()
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]


@pytest.mark.parametrize("kind", [LsvibError, OSError])
def test_a_sentence_names_the_file_and_not_the_temporary_one(tmp_path, kind):
    with pytest.raises(LsvibError) as raised, replacing(tmp_path / "a.nc", tmp_path / "x.nc") as (_, part):
        raise OSError(28, "full", str(part)) if kind is OSError else LsvibError(f"Cannot write {part}: full.")
    assert str(raised.value) == f"Cannot write {tmp_path / 'x.nc'}: full."


def test_two_outputs_are_two_files(tmp_path):
    (tmp_path / "link.nc").symlink_to("x.nc")
    with pytest.raises(LsvibError, match="two of its files"):
        check_outputs([tmp_path / "x.nc", tmp_path / "link.nc"])


@pytest.mark.skipif(os.getuid() == 0, reason="root may write everywhere")
def test_what_cannot_be_written_is_told_before(tmp_path):
    (tmp_path / "kept.nc").touch(mode=0o444)
    with pytest.raises(LsvibError, match="write-protected"):
        check_outputs([tmp_path / "kept.nc"])
    tmp_path.chmod(0o555)
    with pytest.raises(LsvibError, match="not writable"):
        check_outputs([tmp_path / "new" / "x.nc"])


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_or_closed_standard_output_ends_in_one_sentence():
    command = f"{sys.executable} -m lsvib config"
    full = subprocess.run(f"{command} > /dev/full", shell=True, stderr=subprocess.PIPE, text=True)
    assert full.returncode == 2
    assert full.stderr == "lsvib: Cannot write to the standard output: No space left on device.\n"
    closed = subprocess.run(f"{command} >&-", shell=True, stderr=subprocess.PIPE, text=True)
    assert (closed.returncode, closed.stderr) == (0, "")


def test_the_settings_of_the_package_are_those_of_the_repository():
    assert DEFAULT.read_bytes() == CONFIG.read_bytes()
    checked(read_yaml(DEFAULT))
