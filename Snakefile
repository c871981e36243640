"""Figures of chapter 8 from the model: dataset -> checks -> picture. Run: snakemake -j2"""

import time

from snakemake.utils import min_version

min_version("9.19")  # the first that reads profiles/default/profile.yaml


configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


STARTED = time.time()


include: "workflow/rules/common.smk"


# The map of attraction is none of them: it has rules of its own.
wildcard_constraints:
    figure="|".join((*default_figures(), *accuracy_figures())),


include: "workflow/rules/figures.smk"
include: "workflow/rules/checks.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/attraction.smk"
include: "workflow/rules/chart.smk"
include: "workflow/rules/assess.smk"


if config.get("draft"):

    include: "workflow/rules/draft.smk"


rule all:
    default_target: True
    input:
        collect(
            "results/figures/{figure}.{format}",
            figure=FIGURES,
            format=["png", "rst"] if config.get("draft") else ["png", "pdf", "rst"],
        ),
        collect("results/datasets/{figure}.nc", figure=FIGURES),
        collect("results/checks/{figure}.json", figure=FIGURES),
        "results/checks.json",
        "results/checks.md",
        "results/checks.html",
        "results/printed.rst",
        "results/verdict.txt",
    message:
        "All figures are drawn and all checks passed"


onstart:
    if workflow.local_exec:
        jobs.start()
        # Here jobs need no limit for each second; keeping one makes Snakemake choose anew again and again.
        workflow.scheduler.job_rate_limiter = None


onsuccess:
    remove_leftovers()
    print_results(STARTED)


onerror:
    print_results(STARTED, log)
