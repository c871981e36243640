"""Put the tiles of the region of attraction together."""

from job import logged

with logged(snakemake):
    from lsvib.answers.map import gather_map
    from lsvib.chapter.build import made_of

    settings = snakemake.params.settings
    gather_map(settings, list(snakemake.input), snakemake.output[0], made_of("attraction", settings))
