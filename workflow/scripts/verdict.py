"""Fail with one sentence for each check that failed; rule verdict."""

import json
import sys
from pathlib import Path

from lsvib.datasets.checks import Check
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

records = json.loads(Path(snakemake.input.checks).read_text())
checks = [(record.pop("figure"), Check.from_json(record)) for record in records]
failed = [f"{figure}: {check.sentence()}" for figure, check in checks if not check.passed]
if failed:
    sys.exit("\n".join([f"{len(failed)} of {len(checks)} checks failed:", *failed]))
write_text(f"All {len(checks)} checks passed.\n", snakemake.output[0])
