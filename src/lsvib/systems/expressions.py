"""Expressions as people write them, read once into affine functions of the states whose coefficients are balls.

A number in a text is the decimal that it is, ``"0.1"`` a tenth; a float is the double that it is. What is allowed is a
list: numbers, names, + − * / **, a handful of functions, ``pi``. Nothing is ever evaluated as Python.
"""

import ast
import keyword
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from flint import arb

from lsvib.errors import EngineError, InputError
from lsvib.numbers import shown
from lsvib.systems.exact.arithmetic import added

FUNCTIONS = ("sqrt", "sin", "cos", "tan", "exp", "log", "abs")
_LONGEST = 2000  # characters of an expression, so that none takes long
LARGEST = 1e150  # a coefficient beyond it cannot be squared in doubles

Affine = tuple[Any, ...]  # a row: one coefficient for each state, the constant last; what is not there is the integer 0


def check_name(name: Any) -> str:
    """Return a name that an expression may hold; ``InputError`` for anything else."""
    if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name) or name in (*FUNCTIONS, "pi"):
        raise InputError(f"{shown(name)} cannot be a name: take letters, digits and _, and no function, nor pi.")
    return name


class Reader:
    """Reads expressions over some states, with parameters by name as balls.

    ``about`` in every method names the place in a sentence of refusal, such as ``modes.fly.v``.
    """

    def __init__(self, states: Sequence[str], known: Mapping[str, arb]) -> None:
        self.place, self.known, self.size = {name: i for i, name in enumerate(states)}, known, len(states) + 1

    def affine(self, given: Any, about: str) -> Affine:
        """Return an expression, or a number, as an affine function of the states."""
        if isinstance(given, (int, float)) and not isinstance(given, bool):
            return self._checked(self._constant(arb(given)), str(given), about)
        tree, text = _parsed(given, about)
        return self._checked(self._read(tree.body, text, about), text, about)

    def number(self, given: Any, about: str) -> arb:
        """Return an expression without states as a ball."""
        row = self.affine(given, about)
        if any(not _zero(x) for x in row[:-1]):
            raise InputError(f"{about} = {shown(given)} depends on a state, where a number is needed.")
        return arb(row[-1])

    def comparison(self, given: Any, about: str) -> Affine:
        """Return a condition such as ``x > 1`` as the affine function that is positive where it holds."""
        tree, text = _parsed(given, about)
        one = tree.body
        if not isinstance(one, ast.Compare) or len(one.ops) != 1:
            raise InputError(f"{about} = {shown(given)} is not a condition, such as x > 1.")
        sides = [self._read(side, text, about) for side in (one.left, one.comparators[0])]
        if isinstance(one.ops[0], (ast.Lt, ast.LtE)):
            sides.reverse()
        elif not isinstance(one.ops[0], (ast.Gt, ast.GtE)):
            raise InputError(f"{about} = {shown(given)} compares neither by > nor by <.")
        return self._checked(_sum(sides[0], sides[1], -1), text, about)

    def _checked(self, row: Affine, text: str, about: str) -> Affine:
        for x in row:
            if not abs(float(x)) < LARGEST:  # nor is it nan
                raise InputError(f"{about} = {shown(text)} has a coefficient that is no number below {LARGEST:g}.")
        return row

    def _constant(self, value: Any) -> Affine:
        return (*(0 for _ in range(self.size - 1)), 0 if value == 0 else value)

    def _read(self, node: ast.expr, text: str, about: str) -> Affine:
        match node:
            case ast.Constant(value=int(value)) if type(value) is int:
                return self._constant(arb(value))
            case ast.Constant(value=float()):
                return self._constant(arb(str(ast.get_source_segment(text, node)).replace("_", "")))
            case ast.Name(id=name) if name in self.place:
                return tuple(arb(1) if i == self.place[name] else 0 for i in range(self.size))
            case ast.Name(id="pi"):
                return self._constant(arb.pi())
            case ast.Name(id=name) if name in self.known:
                return self._constant(self.known[name])
            case ast.Name(id=name):
                names = ", ".join([*self.place, *self.known])
                raise InputError(f"{about} = {shown(text)} has the unknown name {name}; known are {names or 'none'}.")
            case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=operand):
                own = self._read(operand, text, about)
                return own if isinstance(node.op, ast.UAdd) else _times(own, -1)
            case ast.BinOp():
                return self._operation(node, text, about)
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
                own = self._read(argument, text, about)
                return self._constant(_function(name, self._plain(own, node, text, about), text, about))
        raise InputError(
            f"{about} = {shown(text)} holds {shown(ast.unparse(node))}, which is not understood: numbers, names, "
            f"+ - * / **, {', '.join(FUNCTIONS)} and pi are."
        )

    def _operation(self, node: ast.BinOp, text: str, about: str) -> Affine:
        left, right = (self._read(side, text, about) for side in (node.left, node.right))
        match node.op:
            case ast.Add() | ast.Sub():
                return _sum(left, right, 1 if isinstance(node.op, ast.Add) else -1)
            case ast.Mult():
                if _plain(left):
                    return _times(right, left[-1])
                return _times(left, self._plain(right, node, text, about))
            case ast.Div():
                divisor = arb(self._plain(right, node, text, about))
                if divisor.contains(0):
                    raise InputError(f"{about} = {shown(text)} divides by zero.")
                return _times(left, 1 / divisor)
            case ast.Pow():
                power = self._plain(right, node, text, about)
                if power == 1:
                    return left
                base = arb(self._plain(left, node, text, about))
                return self._constant(_real(base ** arb(power), text, about))
        raise InputError(f"{about} = {shown(text)} holds {shown(ast.unparse(node))}: only + - * / ** are understood.")

    def _plain(self, row: Affine, node: ast.expr, text: str, about: str) -> Any:
        if not _plain(row):
            term = ast.unparse(node)
            raise InputError(f"{about} = {shown(text)} is not affine in the states: the term {shown(term)} is not.")
        return row[-1]


def parameters(given: Mapping[str, Any]) -> dict[str, arb]:
    """Return parameters as balls; a value may be an expression of others, in any order."""
    known: dict[str, arb] = {}
    for start in given:
        waiting = [start]
        while waiting:
            name = waiting[-1]
            value = given[name]
            tree = None if isinstance(value, (int, float)) else _parsed(value, f"parameters.{name}")[0]
            names = {x.id for x in ast.walk(tree) if isinstance(x, ast.Name)} if tree else set()
            if missing := [x for x in given if x in names and x not in known]:
                if missing[0] in waiting:
                    raise InputError(f"parameters.{name} = {shown(value)} depends on itself, by {missing[0]}.")
                waiting.append(missing[0])
                continue
            known[name] = Reader((), known).number(value, f"parameters.{waiting.pop()}")
    return {name: known[name] for name in given}


def _parsed(given: Any, about: str) -> tuple[ast.Expression, str]:
    """Return the tree of an expression, and the text that it was read from."""
    if not isinstance(given, str) or len(given) > _LONGEST:
        raise InputError(f"{about} = {shown(given)} is neither a number nor an expression of at most {_LONGEST} signs.")
    text = " ".join(given.split())
    try:
        with warnings.catch_warnings(action="ignore"):  # of Python, which this is not
            return ast.parse(text, mode="eval"), text
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError(f"{about} = {shown(given)} is not an expression, such as -x - 0.1*v + A.") from None


def _function(name: str, value: Any, text: str, about: str) -> arb:
    return _real(abs(arb(value)) if name == "abs" else getattr(arb(value), name)(), text, about)


def _real(value: arb, text: str, about: str) -> arb:
    if not value.is_finite():
        raise InputError(f"{about} = {shown(text)} is no real number.")
    return value


def _zero(x: Any) -> bool:
    return x.__class__ is int and x == 0


def _plain(row: Affine) -> bool:
    return all(map(_zero, row[:-1]))


def _sum(left: Affine, right: Affine, factor: int) -> Affine:
    try:
        return tuple(added(x, y if _zero(y) else factor * y) for x, y in zip(left, right, strict=True))
    except EngineError as error:
        raise InputError(str(error)) from None


def _times(row: Affine, factor: Any) -> Affine:
    return tuple(0 if _zero(x) or factor == 0 else x * factor for x in row)
