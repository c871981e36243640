"""Draw a figure, a map or a chart from its dataset."""

from job import logged

with logged(snakemake):
    from lsvib.chapter.build import draw_figure

    draw_figure(snakemake.wildcards.figure, snakemake.input[0], *snakemake.output)
