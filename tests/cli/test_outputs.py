"""Outputs are put in place all or none, links are followed; drives are accepted in every form."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from references.command_line import MOTION

from lsvib.errors import LsvibError
from lsvib.figures.configuration import DEFAULT, check
from lsvib.files import Outputs, target_of, uninterrupted
from lsvib.models.scene import read_yaml

ROOT = Path(__file__).parents[2]
SETTINGS = read_yaml(DEFAULT)


def test_links_are_followed_and_old_results_replaced(run, tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "x.nc").symlink_to("deep/real.nc")  # of a file that is not there yet
    (tmp_path / "deep" / "empty.nc").touch()
    for out in ("x.nc", "x.nc", "deep/real.nc", "deep/empty.nc"):
        assert run("simulate", *MOTION, "--out", out)[0] == 0
    assert (tmp_path / "x.nc").is_symlink()
    for name in ("real.nc", "empty.nc"):
        assert (tmp_path / "deep" / name).read_bytes().startswith(b"\x89HDF")
    assert not list(tmp_path.rglob("*.part"))


def test_a_file_keeps_its_mode_and_what_a_killed_run_left_goes(run, tmp_path):
    assert run("simulate", *MOTION, "--out", "x.nc")[0] == 0
    (tmp_path / "x.nc").chmod(0o640)
    stale = tmp_path / ".x.nc.999999999.part"  # no process has this number
    stale.touch()
    os.utime(stale, (0, 0))
    (tmp_path / ".x.nc.999999998.part").touch()  # of another machine
    (tmp_path / f".x.nc.{os.getppid()}.part").touch()
    assert run("simulate", *MOTION, "--out", "x.nc")[0] == 0
    assert (tmp_path / "x.nc").stat().st_mode & 0o777 == 0o640
    assert {path.name for path in tmp_path.glob("*.part")} == {".x.nc.999999998.part", f".x.nc.{os.getppid()}.part"}


def test_an_interrupt_waits_for_the_end_of_a_write():
    ended = []

    def write():
        with uninterrupted():
            os.kill(os.getpid(), signal.SIGINT)
            ended.append(True)

    with pytest.raises(KeyboardInterrupt):
        write()
    assert ended


def test_an_interrupt_ends_a_command_that_is_deep_in_a_kernel(tmp_path):
    """Drag turns so much faster than the screw that one search takes 10¹³ steps."""
    stiff = ("--set", "translation_damping=1e15", "--set", "friction_slope=-1e-5", "--start", "u=0.1", "w=0")
    command = [sys.executable, "-m", "lsvib", "simulate", *stiff, "--duration", "1", "--out", tmp_path / "x.nc"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(8.0)
        process.send_signal(signal.SIGINT)
        sent = time.monotonic()
        error = process.communicate(timeout=60)[1]
    assert (process.returncode, "interrupted." in error) == (130, True)
    assert time.monotonic() - sent < 5
    assert not list(tmp_path.iterdir())


def test_a_name_that_is_no_utf_8_is_refused(run):
    code, _, error = run("simulate", *MOTION, "--out", "x\udcff.nc")
    assert (code, "its name is not valid UTF-8" in error) == (2, True)


@pytest.mark.parametrize("environment", [{"COLUMNS": "0"}, {"COLUMNS": "2"}, {"PYTHONIOENCODING": "ascii"}])
def test_help_is_written_whatever_the_terminal_says(environment):
    done = subprocess.run(
        [sys.executable, "-m", "lsvib", "--help"],
        env={**os.environ, **environment},
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, b"thresholds" in done.stdout) == (0, True)


def test_none_is_left_when_one_fails(tmp_path):
    """The second file cannot be put in place; what the first replaces is another matter, it is new here."""
    outputs = Outputs([(tmp_path / "a" / "x.nc", "netCDF"), (tmp_path / "b" / "x.png", "PNG")], make_folders=True)

    def work():
        with outputs.writing() as (first, second):
            first.write_text("one")
            second.write_text("two")
            (tmp_path / "b" / "x.png").mkdir()

    with pytest.raises(LsvibError, match=r"x\.png"):
        work()
    assert [path.name for path in tmp_path.rglob("*")] == ["b", "x.png"]


@pytest.mark.parametrize("error", [LsvibError("no"), KeyboardInterrupt(), ValueError("no")])
def test_none_is_left_when_the_work_fails(tmp_path, error):
    (tmp_path / "old.nc").write_bytes(b"\x89HDF of old")
    outputs = Outputs([(tmp_path / "old.nc", "netCDF"), (tmp_path / "new" / "x.png", "PNG")], make_folders=True)

    def work():
        with outputs.writing() as (first, _):
            first.write_text("new")
            raise error

    with pytest.raises(type(error)):
        work()
    assert [path.name for path in tmp_path.rglob("*")] == ["old.nc"]
    assert (tmp_path / "old.nc").read_bytes() == b"\x89HDF of old"


def test_a_sentence_names_the_file_and_not_the_temporary_one(tmp_path):
    outputs = Outputs([(tmp_path / "x.nc", "netCDF")])
    with pytest.raises(LsvibError) as raised, outputs.writing() as (part,):
        raise LsvibError(f"Cannot write {part}: full.")
    assert str(raised.value) == f"Cannot write {tmp_path / 'x.nc'}: full."


@pytest.mark.skipif(os.getuid() == 0, reason="root may write everywhere")
def test_what_cannot_be_written_is_told_before(tmp_path):
    (tmp_path / "kept.nc").touch(mode=0o444)
    with pytest.raises(LsvibError, match="write-protected"):
        target_of(tmp_path / "kept.nc")
    tmp_path.chmod(0o555)
    with pytest.raises(LsvibError, match="not writable"):
        target_of(tmp_path / "x.nc")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_or_closed_standard_output_ends_in_one_sentence():
    command = f"{sys.executable} -m lsvib config"
    full = subprocess.run(f"{command} > /dev/full", shell=True, stderr=subprocess.PIPE, text=True)
    assert full.returncode == 2
    assert full.stderr == "lsvib: Cannot write to the standard output: No space left on device.\n"
    closed = subprocess.run(f"{command} >&-", shell=True, stderr=subprocess.PIPE, text=True)
    assert (closed.returncode, closed.stderr) == (0, "")


def test_the_settings_of_the_package_are_those_of_the_repository():
    assert DEFAULT.read_bytes() == (ROOT / "config" / "config.yaml").read_bytes()
    check(SETTINGS)
