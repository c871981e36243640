"""Units as makers print them, in the words of pint: ``kgcm``, ``oz-in²``, ``lb.-in.``, ``U/min``, ``mm/rev``.

One spelling may stand for several units: a pound is a mass or a force, ' a foot or a minute of arc. Which is meant is
decided by the kind of quantity that an entry needs; where two of them fit, the entry refuses it.
"""

import re
import unicodedata
from functools import cache
from itertools import product
from pathlib import Path

from lsvib.drives.scene import read_yaml

_NAMES, _EXACT, _RATES = (
    {spelling: tuple(units.split("|")) for units, spellings in table.items() for spelling in spellings.split()}
    for table in read_yaml(Path(__file__).with_name("units.yaml")).values()
)
_GLUED = re.compile(  # Nm, mNm, kgcm, Nms, ozin, lbft
    r"([mcdkMuµ]?N|daN|kgf|kg|kp|gf|g|lbf|lb|ozf|oz)(mm|cm|m|in|ft)(s?)|([mk]?N)()(s)|()(in|ft)(lbf|lbs|lb|ozf|oz)"
)
_TOKEN = re.compile(r"[A-Za-zµ°'\"_]+|\^[+-]?\d|[/()]|^1(?=/)|[\s·.*-]+|.")
_SIGNS = str.maketrans("−–⁄×⋅•′’”″μ", "--/x··''\"\"µ")
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TENS = re.compile(rf"({_NUMBER})\s*[x*·]\s*10(?:(?:\^|\*\*)\(?([+-]?\d\d?)\)?|([+-]\d\d?))(?!\d)")  # 54 x 10^-7, 10-7
_FRACTION = re.compile(r"(?:(\d{1,3})[\s-]+)?(\d{1,3})/([1-9]\d{0,2})(?=\s*[A-Za-z\"'])")  # 1/2 inch, 1-1/2"
_PER_INCH = re.compile(r"([1-9]\d{0,2}(?:\.\d+)?)\s*(?:tpi|threads?/in(?:ch)?)", re.IGNORECASE)
_ANGLE = re.compile(r"(\d+)\s*°\s*(\d+(?:\.\d+)?)\s*'(?:\s*(\d+(?:\.\d+)?)\s*\")?")  # 4°02'
_TEXT = re.compile(rf"({_NUMBER})\s*([^\d\s+\-][^+]*|1/[^\d+]+)?", re.ASCII)


def plain(text: str) -> str:
    """Return a text with one sign of each kind: ² is 2, × is x, − is -, ″ and '' are ", and ½ is 1/2."""
    text = unicodedata.normalize("NFKC", re.sub("[¼½¾⅛⅜⅝⅞]", r" \g<0>", text))
    return " ".join(text.translate(_SIGNS).replace("''", '"').split()).replace(" per ", "/")


def split(text: str) -> tuple[str, str] | None:
    """Return the number and the unit of a plain text, the number as it can be read; None where it has no number.

    >>> split("1-1/2 in"), split("54x10^-7 kg·m2"), split("8 tpi")
    (('1.5', 'in'), ('54e-7', 'kg·m2'), ('3.175', 'mm'))
    """
    if match := _TENS.match(text):
        text = f"{match[1]}e{match[2] or match[3]}{text[match.end() :]}"
    if match := _FRACTION.match(text):
        text = f"{int(match[1] or 0) + int(match[2]) / int(match[3])!r} {text[match.end() :]}"
    if match := _PER_INCH.fullmatch(text):
        text = f"{25.4 / float(match[1])!r} mm"
    if match := _ANGLE.fullmatch(text):
        text = f"{int(match[1]) + float(match[2]) / 60 + float(match[3] or 0) / 3600!r} deg"
    match = _TEXT.fullmatch(text)
    return (match[1], (match[2] or "").strip()) if match else None


@cache
def readings(unit: str) -> tuple[str, ...]:
    """Return all that a unit may stand for, in pint's words, what it cannot read being left as it is.

    >>> readings("oz-in2"), readings("Nm/rad")
    (('oz*in**2', 'ozf*in**2'), ('N*m/rad',))
    """
    text = re.sub(r"\.?(?:\*\*|\^)\(?([+-]?\d)\)?", r"^\1", f"1{unit}" if unit.startswith("/") else unit)
    text = re.sub(r"(?<=[A-Za-zµ])\.?(-?[1-9])(?![\d.])", r"^\1", re.sub("r.p.m.?", "rpm", text))  # in2, min-1
    tokens = _TOKEN.findall(re.sub(r"\s*([/^()])\s*", r"\1", text))
    parts: list[tuple[str, ...]] = []
    for before, token, after in zip(["", *tokens], tokens, [*tokens[1:], ""], strict=False):
        if token[0] in "^/()1":
            parts.append((token.replace("^", "**"),))
        elif re.fullmatch(r"[\s·.*-]+", token):  # a product, but for dots of abbreviations at an end
            parts.append(("*" if {before, after}.isdisjoint(["", "/", "(", ")"]) else token.strip(" ."),))
        else:
            parts.append(_meanings(token))
    found = tuple("".join(combination) for combination in product(*parts))
    return _RATES.get(found[0], found)


def _meanings(name: str) -> tuple[str, ...]:
    if found := _EXACT.get(name) or _NAMES.get(name.lower()):
        return found
    if match := _GLUED.fullmatch(name):
        return tuple("*".join(parts) for parts in product(*(_meanings(part) for part in match.groups() if part)))
    return (name,)
