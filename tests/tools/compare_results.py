"""Compare two folders of results: ``python tests/tools/compare_results.py OLD NEW``.

Datasets are compared variable by variable, bit for bit, with dimensions, types and attributes but those that say when
and from what a file was made; all other files byte by byte. Prints one line for each difference; the exit code is 1 if
there is one.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from lsvib.datasets.io import provenance

PROVENANCE = set(provenance("anything"))  # the attributes of a file that name its origin, not its content


def files(folder: Path) -> dict[str, Path]:
    """The files of a folder that hold content, by name; what stands below engine are markers of the compiled engine."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path for path in found if "engine" not in path.parts}


def content(attributes: dict) -> dict:
    return {key: repr(np.asarray(value).tolist()) for key, value in attributes.items() if key not in PROVENANCE}


def differences(old: Path, new: Path) -> Iterator[str]:
    """Say in which two files differ."""
    if old.suffix != ".nc":
        if old.read_bytes() != new.read_bytes():
            yield "the bytes differ"
        return
    with xr.open_dataset(old, decode_cf=False) as first, xr.open_dataset(new, decode_cf=False) as second:
        if content(first.attrs) != content(second.attrs):
            yield "other attributes"
        for name in sorted({*first.variables, *second.variables}, key=str):
            if name not in first.variables or name not in second.variables:
                yield f"{name} is only in the {'old' if name in first.variables else 'new'} dataset"
                continue
            a, b = first[name].variable, second[name].variable
            if (a.dims, a.shape, a.dtype, content(a.attrs)) != (b.dims, b.shape, b.dtype, content(b.attrs)):
                yield f"{name} has other dimensions, another type or other attributes"
            elif a.values.tobytes() != b.values.tobytes():
                apart = np.nanmax(np.abs(a.values - b.values)) if a.dtype.kind == "f" else ""
                yield f"{name} differs in {np.count_nonzero(a.values != b.values)} of {a.size} values {apart}"


def main() -> None:
    """Compare the folders of the command line."""
    old, new = (files(Path(folder)) for folder in sys.argv[1:3])
    found = [
        f"{name}: only in the {'old' if name in old else 'new'} results" for name in sorted(old.keys() ^ new.keys())
    ]
    found += [
        f"{name}: {words}" for name in sorted(old.keys() & new.keys()) for words in differences(old[name], new[name])
    ]
    print("\n".join([*found, f"{len(found)} differences in {len(old)} files"]))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
