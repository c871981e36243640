"""Arguments of the command that several tests use, and what a refusal is."""

from pathlib import Path

DRIVE = ["--set", "mass=11", "--set", "support_damping=1e-3", "--set", "axial_force=-10"]
GRID = ["--grid", "u=-0.1:0.1:40", "w=-80:80:30"]
MOTION = [*DRIVE, "--start", "u=0.1", "w=0", "--duration", "0.1"]


def refused(run, *arguments: str) -> str:
    """Assert that a command ends with code 2, one sentence, nothing on standard output and no file; the sentence."""
    before = sorted(Path().rglob("*"))
    code, out, error = run(*arguments)
    assert (code, out) == (2, "")
    assert error.startswith("lsvib: ")
    assert error.count("\n") == 1
    assert error.endswith(".\n")
    assert sorted(Path().rglob("*")) == before
    return error
