"""Write docs/accuracy.md and its pictures from the datasets of the target `accuracy`, or of another run.

    python benchmarks/accuracy_page.py [results/accuracy] [docs]

It says at which commits the datasets were computed.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import xarray as xr

ROOT = Path(__file__).parents[1]
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
    commits = ", ".join(sorted({_described(dataset.attrs["git_commit"]) for dataset in found.values()}))
    lines = [
        "# Accuracy, speed and stability, measured",
        f"Made by `benchmarks/accuracy_page.py` from datasets of the workflow, on a machine that others use, too "
        f"({_machine(found)}). Times are processor times, with the quartiles of the repeats in brackets. What is "
        f"compared, and what it means: [validation](validation.md). Computed at commit {commits}.",
    ]
    for name, dataset in found.items():
        save(load(name).draw(dataset), docs / "figures" / f"{name}.png", resolution=_RESOLUTION)
        title = dataset.attrs["title"]
        lines += [f"## {title}", f"![{title}](figures/{name}.png)", " ".join(load(name).CAPTION.split())]
        lines += ["\n".join(TABLES[name](dataset))] if name in TABLES else []
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


def work_precision(d: xr.Dataset) -> list[str]:
    """Scenes with errors and ratios; the picture has the rest."""
    level = [int(np.argmin(np.abs(d.error_level.values - x))) for x in (1e-3, 1e-7)]
    present = [k for k in range(d.sizes["rival"]) if np.isfinite(d.ratio[:, k]).any()]
    rivals = [f"{[*RIVALS.values()][k][1]} / lsvib at {x:g}" for k in present for x in d.error_level.values[level]]
    return _table(
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


def stability_sweeps(d: xr.Dataset) -> list[str]:
    """Cases by family and verdict, with the largest error."""
    outcomes, errors = _words(d, "outcome"), np.fmax(d.state_error, d.time_error)
    rows = [
        [word, *(str(int(n)) for n in d.case_count[k]), f"{float(errors[d.case_family == family].max()):.1e}"]
        for k, (word, family) in enumerate(zip(_words(d, "edge_family"), d.edge_family.values, strict=True))
    ]
    return _table(["family", *outcomes, "largest error"], rows)


def ablation(d: xr.Dataset) -> list[str]:
    """Scenes with what they save."""
    out = dict(part.split(": ") for part in d.attrs["left_out"].split("; "))
    counts = ("modes", "guards", "states", "table_bytes")
    return _table(
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


TABLES = {f.__name__: f for f in (work_precision, stability_sweeps, ablation)}

if __name__ == "__main__":
    given = [Path(word) for word in sys.argv[1:]]
    main(*given, *(ROOT / "results" / "accuracy", ROOT / "docs")[len(given) :])
