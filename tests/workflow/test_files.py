"""Every variable of every file of a run, by CF-1.11, and what the files say of themselves, by ACDD-1.3."""

import numpy as np
import pytest
import xarray as xr
from conftest import ROOT

from lsvib.chapter.configuration import sources_of

pytestmark = pytest.mark.workflow


@pytest.fixture(scope="module")
def files(finished):
    """Of a run of all figures by these sources, as continuous integration makes one, or else of one of two figures."""
    for results in (ROOT / "results", finished[0].folder / "results"):
        found = {path: xr.open_dataset(path, decode_cf=False) for path in sorted(results.rglob("*.nc"))}
        if any(file.attrs.get("sources_sha256") == sources_of("fig8_08") for file in found.values()):
            return found


def test_every_variable_has_values_flags_that_differ_and_if_it_is_a_coordinate_an_order(files):
    wrong = []
    for (path, file), name in ((item, name) for item in files.items() for name in item[1].variables):
        values, about = file[name].values, file[name].attrs
        words, flags = about.get("flag_meanings", "").split(), np.atleast_1d(about.get("flag_values", []))
        told = not words or (len({*words}) == len(words) == np.unique(flags).size and np.isin(values, flags).all())
        ordered = file[name].dims != (name,) or {*np.sign(np.diff(values.astype(float)))} in (set(), {1.0}, {-1.0})
        if np.isnan(values).all() or not (told and ordered and about["units"] and about["long_name"]):
            wrong.append(f"{path}: {name}")
    assert wrong == []


def test_every_file_says_who_made_it_of_what_and_when(files):
    for path, file in files.items():
        assert all(map(file.attrs.get, ("summary", "keywords", "creator_name", "settings", "sources_sha256"))), path
        assert ("date_created" in file.attrs) == (file.git_commit != "unknown"), path
