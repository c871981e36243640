"""Put the tiles of the chart together; rule gather_chart."""

import sys

from lsvib.data.chart_tiles import gather_chart
from lsvib.errors import LsvibError

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    gather_chart(
        snakemake.params.settings,
        snakemake.input.tiles,
        snakemake.output[0],
        progress=lambda done, total: print(f"{done} of {total} tiles", file=sys.stderr),
    )
except LsvibError as error:
    sys.exit(f"chart: {error}")
