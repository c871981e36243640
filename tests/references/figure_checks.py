"""The datasets of the figures on draft settings; their checks all pass, and each fails on spoiled data."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
import xarray as xr
import yaml
from matplotlib.figure import Figure

from lsvib.data.writer import read_dataset, write_dataset
from lsvib.figures.folders import dataset_module, picture_module
from references.listed_claims import assert_listed_checks_exist

CONFIG = Path(__file__).parents[2] / "config"
STATING = [  # pictures with a line of the values that they hold for
    *(f"fig8_{number:02d}" for number in range(1, 16)),
    *("limit_process", "basin_sweep", "contact_stability", "nut_stability"),
]
Spoiler = Callable[[xr.Dataset], xr.Dataset]


def draft(figure: str) -> dict:
    """The settings of a figure as the workflow merges them for a draft."""
    full, changes = (yaml.safe_load((CONFIG / f"{name}.yaml").read_text()) for name in ("config", "draft"))

    def merge(old: dict, new: dict) -> dict:
        return {**old, **{k: merge(old[k], v) if isinstance(v, dict) else v for k, v in new.items()}}

    return merge(full[figure], changes.get(figure, {}))


@cache
def dataset_of(figure: str) -> xr.Dataset:
    return import_module(dataset_module(figure)).build(draft(figure))


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
    checks = import_module(dataset_module(figure)).checks(dataset_of(figure))
    assert [check.sentence() for check in checks if not check.passed] == []
    assert_listed_checks_exist(figure, checks)
    hits = {words: [check.claim for check in checks if words in check.claim] for words in spoilers}
    assert {words: len(found) for words, found in hits.items()} == dict.fromkeys(hits, 1)
    assert {claim for found in hits.values() for claim in found} == {check.claim for check in checks}


def assert_check_fails(figure: str, words: str, spoiler: Spoiler) -> None:
    """The one check that has these words in its claim fails on spoiled data."""
    checks = import_module(dataset_module(figure)).checks(spoiler(dataset_of(figure)))
    assert [check.passed for check in checks if words in check.claim] == [False]


def assert_each_check_fails_on_some(figure: str, dataset: xr.Dataset, spoilers: Sequence[Spoiler]) -> None:
    """Every check passes; every spoiler makes one fail at least, and all of them together every check."""
    checks = import_module(dataset_module(figure)).checks
    claims = [check.claim for check in checks(dataset)]
    assert_listed_checks_exist(figure, checks(dataset))
    assert [check.sentence() for check in checks(dataset) if not check.passed] == []
    failing = [{k for k, check in enumerate(checks(spoil(dataset))) if not check.passed} for spoil in spoilers]
    assert all(failing), failing
    assert set().union(*failing) == set(range(len(claims))), claims


def assert_states_what_is_assumed(figure: Figure, dataset: xr.Dataset) -> None:
    """The line under the picture has the symbol and every value of each parameter that the dataset marks as assumed."""
    line = figure.get_supxlabel()
    assumed = line.partition("Assumed: ")[2].replace("\n", " ")
    for name, variable in dataset.variables.items():
        origin = variable.attrs.get("origin", "")
        if not origin.startswith("assumed"):
            continue
        values = {float(value) for value in variable.values.ravel() if f" {value:g} (printed" not in origin}
        ends = values if len(values) < 6 else {min(values), max(values)}
        stated = re.split(r", \$[^$]+\$ = ", assumed.partition(f"{variable.attrs['symbol']} = ")[2])[0]
        found = [number_in(word) for word in stated.replace(" \\times ", "*").replace(",", "").split()]
        assert all(any(value == pytest.approx(x, rel=1e-3) for x in found) for value in ends), (name, line)


def number_in(word: str) -> float:
    """The number that a word of a figure's text is, with a power of ten as mathtext or plain; nan if it is none."""
    parts = re.fullmatch(r"\$?([−\d.e+-]*?)(?:\*?10\^\{(-?\d+)\})?\$?\.?", word)
    if not parts or not any(parts.groups()):
        return math.nan
    mantissa, power = parts.groups()
    return float(mantissa.replace("−", "-") or 1) * 10.0 ** int(power or 0)


def assert_drawn_from_file(figure: str, dataset: xr.Dataset, path: Path) -> list[str]:
    """The file alone gives a figure with something in every panel; return the names in its legends, all different."""
    write_dataset(dataset, path)
    drawn: Figure = import_module(picture_module(figure)).draw(read_dataset(path))
    drawn.draw_without_rendering()
    assert drawn.axes
    assert all(axes.has_data() for axes in drawn.axes)
    if figure in STATING:
        assert_states_what_is_assumed(drawn, dataset)
    own = [axes.get_legend() for axes in drawn.axes]
    legends = [*(legend for part in (drawn, *drawn.subfigs) for legend in part.legends), *filter(None, own)]
    names = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert len(names) == len(set(names))
    return names


def figure_tests(spoilers: Mapping[str, Mapping[str, Spoiler]]) -> tuple[Callable, Callable, Callable]:
    """Return three tests for the figures whose spoilers are given, by words of the one check that each must spoil."""

    @pytest.mark.parametrize("figure", spoilers)
    def every_check_passes_and_has_a_spoiler(figure):
        assert_checks_pass(figure, spoilers[figure])

    @pytest.mark.parametrize(
        ("figure", "words"), [(figure, words) for figure in spoilers for words in spoilers[figure]]
    )
    def check_fails_on_spoiled_data(figure, words):
        assert_check_fails(figure, words, spoilers[figure][words])

    @pytest.mark.parametrize("figure", spoilers)
    def figure_is_drawn_from_the_file(figure, tmp_path):
        assert assert_drawn_from_file(figure, dataset_of(figure), tmp_path / "a.nc")

    return every_check_passes_and_has_a_spoiler, check_fails_on_spoiled_data, figure_is_drawn_from_the_file
