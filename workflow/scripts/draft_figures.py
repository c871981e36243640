"""Compute several figures and draw them, in one process and without the PDF of an earlier full run; rules draft_N."""

import sys
from pathlib import Path

from lsvib.errors import LsvibError
from lsvib.figures.build import build_figure
from lsvib.figures.draw import DRAFT

sys.stderr = open(snakemake.log[0], "w", buffering=1)

out = snakemake.output
for (figure, settings), dataset, checks, png, caption in zip(
    snakemake.params.settings.items(), out.datasets, out.checks, out.png, out.captions, strict=True
):
    try:
        build_figure(figure, settings, dataset, checks, png, caption=caption, resolution=DRAFT)
        Path(png).with_suffix(".pdf").unlink(missing_ok=True)
    except LsvibError as error:
        sys.exit(f"{figure}: {error}")
