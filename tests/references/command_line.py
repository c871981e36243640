"""Arguments of the command that several tests use, and what a refusal is: of a command, and in Python."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lsvib.errors import InputError

DRIVE = ["--set", "mass=11", "--set", "support_damping=1e-3", "--set", "axial_force=-10"]
GRID = ["--grid", "u=-0.1:0.1:40", "w=-80:80:30"]
MOTION = [*DRIVE, "--start", "u=0.1", "w=0", "--duration", "0.1"]


def state_of_the_folder() -> dict[Path, tuple[int, ...]]:
    """What changes if a file of this folder does."""
    states = {path: path.lstat() for path in Path().rglob("*")}
    return {path: (s.st_ino, s.st_mode, s.st_size, s.st_mtime_ns) for path, s in states.items()}


def refused(run, *arguments: str) -> str:
    """Assert that a command ends with code 2, one sentence, no other output and no file changed; the sentence."""
    before = state_of_the_folder()
    code, out, error = run(*arguments)
    assert (code, out) == (2, "")
    assert error.startswith("lsvib: ")
    assert error.count("\n") == 1
    assert error.endswith(".\n")
    assert state_of_the_folder() == before
    return error


def complaint(call: Callable, *arguments, **options) -> str:
    """Assert that a call is refused in one sentence; the sentence."""
    with pytest.raises(InputError) as error:
        call(*arguments, **options)
    sentence = str(error.value)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    return sentence
