"""Each figure of the benchmarks on a few cases: its checks pass, fail on spoiled data, and its file alone is drawn."""

import re
from contextlib import suppress
from functools import cache

import numpy as np
import pytest
import xarray as xr

from benchmarks import accuracy_page
from benchmarks.record import Verdict
from lsvib.datasets.io import write_dataset
from lsvib.figures.configuration import accuracy_figures, load
from lsvib.figures.style import save

DRIVE = {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}
SETTINGS = {
    "ablation": {"duration": 0.3, "repeats": 3, "fresh": 1, "compile": ["planar"]},
    "map_precision": {
        "boxes": {"near": {"drive": DRIVE, "window": {"left": -0.05, "right": 0.05, "bottom": -15.0, "top": 15.0}}},
        "cells": {"engine": 60, "rk4_coarse": 40},
        "repeats": 3,
        "distances": {"start": 1e-12, "stop": 1e-1, "count": 12},
        "starts": 10,
        "seed": 1,
    },
    "rival_verdicts": {
        "seed": 3,
        "counts": {"axial_force": 6, "time_span": 2},
        "methods": {"dop853": [1e-6], "rk4_refined": [1e-6]},
    },
    "stability_sweeps": {"seed": 1, "counts": {"contact": 1, "axial_force": 6, "critical_mass": 1}, "thorough": 1},
    "work_precision": {
        "scenes": ["stick_slip", "sprag_graze"],
        "shorten": 0.3,
        "methods": {"exact": [0], "rk4_refined": [1e-4, 1e-5], "dop853": [1e-3, 1e-9]},
        "repeats": 2,
        "seconds": 0.0,
        "limit": 5.0,
        "error_levels": [1e-3, 1e-9],
        "grids": [8, 12],
        "sweep": {"count": 20, "judged": 3, "methods": {"rk4_refined": [1e-5]}},
    },
}


@cache
def built(figure: str) -> xr.Dataset:
    pytest.importorskip("scipy")
    with pytest.MonkeyPatch.context() as patch:  # to compile the engine anew, and to import again, takes a minute
        patch.setattr("benchmarks.ablation.cost_of_starting.compilation", lambda kinds: (60, 9.0))
        return load(figure).build(SETTINGS[figure])


def passed(figure: str, dataset: xr.Dataset) -> dict[str, bool]:
    return {check.claim: check.passed for check in load(figure).checks(dataset)}


@pytest.mark.slow
@pytest.mark.parametrize("figure", accuracy_figures())
def test_every_check_passes(figure):
    assert [claim for claim, good in passed(figure, built(figure)).items() if not good] == []


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
@pytest.mark.parametrize("figure", accuracy_figures())
def test_every_check_refuses_something(figure):
    refused = set()
    for dataset in spoiled(built(figure)):
        with suppress(ValueError, IndexError, RuntimeWarning):
            refused |= {claim for claim, good in passed(figure, dataset).items() if not good}
    assert passed(figure, built(figure)).keys() - refused == set()


@pytest.mark.slow
@pytest.mark.parametrize("figure", accuracy_figures())
def test_no_run_time_decides(figure):
    """Of times and their ratios other numbers, and every check says the same to the letter."""
    dataset = built(figure).copy(deep=True)
    measured = [name for name in dataset if re.search("run_time|build_|_time$|time_per|ratio", str(name))]
    measured = [name for name in measured if "event" not in str(name)]
    assert measured or figure in ("rival_verdicts", "stability_sweeps")
    for name in measured:
        dataset[name] = 1e-3 / dataset[name]
    assert list(map(str, load(figure).checks(dataset))) == list(map(str, load(figure).checks(built(figure))))


@pytest.mark.slow
def test_the_page_of_the_documentation_is_made_from_datasets(tmp_path, monkeypatch):
    """A section with a picture and the commit for each figure, drawn from its file; tables with its numbers."""
    for folder in ("run/datasets", "docs/figures"):
        (tmp_path / folder).mkdir(parents=True)
    for figure in accuracy_figures():
        write_dataset(built(figure), tmp_path / "run/datasets" / f"{figure}.nc")
    drawn = []
    monkeypatch.setattr(
        accuracy_page, "save", lambda figure, *to, **how: (drawn.append(figure), save(figure, *to, **how))
    )
    accuracy_page.main(tmp_path / "run", tmp_path / "docs")
    assert all(any(axes.has_data() for axes in figure.axes) for figure in drawn)
    page = (tmp_path / "docs/accuracy.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\(figures/(\w+)\.png\)", page)) == set(accuracy_figures())
    assert all((tmp_path / "docs/figures" / f"{figure}.png").is_file() for figure in accuracy_figures())
    assert page.count("Computed at commit ") == 1
    assert f"{float(built('work_precision').state_error[0, 0, 0]):.1e}" in page
