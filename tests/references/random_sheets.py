"""The chapter's drive as a data sheet, and random ones over all entries and forms, as of catalogues; seeded."""

from typing import Any

from benchmarks.sheets.own_sheets import OwnSheet
from lsvib import Drive
from lsvib.drives.pairings import PAIRINGS
from lsvib.errors import InputError
from lsvib.sheets.draw import Draw
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.threads import NUT_MATERIALS, SCREW_MATERIALS
from lsvib.sheets.window import OperatingWindow

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


_PARTS: dict[str, list[Any]] = {  # what other sheets have than those of which the motions are known, with their form
    "thread": [{"size": "Acme 1/2-10"}, {"size": "M20x2.5"}, {"size": "Tr 40x14 P7"}, {"lead_angle": "5.57 deg",
               "pitch_diameter": {"low": "10 mm", "mode": "11 mm", "high": "13 mm"}}, {"pitch": "3 mm", "starts": 2,
               "nominal_diameter": ["12 mm", "12.3 mm"], "half_angle": "14.5 deg"}],
    "friction": [{"efficiency": "45 %"}, {"efficiency": {"mean": 0.3, "std": 0.01}}, {"curve": [["5 mm/s", 0.2],
                 ["20 mm/s", 0.14], ["50 mm/s", 0.12], ["90 mm/s", 0.13], ["200 mm/s", 0.15]], "static": 0.3},
                 *({"pairing": name} for name in PAIRINGS)],
    "screw": [{"length": "700 mm", "material": name, "mass": "2 kg"} for name in SCREW_MATERIALS]
             + [{"length": "400 mm", "density": ["2700 kg/m^3", "7900 kg/m^3"]}],
    "nut": [{"length": "30 mm", "material": name} for name in NUT_MATERIALS]
           + [{"length": "15 mm", "pressure_limit": "5 MPa", "pv_limit": "0.4 MPa*m/s", "speed_limit": "1 m/s"}],
    "contact": [{"stiffness": "2e7 N/m"}, {"stiffness": ["1e7 N/m", "1e8 N/m"], "damping": "1e3 N*s/m"}],
    "support": [{"stiffness": "1e8 N/m", "damping": ["300 N*s/m", "2e4 N*s/m"]}, {"stiffness": "2e6 N/m"}],
}  # fmt: skip


def random_sheet(seed: int, index: int) -> dict[str, Any]:
    """Draw sheet ``index`` of a seed over all entries and forms."""
    own = OwnSheet([seed, index], near=False)
    for part, options in _PARTS.items():
        if own.rng.random() < 0.3 and not (
            part in ("contact", "support") and "collar" in own.written.get("bearing", {})
        ):
            own.written[part] = own.one(options)
    if "length" in own.written["screw"] and "density" not in own.written["screw"] and own.rng.random() < 0.5:
        own.written["screw"] |= {"ends": own.one(["fixed-free", "fixed-supported"]), "root_diameter": "6 mm"}
    if "support" in own.written and "inertia" in own.written["screw"]:
        own.written["screw"]["mass"] = "1.5 kg"
    return own.written


def random_drive(seed: int, index: int) -> Drive | None:
    """Return the drive of a random sheet at a point of its window, with its most compliant part; None if refused."""
    try:
        given = random_sheet(seed, index)
        if "support" in given:
            given.pop("contact", None)
        places = OperatingWindow(Draw.of(Sheet.of(given))).corners
        return places[index % len(places)].drive
    except InputError:
        return None
