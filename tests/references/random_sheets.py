"""The chapter's drive as a data sheet, and random ones over all entries and forms, as of catalogues; seeded."""

import math
from typing import Any

import numpy as np

from lsvib.assess.materials import NUT_MATERIALS, SCREW_MATERIALS
from lsvib.assess.operation import Draw
from lsvib.assess.sheet import Sheet
from lsvib.assess.threads import _ACME, _COARSE, _TRAPEZOIDAL
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.pairings import PAIRINGS

CHAPTER = {
    "name": "Table 8.1", "thread": {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm"},
    "screw": {"inertia": "3.12e-6 kg*m^2"}, "coupling": {"stiffness": "1 N*m/rad"},
    "load": {"mass": "1 kg", "force": "-50 N"}, "operation": {"speed": "40 rad/s", "direction": "out"},
    "friction": {"coefficient": 0.218}, "damping": {"rotational": "2e-4 N*m*s/rad"},
}  # fmt: skip
# Of friction, the law of the powered seat.
LAW = {"coefficient": 0.218, "stribeck_rise": 0.0203, "stribeck_speed": "0.013704 m/s", "slope": "-0.0858859895667 s/m"}


def sheet(**changes) -> Sheet:
    return Sheet.of({**CHAPTER, **changes})


_ENDS = ("fixed-free", "supported-supported", "fixed-supported", "fixed-fixed")
_DIRECTIONS = ("out", "back", "both")


def random_sheet(seed: int, index: int) -> dict[str, Any]:
    """Draw sheet ``index`` of a seed, the same whatever else is drawn."""
    draw = _Draw(np.random.default_rng([seed, index]))
    thread, diameter = _thread(draw)
    stiffness = draw.power(0.3, 30.0) * (diameter / 10e-3) ** 3 * 10
    sheet = {
        "name": f"drive {index}",
        "thread": thread,
        "screw": _screw(draw, diameter, "size" in thread),
        "coupling": {"stiffness": draw.form(stiffness, "N*m/rad")}
        | draw.maybe(0.2, gear_ratio=lambda: draw.form(draw.power(1, 50), ""))
        | draw.maybe(0.2, inertia=lambda: draw.form(draw.power(1e-7, 1e-4), "kg*m^2")),
        "load": _load(draw, diameter),
        "operation": _operation(draw),
        "friction": _friction(draw),
    }
    damping = draw.maybe(0.7, rotational=lambda: draw.form(draw.power(1e-6, 1e-1), "N*m*s/rad"))
    damping |= draw.maybe(0.7, translational=lambda: draw.form(draw.power(1, 3000), "N*s/m"))
    sheet |= {"damping": damping} if damping or draw.chance(0.1) else {}
    sheet |= draw.maybe(0.3, nut=lambda: _nut(draw, diameter))
    for part, often in (("contact", 0.2), ("support", 0.25)):
        sheet |= draw.maybe(
            often,
            **{
                part: lambda: (
                    {"stiffness": draw.form(draw.power(1e6, 1e9), "N/m")}
                    | draw.maybe(0.7, damping=lambda: draw.form(draw.power(1, 1e5), "N*s/m"))
                )
            },
        )
    return sheet


class _Draw:
    """Numbers and choices from a generator, and the forms in which a sheet gives a quantity."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng

    def power(self, low: float, high: float) -> float:
        """Draw a number between two ends, its logarithm uniform, with four digits."""
        return float(f"{math.exp(self.rng.uniform(math.log(low), math.log(high))):.4g}")

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def one(self, options: Any) -> Any:
        options = list(options)
        return options[int(self.rng.integers(len(options)))]

    def maybe(self, share: float, **entries: Any) -> dict[str, Any]:
        """Return entries, given by functions, so often, else none."""
        return {key: make() for key, make in entries.items()} if self.chance(share) else {}

    def form(self, value: float, unit: str, even: bool = False) -> Any:
        """Return a quantity as a value, a range or a distribution; ``even``: as a value or a range only."""

        def text(number: float) -> Any:
            return f"{number:.6g} {unit}" if unit else float(f"{number:.6g}")

        kind, width = self.rng.random(), self.rng.uniform(0.01, 0.2)
        if kind < 0.55 or value == 0:
            return text(value)
        ends = sorted((value * (1 - width), value * (1 + width)))
        if kind < 0.75 or even:
            return (
                [text(end) for end in ends]
                if self.chance(0.7)
                else dict(zip(("low", "high"), map(text, ends), strict=True))
            )
        if kind < 0.83:
            return {"low": text(ends[0]), "mode": text(value), "high": text(ends[1])}
        if kind < 0.91:
            return {"mean": text(value), "std": text(abs(value) * width / 5)}
        if value < 0:
            return text(value)
        return {"median": text(value), "factor": float(f"{1 + 2 * width:.3g}")}


def _thread(draw: _Draw) -> tuple[dict[str, Any], float]:
    kind = draw.rng.random()
    if kind < 0.3:
        diameter = draw.one(_TRAPEZOIDAL)
        pitch = draw.one(_TRAPEZOIDAL[diameter])
        starts = draw.one((1, 1, 1, 2, 4))
        return {"size": f"Tr {diameter}x{pitch * starts:g}" + (f" P{pitch:g}" if starts > 1 else "")}, diameter * 1e-3
    if kind < 0.4:
        inches = draw.one(_ACME)
        return {"size": f"Acme {inches}-{_ACME[inches]}"}, 0.02
    if kind < 0.5:
        diameter = draw.one(_COARSE)
        return {"size": f"M{diameter}x{_COARSE[diameter]:g}"}, diameter * 1e-3
    diameter = draw.power(5, 60)
    found: dict[str, Any] = {}
    if kind < 0.7:
        pitch, starts = draw.power(0.5, max(0.25 * diameter, 0.6)), draw.one((1, 2, 4))
        found["pitch"] = draw.form(pitch, "mm")
        found |= {"starts": starts} if starts > 1 else {}
    elif kind < 0.9:
        found["lead"] = draw.form(draw.power(0.05 * diameter, 1.2 * diameter), "mm")
    else:
        found["lead_angle"] = draw.form(draw.power(1, 25), "deg")
    if "lead_angle" in found or draw.chance(0.6):
        found["pitch_diameter"] = draw.form(diameter, "mm")
    else:
        found["nominal_diameter"] = draw.form(diameter, "mm")
        found.setdefault("starts", 1)
    found |= draw.maybe(0.3, half_angle=lambda: draw.form(draw.one((14.5, 15.0, 30.0)), "deg"))
    return found, diameter * 1e-3


def _screw(draw: _Draw, diameter: float, sized: bool) -> dict[str, Any]:
    if draw.chance(0.3):
        found = {"inertia": draw.form(draw.power(1e-7, 1e-3), "kg*m^2")}
        found |= draw.maybe(0.3, unsupported_length=lambda: draw.form(draw.power(100, 2000), "mm"))
        found |= {"mass": draw.form(draw.power(0.1, 10), "kg")}
    else:
        found = {"length": draw.form(draw.power(100, 2000), "mm")}
        found |= draw.maybe(0.3, diameter=lambda: draw.form(1e3 * diameter, "mm"))
        found |= draw.one(
            ({}, {"material": draw.one(SCREW_MATERIALS)}, {"density": draw.form(draw.power(2700, 8900), "kg/m^3")})
        )
        found |= draw.maybe(0.2, mass=lambda: draw.form(draw.power(0.1, 10), "kg"))
    if ("length" in found or "unsupported_length" in found) and "density" not in found and draw.chance(0.5):
        found["ends"] = draw.one(_ENDS)
        found |= draw.maybe(0.2 if sized else 1.0, root_diameter=lambda: draw.form(0.7e3 * diameter, "mm"))
    return found


def _load(draw: _Draw, diameter: float) -> dict[str, Any]:
    mass = draw.power(0.1, 200.0) * (diameter / 10e-3) ** 2
    found = {"mass": draw.form(mass, "kg")}
    kind = draw.rng.random()
    if kind < 0.5:
        found["force"] = draw.form(draw.one((-1, 1)) * draw.power(0.2, 20.0) * mass, "N")
    elif kind < 0.65:
        force = draw.power(0.2, 20.0) * mass
        found["force"] = draw.one(([f"{-force:.4g} N", f"{0.5 * force:.4g} N"], ["0 N", f"{force:.4g} N"], "0 N"))
    angle = draw.one(
        ("horizontal", "vertical", "90 deg", "-90 deg", draw.form(draw.power(0.5, 60), "deg"), ["-5 deg", "5 deg"])
    )
    return found | draw.maybe(0.7, orientation=lambda: angle)


def _operation(draw: _Draw) -> dict[str, Any]:
    unit, low, high = draw.one((("rpm", 1, 3000), ("mm/s", 0.5, 300), ("rad/s", 0.5, 200)))
    speed = draw.power(low, high)
    given = [f"{speed:g} {unit}", f"{speed * draw.power(1.5, 100):.4g} {unit}"]
    found = {"speed": given if draw.chance(0.3) else draw.form(speed, unit)}
    return found | draw.maybe(0.8, direction=lambda: draw.one(_DIRECTIONS))


def _friction(draw: _Draw) -> dict[str, Any]:
    kind, level = draw.rng.random(), draw.power(0.02, 0.35)
    if kind < 0.2:
        return {"pairing": draw.one(PAIRINGS)}
    if kind < 0.3:
        return {"efficiency": draw.form(draw.rng.uniform(0.2, 0.8), "")}
    if kind < 0.4:
        speeds = np.cumsum([draw.power(1, 100) for _ in range(draw.one((2, 3, 5)))])
        pairs = [[f"{speed:.4g} mm/s", draw.power(0.02, 0.35)] for speed in speeds]
        return {"curve": pairs} | draw.maybe(0.4, curve_factor=lambda: draw.form(1.0, ""))
    even = kind >= 0.75  # with static friction, which is above all of them
    found: dict[str, Any] = {"coefficient": draw.form(level, "", even)}
    slope = draw.one((-1, 1)) * draw.power(1e-4, 1.0)
    if kind < 0.55:
        return found | draw.maybe(0.6, slope=lambda: draw.form(slope, "s/m"))
    found |= draw.maybe(0.3, slope=lambda: draw.form(slope, "s/m"))
    rise = draw.power(0.005, 0.2)
    if kind < 0.85:
        found["stribeck_rise"] = draw.form(rise, "", even)
        found["stribeck_speed"] = draw.form(draw.power(0.5, 100), "mm/s")
        found |= draw.maybe(0.5, stribeck_exponent=lambda: draw.one((1, 2)))
    if even:
        found["static"] = draw.form(float(f"{(1.3 * level + 1.3 * rise) * draw.power(1.05, 3):.4g}"), "", even=True)
    return found


def _nut(draw: _Draw, diameter: float) -> dict[str, Any]:
    found = {"length": draw.form(2e3 * diameter, "mm")}
    found |= draw.maybe(0.5, material=lambda: draw.one(NUT_MATERIALS))
    found |= draw.maybe(0.3, pressure_limit=lambda: draw.form(draw.power(1, 40), "MPa"))
    found |= draw.maybe(0.3, pv_limit=lambda: draw.form(draw.power(0.05, 5), "MPa*m/s"))
    return found | draw.maybe(0.3, speed_limit=lambda: draw.form(draw.power(0.05, 2), "m/s"))


def random_drive(seed: int, index: int) -> Drive | None:
    """Return the drive of a random sheet at a point of its window, with its most compliant part; None if refused."""
    try:
        given = random_sheet(seed, index)
        if "support" in given:
            given.pop("contact", None)
        places = Draw.of(Sheet.of(given)).corners
        return places[index % len(places)].drive
    except InputError:
        return None
