"""A copy of the project with a tiny configuration, and a way to run Snakemake in it."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock

ROOT = Path(__file__).parents[2]
PARTS = ("Snakefile", "benchmarks", "config", "examples", "profiles", "src", "tests/references", "workflow")
TINY = "figures: [fig8_03, fig8_08]\n"


class Project:
    """A copy of the project in a folder of its own; what runs there imports the copy, not the installed lsvib."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment = {**os.environ, "PYTHONPATH": str(folder / "src")}

    def __call__(self, *arguments: str) -> subprocess.CompletedProcess:
        """Run Snakemake and wait; stderr goes where stdout goes, as on a terminal."""
        command, both = [sys.executable, "-m", "snakemake", "-j2", *arguments], subprocess.STDOUT
        where = {"cwd": self.folder, "env": self.environment}
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=both, text=True, timeout=300, **where)

    def start(self, *arguments: str) -> subprocess.Popen:
        command, both = [sys.executable, "-m", "snakemake", "-j2", *arguments], subprocess.STDOUT
        where = {"cwd": self.folder, "env": self.environment, "text": True}
        where["preexec_fn"] = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # also where our own is ignored
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=both, start_new_session=True, **where)

    def plan(self, *arguments: str) -> set[str]:
        """Return what a run would do now: messages of its jobs, without the verdict, which every run has."""
        run = self("-n", *arguments)
        assert run.returncode == 0, run.stdout
        lines = (line.split(":", 1) for line in run.stdout.splitlines() if line.startswith("Job "))
        return {message.strip() for job, message in lines if job[4:].isdigit()} - {"Judging the checks"}

    def edit(self, file: str, old: str, new: str) -> None:
        path = self.folder / file
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")

    def files(self) -> dict[Path, int]:
        """Return the results and when each was written, without what Snakemake notes of them."""
        return {path: path.stat().st_mtime_ns for path in (self.folder / "results").rglob("*") if path.is_file()}


@pytest.fixture
def fresh(tmp_path: Path) -> Project:
    return copy_of_sources(tmp_path / "project")


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Project, str]:
    """Return a copy in which one complete run has been made, and what it printed. For reading only.

    The first process of tests that needs it makes it for all.
    """
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "finished"
    folder.mkdir(exist_ok=True)
    said = folder / "said"
    with FileLock(folder / "lock"):
        if not said.exists():
            run = copy_of_sources(folder / "project")()
            assert run.returncode == 0, run.stdout
            said.write_text(run.stdout, encoding="utf-8")
    return Project(folder / "project"), said.read_text(encoding="utf-8")


@pytest.fixture
def built(finished: tuple[Project, str], tmp_path: Path) -> Project:
    """Return a copy of the finished project, to be changed."""
    shutil.copytree(finished[0].folder, tmp_path / "project")
    return Project(tmp_path / "project")


def copy_of_sources(folder: Path) -> Project:
    """Copy what the workflow needs, and configure two figures without engine.

    Python's compiled modules come along; kernels do not, since these figures have none.
    """
    folder.mkdir()
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("*.nb?", "*.egg-info"))
        else:
            shutil.copy2(ROOT / part, folder / part)
    config = folder / "config" / "config.yaml"
    config.write_text(TINY + config.read_text(encoding="utf-8"), encoding="utf-8")
    return Project(folder)
