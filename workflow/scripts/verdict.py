"""Fail with one sentence for each check that failed; rule verdict."""

import sys

from lsvib.data.checks import failures, read_checks, verdict
from lsvib.errors import LsvibError
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    checks = read_checks(snakemake.input.checks)
    failed = failures(checks)
    if failed:
        sys.exit("\n".join([f"{len(failed)} of {len(checks)} checks failed:", *failed]))
    write_text(f"{verdict(checks)}\n", snakemake.output[0])
except LsvibError as error:
    sys.exit(f"verdict: {error}")
