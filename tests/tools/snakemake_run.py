"""Snakemake in a copy of one process that has loaded what it needs, which takes it longer than most plans."""

import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

_PROCESSES = multiprocessing.get_context("forkserver")
_PROCESSES.set_forkserver_preload(["snakemake.cli", "grimp", "pydantic", "xarray"])  # nothing of ours, which is edited


def snakemake(folder: Path, environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess:
    """Run ``snakemake`` in a folder and wait; stderr goes where stdout goes, as on a terminal."""
    said = folder.with_suffix(".said")
    process = _PROCESSES.Process(target=_main, args=(folder, environment, arguments, said))
    process.start()
    process.join()
    return subprocess.CompletedProcess(arguments, process.exitcode, said.read_text(encoding="utf-8"))


def _main(folder: Path, environment: dict[str, str], arguments: tuple[str, ...], said: Path) -> None:
    from snakemake.cli import main

    with said.open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.chdir(folder)
    os.environ.update(environment)
    sys.path[:0] = [str(folder), environment["PYTHONPATH"]]
    sys.argv[1:] = arguments
    main()
