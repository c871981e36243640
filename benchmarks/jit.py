"""How the kernels of the benchmarks are compiled: as the engine's are, but into a cache of their own.

The cache lies in the engine's, whose folder is named after the engine's sources, in a folder named after the sources of
the benchmarks. An edit of a benchmark therefore compiles benchmarks anew and not the engine; an edit of the engine
compiles both, since its kernels are inlined into those of the benchmarks. numba by itself would see neither: see
:mod:`lsvib.engine.kernels.jit`. Kernels outside of the package that stand on those of the benchmarks ask
:func:`cached_apart` for a cache that their own sources name as well.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numba

from lsvib.engine.kernels import jit


def source_digest(*more: Path) -> str:
    """Hexadecimal digest of all files in those folders of the benchmarks that hold kernels, and in ``more`` folders.

    A folder is taken as a whole because a kernel may have the constants of a module beside it compiled into it.
    """
    rooms = {
        path.parent for path in Path(__file__).parent.rglob("*.py") if f"from {__name__} " in path.read_text("utf-8")
    }
    digest = hashlib.sha256()
    for path in sorted(path for room in rooms.union(more) for path in room.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def cached_apart(decorate: Callable, name: str, *more: Path) -> Callable:
    """Return a decorator of kernels as ``decorate``, of :mod:`lsvib.engine.kernels.jit`, with a cache of their own.

    The cache is named ``name`` and after the sources of the benchmarks and of ``more`` folders.
    """
    folder = f"{numba.config.CACHE_DIR}/{name}-{source_digest(*more)}"

    def decorated(function: Callable) -> Callable:
        """Make a kernel of a function; numba chooses a kernel's folder when it is decorated."""
        engine = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = folder
        try:
            return decorate(function)
        finally:
            numba.config.CACHE_DIR = engine

    return decorated if jit.OPTIONS["cache"] else decorate


# Python calls many of them, and they are few.
allocating_kernel = cached_apart(jit.allocating_entry, "bench")
kernel = cached_apart(jit.entry, "bench")
