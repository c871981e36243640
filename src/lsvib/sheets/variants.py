"""Variants of a data sheet in a table, a row each, and what is said of them, a row each again.

Columns are entries of a sheet, such as ``load.mass``, with the unit in the cells or in the heading, ``load.mass [kg]``
or ``load.mass (kg)``. Where semicolons or tabs part the cells, a comma in a number is the decimal sign.
"""

import copy
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import pandas as pd  # type: ignore[import-untyped]
import yaml

from lsvib import numbers
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError, LsvibError
from lsvib.sheets.output import assess

ON_SCREEN = ["name", "verdict", "limit_used", "exceeded", "lifting_torque", "lifting_efficiency", "refused"]


def assess_variants(
    path: Path, base: Path | None = None, samples: Any = 64, seed: Any = 1, progress: numbers.Progress | None = None
) -> pd.DataFrame:
    """Return the rows of a CSV file with what is said of each, or why it is ``refused``.

    ``base``: the YAML file of a sheet that has what the table leaves out; a cell ``null`` takes an entry of it away.
    Raises ``InputError`` if the file is no table, or all rows are refused for one reason.
    """
    sheet, found = read_yaml(base) if base else {}, []
    for about in ("sources", "assumptions"):  # of entries that a variant may not have
        sheet.pop(about, None)
    try:
        text = path.read_text(encoding="utf-8-sig")
        parted = next((sign for sign in ";\t" if sign in text.partition("\n")[0]), ",")
        rows = pd.read_csv(StringIO(text), sep=parted, dtype=str, keep_default_na=False, skipinitialspace=True)
    except (OSError, ValueError) as error:  # pandas raises many kinds of the latter
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()).rstrip(".")
        raise InputError(f"Cannot read {path}: {reason}.") from None
    if parted != ",":
        rows = rows.replace(r"^(-?\d+),(\d+)(?![\d,.])", r"\1.\2", regex=True)
    if not isinstance(rows.index, pd.RangeIndex):
        raise InputError(f"{path} is not a table: its rows have more cells than the first line has headings.")
    for count, cells in enumerate(rows.to_dict("records"), 1):
        row = {"name": f"row {count}", **{key: cell for key, cell in cells.items() if cell or key != "name"}}
        try:
            found.append({**row, "refused": None, **_said(assess(_variant(sheet, row), None, samples, seed))})
        except LsvibError as error:
            found.append({**row, "refused": str(error)})
        if progress:
            progress(count, len(rows))
    refused = {row["refused"] for row in found} or {"there are none."}
    if len(refused) == 1 and (reason := refused.pop()):
        raise InputError(f"All variants in {path} are refused: {reason}")
    return pd.DataFrame(found)


def _variant(base: Mapping[str, Any], cells: Mapping[str, str]) -> dict[str, Any]:
    """The names and values of the sheet of one row."""
    values = copy.deepcopy(dict(base))
    for heading, cell in cells.items():
        path, _, unit = heading.strip().replace("(", "[", 1).removesuffix("]").removesuffix(")").partition("[")
        *parts, last = path.strip().split(".")
        place = values
        for part in parts:
            if not isinstance(place.get(part), dict):  # nothing, or contact: rigid
                place[part] = {}
            place = place[part]
        if cell == "null":
            place.pop(last, None)
        elif cell:
            place[last] = _value(cell, unit)
    return _with_entries(values)


def _with_entries(values: dict[str, Any]) -> dict[str, Any]:
    """Leave out the parts that have no entry, as all of their cells are empty."""
    inner = {key: _with_entries(value) if isinstance(value, dict) else value for key, value in values.items()}
    return {key: value for key, value in inner.items() if value != {}}


def _value(cell: str, unit: str) -> Any:
    """What a cell holds, as in a sheet; a number gets the unit of its heading."""
    try:
        value = yaml.safe_load(cell)
    except yaml.YAMLError:
        return cell
    if isinstance(value, list):
        return [_value(str(one), unit) for one in value]
    return f"{cell} {unit}" if unit and isinstance(value, int | float) else value


def _said(result: Mapping[str, Any]) -> dict[str, Any]:
    """The answers by which an engineer sorts: worst values of statics, the largest share of a limit that is used."""
    rows = {key: row for key, row in result["statics"].items() if isinstance(row, Mapping)}
    back = result["statics"]["back_drives"]
    found = {key: result[key] for key in ("verdict", "sentence")} | {"back_drives": "no" if back is False else back}
    if result["vibration"] is not None:
        near, one = min(result["mechanisms"].items(), key=lambda item: item[1]["reserve"])
        found |= {"probability": result["any_mechanism"]["probability"], "mechanism": near, "reserve": one["reserve"]}
        found |= {"even_speed [m/s]": result["from_rest"]["even_load_speed"]}
        found |= {"frequency [Hz]": result["nominal"]["frequency"], "amplitude [m]": result["nominal"]["amplitude"]}
    limited = [row for key, row in rows.items() if row["limit"] and row["worst"] and key != "holding_friction"]
    found |= {"limit_used": max((row["worst"] / row["limit"] for row in limited), default=None)}
    found |= {"exceeded": "; ".join(key for key, row in rows.items() if row["exceeded"])}
    return found | {f"{key} [{row['unit']}]".removesuffix(" [1]"): row["worst"] for key, row in rows.items()}
