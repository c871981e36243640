"""Files: metadata, what is refused, nothing left after a failure; a map from its tiles, its picture, and grids."""

import errno
import json
import os
import subprocess

import numpy as np
import pytest
import xarray as xr

import lsvib
from lsvib import files
from lsvib.answers import io
from lsvib.answers.io import read_dataset, table_of, write_dataset
from lsvib.answers.map import gather_map, map_tile, rows_of
from lsvib.chapter.build import overview
from lsvib.errors import InputError, LsvibError
from lsvib.systems.grid import Grid


def example() -> xr.Dataset:
    kinds = np.array([0, 1, 1], dtype=np.int8)
    flags = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "rest slip"}
    return xr.Dataset(
        {
            "force": ("time", [1.0, np.nan, 3.0], {"units": "N", "long_name": "contact force"}),
            "speed": ("time", [1.0, 2.0, 3.0], {"units": "rad s-1", "long_name": "speed of the screw"}),
            "mode": ("time", kinds, {"units": "1", "long_name": "mode", **flags}),
        },
        coords={
            "time": ("time", [0.0, 0.1, 0.2], {"units": "s", "long_name": "time"}),
            "mass": ((), 1.5, {"units": "kg", "long_name": "translating mass"}),
        },
        attrs={"title": "example", "source": "test", "references": "none"},
    )


def test_round_trip_keeps_values_and_attributes(tmp_path):
    write_dataset(example(), tmp_path / "a.nc")
    back = read_dataset(tmp_path / "a.nc")
    for name, variable in example().variables.items():
        np.testing.assert_array_equal(back[name].values, variable.values)
        assert back[name].dtype == variable.dtype
        assert {k: list(np.ravel(v)) for k, v in back[name].attrs.items()} == {
            k: list(np.ravel(v)) for k, v in variable.attrs.items()
        }
    assert set(back.coords) == {"time"}  # one without dimensions would be in every title
    assert back.attrs["Conventions"] == "CF-1.11"
    assert back.attrs["title"] == "example"
    assert back.attrs["summary"] == "example. Over time: contact force; speed of the screw; mode."
    assert json.loads(back.attrs["package_versions"])["numpy"] == np.__version__
    assert os.listdir(tmp_path) == ["a.nc"]


def test_the_date_is_that_of_the_commit_and_left_out_without_one(tmp_path):
    (tmp_path / "a.py").touch()
    assert io._git_state(tmp_path / "a.py") == {"git_commit": "unknown", "git_dirty": "unknown"}
    git, date = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a"], "2001-02-03T04:05:06+07:00"
    for words in ("init -q", "add a.py", "commit -q -m one"):
        subprocess.run([*git, *words.split()], env=os.environ | {"GIT_COMMITTER_DATE": date}, check=True)
    assert io._git_state(tmp_path / "a.py")["date_created"] == date


def test_a_table_has_units_words_and_empty_cells():
    rows = ["time [s],force [N],speed [rad s-1],mode", "0.0,1.0,1.0,rest", "0.1,,2.0,slip", "0.2,3.0,3.0,slip", ""]
    assert table_of(example()).to_csv(index=False) == "\n".join(rows)


def test_fill_value_only_where_values_are_missing(tmp_path):
    write_dataset(example(), tmp_path / "a.nc")
    with xr.open_dataset(tmp_path / "a.nc", decode_cf=False) as raw:
        filled = {name for name, variable in raw.variables.items() if "_FillValue" in variable.attrs}
        assert filled == {"force"}
        assert "coordinates" not in raw.attrs


def without(name: str, attribute: str) -> xr.Dataset:
    dataset = example()
    del (dataset[name] if name else dataset).attrs[attribute]
    return dataset


@pytest.mark.parametrize(
    ("dataset", "words"),
    [
        (without("", "title"), "title is missing"),
        (without("", "references"), "references is missing"),
        (without("force", "units"), "variable force has no units"),
        (without("time", "long_name"), "variable time has no long_name"),
        (without("mode", "flag_values"), "variable mode is a flag variable"),
        (example().assign(mode=example().mode.assign_attrs(flag_meanings="rest rest")), "needs distinct flag_values"),
        (example().assign(mode=example().mode.astype("int16").assign_attrs(example().mode.attrs)), "type int8"),
        (example().assign(mode=(example().mode + np.int8(1)).assign_attrs(example().mode.attrs)), "not in flag_values"),
        (example().assign(force=example().force.assign_attrs(units="1e-3 N")), "units '1e-3 N'"),
        (example().assign(force=example().force.assign_attrs(units="N/m")), "units 'N/m'"),
        (example().assign(force=example().force.assign_attrs(exact=True)), "attribute exact of type bool"),
        (example().assign(name=("time", ["a", "b", "c"])), "variable name has the type"),
        (example().assign(moving=("time", [True, False, True])), "variable moving has the type bool"),
        (example().assign_coords(time=example().time.where(example().time > 0)), "missing values"),
        (example().rename(force="contact force"), "letters, digits and underscores"),
    ],
)
def test_refuses_incomplete_metadata(tmp_path, dataset, words):
    with pytest.raises(InputError, match=words) as caught:
        write_dataset(dataset, tmp_path / "a.nc")
    assert "\n" not in str(caught.value)
    assert os.listdir(tmp_path) == []


def test_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    write_dataset(example(), tmp_path / "a.nc")
    before = (tmp_path / "a.nc").read_bytes()

    def full(*arguments, **options):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(xr.Dataset, "to_netcdf", full)
    with pytest.raises(LsvibError, match="No space left on device"):
        write_dataset(example(), tmp_path / "a.nc")
    assert (tmp_path / "a.nc").read_bytes() == before
    assert os.listdir(tmp_path) == ["a.nc"]


@pytest.mark.parametrize("content", [b"", b"this is not netCDF", b"\x89HDF\r\n\x1a\n" + bytes(100)])
def test_corrupt_file_is_one_sentence(tmp_path, content):
    (tmp_path / "a.nc").write_bytes(content)
    with pytest.raises(InputError, match="is not a readable netCDF file"):
        read_dataset(tmp_path / "a.nc")


def test_json_has_no_nan(tmp_path):
    with pytest.raises(ValueError, match="Out of range"):
        files.write_json([float("nan")], tmp_path / "a.json")
    assert os.listdir(tmp_path) == []


MAPPED = lsvib.Drive(mass=11.0, support_damping=1e-3, axial_force=-10.0)


def test_overview_takes_the_middle_of_each_block(tmp_path):
    full = MAPPED.attraction({"u": (-0.1, 0.1, 58), "w": (-50, 50, 37)}, quantities=["time"])
    write_dataset(full, tmp_path / "map.nc")
    coarse = overview(tmp_path / "map.nc", most=15)
    blocks = {"w": (slice(1, 36, 3), 3), "u": (slice(2, 55, 5), 5)}  # 12 whole ones, 11
    expected = full.isel({name: middles for name, (middles, _) in blocks.items()})
    for name in ("label", "settling_time", *blocks):
        np.testing.assert_array_equal(coarse[name], expected[name])
    for name, (_, cells) in blocks.items():
        assert coarse[name].cell_width == cells * full[name].cell_width
    assert len(np.unique(expected.label)) == 2
    assert overview(tmp_path / "map.nc").drop_attrs().identical(full.drop_attrs())


def test_a_map_in_tiles_is_the_map(tmp_path):
    span = {"start": -0.3, "stop": 0.3, "count": 7}, {"start": -150.0, "stop": 150.0, "count": 5}
    settings = {"drive": dict(MAPPED), "grid": dict(zip("uw", span, strict=True)), "quantities": ["label", "time"]}
    tiles = [tmp_path / f"{k}-of-3.nc" for k in range(1, 4)]
    for tile in tiles:
        map_tile(settings, tile.stem, tile)
    gather_map(settings, tiles, tmp_path / "map.nc")
    write_dataset(MAPPED.attraction(settings["grid"], quantities=["time"]), tmp_path / "one.nc")
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
    one, other = (Grid.of(spans, ("u", "w")) for spans in ({"u": SPAN, "w": SPAN}, {"w": SPAN, "u": SPAN}))
    assert one == other
    assert (one.x.coordinate, one.y.coordinate) == ("u", "w")
    slice_of_threads = Grid.of({"e": 0.0, "w": SPAN, "u": 0.5, "v": SPAN}, ("u", "w", "e", "v"))
    assert (slice_of_threads.x.coordinate, slice_of_threads.y.coordinate) == ("w", "v")
    assert slice_of_threads.fixed == {"e": 0.0, "u": 0.5}
