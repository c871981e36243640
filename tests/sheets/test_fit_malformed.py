"""Sheets and tables that a fit refuses: one sentence that names the fault, exit code 2, and nothing written."""

from pathlib import Path

import pytest
import yaml
from references.command_line import refused
from references.measured import SPEEDS, write_tables

GONE = object()
# Place in the sheet, what stands there instead, and words that the sentence must hold.
SHEETS = [
    ("thread", GONE, "thread is missing"),
    ("thread.lead", GONE, "none of size, lead"),
    ("thread.lead", ["4 mm", "5 mm"], "thread.lead = low 4 mm, high 5 mm is more than one value"),
    ("colour", "red", "colour is not a known key"),
    ("load", GONE, "load is missing"),
    ("load.force", "0 N", "load makes no axial force"),
    ("load.force", "300", "has no unit"),
    ("measurements.load", {"force": "0 N"}, "measurements.load makes no axial force"),
    ("load", {"mass": "30 kg", "orientation": "horizontal"}, "load makes no axial force"),
    ("load.force", "-300 N", "turns harder in the direction in which the given load would help"),
    ("measurements", GONE, "measurements is missing"),
    ("measurements.files", "none/*.csv", "names no files"),
    ("measurements.files", "/etc/*.csv", "not a pattern of files"),
    ("measurements.files", ".", "measurements.files = '.' is not a pattern of files in the folder of the sheet"),
    ("measurements.separator", "word", "measurements.separator = 'word' is not one separator"),
    ("measurements.decimal", ",", "measurements.separator and measurements.decimal are both ','"),
    ("measurements.speed.factor", 1e300, "rad/s; the allowed range is up to 1e+06 rad/s"),
    ("measurements.speed.unit", "", "measurements.speed.unit = '' is not the name of a unit"),
    ("measurements.speed.unit", "N", "measurements.speed.unit = 'N' is not a rotational speed"),
    ("measurements.separator", ";", "but no column 2; the separator seems to be ','."),
    ("measurements.speed", GONE, "measurements.speed is missing"),
    ("measurements.speed.unit", GONE, "measurements.speed.unit is missing"),
    ("measurements.speed.unit", "bananas", "is not known"),
    ("measurements.torque.unit", "N", "is not a torque"),
    ("measurements.torque.unit", "A", "is not a torque, such as 3 mN*m; give a block current in place of this one"),
    ("measurements.torque.unit", "%", "needs both or neither of unit: % and rated_torque"),
    ("measurements.position", {"column": 1, "unit": "deg"}, "speed and measurements.position are both given"),
    ("measurements.torque.column", 0, "measurements.torque.column = 0 is outside the allowed range 1 <= column"),
    ("measurements.torque.column", 3, "has 2 columns"),
    ("measurements.torque.factor", 0, "any finite number but 0"),
    ("measurements.torque.factor", "1 %", "is not a number"),
    ("measurements.point", "table", "is not one of file or row"),
    ("friction.coefficient", "5 mm", "friction.coefficient"),
    ("friction", {"coefficient": 0.1, "slope": "-1 s/m"}, "friction.slope >= -0.9 friction.coefficient / (0.3"),
    ("friction.stribeck_exponent", 3, "is not one of 1 or 2"),
    ("bearing.coulomb", "-1 N*m", "outside the allowed range"),
]


@pytest.fixture
def sheet(tmp_path):
    """A sheet of one load, which is fitted as it is."""
    path = write_tables(tmp_path / "data", [300.0], samples=12)
    values = yaml.safe_load(path.read_text())
    (values["measurements"],) = values["measurements"]
    values["load"] = values["measurements"].pop("load")
    path.write_text(yaml.safe_dump(values))
    return path


@pytest.mark.parametrize(("place", "value", "words"), SHEETS)
def test_a_sheet_is_refused(sheet, run, place, value, words):
    values = yaml.safe_load(sheet.read_text())
    part = values
    *parents, key = place.split(".")
    for parent in parents:
        part = part.setdefault(parent, {})
    part[key] = value
    if value is GONE:
        del part[key]
    sheet.write_text(yaml.safe_dump(values))
    assert words in refused(run, "fit", str(sheet), "--out", "fitted")


TABLES = {  # content of one of the files, and words of the sentence
    "": "is empty",
    "rpm,mN m\n": "has no number in column 1",
    "rpm,mN m\n10,high\n10,high\n": "has no number in column 2, whose last cell is 'high'",
    "rpm,mN m\n10,\n,20\n": "has no row with numbers in columns 1 and 2",
    "rpm\n10\n10\n": "has 1 column ",
    "\n".join(f"{speed},20" for speed in range(-50, 50)): "does not run at one speed",
    "10,20\n10,1e308\n": "has 1e+305 N m; the allowed range is up to 1e+09 N m",
    "10,1e999\n10,1e999\n": "has no number in column 2",
    f"10,20\n10,{'9' * 200_000}\n": "is not a table",
}


@pytest.mark.parametrize("text", TABLES, ids=range(len(TABLES)))
def test_a_table_is_refused(sheet, run, text):
    (sheet.parent / "load300" / "07.csv").write_text(text)
    assert TABLES[text] in refused(run, "fit", str(sheet))


def test_a_point_is_no_decimal_sign_where_that_is_a_comma(sheet, run):
    """1.234 may be 1234, so it is refused; points in a header are not."""
    values = yaml.safe_load(sheet.read_text())
    values["measurements"] |= {"separator": ";", "decimal": ","}
    sheet.write_text(yaml.safe_dump(values))
    for path in (sheet.parent / "load300").iterdir():
        rows = path.read_text().replace("rpm,mN m", "rpm,version 1.2").replace(",", ";").replace(".", ",")
        path.write_text(rows.replace("1,2", "1.2", 1))
    assert run("fit", str(sheet))[0] == 0
    with path.open("a") as file:
        file.write("1.234;5,0\n")
    assert "has a point in '1.234', where the decimal sign is a comma" in refused(run, "fit", str(sheet))


def test_what_speeds_and_known_numbers_leave_to_fit(tmp_path, run):
    """Two points for one coefficient and the zero of the torque leave no error; three do."""
    known = {"friction": {"stribeck_rise": 0, "slope": "0 s/m"}}
    known |= {"bearing": {"coulomb": "24 mN*m", "viscous": "0 N*m*s/rad"}}
    path = write_tables(tmp_path / "known", [300.0], [-10.0, 10.0, 10.1], **known)
    code, out, _ = run("fit", str(path), "--json")
    assert (code, '"friction_coefficient": 0.1' in out) == (0, True)
    known |= {"friction": {"coefficient": 0.15, **known["friction"]}, "offset": "0 N*m"}
    assert "nothing is left to fit" in refused(run, "fit", str(write_tables(tmp_path / "all", **known)))
    error = refused(run, "fit", str(write_tables(tmp_path / "one", [300.0], [-10.0, 10.0])))
    assert "1 speed for the 4 unknown numbers" in error
    assert "measure at more speeds, or give some of" in error
    few = write_tables(tmp_path / "few", [300.0], SPEEDS[:4])
    assert "4 points for 6 unknown numbers" in refused(run, "fit", str(few))


def test_binary_and_what_is_no_file_are_refused(sheet, run):
    (sheet.parent / "load300" / "07.csv").write_bytes(bytes(range(256)) * 4)
    refused(run, "fit", str(sheet))
    assert "none.yaml" in refused(run, "fit", "none.yaml")
    Path("folder").mkdir()
    assert "folder" in refused(run, "fit", "folder")
