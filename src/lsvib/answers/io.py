"""The one place that writes and reads datasets: CF-1.11 netCDF-4, complete metadata, whole files only; or as tables.

A file says what made it: package version, git commit and its date, library versions; so equal runs give equal files.
Tables are of pandas: as CSV, as JSON, and on the screen. Headings are names with units, ``time [s]``.
"""

import json
import math
import os
import platform
import re
import shutil
import subprocess
from collections import defaultdict
from collections.abc import Iterator
from importlib.metadata import metadata, version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import CONVENTIONS
from lsvib.answers.spans import evenly_chosen
from lsvib.errors import InputError, LsvibError
from lsvib.files import replacing, uninterrupted
from lsvib.words import table as in_columns

_UNITS = re.compile(r"1|[A-Za-z]+-?\d*( [A-Za-z]+-?\d*)*")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_ATTRIBUTE_TYPES = (str, int, float, np.integer, np.floating, np.ndarray, list, tuple)
_LIBRARIES = ("numpy", "numba", "xarray", "netCDF4")


def write_dataset(dataset: xr.Dataset, path: str | os.PathLike[str], maker: str = "lsvib") -> None:
    """Write ``dataset`` to ``path`` as CF-1.11 netCDF-4, whole or not at all, and re-open it to be sure.

    It brings the global attributes ``title``, ``source`` and ``references``, and for every variable ``units`` (UDUNITS
    syntax, "1" if dimensionless) and ``long_name``; categories are ``int8`` with flags. A coordinate without dimensions
    is written as a variable, because xarray would put it into the title of every plot. Added here are ``Conventions``,
    ``summary`` and ``keywords`` unless it brings them, and :func:`provenance`, whose ``history`` names the ``maker``, a
    function. Raises ``InputError`` if it breaks one of these rules, ``LsvibError`` if the file cannot be written.
    """
    path = Path(path)
    for key in ("title", "source", "references"):
        if not isinstance(dataset.attrs.get(key), str) or not dataset.attrs[key]:
            raise InputError(f"{path.name}: the global attribute {key} is missing.")
    dataset = dataset.reset_coords([name for name, own in dataset.coords.items() if not own.ndim])
    for name in dataset.variables:
        problem = _problem(str(name), dataset.variables[name], is_coordinate=name in dataset.coords)
        if problem:
            raise InputError(f"{path.name}: the variable {name} {problem}.")
    own = {"summary": _summary(dataset), "keywords": metadata("lsvib")["Keywords"].replace(",", ", ")} | dataset.attrs
    complete = dataset.drop_encoding().assign_attrs(own, Conventions=CONVENTIONS, **provenance(maker))
    encoding = {name: _encoding(variable) for name, variable in dataset.variables.items()}
    with replacing(path) as (part,):
        try:
            with uninterrupted():  # of a write that is cut short the library keeps its lock for ever
                complete.to_netcdf(part, engine="netcdf4", format="NETCDF4", encoding=encoding)
            with xr.open_dataset(part, engine="netcdf4") as written:
                sizes = dict(written.sizes)
        except RuntimeError as error:
            # netCDF reports a full disk as "NetCDF: HDF error", without the reason of the system.
            raise LsvibError(f"Cannot write {path}: {error} (is the disk full?).") from error
        if sizes != dict(dataset.sizes):
            raise LsvibError(f"Cannot write {path}: the file written has sizes {sizes}, not {dict(dataset.sizes)}.")


def read_dataset(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a dataset into memory; raises ``InputError`` if the file is missing or is not a readable netCDF file."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path} {'is not a regular file' if path.exists() else 'does not exist'}.")
    try:
        return xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        text = str(error).rstrip(".")
        raise InputError(f"{path} is not a readable netCDF file ({text}); make it again.") from error


def _problem(name: str, variable: xr.Variable, is_coordinate: bool) -> str:
    """Say which rule the variable breaks, or nothing."""
    attributes = variable.attrs
    if not _NAME.fullmatch(name):
        return "must have a name of letters, digits and underscores"
    if variable.dtype.kind not in "if":
        return f"has the type {variable.dtype}; write numbers, and categories as int8 flags"
    texts = {key: attributes.get(key) for key in ("units", "long_name")}
    if missing := [key for key, text in texts.items() if not isinstance(text, str) or not text]:
        return f"has no {missing[0]}"
    if not _UNITS.fullmatch(attributes["units"]):
        return f'has units {attributes["units"]!r}, which are not in the form "kg m2 s-1", or "1"'
    for key, value in attributes.items():
        if isinstance(value, (bool, np.bool_)) or not isinstance(value, _ATTRIBUTE_TYPES):
            return f"has the attribute {key} of type {type(value).__name__}; write text or numbers"
    if is_coordinate and variable.dtype.kind == "f" and bool(np.isnan(variable.values).any()):
        return "is a coordinate and has missing values"
    values, meanings = attributes.get("flag_values"), attributes.get("flag_meanings")
    if variable.dtype != np.int8 and values is None and meanings is None:
        return ""
    if variable.dtype != np.int8 or values is None or not isinstance(meanings, str):
        return "is a flag variable, which needs the type int8, flag_values and flag_meanings"
    words = meanings.split()
    unlike = len({*words}) == np.unique(values).size == np.size(values) == len(words)
    if np.asarray(values).dtype != np.int8 or not unlike:
        return "needs distinct flag_values of type int8, one for each word of flag_meanings"
    # One value after the other: np.isin would take eight bytes for each of the hundreds of millions of cells of a map.
    if sum(np.count_nonzero(variable.values == value) for value in np.atleast_1d(values)) < variable.size:
        return "contains a value that is not in flag_values"
    return ""


def _summary(dataset: xr.Dataset) -> str:
    """Return in words what a file holds: its title, and what it has over which dimensions."""
    found = defaultdict[tuple[Any, ...], list[str]](list)
    for own in dataset.data_vars.values():
        found[own.dims].append(own.attrs["long_name"])
    parts = [f"Over {', '.join(dims)}: {'; '.join(words)}." for dims, words in found.items() if dims]
    return " ".join([f"{dataset.attrs['title']}.", *parts])


def _encoding(variable: xr.Variable) -> dict[str, Any]:
    """Encode without fill value unless values are missing, which no coordinate's are (CF); compress what is big."""
    missing = variable.dtype.kind == "f" and bool(np.isnan(variable.values).any())
    encoding: dict[str, Any] = {"_FillValue": variable.dtype.type(np.nan) if missing else None}
    if variable.size >= 1024:  # below that, compression costs more bytes than it saves
        encoding |= {"zlib": True, "complevel": 4, "shuffle": True}
    if variable.ndim and variable.size:  # a scalar has no chunk that could have a checksum
        encoding["fletcher32"] = True
    return encoding


def rows_of(item: str, rows: int) -> slice:
    """Return the rows of the tile ``item`` ("3-of-6", counted from 1) of a map of so many ``rows``."""
    number, tiles = (int(word) for word in item.split("-of-"))
    if tiles > rows:
        raise InputError(f"tiles = {tiles} is outside the allowed range 1 <= tiles <= {rows}, the number of rows.")
    return slice((number - 1) * rows // tiles, number * rows // tiles)


def provenance(maker: str) -> dict[str, str]:
    """Return attributes that name the code, and in ``history`` the ``maker``, a function.

    ``git_commit`` and ``git_dirty`` are ``"unknown"`` where no repository tracks the package; ``date_created``, the
    date of the commit, is then left out.
    """
    versions = {"python": platform.python_version(), **{name: version(name) for name in _LIBRARIES}}
    return {
        "history": f"made by {maker}, lsvib {version('lsvib')}",
        "lsvib_version": version("lsvib"),
        **_git_state(Path(__file__).resolve()),
        "package_versions": json.dumps(versions),
    }


def _git_state(tracked: Path) -> dict[str, str]:
    def git(*arguments: str) -> str:
        command = ["git", "-C", str(tracked.parent), *arguments]
        return subprocess.run(command, capture_output=True, check=True, text=True).stdout.strip()

    try:
        # An installed copy may lie inside somebody else's repository: ask for the commit only if it tracks this file.
        git("ls-files", "--error-unmatch", tracked.name)
        commit, date = git("log", "-1", "--format=%H %cI").split()
        dirty = bool(git("status", "--porcelain", "--untracked-files=no"))
        return {"git_commit": commit, "git_dirty": str(dirty).lower(), "date_created": date}
    except (OSError, subprocess.CalledProcessError):
        return {"git_commit": "unknown", "git_dirty": "unknown"}


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
        yield f"{left} rows between these are omitted; --json and {file} give all"
