"""What a fresh Python pays before the first number, modules to import and kernels to compile; each in a new process."""

import json
import os
import subprocess
import sys
import tempfile

from lsvib.errors import EngineError

_IMPORT = """
import json, sys, time
begun = time.perf_counter()
import {module}
print(json.dumps([len(sys.modules), time.perf_counter() - begun, sorted({{m.split('.')[0] for m in sys.modules}})]))
"""
_COMPILE = """
import json, time
from numba.core import event
from lsvib.engine.motion import compile_engine
with event.install_recorder("numba:compile") as recorder:
    begun = time.process_time()
    compile_engine({kinds!r})
    seconds = time.process_time() - begun
print(json.dumps([sum(e.is_end for _, e in recorder.buffer), seconds]))
"""


def imports(module: str, repeats: int) -> tuple[int, float, set[str]]:
    """Number of modules that importing ``module`` loads, fastest time [s], names of the packages among them."""
    runs = [_fresh(_IMPORT.format(module=module)) for _ in range(repeats)]
    return runs[0][0], min(run[1] for run in runs), set(runs[0][2])


def compilation(kinds: tuple[str, ...]) -> tuple[int, float]:
    """Number of compiled specialisations and CPU time [s] to compile the engine for some kinds of flow, cache empty."""
    with tempfile.TemporaryDirectory() as folder:
        count, seconds = _fresh(_COMPILE.format(kinds=kinds), NUMBA_CACHE_DIR=folder)
    return count, seconds


def _fresh(program: str, **environment: str) -> list:
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env={**os.environ, **environment}
    )
    if run.returncode:
        raise EngineError(f"a fresh Python failed: {run.stderr.strip().splitlines()[-1]}")
    return json.loads(run.stdout)
