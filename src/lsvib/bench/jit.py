"""How the kernels of the benchmarks are compiled: as the engine's are, but into a cache of their own.

The cache lies in the engine's, whose folder is named after the engine's sources, in a folder named after the sources of
the benchmarks. An edit of a benchmark therefore compiles benchmarks anew and not the engine; an edit of the engine
compiles both, since its kernels are inlined into those of the benchmarks. numba by itself would see neither: see
:mod:`lsvib.engine.kernels.jit`.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numba

from lsvib.engine.kernels import jit


def source_digest() -> str:
    """Hexadecimal digest of all files in those folders of the benchmarks that hold kernels.

    A folder is taken as a whole because a kernel may have the constants of a module beside it compiled into it.
    """
    rooms = {
        path.parent for path in Path(__file__).parent.rglob("*.py") if f"from {__name__} " in path.read_text("utf-8")
    }
    digest = hashlib.sha256()
    for path in sorted(path for room in rooms for path in room.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def _apart(decorate: Callable) -> Callable:
    """Return a decorator of kernels with a cache of their own; numba chooses a kernel's folder when it is decorated."""
    folder = f"{numba.config.CACHE_DIR}/bench-{source_digest()}"

    def decorated(function: Callable) -> Callable:
        """Make a kernel of a function."""
        engine = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = folder
        try:
            return decorate(function)
        finally:
            numba.config.CACHE_DIR = engine

    return decorated if jit.OPTIONS["cache"] else decorate


allocating_kernel, kernel, inlined_kernel = map(_apart, (jit.allocating_kernel, jit.kernel, jit.inlined_kernel))
