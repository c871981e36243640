"""A map from its tiles, the picture of a large one, and grids."""

import numpy as np
import pytest
import xarray as xr

import lsvib
from lsvib.basins.grid import Grid
from lsvib.datasets.io import read_dataset, write_dataset
from lsvib.datasets.map import gather_map, map_tile, rows_of
from lsvib.figures.build import overview

ROWS, COLUMNS = 37, 58
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


def test_overview_takes_the_middle_of_each_block(tmp_path):
    full = whole()
    write_dataset(full, tmp_path / "map.nc")
    coarse = overview(tmp_path / "map.nc", most=15)
    expected = full.isel(w=slice(1, 36, 3), u=slice(2, 55, 5))  # 12 whole blocks of 3 rows, 11 of 5 columns
    assert coarse.label.values.tolist() == expected.label.values.tolist()
    for name, step in (("w", 3), ("u", 5)):
        assert coarse[name].cell_width == pytest.approx(np.diff(coarse[name].values).mean(), rel=1e-12)
        assert coarse[name].values.tolist() == full[name].values[step // 2 : coarse.sizes[name] * step : step].tolist()
    assert overview(tmp_path / "map.nc").drop_attrs().identical(full.drop_attrs())


def test_a_map_in_tiles_is_the_map(tmp_path):
    span = {"start": -0.3, "stop": 0.3, "count": 7}, {"start": -150.0, "stop": 150.0, "count": 5}
    drive = {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}
    settings = {"drive": drive, "grid": dict(zip("uw", span, strict=True)), "quantities": ["label", "time"]}
    tiles = [tmp_path / f"{k}-of-3.nc" for k in range(1, 4)]
    for tile in tiles:
        map_tile(settings, tile.stem, tile)
    gather_map(settings, tiles, tmp_path / "map.nc")
    one = lsvib.Drive(**drive).attraction(settings["grid"], quantities=["time"])
    write_dataset(one, tmp_path / "one.nc")
    assert read_dataset(tmp_path / "map.nc").identical(read_dataset(tmp_path / "one.nc"))
    tiles[1].unlink()
    with pytest.raises(lsvib.InputError, match=r"2-of-3\.nc does not exist"):
        gather_map(settings, tiles, tmp_path / "map.nc")


def test_more_tiles_than_rows_are_refused():
    assert [rows_of(f"{k}-of-3", 7) for k in (1, 2, 3)] == [slice(0, 2), slice(2, 4), slice(4, 7)]
    with pytest.raises(lsvib.InputError, match="tiles = 7 is outside the allowed range 1 <= tiles <= 4"):
        rows_of("1-of-7", 4)


SPAN = {"start": -1.0, "stop": 1.0, "count": 3}


def test_the_axes_do_not_depend_on_the_order_in_which_they_are_written():
    one, other = Grid.of({"u": SPAN, "w": SPAN}), Grid.of({"w": SPAN, "u": SPAN})
    assert one == other
    assert (one.x.coordinate, one.y.coordinate) == ("u", "w")
    slice_of_threads = Grid.of({"e": 0.0, "w": SPAN, "u": 0.5, "v": SPAN})
    assert (slice_of_threads.x.coordinate, slice_of_threads.y.coordinate) == ("w", "v")
    assert slice_of_threads.fixed == {"e": 0.0, "u": 0.5}
