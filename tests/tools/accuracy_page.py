"""Write docs/accuracy.md and its pictures from the datasets of the target `accuracy`, or of another run.

    python tests/tools/accuracy_page.py [results/accuracy] [docs]

Every section says on which commit its dataset was computed.
"""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT)]

from benchmarks.figures.work_precision import RIVALS  # noqa: E402
from lsvib.datasets.io import read_dataset  # noqa: E402
from lsvib.figures.common import flag_names  # noqa: E402
from lsvib.figures.configuration import accuracy_figures, load  # noqa: E402
from lsvib.figures.style import save  # noqa: E402

Rows = list[list[str]]
_RESOLUTION = 150  # dots per inch


def main(results: Path, docs: Path) -> None:
    """Write the page, with a section for each dataset that is there."""
    files = {name: results / "datasets" / f"{name}.nc" for name in accuracy_figures()}
    found = {name: read_dataset(file) for name, file in files.items() if file.is_file()}
    lines = [
        "# Accuracy, speed and stability, measured",
        f"Made by `tests/tools/accuracy_page.py` from datasets of the workflow, on a machine that others use, too "
        f"({_machine(found)}). Times are processor times, with the quartiles of the repeats in brackets. What is "
        "compared, and what it means: [validation](validation.md).",
    ]
    for name, dataset in found.items():
        save(load(name).draw(dataset), docs / "figures" / f"{name}.png", resolution=_RESOLUTION)
        title = dataset.attrs["title"]
        lines += [f"## {title}", f"![{title}](figures/{name}.png)", " ".join(load(name).CAPTION.split())]
        lines += [f"Computed at commit {_described(dataset.attrs['git_commit'])}."]
        lines += ["\n".join(table) for table in TABLES[name](dataset)]
    (docs / "accuracy.md").write_text("\n\n".join(lines) + "\n", encoding="utf-8")


def _described(commit: str) -> str:
    run = subprocess.run(["git", "-C", ROOT, "describe", "--always", commit], capture_output=True, text=True)
    return run.stdout.strip() or commit[:8]


def _machine(found: dict[str, xr.Dataset]) -> str:
    attrs = next((x.attrs for x in found.values() if "processor" in x.attrs), {"processor": "?", "processor_cores": 0})
    return f"{attrs['processor']}, {attrs['processor_cores']} cores"


def _table(head: list[str], rows: Rows) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def _spread(quartiles: np.ndarray, scale: float = 1.0) -> str:
    """A median with its quartiles; a dash where there is none."""
    low, middle, high = (f"{x:.0f}" if x >= 1000 else f"{x:.3g}" for x in scale * np.asarray(quartiles))
    return "–" if middle == "nan" else f"{middle} ({low}–{high})"


def _words(dataset: xr.Dataset, name: str) -> list[str]:
    """The names of the things along a coordinate, in full where it has labels."""
    if "labels" in dataset[name].attrs:
        return dataset[name].attrs["labels"].split("; ")
    names = flag_names(dataset[name])
    return [names[int(k)] for k in dataset[name].values]


def work_precision(d: xr.Dataset) -> Iterator[list[str]]:
    """Scenes with ratios, runs that went wrong, grids, sweeps."""
    level = [int(np.argmin(np.abs(d.error_level.values - x))) for x in (1e-3, 1e-7)]
    present = [k for k in range(d.sizes["rival"]) if np.isfinite(d.ratio[:, k]).any()]
    rivals = [f"{[*RIVALS.values()][k][1]} / lsvib at {x:g}" for k in present for x in d.error_level.values[level]]
    yield _table(
        ["scene", "events", "lsvib [ms]", "error", *rivals],
        [
            [
                title,
                str(int(d.reference_events[s])),
                _spread(d.run_time_quartiles[s, 0, 0], 1e3),
                f"{float(d.state_error[s, 0, 0]):.1e}",
                *(_spread(d.ratio[s, k, x]) for k in present for x in level),
            ]
            for s, title in enumerate(_words(d, "scene"))
        ],
    )
    names, verdicts = _words(d, "method"), flag_names(d.motion_verdict)
    shown = [v for v, word in verdicts.items() if word != "not run"]
    yield _table(
        ["method", *(verdicts[v] for v in shown)],
        [[name, *(str(int((d.motion_verdict[:, k] == v).sum())) for v in shown)] for k, name in enumerate(names)],
    )
    wrong = d.grid_wrong_cells.values
    yield _table(
        ["grid", "cells", "time [s]", "error of the share", "wrong cells"],
        [
            [kind, f"{n}²", _spread(d.grid_time[k, j]), f"{float(d.grid_error[k, j]):.1e}", str(int(wrong[k, j]))]
            for k, kind in enumerate(_words(d, "grid"))
            for j, n in enumerate(d.grid_resolution.values)
        ],
    )  # fmt: skip
    yield _table(
        ["sweep by", "time of one drive [ms]", "error of the amplitude"],
        [[way, _spread(d.way_time[k], 1e3), f"{float(d.way_error[k]):.1e}"] for k, way in enumerate(_words(d, "way"))],
    )


def stability_sweeps(d: xr.Dataset) -> Iterator[list[str]]:
    """Cases by family and verdict, with the largest error."""
    outcomes, errors = _words(d, "outcome"), np.fmax(d.state_error, d.time_error)
    rows = [
        [word, *(str(int(n)) for n in d.case_count[k]), f"{float(errors[d.case_family == family].max()):.1e}"]
        for k, (word, family) in enumerate(zip(_words(d, "edge_family"), d.edge_family.values, strict=True))
    ]
    yield _table(["family", *outcomes, "largest error"], rows)


def ablation(d: xr.Dataset) -> Iterator[list[str]]:
    """Scenes with what they save, and what is compiled and imported."""
    out = dict(part.split(": ") for part in d.attrs["left_out"].split("; "))
    counts = ("modes", "guards", "states", "table_bytes")
    yield _table(
        ["scene", "leaves out", "run time, general / own", "construction, general / own", *counts, "difference"],
        [
            [
                word,
                out[word.replace(" ", "_")],
                _spread(d.run_time_ratio[k]),
                _spread(d.build_time_ratio[k]),
                *(f"{int(d[name][k, 0])} of {int(d[name][k, 1])}" for name in counts),
                f"{float(d.difference[k]):.1e}",
            ]
            for k, word in enumerate(_words(d, "scene"))
        ],
    )
    times = [(word, d.import_time, k) for k, word in enumerate(_words(d, "imported_for"))]
    rows = [[f"import for {word}", f"{float(x[k]):.2f}"] for word, x, k in times]
    if "compiled" in d:
        rows += [[f"compile {word}", f"{float(d.compile_time[k]):.1f}"] for k, word in enumerate(_words(d, "compiled"))]
    yield _table(["what is done anew", "time [s]"], rows)


def rival_verdicts(d: xr.Dataset) -> Iterator[list[str]]:
    """Verdicts on each method."""
    counts = d["count"].sum("edge_family").values
    rows = [[word, *(str(int(n)) for n in counts[k])] for k, word in enumerate(_words(d, "method"))]
    yield _table(["method", *_words(d, "method_outcome")], rows)


def map_precision(d: xr.Dataset) -> Iterator[list[str]]:
    """Labels per second and wrong share of each method in each box."""
    yield _table(
        ["box", "method", "time of a label [ns]", "wrong share"],
        [
            [box, method, _spread(d.time_per_label_quartiles[k, j], 1e9), f"{float(d.wrong_share[k, j]):.1e}"]
            for j, box in enumerate(_words(d, "box"))
            for k, method in enumerate(_words(d, "method"))
        ],
    )


TABLES = {f.__name__: f for f in (work_precision, stability_sweeps, ablation, rival_verdicts, map_precision)}

if __name__ == "__main__":
    given = [Path(word) for word in sys.argv[1:]]
    main(*given, *(ROOT / "results" / "accuracy", ROOT / "docs")[len(given) :])
