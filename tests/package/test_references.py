"""What judges the library stands on nothing of it: references import only each other and mathematics."""

import ast
from pathlib import Path

import pytest

REFERENCES = Path(__file__).parents[1] / "references"
JUDGES = ("bodies", "exponential_sums", "four_states_digits", "four_states_laws", "friction_law_digits",
          "friction_law_series", "newton", "oscillator", "rigid_digits", "rigid_flow", "sliding_friction",
          "threshold_digits")  # fmt: skip
KNOWN = {"flint", "mpmath", "numpy", "scipy.integrate"}
STANDARD = {"collections", "dataclasses", "functools", "itertools", "math", "operator", "re"}


@pytest.mark.parametrize("name", JUDGES)
def test_a_reference_imports_nothing_that_it_judges(name):
    tree = ast.parse((REFERENCES / f"{name}.py").read_text(encoding="utf-8"))
    found = {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    found |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level}
    found |= {f"references.{n.module}" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level}
    ours = {f"references.{judge}" for judge in JUDGES}
    assert {module for module in found if module.split(".")[0] not in STANDARD} <= ours | KNOWN
