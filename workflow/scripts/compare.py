"""Put the verdicts on all drives in one table."""

from pathlib import Path

from job import logged

with logged(snakemake):
    from lsvib.sheets.report import compare

    compare([Path(file) for file in snakemake.input], *map(Path, snakemake.output))
