"""All checks together."""


rule check:
    """Collect the checks of all figures: for programs, as a text by figure, and as pages of the report."""
    input:
        collect("<results>/checks/{figure}.json", figure=FIGURES),
    output:
        json="<results>/checks.json",
        text="<results>/checks.md",
        page=report("<results>/checks.html", category="Checks", labels={"table": "every check"}),
        printed="<results>/printed.rst",
    log:
        "<logs>/checks.log",
    message:
        "Collecting the checks"
    script:
        "../scripts/check.py"
