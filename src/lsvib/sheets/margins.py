"""How far a drive is from vibration: margins of quantities."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.drives.drive import PARTS
from lsvib.sheets.fields import LARGEST_HALF_ANGLE
from lsvib.sheets.mechanisms import NAMES
from lsvib.sheets.operation import PAIRS, Draw
from lsvib.sheets.quantities import Values
from lsvib.sheets.window import worst
from lsvib.sheets.words import QUANTITIES, Quantity

ANY = "any"
"""Stands in for a mechanism where all of them together are meant: whether steady sliding is unstable at all."""


@dataclass(frozen=True)
class Margin:
    """The nearest change of one quantity, in relation, at which a mechanism sets in or, if it occurs, vanishes.

    ``factor`` [1] is what the quantity is multiplied with, ``value`` the quantity then (the larger end of a window);
    both None if no factor from 0.001 to 1000 does it, of a flank angle none up to the largest of a sheet. Of a damping
    that is zero only the ``value`` is known, if one up to the critical damping does it.
    """

    quantity: str
    factor: float | None
    value: float | None

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
    single = {key: (key,) for key, value in values.items() if key not in paired and value != 0}
    pairs = {name: keys for name, keys in PAIRS.items() if any(values[key] != 0 for key in keys)}
    return {**single, **pairs}


def applied(draw: Draw, row: Margin) -> Draw:
    """Return a drive with a change of one quantity."""
    if row.factor is None:
        return draw.changed(**{row.quantity: row.value})
    return draw.scaled(changeable(draw.values)[row.quantity], row.factor)


def _absent_dampings(values: Values) -> dict[str, float]:
    """Return the dampings that are zero, with the size of a critical one each, √(inertia × stiffness) [SI units]."""
    turning = float(np.sqrt(values["screw_inertia"] * values["coupling_stiffness"]))
    sizes = {"support_damping": turning, "translation_damping": turning * (2 * np.pi / values["lead"]) ** 2}
    for mass, stiffness, damping in (("mass", *PARTS["threads"]), PARTS["support"]):
        if stiffness in values:
            sizes[damping] = float(np.sqrt(values[stiffness] * values[mass]))
    return {key: size for key, size in sizes.items() if values[key] == 0}


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


def margins(draw: Draw) -> dict[str, list[Margin]]:
    """Return for each mechanism, and for :data:`ANY` of them, the margin in every quantity, the smallest change first.

    A change to a drive that cannot move at all (μ ≥ cot λ) does not count.
    """
    per_decade = 30  # steps of 8 %; a narrower island of stability between two is not seen
    steps = np.linspace(0.0, 3.0, 3 * per_decade + 1)
    scans: list[tuple[str, tuple[str, ...], Draw, list[NDArray[Any]]]] = []
    for name, keys in changeable(draw.values).items():
        sides = [10.0**steps, 10.0**-steps]
        if name == "half_angle":  # beyond a right angle its tangent comes back, but there is no such thread
            most = max(LARGEST_HALF_ANGLE / draw.values[name], 1.0)
            sides[0] = np.append(sides[0][sides[0] < most], most)
        scans.append((name, keys, draw, sides))
    upwards = np.concatenate([[0.0], 10.0 ** np.linspace(-6.0, 0.0, 6 * per_decade + 1)])
    absent = _absent_dampings(draw.values)
    scans += [(name, (name,), draw.changed(**{name: size}), [upwards]) for name, size in absent.items()]
    result: dict[str, dict[str, Margin]] = {}
    edges: list[_Edge] = []
    for name, keys, base, sides in scans:
        for factors in sides:
            for mechanism, occurs in _occurs(base.scaled(keys, factors)).items():
                result.setdefault(mechanism, {})[name] = Margin(name, None, None)
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
            result[edge.mechanism][edge.quantity] = Margin(edge.quantity, known, value)
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
