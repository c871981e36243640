"""What is published: a complete source distribution, and a wheel that works away from the sources.

``tests/tools/try_wheel.py`` installs it in empty environments of several Pythons.
"""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

import lsvib

ROOT = Path(__file__).parents[2]
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".ci", ".github", ".gitignore", ".venv", ".snakemake", ".*_cache", ".hypothesis", ".cache", "__pycache__",
    "*.egg-info", "results", "logs", "benchmarks", "build", "dist", ".whl", ".gl",
)  # fmt: skip


def python(*arguments: str, folder: Path, path: Path) -> str:
    """Run Python in a folder, with another one on its path, and return what it printed."""
    environment = {**os.environ, "PYTHONPATH": str(path)}
    command = [sys.executable, *arguments]
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


def built(kind: str, sources: Path, tools: Path, out: Path) -> Path:
    """Build what the sources are published as: ``sdist`` or ``wheel``."""
    out.mkdir()
    program = f"import setuptools.build_meta as build; build.build_{kind}({str(out)!r})"
    python("-c", program, folder=sources, path=tools)
    (file,) = out.iterdir()
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a copy of the sources, and the tools that build what is published of it."""
    made = tmp_path_factory.mktemp("published")
    shutil.copytree(ROOT, made / "copy", symlinks=True, ignore=LEFT_OUT)
    python("-m", "pip", "install", "-q", "--target", "tools", "setuptools>=77", folder=made, path=made)
    return made


@pytest.fixture(scope="module")
def wheel(folder):
    """Return the wheel, built from the sources."""
    shutil.copytree(folder / "copy", folder / "for_wheel", symlinks=True)
    return built("wheel", folder / "for_wheel", folder / "tools", folder / "wheel")


@pytest.fixture(scope="module")
def unpacked(folder):
    """Return the unpacked source distribution."""
    archive = built("sdist", folder / "copy", folder / "tools", folder / "sdist")
    with tarfile.open(archive) as file:
        file.extractall(folder / "unpacked", filter="data")
    (found,) = (folder / "unpacked").iterdir()
    return found


def files_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def contents(wheel: Path) -> dict[str, bytes]:
    """What a wheel installs, by its name."""
    with zipfile.ZipFile(wheel) as file:
        return {name: file.read(name) for name in file.namelist() if ".dist-info/" not in name}


@pytest.mark.slow
def test_the_wheel_holds_the_package_and_nothing_else(folder, wheel):
    ours = {name: text for name, text in files_of(folder / "copy" / "src").items() if ".egg-info" not in name}
    assert {"lsvib/py.typed", "lsvib/figures/config.yaml", "lsvib/figures/fig8_06/caption.rst"} <= set(ours)
    assert contents(wheel) == ours
    assert f"lsvib-{lsvib.__version__}-" in wheel.name


@pytest.mark.slow
def test_the_wheel_works_away_from_the_sources(wheel, tmp_path):
    """Unpacked beside the packages that it needs; a figure, and a command that no figure has."""
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as file:
        file.extractall(site)
    program = "import lsvib; print(lsvib.__file__); from lsvib.command.app import main; main()"
    said = python("-c", program, "stability", "--set", "mass=11", folder=tmp_path, path=site)
    assert Path(said.splitlines()[0]) == site / "lsvib" / "__init__.py"
    assert "saddle" in said
    python("-m", "lsvib", "figure", "8.8", "--out", "built", folder=tmp_path, path=site)
    assert (tmp_path / "built" / "fig8_08.png").is_file()


@pytest.mark.long
def test_the_source_distribution_is_complete_and_makes_the_same_wheel(folder, wheel, unpacked):
    ours = {name: text for name, text in files_of(folder / "copy").items() if ".egg-info" not in name}
    theirs = files_of(unpacked)
    assert "src/lsvib/figures/config.yaml" in ours
    assert sorted(set(ours) - set(theirs)) == []
    assert [name for name in ours if ours[name] != theirs[name]] == []
    again = built("wheel", unpacked, folder / "tools", folder / "again")
    assert contents(again) == contents(wheel)
