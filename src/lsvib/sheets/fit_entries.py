"""What the sheet of a measurement holds: thread, load, what is known, and columns of tables with their units."""

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from itertools import chain
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationError

from lsvib.drives.complaints import sentence_about
from lsvib.errors import InputError
from lsvib.numbers import number, shown, whole
from lsvib.sheets import fields
from lsvib.sheets.drive_entries import Part
from lsvib.sheets.fields import NotQuantity, Spread
from lsvib.sheets.sheet import NO_DIAMETER, Load, Thread

_TURNED = ("rad", "m", "counts")
_SHARES = {"%": 1e-2, "‰": 1e-3, "permille": 1e-3}
_COUNTS = re.compile(r"counts?|cts|inc(?:rement)?s?|qc|ticks?|pulses?|steps?", re.IGNORECASE)


def _factor(value: Any) -> float:
    found = number(value)
    if not (math.isfinite(found) and found):
        raise NotQuantity(f"= {shown(value)} is outside the allowed range: any finite number but 0")
    return found


def _column(value: Any) -> int:
    found = whole(value)
    if found < 1:
        raise NotQuantity(f"= {found} is outside the allowed range 1 <= column")
    return found


def _separator(value: Any) -> str:
    if value == "tab":
        return "\t"
    if not isinstance(value, str) or not re.fullmatch(r"[^\w\".+\-\r\n]", value):
        raise NotQuantity(f"= {shown(value)} is not one separator, such as a comma, a semicolon or a tab")
    return value


_Unit = tuple[float, str]  # the size of a unit in one of the package, and that


def _unit(value: Any, *units: str, instead: tuple[str, ...] = ()) -> _Unit:
    """Read the name of a unit that fits one of ``units``; ``instead``: the block for another one, and that."""
    if not isinstance(value, str) or not value.strip():
        raise NotQuantity(f"= {shown(value)} is not the name of a unit")
    if "%" in units and value.strip() in _SHARES:
        return _SHARES[value.strip()], "%"
    if "counts" in units and _COUNTS.fullmatch(value):
        return math.tau, "counts"
    try:
        return fields.quantity(f"1 {value}", *(unit for unit in units if unit not in ("%", "counts")))
    except NotQuantity as error:
        text = str(error).replace("'1 ", "'", 1)
    if instead:
        with suppress(NotQuantity):
            _unit(value, *instead[1:])
            text += f"; give a block {instead[0]} in place of this one"
    raise NotQuantity(text)


class Column(Part):
    """A column of a table, from 1; its numbers times ``factor`` are in ``unit``."""

    column: Annotated[int, BeforeValidator(_column)]
    factor: Annotated[float, BeforeValidator(_factor)] = 1.0
    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "s"))]

    @property
    def size(self) -> float:
        """What one in the column is in the unit of the package: a torque of a current, an angle of counts."""
        known = {key: entry.nominal for key, entry in self if isinstance(entry, Spread)}
        return self.factor * self.unit[0] * float(math.prod(known.values())) / known.get("counts_per_turn", 1.0) ** 2


class SpeedColumn(Column):
    """Speed of the screw, or of the load."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "rad/s", "m/s", instead=("position", *_TURNED)))]


class PositionColumn(Column):
    """Position of the screw, or of the load; of an encoder in counts, all of its edges counted."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, *_TURNED))]
    counts_per_turn: fields.Counts | None = None


class TorqueColumn(Column):
    """Torque of the motor, or its share of a rated one."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "N m", "%", instead=("current", "A")))]
    rated_torque: fields.Holding | None = None


class CurrentColumn(Column):
    """Current of the motor that makes torque, as its drive counts it for the torque constant."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "A", instead=("torque", "N m", "%")))]
    torque_constant: fields.TorqueConstant


class Measurements(Part):
    """Tables of one load: ``files`` beside the sheet, a pattern; by default several files are a point each.

    With a column of ``time``, or the period of ``sampling``, they are records over time, in which jerks are looked for;
    ``averaging``: the time over which the recorder averages each sample.
    """

    files: str = Field(min_length=1, max_length=500)
    separator: Annotated[str, BeforeValidator(_separator)] = ","
    decimal: Literal[".", ","] = "."
    speed: SpeedColumn | None = None
    position: PositionColumn | None = None
    torque: TorqueColumn | None = None
    current: CurrentColumn | None = None
    time: Column | None = None
    sampling: fields.Duration | None = None
    averaging: fields.Duration | None = None
    point: Literal["file", "row"] | None = None
    load: Load | None = None

    def misfit(self, place: str) -> str | None:
        """Return what does not fit together in this block, which stands at ``place``, or None."""
        for one, other in (("speed", "position"), ("torque", "current"), ("time", "sampling")):
            given = [name for name in (one, other) if getattr(self, name) is not None]
            if len(given) == 2:
                return f"{place}.{one} and {place}.{other} are both given; give one of them."
            if not given and one != "time":
                return f"{place}.{one} is missing, and so is {place}.{other}."
        if self.separator == self.decimal:
            return f"{place}.separator and {place}.decimal are both {shown(self.decimal)}; give another separator."
        if self.point == "row" and given:
            return f"{place}.point: row makes each row a point, so leave out time and sampling."
        if self.position and not given:
            return f"{place}.position needs {place}.time or {place}.sampling, from which the speed follows."
        if self.position and (self.position.unit[1] == "counts") != (self.position.counts_per_turn is not None):
            return f"{place}.position needs both or neither of unit: counts and counts_per_turn."
        if self.torque and (self.torque.unit[1] == "%") != (self.torque.rated_torque is not None):
            return f"{place}.torque needs both or neither of unit: % and rated_torque."
        return None


class Turning(Part):
    """What turns: the inertia, by which jerks tell the damping."""

    inertia: fields.Inertia


class KnownFriction(Part):
    """What is known of the friction of the flanks; the rest is fitted."""

    coefficient: fields.Coefficient | None = None
    slope: fields.Slope | None = None
    stribeck_rise: fields.Coefficient | None = None
    stribeck_speed: fields.SlidingSpeed | None = None
    stribeck_exponent: Literal[1, 2] | None = None


class KnownNut(Part):
    """A nut of two halves that are pressed apart, as in a data sheet."""

    preload: fields.Rubbing
    load_share: fields.Share | None = None


class KnownBearing(Part):
    """What is known of the drag of bearing and slide, as torques of the screw; the rest is fitted."""

    coulomb: fields.Drag | None = None
    viscous: fields.TurningDamping | None = None


class MeasuredSheet(Part):
    """A whole sheet. ``offset``: the zero error of the torque, where it is known."""

    name: str = Field(default="measured screw", min_length=1, max_length=200)
    thread: Thread | None = None
    load: Load | None = None
    measurements: list[Measurements] = Field(min_length=1, max_length=100)
    friction: KnownFriction = KnownFriction()
    bearing: KnownBearing = KnownBearing()
    nut: KnownNut | None = None
    screw: Turning | None = None
    offset: fields.Torque | None = None

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a sheet from names and values; raises ``InputError`` in one sentence."""
        found, alone = dict(values), isinstance(values.get("measurements"), Mapping)
        if alone:
            found["measurements"] = [found["measurements"]]
        try:
            sheet = cls.model_validate(found)
        except ValidationError as error:
            text = sentence_about(cls, error)
            raise InputError(text.replace("measurements.0.", "measurements.") if alone else text) from None
        if sheet.thread and (problem := sheet.thread.problem()) is not None:
            raise InputError(problem)
        if sheet.thread and sheet.thread.bare:
            raise InputError(f"{NO_DIAMETER}.")
        about = {"load", "friction", "nut"} & sheet.model_fields_set or {"load" for b in sheet.measurements if b.load}
        if about and not sheet.thread:
            raise InputError(f"thread is missing; {min(about)} needs it.")
        for path, entry in sheet.spreads().items():
            if entry.uncertain:
                raise InputError(f"{path} = {entry.text} is more than one value; a fit takes one.")
        return sheet

    def spreads(self) -> dict[str, Spread]:
        """The quantities that are given, by name."""
        blocks = (block.entries(f"measurements.{k}.") for k, block in enumerate(self.measurements))
        entries = chain(self.entries(), *blocks, [("offset", self.offset)])
        return {path: entry for path, entry in entries if isinstance(entry, Spread)}
