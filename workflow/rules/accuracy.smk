"""Accuracy, stability and cost of the engine beside other methods: target `accuracy`, not part of `all`."""


rule accuracy:
    """Draw the figures of accuracy and judge their checks; needs the extra ``accuracy``."""
    input:
        collect("results/figures/{figure}.{format}", figure=ACCURACY_FIGURES, format=["png", "pdf"]),
        collect("results/datasets/{figure}.nc", figure=ACCURACY_FIGURES),
        collect("results/checks/{figure}.json", figure=ACCURACY_FIGURES),
        collect("results/accuracy/{name}", name=["checks.json", "checks.md", "checks.html", "verdict.txt"]),
    message:
        "All figures of accuracy are drawn and all their checks passed"


use rule check as accuracy_checks with:
    input:
        sources=source_files(imports("lsvib.datasets.checks")),
        checks=collect("results/checks/{figure}.json", figure=ACCURACY_FIGURES),
    output:
        json="results/accuracy/checks.json",
        text="results/accuracy/checks.md",
        printed="results/accuracy/printed.rst",
        page="results/accuracy/checks.html",
    log:
        "logs/accuracy_checks.log",


use rule verdict as accuracy_verdict with:
    input:
        sources=source_files(imports("lsvib.datasets.checks")),
        checks="results/accuracy/checks.json",
    output:
        "results/accuracy/verdict.txt",
    log:
        "logs/accuracy_verdict.log",
