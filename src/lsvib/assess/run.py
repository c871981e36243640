"""Assess one data sheet and write the report, the dataset and the JSON file: all of them or none."""

from pathlib import Path
from typing import Any

from lsvib import numbers
from lsvib.assess.assessment import assess
from lsvib.assess.margins import charts
from lsvib.assess.output import as_json, dataset
from lsvib.assess.report import report
from lsvib.assess.sheet import Sheet
from lsvib.datasets.io import write_dataset
from lsvib.errors import InputError
from lsvib.files import Outputs, write_json, write_text

_MOST = 2**24  # samples: half a minute, for a share in error by less than 1e-4
_LARGEST_SEED = 2**32 - 1  # 32 bits, which every generator and file format takes


def assess_file(path: Path, out: Path, samples: Any = 4096, seed: Any = 1) -> dict[str, Any]:
    """Assess the data sheet in a YAML file; write ``index.html``, ``assessment.nc``, ``assessment.json`` to ``out``.

    ``samples``: a power of two. Returns what ``assessment.json`` holds. Raises ``InputError`` or another ``LsvibError``
    in one sentence; then nothing is written.
    """
    count = numbers.whole_between("samples", samples, 64, _MOST)
    if count & (count - 1):
        raise InputError(f"samples = {count} is not a power of two, as the sequence of samples needs.")
    start = numbers.whole_between("seed", seed, 0, _LARGEST_SEED)
    sheet = Sheet.read(path)
    files = [(out / "index.html", "HTML"), (out / "assessment.nc", "netCDF"), (out / "assessment.json", "JSON")]
    outputs = Outputs(files, [path], make_folders=True)
    found = assess(sheet, count, start)
    operating = charts(sheet, found.values)
    result = as_json(found)
    with outputs.writing() as (page, data, verdict):
        write_text(report(found, operating), page)
        write_dataset(dataset(found, operating), data)
        write_json(result, verdict)
    return result
