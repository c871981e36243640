"""The sheet of a measurement: thread, load and tables with units; from it points, and the friction that fits them."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.numbers import shown
from lsvib.sheets.fit_entries import MeasuredSheet, Measurements
from lsvib.sheets.formulas import GRAVITY, square_coefficient, thread_geometry
from lsvib.sheets.torque.law import Fit, fitted
from lsvib.sheets.torque.measured import Measured, Solution, steady_torque
from lsvib.sheets.torque.records import Record, look
from lsvib.sheets.torque.rows import moving_points, speed_of_position
from lsvib.sheets.torque.starts import UNSURE, Array, Number
from lsvib.sheets.torque.stick_slip import StickSlip, breaking, combined, explained
from lsvib.sheets.torque.tables import REST, Point, Recording, read_table, refuse_record, row_points, steady_point

MOST_FILES = 1000  # of one sheet, and of points some million
LEAST_LOAD = 1e-6  # N
NO_LEAD = 1e-15  # m a radian: the screw without thread, on a radius of 1 m, whose friction is all drag
MOVED = ("start", "stop", "ramp")  # records in which the speed changes
FEWEST, STEADY = 4, 0.05  # steady speeds, so much apart (relative), from which on they alone make the law
AGAINST = 0.9  # of the points, with a torque against the speed: noise or its zero may spare the others
OF_FLANKS = {  # entries of `friction`, coefficients of a flank, and the parameters that they are of the square thread
    "coefficient": "friction_coefficient",
    "stribeck_rise": "stribeck_rise",
    "slope": "friction_slope",
    "static": "static_friction_coefficient",
}


@dataclass(frozen=True)
class Table:
    """What was read of a file: its ``points`` under a ``load`` [N], or jerks, which make none, and what is said of it.

    ``mass`` [kg] that moves with the load, zero where it is not given.

    ``record``: what it is over time, with the mean ``speed`` [rad/s], zero of starts both ways, and the time ``blur``
    over which a sample stands; None where each row is a point. ``timed``: what was recorded, its
    interval and over which time it was averaged [s]; ``used``: what is said of points of a changing speed.
    """

    load: float
    mass: float
    points: list[Point]
    record: Record | None
    speed: float
    blur: float
    said: list[str]
    timed: tuple[Recording, float | None, float | None] | None = None
    used: str = ""


@dataclass(frozen=True)
class FittedSheet:
    """A sheet with its points (n), as read from the tables, and the fit; ``half_angle`` of a thread [rad], or None.

    ``jerks``: what jerks tell of each end of the fit; ``inertia`` [kg m²] of what turns, as starts tell it.
    """

    name: str
    points: list[Point]
    left_out: list[str]
    fit: Fit
    half_angle: float | None
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
    lead, diameter, half_angle = thread_geometry(sheet, entries) if sheet.thread else (math.tau * NO_LEAD, 2.0, None)
    angle = math.atan(lead / (math.pi * diameter))
    tables, unsure = _by_rows(list(_tables(sheet, path.parent, lead)), entries.get("screw.inertia"))
    jerks = [(table, table.record) for table in tables if table.record and table.record.kind == "jerks"]
    points, measured = _measured(sheet, entries, tables, jerks, (0.5 * diameter, angle), unsure)
    fit = fitted(measured, _known(sheet, entries, angle, half_angle))
    even = [((table.points[0].speed, table.load, table.mass), table.blur) for table in tables
            if table.points and table.record and table.record.kind == "even"]  # fmt: skip
    records = {(table.speed, table.load, table.mass): record for table, record in jerks}
    tables = [_started(table, measured, fit.main) for table in tables]
    turning = [table.record.inertia for table in tables if table.record and table.record.inertia]
    inertia = combined(turning, 0.0) if turning else None
    given = entries.get("screw.inertia", inertia[0] if inertia else None)
    told = {name: explained(measured, end, records, even, given) for name, end in fit.ends.items()}
    known = {name: one for name, one in told.items() if one is not None}
    said = [text for table in tables for text in table.said]
    return FittedSheet(sheet.name, points, said, fit, half_angle, tables, known, inertia)


def _measured(
    sheet: MeasuredSheet,
    entries: Mapping[str, float],
    tables: Sequence[Table],
    jerks: Sequence[tuple[Table, Record]],
    screw: tuple[float, float],
    unsure: float,
) -> tuple[list[Point], Measured]:
    """Return the points at which the screw turns, by load and speed, and all that was measured with them."""
    pairs = sorted(
        ((table.load, point) for table in tables for point in table.points), key=lambda one: (one[0], one[1].speed)
    )
    moving = [(point, load) for load, point in pairs if point.speed]
    if not moving and (jerks or not pairs):
        if len(jerks) == len(tables):
            raise InputError("the screw jerks in all files, so none gives a point of the law; measure more speeds.")
        why = next(table.record.said for table in tables if table.record and table.record.kind != "jerks")
        raise InputError(f"no file gives a point of the friction law; of {why[min(1, len(why) - 1)]}")
    _driven(sheet.measurements[0], moving)
    # A file that begins at rest goes on in the direction in which it breaks away, a row at rest has that of its torque.
    starts = [(table, table.record) for table in tables if table.record and table.record.breakaway and table.speed]
    held = [
        (math.copysign(1.0, point.speed or point.torque), point.breakaway, table.load)
        for table in tables
        for point in table.points
        if point.breakaway is not None and (jerks or table.record is None or table.record.breakaway is None)
    ]
    torn, loose = breaking((1 if table.speed > 0 else -1, table.load, record) for table, record in jerks or starts)
    rows = [(one.speed, one.torque, load, one.rate, one.speed_scatter if one.rate else 0.0) for one, load in moving]
    speed, torque, load, rate, spread = np.array(rows).reshape(-1, 5).T
    nut = entries.get("nut.preload", 0.0), entries.get("nut.load_share", 1.0)
    broken = np.array([*held, *torn] if sheet.thread else []).reshape(-1, 3)
    every = Measured(speed, torque, load, *screw, broken, *nut, loose, rate, unsure, spread)
    return [point for point, _ in moving], every


def _by_rows(tables: list[Table], given: float | None) -> tuple[list[Table], float]:
    """Return tables in which changes of speed are points too, where steady files show too few speeds.

    Their torque is less what accelerates the inertia [kg m²] that they tell, or that is ``given``; with its error.
    """
    steady = {round(math.log(abs(point.speed)) / STEADY) for table in tables for point in table.points if point.speed}
    changing = [table.record for table in tables if table.timed and table.record and table.record.kind in MOVED]
    if len(steady) >= FEWEST or not changing:
        return tables, 0.0
    found = [record.turning for record in changing if record.turning]
    inertia = combined(found, 0.0) if found else None
    if given is not None and (inertia is None or inertia[1] > UNSURE * inertia[0]):
        inertia = given, 0.0
    rows = [_with_rows(table, inertia) if table.record in changing else table for table in tables]
    return rows, inertia[1] if inertia else 0.0


def _with_rows(table: Table, inertia: Number | None) -> Table:
    """Return a table in which what changes is points, and what is said of them."""
    if not table.timed or not (points := moving_points(*table.timed, inertia or (0.0, 0.0))):
        return table
    said = table.said[: table.timed[0].skipped > 0]  # of rows that are no numbers
    most = max(abs(point.rate) for point in points)
    less = f"less the torque that accelerates {inertia[0]:.4g} kg m²" if inertia else (
        f"and torque for acceleration, of up to {most:.3g} rad/s², counts as friction; screw.inertia removes it"
    )  # fmt: skip
    rows = sum(point.samples for point in points)
    used = f"{points[0].name}: {rows} rows in which the screw turns make {len(points)} points, {less}."
    broke = next((point.breakaway for point in table.points if point.breakaway is not None), None)
    return replace(table, points=[replace(points[0], breakaway=broke), *points[1:]], said=said, used=used)


def _driven(block: Measurements, points: Sequence[tuple[Point, float]]) -> None:
    """Refuse torques that are against the speed at every point, where no load [N] drives the screw."""
    against = [point.torque * point.speed < 0 for point, _ in points]
    if len(points) > 1 and np.mean(against) > AGAINST and any(load * point.speed >= 0 for point, load in points):
        name, column = ("torque", block.torque) if block.torque else ("current", block.current)
        factor = column.factor if column else 1.0
        raise InputError(
            "the torque opposes the speed at every point, as if friction drove the screw: write factor: "
            f"{-factor:g} in measurements.{name}" + (f" in place of {factor:g}." if factor != 1 else ".")
        )


def _started(table: Table, measured: Measured, solution: Solution) -> Table:
    """Return a table of starts, looked at again without the torque that its mass takes from the threads.

    A turn of one radian moves it by r_m tan λ. Where it starts or stops more steeply than its load, the force on the
    threads changes its sign, and friction with the flank.
    """
    if table.timed is None or table.record is None or table.record.kind == "even" or not table.mass:
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

    return replace(table, record=look(*table.timed, moved))


def _known(
    sheet: MeasuredSheet, entries: Mapping[str, float], angle: float, half_angle: float | None
) -> dict[str, float]:
    """What the sheet gives of friction and drag, by names of the fit, friction of the square thread."""
    found = {"friction_coefficient": 0.0, "stribeck_rise": 0.0, "friction_slope": 0.0, "stribeck_exponent": 1.0}
    if half_angle is not None:  # else all friction is drag
        found = {name: float(square_coefficient(entries[f"friction.{entry}"], angle, half_angle))
                 for entry, name in OF_FLANKS.items() if f"friction.{entry}" in entries}  # fmt: skip
    paths = {"stribeck_speed": "friction.stribeck_speed", "coulomb": "bearing.coulomb", "viscous": "bearing.viscous"}
    found |= {name: entries[path] for name, path in {**paths, "offset": "offset"}.items() if path in entries}
    if sheet.friction.stribeck_exponent is not None:
        found["stribeck_exponent"] = float(sheet.friction.stribeck_exponent)
    return found


def _tables(sheet: MeasuredSheet, folder: Path, lead: float) -> Iterator[Table]:
    """Read all tables of a sheet."""
    for k, block in enumerate(sheet.measurements):
        place = f"measurements.{k}" if len(sheet.measurements) > 1 else "measurements"
        if (problem := block.misfit(place)) is not None:
            raise InputError(problem)
        load = block.load or sheet.load
        if load is None and sheet.thread:
            raise InputError(f"load is missing, and so is {place}.load.")
        three = (load.force, load.mass, load.orientation) if load else (None,) * 3
        force, mass, tilt = (entry.nominal if entry else 0.0 for entry in three)
        under = float(force + mass * GRAVITY * math.sin(tilt)), mass  # against outward travel
        if load and max(abs(under[0]), sheet.nut.preload.nominal if sheet.nut else 0.0) < LEAST_LOAD:
            name = f"{place}.load" if block.load else "load"
            raise InputError(
                f"{name} makes no axial force of at least {LEAST_LOAD:g} N: give its force, or a mass with an "
                "orientation, or leave out thread and load to fit all friction as drag."
            )
        motion = block.speed or block.position
        if not sheet.thread and motion and motion.unit[1] in ("m", "m/s"):
            raise InputError("thread is missing; its lead converts speed or position of the load to the screw.")
        files = _files(f"{place}.files", block.files, folder)
        for file in files:
            name = file.relative_to(folder).as_posix() if file.is_relative_to(folder) else file.name
            yield _table(file, name, block, under, lead, len(files) == 1)


def _table(path: Path, name: str, block: Measurements, under: tuple[float, float], lead: float, alone: bool) -> Table:
    """Read one table, ``alone`` in its block, as points or as a record; ``under``: which load [N], and mass [kg]."""
    columns: list[Any] = [block.speed or block.position, block.torque or block.current]
    columns += [block.time] if block.time else []
    factors = [column.size for column in columns]
    factors[0] *= math.tau / lead if columns[0].unit[1] in ("m", "m/s") else 1.0  # from the load's to the screw's
    table = read_table(path, [column.column for column in columns], factors, block.separator, block.decimal)
    table, timed = replace(table, name=name), block.time or block.sampling
    lost = f"{name}: rows without numbers, or with more or fewer columns ({table.skipped})"
    skipped = [lost] if table.skipped else []
    if block.point == "row" or (block.point is None and alone and not timed):
        if block.point is None:
            refuse_record(table)
        return Table(*under, row_points(table), None, 0.0, 0.0, skipped)
    interval, window = (entry.nominal if entry else None for entry in (block.sampling, block.averaging))
    if table.skipped:
        interval = None  # it is not known where rows are lost
    if block.position:
        table, interval = speed_of_position(table, interval)
        window = max(window or 0.0, interval)
    record, mean = look(table, interval, window) if timed else None, float(table.speed.mean())
    blur = window or interval or (float(np.median(np.diff(table.time))) if table.time is not None else 0.0)
    if record is not None and record.kind == "jerks":
        return Table(*under, [], record, mean, blur, [*skipped, record.said[0].removesuffix(".")])
    moved = record is not None and record.kind in MOVED
    if moved and min(-table.speed.min(), table.speed.max()) > REST * np.ptp(table.speed):
        mean = 0.0
    again = table, interval, window
    try:
        point = steady_point(table)
    except InputError:
        if record is None:
            raise
        if not moved:
            raise InputError(record.said[0]) from None
        return Table(*under, [], record, mean, blur, [*skipped, record.said[0].removesuffix(".")], again)
    counts = {
        "rows of a screw at rest": 0 if point.speed else point.samples,
        "first samples, before the speed was steady": point.transient,
        "spikes of the torque": point.spikes,
    }
    said = [f"{name}: {words} ({count})" for words, count in counts.items() if count]
    return Table(*under, [point], record, mean, blur, skipped + said, again if timed else None)


def _files(name: str, pattern: str, folder: Path) -> list[Path]:
    try:
        found = sorted(path for path in folder.glob(pattern) if path.is_file())
    except (ValueError, NotImplementedError, IndexError, OSError):
        raise InputError(f"{name} = {shown(pattern)} is not a pattern of files in the folder of the sheet.") from None
    if not 1 <= len(found) <= MOST_FILES:
        raise InputError(
            f"{name} = {shown(pattern)} names {len(found) or 'no'} files in {folder}; the allowed range is "
            f"1 <= files <= {MOST_FILES}."
        )
    return found
