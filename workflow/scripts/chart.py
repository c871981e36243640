"""Chart what a drive does over two of its parameters."""

from job import logged

with logged(snakemake):
    from lsvib.answers.sweep import write_chart

    write_chart(snakemake.params.settings, snakemake.output[0], snakemake.threads)
