"""Collect the checks of all figures."""

from job import logged

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Checks</title><style>
body {{ max-width: 62rem; margin: auto; padding: 0 1rem; font: 1rem/1.5 sans-serif; overflow-wrap: break-word }}
th, td {{ padding: .2rem 1rem .2rem 0; text-align: left; vertical-align: top }}
@media (max-width: 640px) {{ tr {{ display: flex; flex-wrap: wrap; margin-bottom: .7rem }} }} /* a telephone */
</style></head><body><main>
{}</main></body></html>
"""

with logged(snakemake):
    from markdown_it import MarkdownIt

    from lsvib.chapter.checks import read_checks, read_statements, report
    from lsvib.drives.chapter import FILE
    from lsvib.files import write_json, write_text

    checks = [pair for file in snakemake.input for pair in read_checks(file)]
    write_json([{"figure": figure, **check.to_json()} for figure, check in checks], snakemake.output.json)
    text = report("md", checks, read_statements(FILE, checks))
    write_text(text, snakemake.output.text)
    # In these sentences an asterisk multiplies, and < begins no tag.
    marked = MarkdownIt("commonmark", {"html": False}).enable("table").disable("emphasis")
    write_text(PAGE.format(marked.render(text)), snakemake.output.page)
    write_text(report("rst", checks), snakemake.output.printed)
