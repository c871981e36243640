"""The workflow, from the folder where users start it: snakemake -j2"""


configfile: "config/config.yaml"


module lsvib:
    snakefile:
        "workflow/Snakefile"
    config:
        config


use rule * from lsvib
