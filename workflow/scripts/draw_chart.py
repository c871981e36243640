"""Draw the chart; rule draw_chart."""

import sys

from lsvib.data.assembly import overview
from lsvib.errors import LsvibError
from lsvib.figures.chart.picture import draw
from lsvib.figures.drawing.style import save

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    save(draw(overview(snakemake.input.chart)), snakemake.output.png, snakemake.output.pdf)
except LsvibError as error:
    sys.exit(f"chart: {error}")
