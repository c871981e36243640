"""Write the tables of error against run time as Markdown; rule accuracy_table."""

import sys

from lsvib.bench.rivals.markdown_tables import markdown
from lsvib.data.writer import read_dataset
from lsvib.errors import LsvibError
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    write_text(markdown(read_dataset(snakemake.input.dataset)), snakemake.output[0])
except LsvibError as error:
    sys.exit(f"work_precision: {error}")
