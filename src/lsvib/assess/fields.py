"""The types of the entries of a data sheet: quantities with units and allowed ranges."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

from pydantic import BeforeValidator

from lsvib.assess.fields import NotQuantity, Spread, ThreadSize, quantity, spread, thread_size
from lsvib.models.drive import Drive, ThreadsDrive

_READABLE = {"rad": ("deg", 180 / math.pi), "rad/s": ("rpm", 30 / math.pi)}  # units for the eye, and how many make one


@dataclass(frozen=True)
class Allowed:
    """The range of a quantity in its unit; ``open_low``: the lower end is not part of it."""

    low: float
    high: float
    open_low: bool = False

    def problem(self, figure: float, unit: str) -> str | None:
        """Return the end of a sentence about a figure outside the range, or None."""
        if (figure > self.low or (figure == self.low and not self.open_low)) and figure <= self.high:
            return None
        name, factor = _READABLE.get(unit, (unit, 1.0))
        value, low, high = (f"{factor * x:.6g} {name}".rstrip() for x in (figure, self.low, self.high))
        return f"= {value} is outside the allowed range {low} {'<' if self.open_low else '<='} value <= {high}"


def _field(*units: str, allowed: dict[str, Allowed]) -> Any:
    def check(figure: float, unit: str) -> str | None:
        return allowed[unit].problem(figure, unit)

    return Annotated[Spread, BeforeValidator(lambda value: spread(value, *units, check=check))]


def _positive(high: float) -> Allowed:
    return Allowed(0.0, high, open_low=True)


def _from_least(key: str, high: float, kind: type[Drive] = Drive) -> Allowed:
    """From the least value of a parameter of the package."""
    return Allowed(kind.model_json_schema()["properties"][key]["minimum"], high)


# The ranges are those of the drives of the package, or narrower where no screw of metal reaches.
Length = _field("m", allowed={"m": _positive(100.0)})
LeadAngle = _field("rad", allowed={"rad": _from_least("lead_angle", math.radians(80))})
LARGEST_HALF_ANGLE = math.radians(60)
HalfAngle = _field("rad", allowed={"rad": Allowed(0.0, LARGEST_HALF_ANGLE)})
Mass = _field("kg", allowed={"kg": _from_least("mass", 1e9)})
Density = _field("kg/m^3", allowed={"kg/m^3": _positive(3e4)})
Inertia = _field("kg m^2", allowed={"kg m^2": _from_least("screw_inertia", 1e6)})
MoreInertia = _field("kg m^2", allowed={"kg m^2": Allowed(0.0, 1e6)})
Torsion = _field("N m/rad", allowed={"N m/rad": _from_least("coupling_stiffness", 1e12)})
TurningDamping = _field("N m s/rad", allowed={"N m s/rad": Allowed(0.0, 1e12)})
LinearDamping = _field("N s/m", allowed={"N s/m": Allowed(0.0, 1e15)})
Stiffness = _field("N/m", allowed={"N/m": _from_least("contact_stiffness", 1e15, ThreadsDrive)})
Force = _field("N", allowed={"N": Allowed(-1e10, 1e10)})
Speed = _field("rad/s", "m/s", allowed={"rad/s": _positive(1e6), "m/s": _positive(1e4)})
Ratio = _field("", allowed={"": _positive(1e4)})
Coefficient = _field("", allowed={"": Allowed(0.0, 3.0)})
Efficiency = _field("", allowed={"": Allowed(0.001, 0.999)})
Slope = _field("s/m", allowed={"s/m": Allowed(-1e3, 1e3)})
CurveFactor = _field("", allowed={"": _positive(10.0)})

_TILT = Allowed(-math.pi / 2, math.pi / 2)
_TILTS = {"horizontal": 0.0, "vertical": math.pi / 2}


def _tilt(value: Any) -> Spread:
    if isinstance(value, str) and value in _TILTS:
        return Spread("value", (_TILTS[value],), "rad", _TILTS[value], _TILTS[value], value)
    try:
        return spread(value, "rad", check=_TILT.problem)
    except NotQuantity as error:
        if isinstance(value, str) and "is not an angle" in str(error):
            raise NotQuantity(f"{error}, horizontal or vertical") from None
        raise


Tilt = Annotated[Spread, BeforeValidator(_tilt)]  # of the axis above the horizontal; outward is upward


Size = Annotated[ThreadSize, BeforeValidator(thread_size)]


@dataclass(frozen=True)
class FrictionBySpeed:
    """Friction coefficient [1] over the sliding speed [m/s], straight lines between points (k) in ascending order."""

    speeds: tuple[float, ...]
    coefficients: tuple[float, ...]


def _curve(value: Any) -> FrictionBySpeed:
    if (
        not isinstance(value, list)
        or len(value) < 2
        or not all(isinstance(row, list) and len(row) == 2 for row in value)
    ):
        raise NotQuantity("is not a list of at least two pairs [sliding speed, coefficient]")
    speeds = [quantity(row[0], "m/s")[0] for row in value]
    coefficients = [quantity(row[1], "")[0] for row in value]
    if any(b <= a for a, b in pairwise(speeds)) or speeds[0] < 0:
        raise NotQuantity("has sliding speeds that do not ascend from zero or above")
    if min(coefficients) < 0 or max(coefficients) > 3:
        raise NotQuantity("has a coefficient outside the allowed range 0 <= value <= 3")
    return FrictionBySpeed(tuple(speeds), tuple(coefficients))


FrictionCurve = Annotated[FrictionBySpeed, BeforeValidator(_curve)]
