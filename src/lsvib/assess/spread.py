"""A quantity that is one value, lies in a range, or follows a distribution."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr, ndtri

from lsvib.assess.fields import NotQuantity, quantity
from lsvib.numbers import shown

_TAIL = 4.0  # standard deviations at which a normal distribution is cut off: 6e-5 of it lie beyond
_FORMS = {
    "uniform": ("low", "high"),
    "triangular": ("low", "mode", "high"),
    "normal": ("mean", "std"),
    "lognormal": ("median", "factor"),
}
_HINT = "low and high, low, mode and high, mean and std, or median and factor"


@dataclass(frozen=True)
class Spread:
    """A quantity in the unit ``unit`` of the package: ``kind`` is value or a name of a distribution.

    ``numbers`` are its parameters, in the order of low, high (uniform), low, mode, high (triangular), mean, standard
    deviation (normal), median, factor of one standard deviation (lognormal); ``low`` and ``high`` its ends, where the
    last two are cut off at four standard deviations and at the ends of the allowed range. ``text``: as it was written.
    """

    kind: str
    numbers: tuple[float, ...]
    unit: str
    low: float
    high: float
    text: str

    @property
    def uncertain(self) -> bool:
        """Whether it is more than one value."""
        return self.low < self.high

    @property
    def nominal(self) -> float:
        """The value in the middle: the value itself, the middle of a range, the mode, the mean or the median."""
        if self.kind == "uniform":
            return 0.5 * (self.low + self.high)
        return self.numbers[1] if self.kind == "triangular" else self.numbers[0]

    def quantile(self, share: ArrayLike) -> NDArray[np.float64]:
        """Return the values (n) below which the shares (n) [1] of the distribution lie."""
        share = np.asarray(share, dtype=float)
        if not self.uncertain:
            return np.full(share.shape, self.nominal)
        if self.kind == "uniform":
            return self.low + share * (self.high - self.low)
        if self.kind == "triangular":
            low, mode, high = self.numbers
            rising = low + np.sqrt(share * (high - low) * (mode - low))
            falling = high - np.sqrt((1 - share) * (high - low) * (high - mode))
            return np.where(share * (high - low) < mode - low, rising, falling)
        below, above = ndtr(self._score(self.low)), ndtr(self._score(self.high))
        score = ndtri(below + share * (above - below))
        middle, width = self.numbers
        values = middle + width * score if self.kind == "normal" else middle * width**score
        return np.clip(values, self.low, self.high)

    def _score(self, value: float) -> float:
        middle, width = self.numbers
        return (value - middle) / width if self.kind == "normal" else float(np.log(value / middle) / np.log(width))


def spread(value: Any, *units: str, check: Callable[[float, str], str | None]) -> Spread:
    """Return what a data sheet says of one quantity, in the first of ``units`` that fits.

    ``value``: a quantity, a list of two (a range), or a mapping with ``low`` and ``high``; ``low``, ``mode`` and
    ``high``; ``mean`` and ``std``; ``median`` and ``factor``. ``check(figure, unit)`` returns what is wrong with a
    figure, or None. Raises ``NotQuantity`` with the end of a sentence.
    """
    if isinstance(value, list):
        if len(value) != 2:
            raise NotQuantity(f"= {shown(value)} is not a range of two quantities, such as [a, b]")
        value = {"low": value[0], "high": value[1]}
    if not isinstance(value, Mapping):
        figure, unit = quantity(value, *units)
        _require(check(figure, unit))
        return Spread("value", (figure,), unit, figure, figure, _plain(value))
    kind = next((kind for kind, keys in _FORMS.items() if set(keys) == set(map(str, value))), None)
    if kind is None:
        raise NotQuantity(f"has the keys {', '.join(map(str, value)) or 'none'}; a distribution has {_HINT}")
    figures, found = [], []
    for key in _FORMS[kind]:
        wanted = ("",) if key == "factor" else units
        try:
            figure, unit = quantity(value[key], *wanted)
        except NotQuantity as error:
            raise NotQuantity(f"has {key} {error}") from None
        figures.append(figure)
        found.append(unit)
    unit = found[0]
    if any(other != unit for key, other in zip(_FORMS[kind], found, strict=True) if key != "factor"):
        raise NotQuantity("mixes two kinds of quantity in one distribution")
    text = ", ".join(f"{key} {_plain(value[key])}" for key in _FORMS[kind])
    low, high = _ends(kind, figures, unit, check)
    return Spread(kind, tuple(figures), unit, low, high, text)


def _ends(kind: str, figures: list[float], unit: str, check: Callable[[float, str], str | None]) -> tuple[float, float]:
    """Where a distribution begins and ends; all of its parameters checked."""
    if kind in ("uniform", "triangular"):
        if figures != sorted(figures) or figures[0] == figures[-1]:
            raise NotQuantity(f"has {' and '.join(_FORMS[kind])} that do not ascend")
        for figure in figures:
            _require(check(figure, unit))
        return figures[0], figures[-1]
    middle, width = figures
    _require(check(middle, unit))
    if not width > (0 if kind == "normal" else 1):
        raise NotQuantity(f"has {_FORMS[kind][1]} = {width:g}, which is not above {0 if kind == 'normal' else 1}")
    low, high = (
        (middle - _TAIL * width, middle + _TAIL * width)
        if kind == "normal"
        else tuple(sorted((middle / width**_TAIL, middle * width**_TAIL)))
    )
    for end in (low, high):
        problem = check(end, unit)
        if problem:
            value, _, rest = problem.removeprefix("= ").partition(" is")
            raise NotQuantity(f"reaches {value} at four standard deviations, which is{rest}")
    return low, high


def _require(problem: str | None) -> None:
    if problem:
        raise NotQuantity(problem)


def _plain(value: Any) -> str:
    return value.strip() if isinstance(value, str) else shown(value)
