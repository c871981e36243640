"""What a command loads: no engine for eigenvalues, no matplotlib for data, nothing heavy before it is needed.

``lint-imports`` (run by .ci/run) holds the rooms to their contracts; here it is seen what Python really loads.
"""

import json
import subprocess
import sys

import grimp

from lsvib.figures.configuration import default_figures, module_of
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
for name in sys.argv[1:]:
    sys.stdout.flush()
    if not os.fork():
        import_module(name)
        print(json.dumps([name, list(sys.modules)]), flush=True)
        os._exit(0)
    os.wait()
"""


def loaded() -> dict[str, set[str]]:
    """By the module of a figure, what Python has loaded after it, imported in a process of its own.

    Each is a copy of one process, which has loaded what else is heavy and not looked for.
    """
    names = map(module_of, FIGURES)
    run = subprocess.run([sys.executable, "-c", MODULES, *names], capture_output=True, text=True, check=True)
    return {name: set(modules) for name, modules in map(json.loads, run.stdout.splitlines())}


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


def test_a_figure_loads_no_engine_and_what_the_workflow_knows_of():
    """The workflow reruns a figure when a file in its import closure changes: no other module may be loaded."""
    graph = grimp.build_graph("lsvib", cache_dir=None)
    for module, modules in loaded().items():
        closure = graph.find_upstream_modules(module) | {module}
        packages = {parent.rsplit(".", n)[0] for parent in closure for n in range(1, parent.count(".") + 1)}
        assert not {"numba", "matplotlib"} & modules, module
        assert {name for name in modules if name.split(".")[0] == "lsvib"} <= closure | packages, module
