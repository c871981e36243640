"""Figures of chapter 8 from the model: dataset -> checks -> picture. Run: snakemake -j2"""

import time

from snakemake.utils import min_version

min_version("9.19")  # the first that reads profiles/default/profile.yaml


configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


STARTED = time.time()


include: "workflow/rules/common.smk"


# The names of all figures: the sections of the configuration but the map, which has rules of its own.
wildcard_constraints:
    figure="|".join(name for name, section in config.items() if isinstance(section, dict) and name != "attraction"),


include: "workflow/rules/figures.smk"
include: "workflow/rules/checks.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/attraction.smk"
include: "workflow/rules/assess.smk"


if config.get("draft"):

    include: "workflow/rules/draft.smk"


rule all:
    default_target: True
    input:
        collect(
            "results/figures/{figure}.{format}",
            figure=config["figures"],
            format=["png"] if config.get("draft") else ["png", "pdf"],
        ),
        collect("results/datasets/{figure}.nc", figure=config["figures"]),
        collect("results/checks/{figure}.json", figure=config["figures"]),
        "results/checks.json",
        "results/checks.md",
        "results/verdict.txt",
    message:
        "All figures are drawn and all checks passed"


onsuccess:
    remove_leftovers()
    print_results(STARTED)


onerror:
    print_results(STARTED, log)
