"""The jobs of the rules, each in a process of its own that starts with all libraries loaded.

To start Python and to load numba, xarray, matplotlib and lsvib takes longer than most figures do. So one process, the
fork server of the standard library, loads them once, and every job is a copy of it. It only imports: no thread runs
in it, and what a job changes dies with the job. After an edit in the middle of a run jobs load lsvib anew.
"""

import multiprocessing
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from multiprocessing import connection, forkserver
from pathlib import Path
from typing import Any

from snakemake.exceptions import WorkflowError

_LIBRARIES = [  # that most jobs load
    *("numba", "numba.cpython.setobj", "numba.np.linalg", "numba.np.npyimpl", "numba.typed.typeddict"),
    *("netCDF4", "scipy.linalg", "xarray"),
    "pint",  # which xarray loads as soon as it computes
    *("matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf", "matplotlib.figure"),
    "snakemake.exceptions",  # which this module loads
    *("lsvib.figures.build", "lsvib.figures.drawing", "lsvib.dynamics.attractor", "lsvib.stability.boundaries"),
]
# When a file of lsvib last changed; each job looks anew.
_FILES = (file for kind in ("py", "yaml", "j2", "css") for file in Path(__file__).parents[1].glob(f"src/**/*.{kind}"))
_CHANGED = max((file.stat().st_ctime_ns for file in _FILES if file.is_file()), default=0)

# One thread for linear algebra in each job, as Snakemake gives to scripts: matrices are small, and jobs fill the cores.
os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
vars(sys.modules["__main__"]).pop("__file__", None)  # else each process would load the main module, all of Snakemake
_PROCESSES = multiprocessing.get_context("forkserver")
_PROCESSES.set_forkserver_preload(_LIBRARIES)
Texts = list[str]
_TURN = threading.Lock()  # multiprocessing starts and reaps processes in one thread at a time; Snakemake has several


def start() -> None:
    """Start loading the libraries, before the first job needs them."""
    forkserver.ensure_running()


def run(job: Callable[..., None], log: str, subject: str, *arguments: Any) -> None:
    """Run ``job(*arguments)`` in a process of its own and wait for it; raise ``WorkflowError`` if it fails.

    What it says goes to the file ``log``; an error of ours is one sentence there, after its ``subject``. The file of
    the same name in the folder ``results/benchmarks`` gets its time and its memory.
    """
    process = _PROCESSES.Process(target=_run, args=(_CHANGED, job, log, subject, arguments))
    with _TURN:
        try:
            process.start()
        except (OSError, EOFError) as error:  # the fork server has ended; it says why on stderr
            raise WorkflowError(f"The process of the job did not start: {error}.") from None
    connection.wait([process.sentinel])
    with _TURN:
        process.join()
    if process.exitcode:
        killed = process.exitcode < 0
        ended = f"was ended by a signal: {signal.strsignal(-process.exitcode)}" if killed else "failed"
        raise WorkflowError(f"The job {ended}.")


def _run(loaded: int, job: Callable[..., None], log: str, subject: str, arguments: tuple[Any, ...]) -> None:
    started = time.perf_counter()
    if loaded != _CHANGED:
        for name in [name for name in sys.modules if name.partition(".")[0] == "lsvib"]:
            del sys.modules[name]
    sys.stderr = open(log, "w", buffering=1)  # noqa: SIM115 (until the process ends)
    from lsvib.errors import LsvibError
    from lsvib.files import write_text

    try:
        job(*arguments)
    except LsvibError as error:
        sys.exit(f"{subject}: {error}")
    except KeyboardInterrupt:
        sys.exit("interrupted")
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    seconds, cpu = time.perf_counter() - started, sum(part.ru_utime + part.ru_stime for part in used)
    memory = max(part.ru_maxrss for part in used) / (2**20 if sys.platform == "darwin" else 2**10)
    benchmark = Path("results/benchmarks", Path(log).relative_to("logs")).with_suffix(".tsv")
    with suppress(OSError, LsvibError):  # what the job has made is good without it
        benchmark.parent.mkdir(parents=True, exist_ok=True)
        write_text(f"s\tcpu_time\tmax_rss [MB]\n{seconds:.2f}\t{cpu:.2f}\t{memory:.0f}\n", benchmark)


# Each of them imports what it needs when it runs, and nothing else.


def compile_engine(part: str, sources: Texts, marker: str) -> None:
    """Compile one part of the engine, and note the digest of its inputs."""
    from lsvib import Drive
    from lsvib.files import write_text

    if part == "mapper":
        from lsvib.basins.grid import Grid
        from lsvib.basins.mapper import mapper

        one = {"start": -1.0, "stop": 1.0, "count": 1}
        mapper(Drive()).cells(Grid.of({"u": one, "w": one}), quantities=("label",))
    elif part == "rule":
        from lsvib.dynamics.attractor import compile_rule

        compile_rule()
    else:
        from lsvib.dynamics.energy import balance
        from lsvib.engine import motion

        if part != "taylor":
            motion.compile_engine((part,))
        threads, law = dict(contact_stiffness=1e8, contact_damping=1e8), dict(stribeck_rise=0.02, stribeck_speed=0.01)
        drive = Drive(mass=11, **{"modal": threads, "taylor": law}.get(part, {}))
        cycle = drive.steady_state({"u": 0.1, "w": 0.0})
        _ = cycle.amplitude, balance(drive, cycle.orbit), cycle.orbit.at([0.0])  # what figures ask of a cycle
        if part == "planar":
            drive.sweep(axial_force=[50.0])
    write_text(f"{digest(sources)}\n", marker)


def part(figure: str, name: str, settings: dict[str, Any], file: str) -> None:
    """Compute the analysis of the drives of a figure, or its maps of grids of starts."""
    from lsvib.figures.build import compute_part

    compute_part(figure, name, settings, file)


def digest(files: Iterable[str]) -> str:
    """Return the digest of the contents of some files."""
    import hashlib

    return hashlib.sha256(b"".join(Path(file).read_bytes() for file in files)).hexdigest()


def dataset(figure: str, settings: dict[str, Any], inputs: Any, outputs: Texts) -> None:
    """Compute the dataset of a figure and its checks; it carries the digest of its sources, some of the inputs."""
    from lsvib.figures.build import compute_figure
    from lsvib.figures.configuration import PARTS

    file, checks = outputs
    parts = {name: str(inputs[name]) for name in PARTS if inputs.get(name)}
    compute_figure(figure, settings, file, checks, parts, digest(inputs["sources"]))


def picture(figure: str, dataset: str, png: str, pdf: str, caption: str) -> None:
    """Draw a figure from its dataset; of a map or a chart, a large one from the middle cells of blocks of cells."""
    from lsvib.figures.build import draw_figure

    draw_figure(figure, dataset, png, pdf, caption)


def draft(figures: dict[str, dict[str, Any]], datasets: Texts, checks: Texts, pngs: Texts, captions: Texts) -> None:
    """Compute several figures and draw them, without the PDF of an earlier full run."""
    from lsvib.errors import LsvibError
    from lsvib.figures.build import DRAFT, build_figure

    files = zip(datasets, checks, pngs, captions, strict=True)
    for (figure, settings), (dataset, judged, png, caption) in zip(figures.items(), files, strict=True):
        try:
            build_figure(figure, settings, dataset, judged, png, caption=caption, resolution=DRAFT)
        except LsvibError as error:
            sys.exit(f"{figure}: {error}")
        Path(png).with_suffix(".pdf").unlink(missing_ok=True)


def all_checks(files: Texts, outputs: Texts, listed: str | None) -> None:
    """Collect the checks of all figures: for programs, as a text, and the printed numbers.

    ``listed``: the file of what the chapter states, for figures of the chapter.
    """
    from lsvib.datasets.checks import read_checks, report
    from lsvib.datasets.statements import read_statements
    from lsvib.files import write_json, write_text

    json, text, printed = outputs
    checks = [pair for file in files for pair in read_checks(file)]
    write_json([{"figure": figure, **check.to_json()} for figure, check in checks], json)
    statements = read_statements(listed) if listed else None
    for form, file in (("md", text), ("rst", printed)):
        write_text(report(form, checks, statements), file)


def foreign(origins: dict[str, tuple[str, str | None]]) -> Texts:
    """Return a sentence for each dataset that other settings or other sources have made, or that is damaged.

    ``origins``: by file the settings and the digest of the sources, None if these are not compared.
    """
    from lsvib.datasets.io import read_dataset
    from lsvib.errors import LsvibError

    found = []
    for file, (settings, sources) in origins.items():
        try:
            made = read_dataset(file).attrs
        except LsvibError as error:
            found.append(str(error))
            continue
        if made.get("settings") != settings:
            found.append(f"{file} was made with another configuration; delete it, and run again what makes it.")
        elif sources and made.get("sources_sha256") != sources:
            found.append(f"{file} was made by other sources; delete it, and run again what makes it.")
    return found


def verdict(file: str, origins: dict[str, tuple[str, str | None]], marker: str) -> None:
    """Fail with one sentence for each check that failed, and each dataset that was not made here."""
    from lsvib.datasets import checks
    from lsvib.files import write_text

    if others := foreign(origins):
        sys.exit("\n".join(others))
    judged = checks.read_checks(file)
    failed = checks.failures(judged)
    if failed:
        sys.exit("\n".join([f"{len(failed)} of {len(judged)} checks failed:", *failed]))
    write_text(f"{checks.verdict(judged)}\n", marker)


def first_cell(settings: dict[str, Any], marker: str) -> None:
    """Map one cell of the region of attraction and note its label."""
    from lsvib.basins.grid import Grid
    from lsvib.datasets.map import mapper_of
    from lsvib.files import write_text

    cells = mapper_of(settings).cells(Grid.of(settings["grid"]), slice(0, 1), slice(0, 1), settings["quantities"])
    write_text(f"{cells['label'].item()}\n", marker)


def map_tile(settings: dict[str, Any], item: str, file: str, workers: int) -> None:
    """Map one tile of the region of attraction."""
    from lsvib.datasets.map import map_tile

    map_tile(settings, item, file, workers)


def whole_map(settings: dict[str, Any], tiles: Texts, file: str) -> None:
    """Put the tiles of the region of attraction together."""
    from lsvib.datasets.map import gather_map

    gather_map(settings, tiles, file)


def chart(settings: dict[str, Any], file: str, workers: int) -> None:
    """Chart what a drive does over two of its parameters."""
    from lsvib.datasets.sweep import write_chart

    write_chart(settings, file, workers)


def assess(sheet: str, page: str, samples: int) -> None:
    """Assess one drive from its data sheet."""
    from lsvib.assess.output import assess_file

    assess_file(Path(sheet), Path(page).parent, samples=samples)


def compare(verdicts: Texts, page: str, table: str) -> None:
    """Put the verdicts on all drives in one table."""
    from lsvib.assess.report import compare

    compare([Path(file) for file in verdicts], Path(page), Path(table))
