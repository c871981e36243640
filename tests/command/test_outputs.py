"""Outputs are put in place all or none, links are followed; settings away from the repository; drives in every form."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from references.command_line import MOTION

import lsvib
from lsvib.basins.grid import Axis
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError, LsvibError
from lsvib.figures.configuration import DEFAULT, check, settings_of
from lsvib.figures.folders import default_figures
from lsvib.files import Outputs, target_of

ROOT = Path(__file__).parents[2]
SETTINGS = read_yaml(DEFAULT)
SLOW = {
    "fig8_01", "fig8_02", "fig8_10", "fig8_13", "limit_process", "basin_sweep", "contact_stability",
    "nut_stability",
}  # fmt: skip


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


def test_figures_away_from_the_repository(run):
    code, out, _ = run("figure", "8.3", "--out", "built")
    assert code == 0
    assert Path("built/fig8_03.nc").is_file()
    assert "wrote built/fig8_03.png" in out
    assert re.search(r"^All \d+ checks passed\.$", out, re.MULTILINE)


def test_the_settings_of_the_package_are_those_of_the_repository():
    assert DEFAULT.read_bytes() == (ROOT / "config" / "config.yaml").read_bytes()
    check(SETTINGS)


@pytest.mark.parametrize(
    "figure", [pytest.param(f, marks=pytest.mark.long) if f in SLOW else f for f in default_figures()]
)
def test_a_figure_depends_on_every_parameter_that_may_be_set(figure):
    """On a coarse grid; those that are refused change no number, whatever their value, of either sign and large."""
    from importlib import import_module

    from lsvib.figures.folders import dataset_module

    section = merged(SETTINGS[figure], yaml.safe_load((ROOT / "config" / "draft.yaml").read_text()).get(figure, {}))
    module = import_module(dataset_module(figure))
    original = numbers_of(module.build(section))
    unused = []
    for key, default in RigidParameters():
        value = section["drive"].get(key, default)
        signs = (-value,) if key in ("input_speed", "axial_force") else ()
        for other in (1.001 * value, 2 * value, 0.5 * value, *signs) if value else (1e-3, 100.0, 1e4):
            try:
                changed = numbers_of(module.build({**section, "drive": {**section["drive"], key: other}}))
            except InputError:  # the figure is for drives of another kind
                continue
            if changed != original:
                break
        else:
            unused.append(key)
    assert sorted(unused) == sorted(settings_of(figure).unused), "declare these in the settings of the figure"


def merged(section, changes):
    both = {key: merged(section[key], new) if isinstance(new, dict) else new for key, new in changes.items()}
    return {**section, **both}


def numbers_of(dataset):
    """All numbers but those that state the drive itself."""
    variables = {name: variable for name, variable in dataset.variables.items() if "origin" not in variable.attrs}
    return {name: (variable.shape, variable.values.tobytes()) for name, variable in variables.items()}


def test_drives_and_dictionaries_are_accepted_alike():
    values, start = {"mass": 11.0, "axial_force": -10.0}, {"start": {"u": 0.1, "w": 0.0}, "duration": 0.1}
    drive = RigidParameters.of(values)
    assert lsvib.stability(drive) == lsvib.stability(values)
    assert lsvib.thresholds(drive, model="threads") == lsvib.thresholds(values, model="threads")
    complete = dict(drive)
    own, chapters = lsvib.thresholds(drive), lsvib.thresholds(complete)
    # A drive stands for itself; of changes to the chapter's drives, the critical friction is that with axial support.
    assert own.pop("critical_friction")["source"] == "eq. 8.20"
    assert "eqs 8.27 and 8.28" in chapters.pop("critical_friction")["source"]
    assert own == chapters
    expected = lsvib.simulate(**values, **start)
    for motion in (
        lsvib.simulate(drive, **start),
        lsvib.simulate(drive=drive, **start),
        lsvib.simulate(drive=values, **start),
        lsvib.simulate(RigidParameters(), **values, **start),
        lsvib.simulate({"drive": drive}, **start),
    ):
        assert motion.identical(expected)


def test_cells_that_are_accepted_are_apart():
    """Axes of random ends, as many cells as are accepted, around the whole axis and at its ends."""
    rng = np.random.default_rng(20261122)
    accepted = 0
    for _ in range(3000):
        start = rng.choice([-1.0, 0.0, 1.0]) * 10.0 ** rng.uniform(-300, 99)
        stop = start + max(abs(start), 1e-300) * 10.0 ** rng.uniform(-17, 2)
        try:
            axis = Axis.checked("u", start, stop, int(10 ** rng.uniform(0, 9)))
        except InputError:
            continue
        accepted += 1
        index = np.unique(rng.integers(0, axis.count, 50))
        index = np.unique(np.concatenate([index, index + 1, [0, 1, axis.count - 2, axis.count - 1]]))
        middles = axis.middles(index[(index >= 0) & (index < axis.count)])
        assert (np.diff(middles) > 0).all()
        assert start <= middles[0]
        assert middles[-1] <= stop
    assert accepted > 1000
