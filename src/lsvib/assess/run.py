"""Assess one data sheet and write the report, the dataset and the JSON file: all of them or none."""

from pathlib import Path
from typing import Any

from lsvib import numbers
from lsvib.assess.assessment import assess
from lsvib.assess.dataset import dataset
from lsvib.assess.operating_chart import charts
from lsvib.assess.plain_values import as_json
from lsvib.assess.report import report
from lsvib.assess.sheet import Sheet
from lsvib.assess.uncertainty import BLOCK, compute_blocks
from lsvib.data.writer import write_dataset
from lsvib.errors import InputError
from lsvib.files import Outputs, write_json, write_text
from lsvib.numbers import Progress

_MOST = 2**30  # samples: a thousand million
_LARGEST_SEED = 2**32 - 1  # 32 bits, which every generator and file format takes


def assess_file(
    path: Path,
    out: Path,
    samples: Any = BLOCK,
    seed: Any = 1,
    workers: Any = 1,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Assess the data sheet in a YAML file; write ``index.html``, ``assessment.nc``, ``assessment.json`` to ``out``.

    ``samples``: a power of two; blocks of them that are finished are kept in the folder ``.samples`` of ``out`` until
    the files are written, so that a run that was stopped goes on. Returns what ``assessment.json`` holds. Raises
    ``InputError`` or another ``LsvibError`` in one sentence; then nothing is written.
    """
    samples, seed = _samples(samples, seed)
    at_once = numbers.workers(workers)
    sheet = Sheet.read(path)
    files = [(out / "index.html", "HTML"), (out / "assessment.nc", "netCDF"), (out / "assessment.json", "JSON")]
    outputs = Outputs(files, [path], make_folders=True)
    folder = out / ".samples" if samples > BLOCK else None
    found = assess(sheet, samples, seed, at_once, folder, progress)
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


def sample_share(path: Path, out: Path, samples: Any, seed: Any, share: str) -> int:
    """Compute a share of the samples of an assessment ahead, as one of many jobs; return the number of its blocks.

    ``share``: 1/8, 2/8 and so on; :func:`assess_file` with the same file, ``out``, ``samples`` and ``seed`` then takes
    them up. Raises ``InputError`` in one sentence.
    """
    samples, seed = _samples(samples, seed)
    part, _, parts = share.partition("/")
    if not (part.isascii() and part.isdigit() and parts.isascii() and parts.isdigit()):
        raise InputError(f"share = {share!r} is not a share such as 1/8.")
    if not 1 <= int(part) <= int(parts) <= _MOST:
        raise InputError(f"share = {share} is outside the allowed range 1/1 to N/N.")
    return compute_blocks(Sheet.read(path), samples, seed, out / ".samples", int(part), int(parts))


def _samples(given: Any, seed: Any) -> tuple[int, int]:
    count = numbers.whole_between("samples", given, 64, _MOST)
    if count & (count - 1):
        raise InputError(f"samples = {count} is not a power of two, as the sequence of samples needs.")
    return count, numbers.whole_between("seed", seed, 0, _LARGEST_SEED)
