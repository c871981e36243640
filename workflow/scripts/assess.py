"""Assess one drive from its data sheet."""

from pathlib import Path

from job import logged

with logged(snakemake):
    from lsvib.sheets.output import assess

    assess(Path(snakemake.input.sheet), Path(snakemake.output.page).parent, samples=snakemake.params.samples)
