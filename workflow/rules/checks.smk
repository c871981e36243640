"""All checks together, and the verdict that decides whether the run passes."""


rule check:
    """Collect the checks of all figures: for machines, and as a text by figure."""
    input:
        sources=source_files(imports("lsvib.datasets.checks")),
        checks=collect("results/checks/{figure}.json", figure=FIGURES),
        listed="config/chapter.yaml",
    output:
        json="results/checks.json",
        text=report(
            "results/checks.md",
            caption="../report/checks.rst",
            category="Checks",
            labels={"text": "every check"},
        ),
        printed="results/printed.rst",
    log:
        "logs/checks.log",
    params:
        code=code(jobs.all_checks),
    message:
        "Collecting the checks"
    run:
        jobs.run(jobs.all_checks, log[0], "checks", list(input.checks), list(output), input.get("listed"))


rule verdict:
    """Fail, with the reason, if a check failed. The table of checks is a result of its own and stays."""
    input:
        sources=source_files(imports("lsvib.datasets.checks")),
        checks="results/checks.json",
    output:
        "results/verdict.txt",
    log:
        "logs/verdict.log",
    params:
        code=code(jobs.verdict) + code(jobs.foreign),
        origins=lambda wildcards: origins(FIGURES),
    message:
        "Judging the checks"
    run:
        jobs.run(jobs.verdict, log[0], "verdict", input.checks, params.origins, output[0])
