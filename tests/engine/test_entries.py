"""Kernels that Python calls are entries; any other kernel is called by a function that is compiled for it."""

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import lsvib
from lsvib.engine.kernels import dispatch, event_loop, flow_planar, jit
from lsvib.engine.kernels.compile_ahead import tables_of

if jit.numba.config.DISABLE_JIT:
    pytest.skip("nothing is compiled", allow_module_level=True)

SOURCE = Path(lsvib.__file__).parent
# Modules that Python reads; a module that makes kernels uses others in them.
READERS = [
    path
    for path in sorted(SOURCE.rglob("*.py"))
    if path.parent.name != "kernels" and "bench.jit" not in path.read_text(encoding="utf-8")
]


def used(tree: ast.Module) -> Iterator[tuple[str, object]]:
    """Yield the names in a module that come from rooms of kernels, with what they stand for."""
    modules = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and ".kernels" in (node.module or ""):
            room = importlib.import_module(node.module)
            for name in node.names:
                if not hasattr(room, name.name):
                    importlib.import_module(f"{node.module}.{name.name}")
                thing = modules[name.asname or name.name] = getattr(room, name.name)
                yield name.name, thing
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules:
            yield f"{node.value.id}.{node.attr}", getattr(modules[node.value.id], node.attr, None)


def test_python_calls_entries_only():
    found = {
        f"{path.relative_to(SOURCE)}: {name}": thing
        for path in READERS
        for name, thing in used(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert "engine/motion.py: event_loop.run" in found
    assert not [place for place, thing in found.items() if isinstance(thing, jit.Inner)]


def test_a_kernel_of_kernels_can_be_called_from_python():
    row = tables_of("planar").flow[0]
    assert isinstance(flow_planar.own_rate, jit.Inner)
    assert flow_planar.own_rate(row) == flow_planar.own_rate.py_func(row) == 0.0
    assert not isinstance(flow_planar.own_rate.caller, jit.Inner)
    assert not isinstance(event_loop.run, jit.Inner)


@pytest.mark.parametrize("kind", ["planar", "modal"])
def test_a_kernel_calls_the_kernel_of_the_kind_of_flow(kind):
    @jit.numba.njit
    def quarter(flow, state, out):
        dispatch.advance(flow, 0, state, 0.5 * np.pi, out)

    flow, out = tables_of(kind).flow, np.empty(2)
    quarter(flow, np.array([1.0, 0.0]), out)
    np.testing.assert_allclose(out, [0.0, -1.0], atol=1e-15)


@pytest.mark.parametrize("said", [True, False])
def test_a_kernel_is_not_inlined_because_its_caller_is(said):
    """Without ``forceinline`` among the options the first caller would decide, as the second case shows."""
    options = {name: value for name, value in jit.OPTIONS.items() if said or name != "forceinline"} | {"cache": False}

    @jit.numba.njit(**options)
    def below(x):
        return x + 1.0

    @jit.numba.njit(**{**options, "forceinline": True})
    def above(x):
        return 2.0 * below(x)

    assert above(1.0) == 4.0
    (code,) = below.inspect_llvm().values()
    assert ("alwaysinline" in code) != said
