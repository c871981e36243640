"""Chart one tile of the chart; rule chart_tile."""

import sys

from lsvib.data.chart_tiles import chart_tile
from lsvib.errors import LsvibError

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    chart_tile(snakemake.params.settings, snakemake.wildcards.scatteritem, snakemake.output[0], snakemake.threads)
except LsvibError as error:
    sys.exit(f"chart: {error}")
