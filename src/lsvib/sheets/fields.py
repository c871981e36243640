"""The entries of a data sheet: quantities with units as people write them, single, in a range or distributed.

A quantity such as ``5 mm`` is read by pint. What is not acceptable raises :class:`NotQuantity` with the end of a
sentence, to which the sheet adds the name of the entry.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, partial
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
import pint
from numpy.typing import ArrayLike, NDArray
from pydantic import BeforeValidator

from lsvib.drives.complaints import bounds_of
from lsvib.drives.drive import Drive
from lsvib.numbers import shown
from lsvib.sheets.units import plain, readings, split

_KINDS = {  # of quantities, by the unit in which the package counts them, each with an example
    "s": ("a time", "10 ms"),
    "m": ("a length", "5 mm"),
    "rad": ("an angle", "4 deg"),
    "kg": ("a mass", "20 kg"),
    "kg/m^3": ("a density", "7850 kg/m^3"),
    "Pa": ("a pressure", "5 MPa"),
    "Pa m/s": ("a pressure times a speed", "0.15 MPa*m/s"),
    "kg m^2": ("a moment of inertia", "2.3e-6 kg*m^2"),
    "N m/rad": ("a torsional stiffness", "30 N*m/rad"),
    "N m s/rad": ("a rotational damping", "2e-4 N*m*s/rad"),
    "N s/m": ("a damping", "100 N*s/m"),
    "N": ("a force", "50 N"),
    "A": ("a current", "2 A"),
    "N m/A": ("a torque constant", "0.05 N*m/A"),
    "N m": ("a torque", "3 mN*m"),
    "W": ("a power", "100 W"),
    "J": ("a work", "20 J"),
    "N/m": ("a stiffness", "1e6 N/m"),
    "Hz": ("a frequency", "50 Hz"),
    "rad/s": ("a rotational speed", "60 rpm"),
    "m/s": ("a speed", "10 mm/s"),
    "rad/s^2": ("a rotational acceleration", "100 rad/s^2"),
    "m/s^2": ("an acceleration", "2 m/s^2"),
    "s/m": ("a slope of the friction coefficient over the sliding speed", "-0.02 s/m"),
    "": ("a plain number or a percentage", "0.15"),
}
# What pint may take for ever, or for a number.
_UNIT = re.compile(r"[A-Za-zµ°%'\"_0-9*/^·(). \-]{1,40}")  # the longest sensible one has a dozen characters
_POWER = re.compile(r"(?:\^|\*\*) ?\(?[+-]?\d\)?(?![\d.^(]| ?\*\*)")
_SEPARATED = re.compile(r"[+-]?\d+(?:,\d|[ ']\d{3}(?!\d))")  # a comma is a point to some, and nothing to others
_PER_TURN = re.compile(r"/ ?(?:rev|turn|rot|tr|u|r)\.?$", re.IGNORECASE)  # of a lead


class NotQuantity(ValueError):
    """A value is not a quantity of the kind that is needed; the sentence has no name yet."""


_registry: Callable[[], "pint.UnitRegistry[Any]"] = cache(pint.UnitRegistry)


def quantity(value: Any, *units: str) -> tuple[float, str]:
    """Return a quantity in the first of ``units`` that it fits, and that unit.

    ``value`` is text such as ``5 mm``, or a plain number where one of the units is empty. The radian counts as a
    dimension of its own where pint would drop it: an angle needs an angular unit, a number must not have one. A lead,
    ``m/turn``, comes back in m. Raises ``NotQuantity`` with the end of a sentence, such as ``is not a length``.
    """
    text = plain(str(value))
    if units[0] == "m/turn":
        units, text = ("m",), _PER_TURN.sub("", text)
    if _SEPARATED.match(text):
        ways = [text.replace(",", ".", 1), re.sub(r"(?<=\d)[, '](?=\d{3})", "", text)]
        taken = " or ".join(way for way in ways if way != text and _is_taken(way, units))
        raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}{taken and f'; write {taken}'}")
    if units == ("",) and (ratio := re.fullmatch(r"(\d+(?:\.\d+)?) ?: ?1", text)):
        text = ratio[1]
    if not (found := split(text)):
        raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")
    figure, unit = float(found[0]), found[1]
    if not math.isfinite(figure):
        raise NotQuantity(f"= {shown(value)} is not finite")
    if not unit:
        if "" in units:
            return figure, ""
        raise NotQuantity(f"= {shown(value)} has no unit; write it with one, such as {_KINDS[units[0]][1]}")
    if unit == "%" and "" in units:
        return float(Decimal(found[0]).scaleb(-2)), ""  # 0.999 for 99.9 %, which a division would miss
    if not _UNIT.fullmatch(unit) or re.search(r"\^|\*\*", _POWER.sub("", unit)):
        raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")
    return _converted(figure, unit, units, value)


def _is_taken(text: str, units: tuple[str, ...]) -> bool:
    try:
        return bool(quantity(text, *units))
    except NotQuantity:
        return False


def _converted(figure: float, unit: str, units: tuple[str, ...], value: Any) -> tuple[float, str]:
    registry, several, known = _registry(), readings(unit), False
    found: dict[str, tuple[float, str, str]] = {}
    for text in several:
        try:
            given = registry.Quantity(figure, registry.parse_units(text))
            angles, known = _angles(given), True
        except Exception:  # pint raises many kinds, some of them of the tokenizer of Python
            continue
        for wanted in filter(given.is_compatible_with, filter(None, units)):
            # A torsional stiffness may be written in N m, its radian being understood.
            if angles == _angles(registry.Quantity(1.0, wanted)) or (angles == 0 and "/rad" in wanted):
                size = float(given.to(wanted).magnitude)
                found.setdefault(f"{size:.9g} {wanted}", (size, wanted, text.replace("**", "^")))
    if len(found) > 1:
        *names, last = (text for _, _, text in found.values())
        raise NotQuantity(f"= {shown(value)} has an ambiguous unit; write {', '.join(names)} or {last}")
    if not known:
        examples = " or ".join(_KINDS[wanted][1] for wanted in units)
        raise NotQuantity(f"= {shown(value)} has the unit {shown(unit)}, which is not known; {examples} would do")
    for size, wanted, text in found.values():
        if wanted == "N" and text in ("kgf", "gf") and len(several) > 1:
            raise NotQuantity(f"= {shown(value)} is a mass; as a force write {figure:g} {text}")
        return size, wanted
    raise NotQuantity(f"= {shown(value)} is not {_wanted(units)}")


def _angles(given: Any) -> int:
    """The power of the radian in a quantity: 1 of an angle and of rpm, −1 of N m/deg, 2 of a square degree."""
    return int(dict(given.to_base_units().unit_items()).get("radian", 0))


def _wanted(units: tuple[str, ...]) -> str:
    words, examples = (" or ".join(texts) for texts in zip(*(_KINDS[unit] for unit in units), strict=True))
    return f"{words}, such as {examples}"


_TOLERANCE = re.compile(r"(.+?) ?(?:±|\+ ?/? ?-) ?(.+)")  # 5 Nm ± 10 %, 5 ± 0.2 Nm
_FORMS = {
    "uniform": ("low", "high"),
    "triangular": ("low", "mode", "high"),
    "normal": ("mean", "std"),
    "lognormal": ("median", "factor"),
}
Allowed = Mapping[str, tuple[float, float]]  # the range of a quantity in each unit that it may have
TAIL = 4.0  # standard deviations at which a normal distribution is cut off: 6e-5 of it lie beyond


@dataclass(frozen=True)
class Spread:
    """A quantity in the unit ``unit`` of the package: ``kind`` is value or a name of a distribution.

    ``numbers`` are its parameters, in the order of low, high (uniform), low, mode, high (triangular), mean, standard
    deviation (normal), median, factor of one standard deviation (lognormal); ``low`` and ``high`` its ends, of the last
    two :data:`TAIL` standard deviations off. ``text``: as it was written.
    """

    kind: str
    numbers: tuple[float, ...]
    unit: str
    low: float
    high: float
    text: str

    @classmethod
    def of(cls, value: Any, allowed: Allowed, above: bool = False) -> Self:
        """Return what a data sheet says of one quantity, in the first unit of those ``allowed`` that fits.

        ``value``: a quantity, a list of two (a range), or a mapping with ``low`` and ``high``; ``low``, ``mode`` and
        ``high``; ``mean`` and ``std``; ``median`` and ``factor``. ``above``: the lower end of the allowed range is not
        part of it. Raises ``NotQuantity``.
        """
        check = partial(_check, allowed=allowed, above=above)
        if isinstance(value, cls):
            return value
        if isinstance(value, list):
            if len(value) != 2:
                raise NotQuantity(f"= {shown(value)} is not a range of two quantities, such as [a, b]")
            value = {"low": value[0], "high": value[1]}
        if isinstance(value, str) and (found := _within_tolerance(value, allowed)):
            figures, unit = found
            return cls("uniform", tuple(figures), unit, *_ends("uniform", figures, unit, check), value.strip())
        if not isinstance(value, Mapping):
            figure, unit = quantity(value, *allowed)
            check(figure, unit)
            return cls("value", (figure,), unit, figure, figure, _plain(value))
        kind = next((kind for kind, keys in _FORMS.items() if set(keys) == set(map(str, value))), None)
        if kind is None:
            raise NotQuantity(
                f"has the keys {', '.join(map(str, value)) or 'none'}; "
                "a distribution has low and high, low, mode and high, mean and std, or median and factor"
            )
        figures, kinds = [], []
        for key in _FORMS[kind]:
            try:
                figure, unit = quantity(value[key], *(("",) if key == "factor" else allowed))
            except NotQuantity as error:
                raise NotQuantity(f"({key}) {error}") from None
            figures.append(figure)
            kinds += [unit] if key != "factor" else []
        unit = kinds[0]
        if len(set(kinds)) > 1:
            raise NotQuantity("mixes two kinds of quantity in one distribution")
        text = ", ".join(f"{key} {_plain(value[key])}" for key in _FORMS[kind])
        low, high = _ends(kind, figures, unit, check)
        return cls(kind, tuple(figures), unit, low, high, text)

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
        from scipy.special import ndtr, ndtri  # type: ignore[import-untyped]  # of these alone, as it takes long

        score, (middle, width) = ndtri(ndtr(-TAIL) + share * (ndtr(TAIL) - ndtr(-TAIL))), self.numbers
        values = middle + width * score if self.kind == "normal" else middle * width**score
        return np.asarray(np.clip(values, self.low, self.high))


def _within_tolerance(value: str, units: Allowed) -> tuple[list[float], str] | None:
    """Read 5 Nm ± 10 %, 5 ± 0.2 Nm or 5 mm ± 0.1 as a range; a share of a percentage might be meant either way."""
    if not (match := _TOLERANCE.fullmatch(plain(value))):
        return None
    (figure, unit), (width, own) = (split(part) or ("", "") for part in match.groups())
    if not figure or not width or unit == own == "%":
        raise NotQuantity(
            f"= {shown(value)} is not a quantity with a tolerance, such as 5 Nm ± 10 %; write [low, high]"
        )
    unit = unit or own.removesuffix("%")
    middle, si = quantity(f"{figure} {unit}".strip(), *units)
    off = abs(middle) * float(width) / 100 if own == "%" else quantity(f"{width} {own or unit}".strip(), *units)[0]
    return [middle - off, middle + off], si


def _ends(kind: str, figures: list[float], unit: str, check: Callable[[float, str], None]) -> tuple[float, float]:
    """Where a distribution begins and ends; all of its parameters checked."""
    if kind in ("uniform", "triangular"):
        if figures != sorted(figures) or figures[0] == figures[-1]:
            raise NotQuantity(f"has {' and '.join(_FORMS[kind])} that are not in ascending order")
        for figure in figures:
            check(figure, unit)
        return figures[0], figures[-1]
    middle, width = figures
    check(middle, unit)
    if not width > (0 if kind == "normal" else 1):
        raise NotQuantity(f"has {_FORMS[kind][1]} = {width:g}, which is not above {0 if kind == 'normal' else 1}")
    normal = (middle - TAIL * width, middle + TAIL * width)
    low, high = normal if kind == "normal" else (middle / width**TAIL, middle * width**TAIL)
    for end in (low, high):
        try:
            check(end, unit)
        except NotQuantity as error:
            value, _, rest = str(error).removeprefix("= ").partition(" is")
            raise NotQuantity(f"reaches {value} at four standard deviations, which is{rest}") from None
    return low, high


def _plain(value: Any) -> str:
    return value.strip() if isinstance(value, str) else shown(value)


def _check(figure: float, unit: str, allowed: Allowed, above: bool) -> None:
    """Raise ``NotQuantity`` unless a figure in this unit is in its range."""
    low, high = allowed[unit]
    if (figure > low or (figure == low and not above)) and figure <= high:
        return
    name, factor = {"rad": ("deg", 180 / math.pi), "rad/s": ("rpm", 30 / math.pi)}.get(unit, (unit, 1.0))
    value, least, most = (f"{factor * x:.6g} {name}".rstrip() for x in (figure, low, high))
    raise NotQuantity(f"= {value} is outside the allowed range {least} {'<' if above else '<='} value <= {most}")


def _field(unit: str, low: float, high: float) -> Any:
    """A quantity, with its range beside it."""
    allowed = dict.fromkeys((unit, unit.removesuffix("/turn")), (low, high))
    return Annotated[Spread, BeforeValidator(lambda value: Spread.of(value, allowed)), tuple(allowed.items())[-1:]]


def _positive(highest: Mapping[str, float]) -> Any:
    """A quantity above zero, in one of some units, each with its largest value."""
    allowed = {unit: (0.0, high) for unit, high in highest.items()}
    return Annotated[Spread, BeforeValidator(lambda value: Spread.of(value, allowed, True)), tuple(allowed.items())]


def _least(key: str) -> float:
    """The least value of a parameter of the package."""
    return bounds_of(Drive, key)["ge"]


LARGEST_HALF_ANGLE = math.radians(60)
# The ranges are those of the drives of the package, or narrower where no screw of metal reaches.
Length = _field("m", 1e-6, 100.0)
Diameter = _field("m", 1e-5, 1.0)
Lead = _field("m/turn", 1e-5, 10.0)
LeadAngle = _field("rad", _least("lead_angle"), math.radians(80))
HalfAngle = _field("rad", 0.0, LARGEST_HALF_ANGLE)
Mass = _field("kg", _least("mass"), 1e9)
Density = _positive({"kg/m^3": 3e4})
Pressure = _field("Pa", 1.0, 1e12)
PressureSpeed = _field("Pa m/s", 1.0, 1e15)
Inertia = _field("kg m^2", _least("screw_inertia"), 1e6)
MoreInertia = _field("kg m^2", 0.0, 1e6)
Torsion = _field("N m/rad", _least("coupling_stiffness"), 1e12)
TurningDamping = _field("N m s/rad", 0.0, 1e12)
LinearDamping = _field("N s/m", 0.0, 1e15)
Stiffness = _field("N/m", _least("contact_stiffness"), 1e15)
Force = _field("N", -1e10, 1e10)
Rubbing = _field("N", 0.0, 1e10)
Torque = _field("N m", -1e9, 1e9)
Drag = _field("N m", 0.0, 1e9)
Speed = _positive({"rad/s": 1e6, "m/s": 1e3})
Acceleration = _positive({"rad/s^2": 1e9, "m/s^2": 1e6})
Bandwidth = _field("Hz", 0.01, 1e5)
Duration = _positive({"s": 1e3})
Pause = _field("s", 0.0, 1e6)
Holding = _positive({"N m": 1e9})
TorqueConstant = _positive({"N m/A": 1e6})
Counts = _positive({"": 1e9})
Ratio = _positive({"": 1e4})
Coefficient = _field("", 0.0, 3.0)
Efficiency = _field("", 0.001, 1.0)
Share = _field("", 0.0, 1.0)
GearEfficiency = _field("", 0.01, 1.0)
Slope = _field("s/m", -1e3, 1e3)
SlidingSpeed = _positive({"m/s": 1e4})
TorqueCurve = Annotated[tuple[tuple[float, float], ...], BeforeValidator(lambda value: _torque_curve(value))]


def _tilt(value: Any) -> Spread:
    named = {"horizontal": 0.0, "vertical": math.pi / 2}
    if isinstance(value, str) and (angle := named.get(value.strip().lower())) is not None:
        return Spread("value", (angle,), "rad", angle, angle, value)
    try:
        return Spread.of(value, {"rad": (-math.pi / 2, math.pi / 2)})
    except NotQuantity as error:
        if isinstance(value, str) and "is not an angle" in str(error):
            raise NotQuantity(f"{error}, horizontal or vertical") from None
        raise


# Of the axis above the horizontal; outward is upward.
Tilt = Annotated[Spread, BeforeValidator(_tilt), (("rad", (-math.pi / 2, math.pi / 2)),)]


def _pairs(value: Any, words: str, *units: str) -> tuple[tuple[float, float], ...]:
    """Return pairs of quantities in two units; raises ``NotQuantity``."""
    if not (isinstance(value, list) and value and all(isinstance(row, list) and len(row) == 2 for row in value)):
        raise NotQuantity(f"is not a list of pairs [{words}]")
    return tuple((quantity(one, units[0])[0], quantity(other, units[1])[0]) for one, other in value)


def _torque_curve(value: Any) -> tuple[tuple[float, float], ...]:
    """Return pairs of the motor's speed [rad/s], ascending, and its torque there [N m]; raises ``NotQuantity``."""
    pairs = _pairs(value, "speed, torque", "rad/s", "N m")
    if len(pairs) < 2 or pairs[0][0] < 0 or any(after[0] <= before[0] for before, after in pairwise(pairs)):
        raise NotQuantity("needs two points or more, with speeds that ascend from 0 rpm or above")
    if not 0 <= min(torque for _, torque in pairs) <= max(torque for _, torque in pairs) <= 1e9:
        raise NotQuantity("has a torque outside the allowed range 0 N m <= value <= 1e9 N m")
    return pairs


def friction_curve(value: Any) -> tuple[tuple[float, float], ...]:
    """Return pairs of sliding speed [m/s], ascending, and friction coefficient [1]; raises ``NotQuantity``."""
    pairs = _pairs(value, "sliding speed, coefficient", "m/s", "")
    speeds, coefficients = zip(*pairs, strict=True)
    if not 1e-6 <= speeds[0] <= speeds[-1] <= 1e4 or any(after <= before for before, after in pairwise(speeds)):
        raise NotQuantity(
            "has sliding speeds that do not ascend between 1e-6 m/s and 1e4 m/s; give static friction as static"
        )
    if not 1e-4 <= min(coefficients) <= max(coefficients) <= 3:
        raise NotQuantity("has a coefficient outside the allowed range 1e-4 <= value <= 3")
    return pairs
