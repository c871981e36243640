"""Habits of the sources and of the judge: constants and long functions have reasons, a name means one thing."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted(path for folder in ("src/lsvib", "tests/judge") for path in (ROOT / folder).rglob("*.py"))
NAMED_ALIKE = {  # names that several things share, and why
    "Settings": "the type of a figure's settings is found by this name in its folder",
}


def is_numeric(value: ast.expr) -> bool:
    """A number, a sum or product with one, or a tuple of numbers; what is looked up or computed is none."""
    if isinstance(value, ast.Tuple):
        return (
            bool(value.elts)
            and all(isinstance(part, ast.Constant | ast.UnaryOp) for part in value.elts)
            and any(map(is_numeric, value.elts))
        )
    if isinstance(value, ast.BinOp | ast.UnaryOp):
        return any(is_numeric(part) for part in ast.iter_child_nodes(value) if isinstance(part, ast.expr))
    return isinstance(value, ast.Constant) and type(value.value) in (int, float, complex)


def without_reason(text: str) -> Iterator[int]:
    """Yield the lines of constants without a comment; one comment holds for the lines right below it."""
    lines, told = text.splitlines(), -1
    for node in ast.parse(text).body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        above = (node.lineno > 1 and lines[node.lineno - 2].startswith("#")) or told == node.lineno - 1
        if above:
            told = node.end_lineno or node.lineno
        if is_numeric(node.value) and not above and not any("#" in x for x in lines[node.lineno - 1 : node.end_lineno]):
            yield node.lineno


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("_A = 3\n", [1]),
        ("_A = 3  # of a kind\n", []),
        ("# Parts of a turn.\n_A = -1e-3\n_B: float = 2 * 4\n\n_C = (1, 2)\n", [5]),
        ("_A = f(3)\n_B = ('a', 'b')\n_C = True\n", []),
    ],
)
def test_the_rule_itself(text, found):
    assert list(without_reason(text)) == found


def test_numeric_constants_have_their_reason():
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in SOURCES
        for line in without_reason(path.read_text(encoding="utf-8"))
    ]
    assert not found, found


def test_long_functions_say_why():
    """A function above sixty lines says in its docstring why it is one loop, or long."""
    found = [
        f"{path.relative_to(ROOT)}: {node.name}"
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and (node.end_lineno or 0) - node.lineno >= 60
        if not re.search(r"\b(loop|long)\b", ast.get_docstring(node) or "", re.IGNORECASE)
    ]
    assert not found, found


def names_of_things(text: str) -> Iterator[str]:
    """Yield the names of all classes, and the public names of modules that begin like one, such as types."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield node.name
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            if isinstance(target, ast.Name) and target.id[0].isupper() and not target.id.isupper():
                yield target.id


def test_what_names_of_things_are():
    text = "Span = float\nHalf: type = int\nLIMIT = 3\n_Own = str\nsmall = 1\nclass Whole:\n    class _Inner: ...\n"
    assert sorted(names_of_things(text)) == ["Half", "Span", "Whole", "_Inner"]


def test_a_name_means_one_thing():
    places: dict[str, list[str]] = {}
    for path in SOURCES:
        for name in names_of_things(path.read_text(encoding="utf-8")):
            places.setdefault(name, []).append(str(path.relative_to(ROOT)))
    twice = {name: found for name, found in places.items() if len(found) > 1}
    assert twice.keys() == NAMED_ALIKE.keys(), {k: v for k, v in twice.items() if k not in NAMED_ALIKE}
