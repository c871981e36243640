"""Accuracy, stability and cost of the engine beside other methods at full size: target `accuracy`, not part of `all`."""


rule accuracy:
    """Draw the figures of accuracy and judge their checks; needs the extra ``accuracy``."""
    input:
        collect("results/accuracy/figures/{figure}.{format}", figure=ACCURACY_FIGURES, format=["png", "pdf"]),
        collect("results/accuracy/datasets/{figure}.nc", figure=ACCURACY_FIGURES),
        collect("results/accuracy/checks/{figure}.json", figure=ACCURACY_FIGURES),
        collect("results/accuracy/{name}", name=["checks.json", "checks.md", "verdict.txt"]),
    message:
        "All figures of accuracy are drawn and all their checks passed"


use rule dataset as accuracy_dataset with:
    output:
        dataset="results/accuracy/datasets/{figure}.nc",
        checks="results/accuracy/checks/{figure}.json",
    log:
        "logs/accuracy_dataset/{figure}.log",
    threads: cores
    params:
        code=code(jobs.dataset),
        settings=accuracy_settings,
    message:
        "Computing {wildcards.figure} for accuracy"


use rule figure as accuracy_figure with:
    input:
        dataset="results/accuracy/datasets/{figure}.nc",
        sources=sources("figures"),
    output:
        png=report(
            "results/accuracy/figures/{figure}.png",
            caption="../report/figure.rst",
            category="Accuracy and cost at full size",
            labels={"figure": "{figure}"},
        ),
        pdf="results/accuracy/figures/{figure}.pdf",
        caption="results/accuracy/figures/{figure}.rst",
    log:
        "logs/accuracy_figure/{figure}.log",
    message:
        "Drawing {wildcards.figure} for accuracy"


use rule check as accuracy_checks with:
    input:
        sources=source_files(imports("lsvib.datasets.checks")),
        checks=collect("results/accuracy/checks/{figure}.json", figure=ACCURACY_FIGURES),
    output:
        json="results/accuracy/checks.json",
        text="results/accuracy/checks.md",
        printed="results/accuracy/printed.rst",
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
    params:
        code=code(jobs.verdict) + code(jobs.foreign),
        origins=lambda wildcards: origins(ACCURACY_FIGURES, accuracy=True),
