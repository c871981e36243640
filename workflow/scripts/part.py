"""Compute the analysis of the drives of a figure, or its maps of grids of starts."""

from job import logged

with logged(snakemake):
    from lsvib.chapter.build import compute_part

    compute_part(snakemake.wildcards.figure, snakemake.params.part, snakemake.params.settings, snakemake.output[0])
