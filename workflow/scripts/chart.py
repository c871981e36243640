"""Chart what a drive does over two of its parameters."""

from job import logged

with logged(snakemake):
    from lsvib.answers.sweep import write_chart
    from lsvib.chapter.build import made_of

    settings = snakemake.params.settings
    write_chart(settings, snakemake.output[0], snakemake.threads, made_of("chart", settings))
