"""Map one tile of the region of attraction."""

from job import logged

with logged(snakemake):
    from lsvib.answers.map import map_tile

    map_tile(snakemake.params.settings, snakemake.wildcards.scatteritem, snakemake.output[0], snakemake.threads)
