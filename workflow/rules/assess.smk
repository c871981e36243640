"""Many drives from their data sheets: snakemake -j2 assessments. Needs no figure; each drive has its report."""

SHEETS = {Path(sheet).stem: sheet for sheet in config["assessments"]}

# What an assessment depends on.
ASSESSMENT = imports("lsvib.assess.output")

if len(SHEETS) < len(config["assessments"]):
    raise WorkflowError("Configuration: two data sheets of assessments have the same name but for their folder.")


wildcard_constraints:
    sheet="|".join(map(re.escape, SHEETS)) or "none",


rule assessments:
    """Assess all drives and compare them."""
    input:
        "results/assessments/index.html",
        "results/assessments/comparison.json",
    message:
        "All drives are assessed"


rule assess_drive:
    """Assess one drive from its data sheet."""
    input:
        sheet=lambda wildcards: SHEETS[wildcards.sheet],
        sources=source_files(ASSESSMENT),
        engine=engine(ASSESSMENT, ["modal"]),
    output:
        page="results/assessments/{sheet}/index.html",
        dataset="results/assessments/{sheet}/assessment.nc",
        verdict="results/assessments/{sheet}/assessment.json",
    log:
        "logs/assess_drive/{sheet}.log",
    params:
        code=code(jobs.assess),
        samples=config["assessment_samples"],
    message:
        "Assessing {wildcards.sheet}"
    run:
        jobs.run(jobs.assess, log[0], wildcards.sheet, input.sheet, output.page, params.samples)


rule compare_drives:
    """Put the verdicts on all drives in one table."""
    input:
        verdicts=collect("results/assessments/{sheet}/assessment.json", sheet=SHEETS),
        sources=source_files(imports("lsvib.assess.report")),
    output:
        page="results/assessments/index.html",
        table="results/assessments/comparison.json",
    log:
        "logs/compare_drives.log",
    params:
        code=code(jobs.compare),
    message:
        "Comparing the drives"
    run:
        jobs.run(jobs.compare, log[0], "assessments", list(input.verdicts), output.page, output.table)
