"""The datasets of the figures on coarse grids, what changes them, and pictures."""

import re
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

import numpy as np
import xarray as xr
import yaml
from matplotlib import rc_context
from matplotlib.legend import Legend
from matplotlib.text import Text

from lsvib.answers.io import read_dataset, write_dataset
from lsvib.chapter import build
from lsvib.chapter.checks import Check
from lsvib.chapter.configuration import load
from lsvib.pictures import drawing, style

STANDARD, COARSE = Path(__file__).parents[2] / "config" / "config.yaml", Path(__file__).with_name("coarse.yaml")


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


@cache
def stored(figure: str) -> xr.Dataset:
    """The dataset of a figure as a file gives it back."""
    with TemporaryDirectory() as folder:
        write_dataset(dataset_of(figure), file := Path(folder) / "figure.nc")
        return read_dataset(file)


def checks_of(figure: str, dataset: xr.Dataset) -> list[Check]:
    return list(load(figure).checks(dataset))


def set_to(name: str, value) -> Callable[[xr.Dataset], xr.Dataset]:
    """What puts a value, or values, in the place of those of a variable."""
    return lambda dataset: dataset.assign({name: dataset[name].variable.copy(data=np.full_like(dataset[name], value))})


def without_room(figure: style.Figure) -> list[str]:
    """Which words leave the picture or cover others, a line, another panel or the frame of their own."""
    words: list[Text] = []
    with patch.object(Text, "draw", lambda text, _: words.append(text)):  # ticks beyond the limits are not drawn
        figure.draw_without_rendering()
    places = [(text, drawing.outline(text, -1)) for text in words if text.get_visible() and text.get_text().strip()]
    page, boxes = figure.bbox, [legend.get_window_extent() for legend in figure.findobj(Legend)]
    faults = [
        "a legend leaves the picture" for x in boxes if not (page.x0 <= x.x0 < x.x1 <= page.x1 and x.y1 <= page.y1)
    ]
    for text, place in places:
        box, name = place.get_extents(), text.get_text()
        if not all(page.contains(*corner) for corner in box.corners()):
            faults.append(f"{name} leaves the picture")
        for axes in figure.axes:
            own = text.axes is not None and np.allclose(axes.bbox.extents, text.axes.bbox.extents)
            free = text in text.axes.texts if own else False
            inside = all(axes.bbox.contains(*corner) for corner in box.corners())
            if not (own and inside) and place.intersects_bbox(axes.bbox):
                faults.append(f"{name} covers a frame")
            for line in axes.lines if free else []:
                path = line.get_transform().transform_path(line.get_path())
                crossed = line.get_linestyle() != "None" and place.intersects_path(path, filled=False)
                if crossed or place.contains_points(path.vertices).any():
                    faults.append(f"{name} covers a line")
    pairs = combinations(places, 2)
    for (a, x), (b, y) in pairs:  # sides on one line, however far apart, count as crossing for paths alone
        if x.get_extents().overlaps(y.get_extents()) and x.intersects_path(y):
            faults.append(f"{a.get_text()} covers {b.get_text()}")
    return faults


def assert_drawn_from_file(figure: str, path: Path) -> None:
    """The file alone gives a figure with something in every panel, and names in its legends that are all different.

    It is one or two columns wide, its words have room, and no type, indices included, is below 6 pt.
    """
    drawn = build.drawn(figure, read_dataset(path))
    # Fonts of type 3 are embedded in a third of the time; sizes are those of any type.
    with rc_context({"pdf.compression": 0}), patch.dict(style._STYLE, {"pdf.fonttype": 3}):
        style.save(drawn, None, path.with_suffix(".pdf"), resolution=100)
    sizes = re.findall(rb"/F\S+ ([\d.]+) Tf", path.with_suffix(".pdf").read_bytes())
    assert min(map(float, sizes)) >= 6
    assert drawn.get_figwidth() in (3.5, 7.2)
    assert drawn.axes
    assert all(axes.has_data() for axes in drawn.axes)
    assert without_room(drawn) == []
    own = [axes.get_legend() for axes in drawn.axes]
    legends = [*(legend for part in (drawn, *drawn.subfigs) for legend in part.legends), *filter(None, own)]
    names = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert len(names) == len(set(names))
