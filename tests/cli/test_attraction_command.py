"""`lsvib attraction`: its dataset, its words, what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from references.command_line import DRIVE, GRID


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
