"""Ways to map a region of attraction, judged by the exact boundary of the basin."""

import json

import numpy as np
import pytest

from benchmarks.maps.map_methods import METHODS, MapMethod, Rule
from benchmarks.maps.map_race import MapOutcome, RaceBox, beside_boundary, contest, strip_share, wrong_share
from lsvib.basins.clipping import Window
from lsvib.basins.exact_basin import basin
from lsvib.basins.mapper import mapper
from lsvib.cycles.attractors import Attractor
from lsvib.drives.parameters import RigidParameters
from lsvib.errors import InputError

NEAR = RaceBox(RigidParameters.of(mass=11.0, support_damping=1e-3, axial_force=-10.0), Window(-0.05, 0.05, -15.0, 15.0))
LATE = RaceBox(RigidParameters.of(mass=11.0, support_damping=3e-3, axial_force=-12.3), Window(-0.3, 0.3, -150.0, 150.0))
DISTANCES = np.array([1e-9, 1e-6, 1e-3])


@pytest.mark.parametrize("box", [NEAR, LATE])
def test_starts_beside_the_boundary_lie_on_either_side(box):
    exact = basin(box.drive)
    starts, length = beside_boundary(exact, box.window, DISTANCES, 20, 1)
    assert starts.shape == (3, 2, 20, 2)
    inside = np.array([exact.contains(start) for start in starts.reshape(-1, 2)]).reshape(3, 2, 20)
    # A point that lies within 1e-3 of a corner may have the same side twice.
    assert (inside[:2, 0] != inside[:2, 1]).all()
    assert (inside[2, 0] != inside[2, 1]).sum() >= 18
    widths = np.array([box.window.right - box.window.left, box.window.top - box.window.bottom])
    apart = np.hypot(*np.moveaxis((starts[:, 0] - starts[:, 1]) / widths, -1, 0))
    np.testing.assert_allclose(apart[2], 2e-3, rtol=1e-9)
    np.testing.assert_allclose(apart[1], 2e-6, rtol=1e-6)
    assert length >= 1.0  # both boundaries pass through their box


def test_a_box_without_boundary_is_refused():
    with pytest.raises(InputError, match="does not pass through the box"):
        beside_boundary(basin(NEAR.drive), Window(0.5, 0.6, 0.0, 1.0), DISTANCES, 2, 1)


def test_share_of_a_strip():
    """Labels that are all wrong up to a distance d, right beyond: a strip of width 2 d along the boundary."""
    distances = np.linspace(0.01, 0.1, 10)
    wrong = np.where(distances < 0.055, 1.0, 0.0)
    assert strip_share(distances, wrong, 3.0) == pytest.approx(2 * 3.0 * 0.055)
    assert strip_share(distances, np.zeros(10), 3.0) == pytest.approx(2 * 3.0 * 0.01)
    many, few = (MapOutcome(1.0, 1000, n, 0, wrong, np.zeros(10)) for n in (100, 3))
    assert wrong_share(many, distances, 3.0) == 0.1
    assert wrong_share(few, distances, 3.0) == strip_share(distances, wrong, 3.0)


def test_wrong_and_undecided_labels_are_counted(monkeypatch):
    """A map that calls all of a lower half undecided and the rest steady sliding."""

    def half(_):
        def fill(x, y, labels):
            labels[...] = np.where(y < 0, Attractor.UNRESOLVED, Attractor.STEADY_SLIDING)[:, None]

        return fill

    monkeypatch.setitem(METHODS, "half", MapMethod("half", Rule.TABLE, half))
    found, _ = contest(NEAR, {"half": 40}, 1, DISTANCES, 10, 1)
    exact = basin(NEAR.drive)
    x, y = NEAR.grid(40)
    outside = sum(not exact.contains((u, w)) for w in y if w > 0 for u in x)
    assert found["half"].undecided_cells == 800
    assert found["half"].wrong_cells == outside > 100
    assert (0 < found["half"].wrong).all()
    np.testing.assert_allclose(found["half"].wrong[0] + found["half"].undecided[0] / 2, 0.5)  # one of two sides


def test_an_unknown_method_is_refused():
    with pytest.raises(InputError, match="'guess' is not one of engine"):
        contest(NEAR, {"guess": 3}, 1, DISTANCES, 2, 1)


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setattr("benchmarks.rivals.method_list.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"package scipy, which .* needs, is not installed"):
        METHODS["lsoda"].prepare(mapper(NEAR.drive))


@pytest.mark.long
@pytest.mark.parametrize("box", [NEAR, LATE])
def test_rivals_map_the_same_but_for_the_boundary(box):
    cells = {"engine": 60, "followed": 60, "rk4_coarse": 60, "rk4_fine": 40, "lsoda": 10}
    found, _ = contest(box, cells, 1, DISTANCES, 40, 1)
    assert found["engine"].wrong_cells == found["engine"].undecided_cells == 0
    assert not found["engine"].wrong.any()
    assert found["rk4_coarse"].wrong_cells <= 2  # a strip of some 1e-5 of the box
    assert found["rk4_fine"].wrong_cells == 0
    assert found["rk4_coarse"].wrong[0] > 0.1  # 1e-9 from the boundary steps of 1e-4 s are blind
    assert found["rk4_coarse"].wrong[2] == found["rk4_fine"].wrong[2] == 0
    assert found["lsoda"].wrong_cells <= 1
    # On LATE a motion may seize three times and settle all the same: the third seizure proves nothing.
    assert (found["followed"].wrong_cells > 360) == (box is LATE)
    assert all(outcome.seconds > 0 for outcome in found.values())


@pytest.mark.long
def test_the_dataset_of_a_small_contest(tmp_path):
    from benchmarks.figures.map_precision import dataset as map_precision
    from benchmarks.figures.map_precision import picture as figure
    from lsvib.data.writer import read_dataset, write_dataset

    window = dict(zip(("left", "right", "bottom", "top"), NEAR.window, strict=True))
    box = {"drive": {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}, "window": window, "ratio_floor": 2.0}
    settings = {
        "boxes": {"near": box}, "cells": {"engine": 60, "rk4_coarse": 40, "lsoda": 0}, "repeats": 3,
        "distances": {"start": 1e-12, "stop": 1e-1, "count": 12}, "starts": 10, "seed": 1,
    }  # fmt: skip
    dataset = map_precision.build(settings).assign_attrs(settings=json.dumps(settings))
    write_dataset(dataset, tmp_path / "map.nc")
    dataset = read_dataset(tmp_path / "map.nc")
    assert all(check.passed for check in map_precision.checks(dataset))
    assert len(figure.draw(dataset).axes) >= 2
    assert 0 < float(dataset.reach[1, 0]) < 1e-3  # steps have their limit
    for name, index in (("wrong_cells", (0, 0)), ("undecided_near", (0, 0, 5))):
        spoilt = dataset.copy(deep=True)
        spoilt[name].values[index] = 1
        assert not map_precision.checks(spoilt)[0].passed
    slow = dataset.assign(time_per_label=dataset.time_per_label.copy(data=np.ones((2, 1))))
    assert not map_precision.checks(slow)[-1].passed
