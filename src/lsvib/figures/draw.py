"""The picture of a figure, drawn from the file of its dataset."""

import os
import re
from importlib import import_module

from matplotlib.figure import Figure

from lsvib.datasets.io import read_dataset
from lsvib.figures.configuration import caption_file, picture_module
from lsvib.figures.style import plain, save
from lsvib.files import write_text

FULL, DRAFT = 300, 100  # resolution of a PNG for print and of one for a quick look [dots per inch]


def draw_figure(
    figure: str,
    dataset_file: str | os.PathLike[str],
    png: str | os.PathLike[str],
    pdf: str | os.PathLike[str] | None = None,
    caption: str | os.PathLike[str] | None = None,
    *,
    resolution: float = FULL,
) -> None:
    """Draw a figure from its dataset and write it; ``pdf`` None for no PDF; ``resolution`` of the PNG [dots per inch].

    ``caption``: file for the caption, reStructuredText; None for no such file. Raises ``LsvibError`` about files, in
    one sentence.
    """
    picture = import_module(picture_module(figure)).draw(read_dataset(dataset_file))
    save(picture, png, pdf, resolution=resolution)
    if caption is not None:
        write_text(caption_of(figure, picture), caption)


def caption_of(figure: str, picture: Figure) -> str:
    """Return the caption of a figure in reStructuredText: what it shows, then the values for which ``picture`` does.

    These are the words under the picture, which say what is printed and what is assumed, without mathematics.
    """
    words = caption_file(figure).read_text(encoding="utf-8").strip()
    values = re.sub(r"([*`|_\\])", r"\\\1", plain(picture.get_supxlabel()))  # so that they mean themselves
    return f"{words}\n\nValues: {values}\n" if values else f"{words}\n"
