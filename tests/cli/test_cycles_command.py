"""``lsvib cycles`` and ``lsvib follow``."""

import json

from references.command_line import refused


def test_commands(run):
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
