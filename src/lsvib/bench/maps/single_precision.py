"""The engine in single precision, made from its own source: every number that is not an integer is a float32.

The modules of ``lsvib.engine.kernels`` and ``lsvib.basins.kernels`` are parsed, changed and compiled a second time, so
that the twin follows every edit of the engine. Changed are literals and constants of ``math``, which become float32
(infinite, where they are beyond its range); the type of new arrays; ``float``; ``np.float64``, and so the unit of
rounding and all tolerances that are multiples of it; and arithmetic of an integer with a float, for which Python and
numba go to double precision. Nothing is cached on disk. That no double is left in a compiled kernel is for
:func:`double_arithmetic` to say.
"""

import ast
import math
import operator
import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import numba
import numpy as np
from numba import types
from numba.extending import overload

from lsvib.engine.kernels import jit

_PACKAGES = ("lsvib.engine.kernels", "lsvib.basins.kernels")
_SHARED = ("columns", "status", "tables")  # modules without arithmetic: the twin uses the engine's
_LARGEST = float(np.finfo(np.float32).max)
_CONSTANTS = ("pi", "e", "tau", "inf", "nan")
_NEW_ARRAYS = ("zeros", "empty", "ones", "full")
# Tolerances that the engine states in numbers, for a step that is the last one since it converges with its cube.
_TOLERANCES = {("newton", "_LAST_STEP"): np.float32(1e-3)}
_DOUBLE = re.compile(r"\bf(?:add|sub|mul|div|rem|neg|cmp)\b.*\bdouble\b|\bfpext\b|\b[su]itofp\b.*\bto double\b")
_DOUBLE_CALL = re.compile(r"\bcall\b.*\bdouble\b.*@(?!Py)\w")  # Python's own functions unpack the arguments
_OPTIONS = jit.OPTIONS | {"cache": False}


def _arithmetic(operate):
    """An operator under which an integer and a float32 make a float32, in Python and compiled."""

    def single(a, b):
        """Return the operator's result in Python."""
        return operate(a, b)

    @overload(single, jit_options=_OPTIONS)
    def single_typed(a, b):
        """Return the compiled operator for two types: an integer beside a float becomes a float32 first."""
        whole = [isinstance(x, types.Integer) for x in (a, b)]
        if all(whole) and operate is operator.truediv:
            return lambda a, b: operate(np.float32(a), np.float32(b))
        if whole[0] and isinstance(b, types.Float):
            return lambda a, b: operate(np.float32(a), b)
        if whole[1] and isinstance(a, types.Float):
            return lambda a, b: operate(a, np.float32(b))
        return lambda a, b: operate(a, b)

    return single


_OPERATORS = {
    ast.Add: ("_plus", _arithmetic(operator.add)),
    ast.Sub: ("_minus", _arithmetic(operator.sub)),
    ast.Mult: ("_times", _arithmetic(operator.mul)),
    ast.Div: ("_over", _arithmetic(operator.truediv)),
    ast.Mod: ("_modulo", _arithmetic(operator.mod)),
    ast.Pow: ("_power", _arithmetic(operator.pow)),
}


class _SinglePrecision(ast.NodeTransformer):
    """Turns the source of a module into that of its twin."""

    def visit_ImportFrom(self, node: ast.ImportFrom):
        """Take what comes from the engine from its twin."""
        place, _, module = (node.module or "").rpartition(".")
        if node.module in _PACKAGES:
            found = [(name.asname or name.name, f"_twin({name.name!r})", name.name) for name in node.names]
        elif place in _PACKAGES:
            found = [(name.asname or name.name, f"_twin({module!r}).{name.name}", module) for name in node.names]
        else:
            return node
        if all(source in _SHARED for _, _, source in found):
            return node
        return [ast.parse(f"{name} = {value}").body[0] for name, value, _ in found]

    def visit_Constant(self, node: ast.Constant):
        """Make a float a float32."""
        if not isinstance(node.value, float):
            return node
        return _expression("_infinity" if abs(node.value) > _LARGEST else f"_float32({node.value!r})")

    def visit_Attribute(self, node: ast.Attribute):
        """Make the constants of ``math`` and ``np.float64`` single."""
        text = ast.unparse(node)
        if text in [f"math.{name}" for name in _CONSTANTS]:
            return _expression(f"_float32({text})")
        if text == "np.float64":
            return _expression("np.float32")
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call):
        """Make new arrays, and what is made a float, single."""
        name = ast.unparse(node.func)
        self.generic_visit(node)
        if name == "float":
            node.func = _expression("_float32")
        elif name in [f"np.{name}" for name in _NEW_ARRAYS] and not any(k.arg == "dtype" for k in node.keywords):
            node.keywords.append(ast.keyword("dtype", _expression("np.float32")))
        return node

    def visit_BinOp(self, node: ast.BinOp):
        """Make arithmetic of an integer with a float single."""
        self.generic_visit(node)
        if type(node.op) not in _OPERATORS:
            return node
        return ast.Call(_expression(_OPERATORS[type(node.op)][0]), [node.left, node.right], [])

    def visit_AugAssign(self, node: ast.AugAssign):
        """Write ``x += y`` as ``x = x + y``, so that the same holds for it."""
        if isinstance(node.target, ast.Name) and type(node.op) in _OPERATORS:
            before = ast.BinOp(ast.Name(node.target.id, ast.Load()), node.op, node.value)
            return ast.Assign([node.target], self.visit(before))
        return self.generic_visit(node)


def _expression(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


@cache
def twin(name: str) -> ModuleType:
    """Return the twin of the kernels' module ``name``; its kernels are compiled when they are called."""
    if name in _SHARED:
        raise ValueError(f"the module {name} has no twin: it holds no arithmetic.")
    module = ModuleType(f"{__name__}.{name}")
    if name == "jit":
        module.allocating_kernel = numba.njit(**_OPTIONS, _nrt=True)
        module.kernel = numba.njit(**_OPTIONS, _nrt=False)
        module.inlined_kernel = numba.njit(**_OPTIONS, _nrt=False, forceinline=True)
        return module
    found = [spec for package in _PACKAGES if (spec := find_spec(f"{package}.{name}"))]
    path = Path(found[0].origin)
    tree = ast.fix_missing_locations(_SinglePrecision().visit(ast.parse(path.read_text(encoding="utf-8"))))
    module.__dict__.update(
        {"_twin": twin, "_float32": np.float32, "_infinity": np.float32(math.inf)} | dict(_OPERATORS.values())
    )
    exec(compile(tree, f"<single precision of {path.name}>", "exec"), module.__dict__)
    for (owner, constant), value in _TOLERANCES.items():
        if owner == name:
            if constant not in vars(module):
                raise AttributeError(f"the module {name} has no constant {constant} any more.")
            vars(module)[constant] = value
    return module


def in_single(value):
    """Return tables with every array and number that is not an integer rounded to float32; tuples within, too."""
    if isinstance(value, tuple):
        parts = [in_single(part) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    if isinstance(value, np.ndarray):
        return value.astype(np.float32) if value.dtype.kind == "f" else value
    return np.float32(value) if isinstance(value, float) else value


def double_arithmetic(kernel) -> list[str]:
    """Return the instructions of a compiled kernel, and of all that it calls, that work in double precision."""
    return [
        line.strip()
        for text in kernel.inspect_llvm().values()
        for line in text.splitlines()
        if _DOUBLE.search(line) or _DOUBLE_CALL.search(line)
    ]
