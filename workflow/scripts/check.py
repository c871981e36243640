"""Collect the checks of all figures."""

from job import logged

with logged(snakemake):
    from lsvib.chapter.checks import read_checks, read_statements, report
    from lsvib.drives.chapter import FILE
    from lsvib.files import write_json, write_text

    checks = [pair for file in snakemake.input for pair in read_checks(file)]
    write_json([{"figure": figure, **check.to_json()} for figure, check in checks], snakemake.output.json)
    write_text(report("md", checks, read_statements(FILE)), snakemake.output.text)
    write_text(report("rst", checks), snakemake.output.printed)
