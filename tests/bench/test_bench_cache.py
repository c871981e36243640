"""The compiled benchmarks: an edit of what is inlined compiles them anew, and leaves the compiled engine alone."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import lsvib
from lsvib.bench import jit as bench_jit
from lsvib.bench.second_opinions import strides
from lsvib.engine.kernels import flow_planar, jit

# The kernel of one module, into which that of another one is inlined, and how many of both had to be compiled.
PROGRAM = """
import numpy as np
from lsvib.bench.second_opinions import strides
from lsvib.engine.kernels import jit
table, x = np.zeros((4, 5, 2)), np.zeros((4, 2))
table[:, 4, 0] = 1.0
strides._put(table, x, np.empty((4, 2)))
print(x[0, 0], sum(strides._put.stats.cache_misses.values()), jit.source_digest())
"""


def test_benchmarks_have_a_cache_of_their_own():
    engine, bench = Path(flow_planar.advance._cache.cache_path), Path(strides._put._cache.cache_path)
    assert bench.parent.name == f"bench-{bench_jit.source_digest()}"
    assert bench.parent.parent == engine.parent


@pytest.mark.slow
def test_an_edit_of_an_inlined_kernel_compiles_the_kernel_anew(tmp_path):
    package = tmp_path / "source" / "lsvib"
    shutil.copytree(Path(lsvib.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))

    def run() -> tuple[str, str, str]:
        environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
        environment |= {"PYTHONPATH": str(package.parent), "XDG_CACHE_HOME": str(tmp_path / "cache")}
        command = [sys.executable, "-c", PROGRAM]
        found = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert found.returncode == 0, found.stderr
        return tuple(found.stdout.split())

    engine = jit.source_digest()
    assert run() == ("1.0", "1", engine)
    assert run() == ("1.0", "0", engine)
    inlined = package / "bench" / "second_opinions" / "double_doubles.py"
    text = inlined.read_text(encoding="utf-8")
    old = "    h, e = row[4, 0], row[4, 1]\n    for i in range(4):\n        if row"
    assert text.count(old) == 1
    inlined.write_text(text.replace(old, old.replace("row[4, 0]", "2.0 * row[4, 0]")), encoding="utf-8")
    assert run() == ("2.0", "1", engine)
