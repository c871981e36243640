"""Grids of starts in two coordinates of a state."""

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from lsvib import numbers
from lsvib.errors import InputError

MOST_CELLS = 100_000_000  # of a map at once; each takes some hundred bytes while it is computed


@dataclass(frozen=True)
class Axis:
    """An axis of a :class:`Grid`: ``count`` cells of equal width (stop − start) / count along a coordinate [SI unit].

    Numbers may be given as text. Raises ``InputError`` for what is not a number, or if cells coincide in doubles.

    >>> lsvib.Axis("w", -80, 80, 4).centres()
    array([-60., -20.,  20.,  60.])
    """

    coordinate: str
    start: float
    stop: float
    count: int

    def __post_init__(self) -> None:
        for name in ("start", "stop"):
            object.__setattr__(self, name, numbers.start(f"axis {self.coordinate}: {name}", getattr(self, name)))
        if not self.start < self.stop:
            raise InputError(
                f"axis {self.coordinate} has start = {self.start:g} and stop = {self.stop:g}; it needs start < stop."
            )
        count = numbers.whole_between(f"axis {self.coordinate}: count", self.count, 1, 10_000_000)
        object.__setattr__(self, "count", count)
        # A middle is rounded three times, each time by at most one unit in the last place of the larger end; and the
        # width itself needs all its digits, which doubles below the smallest normal one have not.
        if not self.width >= max(4 * math.ulp(max(abs(self.start), abs(self.stop))), sys.float_info.min):
            raise InputError(
                f"axis {self.coordinate} has {self.count} cells between start = {self.start:.17g} and stop = "
                f"{self.stop:.17g}, too narrow to be distinguished in double precision; take fewer cells or a longer "
                "axis."
            )

    def centres(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """Return the centres (last − first) of cells ``first`` to ``last`` (excluded) [SI unit]; by default of all."""
        return self.start + (np.arange(first, self.count if last is None else last) + 0.5) * self.width

    @property
    def width(self) -> float:
        """Width of a cell [SI unit]."""
        return (self.stop - self.start) / self.count


@dataclass(frozen=True)
class Grid:
    """Starts in two coordinates, ``x`` along columns and ``y`` along rows; ``fixed``: values [SI units] of others.

    Raises ``InputError`` if they are not two axes of different coordinates. See also :meth:`lsvib.Drive.attraction`.

    >>> grid = lsvib.Grid(lsvib.Axis("u", -0.1, 0.1, 40), lsvib.Axis("w", -80, 80, 30))
    >>> grid.x.centres()[:2], grid.y.width  # motions start from the centres of cells
    (array([-0.0975, -0.0925]), 5.333333333333333)
    """

    x: Axis
    y: Axis
    fixed: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (isinstance(self.x, Axis) and isinstance(self.y, Axis)):
            raise InputError("a grid needs two axes, lsvib.Axis(coordinate, start, stop, count) each.")
        names = [self.x.coordinate, self.y.coordinate, *numbers.names_and_values("grid", self.fixed)]
        if len(set(names)) < len(names):
            raise InputError(f"the grid gives a coordinate twice: {', '.join(map(str, names))}.")
        values = {name: numbers.start(f"grid: {name}", value) for name, value in self.fixed.items()}
        object.__setattr__(self, "fixed", values)

    @classmethod
    def of(cls, values: Mapping[str, Any], names: Sequence[str]) -> Self:
        """Make a grid from two ``{coordinate: {start, stop, count}}``, as in YAML, and ``{coordinate: value}``.

        A span may also be (start, stop, count). The axis that comes first in ``names`` is ``x``. Raises ``InputError``.
        """
        values = numbers.names_and_values("grid", values)
        for name, span in values.items():
            if isinstance(span, tuple | list):
                if len(span) != 3:
                    raise InputError(f"axis {name} has {len(span)} numbers; it needs start, stop and count.")
                values[name] = dict(zip(("start", "stop", "count"), span, strict=True))
        known = [*names, *values]  # what is no coordinate comes last
        spans = [name for name in dict.fromkeys(known) if isinstance(values.get(name), Mapping)]
        if len(spans) != 2:
            raise InputError(f"grid needs start, stop and count of two coordinates; {len(spans)} given.")
        for name in spans:
            if set(values[name]) != {"start", "stop", "count"}:
                raise InputError(
                    f"axis {name} has the keys {', '.join(map(str, values[name]))}; it needs start, stop and count."
                )
        x, y = (Axis(name, **values[name]) for name in spans)
        return cls(x, y, {name: values[name] for name in values if name not in spans})
