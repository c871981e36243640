r"""Defining equations of a threshold, solved for any parameter of a drive, with the derivatives by all others.

A threshold is a system F(y, p) = 0 of n equations in n − 1 inner unknowns y, such as times, and one parameter x of the
drive; p are all its parameters. Newton's method solves it in 70 digits with the exact Jacobian (forward
differentiation, :mod:`lsvib.engine.exact.duals`). By the implicit function theorem

    d(y, x)/dp_j = −[∂F/∂y, ∂F/∂x]⁻¹ ∂F/∂p_j

for every other parameter p_j, from the same Jacobian. The solution is then rounded to a double.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lsvib.engine.exact.duals import Dual, many, number, variables
from lsvib.models.drive import Drive

Equations = Callable[[Mapping[str, Dual], Sequence[Dual]], Sequence[Dual]]
"""F as a function of the parameters by name and the inner unknowns, both as numbers with derivatives."""

_NEWTON = 40  # steps; from the nine digits of a bracketed root four of them reach all that 70 digits allow
_FIXED = 1e-35  # relative change after which one more step, which squares it, is the last
_REACH = 1e-4  # relative, from the start, which is good to 1e-8 (of an extremum) or better
_CANCELLED = 1e-45  # of the terms of an equation: what rounding leaves of them in 70 digits


class Singular(Exception):
    """The Jacobian vanishes, or all but vanishes: a double root, which has no derivatives."""


@dataclass(frozen=True)
class Root:
    """A solution: ``value`` of the unknown as a double, its ``exact`` digits, those of the ``inner`` unknowns.

    ``residual`` [1]: what is left of the equations at the double, relative to their terms; ``error_bound`` [unit of
    the unknown]: distance of the double from the digits, and twice what the digits still miss; ``derivatives``, of the
    unknown by every other parameter.
    """

    value: float
    exact: Any
    inner: tuple[Any, ...]
    residual: float
    error_bound: float
    derivatives: Mapping[str, float]


def solved(drive: Drive, unknown: str, equations: Equations, guess: Any, inner: Sequence[Any] = ()) -> Root:
    """Solve the equations of a threshold for a parameter of a drive.

    Arguments: drive; name of the unknown; equations; a ``guess`` of the unknown and of the ``inner`` unknowns, each
    good to four digits. Raises ``Singular`` at a double root, and where Newton's method finds no root so close.
    """
    names = list(type(drive).model_fields)
    fixed = {name: number(value) for name, value in drive}
    # The unknowns: the inner ones, then the parameter.
    begin = place = [number(value) for value in (*inner, guess)]
    columns = [*range(len(inner)), len(inner) + names.index(unknown)]
    close = False
    for _ in range(_NEWTON):
        values, jacobian, _ = _linearised(names, {**fixed, unknown: place[-1]}, place[:-1], equations)
        step = _solved(jacobian, columns, values)
        place = [x - dx for x, dx in zip(place, step, strict=True)]
        if any(abs(x - near) > _REACH * abs(near) for x, near in zip(place, begin, strict=True)):
            raise Singular
        if close:
            break
        close = all(abs(dx) <= _FIXED * abs(x) for x, dx in zip(place, step, strict=True))
    else:
        raise Singular
    values, jacobian, sizes = _linearised(names, {**fixed, unknown: place[-1]}, place[:-1], equations)
    weights = _last_row_of_inverse(jacobian, columns)
    missing = many.fsum(w * value for w, value in zip(weights, values, strict=True))
    hidden = _CANCELLED * many.fsum(abs(w) * size for w, size in zip(weights, sizes, strict=True))
    derivatives = {
        name: -float(many.fsum(w * row[len(inner) + k] for w, row in zip(weights, jacobian, strict=True)))
        for k, name in enumerate(names)
        if name != unknown
    }
    rounded = float(place[-1])
    at_double, _, terms = _linearised(names, {**fixed, unknown: number(rounded)}, place[:-1], equations)
    bound = abs(number(rounded) - place[-1]) + 2 * (abs(missing) + hidden)
    return Root(
        value=rounded,
        exact=place[-1],
        inner=tuple(place[:-1]),
        residual=max((float(abs(f) / size) if f else 0.0) for f, size in zip(at_double, terms, strict=True)),
        error_bound=math.nextafter(float(bound), math.inf) if bound else 0.0,
        derivatives={name: slope + 0.0 for name, slope in derivatives.items()},
    )


def _linearised(
    names: Sequence[str], parameters: Mapping[str, Any], inner: Sequence[Any], equations: Equations
) -> tuple[list[Any], list[tuple[Any, ...]], list[Any]]:
    """Values of the equations, their derivatives by (inner, parameters), and the sizes of their terms, Σ |∂F/∂z z|."""
    at = [*inner, *(parameters[name] for name in names)]
    seeds = variables(at)
    found = equations(dict(zip(names, seeds[len(inner) :], strict=True)), seeds[: len(inner)])
    jacobian = [equation.slopes for equation in found]
    sizes = [many.fsum(abs(slope * z) for slope, z in zip(row, at, strict=True)) for row in jacobian]
    return [equation.value for equation in found], jacobian, sizes


def _solved(jacobian: Sequence[Sequence[Any]], columns: Sequence[int], side: Sequence[Any]) -> list[Any]:
    """Solve the linear equations of the unknowns in ``columns``."""
    matrix = many.matrix([[row[k] for k in columns] for row in jacobian])
    try:
        return list(many.lu_solve(matrix, many.matrix(list(side))))
    except ZeroDivisionError:
        raise Singular from None


def _last_row_of_inverse(jacobian: Sequence[Sequence[Any]], columns: Sequence[int]) -> list[Any]:
    """The weights (n) with which the equations count in the last unknown."""
    n = len(columns)
    return [_solved(jacobian, columns, [int(i == k) for i in range(n)])[-1] for k in range(n)]
