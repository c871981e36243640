"""Draw one figure from its dataset; rule figure."""

import sys
from importlib import import_module

from lsvib.data.writer import read_dataset
from lsvib.errors import LsvibError
from lsvib.figures.drawing.style import save
from lsvib.figures.folders import picture_module

sys.stderr = open(snakemake.log[0], "w", buffering=1)

figure = snakemake.wildcards.figure
try:
    draw = import_module(picture_module(figure)).draw
    save(draw(read_dataset(snakemake.input.dataset)), snakemake.output.png, snakemake.output.pdf)
except LsvibError as error:
    sys.exit(f"{figure}: {error}")
