"""One large dataset over rows and columns from the files of its tiles, one tile at a time.

A tile is a dataset of its own, written whole or not at all, in any order and by any number of processes. The
whole may be larger than memory, because nothing here holds more than a tile, or one row of its compressed blocks.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np
import xarray as xr

from lsvib.data.attributes import attributes
from lsvib.data.writer import write_dataset
from lsvib.errors import InputError, LsvibError
from lsvib.files import replacing
from lsvib.numbers import Progress

_CHUNK = 512  # cells along each side of a compressed block of the map, at most


class TilePlace(NamedTuple):
    """The cells of one tile: rows ``first_row`` to ``last_row`` - 1, columns likewise."""

    first_row: int
    last_row: int
    first_column: int
    last_column: int

    @property
    def rows(self) -> slice:
        """Rows of the map."""
        return slice(self.first_row, self.last_row)

    @property
    def columns(self) -> slice:
        """Columns of the map."""
        return slice(self.first_column, self.last_column)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of columns."""
        return self.last_row - self.first_row, self.last_column - self.first_column


def write_tile(cells: xr.Dataset, place: TilePlace, settings: Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    """Write a tile: its dataset (variables over rows and columns), its place in the map, and the map's settings.

    Raises ``InputError`` and ``LsvibError`` like :func:`lsvib.data.writer.write_dataset`.
    """
    write_dataset(cells.assign_attrs(window=np.array(place), settings=_text(settings)), path)


def gather(
    frame: xr.Dataset,
    settings: Mapping[str, Any],
    tiles: Mapping[Path, TilePlace],
    path: str | os.PathLike[str],
    progress: Progress | None = None,
    kinds: str = "attractor",
) -> None:
    """Write the map whose tiles are in the files ``tiles``, whole or not at all, in chunks and compressed.

    ``frame`` holds all of the map but its cells: coordinates of its rows and columns, the drive, lines, attractors.
    The windows must cover each cell once. Added are ``cell_count`` and ``fraction`` of each label, along ``kinds``, and
    ``content_digest`` (:func:`content_digest`). ``progress`` is told how many of how many tiles are written. Raises
    ``InputError`` if a tile is missing, damaged or of another map; ``LsvibError`` if the map cannot be written.
    """
    headers = {tile: _header(tile, place, _text(settings)) for tile, place in tiles.items()}
    variables = _same_variables(headers)
    missing = set().union(*(header.missing for header in headers.values()))
    chunks = tuple(map(_chunk, next(iter(tiles.values())).shape))
    with replacing(path) as part:
        write_dataset(_with_counts(frame, variables["label"].attrs, kinds).assign_attrs(settings=_text(settings)), part)
        try:
            with netCDF4.Dataset(part, "a") as file:
                for name, variable in variables.items():
                    _create(file, name, variable, chunks, name in missing)
                counts = np.zeros(file["cell_count"].size, np.int64)
                for done, (tile, place) in enumerate(tiles.items(), 1):
                    cells = _read(tile, variables)
                    for name, values in cells.items():
                        file[name][place.rows, place.columns] = values
                    counts += [np.count_nonzero(cells["label"] == value) for value in file[kinds][:]]
                    if progress:
                        progress(done, len(tiles))
                file["cell_count"][:] = counts
                file["fraction"][:] = counts / counts.sum()
            digest = content_digest(part)
            with netCDF4.Dataset(part, "a") as file:
                file.content_digest = digest
        except RuntimeError as error:
            raise LsvibError(f"Cannot write {path}: {error} (is the disk full?).") from error


def content_digest(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 digest of the values of a dataset: of each variable its name, type, shape and elements.

    Neither attributes nor the way in which the file stores the values enter, so maps that agree in every bit of every
    value have the same digest, however they were tiled or compressed. Reads one row of blocks at a time. Raises
    ``InputError`` if the file cannot be read.
    """
    total = hashlib.sha256()
    with _opened(Path(path)) as file:
        for name, variable in sorted(file.variables.items()):
            total.update(f"{name} {variable.dtype.str} {variable.shape}\n".encode())
            for block in _blocks(variable):
                total.update(np.ascontiguousarray(block).tobytes())
    return total.hexdigest()


def overview(path: str | os.PathLike[str], most: int = 1000) -> xr.Dataset:
    """Return a map with at most ``most`` rows and columns: of each block of cells the one in its middle.

    A picture has no room for more. The coordinates are the middles of the blocks and ``cell_width`` is theirs; cells
    beyond the last whole block are left out. ``cell_count`` and ``fraction`` remain those of all cells. The rest of the
    file is read in its compressed blocks and forgotten. Raises ``InputError`` if the file cannot be read.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4", cache=False) as whole:
            sizes = {dim: whole.sizes[dim] for dim in whole["label"].dims}
            steps = {dim: -(-size // most) for dim, size in sizes.items()}
            middles = {dim: slice(step // 2, sizes[dim] // step * step, step) for dim, step in steps.items()}
            coarse = whole.isel(middles).load()
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise InputError(f"{path} is not a readable map: {error}.") from error
    for dim, step in steps.items():
        given = coarse[dim].attrs
        between_cells = step % 2 == 0  # of an even number of cells, the one after the middle is taken
        if "cell_ratio" in given:  # cells of equal ratio, not of equal width
            values = coarse[dim].values * given["cell_ratio"] ** (-0.5 * between_cells)
            more = {"cell_ratio": given["cell_ratio"] ** step}
        else:
            values = coarse[dim].values - 0.5 * given["cell_width"] * between_cells
            more = {"cell_width": given["cell_width"] * step}
        coarse = coarse.assign_coords({dim: (dim, values, {**given, **more})})
    return coarse


class _Header(NamedTuple):
    """What is known of a tile without its cells."""

    variables: dict[str, xr.Variable]
    missing: set[str]  # variables with missing values


def _text(settings: Mapping[str, Any]) -> str:
    return json.dumps(settings, sort_keys=True)


@contextmanager
def _opened(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a file for reading stored values as they are; what goes wrong becomes one sentence."""
    if not path.is_file():
        raise InputError(f"{path} does not exist.")
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            yield file
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path} is damaged ({error}); delete it, and it will be computed again.") from error


def _blocks(variable: netCDF4.Variable) -> Iterator[np.ndarray]:
    """Yield the elements in their order, one row of compressed blocks at a time."""
    if variable.ndim == 0:
        yield variable[...]
        return
    chunks = variable.chunking()
    rows = variable.shape[0] if chunks == "contiguous" else chunks[0]
    for first in range(0, variable.shape[0], rows):
        yield variable[first : first + rows]


def _header(path: Path, place: TilePlace, settings: str) -> _Header:
    with _opened(path) as file:
        if getattr(file, "settings", "") != settings or tuple(getattr(file, "window", ())) != place:
            raise InputError(f"{path} is no tile of this map; delete it, and it will be computed again.")
        variables = {
            name: xr.Variable(variable.dimensions, np.empty((0, 0), variable.dtype), _attributes(variable))
            for name, variable in file.variables.items()
            if variable.ndim == 2
        }
        return _Header(variables, {name for name in variables if "_FillValue" in file[name].ncattrs()})


def _read(path: Path, names: Iterable[str]) -> dict[str, np.ndarray]:
    with _opened(path) as file:
        return {name: file[name][:] for name in names}


def _attributes(variable: netCDF4.Variable) -> dict[str, Any]:
    return {key: variable.getncattr(key) for key in variable.ncattrs() if key != "_FillValue"}


def _same_variables(headers: Mapping[Path, _Header]) -> dict[str, xr.Variable]:
    """Return the variables of the first tile, which must be those of every tile."""
    (first, header), *others = headers.items()
    for path, other in others:
        if _signature(other) != _signature(header):
            raise InputError(f"{path} holds other variables than {first}; delete both to have them computed again.")
    return header.variables


def _signature(header: _Header) -> dict[str, tuple]:
    return {name: (variable.dims, variable.dtype) for name, variable in header.variables.items()}


def _with_counts(frame: xr.Dataset, labels: Mapping[str, Any], kinds: str) -> xr.Dataset:
    """Add room for the number and the fraction of the cells with each label, along a dimension ``kinds``."""
    flags = {key: labels[key] for key in ("flag_values", "flag_meanings")}
    counts = np.zeros(np.size(flags["flag_values"]), np.int64)
    return frame.assign_coords({kinds: (kinds, flags["flag_values"], attributes("1", kinds, **flags))}).assign(
        cell_count=(kinds, counts, attributes("1", "number of the cells")),
        fraction=(kinds, counts + 0.0, attributes("1", "fraction of the cells")),
    )


def _create(
    file: netCDF4.Dataset, name: str, variable: xr.Variable, chunks: tuple[int, ...], has_missing: bool
) -> None:
    created = file.createVariable(
        name,
        variable.dtype,
        variable.dims,
        compression="zlib",
        shuffle=True,
        chunksizes=chunks,
        fill_value=np.nan if has_missing else False,
    )
    created.setncatts(variable.attrs)
    created.set_auto_maskandscale(False)


def _chunk(side: int) -> int:
    """Side of the compressed blocks in a tile of a given side: a divisor of it where there is one of the right size."""
    return -(-side // -(-side // _CHUNK))
