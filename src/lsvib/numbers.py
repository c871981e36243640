"""Numbers as people write them: one spelling for the command line, files and Python, and one limit for starts."""

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

from lsvib.errors import InputError

# A start this far out is no state of a drive; its square is still a double, so that products of two can be formed.
LARGEST_START = 1e100
_MOST_POINTS = 10_000_000  # of a sweep, of which each has some hundred bytes
# Called with the number of parts of a work that are done, and that of all.
Progress = Callable[[int, int], None]
_PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


class NotNumber(InputError):
    """A value is not a number, or not a whole one; the sentence has no name yet."""


def bisected(turned: Callable[[float], bool], low: float, high: float) -> float:
    """Return where a condition turns true between ``low``, where it is not, and ``high``, where it is, to the last bit.

    The result is one of two neighbouring doubles, that on the side of ``high``, so that the condition holds there;
    ``high`` may also be the smaller end.
    """
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (low, middle) if turned(middle) else (middle, high)
    return high


def shown(value: Any) -> str:
    """Return a value as it stands in a sentence: its ``repr`` in one line, cut off where it is long."""
    try:
        text = " ".join(repr(value).split())
    except (ValueError, RecursionError):  # integers of more than 4300 digits have no repr
        text = f"a {type(value).__name__}"
    return text if len(text) <= 60 else f"{text[:60]}..."


def number(value: Any) -> float:
    """Return a value as a double; text is a decimal number with a point, such as ``-1.5e-3``.

    Raises ``NotNumber`` for anything else: other text (``1,5``, ``1 kg``, ``nan``), truth values, lists, NaN.
    """
    if type(value) is float and value == value:  # nearly always, and quick
        return value
    if isinstance(value, str):
        if not _PLAIN.fullmatch(value.strip()):
            raise NotNumber("is not a number")
        return float(value)
    kind = getattr(getattr(value, "dtype", None), "kind", "f")  # numpy has truth values and complex numbers as well
    single = hasattr(type(value), "__float__") and getattr(value, "ndim", 0) == 0
    if not single or kind not in "iuf" or isinstance(value, bool) or getattr(value, "mask", False):
        raise NotNumber("is not a number")
    try:
        result = float(value)
    except OverflowError:  # an integer beyond the range of doubles
        return math.inf if value > 0 else -math.inf
    except (TypeError, ValueError):
        result = math.nan
    if math.isnan(result):
        raise NotNumber("is not a number")
    return result


def whole(value: Any) -> int:
    """Return a value as an integer; raises ``NotNumber`` for what is no number or, like 1.5, not a whole one."""
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    result = number(value)
    if not math.isfinite(result) or result != int(result):
        raise NotNumber("is not a whole number")
    return int(result) if isinstance(value, str) and not value.strip().lstrip("+-").isdigit() else int(value)


def whole_between(name: str, value: Any, least: int, most: int) -> int:
    """Return a value as an integer of a range; raises ``InputError`` in one sentence, with its ``name``, otherwise."""
    allowed = f"{least} <= {name.split()[-1]} <= {most}"
    try:
        result = whole(value)
    except NotNumber as error:
        raise InputError(f"{name} = {shown(value)} {error}; the allowed range is {allowed}.") from None
    if not least <= result <= most:
        raise InputError(f"{name} = {result} is outside the allowed range {allowed}.")
    return result


def workers(value: Any) -> int:
    """Return a number of threads or processes, as :func:`whole_between` does."""
    return whole_between("workers", value, 1, 4096)  # more than any machine has cores


def start(name: str, value: Any) -> float:
    """Return a coordinate of a start; raises ``InputError`` in one sentence, with its ``name``, if it is none."""
    try:
        result = number(value)
    except NotNumber as error:
        raise InputError(f"{name} = {shown(value)} {error}.") from None
    if not abs(result) < LARGEST_START:
        raise InputError(
            f"{name} = {shown(value)} is outside the allowed range "
            f"-{LARGEST_START:g} < {name.split()[-1]} < {LARGEST_START:g}."
        )
    return result


EXAMPLES = {
    "drive": ", such as mass: 11.0",
    "start": ", such as u: 0.1 and w: 0.0, or rest",
    "command": ", such as times: [0, 1] and speeds: [0, 40]",
}


def names_and_values(name: str, given: Any) -> dict[str, Any]:
    """Return a mapping of names as a dictionary, None as an empty one; ``InputError`` for anything else."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise InputError(f"{name} = {shown(given)} is not a set of names and values{EXAMPLES.get(name, '')}.")
    for key in given:
        if not isinstance(key, str):
            raise InputError(f"{shown(key)} is not a known key of {name}: keys are names.")
    return dict(given)


def axes(over: Any, check: Callable[[Any], None]) -> dict[str, list[float]]:
    """Return the values of each parameter of a product; ``check`` refuses a name. Raises ``InputError``."""
    found: dict[str, list[float]] = {}
    lists = names_and_values("over", over)
    for name, given in lists.items():
        check(name)
        if isinstance(given, str | bytes | Mapping) or getattr(given, "ndim", 1) != 1 or not hasattr(given, "__len__"):
            raise InputError(f"over: {name} = {shown(given)} is not a list of numbers.")
    total = math.prod(map(len, lists.values()))
    if not 1 <= total <= _MOST_POINTS:
        raise InputError(f"over has {total} points; the allowed range is 1 <= points <= {_MOST_POINTS}.")
    for name, given in lists.items():
        try:
            found[name] = [number(value) for value in given]
        except NotNumber as error:
            raise InputError(f"over: {name} has a value that {error}.") from None
    if not found:
        raise InputError("over is empty; give the values of a parameter.")
    return found
