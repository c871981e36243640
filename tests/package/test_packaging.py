"""What the README and the metadata promise about set-up: two lines, complete pins, one version; the wheel; imports.

What a command loads: no engine for eigenvalues, no matplotlib for data, nothing heavy before it is needed. And what
judges the library stands on nothing of it: references import only each other and mathematics. ``lint-imports`` (run by
.ci/run) holds the rooms to their contracts; here it is seen what Python really loads.
"""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import requires, version
from pathlib import Path

import pytest
import yaml
from references.drives import GIVEN
from references.figure_checks import coarse
from tools.codemeta import author, codemeta

import lsvib
from lsvib.chapter.configuration import FIGURES, PARTS, module_of

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LINES = (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines()
PINS = dict(line.split("==") for line in LINES if "==" in line)
FOLDERS = (".ci", "benchmarks", "config", "docs", "examples", "paper", "profiles", "src", "tests", "workflow")


def normal(text: str) -> str:
    """The name of a package in a requirement, as indexes compare it."""
    return re.sub(r"[-_.]+", "-", re.split(r"[>=<!~\[; (]", text)[0]).lower()


@pytest.mark.parametrize("program", ["snakemake -j2", "pytest"])
def test_readme_has_the_line(program):
    line = f"python3 -m venv .venv && .venv/bin/pip install -r requirements.txt && .venv/bin/{program}"
    assert (ROOT / "README.md").read_text(encoding="utf-8").splitlines().count(line) == 1
    assert program.split()[0] in PINS


def test_requirements_lock_what_the_two_commands_need():
    """What the project declares for them, and all that this needs in turn, but what other platforms need."""
    extras = PROJECT["optional-dependencies"]
    declared = [*PROJECT["dependencies"], *extras["workflow"], *extras["assess"], *extras["test"]]
    needed, open_ones = set(), {normal(text) for text in declared}
    while open_ones:
        needed |= open_ones
        texts = [text for name in open_ones for text in requires(name) or [] if ";" not in text]
        open_ones = {normal(text) for text in texts} - needed
    pinned = {normal(name) for name in PINS}
    assert needed <= pinned
    least = {text.replace(">=", "==") for text in declared} - {"numba==0.64.0"}  # of which the oldest was tried
    assert least <= set(LINES)


def test_the_version_is_in_one_place_and_the_others_agree():
    assert version("lsvib") == lsvib.__version__
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (cited["version"], cited["license"]) == (lsvib.__version__, PROJECT["license"])
    heading = re.search(rf"^## {lsvib.__version__} – (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert heading[1] in ("unreleased", str(cited["date-released"]))
    assert json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8")) == codemeta()
    names = author({"family-names": "Curie", "given-names": "Marie"})
    assert names == {"@type": "Person", "givenName": "Marie", "familyName": "Curie"}


def test_files_that_a_text_names_are_there():
    """Paths within the repository in all its texts, programs and tables; in pages modules by their names alone, too."""
    texts = [*ROOT.glob("*.md"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.*"))]
    texts = [path for path in texts if path.suffix in {".md", ".rst", ".py", ".yaml", ".smk"}]
    modules = {path.name for path in texts}
    for text in texts:
        content = text.read_text(encoding="utf-8")
        for path in re.findall(rf"(?<![\w/.:-])((?:{'|'.join(map(re.escape, FOLDERS))})/[\w./-]*\w)", content):
            assert (ROOT / path).exists() or (text.parent / path).exists(), f"{text}: {path}"
        if text.suffix == ".md":
            assert set(re.findall(r"`(\w+\.(?:py|smk))`", content)) <= modules, text


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
    python("-m", "lsvib", "figure", "8.3", "--out", "built", folder=tmp_path, path=site)
    assert (tmp_path / "built" / "fig8_03.png").is_file()


CHEAP = ("fig8_01", "fig8_03", "fig8_04", "fig8_07", "fig8_08", "fig8_09", "fig8_11", "fig8_15")  # of each module one
WITHOUT_ENGINE = [
    "--help",
    "config",
    *(" ".join(("stability", *given)) for given in GIVEN.values()),
    " ".join(("thresholds", "--solve", "flutter", *GIVEN["threads"])),
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
FIGURE = """
import os, sys
from importlib import import_module
import numba, numpy, xarray, netCDF4, mpmath, pydantic
import_module("lsvib.chapter.settings")  # every figure has some
code, *figures = sys.argv[1:]
for name, figure in map(str.split, figures):
    if not os.fork():
        module = import_module(name)
        exec(code, {"figure": figure, "module": getattr(module, figure, module)})
        sys.exit("matplotlib" in sys.modules and f"{figure} loads matplotlib")
    if os.wait()[1]:
        sys.exit(f"{figure} has failed")
"""


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_dataset_is_built_without_matplotlib():
    """Each in a copy of one process, which has loaded what else is heavy."""
    settings = {figure: coarse(figure) for figure in CHEAP}
    own = f"{{part: getattr(module, part)({settings!r}[figure]) for part in {PARTS} if hasattr(module, part)}}"
    code = f"module.build({settings!r}[figure], **{own}) if figure in {CHEAP!r} else None"
    command = [sys.executable, "-c", FIGURE, code, *(f"{module_of(name)} {name}" for name in FIGURES)]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (0, "")


REFERENCES = Path(__file__).parents[1] / "references"
JUDGES = ("bodies", "newton", "rigid_digits", "series", "threshold_digits")
KNOWN = {"flint", "mpmath", "numpy", "scipy.linalg", "scipy.optimize"}
STANDARD = {"collections", "dataclasses", "itertools", "math", "operator", "re", "typing"}


@pytest.mark.parametrize("name", JUDGES)
def test_a_reference_imports_nothing_that_it_judges(name):
    tree = ast.parse((REFERENCES / f"{name}.py").read_text(encoding="utf-8"))
    found = {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    found |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level}
    found |= {f"references.{n.module}" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level}
    ours = {f"references.{judge}" for judge in JUDGES}
    assert {module for module in found if module.split(".")[0] not in STANDARD} <= ours | KNOWN
