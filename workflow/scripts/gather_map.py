"""Put the tiles of the region of attraction together; rule gather_map."""

import sys

from lsvib.data.tiles import gather_map
from lsvib.errors import LsvibError

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    gather_map(
        snakemake.params.settings,
        snakemake.input.tiles,
        snakemake.output[0],
        progress=lambda done, total: print(f"{done} of {total} tiles", file=sys.stderr),
    )
except LsvibError as error:
    sys.exit(f"attraction: {error}")
