"""Grids of starts in two coordinates of a drive's state."""

import math
import sys
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple, Self

import numpy as np

from lsvib import numbers
from lsvib.errors import InputError
from lsvib.models.drive import names_and_values
from lsvib.models.model import all_models

MOST_CELLS = 100_000_000  # of a map or chart at once; each takes some hundred bytes while it is computed


@cache
def coordinates() -> dict[str, str]:
    """Return the names that the coordinates of states have in automata and datasets, of all models, by their keys."""
    return {
        key: state
        for model in all_models().values()
        for key, state in zip((*model.required, *model.optional), model.states, strict=True)
    }


class Axis(NamedTuple):
    """Cells of equal width along a coordinate: u [rad], w [rad/s], with compliant threads e [m] and v [m/s]."""

    coordinate: str
    start: float
    stop: float
    count: int  # type: ignore[assignment]  # it hides tuple.count, which nobody calls

    def centres(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """Return the middles of cells ``first`` to ``last`` (excluded); each from its own index, whatever the range."""
        return self.middles(np.arange(first, self.count if last is None else last))

    def middles(self, index: np.ndarray) -> np.ndarray:
        """Return the middles of the cells of these indices."""
        return self.start + (index + 0.5) * ((self.stop - self.start) / self.count)

    @property
    def width(self) -> float:
        """Width of a cell."""
        return (self.stop - self.start) / self.count

    @classmethod
    def checked(cls, coordinate: str, start: Any, stop: Any, count: Any) -> Self:
        """Make an axis from numbers or text; ``InputError`` if it is none or has cells that coincide."""
        if coordinate not in coordinates():
            raise InputError(f"axis {coordinate!r} is not a coordinate of a state: {', '.join(coordinates())}.")
        return cls.over(coordinate, start, stop, count)

    @classmethod
    def over(cls, coordinate: str, start: Any, stop: Any, count: Any) -> Self:
        """Make an axis as :meth:`checked`, over whatever bears the name."""
        start, stop = (numbers.start(f"axis {coordinate}: {name}", x) for name, x in (("start", start), ("stop", stop)))
        if not start < stop:
            raise InputError(f"axis {coordinate} has start = {start:g} and stop = {stop:g}; it needs start < stop.")
        most = 10_000_000
        try:
            cells = numbers.whole(count)
        except numbers.NotNumber as error:
            raise InputError(
                f"axis {coordinate} has count = {count if isinstance(count, str) else numbers.shown(count)}, which "
                f"{error}; the allowed range is 1 <= count <= {most}."
            ) from None
        if not 1 <= cells <= most:
            raise InputError(f"axis {coordinate} has count = {cells}; the allowed range is 1 <= count <= {most}.")
        # A middle is rounded three times, each time by at most one unit in the last place of the larger end; and the
        # width itself needs all its digits, which doubles below the smallest normal one have not.
        if not (stop - start) / cells >= max(4 * math.ulp(max(abs(start), abs(stop))), sys.float_info.min):
            raise InputError(
                f"axis {coordinate} has {cells} cells between start = {start:.17g} and stop = {stop:.17g}, too narrow "
                "to be distinguished in double precision; take fewer cells or a longer axis."
            )
        return cls(coordinate, start, stop, cells)


class Grid(NamedTuple):
    """Starts in two coordinates, ``x`` along columns and ``y`` along rows; ``fixed`` are the values of the others."""

    x: Axis
    y: Axis
    fixed: Mapping[str, float] = {}

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a grid from ``{coordinate: {start, stop, count}}`` twice and ``{coordinate: value}``, as YAML has it.

        Of the two axes, the one that comes first in a state is horizontal, whichever is written first. Raises
        ``InputError``.
        """
        for name in names_and_values("grid", values):
            if name not in coordinates():
                raise InputError(f"grid has the coordinate {name!r}, which is not one of {', '.join(coordinates())}.")
        spans = [name for name in coordinates() if isinstance(values.get(name), Mapping)]
        if len(spans) != 2:
            raise InputError(f"grid spans {len(spans)} coordinates; give start, stop and count of two.")
        for name in spans:
            if set(values[name]) != {"start", "stop", "count"}:
                raise InputError(
                    f"axis {name} has the keys {', '.join(map(str, values[name]))}; it needs start, stop and count."
                )
        x, y = (Axis.checked(name, **values[name]) for name in spans)
        return cls(x, y, {name: numbers.start(f"grid: {name}", values[name]) for name in values if name not in spans})
