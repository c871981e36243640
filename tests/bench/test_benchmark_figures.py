"""Each race of the benchmarks on a few cases: its checks pass, and fail on spoiled data."""

import re
from contextlib import suppress
from functools import cache

import numpy as np
import pytest
import xarray as xr
from references.figure_checks import without_room

from benchmarks.judge import Verdict
from lsvib.chapter.build import drawn
from lsvib.chapter.configuration import load

SETTINGS = {
    "ablation": {"duration": 0.3, "repeats": 3, "fresh": 1},
    "stability_sweeps": {"seed": 1, "counts": {"contact": 1, "axial_force": 6, "friction_law": 1}, "thorough": 1},
    "work_precision": {
        "scenes": ["stick_slip", "sprag_graze", "law_graze"],
        "shorten": 0.3,
        "methods": {"exact": [0], "rk4_refined": [1e-4, 1e-5], "dop853": [1e-3, 1e-9]},
        "repeats": 2,
        "seconds": 0.0,
        "limit": 5.0,
        "error_levels": [1e-3, 1e-9],
    },
}


@cache
def built(figure: str) -> xr.Dataset:
    pytest.importorskip("scipy")
    return load(figure).build(SETTINGS[figure])


def passed(figure: str, dataset: xr.Dataset) -> dict[str, bool]:
    return {check.claim: check.passed for check in load(figure).checks(dataset)}


@pytest.mark.slow
@pytest.mark.parametrize("figure", SETTINGS)
def test_every_check_passes(figure):
    assert [claim for claim, good in passed(figure, built(figure)).items() if not good] == []


@pytest.mark.slow
@pytest.mark.parametrize("figure", SETTINGS)
def test_the_words_of_its_picture_have_room(figure):
    assert without_room(drawn(figure, built(figure))) == []


def spoiled(dataset: xr.Dataset):
    """The dataset with one of its variables the same everywhere, or with one value that is another."""
    for name in dataset.data_vars:
        values = dataset[name].values
        for value in (
            (*Verdict, np.iinfo(values.dtype).max) if values.dtype.kind in "iu" else (0.0, 1e-9, 1e-3, 1.0, 1e6)
        ):
            some = values.copy()
            some[(0,) * values.ndim] = value
            for changed in (some, np.full_like(values, value)):
                yield dataset.assign({name: (dataset[name].dims, changed, dataset[name].attrs)})


@pytest.mark.slow
@pytest.mark.parametrize("figure", SETTINGS)
def test_every_check_refuses_something(figure):
    refused = set()
    for dataset in spoiled(built(figure)):
        with suppress(ValueError, IndexError, RuntimeWarning):
            refused |= {claim for claim, good in passed(figure, dataset).items() if not good}
    assert passed(figure, built(figure)).keys() - refused == set()


@pytest.mark.slow
@pytest.mark.parametrize("figure", SETTINGS)
def test_no_run_time_decides(figure):
    """Of times and their ratios other numbers, and every check says the same to the letter."""
    dataset = built(figure).copy(deep=True)
    measured = [name for name in dataset if re.search("run_time|build_|_time$|ratio", str(name))]
    measured = [name for name in measured if "event" not in str(name)]
    assert measured or figure == "stability_sweeps"
    for name in measured:
        dataset[name] = 1e-3 / dataset[name]
    assert list(map(str, load(figure).checks(dataset))) == list(map(str, load(figure).checks(built(figure))))
