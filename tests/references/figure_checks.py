"""The datasets of the figures on coarse grids, ways to spoil them, and pictures."""

import re
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from unittest.mock import patch

import xarray as xr
import yaml
from matplotlib import rc_context

from lsvib.answers.io import read_dataset
from lsvib.chapter import build
from lsvib.chapter.checks import Check
from lsvib.chapter.configuration import load
from lsvib.pictures import style

STANDARD, COARSE = Path(__file__).parents[2] / "config" / "config.yaml", Path(__file__).with_name("coarse.yaml")
Spoiler = Callable[[xr.Dataset], xr.Dataset]


@cache
def _read(file: Path) -> dict:
    return yaml.safe_load(file.read_text())


def coarse(figure: str) -> dict:
    """The settings of a figure on grids that take little time."""

    def merge(old: dict, new: dict) -> dict:
        return {**old, **{k: merge(old[k], v) if isinstance(v, dict) else v for k, v in new.items()}}

    return merge(deepcopy(_read(STANDARD)[figure]), _read(COARSE).get(figure, {}))


@cache
def dataset_of(figure: str) -> xr.Dataset:
    return build.dataset_of(figure, coarse(figure))


def checks_of(figure: str, dataset: xr.Dataset) -> list[Check]:
    return list(load(figure).checks(dataset))


def set_to(name: str, value, *where: int) -> Spoiler:
    """A spoiler that puts ``value`` into a variable, at an index or everywhere."""

    def spoil(dataset: xr.Dataset) -> xr.Dataset:
        values = dataset[name].values.copy()
        values[where or ...] = value
        return dataset.assign({name: (dataset[name].dims, values, dataset[name].attrs)})

    return spoil


def scale(name: str, factor: float, *where: int) -> Spoiler:
    """A spoiler that multiplies a variable, at an index or everywhere."""
    return lambda dataset: set_to(name, dataset[name].values[where or ...] * factor, *where)(dataset)


def assert_drawn_from_file(figure: str, path: Path) -> None:
    """The file alone gives a figure with something in every panel, and names in its legends that are all different.

    It is one or two columns wide, its whole legend is in the picture, and no type, indices included, is below 6 pt.
    """
    drawn = build.drawn(figure, read_dataset(path))
    # Fonts of type 3 are embedded in a third of the time; sizes are those of any type.
    with rc_context({"pdf.compression": 0}), patch.dict(style._STYLE, {"pdf.fonttype": 3}):
        style.save(drawn, None, path.with_suffix(".pdf"), resolution=50)
    sizes = re.findall(rb"/F\S+ ([\d.]+) Tf", path.with_suffix(".pdf").read_bytes())
    assert min(map(float, sizes)) >= 6
    assert drawn.get_figwidth() in (3.5, 7.2)
    assert drawn.axes
    assert all(axes.has_data() for axes in drawn.axes)
    own = [axes.get_legend() for axes in drawn.axes]
    legends = [*(legend for part in (drawn, *drawn.subfigs) for legend in part.legends), *filter(None, own)]
    for legend in legends:
        box, page = legend.get_window_extent(), drawn.bbox
        assert page.x0 <= box.x0 < box.x1 <= page.x1
        assert box.y1 <= page.y1
    names = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert len(names) == len(set(names))
