"""What the README and the metadata promise about set-up: two lines, complete pins, one version; and the wheel."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import requires, version
from pathlib import Path

import pytest
import yaml

import lsvib

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PINS = dict(
    line.split("==") for line in (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines() if "==" in line
)


def normal(text: str) -> str:
    """The name of a package in a requirement, as indexes compare it."""
    return re.sub(r"[-_.]+", "-", re.split(r"[>=<!~\[; (]", text)[0]).lower()


@pytest.mark.parametrize("program", ["snakemake -j2", "pytest"])
def test_readme_has_the_line(program):
    line = f"python3 -m venv .venv && .venv/bin/pip install -r requirements.txt && .venv/bin/{program}"
    assert (ROOT / "README.md").read_text(encoding="utf-8").splitlines().count(line) == 1
    assert program.split()[0] in PINS


def test_requirements_lock_what_the_two_commands_need():
    """What the project declares for them, and all that this needs in turn, but what other platforms need."""
    extras = PROJECT["optional-dependencies"]
    declared = [*PROJECT["dependencies"], *extras["workflow"], *extras["assess"], *extras["test"]]
    needed, open_ones = set(), {normal(text) for text in declared}
    while open_ones:
        needed |= open_ones
        texts = [text for name in open_ones for text in requires(name) or [] if ";" not in text]
        open_ones = {normal(text) for text in texts} - needed
    pinned = {normal(name) for name in PINS}
    assert needed <= pinned
    assert {normal(text) for text in declared} <= pinned


def test_the_version_is_in_one_place_and_the_others_agree():
    assert version("lsvib") == lsvib.__version__
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == lsvib.__version__
    assert f"## {lsvib.__version__} " in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/design.md"])
def test_files_that_a_page_names_are_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for path in set(re.findall(r"`((?:src|tests|config|workflow|docs|benchmarks|\.ci)/[\w./]+)`", text)):
        assert (ROOT / path).exists(), path


def python(*arguments: str, folder: Path, path: Path) -> str:
    """Run Python in a folder, with another one on its path, and return what it printed."""
    environment = {**os.environ, "PYTHONPATH": str(path)}
    run = subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.mark.slow
def test_the_wheel(tmp_path):
    """Built from a copy of the sources and unpacked elsewhere, it has every file and draws a figure."""
    leave = shutil.ignore_patterns("__pycache__", "*.egg-info")
    shutil.copytree(ROOT / "src", tmp_path / "copy" / "src", ignore=leave)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy2(ROOT / name, tmp_path / "copy")
    command = ("pip", "wheel", "-q", "--no-deps", "-w", str(tmp_path), str(tmp_path / "copy"))
    python("-m", *command, folder=tmp_path, path=tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    assert f"lsvib-{lsvib.__version__}-" in wheel.name
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as file:
        file.extractall(site)
    ours, theirs = (
        {path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()}
        for root in (ROOT / "src", site)
    )
    expected = {name for name in ours if not any(part in name for part in ("__pycache__", ".egg-info", ".pyc"))}
    assert {name for name in theirs if ".dist-info/" not in name} == expected
    python("-m", "lsvib", "figure", "8.8", "--out", "built", folder=tmp_path, path=site)
    assert (tmp_path / "built" / "fig8_08.png").is_file()
