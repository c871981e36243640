"""Random measurement tables and their sheets, sound, unusual and malformed ones; seeded."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from references.measured import DIAMETER, square, torque

GONE = object()
# What may stand in a cell instead of a number.
CELLS = (
    "", "nan", "inf", "-inf", "1e308", "1e999", "1e-320", "1_0", "0x1F", "1,5", "1.5.5", "−3", "٣", "high", '"', "0",
    "-0",
)  # fmt: skip
# Places in the sheet, and what may stand there instead.
ENTRIES: dict[str, tuple[Any, ...]] = {
    "thread": (GONE, None, 5, [], {}, {"size": "Tr 18x4"}, {"lead_angle": "4 deg", "pitch_diameter": "18 mm"}),
    "thread.lead": (GONE, "0 mm", "1e-6 m", "4", "4 kg", ["4 mm", "5 mm"], "1e-300 mm", "90 m", "4_0 mm"),
    "thread.pitch_diameter": ("1e-6 m", "90 m", "18 furlongs", None), "thread.half_angle": ("89 deg", "-1 deg", "15"),
    "load": (GONE, None, 5, {"mass": "30 kg"}, {"mass": "30 kg", "orientation": "vertical"}, {"mass": "30 kg",
        "orientation": "45 deg", "force": "1 N"}),
    "load.force": ("0 N", "1e-300 N", "-300 N", "1e10 N", "300", "nan N", "3_0 N", {"mean": "300 N", "std": "1 N"}),
    "load.colour": ("red",), "measurements": (GONE, None, [], [5], 5, "x", [{}], {}), "measurements.0": ("x",),
    "measurements.colour": (1,),
    "measurements.files": ("*" * 100, "*.csv" * 40, "**/*.csv", "../*/*.csv", "/proc/kmsg", ".", "", "[", "*.csv/x",
        "a\0b", 5, None, "data/00.csv", "data/0?.csv", "data/[!x]*.csv", "data/{a}.csv", "data"),
    "measurements.separator": (";", "\t", " ", "", ",,", "1", '"', "\n", None, 5),
    "measurements.decimal": (",", ";", "", None), "measurements.point": ("file", "row", "table", None),
    "measurements.load": ({"force": "0 N"}, {}, {"force": "50 N"}, 7),
    "measurements.speed": (GONE, 5, {}, {"column": 1}, {"unit": "rpm"}),
    "measurements.speed.column": (0, -1, 2, 3, 1000, "1_0", 1.0, 1.5, True, None, "two", 10**400),
    "measurements.speed.unit": ("", "N", "mm/s", "rad/s", "m/s", "1", "rpm*rpm", "rpm^99", 5, None),
    "measurements.speed.factor": (0, -1, 1e-300, 1e300, 1e-12, "1_0", "nan", True, None, "1 %"),
    "measurements.torque.factor": (0, -1, 1e-300, 1e300, 1e-12, 1e-320, "1_0", False, []),
    "measurements.torque.column": (1, 2, 3, 200, 201), "measurements.torque.unit": ("N*m", "lbf*in", "Nm", "mm", ""),
    "friction": (None, 5, {"coefficient": 0.15}, {"stribeck_rise": 0}, {"stribeck_exponent": 1},
        {"stribeck_exponent": 3}, {"slope": "0 s/m", "stribeck_rise": 0}, {"coefficient": 2.9},
        {"stribeck_speed": "1e-9 m/s"}, {"stribeck_speed": "1e4 m/s"}, {"slope": "-1000 s/m"}, {"coefficient": 0,
        "stribeck_rise": 0, "slope": "0 s/m"}),
    "bearing": (None, {"coulomb": "24 mN*m"}, {"viscous": "0 N*m*s/rad"}, {"coulomb": "1e9 N*m"}, {"coulomb": "0 N*m",
        "viscous": "1e12 N*m*s/rad"}), "offset": ("0 N*m", "1e9 N*m", "-3 mN*m", 5, "1 N"),
    "name": ("", "x" * 300, 5, None, "a\nb", "<b>&amp;"), "colour": ("red",),
}  # fmt: skip


def one_load(seed: int) -> tuple[np.ndarray, np.ndarray, float, dict[str, float]]:
    """Speeds and noisy torques of a random screw, one way or both, its load, and the law, of the square thread.

    Every other law has a rise; slopes fall or grow, and the bearing has up to as much friction as the threads.
    """
    rng = np.random.default_rng([7, seed])
    load, most = float(rng.choice([-1, 1]) * 10 ** rng.uniform(0, 3)), rng.choice([6.3, 21.0])
    both, speed = rng.integers(2), np.linspace(1.0, most, 15) * rng.choice([-1, 1])
    speed, fastest = np.concatenate([-speed[: 15 * both], speed]), 0.5 * DIAMETER * most
    share = rng.uniform([0.05, 0.2, 0.1, -0.6, 0, 0], [0.4, 0.5, 0.4, 0.6, 1, 0.5]) * [1, seed % 2, fastest, 1, 1, 1]
    friction, force = share[0] * np.array([1, share[1], share[3] / fastest]), 0.5 * DIAMETER * abs(load) * share[0]
    numbers = [*friction, share[2], force * share[4], force * share[5] / most, 0.05 * force * both]
    names = ["friction_coefficient", "stribeck_rise", "friction_slope"]
    law = dict(zip([*names, "stribeck_speed", "coulomb", "viscous", "offset"], numbers, strict=True))
    exact = torque(speed, load, law)
    noise = 10 ** rng.uniform(-2.5, -1.5) * float(np.median(np.abs(exact))) * rng.standard_normal(speed.size)
    return speed, exact + noise, load, law | {name: law[name] * square() for name in names}


def random_measurement(folder: Path, seed: int, index: int) -> Path:
    """Write tables and their sheet into a folder, the same whatever else is drawn; the path of the sheet.

    One in three has sound tables and a sound sheet, with speeds, noise and forms of a table drawn; the others have up
    to three faults.
    """
    rng = np.random.default_rng([seed, index])
    faults = int(rng.choice([0, 1, 1, 2, 3]))
    load, count = float(rng.choice([-900, 40, 300])), int(rng.choice([1, 3, 8, 8, 14, 14]))
    speeds = np.geomspace(0.5, rng.choice([1.0, 40.0]), count)
    speeds = np.concatenate([-speeds, speeds]) if rng.random() < 0.8 else speeds
    sheet: dict[str, Any] = {
        "thread": {"lead": "4 mm", "pitch_diameter": "18 mm", "half_angle": "15 deg"},
        "load": {"force": f"{load} N"},
        "measurements": {
            "files": "data/*.csv",
            "speed": {"column": 1, "unit": "rad/s"},
            "torque": {"column": 2, "unit": "N*m"},
        },
    }
    tables = _tables(rng, speeds, load)
    separator, decimal = [(",", "."), (";", ","), ("\t", "."), (";", "."), (" ", ",")][int(rng.choice(5))]
    sheet["measurements"] |= {"separator": separator, "decimal": decimal} if separator != "," else {}
    for _ in range(faults):
        if rng.random() < 0.5:
            _spoil_sheet(rng, sheet)
        else:
            _spoil_tables(rng, tables)
    (folder / "data").mkdir(parents=True)
    for name, rows in tables.items():
        text = "\n".join(separator.join(cell.replace(".", decimal) for cell in row) for row in rows)
        (folder / "data" / name).write_bytes(_encoded(rng, text))
    path = folder / "sheet.yaml"
    path.write_text(yaml.safe_dump(sheet, allow_unicode=True), encoding="utf-8")
    return path


def _tables(rng: np.random.Generator, speeds: np.ndarray, load: float) -> dict[str, list[list[str]]]:
    """One table of rows, or a file for each speed; header, noise and further columns as drawn."""
    noise = float(rng.choice([0.0, 1e-3, 0.1]))
    header, more = rng.random() < 0.5, rng.random() < 0.3

    def rows(turning: np.ndarray) -> list[list[str]]:
        measured = torque(turning, load) + noise * rng.standard_normal(turning.size)
        own = [[f"{w:.9g}", f"{t:.9g}"] + (["7"] if more else []) for w, t in zip(turning, measured, strict=True)]
        return ([["rad/s", "N m"] + (["time"] if more else [])] if header else []) + own

    if rng.random() < 0.6:
        return {"00.csv": rows(speeds)}
    samples = int(rng.choice([1, 2, 12]))
    return {f"{k:02}.csv": rows(np.full(samples, w) * (1 + noise * 0.1)) for k, w in enumerate(speeds)}


def _spoil_sheet(rng: np.random.Generator, sheet: dict[str, Any]) -> None:
    place = str(rng.choice(list(ENTRIES)))
    options = ENTRIES[place]
    value = options[int(rng.choice(len(options)))]
    *parents, key = place.split(".")
    at: Any = sheet
    for parent in parents:
        at = at.setdefault(parent, {}) if isinstance(at, dict) else None
    if not isinstance(at, dict):
        return
    if value is GONE:
        at.pop(key, None)
    else:
        at[key] = copy.deepcopy(value)


def _spoil_tables(rng: np.random.Generator, tables: dict[str, list[list[str]]]) -> None:
    name = str(rng.choice(list(tables)))
    rows, kind = tables[name], int(rng.choice(12))
    if not rows:
        return
    column = int(rng.choice(2))
    if kind == 0:
        tables[name] = []
    elif kind in (1, 2):  # a column that is one number throughout, of all files
        value = str(rng.choice(["0", "0", "5", "-1", "1e-300", "1e-12"]))
        for table in tables.values():
            for row in table[-max(len(table) - 1, 1) :]:
                row[column] = value
    elif kind in (3, 4, 5):  # some cells
        for row in rows:
            if rng.random() < 0.3:
                row[column] = str(rng.choice(CELLS))
    elif kind == 6:
        tables[name] = rows * 3
    elif kind == 7:
        rng.shuffle(rows)
    elif kind == 8:  # rows of other lengths
        for row in rows:
            if rng.random() < 0.3:
                row[:] = row[:1] if rng.random() < 0.5 else row * 2
    elif kind == 9:
        tables[name] = [["1"] * 300] * 4
    elif kind == 10:  # an outlier
        rows[-1][-1] = str(rng.choice(["100", "-100", "1e6", "0"]))
    else:
        for row in rows:
            row.reverse()


def _encoded(rng: np.random.Generator, text: str) -> bytes:
    kind = int(rng.choice(10))
    if kind == 0:
        return text.replace("\n", "\r\n").encode("utf-8-sig")
    if kind == 1 and rng.random() < 0.3:
        return text.encode("utf-16")
    if kind == 2:
        return text.replace("\n", "\r").encode()
    return (text + "\n" * int(rng.choice(3))).encode()
