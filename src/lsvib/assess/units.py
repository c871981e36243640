"""Quantities with units as people write them: ``5 mm``, ``60 rpm``; read by pint, refused in one sentence."""

import math
import re
from functools import cache
from typing import Any

import pint

from lsvib.numbers import NotNumber, number, shown

_KINDS = {  # of quantities, by the unit in which the package counts them, each with an example
    "m": ("a length", "5 mm"),
    "rad": ("an angle", "4 deg"),
    "kg": ("a mass", "20 kg"),
    "kg/m^3": ("a density", "7850 kg/m^3"),
    "kg m^2": ("a moment of inertia", "2.3e-6 kg*m^2"),
    "N m/rad": ("a torsional stiffness", "30 N*m/rad"),
    "N m s/rad": ("a rotational damping", "2e-4 N*m*s/rad"),
    "N s/m": ("a damping", "100 N*s/m"),
    "N": ("a force", "50 N"),
    "N/m": ("a stiffness", "1e6 N/m"),
    "rad/s": ("a rotational speed", "60 rpm"),
    "m/s": ("a speed", "10 mm/s"),
    "s/m": ("a slope of the friction coefficient over the sliding speed", "-0.02 s/m"),
    "": ("a plain number or a percentage", "0.15"),
}
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
        raise NotQuantity(f"= {shown(value)} has no unit; write it with one, such as {_KINDS[units[0]][1]}")
    if unit == "%" and "" in units:
        return _hundredth(match[1]), ""
    if len(unit) > _LONGEST or not _LETTERS.fullmatch(unit):
        raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")
    return _converted(figure, unit, units, value)


def _hundredth(digits: str) -> float:
    """A number of per cent as a double: the one that is nearest, as 0.999 for 99.9, which a division may miss."""
    mantissa, _, power = digits.lower().partition("e")
    return float(f"{mantissa}e{int(power or 0) - 2}")


def _converted(figure: float, unit: str, units: tuple[str, ...], value: Any) -> tuple[float, str]:
    registry = _registry()
    try:
        given = registry.Quantity(1.0, registry.parse_units(unit.replace("·", "*").replace(" ", "*")))
        angles = _angles(given)
    except Exception:  # pint raises many kinds, some of them of the tokenizer of Python
        raise NotQuantity(f"= {shown(value)} has the unit {shown(unit)}, which is not known") from None
    for wanted in units:
        if wanted and given.is_compatible_with(wanted) and angles == _angles(registry.Quantity(1.0, wanted)):
            with_unit = registry.Quantity(figure, given.units).to(wanted)
            return float(with_unit.magnitude), wanted
    # A torsional stiffness may be written in N m, its radian being understood.
    for wanted in units:
        if "/rad" in wanted and angles == 0 and given.is_compatible_with(wanted):
            return float(registry.Quantity(figure, given.units).to(wanted).magnitude), wanted
    raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")


def _angles(given: Any) -> int:
    """The power of the radian in a quantity: 1 of an angle and of rpm, −1 of N m/deg, 2 of a square degree."""
    return int(dict(given.to_base_units().unit_items()).get("radian", 0))


def _wanted(units: tuple[str, ...]) -> str:
    words, examples = (" or ".join(texts) for texts in zip(*(_KINDS[unit] for unit in units), strict=True))
    return f"{words}, such as {examples}"
