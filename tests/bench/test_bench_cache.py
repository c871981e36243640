"""The compiled benchmarks and judges: an edit of what is inlined compiles them anew, and nothing that they stand on."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import judge
import pytest
from judge.second_opinions import strides

import lsvib
from benchmarks import jit as bench_jit
from benchmarks.sweeps import taylor
from lsvib.engine.kernels import flow_planar, jit

# A kernel of the judge, into which that of another module is inlined, how often it had to be compiled, and the digests
# of what it stands on.
PROGRAM = """
import numpy as np
from judge.second_opinions import strides
from benchmarks import jit as bench_jit
from lsvib.engine.kernels import jit
table, x = np.zeros((4, 5, 2)), np.zeros((4, 2))
table[:, 4, 0] = 1.0
strides._put(table, x, np.empty((4, 2)))
print(x[0, 0], sum(strides._put.stats.cache_misses.values()), bench_jit.source_digest(), jit.source_digest())
"""


def folder(kernel) -> Path:
    """The folder of the cache of a kernel's room."""
    return Path(kernel._cache.cache_path).parent


def test_benchmarks_and_judges_have_caches_of_their_own():
    engine, digest = folder(flow_planar.advance), bench_jit.source_digest()
    assert folder(taylor.run) == engine / f"bench-{digest}"
    assert folder(strides._put).parent == engine
    assert folder(strides._put).name.startswith("judge-")
    assert digest not in folder(strides._put).name


@pytest.mark.slow
def test_an_edit_of_an_inlined_kernel_compiles_the_kernel_anew(tmp_path):
    for package in (lsvib, judge):
        source = Path(package.__file__).parent
        shutil.copytree(source, tmp_path / "source" / source.name, ignore=shutil.ignore_patterns("__pycache__"))

    def run() -> tuple[str, str, str, str]:
        environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
        environment |= {"PYTHONPATH": str(tmp_path / "source"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
        command = [sys.executable, "-c", PROGRAM]
        found = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert found.returncode == 0, found.stderr
        return tuple(found.stdout.split())

    below = bench_jit.source_digest(), jit.source_digest()
    assert run() == ("1.0", "1", *below)
    assert run() == ("1.0", "0", *below)
    inlined = tmp_path / "source" / "judge" / "second_opinions" / "double_doubles.py"
    text = inlined.read_text(encoding="utf-8")
    old = "    h, e = row[4, 0], row[4, 1]\n    for i in range(4):\n        if row"
    assert text.count(old) == 1
    inlined.write_text(text.replace(old, old.replace("row[4, 0]", "2.0 * row[4, 0]")), encoding="utf-8")
    assert run() == ("2.0", "1", *below)
