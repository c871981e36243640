"""What a module loads: no engine for eigenvalues, no matplotlib for data, no engine for pictures; import contracts."""

import ast
import json
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import grimp
import pytest

from lsvib.figures.folders import accuracy_figures, dataset_module, default_figures, picture_module

ROOT = Path(__file__).parents[2]
PACKAGE = Path(find_spec("lsvib").origin).parent
FIGURES = [*default_figures(), *accuracy_figures()]
EIGENVALUES = ["fig8_01", "fig8_02", "fig8_03", "fig8_08", "fig8_15"]
FIGURE_ROOMS = ("figures", "bench/figures")
PACKAGES = sorted(
    ".".join(("lsvib", *init.parent.relative_to(PACKAGE).parts)) for init in PACKAGE.glob("**/__init__.py")
)
HEAVY = {"numba", "matplotlib", "xarray", "scipy", "pydantic", "netCDF4"}


# Loaded before the modules in question, each of which then costs a tenth of a second; nothing that is looked for.
DATASETS_NEED = "numpy, xarray, netCDF4, mpmath, pydantic, numba"
FIGURES_NEED = "numpy, xarray, netCDF4, mpmath, matplotlib, matplotlib.figure, matplotlib.backends.backend_agg"
PROGRAM = """
import json, os, sys
from importlib import import_module
for name in sys.argv[1:]:
    sys.stdout.flush()
    if not os.fork():
        import_module(name)
        print(json.dumps([name, list(sys.modules)]), flush=True)
        os._exit(0)
    if os.wait()[1]:
        sys.exit(1)
"""


@cache
def loaded(names: tuple[str, ...], before: str = "sys") -> dict[str, frozenset[str]]:
    """Names of all modules that Python has loaded after each module, which is imported in a process of its own."""
    program = f"import {before}\n{PROGRAM}"
    run = subprocess.run([sys.executable, "-c", program, *names], capture_output=True, text=True, check=True)
    return {name: frozenset(modules) for name, modules in map(json.loads, run.stdout.splitlines())}


def after_dataset(figure: str) -> frozenset[str]:
    return loaded(tuple(dataset_module(n) for n in FIGURES), DATASETS_NEED)[dataset_module(figure)]


def after_figure(figure: str) -> frozenset[str]:
    return loaded(tuple(picture_module(n) for n in FIGURES), FIGURES_NEED)[picture_module(figure)]


@cache
def import_graph() -> grimp.ImportGraph:
    return grimp.build_graph("lsvib", cache_dir=None)


def test_every_figure_is_configured_and_has_both_modules():
    """What has ``build`` makes the dataset of a figure, what has ``draw`` its picture; all of it is configured."""
    for file, function in (("dataset", "build"), ("picture", "draw")):
        paths = [path for room in FIGURE_ROOMS for path in (PACKAGE / room).glob(f"*/{file}.py")]
        found = {path.parent.name for path in paths if f"\ndef {function}(" in path.read_text(encoding="utf-8")}
        assert found - {"attraction", "chart"} == set(FIGURES)  # a map and charts have targets of their own
    assert len(FIGURES) == len(set(FIGURES))
    assert {f"fig8_{n:02}" for n in range(1, 16)} <= set(FIGURES)


def test_the_package_itself_loads_nothing_heavy():
    assert not frozenset().union(*loaded(tuple(PACKAGES)).values()) & HEAVY


def test_no_engine_where_none_is_needed():
    tables = [
        ".".join(("lsvib", *p.relative_to(PACKAGE).with_suffix("").parts)) for p in PACKAGE.glob("drives/**/*.py")
    ]
    modules = (
        *(dataset_module(n) for n in EIGENVALUES),
        *(name for name in tables if not name.endswith("__init__")),
        "lsvib.engine.exact.flow_choice",
        "lsvib.steady_sliding.eigenvalues_rigid",
        "lsvib.data.writer",
    )
    found = loaded(modules, "numpy, xarray, netCDF4, mpmath, pydantic")
    assert len(found) == len(modules)
    assert not [module for module in modules if "numba" in found[module]]


@pytest.mark.parametrize("figure", FIGURES)
def test_dataset_modules_load_no_matplotlib(figure):
    assert "matplotlib" not in after_dataset(figure)


@pytest.mark.parametrize("figure", FIGURES)
def test_figure_modules_load_no_engine(figure):
    assert not after_figure(figure) & {"numba", "matplotlib.pyplot", "scipy"}


@pytest.mark.parametrize("folder", ["datasets", "figures"])
@pytest.mark.parametrize("figure", FIGURES)
def test_what_is_loaded_is_known_to_the_workflow(folder, figure):
    """The workflow reruns a figure when a file in its import closure changes: no module may be loaded outside of it."""
    name = {"datasets": dataset_module, "figures": picture_module}[folder](figure)
    closure = import_graph().find_upstream_modules(name) | {name}
    packages = {parent.rsplit(".", n)[0] for parent in closure for n in range(1, parent.count(".") + 1)}
    found = after_dataset(figure) if folder == "datasets" else after_figure(figure)
    ours = {m for m in found if m == "lsvib" or m.startswith("lsvib.")}
    assert name in ours
    assert ours <= closure | packages


def test_import_contracts_hold():
    command = [str(Path(sys.executable).with_name("lint-imports")), "--no-cache"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout
    assert "0 broken" in run.stdout


def test_kernels_need_no_linear_algebra():
    """numba's products and solutions of matrices call scipy, which the runtime does not install."""
    for path in PACKAGE.glob("**/kernels/*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            product = isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult)
            assert not product, f"{path.name}:{node.lineno} multiplies matrices"
            named = isinstance(node, ast.Attribute) and node.attr in {"dot", "vdot", "linalg", "matmul"}
            assert not named, f"{path.name}:{node.lineno} uses {getattr(node, 'attr', '')}"


def test_nothing_lets_xarray_interpolate():
    """Its interpolation calls scipy, which only assessments and benchmarks have."""
    for path in PACKAGE.rglob("*.py"):
        if path.relative_to(PACKAGE).parts[0] in ("assess", "bench"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr in {"interp", "interp_like", "interpolate_na"}:
                assert ast.unparse(node.value) == "np", f"{path.name}:{node.lineno} uses {node.attr}"
