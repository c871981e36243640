"""Compute several figures and draw them, in one process and without the PDF of an earlier full run; rules draft_N."""

import json
import sys
from importlib import import_module
from pathlib import Path

from lsvib.data.writer import read_dataset, write_dataset
from lsvib.errors import LsvibError
from lsvib.figures.drawing.style import save
from lsvib.figures.folders import dataset_module, picture_module
from lsvib.files import write_json

sys.stderr = open(snakemake.log[0], "w", buffering=1)

out = snakemake.output
for (figure, settings), path, checks, png in zip(
    snakemake.params.settings.items(), out.datasets, out.checks, out.png, strict=True
):
    try:
        module = import_module(dataset_module(figure))
        dataset = module.build(settings).assign_attrs(settings=json.dumps(settings))
        write_dataset(dataset, path)
        write_json([check.to_json() for check in module.checks(dataset)], checks)
        save(import_module(picture_module(figure)).draw(read_dataset(path)), png, resolution=100)
        Path(png).with_suffix(".pdf").unlink(missing_ok=True)
    except LsvibError as error:
        sys.exit(f"{figure}: {error}")
