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

import hashlib
import logging
import os
import tempfile
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils, event
from numba.extending import intrinsic, overload, register_jitable
from platformdirs import user_cache_path

from lsvib.systems.kernels.layout import Modal, ModalFlow, Planar, Taylor, TaylorFlow

# What is compiled, by the module of the kernel and a word in the types of its arguments, the first that fits; with the
# processor time that was measured. Kernels that fit nothing are small and are compiled for one of the others.
_RULE = ("attractor", "machine", "poincare_map", "saltation", "saltation_taylor", "single_mode", "sweep")
_PARTS = (
    (_RULE, "Flow", "the search for attractors (first use only, about 25 s)"),
    ("", "TaylorFlow", "the engine for friction that depends on speed (first use only, about 15 s)"),
    ("", "ModalFlow", "the engine for systems with more than two states (first use only, about 30 s)"),
    ("next_section", "", "the map of attractors for systems with two states (first use only, 6 to 15 s)"),
    ("", "Tables", "the engine for systems with two states (first use only, about 10 s)"),
)


def sentence(module: str, arguments: str) -> str | None:
    """Return what is said of compiling a kernel of ``module``, by the types of its arguments; None if nothing."""
    if not module.startswith("lsvib."):
        return None
    return next((f"compiling {words}" for a, b, words in _PARTS if module.endswith(a) and b in arguments), None)


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


class OneWriter(event.Listener):
    """Let one process at a time add to the cache: from the end of a compilation, after which numba saves what is made,
    until numba gives back its own lock.
    """

    def __init__(self) -> None:
        self.mine = threading.local()  # one thread at a time compiles, but others give the lock back, too
        self.patience = 30.0  # s; to write a kernel takes milliseconds

    def on_start(self, event: event.Event) -> None:
        """Let it begin."""

    def on_end(self, event: event.Event) -> None:
        """Wait until no other process adds, or let others add, who may also do so when this process ends."""
        if event.kind != "numba:compile":
            if hasattr(self.mine, "lock"):
                self.mine.__dict__.pop("lock").release()
        elif not hasattr(self.mine, "lock"):  # else this thread would wait for itself
            from filelock import FileLock  # takes 30 ms, which a start that compiles nothing does not need

            self.mine.lock = FileLock(Path(numba.config.CACHE_DIR, "lock"), timeout=self.patience)
            try:
                self.mine.lock.acquire()
            except OSError as error:  # the process that adds has been stopped, say, or is another user's
                if self.patience:
                    logging.getLogger("lsvib").warning("The compiled engine is not kept for the next start: %s", error)
                self.patience = 0.0
                event.data["dispatcher"]._cache.disable()


def source_digest() -> str:
    """Hexadecimal digest of the source files in all folders named ``kernels``, and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parents[2].glob("**/kernels/*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path | None:
    """Return the folder of the cache, made if need be; None if it cannot be written."""
    with suppress(OSError, RuntimeError):  # also of a user without a home
        folder = Path(os.environ.get("NUMBA_CACHE_DIR") or user_cache_path("lsvib", False, source_digest()))
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    return None


_folder, notice, writer = cache_folder(), Notice(), OneWriter()
if _folder is None:
    warnings.warn(
        "The folder for the compiled engine is not writable, so every process compiles it anew, which takes tens of "
        "seconds; set NUMBA_CACHE_DIR to a writable folder.",
        RuntimeWarning,
        stacklevel=2,
    )
else:
    numba.config.CACHE_DIR = str(_folder)
    for kind, listener in (("numba:compile", notice), ("numba:compile", writer), ("numba:compiler_lock", writer)):
        event.register(kind, listener)

OPTIONS: dict[str, Any] = {
    "cache": _folder is not None,
    "error_model": "numpy",
    "fastmath": False,
    "nogil": True,
    "forceinline": False,  # said of every kernel: numba takes it from the first that calls it otherwise
}
_options: dict[Callable, dict[str, Any]] = {}  # of each kernel


def _missed(what: str) -> None:
    """Warn that numba has no longer what lsvib takes from it beyond what it promises."""
    warnings.warn(
        f"numba {numba.__version__} lacks {what}: the first start takes longer, and motions may; results are the same.",
        RuntimeWarning,
        stacklevel=3,
    )


# Options that numba has but does not promise; those that it lacks.
_UNPROMISED = ("_nrt", "no_cfunc_wrapper", "no_cpython_wrapper")
_known = getattr(getattr(numba.njit(_missed), "targetdescr", None), "options", None)
_lacking = [name for name in _UNPROMISED if not hasattr(_known, name)]
if _lacking and not numba.config.DISABLE_JIT:
    _missed(" and ".join(_lacking))


def _allowed(options: dict[str, Any], **more: bool | str) -> dict[str, Any]:
    """Return options and ``more``, without those that numba lacks."""
    return {name: value for name, value in {**options, **more}.items() if name not in _lacking}


def _compiler(decorator: Callable, **more: bool | str) -> Callable:
    """Return a decorator of numba's with our options and ``more``."""
    options = _allowed(OPTIONS, **more)

    def compiled(function: Callable) -> Any:
        """Make a kernel of a function."""
        _options[function] = options
        return decorator(**options)(function)

    return compiled


# A kernel that makes no array need not count references to those that it is given. Each count is an atomic operation;
# together they took half of the time of a run, and would make threads wait for each other.
allocating_entry = _compiler(numba.njit, _nrt=True)  # an entry is a kernel that Python calls
entry = _compiler(numba.njit, _nrt=False)
inlined_entry = _compiler(numba.njit, _nrt=False, forceinline=True)
# What only kernels call is compiled without what others need to call it, which takes a fifth of the time. Where Python
# calls it all the same, as tests do, it is a plain function.
_kernel = partial(_compiler, register_jitable, no_cfunc_wrapper=True)
allocating_kernel = _kernel(_nrt=True)
kernel = _kernel(_nrt=False)
inlined_kernel = _kernel(_nrt=False, forceinline=True)
# A kernel that is put into its few callers before types are inferred: it is not compiled alone, with all that it calls,
# as every other one is. Of kernels with many callers that would make more to compile.
merged_kernel = _compiler(numba.njit, _nrt=False, inline="always")


@intrinsic
def on_stack(context, shape, *number):
    """Return an array of any numbers, a small one, that lasts until the kernel ends that asks for it, in no loop.

    A kernel that makes its arrays so counts no references, as one that makes none.
    """
    dimensions = shape.count if isinstance(shape, types.BaseTuple) else 1
    own = types.Array(number[0].dtype if number else types.float64, dimensions, "C")

    def written(context, builder, signature, values):
        sizes = cgutils.unpack_tuple(builder, values[0]) if dimensions > 1 else values[:1]
        content = context.get_data_type(own.dtype)
        item = context.get_constant(types.intp, context.get_abi_sizeof(content))
        *strides, size = accumulate(reversed(sizes), builder.mul, initial=item)
        array = cgutils.create_struct_proxy(own)(context, builder)
        array.nitems, array.itemsize = builder.udiv(size, item), item
        array.data = builder.alloca(content, size=array.nitems)
        array.shape, array.strides = cgutils.pack_array(builder, sizes), cgutils.pack_array(builder, strides[::-1])
        return array._getvalue()

    return own(shape, types.StarArgTuple.from_types(number)), written


if numba.config.DISABLE_JIT:
    on_stack = np.empty


def by_kind(planar_kernel: Any, modal_kernel: Any, taylor_kernel: Any) -> Any:
    """Return a function that chooses a kernel by the kind of flow, its first argument.

    A flow is a plain table of oscillators (two states, :mod:`lsvib.systems.kernels.flow_planar`), a ``ModalFlow``
    (:mod:`lsvib.systems.kernels.flow_modal`) or a ``TaylorFlow`` (:mod:`lsvib.systems.kernels.flow_taylor`); or it is
    one of the values that stand for them. Kernels choose by type when they are compiled, so that a system compiles none
    of the kernels of another kind.
    """

    def choose(flow, *arguments):
        if isinstance(flow, (np.ndarray, Planar)):
            return planar_kernel(flow, *arguments)
        return (taylor_kernel if isinstance(flow, (TaylorFlow, Taylor)) else modal_kernel)(flow, *arguments)

    def offer(kernel: Any, *kinds: type) -> None:
        """Let kernels that call ``choose`` with a flow of some kinds call ``kernel``."""
        function = getattr(kernel, "py_func", kernel)
        # what is an entry, too, has one place in the cache for both, so it is compiled for Python here as well
        options = _allowed(_options[function], no_cpython_wrapper=function is kernel)

        @overload(choose, jit_options=options, strict=False)
        def own(flow, *arguments):
            return function if getattr(flow, "instance_class", Planar) in kinds else None  # an array has none

    offer(planar_kernel, Planar)
    offer(modal_kernel, ModalFlow, Modal)
    offer(taylor_kernel, TaylorFlow, Taylor)
    return choose


def by_address(entry: Any, returns: Any) -> Any:
    """Return a function that calls an entry by its address [int], its first argument, of :func:`address`.

    ``returns`` is the numba type of what the entry returns. It may be any entry whose arguments take the same place in
    memory; a value that holds nothing takes none, and is left out of the call.

    numba puts all that a kernel calls into it and optimises it anew, which for the event loop takes many seconds in
    every kernel that follows motions. What is called by its address stays where it is. It may return no arrays.
    """

    if numba.config.DISABLE_JIT:
        return lambda address, *arguments: address(*arguments)

    @intrinsic
    def call(context, address, *arguments):
        def written(context, builder, signature, values):
            function = ir.FunctionType(context.get_value_type(returns), map(context.get_value_type, arguments))
            pointer = builder.inttoptr(values[0], function.as_pointer())
            return builder.call(pointer, cgutils.unpack_tuple(builder, values[1]))

        return returns(types.intp, types.StarArgTuple.from_types(arguments)), written

    return call


_addresses: dict[tuple, int] = {}
_kept: list[Any] = []


def _types(value: Any) -> Any:
    """Return what numba's types of a value depend on."""
    if isinstance(value, tuple):
        return (type(value), *map(_types, value))
    return (value.dtype, value.ndim, value.flags.num) if isinstance(value, np.ndarray) else type(value)


def address(entry: Any, *arguments: Any) -> Any:
    """Return the address of an entry as compiled for arguments like these; it lasts as long as the process."""
    if numba.config.DISABLE_JIT:  # the function itself, with the value that holds nothing, if one comes first
        return partial(entry, *(value for value in arguments[:1] if isinstance(value, tuple) and not value))
    key = entry, _types(arguments)  # numba's own names of them take a hundred times as long
    if key not in _addresses:
        own = tuple(map(numba.typeof, arguments))
        entry.compile(own)
        _addresses[key] = _pointer(entry, own)
    return _addresses[key]


def _pointer(entry: Any, own: tuple) -> int:
    """Return the address of an entry as compiled for arguments of some types; where numba does not tell it, anew."""
    with suppress(AttributeError):
        compiled = entry.overloads[own]
        return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))
    _missed("the address of compiled code")
    signature = next(known for known in entry.nopython_signatures if known.args == own)
    _kept.append(numba.cfunc(signature, **_options[entry.py_func] | {"cache": False})(entry.py_func))
    return int(_kept[-1].address)
