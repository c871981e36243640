"""The dataset of a figure and its checks, from its settings to the files."""

import json
import os
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from lsvib.datasets.checks import Check
from lsvib.datasets.io import write_dataset
from lsvib.figures.configuration import complete_settings, dataset_module
from lsvib.files import write_json


def compute_figure(
    figure: str, given: Mapping[str, Any], dataset_file: str | os.PathLike[str], checks_file: str | os.PathLike[str]
) -> list[Check]:
    """Compute the dataset of a figure and judge it, by the functions ``build`` and ``checks`` of its module.

    ``build`` takes all values of the class ``Settings`` beside it; for values that it cannot use it raises
    ``InputError``. Both results are written.
    ``given``: settings as in its section of ``config/config.yaml``; those that it does not name have their defaults.
    The dataset carries the settings as JSON in its attribute ``settings``. Raises ``InputError`` about the settings and
    ``LsvibError`` about files, in one sentence.
    """
    settings = complete_settings(figure, given)
    module = import_module(dataset_module(figure))
    dataset = module.build(settings).assign_attrs(settings=json.dumps(settings))
    write_dataset(dataset, dataset_file, f"{dataset_module(figure)}.build")
    checks: list[Check] = module.checks(dataset)
    write_json([check.to_json() for check in checks], checks_file)
    return checks
