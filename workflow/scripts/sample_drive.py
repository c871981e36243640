"""Compute one share of the samples of a drive ahead; rule sample_drive."""

import sys
from pathlib import Path

from lsvib.assess.run import sample_share
from lsvib.errors import LsvibError
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    done = sample_share(
        Path(snakemake.input.sheet),
        Path(snakemake.output[0]).parent,
        snakemake.params.samples,
        1,
        f"{snakemake.wildcards.share}/{snakemake.params.shares}",
    )
    write_text(f"{done} blocks of samples\n", snakemake.output[0])
except LsvibError as error:
    sys.exit(f"{snakemake.wildcards.sheet}: {error}")
