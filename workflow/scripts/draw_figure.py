"""Draw one figure from its dataset; rule figure."""

import sys

from lsvib.errors import LsvibError
from lsvib.figures.draw import draw_figure

sys.stderr = open(snakemake.log[0], "w", buffering=1)

figure = snakemake.wildcards.figure
try:
    out = snakemake.output
    draw_figure(figure, snakemake.input.dataset, out.png, out.pdf, out.caption)
except LsvibError as error:
    sys.exit(f"{figure}: {error}")
