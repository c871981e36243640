"""The workflow, from the folder where users start it: snakemake -j2"""


include: "workflow/Snakefile"


workflow.default_target = "all"  # an included file does not set it
