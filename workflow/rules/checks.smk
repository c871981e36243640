"""All checks together, and the verdict that decides whether the run passes."""


rule checks:
    """Collect the checks of all figures in one file for machines and one table for people."""
    input:
        sources=source_files(imports("lsvib.data.checks")),
        checks=collect("results/checks/{figure}.json", figure=FIGURES),
    output:
        json="results/checks.json",
        table="results/checks.md",
    log:
        "logs/checks.log",
    message:
        "Collecting the checks"
    script:
        "../scripts/collect_checks.py"


rule verdict:
    """Fail, with the reason, if a check failed. The table of checks is a result of its own and stays."""
    input:
        sources=source_files(imports("lsvib.data.checks")),
        checks="results/checks.json",
    output:
        "results/verdict.txt",
    log:
        "logs/verdict.log",
    message:
        "Judging the checks"
    script:
        "../scripts/verdict.py"
