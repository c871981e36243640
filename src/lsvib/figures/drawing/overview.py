"""A large map or chart as one that a picture has room for."""

import os

import xarray as xr

from lsvib.errors import InputError


def overview(path: str | os.PathLike[str], most: int = 1000) -> xr.Dataset:
    """Return a map with at most ``most`` rows and columns: of each block of cells the one in its middle.

    The coordinates are the middles of the blocks, whose sides are odd numbers of cells, and ``cell_width`` is theirs;
    cells beyond the last whole block are left out. ``fraction`` remains that of all cells. Raises ``InputError`` if the
    file cannot be read.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4", cache=False) as whole:
            steps = {dim: -(-whole.sizes[dim] // most) | 1 for dim in whole["label"].dims}
            middles = {dim: slice(n // 2, whole.sizes[dim] // n * n, n) for dim, n in steps.items()}
            coarse = whole.isel(middles).load()
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise InputError(f"{path} is not a readable map: {error}.") from error
    for dim, step in steps.items():
        attrs = coarse[dim].attrs
        if "cell_ratio" in attrs:  # cells of equal ratio, not of equal width
            attrs["cell_ratio"] **= step
        else:
            attrs["cell_width"] *= step
    return coarse
