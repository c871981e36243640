"""Compute the dataset of one figure and its checks; rule dataset."""

import json
import sys
from importlib import import_module

from lsvib.datasets.writer import write_dataset
from lsvib.errors import LsvibError
from lsvib.files import write_json

sys.stderr = open(snakemake.log[0], "w", buffering=1)

figure = snakemake.wildcards.figure
settings = snakemake.params.settings
try:
    module = import_module(f"lsvib.datasets.{figure}")
    dataset = module.build(settings).assign_attrs(settings=json.dumps(settings))
    write_dataset(dataset, snakemake.output.dataset, f"lsvib.datasets.{figure}.build")
    write_json([check.to_json() for check in module.checks(dataset)], snakemake.output.checks)
except LsvibError as error:
    sys.exit(f"{figure}: {error}")
