"""``lsvib resilience``."""

import json

import xarray as xr

import lsvib

DRIVE = ("--set", "mass=11", "--set", "support_damping=1e-3")


def test_resilience(run):
    """The command says what the method says, in numbers and in text, and writes a sweep to a file."""
    drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
    window = ("--window", "u=-0.3:0.3", "w=-150:150")
    one = (*DRIVE, "--set", "axial_force=-10", *window)
    code, out, error = run("resilience", *one, "--json")
    expected = drive.resilience({"u": (-0.3, 0.3), "w": (-150, 150)})
    assert (code, error, json.loads(out)) == (0, "", json.loads(json.dumps(expected.to_json())))
    text = run("resilience", *one)[1]
    assert f"largest tolerated perturbation of the speed: {expected.speed:.12g} rad/s\n" in text
    over = ("--over", "axial_force=-40:-10:2", "--out", "reserve.nc")
    result = json.loads(run("resilience", *DRIVE, *over, "--json")[1])
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
