"""Benchmarks: the engine held against references and beside other methods. Nothing imports this room."""

import sys
from pathlib import Path

# The references in many digits belong to the tests; the benchmarks take theirs from there.
sys.path.append(str(Path(__file__).parents[1] / "tests"))
