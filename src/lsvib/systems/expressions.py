"""Expressions as people write them, read once into affine functions of the states whose coefficients are balls.

A number in a text is the decimal that it is, ``"0.1"`` a tenth; a float is the double that it is. What is allowed is a
list: numbers, names, + − * / **, a handful of functions, ``pi``. Nothing is ever evaluated as Python.
"""

import ast
import keyword
import warnings
from collections.abc import Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import Any

from flint import arb

from lsvib.errors import InputError
from lsvib.numbers import shown
from lsvib.systems.automaton import scaled
from lsvib.systems.exact.arithmetic import added, nothing

FUNCTIONS = ("sqrt", "sin", "cos", "tan", "exp", "log", "abs")
_LONGEST = 2000  # characters of an expression, so that none takes long
_HINTS = {"BitXor": "; write ** for powers", "Compare": "; leave out the comparison", "t": "; use harmonics or a clock"}
_HINTS |= dict.fromkeys(("sign", "max", "min", "abs"), "; use surfaces or events")
LARGEST = 1e150  # a coefficient beyond it cannot be squared in doubles

Affine = tuple[Any, ...]  # a row: one coefficient for each state, the constant last; what is not there is the integer 0


def check_name(name: Any) -> str:
    """Return a name that an expression may hold; ``InputError`` for anything else."""
    if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name) or name in (*FUNCTIONS, "pi"):
        raise InputError(f"{shown(name)} cannot be a name: use letters, digits and _, but no function and not pi.")
    return name


class Reader:
    """Reads expressions over some states, with parameters by name as balls.

    ``about`` in every method names the place in a sentence of refusal, such as ``modes.fly.v``.
    """

    def __init__(self, states: Sequence[str], known: Mapping[str, arb]) -> None:
        self.text, self.start = "", ""  # what is read now, and how a sentence about it starts
        self.none = [0 for _ in states]
        self.rows = {name: (*self.none[:k], arb(1), *self.none[k:]) for k, name in enumerate(states)}
        self.rows |= {name: self._constant(x) for name, x in {**known, "pi": arb.pi()}.items()}

    def affine(self, given: Any, about: str) -> Affine:
        """Return an expression, or a number, as an affine function of the states."""
        self.start = f"{about} = {shown(given)}"
        if isinstance(given, (int, float)) and not isinstance(given, bool):
            return self._checked(self._constant(arb(given)))
        tree, self.text = _parsed(given, about)
        return self._checked(self._whole(tree))

    def number(self, given: Any, about: str) -> arb:
        """Return an expression without states as a ball."""
        row = self.affine(given, about)
        if linear(row):
            raise self._refusal("depends on a state, where a number is needed.")
        return arb(row[-1])

    def comparison(self, given: Any, about: str) -> Affine:
        """Return a condition such as ``x > 1`` as the affine function that is positive where it holds."""
        self.start, (one, self.text) = f"{about} = {shown(given)}", _parsed(given, about)
        match one:
            case ast.Compare(left=less, ops=[ast.Lt() | ast.LtE()], comparators=[more]):
                pass
            case ast.Compare(left=more, ops=[ast.Gt() | ast.GtE()], comparators=[less]):
                pass
            case _:
                raise self._refusal("is not a condition, such as x > 1.")
        return self._checked(plus(self._whole(more), self._whole(less), -1))

    def _refusal(self, what: str) -> InputError:
        return InputError(f"{self.start} {what}")

    def _checked(self, row: Affine) -> Affine:
        if not all(abs(float(x)) < LARGEST for x in row):  # nor is one nan
            raise self._refusal(f"has a coefficient that is not a number below {LARGEST:g}.")
        return row

    def _constant(self, value: Any) -> Affine:
        if isinstance(value, arb) and not value.is_finite():
            raise self._refusal("is not a real number.")
        return (*self.none, 0 if value == 0 else value)

    def _whole(self, tree: ast.expr) -> Affine:
        try:
            return self._read(tree)
        except RecursionError:
            raise self._refusal("is nested too deeply.") from None

    def _read(self, node: ast.expr) -> Affine:
        match node:
            case ast.Constant(value=int(value)) if type(value) is int:
                return self._constant(arb(value))
            case ast.Constant(value=float()):
                return self._constant(arb(str(ast.get_source_segment(self.text, node)).replace("_", "")))
            case ast.Name(id=name) if name in self.rows:
                return self.rows[name]
            case ast.Name(id=name):
                names = ", ".join(x for x in [*self.rows][:-1] if x.isidentifier()) or "none"
                raise self._refusal(f"has the unknown name {name}{_hint(node)}; known are {names}.")
            case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=operand):
                return scaled(self._read(operand), 1 if isinstance(node.op, ast.UAdd) else -1)
            case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.Pow()):
                return self._operation(node)
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
                number = arb(self._plain(self._read(argument), node))
                return self._constant(getattr(number, "__abs__" if name == "abs" else name)())
        what = _hint(node) or f"; use numbers, names, + - * / **, {', '.join(FUNCTIONS)} and pi"
        raise self._refusal(f"holds {shown(ast.unparse(node))}, which is not allowed{what}.")

    def _operation(self, node: ast.BinOp) -> Affine:
        left, right = self._read(node.left), self._read(node.right)
        if isinstance(node.op, (ast.Add, ast.Sub)):
            return plus(left, right, 1 if isinstance(node.op, ast.Add) else -1)
        if isinstance(node.op, ast.Mult) and not linear(left):
            return scaled(right, left[-1])
        second = arb(self._plain(right, node))
        if isinstance(node.op, ast.Mult):
            return scaled(left, second)
        if isinstance(node.op, ast.Pow):
            return left if second == 1 else self._constant(arb(self._plain(left, node)) ** second)
        if second.contains(0):
            raise self._refusal("divides by zero.")
        return scaled(left, 1 / second)

    def _plain(self, row: Affine, node: ast.expr) -> Any:
        if linear(row):
            raise self._refusal(f"is not affine in the states; {shown(ast.unparse(node))} is not{_hint(node)}.")
        return row[-1]


def parameters(given: Mapping[str, Any]) -> dict[str, arb]:
    """Return parameters as balls; a value may be an expression of others, in any order."""
    known, needs = dict[str, arb](), dict[str, set[str]]()
    for name, value in given.items():
        tree = ast.walk(_parsed(value, f"parameters.{name}")[0]) if isinstance(value, str) else ()
        needs[name] = {x.id for x in tree if isinstance(x, ast.Name)} & given.keys()
    try:
        for name in TopologicalSorter(needs).static_order():
            known[name] = Reader((), known).number(given[name], f"parameters.{name}")
    except CycleError as error:
        name, *others = sorted({*error.args[1]})
        by = ", ".join(others or [name])
        raise InputError(f"parameters.{name} = {shown(given[name])} depends on itself, by {by}.") from None
    return known


def _parsed(given: Any, about: str) -> tuple[ast.expr, str]:
    """Return the tree of an expression, and the text that it was read from."""
    if not isinstance(given, str) or len(given) > _LONGEST:
        raise InputError(f"{about} = {shown(given)} is not a number or an expression of at most {_LONGEST} characters.")
    try:
        with warnings.catch_warnings(action="ignore"):  # of Python, which this is not
            return ast.parse(text := " ".join(given.split()), mode="eval").body, text
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError(f"{about} = {shown(given)} is not an expression, such as -x - 0.1*v + A.") from None


def _hint(node: ast.expr) -> str:
    """Return what to write instead of a name, a function or an operation that an expression cannot hold."""
    return _HINTS.get(getattr(getattr(node, "func", node), "id", type(getattr(node, "op", node)).__name__), "")


def linear(row: Affine) -> list[int]:
    """Return the places of the coefficients of states that are there."""
    return [i for i, x in enumerate(row[:-1]) if not nothing(x)]


def plus(left: Affine, right: Affine, factor: int = 1) -> Affine:
    """Return the sum of two affine functions, or their difference."""
    return tuple(map(added, left, scaled(right, factor)))
