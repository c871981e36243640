"""The words of the report, which stand in words.yaml beside this file, and numbers with units."""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined

_WORDS: dict[str, Any] = yaml.safe_load(Path(__file__).with_name("words.yaml").read_text(encoding="utf-8"))


class Quantity(NamedTuple):
    """What the verdict depends on: its name in files, in words, its unit, and the entry of the sheet."""

    name: str
    words: str
    unit: str
    entry: str


MECHANISMS = {name: (entry["name"], entry["meaning"]) for name, entry in _WORDS["mechanisms"].items()}
"""Name and plain meaning of each mechanism."""

ATTRACTORS: dict[str, str] = _WORDS["ends"]
"""Where motions end, in plain words."""

TOLERATED: dict[str, str] = _WORDS["tolerated"]
"""What is said of the largest perturbation that steady running tolerates."""

VERDICTS: dict[str, str] = _WORDS["verdicts"]
"""The verdict in one sentence, by its name."""

WEAK: dict[str, str] = _WORDS["weak"]
"""What takes more than motor or brake have, by the row of statics."""

QUANTITIES = {name: Quantity(*entry) for name, entry in _WORDS["quantities"].items()}
"""What the verdict depends on, by the names of a drive's parameters; coefficients of friction are of the flanks."""

ABOUT: dict[str, dict[str, str]] = _WORDS["statics"]
"""``name``, ``unit``, ``formula`` and ``source`` of each row of statics."""

TORQUE_PARTS, BUY = (dict[str, dict[str, Any]](_WORDS[name]) for name in ("torque_parts", "buy"))
"""What the worst torque is made of, and what can be bought: ``words``, and what words.yaml says besides."""


def environment(html: bool = False) -> Environment:
    """Return what renders the templates beside this file, of which pages escape their texts."""
    found = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=html,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    found.filters |= {"fmt": format, "short": short, "shown": shown, "yaml": partial(yaml.safe_dump, sort_keys=False)}
    return found


def short(mechanism: str) -> str:
    """Return the name of a mechanism for the middle of a sentence."""
    name = str(MECHANISMS[mechanism][0])
    return name[0].lower() + name[1:]


def capital(text: str) -> str:
    """Return a text for the beginning of a sentence."""
    return text[0].upper() + text[1:]


def entry_name(path: str) -> str:
    """Return an entry of the data sheet, such as coupling.gear_ratio, as a reader meets it: coupling: gear ratio."""
    return path.replace(".", ": ").replace("_", " ")


_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = ("N", "m", "m/s", "Hz", "N s", "N/m", "N m/rad", "s", "N m", "W")


_us_too = ContextVar("_us_too", default=False)


@contextmanager
def us_units_too(wanted: bool = True) -> Iterator[None]:
    """Show every quantity in US units, too, behind the SI ones: 1.79 N m (15.8 lbf·in)."""
    before = _us_too.set(wanted)
    try:
        yield
    finally:
        _us_too.reset(before)


def shown(value: float | None, unit: str, inner: bool = False, *, digits: int = 3) -> str:
    """Return a quantity in SI units with a prefix where one is usual, rad and rad/s in degrees and rpm, Pa in MPa.

    ``unit`` in the spelling of datasets (``N m s rad-1``) or of people; an empty text or 1 for plain numbers.
    ``inner``: where it stands in parentheses, and its US units, if they are wanted, in brackets.
    """
    size, name = _WORDS["us_units"].get(re.sub(r" (\w+)-1$", r"/\1", unit), (0.0, ""))
    if not (_us_too.get() and size and value and math.isfinite(value)):
        return _in_si(value, unit, digits)
    ends = "[]" if inner else "()"
    return f"{_in_si(value, unit, digits)} {ends[0]}{_figure(value / size, digits)} {name}{ends[1]}"


def _in_si(value: float | None, unit: str, digits: int) -> str:
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "any" if value > 0 else "none"
    if unit in ("rad s-1", "rad/s"):
        return f"{_figure(value * 60 / (2 * math.pi), digits)} rpm"
    if unit == "rad":
        return f"{_figure(math.degrees(value), digits)}°"
    if unit in ("Pa", "Pa m/s"):
        return f"{_figure(1e-6 * value, digits)} M{unit}"
    unit = re.sub(r" (\w+)-1$", r"/\1", unit)
    unit = re.sub(r"m\^?([23])$", lambda power: "m²" if power[1] == "2" else "m³", unit)
    if unit in ("", "1"):
        return _figure(value, digits)
    if unit in _PREFIXED and value != 0:
        size = abs(value) * (1 + 0.5 * 10.0**-digits)  # so that 999.7 becomes 1 k
        factor, prefix = next((pair for pair in _PREFIXES if size >= pair[0]), _PREFIXES[-1])
        return f"{_figure(value / factor, digits)} {prefix}{unit}"
    return f"{_figure(value, digits)} {unit}"


def size(value: float | None, unit: str, inner: bool = False) -> str:
    """Return a quantity in words; a torque against threads that jam is infinite."""
    return "any (it jams)" if value is not None and math.isinf(value) else shown(value, unit, inner)


def percent(value: float | None) -> str:
    """Return a share as a percentage, with enough digits near its ends."""
    if value is None or math.isnan(value):
        return "–"
    share, digits = 100 * value, 4
    if share <= 99 or value >= 1:
        return f"{_figure(share)} %"
    while (text := f"{share:.{digits}g}") == "100":  # only what is sure is 100 %
        digits += 1
    return f"{text} %"


def signed(value: float, places: int) -> str:
    """Return a plain number with its sign and so many decimal places."""
    return f"{value:+.{places}f}".replace("-", "−")


def change(factor: float | None) -> str:
    """Return a factor in words: 20 % larger, 3 times as large."""
    if factor is None:
        return "no change of it is enough"
    if factor >= 2:
        return f"{factor:.3g} times as large"
    return f"{abs(factor - 1) * 100:.3g} % {'larger' if factor > 1 else 'smaller'}"


def _figure(value: float, digits: int = 3) -> str:
    text = f"{value or 0.0:.{digits}g}"  # zero without a sign
    mantissa, _, exponent = text.partition("e")
    if exponent and 0 < int(exponent) < 6:
        text = f"{value:.0f}"
    elif exponent:
        small = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa} × 10{small}"
    return text.replace("-", "−")
