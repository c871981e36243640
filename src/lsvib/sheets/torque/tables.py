"""Tables of measured speed and torque: read, and reduced to points of steady motion.

A file is a table of rows in which cells are parted by one letter. Its header, and rows that hold no numbers where they
are wanted, are skipped. A file that was recorded at one speed is one point, the mean of its samples; of a table of many
speeds each row is a point.
"""

import csv
import math
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lsvib.errors import InputError
from lsvib.numbers import NotNumber, number, shown

LARGEST_FILE = 64 * 2**20  # bytes; a million rows of three columns
TRANSIENT = 5.0  # standard deviations of the second half: further off, the first samples are not yet steady
SPIKE = 10.0  # robust standard deviations of the torque: so far off is no friction
DRIFT = 0.1  # of the mean speed: largest difference of the means of four parts of a file
ERRORS = 7.0  # standard errors of those means, up to which noise explains their difference
JERKS = 0.5  # of the scatter within the parts, up to which jerks do, of which samples are not independent
FASTEST, STRONGEST = 1e6, 1e9  # rad/s, N m: beyond it is no screw
RECORD = 50  # rows from which on a table from rest to rest counts as a record over time
REST = 0.05  # of the mean speed: below it a screw that is about to start still rests


@dataclass(frozen=True)
class Recording:
    """What one file holds: ``speed`` of the screw (n) [rad/s], ``torque`` of the motor (n) [N m], rows ``skipped``.

    ``time`` (n) [s]: of the samples, where it was read.
    """

    name: str
    speed: NDArray[np.float64]
    torque: NDArray[np.float64]
    skipped: int = 0
    time: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Point:
    """Steady motion: means of ``speed`` [rad/s] and ``torque`` [N m] with the scatter of the samples about them.

    ``samples``: of how many; left out were ``transient`` first samples and ``spikes``. ``breakaway``: the largest
    torque [N m] of a screw at rest that then began to turn, None where it turned all the time. ``rate`` of the speed
    [rad/s²]: of what it accelerates the torque is free.
    """

    name: str
    speed: float
    torque: float
    speed_scatter: float
    torque_scatter: float
    samples: int
    transient: int = 0
    spikes: int = 0
    breakaway: float | None = None
    rate: float = 0.0


def read_table(
    path: Path, columns: Sequence[int], factors: Sequence[float], separator: str = ",", decimal: str = "."
) -> Recording:
    """Read speed, torque and, if it is asked for, time from ``columns`` (from 1), times ``factors`` to rad/s, N m, s.

    A position in rad may stand in the place of the speed.
    Rows count that have as many cells as most rows have, and numbers in all columns. Raises ``InputError``.
    """
    try:
        lines = _text(path).splitlines()
        blank = separator == " "  # of which any number parts two cells
        rows = [row for row in (map(str.split, lines) if blank else csv.reader(lines, delimiter=separator)) if any(row)]
    except csv.Error as error:
        raise InputError(f"{path} is not a table: {error}.") from None
    if not rows:
        raise InputError(f"{path} is empty.")
    width = Counter(map(len, rows)).most_common(1)[0][0]
    if width < max(columns):
        wanted = max(columns) - 1
        other = next((sign for sign in ";\t, " if all(line.count(sign) >= wanted for line in lines[-3:])), separator)
        raise InputError(
            f"{path} has {width} column{'s' * (width > 1)} when separated by {shown(separator)}, but no column "
            f"{max(columns)}{f'; the separator seems to be {shown(other)}' * (other != separator)}."
        )
    places = [k for k, row in enumerate(rows) if len(row) == width]
    own = [rows[k] for k in places]
    cells = [[row[column - 1] for column in columns] for row in own]
    found = np.array([[_number(cell.replace(decimal, ".")) for cell in pair] for pair in cells])
    marked = [pair for pair in cells if decimal == "," and "." in "".join(pair)]
    for pair in marked:
        if np.isfinite([_number(cell.replace(".", "").replace(decimal, ".")) for cell in pair]).all():
            cell = next(cell for cell in pair if "." in cell)
            raise InputError(f"{path} has a point in {shown(cell)}, where the decimal sign is a comma.")
    for column, holds in zip(columns, np.isfinite(found).any(axis=0), strict=True):
        if not holds:
            last = own[-1][column - 1]
            hint = "; where a comma is the decimal sign, give decimal: ','" if "," in last and decimal == "." else ""
            hint = next((f"; the separator seems to be {shown(sign)}" for sign in ";\t" if sign in last), hint)
            raise InputError(f"{path} has no number in column {column}, whose last cell is {shown(last)}{hint}.")
    kept = np.isfinite(found).all(axis=1)
    if not kept.any():
        raise InputError(f"{path} has no row with numbers in columns {' and '.join(map(str, columns))}.")
    begin = places[int(np.argmax(kept))]  # what stands above is the header
    with np.errstate(over="ignore"):
        speed, torque, *time = (found[kept] * factors).T
    for values, most, unit in ((speed, FASTEST, "rad/s"), (torque, STRONGEST, "N m")):
        if (size := float(np.abs(values).max())) > most:
            raise InputError(f"{path} has {size:.4g} {unit}; the allowed range is up to {most:.4g} {unit}.")
    return Recording(path.name, speed, torque, len(rows) - begin - int(np.count_nonzero(kept)), *time)


def _text(path: Path) -> str:
    try:
        if not path.is_file():
            raise InputError(f"Cannot read {path}: it is not a regular file.")
        size = os.path.getsize(path)  # of what is made while it is read, as under /proc, it is zero
        if size > LARGEST_FILE:
            raise InputError(f"{path} is larger than {LARGEST_FILE // 2**20} MB, the largest table that is read.")
        with path.open("rb") as file:
            return file.read(size).decode("utf-8-sig", errors="replace").replace("\0", "?")
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror or error}.") from None


def _number(text: str) -> float:
    try:
        return number(text.replace("−", "-"))
    except NotNumber:
        return np.nan


def steady_point(recording: Recording) -> Point:
    """Return the mean of a recording at one speed, without what is not steady motion at its beginning.

    Raises ``InputError`` where it does not run at one speed.
    """
    speed, torque = recording.speed, recording.torque
    half = speed[speed.size // 2 :]
    tolerance = TRANSIENT * half.std() + 1e-9 * abs(half.mean())  # more than rounding where all speeds are equal
    begin = int(np.argmax(np.abs(speed - half.mean()) <= tolerance))
    deviation = np.abs(torque[begin:] - np.median(torque[begin:]))
    usual = 1.4826 * np.median(deviation)  # the standard deviation where samples are normally distributed
    kept = begin + np.flatnonzero((deviation <= SPIKE * usual) | (usual == 0))
    mean, scatter = float(speed[kept].mean()), _scatter(speed[kept])
    if scatter > 2 * abs(mean) or drifts(speed[begin:]):
        raise InputError(
            f"{recording.name} does not run at one speed, but from {speed.min():.4g} to {speed.max():.4g} rad/s; give "
            "measurements.time or measurements.sampling, to account for changes of speed, or, if each "
            "row is steady motion of its own, measurements.point: row."
        )
    resting = np.abs(speed[:begin]) < REST * abs(mean)
    held = torque[: begin if resting.all() else int(np.argmin(resting))]
    return Point(
        recording.name,
        mean,
        float(torque[kept].mean()),
        scatter,
        _scatter(torque[kept]),
        kept.size,
        transient=begin,
        spikes=speed.size - begin - kept.size,
        breakaway=float(held[np.argmax(np.abs(held))]) if held.size else None,
    )


def drifts(speed: NDArray[np.float64]) -> bool:
    """Whether the means of four parts differ by more than noise and jerks explain, as they do in a ramp or a stop."""
    parts = np.array_split(speed, min(4, speed.size))
    within = math.sqrt(sum(part.var() * part.size for part in parts) / max(speed.size - len(parts), 1))
    explained = max(JERKS, ERRORS * math.sqrt(len(parts) / speed.size)) * within
    return bool(np.ptp([part.mean() for part in parts]) > max(DRIFT * abs(speed.mean()), explained))


def refuse_record(recording: Recording) -> None:
    """Raise ``InputError`` for a record over time: many rows, whose speed changes slowly from rest to rest."""
    speed, slowly = np.abs(recording.speed), np.abs(np.diff(recording.speed))
    least = REST * float(speed.max())
    if speed.size >= RECORD and max(speed[0], speed[-1], np.median(slowly)) < least:
        raise InputError(
            f"{recording.name} looks like a record over time, which begins and ends at rest; give measurements.time or "
            "measurements.sampling, or, if each row is steady motion of its own, measurements.point: row."
        )


def row_points(recording: Recording) -> list[Point]:
    """Return each row of a table as a point; a row at rest, with its torque, is a breakaway."""
    rows = zip(recording.speed.tolist(), recording.torque.tolist(), strict=True)
    return [
        Point(recording.name, speed, torque, np.nan, np.nan, 1, breakaway=None if speed else torque)
        for speed, torque in rows
    ]


def _scatter(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1)) if values.size > 1 else float("nan")
