"""Compare two folders of results: ``python tests/tools/compare_results.py OLD NEW``.

Datasets are compared variable by variable, bit for bit, with dimensions, types and attributes but those that say when
and from what a file was made; checks and verdicts by their values; pictures and all other files byte by byte. Prints
one line for each difference and how much was compared; the exit code is 1 if there is a difference.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import netCDF4
import numpy as np

from lsvib.data.provenance import provenance

PROVENANCE = set(provenance("anything"))  # the attributes of a file that name its origin, not its content
MADE_BESIDE = {"engine", "engine.txt"}  # markers of the compiled engine: digests of its source


def differences(old: Path, new: Path) -> Iterator[str]:
    """Yield a line for each difference between two folders of results."""
    names = {folder: {str(path.relative_to(folder)) for path in files(folder)} for folder in (old, new)}
    for name in sorted(names[old] | names[new]):
        if name not in names[new]:
            yield f"{name}: only in the old results"
        elif name not in names[old]:
            yield f"{name}: only in the new results"
        else:
            yield from (f"{name}: {words}" for words in compared(old / name, new / name))


def files(folder: Path) -> list[Path]:
    """Return the files of a folder of results that hold content."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return [path for path in found if path.relative_to(folder).parts[0] not in MADE_BESIDE]


def compared(old: Path, new: Path) -> Iterator[str]:
    """Yield the differences of two files, by their kind."""
    if old.suffix == ".nc":
        with netCDF4.Dataset(old) as first, netCDF4.Dataset(new) as second:
            yield from datasets(first, second)
    elif old.suffix == ".json":
        yield from values("", json.loads(old.read_text("utf-8")), json.loads(new.read_text("utf-8")))
    elif old.read_bytes() != new.read_bytes():
        yield "the bytes differ"


def datasets(old: netCDF4.Dataset, new: netCDF4.Dataset) -> Iterator[str]:
    """Yield the differences of two datasets."""
    yield from attributes("", old, new)
    for name in sorted(old.variables.keys() | new.variables.keys()):
        if name not in new.variables or name not in old.variables:
            yield f"{name} is only in the {'old' if name in old.variables else 'new'} dataset"
            continue
        first, second = old.variables[name], new.variables[name]
        first.set_auto_maskandscale(False)
        second.set_auto_maskandscale(False)
        if (first.dimensions, first.shape, first.dtype) != (second.dimensions, second.shape, second.dtype):
            yield f"{name} has other dimensions or another type"
            continue
        yield from attributes(name, first, second)
        a, b = np.asarray(first[...]), np.asarray(second[...])
        if a.tobytes() == b.tobytes() if a.dtype != object else (a == b).all():
            continue
        unequal = ~(a == b) if a.dtype == object else a.view(f"V{a.itemsize}") != b.view(f"V{a.itemsize}")
        words = f"{name} differs in {np.count_nonzero(unequal)} of {a.size} values"
        if a.dtype.kind == "f":
            gap = np.nanmax(np.abs(a - b), initial=0.0)
            words += f", by at most {gap:g}"
        yield words


def attributes(name: str, old, new) -> Iterator[str]:
    """Yield the attributes in which two variables or datasets differ, but those of the origin."""
    for key in sorted({*old.ncattrs(), *new.ncattrs()} - PROVENANCE):
        a, b = ((owner.getncattr(key) if key in owner.ncattrs() else None) for owner in (old, new))
        same = np.asarray(a).tobytes() == np.asarray(b).tobytes() if isinstance(a, np.generic | np.ndarray) else a == b
        if type(a) is not type(b) or not same:
            yield f"{name or 'the file'}: attribute {key} was {a!r} and is {b!r}"


def values(place: str, old: object, new: object) -> Iterator[str]:
    """Yield the places of two JSON values in which they differ."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in [*old, *(key for key in new if key not in old)]:
            missing = object()
            yield from values(f"{place}.{key}", old.get(key, missing), new.get(key, missing))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, pair in enumerate(zip(old, new, strict=True)):
            yield from values(f"{place}[{k}]", *pair)
    elif old != new or type(old) is not type(new):
        texts = [
            value if isinstance(value, str | int | float | list | dict | None) else "absent" for value in (old, new)
        ]
        yield f"{place} was {texts[0]!r} and is {texts[1]!r}"


def main() -> None:
    """Compare the folders of the command line."""
    if len(sys.argv) != 3:
        sys.exit("usage: python tests/tools/compare_results.py OLD NEW")
    old, new = map(Path, sys.argv[1:])
    for folder in (old, new):
        if not files(folder):
            sys.exit(f"{folder} holds no results.")
    found = list(differences(old, new))
    print("\n".join([*found, f"{len(found)} differences in {len(files(old))} files"]))
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
