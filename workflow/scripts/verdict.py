"""Judge the checks and where the datasets come from, and print the numbers that the chapter prints."""

import json
import sys

from job import logged

with logged(snakemake):
    import lsvib
    from lsvib.answers.io import read_dataset
    from lsvib.chapter.checks import counts, failures, printed_thresholds, read_checks, verdict
    from lsvib.chapter.configuration import complete_settings, sources_of

    wrong = []
    for (figure, given), file in zip(snakemake.params.settings.items(), snakemake.input.datasets, strict=True):
        made = read_dataset(file).attrs
        if made.get("settings") != json.dumps(complete_settings(figure, given)):
            wrong.append(f"{file} was made with another configuration; delete it and run the workflow again.")
        elif made.get("sources_sha256") != sources_of(figure):
            wrong.append(f"{file} was made by other sources; delete it and run the workflow again.")
    if wrong:
        sys.exit("\n".join(wrong))
    checks = read_checks(snakemake.input.checks)
    print("\n".join(["", *printed_thresholds(checks), counts(checks), verdict(checks)]))
    print(f"Every check: {snakemake.input.checks}, .md; made by the lsvib in {lsvib.__path__[0]}")
    if failed := failures(checks):
        sys.exit("\n".join(failed))
