"""Collect the checks of all figures; rule checks."""

import sys

from lsvib.data.checks import read_checks
from lsvib.data.checks_report import checks_page, checks_text, printed_table
from lsvib.errors import LsvibError
from lsvib.files import write_json, write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

try:
    checks = [pair for path in snakemake.input.checks for pair in read_checks(path)]
    write_json([{"figure": figure, **check.to_json()} for figure, check in checks], snakemake.output.json)
    write_text(checks_text(checks), snakemake.output.text)
    write_text(checks_page(checks), snakemake.output.page)
    write_text(printed_table(checks), snakemake.output.printed)
except LsvibError as error:
    sys.exit(f"checks: {error}")
