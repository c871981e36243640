"""The picture of a figure, drawn from the file of its dataset."""

import os
from importlib import import_module

from lsvib.data.writer import read_dataset
from lsvib.figures.drawing.style import save
from lsvib.figures.folders import picture_module

FULL, DRAFT = 300, 100  # resolution of a PNG for print and of one for a quick look [dots per inch]


def draw_figure(
    figure: str,
    dataset_file: str | os.PathLike[str],
    png: str | os.PathLike[str],
    pdf: str | os.PathLike[str] | None = None,
    *,
    resolution: float = FULL,
) -> None:
    """Draw a figure from its dataset and write it; ``pdf`` None for no PDF; ``resolution`` of the PNG [dots per inch].

    Raises ``LsvibError`` about files, in one sentence.
    """
    picture = import_module(picture_module(figure)).draw(read_dataset(dataset_file))
    save(picture, png, pdf, resolution=resolution)
