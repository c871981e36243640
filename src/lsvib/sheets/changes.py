"""Changes of one quantity: how far a drive is from vibration, and what ends vibration or jerks.

What is advised is asked all that the verdict asks. It is looked for up to a factor of three, and rounded to what is
printed, two digits of it, before it is asked.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.drives.drive import PARTS, STATIC
from lsvib.sheets.draw import PAIRS, Draw, Operation
from lsvib.sheets.fields import LARGEST_HALF_ANGLE
from lsvib.sheets.formulas import Values
from lsvib.sheets.from_rest import Starter, places, speeds
from lsvib.sheets.reserves import NAMES
from lsvib.sheets.vibration import UNDECIDED
from lsvib.sheets.window import OperatingWindow, worst
from lsvib.sheets.words import QUANTITIES, Quantity

ANY = "any"
"""Stands in for a mechanism where all of them together are meant: whether steady sliding is unstable at all."""
MOST = 3.0  # the largest factor that is tried, and its inverse
_FACTORS = (1.5, MOST)
_CLOSE = 0.05  # of a change, to which it is closed in on
_LEAST_LAW = 0.1  # of the largest friction in the window: below it a law of friction is not what was measured


@dataclass(frozen=True)
class Change:
    """A change of one quantity: the nearest at which a mechanism sets in or, if it occurs, vanishes, or one advised.

    ``factor`` [1] is what the quantity is multiplied with, ``value`` the quantity then (the larger end of a window);
    both None if no factor from 0.001 to 1000 does it, of a flank angle none up to the largest of a sheet. Of a damping
    that is zero only the ``value`` is known, if one up to the critical damping does it.

    ``left``: of one advised, what is left of vibration with it at the middle values: ``""``, ``knock``, if a
    perturbation may still start vibration (``unknown knock``, if that is not known), ``start``, if steady running is
    stable, but not reached from rest, or ``unknown``, if it is not known whether it is.
    """

    quantity: str
    factor: float | None
    value: float | None
    left: str = ""

    @property
    def about(self) -> Quantity:
        """Name, words and unit of the quantity."""
        return QUANTITIES[self.quantity]

    def is_near(self, factor: float = 10.0) -> bool:
        """Whether it is worth a bar and a row: a change by no more than a factor of ten."""
        return self.factor is not None and 1 / factor <= self.factor <= factor


def changeable(values: Values) -> dict[str, tuple[str, ...]]:
    """Return the quantities whose change is looked at, by name: keys of ``values`` that are not zero.

    The tilt is not among them: an axis that stands upright cannot lean more, and its weight counts as ``force``.
    """
    paired = {key for keys in PAIRS.values() for key in keys} | {"tilt"}
    single = {key: (key,) for key, value in values.items() if key not in paired and np.any(value)}
    pairs = {name: keys for name, keys in PAIRS.items() if any(np.any(values[key]) for key in keys)}
    return {**single, **pairs}


def applied(draw: Draw, row: Change) -> Draw:
    """Return a drive with a change of one quantity."""
    if row.factor is None:
        return draw.changed(**{row.quantity: row.value})
    return draw.scaled(changeable(draw.values)[row.quantity], row.factor)


def damping_sizes(values: Values) -> dict[str, float]:
    """Return the size of a critical damping of each kind, √(inertia × stiffness) [SI units]."""
    turning = float(np.sqrt(values["screw_inertia"] * values["coupling_stiffness"]))
    sizes = {"support_damping": turning, "translation_damping": turning * (2 * np.pi / values["lead"]) ** 2}
    for mass, stiffness, damping in (("mass", *PARTS["threads"]), PARTS["support"]):
        if stiffness in values:
            sizes[damping] = float(np.sqrt(values[stiffness] * values[mass]))
    return sizes


def _occurs(draw: Draw) -> dict[str, NDArray[Any]]:
    """Whether each mechanism occurs (1, 0, or −1 where the drive cannot move), for drives given by arrays (n)."""
    occurs = {name: np.where(np.isnan(one.reserve), -1, one.reserve < 0) for name, one in worst(draw).items()}
    own = np.stack([flags for name, flags in occurs.items() if name in NAMES])
    return {**occurs, ANY: np.where(own[0] < 0, -1, own.max(axis=0))}


@dataclass(frozen=True)
class _Edge:
    """A verdict on a mechanism that changes between two factors on a quantity, from ``occurs`` at the first."""

    quantity: str
    base: Draw
    keys: tuple[str, ...]
    mechanism: str
    factors: tuple[float, float]
    occurs: int


def margins(draw: Draw) -> dict[str, list[Change]]:
    """Return for each mechanism, and for :data:`ANY` of them, the margin in every quantity, the smallest change first.

    A change to a drive that cannot move at all (μ ≥ cot λ) does not count.
    """
    per_decade = 30  # steps of 8 %; a narrower island of stability between two is not seen
    steps = np.linspace(0.0, 3.0, 3 * per_decade + 1)
    scans: list[tuple[str, tuple[str, ...], Draw, NDArray[Any]]] = []
    for name, keys in changeable(draw.values).items():
        up = 10.0**steps
        if name == "half_angle":  # beyond a right angle its tangent comes back, but there is no such thread
            most = max(LARGEST_HALF_ANGLE / draw.values[name], 1.0)
            up = np.append(up[up < most], most)
        scans += [(name, keys, draw, factors) for factors in (up, 10.0**-steps)]
    up = np.concatenate([[0.0], 10.0 ** np.linspace(-6.0, 0.0, 6 * per_decade + 1)])
    absent = {key: size for key, size in damping_sizes(draw.values).items() if draw.values[key] == 0}
    scans += [(name, (name,), draw.changed(**{name: size}), up) for name, size in absent.items()]
    result: dict[str, dict[str, Change]] = {}
    edges: list[_Edge] = []
    for name, keys, base, factors in scans:
        for mechanism, occurs in _occurs(base.scaled(keys, factors)).items():
            result.setdefault(mechanism, {})[name] = Change(name, None, None)
            changed = np.flatnonzero(occurs != occurs[0])
            if changed.size and occurs[changed[0]] >= 0:
                first = max(factors[changed[0] - 1], 1e-12)  # such a damping is as good as none
                pair = float(first), float(factors[changed[0]])
                edges.append(_Edge(name, base, keys, mechanism, pair, int(occurs[0])))
    for edge, factor in zip(edges, _refined(edges), strict=True):
        nearer = result[edge.mechanism][edge.quantity].factor
        if nearer is None or abs(np.log(factor)) < abs(np.log(nearer)):
            value = factor * max((float(edge.base.values[key]) for key in edge.keys), key=abs)
            known = factor if edge.base is draw else None
            result[edge.mechanism][edge.quantity] = Change(edge.quantity, known, value)
    found = {mechanism: list(rows.values()) for mechanism, rows in result.items()}
    for rows in found.values():
        rows.sort(key=lambda row: np.inf if row.factor is None else abs(np.log(row.factor)))
    return found


def _refined(edges: list[_Edge]) -> list[float]:
    """The first factor at which the verdict of each edge changes, to a part in 10⁹; all are looked at together."""
    if not edges:
        return []
    base, occurs = edges[0].base, np.array([edge.occurs for edge in edges])
    before, after = np.array([edge.factors for edge in edges]).T
    for _ in range(34):  # a step of 8 %, or of the smallest damping from 1e-12 on, is halved, to a part in 10⁹
        middle = before * np.sqrt(after / before)
        drives = [edge.base.scaled(edge.keys, factor).values for edge, factor in zip(edges, middle, strict=True)]
        flags = _occurs(base.changed(**{key: np.array([one[key] for one in drives]) for key in base.values}))
        there = np.array([flags[edge.mechanism][k] for k, edge in enumerate(edges)]) != occurs
        before, after = np.where(there, before, middle), np.where(there, middle, after)
    return [float(factor) for factor in after]


def advice(draw: Draw, edges: list[Change], vibrates: bool, starter: Starter) -> list[Change]:
    """Return the three smallest changes that end what a drive does at its middle values, and dampings that it lacks.

    ``edges``: the changes at which steady running becomes stable, for a drive that ``vibrates``; others jerk from rest.
    For a drive that vibrates three that leave jerks follow.
    """
    asker = Asker(draw, starter)
    near = {row.quantity: row for row in edges if vibrates and not draw.sheet.is_fixed(row.about.entry)}
    absent = [Change(name, None, _digits(row.value)) for name, row in near.items() if row.factor is None and row.value]
    found, ended = [replace(one, left=asker.left(applied(draw, one))) for one in absent], set()
    free = [name for name in changeable(draw.values) if not draw.sheet.is_fixed(QUANTITIES[name].entry)]
    sides = [(name, side) for name in free for side in _sides(draw, name, near.get(name))]
    steps = [(name, side[0] > 1, *step) for name, side in sides for step in pairwise([1.0, *side])]
    for name, larger, before, factor in sorted(steps, key=lambda step: _size(step[3])):
        sizes = sorted(_size(one.factor) for one in found if one.factor and not one.left)
        if (name, larger) in ended or (sizes[2:] and _size(before) >= sizes[2]):
            continue  # no smaller change is there
        one = _between(asker, name, before, factor, sizes[2] if sizes[2:] else math.inf)
        ended |= {(name, larger)} if one and not one.left else set()
        found += [one] if one else []
    best: dict[str, Change] = {}
    stable = [one for one in found if one.left != "vibrates"]
    for one in sorted(stable, key=lambda one: (bool(one.left), _size(one.factor or MOST))):
        best.setdefault(one.quantity, one)
    whole, part = ([one for one in best.values() if bool(one.left) == some] for some in (False, True))
    ends = [*[one for one in whole if one.factor][:3], *(one for one in whole if one.factor is None)]
    return [*(replace(one, left=knocked(applied(draw, one))) for one in ends), *(part[:3] if vibrates else ())]


def knocked(draw: Draw) -> str:
    """What a strong knock leaves of vibration, as of :class:`Change`."""
    if draw.sheet.closed:
        return "knock" if OperatingWindow(draw).most_perturbed[0] else ""
    ends = {there.after_knock for there in _points(draw)} - {"steady sliding"}
    return "knock" if ends - set(UNDECIDED) else "unknown knock" if ends else ""


def _size(factor: float | None) -> float:
    """The size of a change by a factor, however far it goes either way."""
    return abs(math.log(factor or 1.0))


def _sides(draw: Draw, name: str, edge: Change | None) -> list[list[float]]:
    """The factors on a quantity that are tried, upwards and downwards, the smallest change first."""
    sides = [list(_FACTORS), [1 / factor for factor in _FACTORS]]
    if edge is not None and edge.is_near(MOST) and edge.factor:
        side = sides[edge.factor < 1]
        side[:] = [edge.factor, *(factor for factor in side if _size(factor / edge.factor) > _CLOSE)]
        side.sort(key=_size)
    if name in STATIC:
        least = _least(draw, name)
        return [[*(factor for factor in sides[1] if factor > least), *([least] if 1 / MOST < least < 1 else [])]]
    if any(name in slowest and static in draw.values for static, slowest in STATIC.items()):
        return sides[1:]  # what raises friction in motion raises that at rest, too
    if name == "half_angle":
        return [[factor for factor in side if factor * draw.values[name] <= LARGEST_HALF_ANGLE] for side in sides]
    return sides


def _between(asker: "Asker", name: str, before: float, factor: float, most: float) -> Change | None:
    """The smallest change up to a factor, from another one on that does not, that ends all, or makes it stable alone.

    Those above the size ``most`` are not looked for.
    """
    draw, keys = asker.draw, changeable(asker.draw.values)[name]
    left = asker.left(draw.scaled(keys, _printed(draw, name, factor)))
    if not left:
        bad, good = before, factor
        while abs(math.log(good / bad)) > _CLOSE * _size(good) and _size(bad) < most:
            middle = math.sqrt(good * bad)
            bad, good = (middle, good) if asker.left(draw.scaled(keys, middle)) else (bad, middle)
        factor = good
        left = asker.left(draw.scaled(keys, _printed(draw, name, factor)))
    if left == "vibrates" or _size(factor) >= most:
        return None
    factor = _printed(draw, name, factor)
    return Change(name, factor, factor * max((draw.values[key] for key in keys), key=abs), left)


def _least(draw: Draw, name: str) -> float:
    """The least factor on friction at rest, which stays above that of slow sliding; zero on another quantity."""
    if name not in STATIC:
        return 0.0
    room = 1 - sum(draw.values.get(key, 0.0) for key in STATIC[name]) / draw.values[name]
    return round(1 - _digits(max(room, 0.0), math.floor), 12)


def _printed(draw: Draw, name: str, factor: float) -> float:
    """Return a factor whose change has two digits, as it is printed, and is no smaller."""
    change = math.copysign(_digits(abs(factor - 1)), factor - 1)
    return _digits(factor) if factor >= 2 else max(round(1 + change, 12), _least(draw, name))


def _digits(size: float, towards: Callable[[float], int] = math.ceil) -> float:
    """Return a size rounded up, or down, to two digits."""
    step = 10.0 ** (math.floor(math.log10(max(size, 1e-12))) - 1)
    return float(f"{towards(size / step * (1 - 1e-9)) * step:.2g}")


class Asker:
    """Asks of changed drives what the verdict asks of the drive but for knocks, first at the point that failed last."""

    def __init__(self, draw: Draw, starter: Starter) -> None:
        self.draw, self.starter, self.level, self.failed = draw, starter, _level(draw), 0
        self.started = 0  # how many drives were

    def left(self, own: Draw) -> str:
        """What is left of vibration, as of :class:`Change`, or ``vibrates``."""
        reserves = {name: one.reserve[0] for name, one in worst(own).items()}
        steady = min(reserve for name, reserve in reserves.items() if name != "after_perturbation")
        if not steady >= 0 or _level(own) < min(_LEAST_LAW, self.level):
            return "vibrates"
        points = _points(own)
        sure = own.sheet.stiff and not own.sheet.followed and min(reserves.values()) > 0  # then slip shrinks areas
        self.started += not sure
        for k in [] if sure else sorted(range(len(points)), key=lambda k: k != self.failed):
            if (even := self.starter.evenly(points[k])) is not True:
                self.failed = k
                return "start" if even is False else "unknown"
        return ""


def _points(draw: Draw) -> list[Operation]:
    """The points of the window at which a drive is started."""
    return [Operation(draw, way, speed, force) for way, force in places(draw) for speed in speeds(draw)]


def _level(draw: Draw) -> float:
    """The least friction of a law in the window over the largest [1]; 1 without a law."""
    if not draw.sheet.friction.law:
        return 1.0
    found = draw.friction_at(np.linspace(0.0, draw.values["speed_high"], 200))[0]
    return float(found.min() / max(found.max(), 1e-300))
