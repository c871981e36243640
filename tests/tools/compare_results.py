"""Compare two folders of results: ``python tests/tools/compare_results.py OLD NEW [TOLERANCE]``.

Datasets are compared variable by variable, with dimensions, types and attributes but those that say when and from what
a file was made: to the tolerance times the largest value of each variable, bit for bit without one; all other files
byte by byte. Prints one line for each difference; the exit code is 1 if there is one.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from lsvib.datasets.io import provenance

PROVENANCE = set(provenance("anything"))  # the attributes of a file that name its origin, not its content


def content(attributes: dict) -> dict:
    return {key: repr(np.asarray(value).tolist()) for key, value in attributes.items() if key not in PROVENANCE}


def differences(old: Path, new: Path, tolerance: float) -> Iterator[str]:
    """Say in what two files differ."""
    if not (old.is_file() and new.is_file()):
        yield f"only in the {'old' if old.is_file() else 'new'} results"
    elif old.suffix != ".nc":
        if old.read_bytes() != new.read_bytes():
            yield "the bytes differ"
    else:
        with xr.open_dataset(old, decode_cf=False) as first, xr.open_dataset(new, decode_cf=False) as second:
            if content(first.attrs) != content(second.attrs):
                yield "other attributes"
            for name in sorted({*first.variables, *second.variables}, key=str):
                both = [d[name].variable for d in (first, second) if name in d.variables]
                if len(both) < 2:
                    yield f"{name} is only in the {'old' if name in first.variables else 'new'} dataset"
                    continue
                a, b = both
                if (a.dims, a.shape, a.dtype, content(a.attrs)) != (b.dims, b.shape, b.dtype, content(b.attrs)):
                    yield f"{name} has other dimensions, another type or other attributes"
                elif a.values.tobytes() != b.values.tobytes():
                    apart = np.abs(a.values - b.values) if a.dtype.kind == "f" else np.array(np.inf)
                    same = (np.isnan(a.values) == np.isnan(b.values)).all() if a.dtype.kind == "f" else False
                    if not (same and np.nanmax(apart) <= tolerance * np.nanmax(np.abs(a.values))):
                        count = np.count_nonzero(a.values != b.values)
                        yield f"{name} differs in {count} of {a.size} values, by {np.nanmax(apart)}"


if __name__ == "__main__":
    old, new, tolerance = Path(sys.argv[1]), Path(sys.argv[2]), float([*sys.argv, 0][3])
    names = {path.relative_to(root) for root in (old, new) for path in root.rglob("*") if path.is_file()}
    names = {name for name in names if "engine" not in name.parts}  # markers of the compiled engine
    found = [f"{name}: {words}" for name in sorted(names) for words in differences(old / name, new / name, tolerance)]
    print("\n".join([*found, f"{len(found)} differences in {len(names)} files"]))
    sys.exit(bool(found))
