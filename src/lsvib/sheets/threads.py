"""Threads of the catalogues by name: metric trapezoidal, Acme and metric coarse."""

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated

from pydantic import BeforeValidator

from lsvib.numbers import shown
from lsvib.sheets.fields import NotQuantity

_TRAPEZOIDAL = {  # nominal diameter: pitches [mm] of ISO 2902, and those of drive screws that catalogues offer besides
    8: (1.5, 2), 9: (1.5, 2), 10: (1.5, 2, 3), 11: (2, 3), 12: (2, 3, 4), 14: (2, 3, 4), 16: (2, 3, 4), 18: (2, 4),
    20: (2, 4), 22: (3, 5, 8), 24: (3, 5, 8), 26: (3, 5, 8), 28: (3, 5, 8), 30: (3, 6, 10), 32: (3, 6, 10),
    34: (3, 6, 10), 36: (3, 6, 10), 38: (3, 7, 10), 40: (3, 7, 10), 44: (3, 7, 12), 48: (3, 8, 12), 50: (3, 8, 12),
    52: (3, 8, 12), 55: (3, 9, 14), 60: (3, 9, 14), 65: (4, 10, 16), 70: (4, 10, 16), 80: (4, 10, 16),
    85: (4, 12, 18), 90: (4, 12, 18), 95: (4, 12, 18), 100: (4, 12, 20), 110: (4, 12, 20), 120: (6, 14, 22),
    130: (6, 14, 22), 140: (6, 14, 24), 150: (6, 16, 24), 160: (6, 16, 28), 170: (6, 16, 28), 180: (8, 18, 28),
    190: (8, 18, 32), 200: (8, 18, 32), 210: (8, 20, 36), 220: (8, 20, 36), 230: (8, 20, 36), 240: (8, 22, 36),
    250: (12, 22, 40), 260: (12, 22, 40), 270: (12, 24, 40), 280: (12, 24, 40), 290: (12, 24, 44), 300: (12, 24, 44),
}  # fmt: skip
_ACME = {  # nominal diameter [inch]: threads per inch
    "1/4": 16, "5/16": 14, "3/8": 12, "7/16": 12, "1/2": 10, "5/8": 8, "3/4": 6, "7/8": 6, "1": 5, "1-1/8": 5,
    "1-1/4": 5, "1-3/8": 4, "1-1/2": 4, "1-3/4": 4, "2": 4, "2-1/4": 3, "2-1/2": 3, "2-3/4": 3, "3": 2,
}  # fmt: skip
_COARSE = {  # nominal diameter: pitch [mm] of the coarse series of ISO 261
    4: 0.7, 5: 0.8, 6: 1, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2, 16: 2, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3, 27: 3, 30: 3.5,
    33: 3.5, 36: 4, 39: 4, 42: 4.5, 45: 4.5, 48: 5, 52: 5, 56: 5.5, 60: 5.5, 64: 6,
}  # fmt: skip
_METRIC = re.compile(r"M\s*(\d{1,3})(?:\s*x\s*(\d+(?:\.\d+)?))?")
_POWER_METRIC = re.compile(r"Tr\s*(\d{1,3})\s*x\s*(\d+(?:\.\d+)?)(?:\s*\(?P(\d+(?:\.\d+)?)\)?)?", re.IGNORECASE)
_INCHES = re.compile(r"Acme\s*((?:\d-)?\d{1,2}/\d{1,2}|\d)\s*-\s*(\d{1,2})", re.IGNORECASE)


@dataclass(frozen=True)
class ThreadSize:
    """A thread: ``lead`` and ``pitch_diameter`` [m], ``half_angle`` of a flank in an axial section [rad].

    ``root_diameter`` of the screw [m]; ``engaged_depth`` of screw and nut over the pitch [1].
    """

    lead: float
    pitch_diameter: float
    half_angle: float
    root_diameter: float
    engaged_depth: float = 0.5


def thread_size(name: object) -> ThreadSize:
    """Return the thread of a name such as ``Tr 10x2``, ``Tr 8x8 P2`` (lead, then pitch), ``Acme 1/2-10``, ``M20``.

    The pitch diameter of Tr (DIN 103, ISO 2904) and Acme (ASME B1.5) is the nominal one d less half a pitch P, the root
    diameter d − P − 2 a with a clearance a of the standard; of M (ISO 724) they are d − 3√3/8 P and d − 17√3/24 P.
    Raises ``NotQuantity`` with the end of a sentence.
    """
    text = name.strip() if isinstance(name, str) else ""
    if match := _METRIC.fullmatch(text):
        return _metric(int(match[1]), float(match[2]) if match[2] else None, text)
    if match := _POWER_METRIC.fullmatch(text):
        diameter, lead = int(match[1]), float(match[2])
        pitch = float(match[3] or lead)
        if diameter not in _TRAPEZOIDAL or pitch not in _TRAPEZOIDAL[diameter]:
            pitches = ", ".join(f"{p:g}" for p in _TRAPEZOIDAL.get(diameter, ()))
            hint = f"Tr {diameter} has the pitches {pitches} mm" if pitches else "diameters go from Tr 8 to Tr 300"
            own = next((p for p in reversed(_TRAPEZOIDAL.get(diameter, ())) if lead / p in (2, 3, 4, 6, 8)), None)
            if match[3] is None and own is not None:
                hint += f"; with several starts it is written with its pitch, such as Tr {diameter}x{lead:g} P{own:g}"
            raise NotQuantity(f"= {name!r} is not in the catalogue: {hint}")
        starts = lead / pitch
        if starts != round(starts) or not 1 <= starts <= 8:
            raise NotQuantity(f"= {name!r} has a lead that is not 1 to 8 times its pitch of {pitch:g} mm")
        clearance = 0.15 if pitch < 2 else 0.25 if pitch < 6 else 0.5 if pitch < 14 else 1.0
        root = (diameter - pitch - 2 * clearance) * 1e-3
        return ThreadSize(lead * 1e-3, (diameter - 0.5 * pitch) * 1e-3, math.radians(15), root)
    if match := _INCHES.fullmatch(text):
        threads = int(match[2])
        if _ACME.get(match[1]) != threads:
            raise NotQuantity(f"= {name!r} is not in the catalogue of general-purpose Acme threads")
        whole, _, rest = match[1].rpartition("-")
        inches = float(Fraction(rest) + (int(whole) if whole else 0))
        root = (inches - 1 / threads - (0.02 if threads <= 10 else 0.01)) * 0.0254
        return ThreadSize(0.0254 / threads, (inches - 0.5 / threads) * 0.0254, math.radians(14.5), root)
    raise NotQuantity(
        f"= {shown(name)} is not the name of a thread, such as Tr 10x2, Tr 8x8 P2, Acme 1/2-10 or M20x2.5"
    )


def _metric(diameter: int, pitch: float | None, name: str) -> ThreadSize:
    """A metric thread of the coarse series [mm], whose pitch need not be named."""
    coarse = _COARSE.get(diameter)
    pitch = pitch or coarse
    if pitch is None or coarse != pitch:
        hint = f"M{diameter} has the coarse pitch {coarse:g} mm" if coarse else "diameters go from M4 to M64"
        raise NotQuantity(f"= {name!r} is not in the catalogue: {hint}")
    height = math.sqrt(3) / 2 * pitch  # of the fundamental triangle
    diameters = [1e-3 * (diameter - share * height) for share in (3 / 4, 17 / 12)]
    return ThreadSize(pitch * 1e-3, diameters[0], math.radians(30), diameters[1], 5 / 8 * height / pitch)


Size = Annotated[ThreadSize, BeforeValidator(thread_size)]
