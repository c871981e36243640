"""The one way kernels are compiled: no fast maths, numpy's error model, a disk cache keyed by the source.

numba checks only the file of the function itself when it decides whether a cached kernel is current; a change in
another kernel that is inlined into it goes unnoticed. The cache therefore lives in a folder named after a digest of all
kernels, unless ``NUMBA_CACHE_DIR`` says otherwise.
"""

import hashlib
import os
from pathlib import Path

import numba


def source_digest() -> str:
    """Hexadecimal digest of every source file of ``lsvib.core`` and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


if "NUMBA_CACHE_DIR" not in os.environ:
    _caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    numba.config.CACHE_DIR = str(_caches / "lsvib" / source_digest())

OPTIONS = {"cache": True, "error_model": "numpy", "fastmath": False, "nogil": True}

allocating_kernel = numba.njit(**OPTIONS, _nrt=True)
# A kernel that makes no array need not count references to those that it is given. Each count is an atomic operation;
# together they took half of the time of a run, and would make threads wait for each other.
kernel = numba.njit(**OPTIONS, _nrt=False)
inlined_kernel = numba.njit(**OPTIONS, _nrt=False, forceinline=True)
