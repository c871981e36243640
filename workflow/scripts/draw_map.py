"""Draw the region of attraction; rule draw_map."""

import sys

from lsvib.data.assembly import overview
from lsvib.errors import LsvibError
from lsvib.figures.attraction.picture import draw
from lsvib.figures.drawing.style import save

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    save(draw(overview(snakemake.input.map)), snakemake.output.png, snakemake.output.pdf)
except LsvibError as error:
    sys.exit(f"attraction: {error}")
