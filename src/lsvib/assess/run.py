"""Assess one data sheet and write the report, the dataset and the JSON file: all of them or none."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from lsvib.assess.assessment import as_json, assess
from lsvib.assess.chart import charts
from lsvib.assess.dataset import dataset
from lsvib.assess.report import report
from lsvib.assess.sheet import Sheet
from lsvib.assess.uncertainty import BLOCK, compute_blocks
from lsvib.datasets.writer import write_dataset
from lsvib.errors import InputError
from lsvib.files import Outputs, write_json, write_text

_MOST = 2**30  # samples: a thousand million
_LARGEST_SEED = 2**32 - 1


def assess_file(
    path: Path,
    out: Path,
    samples: int = BLOCK,
    seed: int = 1,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Assess the data sheet in a YAML file; write ``index.html``, ``assessment.nc``, ``assessment.json`` to ``out``.

    ``samples``: a power of two; blocks of them that are finished are kept in the folder ``.samples`` of ``out`` until
    the files are written, so that a run that was stopped goes on. Returns what ``assessment.json`` holds. Raises
    ``InputError`` or another ``LsvibError`` in one sentence; then nothing is written.
    """
    _require_samples(samples, seed)
    sheet = Sheet.read(path)
    files = [(out / "index.html", "HTML"), (out / "assessment.nc", "netCDF"), (out / "assessment.json", "JSON")]
    outputs = Outputs(files, [path], make_folders=True)
    folder = out / ".samples" if samples > BLOCK else None
    found = assess(sheet, samples, seed, threads, folder, progress)
    operating = charts(sheet, found.values)
    result = as_json(found)
    with outputs.writing() as (page, data, verdict):
        write_text(report(found, operating), page)
        write_dataset(dataset(found, operating), data)
        write_json(result, verdict)
    if folder is not None:
        for block in folder.glob("*.json"):
            block.unlink()
        folder.rmdir()
    return result


def sample_share(path: Path, out: Path, samples: int, seed: int, share: str) -> int:
    """Compute a share of the samples of an assessment ahead, as one of many jobs; return the number of its blocks.

    ``share``: 1/8, 2/8 and so on; :func:`assess_file` with the same file, ``out``, ``samples`` and ``seed`` then takes
    them up. Raises ``InputError`` in one sentence.
    """
    _require_samples(samples, seed)
    part, _, parts = share.partition("/")
    if not (part.isascii() and part.isdigit() and parts.isascii() and parts.isdigit()):
        raise InputError(f"share = {share!r} is not a share such as 1/8.")
    if not 1 <= int(part) <= int(parts) <= _MOST:
        raise InputError(f"share = {share} is outside the allowed range 1/1 to N/N.")
    return compute_blocks(Sheet.read(path), samples, seed, out / ".samples", int(part), int(parts))


def _require_samples(samples: int, seed: int) -> None:
    if not 64 <= samples <= _MOST or samples & (samples - 1):
        raise InputError(f"samples = {samples} is not a power of two in the allowed range 64 <= samples <= {_MOST}.")
    if not 0 <= seed <= _LARGEST_SEED:
        raise InputError(f"seed = {seed} is outside the allowed range 0 <= seed <= {_LARGEST_SEED}.")
