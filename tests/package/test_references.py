"""What judges the library stands on nothing of it: the references in many digits import only each other and mpmath."""

import ast
from pathlib import Path

import pytest

REFERENCES = Path(__file__).parents[1] / "references"
JUDGES = ("exponential_sums", "four_states_digits", "four_states_laws", "newton", "rigid_digits", "rigid_flow",
          "threshold_digits")  # fmt: skip


@pytest.mark.parametrize("name", JUDGES)
def test_a_reference_imports_nothing_that_it_judges(name):
    tree = ast.parse((REFERENCES / f"{name}.py").read_text(encoding="utf-8"))
    found = {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    found |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level}
    found |= {f"references.{n.module}" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level}
    standard = {"collections", "dataclasses", "functools", "itertools", "math"}
    ours = {f"references.{judge}" for judge in JUDGES}
    assert {module for module in found if module.split(".")[0] not in standard} <= ours | {"mpmath", "numpy"}
