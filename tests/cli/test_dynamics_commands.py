"""`lsvib attraction`, `cycles`, `follow` and `resilience`: datasets, words, and that they say what the methods say."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from references.command_line import DRIVE, GRID, refused

import lsvib


def test_attraction_json_and_dataset(run):
    code, out, error = run("attraction", *DRIVE, *GRID, "--quantities", "time", "seizures", "first_event",
                           "--out", "map.nc", "--figure", "map.png", "--json")  # fmt: skip
    assert code == 0
    result = json.loads(out)
    keys = {"cells", "fractions", "unresolved", "unresolved_because", "exact_basin_area", "cells_per_second"}
    assert set(result) == keys
    assert result["cells"] == 1200
    assert result["unresolved"] == 0
    assert sum(result["fractions"].values()) == pytest.approx(1.0, abs=1e-15)
    assert error.splitlines()[-1] == "100 % of 30 rows"
    with xr.open_dataset("map.nc") as written:
        assert written.label.dims == ("velocity_deviation", "angle_deviation")
        assert written.angle_deviation.values[0] == -0.1 + 0.5 * 0.2 / 40
        assert (written.label == 0).mean().item() == result["fractions"]["steady_sliding"]
        assert written.fraction.sel(attractor=2).item() == result["fractions"]["sprag_slip_cycle"]
        names = {"settling_time", "seizures", "first_event", "cycle_angle", "contact_line_angle"}
        assert names | {"friction_coefficient"} <= set(written)
        assert np.isfinite(written.settling_time).all()
    assert Path("map.png").stat().st_size > 10_000
    assert Path("map.pdf").is_file()


def test_attraction_text_says_shares_of_cells(run):
    lines = run("attraction", *DRIVE, *GRID, "--out", "map.nc")[1].splitlines()
    found = [line.rsplit(": ", 1)[1].split() for line in lines if "% of" in line]
    assert sum(float(words[0]) for words in found) == pytest.approx(100, rel=1e-5)
    for words in found:
        assert words[1:] == ["%", "of", "1200", "cells"]
        cells = float(words[0]) * 12
        assert cells == pytest.approx(round(cells), rel=1e-5)


def test_cycles_and_follow(run):
    """``lsvib cycles`` lists the pair near the fold; ``lsvib follow`` goes from one through the fold to the other."""
    drive = ["--set", "mass=11", "--set", "support_damping=2e-3", "--set", "axial_force=-18.37"]
    listed = json.loads(run("cycles", *drive, "--json")[1])["cycles"]
    assert [cycle["attracting"] for cycle in listed] == [True, False]
    keys = {"label", "attracting", "period", "multipliers", "amplitude", "state", "residual"}
    assert all(keys <= set(cycle) for cycle in listed)
    assert "repelling" in run("cycles", *drive)[1]
    over = ["--over", "axial_force=-18.38:-18.36", "--points", "30"]
    branch = json.loads(run("follow", *drive, *over, "--out", "branch.nc", "--json")[1])
    assert {point["attracting"] for point in branch["points"]} == {True, False}
    assert "fold" in [change["kind"] for change in branch["changes"]]
    assert "KEY=LOW:HIGH" in refused(run, "follow", *drive, "--over", "axial_force=-18")
    assert "1 <= cycle <= 2" in refused(run, "follow", *drive, *over, "--cycle", "3")


def test_resilience(run):
    """The command says what the method says, in numbers and in text, and writes a sweep to a file."""
    drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
    window = ("--window", "u=-0.3:0.3", "w=-150:150")
    one = (*DRIVE, *window)
    code, out, error = run("resilience", *one, "--json")
    expected = drive.resilience({"u": (-0.3, 0.3), "w": (-150, 150)})
    assert (code, error, json.loads(out)) == (0, "", json.loads(json.dumps(expected.to_json())))
    text = run("resilience", *one)[1]
    assert f"largest tolerated perturbation of the speed: {expected.speed:.12g} rad/s\n" in text
    over = ("--over", "axial_force=-40:-10:2", "--out", "reserve.nc")
    result = json.loads(run("resilience", *DRIVE[:4], *over, "--json")[1])
    assert result == {"points": 2, "not_covered": 0}
    with xr.open_dataset("reserve.nc") as found:
        assert found.fatal_speed.values.tolist() == [float("inf"), expected.speed]


def test_where_every_perturbation_is_tolerated_none_has_a_limit(run):
    """In words, not as infinite numbers and states that are none; JSON has null for them."""
    text = run("resilience", "--set", "mass=1")[1]
    assert text.count(": none\n") == 1  # the boundary of the region
    assert text.count(": unlimited\n") == 3  # of each of the perturbations
    assert "inf" not in text.replace("boundary of the region of attraction", "")
    assert "nan" not in text
    assert json.loads(run("resilience", "--set", "mass=1", "--json")[1])["energy"] is None
