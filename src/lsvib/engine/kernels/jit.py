"""The one way kernels are compiled: no fast maths, numpy's error model, a disk cache keyed by the source.

numba checks only the file of the function itself when it decides whether a cached kernel is current; a change in
another kernel that is inlined into it goes unnoticed. The cache therefore lives in a folder named after a digest of all
kernels, unless ``NUMBA_CACHE_DIR`` says otherwise. Where that cannot be written every process compiles in memory.

Several processes may fill the cache at once. numba writes each file of it whole, but it numbers the compiled versions
of a kernel after the index that it has just read: two processes that compile a kernel for different types could give
both the same number, and one would later run what the other has compiled. So one process at a time may add to it.

The first use of the engine takes much longer than all later ones, so a sentence to the log of the package says what is
being compiled; the ``lsvib`` command shows it. What numba finds in its cache starts no compilation.
"""

import fcntl
import hashlib
import logging
import os
import tempfile
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import partial, reduce
from itertools import accumulate
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import types
from numba._dispatcher import compute_fingerprint
from numba.core import cgutils, event
from numba.core.caching import IndexDataCacheFile
from numba.core.imputils import impl_ret_borrowed, lower_builtin
from numba.core.registry import CPUDispatcher
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np import arrayobj

from lsvib.engine.kernels.layout import Planar, Taylor, TaylorFlow

# What is compiled, by the folder of the kernel and a word in the types of its arguments, the first that fits; with the
# processor time that was measured. Kernels that fit nothing are small and are compiled for one of the others.
_PARTS = (
    ("lsvib.dynamics.", "Flow", "the rule of what motions end in, once, about 25 s"),
    ("lsvib.", "TaylorFlow", "the engine for friction that depends on speed, once, about 15 s"),
    ("lsvib.", "ModalFlow", "the engine for drives with parts, once, about 30 s"),
    ("lsvib.basins.", "", "the mapper of rigid drives, once, 6 to 15 s"),
    ("lsvib.engine.", "Tables", "the engine for rigid drives, once, about 10 s"),
)


def sentence(module: str, arguments: str) -> str | None:
    """Return what is said of compiling a kernel of ``module``, by the types of its arguments; None if nothing."""
    return next((f"compiling {words}" for a, b, words in _PARTS if module.startswith(a) and b in arguments), None)


class Notice(event.Listener):
    """Log one sentence for each part of the engine when numba starts to compile the first kernel of it."""

    def __init__(self) -> None:
        self.depth, self.said = 0, set[str | None]({None})  # kernels being compiled, each for the one before; sentences

    def on_start(self, event: event.Event) -> None:
        """Say what is compiled, unless it has been said, or is part of what is being compiled."""
        words = sentence(event.data["dispatcher"].py_func.__module__, " ".join(map(str, event.data["args"])))
        if self.depth == 0 and words not in self.said:
            self.said.add(words)
            logging.getLogger("lsvib").info(words)
        self.depth += 1

    def on_end(self, event: event.Event) -> None:
        """Count the kernel as compiled."""
        self.depth -= 1


def source_digest() -> str:
    """Hexadecimal digest of the source files in all folders named ``kernels``, and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parents[2].glob("**/kernels/*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path | None:
    """Return the folder of the cache, made if need be; None if it cannot be written."""
    with suppress(OSError, RuntimeError):  # also of a user without a home
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        folder = Path(os.environ.get("NUMBA_CACHE_DIR") or Path(home) / "lsvib" / source_digest())
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    return None


_folder, notice = cache_folder(), Notice()
if _folder is None:
    warnings.warn(
        "The folder for the compiled engine cannot be written, so it is compiled in memory, in every process anew, "
        "which takes some ten seconds; set NUMBA_CACHE_DIR to a folder that can be written.",
        RuntimeWarning,
        stacklevel=2,
    )
else:
    numba.config.CACHE_DIR = str(_folder)
    event.register("numba:compile", notice)

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


def _declare(function, typed, written):
    """Let kernels call a function: ``typed`` returns the signature of a call, ``written`` writes it into their code."""

    class Call(AbstractTemplate):
        key = function

        def generic(self, arguments, keywords):
            return typed(self.context, arguments, keywords)

    infer_global(function, types.Function(Call))
    lower_builtin(function, types.VarArg(types.Any))(written)


def on_stack(shape, number=np.float64):
    """Return an array of any numbers, a small one, that lasts until the kernel ends that asks for it, in no loop.

    A kernel that makes its arrays so counts no references, as one that makes none.
    """
    return np.empty(shape, number)


def _type_on_stack(context, arguments, keywords):
    dimensions = len(arguments[0]) if isinstance(arguments[0], types.BaseTuple) else 1
    number = arguments[1].dtype if len(arguments) > 1 else types.float64
    return signature(types.Array(number, dimensions, "C"), *arguments)


def _write_on_stack(context, builder, signature, values):
    own = signature.return_type
    shape, number = cgutils.unpack_tuple(builder, values[0]) if own.ndim > 1 else values[:1], own.dtype
    size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(number)))
    strides = list(accumulate(reversed(shape[1:]), builder.mul, initial=size))[::-1]
    place = builder.alloca(context.get_data_type(number), size=reduce(builder.mul, shape))
    array = context.make_array(own)(context, builder)
    arrayobj.populate_array(array, place, shape, strides, size, meminfo=None)
    return array._getvalue()


_declare(on_stack, _type_on_stack, _write_on_stack)


def by_kind(planar_kernel: Any, modal_kernel: Any, taylor_kernel: Any) -> Any:
    """Return a function that chooses a kernel by the kind of flow, its first argument.

    A flow is a plain table of oscillators (two states, :mod:`lsvib.engine.kernels.flow_planar`), a ``ModalFlow``
    (:mod:`lsvib.engine.kernels.flow_modal`) or a ``TaylorFlow`` (:mod:`lsvib.engine.kernels.flow_taylor`); or it is
    one of the values that stand for them. Kernels choose by type when they are compiled, so that a drive compiles none
    of the kernels of another kind.
    """

    def choose(flow, *arguments):
        if isinstance(flow, (np.ndarray, Planar)):
            return planar_kernel(flow, *arguments)
        return (taylor_kernel if isinstance(flow, (TaylorFlow, Taylor)) else modal_kernel)(flow, *arguments)

    class Choice(AbstractTemplate):
        """A call of the chosen kernel itself. An overload would call it in a function that is compiled with it."""

        key = choose

        def generic(self, arguments, keywords):
            """Return the signature of a call with these types, that of the chosen kernel."""
            return self._kernel(arguments).get_call_type(self.context, arguments, keywords)

        def get_impl_key(self, signature):
            return self._kernel(signature.args).get_impl_key(signature)

        def _kernel(self, arguments):
            own = getattr(arguments[0], "instance_class", Planar)  # an array has none
            if own is Planar:
                return types.Dispatcher(planar_kernel)
            return types.Dispatcher(taylor_kernel if own in (TaylorFlow, Taylor) else modal_kernel)

    infer_global(choose, types.Function(Choice))
    return choose


def by_address(entry: Any, returns: Any = None) -> Any:
    """Return a function that calls an entry by its address [int], its first argument, of :func:`address`.

    With the numba type that it ``returns`` it may be any entry whose arguments take the same place in memory; a value
    that holds nothing takes none, and is left out of the call.

    numba puts all that a kernel calls into it and optimises it anew, which for the event loop takes many seconds in
    every kernel that follows motions. What is called by its address stays where it is. It may return no arrays.
    """

    def call(address, *arguments):
        return address(*arguments)

    def typed(context, arguments, keywords):
        if returns is not None:
            return signature(returns, types.intp, *arguments[1:])
        own = types.Dispatcher(entry).get_call_type(context, arguments[1:], keywords)  # is compiled first
        return signature(own.return_type, types.intp, *own.args)

    def written(context, builder, signature, values):
        result, own = signature.return_type, signature.args[1:]
        function = context.call_conv.get_function_type(result, own)
        pointer = builder.inttoptr(values[0], function.as_pointer())
        status, value = context.call_conv.call_function(builder, pointer, result, own, values[1:])
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return impl_ret_borrowed(context, builder, result, value)

    _declare(call, typed, written)
    return call


_addresses: dict[tuple[Any, bytes], int] = {}


def address(entry: Any, *arguments: Any) -> Any:
    """Return the address of an entry as compiled for arguments like these; it lasts as long as the process."""
    if numba.config.DISABLE_JIT:  # the function itself, with the value that holds nothing, if one comes first
        return partial(entry, *(value for value in arguments[:1] if isinstance(value, tuple) and not value))
    key = entry, compute_fingerprint(arguments)  # of the types; numba's own names of them take a hundred times as long
    if key not in _addresses:
        own = tuple(map(numba.typeof, arguments))
        entry.compile(own)
        compiled = entry.overloads[own]
        _addresses[key] = int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))
    return _addresses[key]
