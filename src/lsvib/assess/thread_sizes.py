"""Sizes of threads by name: metric trapezoidal (ISO 2904, DIN 103) and general-purpose Acme (ASME B1.5)."""

import math
import re
from dataclasses import dataclass
from fractions import Fraction

from lsvib.assess.fields import NotQuantity

_INCH = 0.0254  # m
_TRAPEZOIDAL = {  # nominal diameter: pitches [mm] of ISO 2902, and those of drive screws that printers use
    8: (1.5, 2), 9: (1.5, 2), 10: (1.5, 2, 3), 11: (2, 3), 12: (2, 3), 14: (2, 3, 4), 16: (2, 3, 4), 18: (2, 4),
    20: (2, 4), 22: (3, 5, 8), 24: (3, 5, 8), 26: (3, 5, 8), 28: (3, 5, 8), 30: (3, 6, 10), 32: (3, 6, 10),
    34: (3, 6, 10), 36: (3, 6, 10), 38: (3, 7, 10), 40: (3, 7, 10), 44: (3, 7, 12), 48: (3, 8, 12), 50: (3, 8, 12),
    52: (3, 8, 12), 55: (3, 9, 14), 60: (3, 9, 14), 65: (4, 10, 16), 70: (4, 10, 16), 80: (4, 10, 16),
}  # fmt: skip
_ACME = {  # nominal diameter [inch]: threads per inch
    "1/4": 16, "5/16": 14, "3/8": 12, "7/16": 12, "1/2": 10, "5/8": 8, "3/4": 6, "7/8": 6, "1": 5, "1-1/8": 5,
    "1-1/4": 5, "1-3/8": 4, "1-1/2": 4, "1-3/4": 4, "2": 4, "2-1/4": 3, "2-1/2": 3, "2-3/4": 3, "3": 2,
}  # fmt: skip
_METRIC = re.compile(r"Tr\s*(\d+)\s*x\s*(\d+(?:\.\d+)?)(?:\s*\(?P(\d+(?:\.\d+)?)\)?)?", re.IGNORECASE)
_INCHES = re.compile(r"Acme\s*((?:\d+-)?\d+/\d+|\d+)\s*-\s*(\d+)", re.IGNORECASE)


@dataclass(frozen=True)
class ThreadSize:
    """A thread: ``lead`` and ``pitch_diameter`` [m], ``half_angle`` of a flank in an axial section [rad]."""

    lead: float
    pitch_diameter: float
    half_angle: float


def thread_size(name: object) -> ThreadSize:
    """Return the thread of a name such as ``Tr 10x2``, ``Tr 8x8 P2`` (lead, then pitch) or ``Acme 1/2-10``.

    The pitch diameter is the nominal one less half a pitch. Raises ``NotQuantity`` with the end of a sentence.
    """
    text = name if isinstance(name, str) else ""
    if match := _METRIC.fullmatch(text.strip()):
        diameter, lead = int(match[1]), float(match[2])
        pitch = float(match[3] or lead)
        if diameter not in _TRAPEZOIDAL or pitch not in _TRAPEZOIDAL[diameter]:
            pitches = ", ".join(f"{p:g}" for p in _TRAPEZOIDAL.get(diameter, ()))
            hint = f"Tr {diameter} has the pitches {pitches} mm" if pitches else "diameters go from Tr 8 to Tr 80"
            raise NotQuantity(f"= {name!r} is not in the catalogue: {hint}")
        starts = lead / pitch
        if starts != round(starts) or not 1 <= starts <= 8:
            raise NotQuantity(f"= {name!r} has a lead that is not 1 to 8 times its pitch of {pitch:g} mm")
        return ThreadSize(lead * 1e-3, (diameter - 0.5 * pitch) * 1e-3, math.radians(15))
    if match := _INCHES.fullmatch(text.strip()):
        threads = int(match[2])
        if _ACME.get(match[1]) != threads:
            raise NotQuantity(f"= {name!r} is not in the catalogue of general-purpose Acme threads")
        whole, _, rest = match[1].rpartition("-")
        diameter = float(Fraction(rest) + (int(whole) if whole else 0))
        return ThreadSize(_INCH / threads, (diameter - 0.5 / threads) * _INCH, math.radians(14.5))
    raise NotQuantity(f"= {name!r} is not the name of a thread, such as Tr 10x2, Tr 8x8 P2 or Acme 1/2-10")
