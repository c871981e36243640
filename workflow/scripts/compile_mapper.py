"""Map one cell of the region of attraction and note its label; rule compile_mapper."""

import sys

from lsvib.basins.grid import Grid
from lsvib.data.tiles import mapper_of
from lsvib.errors import LsvibError
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

settings = snakemake.params.settings
try:
    cells = mapper_of(settings).cells(Grid.of(settings["grid"]), slice(0, 1), slice(0, 1), settings["quantities"])
    write_text(f"{cells['label'].item()}\n", snakemake.output[0])
except LsvibError as error:
    sys.exit(f"attraction: {error}")
