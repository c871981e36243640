"""Put the tiles of the region of attraction together."""

from job import logged

with logged(snakemake):
    from lsvib.answers.map import gather_map

    gather_map(snakemake.params.settings, list(snakemake.input), snakemake.output[0])
