"""What is published: a complete source distribution, a wheel built from it, and the installed wheel away from both."""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".ci", ".github", ".gitignore", ".venv", ".snakemake", ".*_cache", ".hypothesis", ".cache", "__pycache__",
    "*.egg-info", "results", "logs", "benchmarks", "build", "dist", ".whl", ".gl",
)  # fmt: skip
pytestmark = pytest.mark.long


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
def published(tmp_path_factory):
    """Return a copy of the sources, the unpacked source distribution and the wheel that was built from it."""
    folder = tmp_path_factory.mktemp("published")
    shutil.copytree(ROOT, folder / "copy", symlinks=True, ignore=LEFT_OUT)
    python("-m", "pip", "install", "-q", "--target", "tools", "setuptools>=77", folder=folder, path=folder)
    archive = built("sdist", folder / "copy", folder / "tools", folder / "sdist")
    with tarfile.open(archive) as file:
        file.extractall(folder / "unpacked", filter="data")
    (unpacked,) = (folder / "unpacked").iterdir()
    wheel = built("wheel", unpacked, folder / "tools", folder / "wheel")
    return folder / "copy", unpacked, wheel


def files_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_source_distribution_is_complete(published):
    sources, unpacked, _ = published
    ours = {name: text for name, text in files_of(sources).items() if ".egg-info" not in name}
    theirs = files_of(unpacked)
    assert "src/lsvib/figures/config.yaml" in ours
    assert sorted(set(ours) - set(theirs)) == []
    assert [name for name in ours if ours[name] != theirs[name]] == []


def test_the_wheel_holds_the_package_and_nothing_else(published):
    sources, _, wheel = published
    ours = {name: text for name, text in files_of(sources / "src").items() if ".egg-info" not in name}
    with zipfile.ZipFile(wheel) as file:
        theirs = {name: file.read(name) for name in file.namelist() if ".dist-info/" not in name}
    assert {"lsvib/py.typed", "lsvib/figures/config.yaml", "lsvib/figures/fig8_06/caption.rst"} <= set(ours)
    assert theirs == ours


def test_the_installed_wheel_works_away_from_the_sources(published, tmp_path):
    *_, wheel = published
    install = ("-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", "site", str(wheel))
    python(*install, folder=tmp_path, path=tmp_path)
    site = tmp_path / "site"
    where = python("-c", "import lsvib; print(lsvib.__file__)", folder=tmp_path, path=site)
    assert Path(where.strip()) == site / "lsvib" / "__init__.py"
    python("-m", "lsvib", "figure", "8.3", "--out", "built", folder=tmp_path, path=site)
    assert (tmp_path / "built" / "fig8_03.png").is_file()
