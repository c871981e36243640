"""Validation of the configuration, and the source files that a figure depends on."""

import hashlib
import importlib.metadata
import importlib.util
import inspect
import json
import re
import sys
from functools import cache
from pathlib import Path

import grimp
import yaml
from lsvib.datasets.checks import counts, failures, printed_thresholds, read_checks, verdict
from lsvib.errors import LsvibError
from lsvib.models.chapter import listed
from lsvib.models.drive import DRY, PART_OF
from lsvib.models.friction import OF_SPEED
from lsvib.models.scene import read_yaml
from lsvib.figures.configuration import (
    PARTS,
    accuracy_figures,
    check,
    complete_settings,
    default_figures,
    figures_with,
    given,
    module_of,
    selected,
    settings_of,
)
from snakemake.exceptions import WorkflowError
from snakemake.utils import update_config

ROOT = Path(str(workflow.current_basedir)).parents[1]
sys.path[:0] = [str(ROOT / "workflow"), str(ROOT)]
import benchmarks  # with which the references are found, too
import jobs

# What asks Snakemake for a plan, a picture of the rules, a report; it says so itself only after all this is read.
ASKS = re.compile(r"-[npq]*n[npq]*|--(dry-?run|lint|report|rulegraph|filegraph|d3dag|dag|(detailed-)?summary|list)\b.*")
if not (Path("results/verdict.txt").exists() or any(map(ASKS.fullmatch, sys.argv[1:]))):
    jobs.start()  # while Snakemake plans


def typed(values):
    """Return what ``--config`` gives, in which Snakemake leaves the numbers inside of lists and mappings as text."""
    if isinstance(values, dict):
        return {key: typed(value) for key, value in values.items()}
    if isinstance(values, list):
        return [typed(value) for value in values]
    try:
        return yaml.safe_load(values) if isinstance(values, str) else values
    except yaml.YAMLError:
        return values


try:
    update_config(config, typed(dict(workflow.config_settings.config)))
    for file in workflow.configfiles:
        read_yaml(file)  # refuses a key that is given twice, of which Snakemake would take the last
    check(config)
except LsvibError as error:
    raise WorkflowError(f"Configuration: {error}") from None

# What is built: the figures of the default target and those of the target `accuracy`; the configuration may leave some
# out.
FIGURES = selected(config)
ACCURACY_FIGURES = selected(config, "accuracy_figures")

# What the jobs import of ours besides the module of their figure, and what no dataset depends on.
BUILD = "lsvib.figures.build"
DRAWING = {"lsvib.figures.style", "lsvib.figures.drawing"}

# The region of attraction and the chart but for their tiles. In alphabetical order, because Snakemake compares parameters as text, and a
# second configuration file changes the order.
MAP, CHART = (
    json.loads(json.dumps({k: v for k, v in given(config, name).items() if k != "tiles"}, sort_keys=True))
    for name in ("attraction", "chart")
)


# Our packages and the folders that they are in.
FOLDERS = {"lsvib": "src", "benchmarks": ".", "references": "tests"}


@cache
def import_graph():
    """Return who imports whom in our packages; refuse an lsvib that is not the one beside this Snakefile."""
    graph = grimp.build_graph(*FOLDERS, exclude_type_checking_imports=True, cache_dir=None)
    source = Path(ROOT, "src", "lsvib", "__init__.py").resolve()
    found = Path(importlib.util.find_spec("lsvib").origin).resolve()
    if found != source:
        raise WorkflowError(f"The lsvib that Python imports is {found}, not {source}: run pip install -e . here.")
    return graph


@cache
def imports(module):
    """Return the modules of our packages that ``module`` imports, directly or not, itself included."""
    graph = import_graph()
    if module not in graph.modules:
        raise WorkflowError(f"The module {module} does not exist.")
    return frozenset(graph.find_upstream_modules(module) | {module})


@cache
def files_of(module):
    """Return the files of a module and of the packages around it, relative to the working directory.

    Templates, words and the style of a page lie beside the module that reads them, and begin with its name. Claims,
    beside the module that reads them, are a parameter of the rules that judge them instead.
    """
    parts = module.split(".")
    around = {Path(FOLDERS[parts[0]], *parts[:n], "__init__.py") for n in range(1, len(parts))}
    package = Path(FOLDERS[parts[0]], *parts, "__init__.py")
    file = package if package.exists() else Path(FOLDERS[parts[0]], *parts).with_suffix(".py")
    kinds = ("css", "j2") if module == "lsvib.models.chapter" else ("css", "j2", "yaml")
    beside = (path for kind in kinds for path in file.parent.glob(f"{file.stem}*.{kind}"))
    return {str(path) for path in (*around, file, *beside)}


def source_files(modules):
    """Return the files of several modules, as :func:`files_of` those of one."""
    return sorted(set().union(*map(files_of, modules)))


def code(job):
    """Return a digest of the source of a function of jobs.py: a parameter of its rule, so that an edit reruns that rule."""
    return hashlib.sha256(inspect.getsource(job).encode()).hexdigest()[:16]


@cache
def drawn_from(module):
    """Return the modules that a picture depends on: that of its figure, and those beside it that it imports."""
    found, rest = set(), {module}
    while rest:
        found |= rest
        beside = set().union(*map(import_graph().find_modules_directly_imported_by, rest))
        rest = {name for name in beside if name.startswith("lsvib.figures.")} - found
    return frozenset(found)


def figure_sources(kind, figure):
    """Return the source files of the figure's dataset or picture; a picture is drawn from its dataset alone."""
    own = module_of(figure)
    if kind == "figures":
        return source_files(drawn_from(own) | imports(BUILD))
    found = frozenset().union(*map(imports, (own, *settings_of(figure).needs, BUILD))) - DRAWING
    return source_files(found)


def sources(kind):
    """Return :func:`figure_sources` as an input function."""
    return lambda wildcards: figure_sources(kind, wildcards.figure)


def parts(wildcards):
    """Return the files of the parts of a figure that have rules of their own, by name: its analysis and its maps."""
    return {name: f"results/{name}/{wildcards.figure}.nc" for name in PARTS if wildcards.figure in figures_with(name)}


@cache
def quoted(file):
    """Return the names in quotation marks in a file."""
    return frozenset(re.findall(r'"(?=([\w.]+)")', Path(file).read_text(encoding="utf-8")))


@cache
def claims_in(files):
    """Return a digest of the claims whose ids stand in some source files: a parameter of the rules that judge them."""
    names = frozenset().union(*map(quoted, files))
    named = [entry for part in listed().values() for entry in part if entry.get("id") in names]
    return hashlib.sha256(json.dumps(named).encode()).hexdigest()[:16]


def claims(wildcards):
    """Return the digest of the claims that a figure checks."""
    return claims_in(tuple(figure_sources("datasets", wildcards.figure)))


def part_sources(module):
    """Return, as an input function, the source files of such a part, which is made by ``module`` for each figure."""
    return lambda wildcards: source_files(imports(module) | {module_of(wildcards.figure), BUILD})


# The parts of the engine, and the modules of which a figure that runs the engine imports one if it needs the part.
ENGINE = {
    "rule": ("lsvib.dynamics.attractor",),
    "planar": ("lsvib.engine.kernels.jit",),  # all compiled code imports it
    "modal": (),
    "mapper": ("lsvib.basins.labels",),
    "taylor": (),  # both of figures that say so, `flows` of their settings
}

CALLED = {"rule": (), "modal": (), "planar": ("rule",), "taylor": ("rule",), "mapper": ("planar",)}
"""The parts whose kernels a part calls, so that they are compiled before it."""


def flows_of(drive):
    """Return the flows that the motions of a drive have besides that of rigid drives; ``drive``: names and values."""
    flows = {"modal": (*PART_OF, *DRY), "taylor": OF_SPEED}
    return [flow for flow, names in flows.items() if not drive.keys().isdisjoint(names)]


def marker(part):
    """Return the file that says that a part of the engine is compiled."""
    return f"results/engine/{part}.txt"


def engine(modules, flows=()):
    """Return the markers of the parts of the engine that modules run; none if they reach no compiled code.

    ``flows``: those that the motions have besides that of rigid drives.
    """
    if "lsvib.engine.kernels.jit" not in modules:
        return []
    parts = [part for part, roots in ENGINE.items() if not modules.isdisjoint(roots)]
    return [marker(part) for part in [*parts, *flows]]


def cores(wildcards):
    """Return the cores of a job of `accuracy`: all of them if run times are measured, so that nothing runs beside it."""
    return workflow.cores if settings_of(wildcards.figure).timed else 1


def settings(wildcards):
    """Return the section of the figure; what it does not name has the defaults of its ``Settings``."""
    return given(config, wildcards.figure)


def accuracy_settings(wildcards):
    """Return the same for the target `accuracy`."""
    return given(config, wildcards.figure, accuracy=True)


def category(wildcards):
    """Return the part of the report in which the figure is."""
    if wildcards.figure.startswith("fig8_"):
        return "Chapter 8"
    return "Accuracy and cost" if wildcards.figure in accuracy_figures() else "Beyond the chapter"


def remove_leftovers():
    """Remove temporary files of runs that were killed; a run that ended well has none of its own."""
    for part in Path("results").rglob(".*.part"):
        part.unlink(missing_ok=True)


def print_results(started, log=None):
    """Print what failed, the printed thresholds, the checks of this run by figure, and last one line of summary.

    ``log``: the logs of Snakemake, in which the jobs that failed are looked up; None if none did.
    """
    failed = failed_jobs(log) if log else []
    words = f"{len(failed)} job{'s' * (len(failed) > 1)} FAILED: {', '.join(name for name, _ in failed)}."
    summary = [words] if failed else []
    for name, reason in failed:
        print(f"\nFAILED {name}: {reason}")
    for folder in ("results", "results/accuracy"):
        records = Path(folder, "checks.json")
        if records.exists() and records.stat().st_mtime >= started:
            checks = read_checks(records)
            print("\n".join(["", *failures(checks), *printed_thresholds(checks), counts(checks)]))
            places = f"{folder}/figures   datasets: {folder}/datasets   every check: {folder}/checks.md, .json"
            print(f"Figures: {places}")
            summary.append(verdict(checks))
    print("\n" + " ".join(summary or ["The run FAILED; the reason stands above." if log else "Done."]))


def judge_alone(started):
    """Raise an error about the checks that failed of figures built in this run without the verdict on all.

    Their pictures go to ``results/failed``, so that the next run does not take them for good.
    """
    wrong = []
    for records in sorted(Path("results").glob("**/checks/*.json")):
        pictures = sorted(records.parents[1].glob(f"figures/{records.stem}.*"))
        failed = failures(read_checks(records))
        if failed and any(file.stat().st_mtime >= started for file in (records, *pictures)):
            wrong += failed
            aside = Path("results/failed")
            aside.mkdir(exist_ok=True)
            for picture in pictures:
                picture.rename(aside / picture.name)
    if wrong:
        count = f"{len(wrong)} check{'s' * (len(wrong) > 1)} failed"
        raise WorkflowError("\n".join([f"{count}; the pictures lie in results/failed.", *wrong]))


def origins(figures, accuracy=False):
    """Return of each dataset that figures have the settings and the digest of the sources that make it, by its file.

    A draft notes no sources. Snakemake compares times alone where it has no record of how a file came about, as of one
    that was copied; so the verdict compares these.
    """
    folder = "results/accuracy/datasets" if accuracy else "results/datasets"
    return {
        f"{folder}/{figure}.nc": (
            json.dumps(complete_settings(figure, given(config, figure, accuracy=accuracy))),
            None if config.get("draft") else jobs.digest(figure_sources("datasets", figure)),
        )
        for figure in figures
    }


def forget_verdict(marker):
    """Remove a verdict that does not hold any more, so that all is judged again.

    A dry run removes it, too, since nothing says at this point that it is one.
    """
    if Path(marker).exists() and jobs.foreign(origins(FIGURES)):
        Path(marker).unlink()


def failed_jobs(log):
    """Return the name of each job that failed and the last line of its log."""
    logs = [log] if isinstance(log, str) else log
    text = "".join(Path(file).read_text(encoding="utf-8", errors="replace") for file in logs)
    failed = {}
    for block in re.findall(r"^Error in \w+ .+\n(?: .*\n)*", text, re.MULTILINE):
        file = re.search(r"^    log: (\S+)", block, re.MULTILINE)
        written = file and Path(file[1]).exists()
        lines = Path(file[1]).read_text(encoding="utf-8", errors="replace").split("\n") if written else []
        reasons = [line for line in lines if line.strip()]
        name = Path(file[1]).with_suffix("").relative_to("logs").as_posix() if file else block.split()[3].rstrip(":,")
        failed[name] = reasons[-1] if reasons else "its log is empty; Snakemake says more above"
    return list(failed.items())
