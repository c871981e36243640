"""What a command loads: no engine for eigenvalues, no matplotlib for data, nothing heavy before it is needed.

``lint-imports`` (run by .ci/run) holds the rooms to their contracts; here it is seen what Python really loads.
"""

import json
import subprocess
import sys

import grimp
import pytest

from lsvib.figures.configuration import dataset_module, default_figures, picture_module
from lsvib.models.model import model_names

FIGURES = default_figures()
WITHOUT_ENGINE = [
    "--help",
    "config",
    *(f"stability --model {name}" for name in model_names()),
    "thresholds --model threads",
    "figure 8.8",
    "thresholds --set mass=-1",
]
COMMANDS = """
import os, sys
import cyclopts, mpmath, matplotlib, netCDF4, pydantic, xarray
for line in sys.argv[1:]:
    if not os.fork():
        sys.argv = ["lsvib", *line.split()]
        sys.stdout = sys.stderr = open(os.devnull, "w")
        try:
            from lsvib.cli.app import main
            main()
        except SystemExit:
            pass
        os.write(1, f"{line}: {'numba' in sys.modules}\\n".encode())
        os._exit(0)
    os.wait()
"""
MODULES = """
import json, os, sys
from importlib import import_module
import numpy, xarray, netCDF4, mpmath, pydantic
before, *names = sys.argv[1:]
import_module(before)
for name in names:
    sys.stdout.flush()
    if not os.fork():
        import_module(name)
        print(json.dumps([name, list(sys.modules)]), flush=True)
        os._exit(0)
    os.wait()
"""


def loaded(part, before: str) -> dict[str, set[str]]:
    """By figure, the modules that Python has loaded after its dataset or picture, imported in a process of its own.

    Each is a copy of one process, which has loaded ``before`` and what else is heavy and not looked for.
    """
    names = {part(figure): figure for figure in FIGURES}
    run = subprocess.run([sys.executable, "-c", MODULES, before, *names], capture_output=True, text=True, check=True)
    return {names[name]: set(modules) for name, modules in map(json.loads, run.stdout.splitlines())}


def test_commands_that_need_no_engine_load_none(tmp_path):
    """Each in a copy of one process, which has loaded what else is heavy; and one that needs the engine shows it."""
    lines = [*WITHOUT_ENGINE, "simulate --out x.nc --scene none.yaml"]
    command = [sys.executable, "-c", COMMANDS, *lines]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [*(f"{line}: False" for line in WITHOUT_ENGINE), f"{lines[-1]}: True"]


def test_the_package_loads_nothing_heavy():
    program = "import lsvib, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert not {"numba", "matplotlib", "xarray", "scipy", "pydantic", "numpy"} & set(done.stdout.split())


@pytest.mark.parametrize(
    ("part", "before", "unwanted"),
    [(dataset_module, "numba", "matplotlib"), (picture_module, "matplotlib.backends.backend_agg", "numba")],
)
def test_figures_load_what_the_workflow_knows_of(part, before, unwanted):
    """The workflow reruns a figure when a file in its import closure changes: no other module may be loaded."""
    graph = grimp.build_graph("lsvib", cache_dir=None)
    for figure, modules in loaded(part, before).items():
        closure = graph.find_upstream_modules(part(figure)) | {part(figure)}
        packages = {parent.rsplit(".", n)[0] for parent in closure for n in range(1, parent.count(".") + 1)}
        assert unwanted not in modules, figure
        assert {name for name in modules if name.split(".")[0] == "lsvib"} <= closure | packages, figure
