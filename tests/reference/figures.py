"""The datasets of the figures on draft settings; their checks all pass, and each fails on spoiled data."""

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path

import xarray as xr
import yaml
from matplotlib.figure import Figure

from lsvib.datasets.writer import read_dataset, write_dataset

CONFIG = Path(__file__).parents[2] / "config"
Spoiler = Callable[[xr.Dataset], xr.Dataset]


def draft(figure: str) -> dict:
    """The settings of a figure as the workflow merges them for a draft."""
    full, changes = (yaml.safe_load((CONFIG / f"{name}.yaml").read_text()) for name in ("config", "draft"))

    def merge(old: dict, new: dict) -> dict:
        return {**old, **{k: merge(old[k], v) if isinstance(v, dict) else v for k, v in new.items()}}

    return merge(full[figure], changes.get(figure, {}))


@cache
def dataset_of(figure: str) -> xr.Dataset:
    return import_module(f"lsvib.datasets.{figure}").build(draft(figure))


def set_to(name: str, value, *where: int) -> Spoiler:
    """A spoiler that puts ``value`` into a variable, at an index or everywhere."""

    def spoil(dataset: xr.Dataset) -> xr.Dataset:
        values = dataset[name].values.copy()
        values[where or ...] = value
        return dataset.assign({name: (dataset[name].dims, values, dataset[name].attrs)})

    return spoil


def scale(name: str, factor: float, *where: int) -> Spoiler:
    """A spoiler that multiplies a variable, at an index or everywhere."""

    def spoil(dataset: xr.Dataset) -> xr.Dataset:
        values = dataset[name].values.copy()
        values[where or ...] *= factor
        return dataset.assign({name: (dataset[name].dims, values, dataset[name].attrs)})

    return spoil


def assert_checks_pass(figure: str, spoilers: Mapping[str, Spoiler]) -> None:
    """Every check passes, and the words of each spoiler name exactly one check."""
    checks = import_module(f"lsvib.datasets.{figure}").checks(dataset_of(figure))
    assert [check.sentence() for check in checks if not check.passed] == []
    hits = {words: [check.claim for check in checks if words in check.claim] for words in spoilers}
    assert {words: len(found) for words, found in hits.items()} == dict.fromkeys(hits, 1)
    assert {claim for found in hits.values() for claim in found} == {check.claim for check in checks}


def assert_check_fails(figure: str, words: str, spoiler: Spoiler) -> None:
    """The one check that has these words in its claim fails on spoiled data."""
    checks = import_module(f"lsvib.datasets.{figure}").checks(spoiler(dataset_of(figure)))
    assert [check.passed for check in checks if words in check.claim] == [False]


def drawn_from_file(figure: str, path: Path) -> tuple[Figure, list[str]]:
    """The figure drawn from its file, and the names in its legends, which must be different ones."""
    write_dataset(dataset_of(figure), path)
    drawn = import_module(f"lsvib.figures.{figure}").draw(read_dataset(path))
    drawn.draw_without_rendering()
    legends = [legend for part in (drawn, *drawn.subfigs) for legend in part.legends]
    names = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert names
    assert len(names) == len(set(names))
    return drawn, names
