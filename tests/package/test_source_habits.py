"""Habits of the sources and of the judge: reasons are given, a name means one thing, no room asks for the model."""

import ast
import re
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

import pytest

from lsvib.drives.model_files import model_names
from lsvib.drives.registry import find_model

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


# What belongs to one model stands in its own file and in the folders ``*_of_models``. The benchmarks compare with
# references that know one model each; ``model_of`` fills in the model that is meant if none is named; a data sheet has
# parts that are compliant or, with the word of the model, rigid.
OF_ONE_MODEL = (
    *("src/lsvib/bench/*", "src/lsvib/*/*_of_models/*", "src/lsvib/drives/parameters.py"),
    *("src/lsvib/assess/assessment.py", "src/lsvib/assess/sheet.py"),
)


def questions_about_the_model(text: str) -> Iterator[int]:
    """Yield the lines that compare with the name of a model, or ask whether a drive is of the class of one."""
    classes = {find_model(name).drive.__name__ for name in model_names()}
    for node in ast.walk(ast.parse(text)):
        parts: list[ast.expr] = []
        if isinstance(node, ast.Compare):
            parts = [node.left, *node.comparators]
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("isinstance", "issubclass"):
            parts = node.args[1:]
        inner = [one for part in parts for one in ast.walk(part)]
        named = any(isinstance(one, ast.Constant) and one.value in model_names() for one in inner)
        if named or any(getattr(one, "id", getattr(one, "attr", "")) in classes for one in inner):
            yield node.lineno


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('if drive.model == "rigid": pass\n', [1]),
        ('x = 1\ny = model in ("nut", "other")\n', [2]),
        ("isinstance(drive, ThreadsParameters)\n", [1]),
        ("isinstance(drive, a.NutParameters | int)\n", [1]),
        ("kind is SupportParameters\n", [1]),
        ('isinstance(drive, DriveParameters) and name == "threads_of_time"\nRigidParameters()\n', []),
    ],
)
def test_what_asks_about_the_model(text, found):
    assert list(questions_about_the_model(text)) == found


def test_no_room_asks_which_model_a_drive_is_of():
    found = []
    for path in SOURCES:
        name = path.relative_to(ROOT).as_posix()
        if name.startswith("src/") and not any(fnmatch(name, pattern) for pattern in OF_ONE_MODEL):
            found += [f"{name}:{line}" for line in questions_about_the_model(path.read_text(encoding="utf-8"))]
    assert not found, found
