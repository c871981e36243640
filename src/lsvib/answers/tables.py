"""Answers as tables of pandas: as CSV, as JSON, and on the screen. Headings are names with units, ``time [s]``."""

import math
import shutil
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.spans import evenly_chosen
from lsvib.words import table as in_columns


def table_of(dataset: xr.Dataset) -> Any:
    """Return what a dataset has at each time, point or cell: the variables along the dimensions of its first one.

    Categories are words. Parameters, events and curves are left out.
    """
    dims = next(iter(dataset.data_vars.values())).dims
    own = dataset.drop_vars([name for name, one in dataset.variables.items() if one.dims != dims and name not in dims])
    table, names = own.to_dataframe(dim_order=dims).reset_index(), {}
    for name, one in [*own.coords.items(), *own.data_vars.items()]:
        if (words := one.attrs.get("flag_meanings")) is not None:
            values = np.atleast_1d(one.attrs["flag_values"]).tolist()
            table[name] = table[name].map(dict(zip(values, words.split(), strict=True)))
        names[name] = f"{name} [{one.attrs.get('units', '1')}]".removesuffix(" [1]")
    return table[list(names)].rename(columns=names)


def records(table: Any) -> list[dict[str, Any]]:
    """Return the rows of a table as plain values, None for what does not exist or is infinite."""
    plain = table.astype(object)
    return list(plain.mask(plain.isin([math.nan, math.inf, -math.inf]), None).to_dict("records"))


def on_screen(table: Any, columns: list[str], file: str) -> Iterator[str]:
    """Yield columns, named without units, of evenly spread rows where not all fit a screen; ``file`` has all."""
    names = {name.partition(" [")[0]: name for name in table}
    chosen = [names[name] for name in columns if name in names and table[names[name]].notna().any()]
    places = evenly_chosen(len(table), max(3, shutil.get_terminal_size().lines - 8))
    shown = ([row[name] for name in chosen] for row in records(table.iloc[places]))
    lines = ([f"{x:.5g}" if isinstance(x, float) else str(x or "") for x in row] for row in shown)
    yield in_columns(lines, *chosen)
    if left := len(table) - len(places):
        yield f"{left} rows between these are left out; --json and {file} have all of them"
