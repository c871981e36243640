"""Compute the dataset of a figure and its checks; a check that failed is said at once."""

from job import logged

with logged(snakemake):
    from lsvib.chapter.build import compute_figure
    from lsvib.chapter.checks import failures
    from lsvib.chapter.configuration import PARTS

    figure, files = snakemake.wildcards.figure, snakemake.input
    parts = {name: files.get(name) for name in PARTS if files.get(name)}
    checks = compute_figure(figure, snakemake.params.settings, *snakemake.output, parts)
    for sentence in failures([(figure, check) for check in checks]):
        print(f"A check failed. {sentence}")
