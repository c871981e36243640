"""Variables of datasets with their attributes, of whatever they are: CF-1.11.

Functions return variables ``(dimensions, values, attributes)`` as ``xarray.Dataset`` takes them.
"""

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from lsvib import __version__

Dims = str | tuple[str, ...]
Variable = tuple[Dims, Any, dict[str, Any]]  # as xarray.Dataset takes one
Variables = dict[str, Variable]
Words = Iterable[IntEnum] | Mapping[int, str] | Sequence[str]
CONVENTIONS = "CF-1.11"


def answer(found: Variables, coordinates: Variables, about: Mapping[str, Any]) -> xr.Dataset:
    """Return what was found as a dataset that says what made it and is CF, which has no fill values on coordinates."""
    made = {"Conventions": CONVENTIONS, "history": f"made by lsvib {__version__}", "lsvib_version": __version__}
    return xr.Dataset(found, {n: (*own, {"_FillValue": None}) for n, own in coordinates.items()}, {**about, **made})


def flags(words: Words, none: bool = False) -> dict[str, Any]:
    """Return the CF attributes of numbers that words name, ``flag_values`` and ``flag_meanings``.

    ``words``: members of an ``IntEnum``, or words by their number, or words in the order of numbers from zero;
    blanks in them become ``_``; ``none``: −1 for none of them.
    """
    known: Mapping[int, Any] = words if isinstance(words, Mapping) else dict(enumerate(words))
    pairs = [(int(w), w.name.lower()) if isinstance(w, IntEnum) else (k, w) for k, w in known.items()]
    named = dict(pairs) | ({-1: "none"} if none else {})
    meanings = ("_".join(word.split()) for word in named.values())
    return {"flag_values": np.array(list(named), dtype=np.int8), "flag_meanings": " ".join(meanings)}


def attributes(units: str, long_name: str, symbol: str = "", **more: Any) -> dict[str, Any]:
    """Return the attributes of a variable; an empty symbol is left out."""
    return {"units": units, "long_name": long_name, **({"symbol": symbol} if symbol else {}), **more}


def variable(dims: Dims, values: Any, units: str, long_name: str, symbol: str = "", **more: Any) -> Variable:
    """Return a variable: its dimensions, values of any shape that these have, and :func:`attributes`."""
    return dims, values, attributes(units, long_name, symbol, **more)


def columns(dims: Dims, table: Mapping[str, tuple[Any, ...]], shape: Any = (-1,)) -> Variables:
    """Return variables by name from their values, units, long names and perhaps symbols."""
    return {name: variable(dims, np.reshape(own, shape), *more) for name, (own, *more) in table.items()}


def flagged(dims: Dims, values: Any, long_name: str, words: Words, **more: Any) -> Variable:
    """Return a variable of numbers that words name, as int8 with :func:`flags`."""
    return dims, np.asarray(values, dtype=np.int8), attributes("1", long_name, **flags(words), **more)


def flag_names(variable: xr.DataArray) -> dict[int, str]:
    """Return the words of a flag variable by value, with spaces: ``{0: "stable node", …}``."""
    words = [word.replace("_", " ") for word in variable.attrs["flag_meanings"].split()]
    # A single flag comes back from a file as a scalar.
    return dict(zip((int(value) for value in np.atleast_1d(variable.attrs["flag_values"])), words, strict=True))


def named(variable: xr.DataArray, *words: str) -> np.ndarray:
    """Return where a flag variable has one of the meanings ``words``, such as ``"stable node"``."""
    values = {name: value for value, name in flag_names(variable).items()}
    return np.isin(variable.values, [values[word] for word in words])


def counted(flags: xr.DataArray) -> dict[str, int]:
    """Return how many values of a flag variable have each of its words, for the words that occur."""
    meanings = zip(flags.attrs["flag_meanings"].split(), flags.attrs["flag_values"], strict=True)
    return {word: n for word, value in meanings if (n := int(np.count_nonzero(flags.values == value)))}


def yes_no(dims: Dims, values: Any, long_name: str) -> Variable:
    """Return a variable that is 1 where a statement is true, else 0, as int8 with flags."""
    return flagged(dims, values, long_name, ("no", "yes"))


def named_index(dim: str, long_name: str, words: Sequence[str], **more: Any) -> Variable:
    """Return the coordinate along ``dim`` of things that have names: their index, whose flags are the names."""
    return flagged(dim, range(len(words)), long_name, words, **more)
