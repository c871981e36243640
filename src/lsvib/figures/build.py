"""A whole figure: dataset, checks and picture, the same from Python, from the command and in the workflow.

The workflow calls the two halves in jobs of their own, or this whole for a quick look.
"""

import os
from collections.abc import Mapping
from typing import Any

from lsvib.datasets.checks import Check
from lsvib.figures.build import FULL, compute_figure, draw_figure


def build_figure(
    figure: str,
    given: Mapping[str, Any],
    dataset_file: str | os.PathLike[str],
    checks_file: str | os.PathLike[str],
    png: str | os.PathLike[str],
    pdf: str | os.PathLike[str] | None = None,
    *,
    caption: str | os.PathLike[str] | None = None,
    resolution: float = FULL,
) -> list[Check]:
    """Compute, judge and draw a figure; write its dataset, checks and picture, and return the checks.

    Arguments as of :func:`compute_figure` and :func:`draw_figure`; ``figure``: its name, such as ``fig8_06``. Raises
    ``InputError`` about the name and the settings and ``LsvibError`` about files, in one sentence.
    """
    checks = compute_figure(figure, given, dataset_file, checks_file)
    draw_figure(figure, dataset_file, png, pdf, caption, resolution=resolution)
    return checks
