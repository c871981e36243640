"""The processes of the jobs: how one fails, is killed or cannot write, and what is left of it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

PROGRAM = """
import math, os, signal, sys
sys.path.insert(0, sys.argv[1])
import jobs
jobs._PROCESSES.set_forkserver_preload([])  # the libraries are no part of this
for name, job, *arguments in (
    ("good", abs, -1), ("wrong", math.sqrt, -1),
    ("killed", signal.raise_signal, 9), ("real_time", signal.raise_signal, 40),
):
    try:
        jobs.run(job, f"logs/{name}.log", name, *arguments)
        print(name, "ended well")
    except jobs.WorkflowError as error:
        print(name, error)
try:
    jobs.run(abs, "no/folder/x.log", "unwritten", 1)
except jobs.WorkflowError as error:
    print("unwritten", error)
"""


def run(folder: Path) -> list[str]:
    """Run a few jobs in a folder and return what became of each."""
    (folder / "logs").mkdir()
    command = [sys.executable, "-c", PROGRAM, str(Path(__file__).parents[2] / "workflow")]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120).stdout.splitlines()


def test_how_jobs_end(tmp_path):
    """Each in one sentence; the reason of an error is in its log, and only what ended well has a benchmark."""
    assert run(tmp_path) == [
        "good ended well",
        "wrong The job failed.",
        "killed The job was ended by a signal: Killed.",
        "real_time The job was ended by a signal: Real-time signal 6.",
        "unwritten The job failed.",
    ]
    assert "ValueError: " in (tmp_path / "logs" / "wrong.log").read_text()
    assert [path.name for path in (tmp_path / "results" / "benchmarks").iterdir()] == ["good.tsv"]
    assert (tmp_path / "results" / "benchmarks" / "good.tsv").read_text().startswith("s\tcpu_time\tmax_rss [MB]\n")


def test_a_job_is_good_without_its_benchmark(tmp_path):
    (tmp_path / "results").write_text("not a folder")
    assert run(tmp_path)[0] == "good ended well"


EDIT = """
import pathlib, sys
sys.path.insert(0, "workflow")
import jobs
jobs._PROCESSES.set_forkserver_preload(["lsvib.said"])
for file in ("first.txt", "second.txt"):
    jobs.run(exec, "logs/said.log", file, f"from lsvib.said import words; open('{file}', 'w').write(words)")
    pathlib.Path("src/lsvib/said.py").write_text("words = 'edited later'")
"""


def test_an_edit_in_the_middle_of_a_run_reaches_the_jobs_after_it(tmp_path):
    root, package = Path(__file__).parents[2], tmp_path / "src" / "lsvib"
    for folder in (package, tmp_path / "workflow", tmp_path / "logs"):
        folder.mkdir(parents=True)
    shutil.copy(root / "workflow" / "jobs.py", tmp_path / "workflow")
    for name in ("__init__.py", "__init__.pyi", "errors.py", "files.py"):
        shutil.copy(root / "src" / "lsvib" / name, package)
    (package / "said.py").write_text("words = 'loaded'")
    environment = os.environ | {"PYTHONPATH": str(package.parent)}
    subprocess.run([sys.executable, "-c", EDIT], cwd=tmp_path, env=environment, check=True, timeout=120)
    assert [(tmp_path / f"{name}.txt").read_text() for name in ("first", "second")] == ["loaded", "edited later"]
