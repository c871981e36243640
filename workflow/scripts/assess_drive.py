"""Assess one drive from its data sheet; rule assess_drive."""

import sys
from pathlib import Path

from lsvib.assess.run import assess_file
from lsvib.errors import LsvibError

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    assess_file(
        Path(snakemake.input.sheet),
        Path(snakemake.output.page).parent,
        samples=snakemake.params.samples,
        workers=snakemake.threads,
        progress=lambda done, total: print(f"{done} of {total} blocks of samples", file=sys.stderr),
    )
except LsvibError as error:
    sys.exit(f"{snakemake.wildcards.sheet}: {error}")
