"""The sheet of a measurement: thread, load and tables with units; from it points, and the friction that fits them."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError

from lsvib.drives.complaints import sentence_about
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.numbers import number, shown, whole
from lsvib.sheets import fields
from lsvib.sheets.fields import NotQuantity, Spread
from lsvib.sheets.formulas import GRAVITY, square_coefficient, thread_geometry
from lsvib.sheets.sheet import Load, Part, Thread
from lsvib.sheets.torque.law import Fit, fitted
from lsvib.sheets.torque.measured import Measured, Solution, steady_torque
from lsvib.sheets.torque.records import Record, look
from lsvib.sheets.torque.starts import Array, Number
from lsvib.sheets.torque.stick_slip import StickSlip, breaking, combined, explained
from lsvib.sheets.torque.tables import REST, Point, read_table, refuse_record, row_points, steady_point

MOST_FILES = 1000  # of one sheet, and of points some million
LEAST_LOAD = 1e-6  # N
OF_FLANKS = {  # entries of `friction`, coefficients of a flank, and the parameters that they are of the square thread
    "coefficient": "friction_coefficient",
    "stribeck_rise": "stribeck_rise",
    "slope": "friction_slope",
    "static": "static_friction_coefficient",
}


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
    if not isinstance(value, str) or not re.fullmatch(r"[^\w\".+\-\r\n]", value):
        raise NotQuantity(f"= {shown(value)} is not one sign that parts cells, such as a comma, a semicolon or a tab")
    return value


_Unit = tuple[float, str]  # the size of a unit in one of the package, and that


def _unit(value: Any, *units: str) -> _Unit:
    """Read the name of a unit that fits one of ``units``."""
    if not isinstance(value, str) or not value.strip():
        raise NotQuantity(f"= {shown(value)} is not the name of a unit")
    try:
        return fields.quantity(f"1 {value}", *units)
    except NotQuantity as error:
        raise NotQuantity(str(error).replace("'1 ", "'", 1)) from None


class Column(Part):
    """A column of a table, from 1; its numbers times ``factor`` are in ``unit``."""

    column: Annotated[int, BeforeValidator(_column)]
    factor: Annotated[float, BeforeValidator(_factor)] = 1.0


class SpeedColumn(Column):
    """Speed of the screw, or of the load."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "rad/s", "m/s"))]


class TorqueColumn(Column):
    """Torque of the motor."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "N m"))]


class TimeColumn(Column):
    """Time of the samples."""

    unit: Annotated[_Unit, BeforeValidator(lambda value: _unit(value, "s"))]


class Measurements(Part):
    """Tables of one load: ``files`` beside the sheet, a pattern; by default several files are a point each.

    With a column of ``time``, or the period of ``sampling``, they are records over time, in which jerks are looked for;
    ``averaging``: the time over which the recorder averages each sample.
    """

    files: str = Field(min_length=1, max_length=500)
    separator: Annotated[str, BeforeValidator(_separator)] = ","
    decimal: Literal[".", ","] = "."
    speed: SpeedColumn
    torque: TorqueColumn
    time: TimeColumn | None = None
    sampling: fields.Duration | None = None
    averaging: fields.Duration | None = None
    point: Literal["file", "row"] | None = None
    load: Load | None = None


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
    thread: Thread
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
        if (problem := sheet.thread.problem()) is not None:
            raise InputError(problem)
        for path, entry in sheet.spreads().items():
            if entry.uncertain:
                raise InputError(f"{path} = {entry.text} is more than one value; a fit takes one.")
        return sheet

    def spreads(self) -> dict[str, Spread]:
        """The quantities that are given, by name."""
        blocks = (block.entries(f"measurements.{k}.") for k, block in enumerate(self.measurements))
        entries = chain(self.entries(), *blocks, [("offset", self.offset)])
        return {path: entry for path, entry in entries if isinstance(entry, Spread)}


@dataclass(frozen=True)
class Table:
    """What was read of a file: its ``points`` under a ``load`` [N], or jerks, which make none, and what is said of it.

    ``mass`` [kg] that moves with the load, zero where it is not given.

    ``record``: what it is over time, with the mean ``speed`` [rad/s], zero of starts both ways, and the time ``blur``
    over which a sample stands; None where each row is a point. ``look``: what makes it.
    """

    load: float
    mass: float
    points: list[Point]
    record: Record | None
    speed: float
    blur: float
    said: list[str]
    look: Callable[..., Record] | None = None


@dataclass(frozen=True)
class FittedSheet:
    """A sheet with its points (n), as read from the tables, and the fit; ``half_angle`` of the thread [rad].

    ``jerks``: what jerks tell of each end of the fit; ``inertia`` [kg m²] of what turns, as starts tell it.
    """

    name: str
    points: list[Point]
    left_out: list[str]
    fit: Fit
    half_angle: float
    tables: list[Table]
    jerks: dict[str, StickSlip]
    inertia: Number | None

    @property
    def stick_slip(self) -> StickSlip | None:
        """What jerks tell of the first end; None where no file has any."""
        return next(iter(self.jerks.values()), None)

    @property
    def too_lively(self) -> float | None:
        """The least speed [rad/s] up to which it would jerk, if it jerks as often as it did, where files were even."""
        found = [(one.damping[0] - one.by_periods, one.up_to) for one in self.jerks.values()
                 if one.damping and one.by_periods and one.up_to]  # fmt: skip
        return min(up_to for _, up_to in found) if found and all(short > 0 for short, _ in found) else None


def fit_sheet(path: Path) -> FittedSheet:
    """Read the sheet and its tables, and fit the friction law; raises ``InputError`` in one sentence."""
    sheet = MeasuredSheet.of(read_yaml(path))
    entries = {key: entry.nominal for key, entry in sheet.spreads().items()}
    lead, diameter, half_angle = thread_geometry(sheet, entries)
    angle = math.atan(lead / (math.pi * diameter))
    tables = list(_tables(sheet, path.parent, lead))
    pairs = sorted(
        ((table.load, point) for table in tables for point in table.points), key=lambda one: (one[0], one[1].speed)
    )
    jerks = [(table, table.record) for table in tables if table.record and table.record.kind == "jerks"]
    moving = [(point, load) for load, point in pairs if point.speed]
    if not moving and (jerks or not pairs):
        does = "jerks" if len(jerks) == len(tables) else "jerks, starts or stops"
        raise InputError(f"the screw {does} in all files, so none is a point of the friction law: measure more speeds.")
    # A file that begins at rest goes on in the direction in which it breaks away, a row at rest has that of its torque.
    starts = [(table, table.record) for table in tables if table.record and table.record.breakaway and table.speed]
    held = [
        (math.copysign(1.0, point.speed or point.torque), point.breakaway, table.load)
        for table in tables
        for point in table.points
        if point.breakaway is not None and (jerks or table.record is None or table.record.breakaway is None)
    ]
    torn, loose = breaking((1 if table.speed > 0 else -1, table.load, record) for table, record in jerks or starts)
    speed, torque, load = np.array([(point.speed, point.torque, load) for point, load in moving]).reshape(-1, 3).T
    nut = entries.get("nut.preload", 0.0), entries.get("nut.load_share", 1.0)
    measured = Measured(
        speed, torque, load, 0.5 * diameter, angle, np.array([*held, *torn]).reshape(-1, 3), *nut, loose
    )
    fit = fitted(measured, _known(sheet, entries, angle, half_angle))
    even = [((table.points[0].speed, table.load, table.mass), table.blur) for table in tables
            if table.points and table.record and table.record.kind == "even"]  # fmt: skip
    records = {(table.speed, table.load, table.mass): record for table, record in jerks}
    tables = [_started(table, measured, fit.main) for table in tables]
    turning = [table.record.inertia for table in tables if table.record and table.record.inertia]
    inertia = combined(turning) if turning else None
    given = entries.get("screw.inertia", inertia[0] if inertia else None)
    told = {name: explained(measured, end, records, even, given) for name, end in fit.ends.items()}
    known = {name: one for name, one in told.items() if one is not None}
    said = [text for table in tables for text in table.said]
    return FittedSheet(sheet.name, [point for point, _ in moving], said, fit, half_angle, tables, known, inertia)


def _started(table: Table, measured: Measured, solution: Solution) -> Table:
    """Return a table of starts, looked at again without the torque that its mass takes from the threads.

    A turn of one radian moves it by r_m tan λ. Where it starts or stops more steeply than its load, the force on the
    threads changes its sign, and friction with the flank.
    """
    if table.look is None or table.record is None or table.record.kind == "even" or not table.mass:
        return table
    lead = measured.pitch_radius * math.tan(measured.lead_angle)
    fastest = measured.speeds[-1]

    def moved(speed: Array, rate: Array) -> Array:
        """The torque [N m] at speeds [rad/s] and their rates."""
        law = np.clip(speed, -fastest, fastest)
        more, even = (
            steady_torque(solution.values, measured, law, table.load + share * table.mass * lead * rate)
            for share in (1, 0)
        )
        return np.asarray(more - even)

    return replace(table, record=table.look(load=moved))


def _known(sheet: MeasuredSheet, entries: Mapping[str, float], angle: float, half_angle: float) -> dict[str, float]:
    """What the sheet gives of friction and drag, by names of the fit, friction of the square thread."""
    found = {
        name: float(square_coefficient(entries[f"friction.{entry}"], angle, half_angle))
        for entry, name in OF_FLANKS.items()
        if f"friction.{entry}" in entries
    }
    paths = {"stribeck_speed": "friction.stribeck_speed", "coulomb": "bearing.coulomb", "viscous": "bearing.viscous"}
    found |= {name: entries[path] for name, path in {**paths, "offset": "offset"}.items() if path in entries}
    if sheet.friction.stribeck_exponent is not None:
        found["stribeck_exponent"] = float(sheet.friction.stribeck_exponent)
    return found


def _tables(sheet: MeasuredSheet, folder: Path, lead: float) -> Iterator[Table]:
    """Read all tables of a sheet."""
    for k, block in enumerate(sheet.measurements):
        place = f"measurements.{k}" if len(sheet.measurements) > 1 else "measurements"
        if (load := block.load or sheet.load) is None:
            raise InputError(f"load is missing, and so is {place}.load.")
        force, mass, tilt = (entry.nominal if entry else 0.0 for entry in (load.force, load.mass, load.orientation))
        under = float(force + mass * GRAVITY * math.sin(tilt)), mass  # against outward travel
        if max(abs(under[0]), sheet.nut.preload.nominal if sheet.nut else 0.0) < LEAST_LOAD:
            name = f"{place}.load" if block.load else "load"
            raise InputError(
                f"{name} makes no axial force of at least {LEAST_LOAD:g} N: give its force, or a mass with an "
                "orientation."
            )
        if block.separator == block.decimal:
            raise InputError(f"{place}.separator and {place}.decimal are both {shown(block.decimal)}.")
        if block.time is not None and block.sampling is not None:
            raise InputError(f"{place}.time and {place}.sampling are both given; give one of them.")
        if block.point == "row" and (block.time or block.sampling):
            raise InputError(f"{place}.point: row makes each row a point, and a time of samples the file a record.")
        files = _files(f"{place}.files", block.files, folder)
        for file in files:
            yield _table(file, block, under, lead, len(files) == 1)


def _table(path: Path, block: Measurements, under: tuple[float, float], lead: float, alone: bool) -> Table:
    """Read one table, ``alone`` in its block, as points or as a record; ``under``: which load [N], and mass [kg]."""
    columns: list[Any] = [block.speed, block.torque, *([block.time] if block.time else [])]
    factors = [column.factor * column.unit[0] for column in columns]
    factors[0] *= 2 * math.pi / lead if block.speed.unit[1] == "m/s" else 1.0  # from the load's speed to the screw's
    table = read_table(path, [column.column for column in columns], factors, block.separator, block.decimal)
    timed = block.time or block.sampling
    lost = f"{path.name}: rows that are not numbers, or of another width ({table.skipped})"
    skipped = [lost] if table.skipped else []
    if block.point == "row" or (block.point is None and alone and not timed):
        if block.point is None:
            refuse_record(table)
        return Table(*under, row_points(table), None, 0.0, 0.0, skipped)
    interval, window = (entry.nominal if entry else None for entry in (block.sampling, block.averaging))
    if table.skipped:
        interval = None  # it is not known where rows are lost
    again = partial(look, table, interval, window)
    record, mean = again() if timed else None, float(table.speed.mean())
    blur = window or interval or (float(np.median(np.diff(table.time))) if table.time is not None else 0.0)
    if record is not None and record.kind == "jerks":
        return Table(*under, [], record, mean, blur, [*skipped, record.said[0].removesuffix(".")])
    moved = record is not None and record.kind in ("start", "stop", "ramp")
    if moved and min(-table.speed.min(), table.speed.max()) > REST * np.ptp(table.speed):
        mean = 0.0
    try:
        point = steady_point(table)
    except InputError:
        if record is None or not moved:
            raise
        return Table(*under, [], record, mean, blur, [*skipped, record.said[0].removesuffix(".")], again)
    counts = {
        "rows of a screw at rest": 0 if point.speed else point.samples,
        "first samples, before the speed was steady": point.transient,
        "spikes of the torque": point.spikes,
    }
    said = [f"{path.name}: {words} ({count})" for words, count in counts.items() if count]
    return Table(*under, [point], record, mean, blur, skipped + said, again)


def _files(name: str, pattern: str, folder: Path) -> list[Path]:
    try:
        found = sorted(path for path in folder.glob(pattern) if path.is_file())
    except (ValueError, NotImplementedError, IndexError, OSError):
        raise InputError(f"{name} = {shown(pattern)} is not a pattern of files beside the sheet.") from None
    if not 1 <= len(found) <= MOST_FILES:
        raise InputError(
            f"{name} = {shown(pattern)} names {len(found) or 'no'} files in {folder}; the allowed range is "
            f"1 <= files <= {MOST_FILES}."
        )
    return found
