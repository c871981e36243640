"""Many drives from their data sheets: snakemake -j2 assessments. Needs no figure; each drive has its report."""

import re
from pathlib import Path

SHEETS = {Path(sheet).stem: sheet for sheet in config["assessments"]}

if len(SHEETS) < len(config["assessments"]):
    raise WorkflowError("Configuration: two data sheets of assessments have the same name in different folders.")


rule assessments:
    """Assess all drives and compare them."""
    input:
        "<results>/assessments/index.html",
        "<results>/assessments/comparison.json",


rule check_sheets:
    """Refuse what no sheet may say before any drive is assessed."""
    input:
        SHEETS.values(),
    output:
        touch("<results>/assessments/checked"),
    log:
        "<logs>/check_sheets.log",
    message:
        "Checking the data sheets"
    script:
        "../scripts/check_sheets.py"


rule assess_drive:
    """Assess one drive from its data sheet."""
    input:
        sheet=lambda wildcards: SHEETS[wildcards.sheet],
        checked=ancient("<results>/assessments/checked"),
    output:
        page="<results>/assessments/{sheet}/index.html",
        verdict="<results>/assessments/{sheet}/assessment.json",
    log:
        "<logs>/assess_drive/{sheet}.log",
    wildcard_constraints:
        sheet="|".join(map(re.escape, SHEETS)) or "none",
    params:
        samples=config["assessment_samples"],
        sources=sources,
    message:
        "Assessing {wildcards.sheet}"
    script:
        "../scripts/assess.py"


rule compare_drives:
    """Put the verdicts on all drives in one table."""
    input:
        collect("<results>/assessments/{sheet}/assessment.json", sheet=SHEETS),
    output:
        page="<results>/assessments/index.html",
        table="<results>/assessments/comparison.json",
    log:
        "<logs>/compare_drives.log",
    message:
        "Comparing the drives"
    script:
        "../scripts/compare.py"
