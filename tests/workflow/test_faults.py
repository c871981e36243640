"""Faults that the workflow survives: kills at random moments, a full disk, two runs at once; and one core or two."""

import os
import random
import resource
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from conftest import ROOT, Project, copy_of_sources

from lsvib.data.writer import read_dataset

pytestmark = pytest.mark.workflow


def files_of(project: Project) -> dict[Path, Path]:
    """Return the results of a project by their names, without the temporary files of writers that were killed."""
    results = project.folder / "results"
    files = (path for path in results.rglob("*") if path.is_file() and not path.name.endswith(".part"))
    return {path.relative_to(results): path for path in files}


def differences(project: Project, reference: Project) -> list[str]:
    """Return which results of a project, complete or not, differ from those of the reference."""
    theirs = files_of(reference)
    found = []
    for name, path in files_of(project).items():
        if name not in theirs:
            found.append(f"{name} is no result")
        elif name.suffix == ".nc":
            if not read_dataset(path).identical(read_dataset(theirs[name])):
                found.append(f"{name} differs")
        elif path.read_bytes() != theirs[name].read_bytes():
            found.append(f"{name} differs")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kills", [2, pytest.param(20, marks=pytest.mark.long)])
def test_kills_at_random_moments_leave_whole_files_and_the_next_run_goes_on(fresh, finished, kills):
    """SIGKILL to Snakemake and all its jobs; each run resumes what the killed one left, a complete one begins anew."""
    moments = random.Random(kills)
    everything = len(files_of(finished[0]))
    for _ in range(kills):
        if (fresh.folder / "results" / "verdict.txt").exists():
            shutil.rmtree(fresh.folder / "results")
        there = len(files_of(fresh))
        wanted, delay = moments.randint(there, everything - 1), moments.uniform(0.0, 1.0)
        process = fresh.start()
        try:
            while len(files_of(fresh)) < wanted and process.poll() is None:
                time.sleep(0.01)
            time.sleep(delay)
        finally:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        assert differences(fresh, finished[0]) == []
    run = fresh()
    assert run.returncode == 0, run.stdout
    assert differences(fresh, finished[0]) == []
    assert files_of(fresh).keys() == files_of(finished[0]).keys()
    assert not list((fresh.folder / "results").rglob("*.part"))


@pytest.mark.parametrize(
    ("room", "job", "name"),  # [bytes] too little for the dataset, or enough for it and too little for the picture
    [
        (40_000, "dataset/fig8_08", "datasets/fig8_08.nc"),
        (110_000, "figure/fig8_08", "figures/fig8_08.png"),
    ],
)
@pytest.mark.long
def test_a_full_disk_is_one_sentence_and_leaves_no_part_of_a_file(fresh, finished, room, job, name):
    """No file may grow beyond a limit, as on a disk that is full; with room again, the next run completes the rest."""
    run = subprocess.run(
        [*fresh.command, "--keep-going", "results/figures/fig8_08.png"],
        cwd=fresh.folder,
        env=fresh.environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)),
    )
    assert run.returncode == 1
    assert f"FAILED {job}: fig8_08: Cannot write results/{name}: " in run.stdout
    assert "Traceback" not in run.stdout
    assert not list((fresh.folder / "results").rglob("*.part"))
    assert differences(fresh, finished[0]) == []
    again = fresh()
    assert again.returncode == 0, again.stdout
    assert differences(fresh, finished[0]) == []


@pytest.mark.long
def test_two_runs_at_once_leave_the_same_files(fresh, finished):
    """Nothing locks the folder; each file is put in place whole, so whoever is last puts the same one there."""
    for process in [fresh.start(), fresh.start()]:
        process.wait()
    assert differences(fresh, finished[0]) == []
    again = fresh()
    assert again.returncode == 0, again.stdout
    assert differences(fresh, finished[0]) == []
    assert files_of(fresh).keys() == files_of(finished[0]).keys()


@pytest.mark.long
def test_one_core_gives_the_same_bits_as_two(tmp_path):
    """Figures that need the engine, on coarse grids; the compiled engine is shared with the other tests."""
    projects = []
    for cores in (1, 2):
        project = copy_of_sources(tmp_path / f"cores{cores}")
        shutil.rmtree(project.folder / "src")
        (project.folder / "src").symlink_to(ROOT / "src")
        project.environment["PYTHONPATH"] = str(ROOT / "src")
        project.edit("config/config.yaml", "figures: [fig8_03, fig8_08]", "figures: [fig8_04, fig8_09, fig8_13]")
        project.command[-1] = f"-j{cores}"
        run = project("--configfile", "config/draft.yaml")
        assert run.returncode == 0, run.stdout
        projects.append(project)
    one, two = projects
    assert files_of(one).keys() == files_of(two).keys()
    assert len(files_of(one)) > 12
    assert differences(one, two) == []
