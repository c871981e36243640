"""Put the verdicts on all drives in one table; rule compare_drives."""

import sys
from pathlib import Path

from lsvib.assess.compare import compare
from lsvib.errors import LsvibError

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    compare(
        [Path(path) for path in snakemake.input.verdicts], Path(snakemake.output.page), Path(snakemake.output.table)
    )
except LsvibError as error:
    sys.exit(f"assessments: {error}")
