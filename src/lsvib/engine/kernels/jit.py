"""The one way kernels are compiled: no fast maths, numpy's error model, a disk cache keyed by the source.

numba checks only the file of the function itself when it decides whether a cached kernel is current; a change in
another kernel that is inlined into it goes unnoticed. The cache therefore lives in a folder named after a digest of all
kernels, unless ``NUMBA_CACHE_DIR`` says otherwise. Where the folder of the user cannot be written, one of the user's
own in the folder for temporary files takes its place; where that cannot either, every process compiles in memory.

Several processes may fill the cache at once. numba writes each file of it whole, but it numbers the compiled versions
of a kernel after the index that it has just read: two processes that compile a kernel for different types could give
both the same number, and one would later run what the other has compiled. So one process at a time may add to it.
"""

import fcntl
import hashlib
import os
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.caching import IndexDataCacheFile
from numba.core.registry import CPUDispatcher

from lsvib.engine.kernels.jit import Notice


def source_digest() -> str:
    """Hexadecimal digest of the source files in all folders named ``kernels``, and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parents[2].glob("**/kernels/*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def _folders() -> Iterator[Path]:
    """Yield the folders that may hold the cache, the best first."""
    if "NUMBA_CACHE_DIR" in os.environ:
        yield Path(os.environ["NUMBA_CACHE_DIR"])
    digest = source_digest()
    with suppress(RuntimeError):  # a user without a home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lsvib" / digest
    with suppress(FileNotFoundError):  # no folder for temporary files can be written
        yield Path(tempfile.gettempdir()) / f"lsvib-{os.getuid()}" / digest


def cache_folder() -> Path | None:
    """Return the folder of the cache, made if need be; None if no folder can be written."""
    for folder in _folders():
        try:
            folder.parent.parent.mkdir(parents=True, exist_ok=True)
            folder.parent.mkdir(exist_ok=True, mode=0o700)
            folder.mkdir(exist_ok=True, mode=0o700)
            owner = folder.parent.stat() if folder.parent.name == f"lsvib-{os.getuid()}" else None
            if owner is not None and (owner.st_uid != os.getuid() or owner.st_mode & 0o022):
                continue  # somebody else could put kernels there, and reading them is running them
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return None


_folder = cache_folder()
if _folder is None:
    warnings.warn(
        "No folder for the compiled engine can be written, so it is compiled in memory, in every process anew, which "
        "takes some ten seconds; set NUMBA_CACHE_DIR to a folder that can be written.",
        RuntimeWarning,
        stacklevel=2,
    )
else:
    numba.config.CACHE_DIR = str(_folder)
    event.register("numba:compile", Notice())

OPTIONS = {
    "cache": _folder is not None,
    "error_model": "numpy",
    "fastmath": False,
    "nogil": True,
    "forceinline": False,  # said of every kernel: numba takes it from the first that calls it otherwise
    "no_cfunc_wrapper": True,  # by which a kernel could be called through a pointer, as a C function; none is
}


class OneWriter(IndexDataCacheFile):
    """numba's file of the compiled versions of one kernel, to which one process at a time adds."""

    def save(self, key: tuple, data: Any) -> None:
        """Add a compiled version while no other process adds one; waits until it may."""
        with open(os.path.join(self._cache_path, "lock"), "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # given back when the file is closed, however the process ends
            super().save(key, data)


class Inner(CPUDispatcher):
    """A kernel that kernels call, compiled without what Python needs to call it, which takes a fifth of the time.

    Where Python calls such a kernel all the same, as tests do, a function that is compiled for it does so.
    """

    caller: Any = None

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel from Python."""
        if self.caller is None:
            self.caller = numba.njit(lambda *given: self(*given), error_model="numpy")
        return self.caller(*arguments)


def _compiler(**more: bool | str) -> Callable:
    """Return numba's decorator with our options and ``more``, and a cache that several processes may fill."""

    def compiled(function: Callable) -> Any:
        """Make a kernel of a function."""
        made = numba.njit(**{**OPTIONS, **more})(function)
        if numba.config.DISABLE_JIT:
            return made
        if OPTIONS["cache"]:
            made._cache._cache_file.__class__ = OneWriter
        if "no_cpython_wrapper" in more:
            made.__class__ = Inner
        return made

    return compiled


# A kernel that makes no array need not count references to those that it is given. Each count is an atomic operation;
# together they took half of the time of a run, and would make threads wait for each other.
allocating_entry = _compiler(_nrt=True)  # an entry is a kernel that Python calls
entry = _compiler(_nrt=False)
inlined_entry = _compiler(_nrt=False, forceinline=True)
allocating_kernel = _compiler(_nrt=True, no_cpython_wrapper=True)
kernel = _compiler(_nrt=False, no_cpython_wrapper=True)
inlined_kernel = _compiler(_nrt=False, forceinline=True, no_cpython_wrapper=True)
# A kernel that is put into its few callers before types are inferred: it is not compiled alone, with all that it calls,
# as every other one is. Of kernels with many callers that would make more to compile.
merged_kernel = _compiler(_nrt=False, inline="always", no_cpython_wrapper=True)
