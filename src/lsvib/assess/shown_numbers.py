"""Numbers with units as a reader of the report meets them."""

import math

_DIGITS = 3  # of a quantity
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = {"N": "N", "m": "m", "m/s": "m/s", "Hz": "Hz", "N s": "N s", "N/m": "N/m", "N m/rad": "N m/rad", "s": "s"}
_READABLE = {
    "kg m2": "kg m²",
    "kg m^2": "kg m²",
    "kg/m^3": "kg/m³",
    "N m rad-1": "N m/rad",
    "N m s rad-1": "N m s/rad",
    "N s m-1": "N s/m",
    "N m-1": "N/m",
    "s m-1": "s/m",
    "m s-1": "m/s",
}


def shown(value: float | None, unit: str) -> str:
    """Return a quantity in SI units with a prefix where one is usual, rad and rad/s in degrees and rpm.

    ``unit`` in the spelling of datasets (``N m s rad-1``) or of people; an empty text or 1 for plain numbers.
    """
    if value is None:
        return "–"
    if math.isinf(value):
        return "any" if value > 0 else "none"
    if unit in ("rad s-1", "rad/s"):
        return f"{_figure(value * 60 / (2 * math.pi))} rpm"
    if unit == "rad":
        return f"{_figure(math.degrees(value))}°"
    unit = _READABLE.get(unit, unit)
    if unit in ("", "1"):
        return _figure(value)
    if unit in _PREFIXED and value != 0:
        size = abs(value) * (1 + 0.5 * 10.0**-_DIGITS)  # so that 999.7 becomes 1 k
        factor, prefix = next((pair for pair in _PREFIXES if size >= pair[0]), _PREFIXES[-1])
        return f"{_figure(value / factor)} {prefix}{unit}"
    return f"{_figure(value)} {unit}"


def percent(value: float | None) -> str:
    """Return a share as a percentage, with enough digits near its ends."""
    if value is None:
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
        return "no change of it does"
    if factor >= 2:
        return f"{factor:.3g} times as large"
    return f"{abs(factor - 1) * 100:.3g} % {'larger' if factor > 1 else 'smaller'}"


def _figure(value: float) -> str:
    if value == 0:
        return "0"
    text = f"{value:.{_DIGITS}g}"
    if "e" not in text:
        return text.replace("-", "−")
    mantissa, _, exponent = text.partition("e")
    if 0 < int(exponent) < 6:
        return f"{value:.0f}".replace("-", "−")
    small = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa} × 10{small}".replace("-", "−")
