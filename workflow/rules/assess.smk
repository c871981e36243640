"""Many drives from their data sheets: snakemake -j2 assessments. Needs no figure; each drive has its report."""

# A share of the samples is a job of its own, as a tile of a map is; with one share there is no such job.
SHEETS = {Path(sheet).stem: sheet for sheet in config["assessments"]}
SHARES = config["assessment_shares"]

# What an assessment depends on; the models, imported by their names, are unknown to the graph.
ASSESSMENT = (
    imports("lsvib.assess.run")
    | imports("lsvib.drives.rigid")
    | imports("lsvib.drives.second_body.support")
    | imports("lsvib.drives.threads")
)

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


rule sample_drive:
    """Compute one share of the samples of a drive ahead."""
    input:
        sheet=lambda wildcards: SHEETS[wildcards.sheet],
        sources=source_files(ASSESSMENT),
    output:
        temp("results/assessments/{sheet}/share_{share}.txt"),
    log:
        "logs/sample_drive/{sheet}_{share}.log",
    params:
        code=code(jobs.sample),
        samples=config["assessment_samples"],
        shares=SHARES,
    message:
        "Sampling {wildcards.sheet}, share {wildcards.share}"
    run:
        share = f"{wildcards.share}/{params.shares}"
        jobs.run(jobs.sample, log[0], wildcards.sheet, input.sheet, output[0], params.samples, share)


rule assess_drive:
    """Assess one drive from its data sheet."""
    input:
        sheet=lambda wildcards: SHEETS[wildcards.sheet],
        sources=source_files(ASSESSMENT),
        engine=engine(ASSESSMENT),
        shares=lambda wildcards: (
            [f"results/assessments/{wildcards.sheet}/share_{k + 1}.txt" for k in range(SHARES)] if SHARES > 1 else []
        ),
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
        jobs.run(jobs.assess, log[0], wildcards.sheet, input.sheet, output.page, params.samples, threads)


rule compare_drives:
    """Put the verdicts on all drives in one table."""
    input:
        verdicts=collect("results/assessments/{sheet}/assessment.json", sheet=SHEETS),
        sources=source_files(imports("lsvib.assess.compare")),
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
