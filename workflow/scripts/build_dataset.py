"""Compute the dataset of one figure and its checks; rule dataset."""

import sys

from lsvib.errors import LsvibError
from lsvib.figures.compute import compute_figure

sys.stderr = open(snakemake.log[0], "w", buffering=1)

figure = snakemake.wildcards.figure
try:
    compute_figure(figure, snakemake.params.settings, snakemake.output.dataset, snakemake.output.checks)
except LsvibError as error:
    sys.exit(f"{figure}: {error}")
