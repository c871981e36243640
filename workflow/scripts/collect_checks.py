"""Collect the checks of all figures; rule checks."""

import json
import sys
from pathlib import Path

from lsvib.datasets.checks import Check, markdown_table
from lsvib.files import write_json, write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

checks = [
    (path.stem, Check.from_json(values))
    for path in map(Path, snakemake.input.checks)
    for values in json.loads(path.read_text())
]
write_json([{"figure": figure, **check.to_json()} for figure, check in checks], snakemake.output.json)
write_text(markdown_table(checks), snakemake.output.table)
