"""Quantities with units as people write them: ``5 mm``, ``60 rpm``; read by pint, refused in one sentence."""

import math
import re
from functools import cache
from typing import Any

import pint

from lsvib.numbers import NotNumber, number, shown

EXAMPLES = {
    "m": "5 mm",
    "rad": "4 deg",
    "kg": "20 kg",
    "kg/m^3": "7850 kg/m^3",
    "kg m^2": "2.3e-6 kg*m^2",
    "N m/rad": "30 N*m/rad",
    "N m s/rad": "2e-4 N*m*s/rad",
    "N s/m": "100 N*s/m",
    "N": "50 N",
    "N/m": "1e6 N/m",
    "rad/s": "60 rpm",
    "m/s": "10 mm/s",
    "s/m": "-0.02 s/m",
    "": "0.15",
}
"""An example of each kind of quantity, by the unit in which the package counts it."""

_WORDS = {"m": "a length", "rad": "an angle", "kg": "a mass", "kg/m^3": "a density", "kg m^2": "a moment of inertia"}
_WORDS |= {"N m/rad": "a torsional stiffness", "N m s/rad": "a rotational damping", "N s/m": "a damping"}
_WORDS |= {"N": "a force", "N/m": "a stiffness", "rad/s": "a rotational speed", "m/s": "a speed"}
_WORDS |= {"s/m": "a slope of the friction coefficient over the sliding speed", "": "a plain number or a percentage"}
_TEXT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s(+\-][^+]*)?\s*")
_LONGEST = 40  # characters of a unit; the longest sensible one has a dozen
_LETTERS = re.compile(r"[A-Za-z_µμ°²³%*/^·() 0-9.\-]*")


class NotQuantity(ValueError):
    """A value is not a quantity of the kind that is needed; the sentence has no name yet."""


@cache
def _registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


def quantity(value: Any, *units: str) -> tuple[float, str]:
    """Return a quantity in the first of ``units`` that it fits, and that unit.

    ``value`` is text such as ``5 mm``, or a plain number where one of the units is empty. The radian counts as a
    dimension of its own where pint would drop it: an angle needs an angular unit, a number must not have one. Raises
    ``NotQuantity`` with the end of a sentence, such as ``is not a length, such as 5 mm``.
    """
    if isinstance(value, str):
        match = _TEXT.fullmatch(value)
        if not match:
            raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")
        figure, unit = number(match[1]), (match[2] or "").strip()
    else:
        try:
            figure, unit = number(value), ""
        except NotNumber:
            raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}") from None
    if not math.isfinite(figure):
        raise NotQuantity(f"= {shown(value)} is not finite")
    if not unit:
        if "" in units:
            return figure, ""
        raise NotQuantity(f"= {shown(value)} has no unit; write it with one, such as {EXAMPLES[units[0]]}")
    if unit == "%" and "" in units:
        return figure / 100, ""
    if len(unit) > _LONGEST or not _LETTERS.fullmatch(unit):
        raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")
    return _converted(figure, unit, units, value)


def _converted(figure: float, unit: str, units: tuple[str, ...], value: Any) -> tuple[float, str]:
    registry = _registry()
    try:
        given = registry.Quantity(1.0, registry.parse_units(unit.replace("·", "*").replace(" ", "*")))
    except Exception:  # pint raises many kinds, some of them of the tokenizer of Python
        raise NotQuantity(f"= {shown(value)} has the unit {shown(unit)}, which is not known") from None
    angular = any(name in str(given.to_base_units().units) + unit for name in ("rad", "deg", "turn", "rev", "rpm", "°"))
    for wanted in units:
        if wanted and given.is_compatible_with(wanted) and angular == (wanted in ("rad", "rad/s") or "/rad" in wanted):
            with_unit = registry.Quantity(figure, given.units).to(wanted)
            return float(with_unit.magnitude), wanted
    # A torsional stiffness may be written in N m, its radian being understood.
    for wanted in units:
        if "/rad" in wanted and not angular and given.is_compatible_with(wanted):
            return float(registry.Quantity(figure, given.units).to(wanted).magnitude), wanted
    raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")


def _wanted(units: tuple[str, ...]) -> str:
    words = " or ".join(_WORDS[unit] for unit in units)
    return f"{words}, such as {' or '.join(EXAMPLES[unit] for unit in units)}"
