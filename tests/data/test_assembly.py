"""A dataset from its tiles: the same for every tiling, and one sentence for a tile that does not fit."""

import os

import numpy as np
import pytest
import xarray as xr

from lsvib.basins.grid import Grid
from lsvib.data.assembly import TilePlace, gather, overview, write_tile
from lsvib.data.tiles import layout, tile_place
from lsvib.data.writer import read_dataset
from lsvib.errors import InputError

ROWS, COLUMNS = 37, 58
SETTINGS = {"some": 1}
LABELS = {"flag_values": np.array([-1, 0, 2], np.int8), "flag_meanings": "unresolved steady cycle"}
METADATA = {"title": "test", "source": "test", "references": "none"}


def whole(rows=ROWS, columns=COLUMNS):
    """A map with all labels, and times of which some are missing."""
    u, w = np.linspace(-1, 1, columns), np.linspace(-2, 2, rows)
    distance = np.hypot(u, w[:, None])
    label = np.select([distance > 2, distance < 1], [-1, 0], 2).astype(np.int8)
    time = np.where(label < 0, np.nan, distance)
    return xr.Dataset(
        {
            "label": (("w", "u"), label, {"units": "1", "long_name": "attractor", **LABELS}),
            "time": (("w", "u"), time, {"units": "s", "long_name": "time"}),
            "mass": ((), 11.0, {"units": "kg", "long_name": "mass"}),
        },
        coords={
            "w": ("w", w, {"units": "rad s-1", "long_name": "rate", "cell_width": 4 / (rows - 1)}),
            "u": ("u", u, {"units": "rad", "long_name": "deviation", "cell_width": 2 / (columns - 1)}),
        },
        attrs=METADATA,
    )


def tiles_of(dataset, count, folder, settings=SETTINGS):
    """Write the tiles of a map; return their places by file."""
    rows, columns = dataset.sizes["w"], dataset.sizes["u"]
    places = {folder / f"{k}-of-{count}.nc": tile_place(f"{k}-of-{count}", rows, columns) for k in range(1, count + 1)}
    for path, place in places.items():
        write_tile(dataset.drop_vars("mass").isel(w=place.rows, u=place.columns), place, settings, path)
    return places


def frame(dataset):
    return dataset.drop_vars(["label", "time"])


@pytest.fixture
def places(tmp_path):
    return tiles_of(whole(), 6, tmp_path)


@pytest.mark.parametrize("count", [1, 6, 7])
def test_the_map_is_the_same_for_every_tiling(count, tmp_path):
    told = []
    gather(frame(whole()), SETTINGS, tiles_of(whole(), count, tmp_path), tmp_path / "map.nc", lambda *n: told.append(n))
    gathered = read_dataset(tmp_path / "map.nc")
    assert all(gathered[name].variable.identical(whole()[name].variable) for name in whole().variables)
    values, counts = np.unique(whole().label, return_counts=True)
    assert gathered.attractor.values.tolist() == values.tolist()
    assert gathered.cell_count.values.tolist() == counts.tolist()
    assert gathered.fraction.values == pytest.approx(counts / counts.sum(), abs=1e-15)
    assert told[-1] == (count, count)


def test_overview_takes_the_middle_of_each_block(places, tmp_path):
    gather(frame(whole()), SETTINGS, places, tmp_path / "map.nc")
    full = read_dataset(tmp_path / "map.nc")
    coarse = overview(tmp_path / "map.nc", most=15)
    expected = full.isel(w=slice(1, 36, 3), u=slice(2, 56, 4))  # 12 whole blocks of 3 rows, 14 of 4 columns
    assert coarse.label.values.tolist() == expected.label.values.tolist()
    assert coarse.cell_count.identical(full.cell_count)
    for name, step in (("w", 3), ("u", 4)):
        blocks = full[name].values[: coarse.sizes[name] * step].reshape(-1, step)
        assert coarse[name].values == pytest.approx(blocks.mean(axis=1), abs=1e-15)
        assert coarse[name].cell_width == pytest.approx(np.diff(coarse[name].values).mean(), rel=1e-12)
    assert overview(tmp_path / "map.nc").identical(full)


def truncate(path):
    os.truncate(path, path.stat().st_size // 2)


def other_settings(path):
    write_tile(whole().isel(w=slice(0, 18), u=slice(0, 19)), TilePlace(0, 18, 0, 19), {"some": 2}, path)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (truncate, "is damaged"),
        (other_settings, "is no tile of this map"),
        (lambda path: path.unlink(), "does not exist"),
    ],
)
def test_a_tile_that_does_not_fit_is_refused_in_one_sentence(damage, words, places, tmp_path):
    tile = next(iter(places))
    damage(tile)
    with pytest.raises(InputError) as error:
        gather(frame(whole()), SETTINGS, places, tmp_path / "map.nc")
    assert str(error.value).startswith(str(tile))
    assert words in str(error.value)
    assert not list(tmp_path.glob("*map.nc*"))


@pytest.mark.parametrize(
    ("tiles", "rows", "columns", "expected"),
    [(6, 40, 60, (2, 3)), (6, 60, 40, (3, 2)), (100, 20000, 20000, (10, 10)), (7, 40, 60, (1, 7)), (4, 2, 300, (1, 4))],
)
def test_layout_is_the_one_with_the_squarest_tiles(tiles, rows, columns, expected):
    assert layout(tiles, rows, columns) == expected


@pytest.mark.parametrize(("tiles", "rows", "columns"), [(6, 40, 60), (7, 41, 59), (1, 1, 1), (12, 5, 5)])
def test_windows_cover_each_cell_once(tiles, rows, columns):
    seen = np.zeros((rows, columns), int)
    for k in range(tiles):
        place = tile_place(f"{k + 1}-of-{tiles}", rows, columns)
        assert min(place.shape) > 0
        seen[place.rows, place.columns] += 1
    assert (seen == 1).all()


def test_more_tiles_than_a_map_can_have_are_refused():
    with pytest.raises(InputError, match="tiles = 7 cannot divide a map of 6 x 4 cells"):
        layout(7, 4, 6)


SPAN = {"start": -1.0, "stop": 1.0, "count": 3}


def test_the_axes_do_not_depend_on_the_order_in_which_they_are_written():
    one, other = Grid.of({"u": SPAN, "w": SPAN}), Grid.of({"w": SPAN, "u": SPAN})
    assert one == other
    assert (one.x.coordinate, one.y.coordinate) == ("u", "w")
    slice_of_threads = Grid.of({"e": 0.0, "w": SPAN, "u": 0.5, "v": SPAN})
    assert (slice_of_threads.x.coordinate, slice_of_threads.y.coordinate) == ("w", "v")
    assert slice_of_threads.fixed == {"e": 0.0, "u": 0.5}


@pytest.mark.parametrize(
    ("grid", "words"),
    [
        ({"u": SPAN, "x": SPAN}, "coordinate 'x', which is not one of u, w"),
        ({"u": SPAN, "w": 1.0}, "spans 1 coordinates"),
        ({"u": SPAN, "w": {"start": 0.0, "stop": 1.0}}, "axis w has the keys start, stop; it needs"),
        ({"u": SPAN, "w": {**SPAN, "stop": -2.0}}, "it needs start < stop"),
    ],
)
def test_a_grid_that_is_not_acceptable_is_refused(grid, words):
    with pytest.raises(InputError, match=words):
        Grid.of(grid)
