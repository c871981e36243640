"""Compute the dataset of one figure and its checks; rule dataset."""

import json
import sys
from importlib import import_module

from lsvib.data.writer import write_dataset
from lsvib.errors import LsvibError
from lsvib.figures.folders import dataset_module
from lsvib.files import write_json

sys.stderr = open(snakemake.log[0], "w", buffering=1)

figure = snakemake.wildcards.figure
settings = snakemake.params.settings
try:
    module = import_module(dataset_module(figure))
    dataset = module.build(settings).assign_attrs(settings=json.dumps(settings))
    write_dataset(dataset, snakemake.output.dataset, f"{dataset_module(figure)}.build")
    write_json([check.to_json() for check in module.checks(dataset)], snakemake.output.checks)
except LsvibError as error:
    sys.exit(f"{figure}: {error}")
