"""The wheel holds the package and nothing else, and works away from the sources."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import lsvib

ROOT = Path(__file__).parents[2]


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
