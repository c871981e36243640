"""Map one tile of the region of attraction; rule map_tile."""

import sys

from lsvib.data.tiles import map_tile
from lsvib.errors import LsvibError

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    map_tile(snakemake.params.settings, snakemake.wildcards.scatteritem, snakemake.output[0], snakemake.threads)
except LsvibError as error:
    sys.exit(f"attraction: {error}")
