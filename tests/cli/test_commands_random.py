"""Every command that takes a friction law, on drives of random data sheets: an answer, or one sentence."""

import json
import math
import re

import numpy as np
import pytest

pytest.importorskip("pint")
pytest.importorskip("scipy")

from references.random_sheets import random_drive
from references.sizes import sizes

UNKNOWNS = ("mass", "input_speed", "support_damping", "axial_force", "friction_coefficient", "lead_angle")


def commands(drive, index):
    """Return the arguments of all commands for a drive."""
    rng, speed = np.random.default_rng(index), drive.input_speed
    without = {key: [*(x for k, v in drive if k not in key for x in ("--set", f"{k}={v!r}"))] for key in
               ((), ("axial_force",), ("axial_force", "mass"))}  # fmt: skip
    force = sorted((0.5 * (drive.axial_force or 1.0), 2 * (drive.axial_force or 1.0)))
    forces, masses = f"axial_force={force[0]!r}:{force[1]!r}", f"mass={0.5 * drive.mass!r}:{2 * drive.mass!r}"
    swing = 2 * math.pi * math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
    start = f"w={-float(rng.choice([0.5, 1.0, 5.0])) * speed!r}"
    whole = without[()]
    yield ["stability", *whole]
    yield ["thresholds", *whole]
    yield ["thresholds", "--solve", "onset", "--for", str(rng.choice(UNKNOWNS)), *whole]
    yield ["cycles", *whole]
    duration = ["--duration", repr(10 * swing), "--samples", "100"]
    yield ["simulate", "--start", "u=0", start, *duration, "--out", "m.nc", *whole]
    yield ["sweep", "--over", f"{forces}:7", "--out", "s.nc", *without["axial_force",]]
    if drive.rigid:
        grid = ["--grid", "u=-0.1:0.1:4", f"w={-abs(speed)!r}:{abs(speed)!r}:4"]
        yield ["attraction", *grid, "--out", "a.nc", *whole]
    yield ["sweep", "--over", f"{forces}:4", "--over", f"{masses}:4", *without["axial_force", "mass"]]


def check(run, seed, index):
    """Run all commands on one drive; an answer has no NaN, a refusal is one sentence; return the exit codes."""
    drive, codes = random_drive(seed, index), []
    for arguments in commands(drive, index) if drive else ():
        code, out, error = run(*arguments, "--json")
        assert code in (0, 2), (arguments, error)
        codes.append(code)
        if code == 0:
            json.loads(out, parse_constant=lambda word, at=arguments: pytest.fail(f"{word} in {at}"))
            assert not re.search("Traceback|Warning|nan", error), (arguments, error)
        else:
            assert error.startswith("lsvib: "), (arguments, error)
            assert error.endswith(".\n"), (arguments, error)
            assert error.count("\n") == 1, (arguments, error)
    return codes


@pytest.mark.parametrize("drive", sizes([], [(1, 0)], [*((1, k) for k in range(1, 8)), *((2, k) for k in range(300))]))
def test_commands_answer_or_refuse(run, drive):
    codes = check(run, *drive)
    assert 0 in codes or not codes  # no drive: a refused sheet
