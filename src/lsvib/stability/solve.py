"""Roots: bracketed, isolated, searched for, and of systems of equations with an enclosure and exact derivatives.

A threshold is a system F(y, x; p) = 0 of n equations in n − 1 inner unknowns y, such as times, and one parameter x of
the drive; p are all its other parameters. docs/thresholds.md says how it is found, proved and differentiated; F takes
power series of two terms (an ``arb_series`` a + b ε).
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_poly, arb_series, fmpq

from lsvib.drives import friction
from lsvib.drives.complaints import bounds_of
from lsvib.drives.drive import PART_OF, PARTS, Drive
from lsvib.errors import InputError, NoThreshold
from lsvib.numbers import bisected
from lsvib.stability.spectrum import SAME
from lsvib.systems.exact.arithmetic import many_digits

Equations = Callable[[Mapping[str, Any], Sequence[Any]], Sequence[Any]]
"""F as a function of the parameters by name and the inner unknowns, all of them balls or power series."""

_WHOLE = ("stribeck_exponent",)  # parameters that are whole numbers, by which there is no derivative
DECADES = 6  # of a search, on both sides of its middle
_ORDER = 12  # of a Taylor polynomial: next to a double root, or where large terms cancel, boxes may still be wide
_MOST = 4000  # boxes, some seconds
_CLOSE = 1e-29  # relative error of an isolated root


class Singular(Exception):
    """The Jacobian vanishes, or all but vanishes: a double root, which has no derivatives."""


@dataclass(frozen=True)
class Root:
    """A proved solution: enclosures of the unknown parameter and its derivatives by all others."""

    unknown: arb
    derivatives: Mapping[str, arb]


def bracketed_root(function: Callable[[Any], Any], low: Any, high: Any, tolerance: float) -> Any:
    """Root of a function between ``low`` and ``high``, where it has different signs, to a relative tolerance [1].

    In floats or in balls, of which only the midpoints count. Chandrupatla's method: inverse quadratic steps where they
    are safe, halves elsewhere.
    """
    a, b = _middle(high), _middle(low)
    value_a, value_b = _middle(function(a)), _middle(function(b))
    c, value_c, part, best = a, value_a, 0.5, b
    for _ in range(400):  # more than halves of halves ever take
        x = _middle(a + part * (b - a))
        value = _middle(function(x))
        if (value > 0) == (value_a > 0):
            c, value_c = a, value_a
        else:
            c, b, value_c, value_b = b, a, value_b, value_a
        a, value_a = x, value
        if value_a == 0 or value_b == 0:
            return a if value_a == 0 else b
        ratio, other = float(value_a / value_b), float(value_c / value_b)  # negative; the values themselves may be tiny
        best = a if ratio > -1 else b
        limit = float(tolerance * abs(best) / abs(b - a)) if b != a else 1.0
        if limit > 0.5:
            return best
        part = 0.5
        if other in (ratio, 1.0):  # the function is flat to rounding
            continue
        share, rise = float((a - b) / (c - b)), (ratio - 1) / (other - 1)
        if rise**2 < share and (1 - rise) ** 2 < 1 - share:
            part = ratio / (1 - ratio) * other / (1 - other)
            part += float((c - a) / (b - a)) * ratio / (other - ratio) / (other - 1)
            part = min(max(part, limit), 1 - limit)
    return best


def isolated_roots(function: Callable[[Any], Any], low: fmpq, high: fmpq) -> list[fmpq] | None:
    """Return all roots between ``low`` > 0 and ``high``, ascending; None if the function does not depend on x.

    The function is of a ball or a power series. On a box of the half-width r about its middle m it is a Taylor
    polynomial of h = x − m, |h| <= r, whose coefficients are those of m, but for the last one, which is that of the
    whole box. Where this holds no zero there is no root; where its derivative has none there is one exactly if the ends
    of the box differ in sign; other boxes are halved. Roots that lie closer together than ``SAME`` count as one, and as
    none where the sign is the same on both sides. To be called with many digits. Raises ``NoThreshold`` where roots
    cannot be told apart.
    """

    def value(x: Any) -> arb:
        return arb(function(arb(x)))

    span = (arb(high) / arb(low)).log()
    if all(_series(function, (arb(low) * (span * n / 64).exp()).mid(), 1)[1].contains(0) for n in range(65)):
        return None
    boxes: list[tuple[fmpq, fmpq]] = []
    roots: list[fmpq] = []
    start = low
    while start < high:
        boxes.append((start, min(2 * start, high)))
        start = 2 * start
    boxes.reverse()
    for _ in range(_MOST):
        if not boxes:
            return roots
        a, b = boxes.pop()
        if not value(_box(a, b)).contains(0):  # as where all terms have one sign
            continue
        whole, slope = _over(function, a, b)
        if not whole.contains(0):
            continue
        if not slope.contains(0):
            ends = value(a) * value(b)
            if ends < 0:
                roots.append(arb(bracketed_root(value, arb(a), arb(b), _CLOSE)).mid().fmpq())
            if ends != 0:  # for certain
                continue
        if b - a < SAME * a:
            below, above = a * (1 - 2 * SAME), b * (1 + 2 * SAME)
            ends = value(below) * value(above)
            if ends < 0 and not (roots and roots[-1] > below):
                roots.append((a + b) / 2)
            if ends != 0:
                continue
        boxes += [((a + b) / 2, b), (a, (a + b) / 2)]
    raise NoThreshold(
        "the roots of an equation of the threshold cannot be separated: two are too close, or it nearly vanishes."
    )


def _series(function: Callable[[Any], Any], x: arb, order: int) -> list[arb]:
    """The Taylor coefficients at a ball, up to an order."""
    found = arb_series(function(arb_series([x, 1], prec=order + 1)), prec=order + 1)
    return [found[k] for k in range(order + 1)]


def _box(a: fmpq, b: fmpq) -> arb:
    middle = arb((a + b) / 2)
    return arb(middle.mid(), arb((b - a) / 2).abs_upper() + middle.rad())


def _over(function: Callable[[Any], Any], a: fmpq, b: fmpq) -> tuple[arb, arb]:
    """Enclosures of the values and of the derivative between two numbers."""
    terms = [*_series(function, arb((a + b) / 2), _ORDER - 1), _series(function, _box(a, b), _ORDER)[-1]]
    h, polynomial = arb(0, arb((b - a) / 2).abs_upper()), arb_poly(terms)
    return polynomial(h), polynomial.derivative()(h)


def solved(drive: Drive, unknown: str, equations: Equations, guess: Any, inner: Sequence[Any] = ()) -> Root:
    """Solve the equations of a threshold for a parameter of a drive, and prove the solution.

    Arguments: drive; name of the unknown; equations; a ``guess`` of the unknown and of the ``inner`` unknowns, each
    good to four digits. Raises ``Singular`` at a double root, and where no root so close is proved.
    """
    with many_digits():
        fixed, count = {name: arb(value) for name, value in drive}, len(inner)
        names = [*fixed, *([] if unknown in fixed else [unknown])]
        columns = [*range(count), count + names.index(unknown)]

        def linearised(place: Sequence[arb], more: Sequence[int] = ()) -> tuple[list[arb], list[list[arb]]]:
            """Values of the equations at (y, x), and their derivatives by y, x and ``more`` of the parameters."""
            parameters = {**fixed, unknown: place[-1]}
            at, by_column = [*place[:-1], *(parameters[name] for name in names)], []
            for k in (*columns, *more):
                seeded = [*at[:k], arb_series([at[k], 1], prec=2), *at[k + 1 :]]
                named = dict(zip(names, seeded[count:], strict=True))
                by_column.append([arb_series(x, prec=2) for x in equations(named, seeded[:count])])
            return [x[0] for x in by_column[0]], [[column[i][1] for column in by_column] for i in range(len(place))]

        place = _newton(linearised, [_middle(arb(x)) for x in (*inner, guess)])
        others = [count + k for k, name in enumerate(names) if name not in (unknown, *_WHOLE)]
        values, jacobian = linearised(place)
        step = _quotient(jacobian, [[value] for value in values])
        box = [m + arb(0, 4 * row[0].abs_upper()) for m, row in zip(place, step, strict=True)]
        _, slopes = linearised(box, others)
        n = len(place)
        jacobian = [row[:n] for row in slopes]
        proved = [m - row[0] for m, row in zip(place, _quotient(jacobian, [[v] for v in values]), strict=True)]
        if not all(x == y or x.contains_interior(y) for x, y in zip(box, proved, strict=True)):
            raise Singular
        found = _quotient(jacobian, [row[n:] for row in slopes])[-1] if others else []
        of = {names[k - count]: -slope for k, slope in zip(others, found, strict=True)}
        return Root(proved[-1], of)


def _newton(linearised: Callable[[list[arb]], tuple[list[arb], list[list[arb]]]], place: list[arb]) -> list[arb]:
    """Return the midpoint of a root next to a place."""
    begin, close = place, False
    for _ in range(40):  # from nine digits five steps reach 150
        values, jacobian = linearised(place)
        step = [_middle(row[0]) for row in _quotient(jacobian, [[value] for value in values])]
        place = [_middle(x - dx) for x, dx in zip(place, step, strict=True)]
        # The start is good to 1e-8 (of an extremum) or better.
        if not all(abs(x - near) <= 1e-4 * abs(near) for x, near in zip(place, begin, strict=True)):
            raise Singular
        if close:
            return place
        # One more step, which squares the change, is the last.
        close = all(abs(dx) <= 1e-60 * abs(x) for x, dx in zip(place, step, strict=True))
    raise Singular


def _quotient(matrix: list[list[arb]], sides: list[list[arb]]) -> list[list[arb]]:
    try:
        found: list[list[arb]] = arb_mat(matrix).solve(arb_mat(sides)).tolist()
    except ZeroDivisionError:
        raise Singular from None
    return found


def _middle(x: Any) -> Any:
    return x.mid() if isinstance(x, arb) else x


def outwards(ball: arb) -> tuple[float, float]:
    """Return the narrowest doubles that enclose a ball; infinite where there is none."""
    low, high = float(ball.lower()), float(ball.upper())
    if not arb(low) <= ball.lower():
        low = math.nextafter(low, -math.inf)
    if not arb(high) >= ball.upper():
        high = math.nextafter(high, math.inf)
    return low, high


Sample = tuple[float, float | None]  # a value of the parameter and the gap there, None where there is none


def crossings(at: Callable[[float], float | None], places: Sequence[float], tolerance: float) -> Iterator[float]:
    """Yield where a gap, None where there is none, changes its sign, in ascending order, to a relative tolerance [1].

    It is sampled at ``places``, ascending; where the gap begins or ends between two samples, that place is halved down,
    and so is a change of sign. A jump through zero is among them; what lies between two samples without a change of
    sign stays unseen.
    """

    def defined(value: float) -> float:
        if (found := at(value)) is None:
            raise NoThreshold
        return found

    known: list[Sample] = [(value, at(value)) for value in places]
    ordered = known[:1]
    for before, after in pairwise(known):
        if (before[1] is None) != (after[1] is None):
            ordered.append(_edge(at, before, after))
        ordered.append(after)
    for before, after in pairwise(ordered):
        if before[1] is not None and after[1] is not None and (before[1] > 0) != (after[1] > 0):
            with suppress(NoThreshold):  # it is not defined somewhere on the way
                yield bracketed_root(defined, before[0], after[0], tolerance)


def _edge(at: Callable[[float], float | None], before: Sample, after: Sample) -> Sample:
    """The last place at which the gap is defined between two samples of which one is not, to 1e-9 of the step."""
    inside, outside = (before, after) if before[1] is not None else (after, before)
    for _ in range(30):
        middle = 0.5 * (inside[0] + outside[0])
        found = at(middle)
        inside, outside = (inside, (middle, None)) if found is None else ((middle, found), outside)
    return inside


def samples(
    drive: Drive, unknown: str, ends: Sequence[float] = (), decades: int = DECADES, per_decade: int = 12
) -> list[float]:
    """Return the values of a parameter at which a gap is looked at, in ascending order, all of them allowed.

    Over so many ``decades`` on both sides of the drive's own value (or a natural size, if that is zero), with the last
    values that are allowed on the way; closer and closer, to 1e-8, to these and to the ``ends``, at which a threshold
    may begin or end.
    """
    middle = abs(getattr(drive, unknown)) or _natural(drive, unknown)
    sizes = middle * np.logspace(-decades, decades, 2 * per_decade * decades + 1)  # of 12, a fifth from one to the next
    signs = (-1, 1) if bounds_of(Drive, unknown).get("ge", 0) < 0 else (1,)
    values = sorted(sign * size for sign in signs for size in sizes.tolist())
    may_be = partial(allowed, drive, unknown)
    pairs = (sorted(pair, key=may_be) for pair in pairwise(values))
    limits = [bisected(may_be, out, inside) for out, inside in pairs if may_be(inside) and not may_be(out)]
    near = {end * (1 + side * 0.3**k) for end in (*ends, *limits) for side in (-1, 1) for k in range(1, 16)}
    return sorted(value for value in near.union(values, limits) if may_be(value))


def _natural(drive: Drive, unknown: str) -> float:
    """A size of a parameter that may be zero, from the others, in its SI unit."""
    rate = math.sqrt(drive.coupling_stiffness / drive.screw_inertia)  # 1/s
    lever = drive.pitch_radius * math.tan(drive.lead_angle)  # m
    force = abs(drive.axial_force) or drive.mass * lever * rate * abs(drive.input_speed)  # N
    torque = drive.pitch_radius * abs(drive.axial_force) * drive.friction_coefficient
    torque = torque or drive.screw_inertia * rate * abs(drive.input_speed)  # N m
    sizes: dict[str, float] = {
        "support_damping": drive.screw_inertia * rate,
        "translation_damping": drive.screw_inertia * rate / lever / lever,
        "axial_force": drive.mass * lever * rate * abs(drive.input_speed),
        "friction_coefficient": math.tan(drive.lead_angle),
        "static_friction_coefficient": friction.slowest(vars(drive)),
        **dict.fromkeys(friction.FADING, drive.friction_coefficient),
        **dict.fromkeys(friction.FADING.values(), drive.pitch_radius * abs(drive.input_speed)),
        "friction_slope": drive.friction_coefficient / (drive.pitch_radius * abs(drive.input_speed)),
        "slide_friction": drive.slide_static_friction or force,
        "slide_static_friction": drive.slide_friction or force,
        "bearing_friction": drive.bearing_static_friction or torque,
        "bearing_static_friction": drive.bearing_friction or torque,
        "collar_friction": math.tan(drive.lead_angle),
        "collar_radius": drive.pitch_radius,
        "coupling_damping": drive.screw_inertia * rate,
    }
    if unknown in sizes:
        return sizes[unknown]
    inertia, stiffness = (getattr(drive, name) for name in ("mass", *PARTS[PART_OF[unknown]])[-3:-1])  # of a damper
    return math.sqrt(inertia * stiffness)


def allowed(drive: Drive, unknown: str, value: float) -> bool:
    """Whether the drive may have this value of a parameter."""
    try:
        drive.replace(**{unknown: value})
    except InputError:
        return False
    return True
