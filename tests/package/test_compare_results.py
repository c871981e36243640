"""The tool that compares two folders of results: it finds every kind of difference, and none where there is none."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from lsvib.data.writer import write_dataset

TOOL = Path(__file__).parents[1] / "tools" / "compare_results.py"
ATTRIBUTES = {"title": "title", "source": "source", "references": "none"}
NUMBER = {"units": "N", "long_name": "force"}


def write(folder: Path, values=(0.0, 1.0, np.nan), name="force", maker="old", **attributes) -> None:
    variables = {name: ("x", np.array(values), NUMBER | attributes)}
    write_dataset(xr.Dataset(variables, attrs=ATTRIBUTES), folder / "datasets" / "a.nc", maker)


@pytest.fixture
def results(tmp_path):
    for folder in (tmp_path / "old" / "datasets", tmp_path / "old" / "checks"):
        folder.mkdir(parents=True)
    write(tmp_path / "old")
    (tmp_path / "old" / "checks" / "a.json").write_text(json.dumps([{"passed": True, "value": 1.0}]))
    (tmp_path / "old" / "verdict.txt").write_text("all passed")
    shutil.copytree(tmp_path / "old", tmp_path / "new")
    return tmp_path / "old", tmp_path / "new"


def told(results: tuple[Path, Path]) -> list[str]:
    done = subprocess.run([sys.executable, str(TOOL), *map(str, results)], capture_output=True, text=True)
    lines = done.stdout.splitlines()
    assert (done.returncode, done.stderr) == (int(len(lines) > 1), "")
    return lines


def test_equal_results_whatever_made_them(results):
    write(results[1], maker="new")
    assert told(results) == ["0 differences in 3 files"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"values": (0.0, np.nextafter(1.0, 2.0), np.nan)}, "force differs in 1 of 3 values, by at most 2.22045e-16"),
        ({"values": (-0.0, 1.0, np.nan)}, "force differs in 1 of 3 values, by at most 0"),
        ({"values": (0.0, 1.0)}, "force has other dimensions or another type"),
        ({"name": "power"}, "force is only in the old dataset"),
        ({"long_name": "strength"}, "force: attribute long_name was 'force' and is 'strength'"),
    ],
)
def test_a_changed_dataset(results, change, words):
    write(results[1], **change)
    assert f"datasets/a.nc: {words}" in told(results)


def test_changed_checks_verdicts_and_files(results):
    (results[1] / "checks" / "a.json").write_text(json.dumps([{"passed": False, "value": 1.0}]))
    (results[1] / "verdict.txt").write_text("failed")
    (results[0] / "old.txt").write_text("")
    assert told(results) == [
        "checks/a.json: [0].passed was True and is False",
        "old.txt: only in the old results",
        "verdict.txt: the bytes differ",
        "3 differences in 4 files",
    ]
