"""Random sheets of a size with motor, gear, brake and moves: one answer in all spellings, texts and files."""

import html
import json
import math
import re
from functools import reduce
from itertools import product

import numpy as np
import pytest
from references.sizes import sizes

import lsvib
from lsvib.sheets.motor import LIMITED

INCH, LB, G, POUND, TURN = 0.0254, 0.45359237, 9.80665, 4.4482216152605, 2 * math.pi
UNITS = {  # spellings of each unit, and what they are in it
    "N*m": {"Nm": 1, "Ncm": 0.01, "mN-m": 1e-3, "kgcm": G / 100, "oz-in": POUND * INCH / 16, "in-lbs": POUND * INCH},
    "N": {"kN": 1e3, "lbf": POUND, "lbs": POUND, "kp": G}, "kg": {"g": 1e-3, "lbs": LB}, "rad": {"°": TURN / 360},
    "kg*m^2": {"kgcm2": 1e-4, "g·cm²": 1e-7, "oz-in²": LB * INCH**2 / 16, "lb-in-s²": POUND * INCH},
    "m": {"mm": 1e-3, '"': INCH}, "s": {"ms": 1e-3, "min": 60}, "m/s": {"mm/s": 1e-3, "ipm": INCH / 60},
    "m/s^2": {"mm/s²": 1e-3, "in/s2": INCH}, "Pa": {"N/mm²": 1e6, "psi": POUND / INCH**2}, "": {"%": 0.01},
}  # fmt: skip
ENTRIES = {  # unit, how often they are given, and between which values
    "thread.lead": ("m", 1, 1e-3, 1e-2), "thread.pitch_diameter": ("m", 1, 8e-3, 3e-2), "load.force": ("N", 1, 9, 2e3),
    "thread.half_angle": ("rad", 0.5, 0.1, 0.3), "friction.coefficient": ("", 1, 0.02, 0.3),
    "load.mass": ("kg", 1, 0.5, 200), "load.orientation": ("rad", 0.8, 0.1, 0.4), "guide.friction": ("N", 0.4, 1, 99),
    "screw.inertia": ("kg*m^2", 0.6, 1e-6, 1e-3), "coupling.gear_ratio": ("", 0.6, 0.5, 8),
    "motor.inertia": ("kg*m^2", 0.6, 1e-6, 1e-3), "motor.gear_efficiency": ("", 0.6, 0.1, 0.25),
    "motor.rated_torque": ("N*m", 0.5, 0.05, 5), "motor.peak_torque": ("N*m", 0.5, 0.1, 10),
    "motor.holding_torque": ("N*m", 0.3, 0.1, 5), "brake.torque": ("N*m", 0.5, 0.01, 2),
    "guide.coefficient": ("", 0.4, 0.01, 0.2), "bearing.torque": ("N*m", 0.3, 1e-3, 0.1),
    "nut.length": ("m", 1, 0.01, 0.1), "nut.pressure_limit": ("Pa", 0.7, 1e5, 1e7),
    "operation.speed": ("m/s", 1, 0.01, 0.3),
    "operation.acceleration": ("m/s^2", 0.5, 0.1, 5), "operation.move.distance": ("m", 1, 0.05, 0.5),
    "operation.move.time": ("s", 1, 0.5, 5), "operation.move.pause": ("s", 0.5, 0.1, 5),
}  # fmt: skip


def drawn(rng) -> dict[str, list[float]]:
    """Values of the entries of a sheet in SI units, of at most five of them two ends: at rest, even, or a move."""
    found, runs = dict[str, list[float]](), ("none", "operation.[sa]", "operation.m")[rng.integers(3)]
    for path, (_, share, low, high) in ENTRIES.items():
        if rng.random() < share and (path[:9] != "operation" or re.match(runs, path)):
            value, ends = low * (high / low) ** rng.random(), sum(map(len, found.values())) - len(found)
            found[path] = [value, 1.2 * value] if ends < 5 and "move" not in path and rng.random() < 0.3 else [value]
    return found


def written(values, rng=None) -> dict:
    """Names and values of a sheet, with an ``rng`` in spellings that it draws, ranges as tolerances."""
    sheet: dict = {"name": "drawn"}
    for path, ends in values.items():
        spellings = {ENTRIES[path][0]: 1, **(UNITS[ENTRIES[path][0]] if rng else {})}
        name, size = list(spellings.items())[rng.integers(len(spellings)) if rng else 0]
        texts = [f"{end / size!r} {name}".strip() for end in ends]
        if rng and texts[1:] and name != "%":
            texts = [f"{sum(ends) / 2 / size!r} ± {(ends[1] - ends[0]) / 2 / size!r} {name}"]
        *parts, last = path.split(".")
        reduce(lambda place, part: place.setdefault(part, {}), parts, sheet)[last] = texts if texts[1:] else texts[0]
    return sheet


def close(one, other) -> bool:
    """Whether two answers say the same, numbers to 1e-12, whatever the words."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(close(one[k], other[k]) for k in one.keys() - {"brief", "sentence"})
    return one == (pytest.approx(other, rel=1e-12, abs=0) if isinstance(other, float) else other)


def at_corner(v, way):
    """Yield rows by the balance of forces on a flank, and their limits: torques at the motor to run and to hold."""
    get, angle = v.get, math.atan(v["thread.lead"] / (math.pi * v["thread.pitch_diameter"]))
    along = math.cos(math.atan(math.cos(angle) * math.tan(get("thread.half_angle", 0))))
    ratio, share, weight = get("coupling.gear_ratio", 1), get("motor.gear_efficiency", 1), get("load.mass", 0) * G
    guide = get("guide.friction", 0) + get("guide.coefficient", 0) * weight * math.cos(get("load.orientation", 0))
    held = way * (v["load.force"] + weight * math.sin(get("load.orientation", 0)))

    def screw(load):
        rub = math.copysign(v["friction.coefficient"], load)
        normal = load / (along * math.cos(angle) - rub * math.sin(angle)) * 0.5 * v["thread.pitch_diameter"]
        return normal * (along * math.sin(angle) + rub * math.cos(angle)) + get("bearing.torque", 0)

    torque, hold = screw(held + guide), max(-screw(-max(abs(held) - guide, 0)), 0) * share / ratio
    limits = [get(f"motor.{name}_torque") for name in ("rated", "peak", "holding")]
    first = [limits[k] for k in ((1, 0, 2) if "operation.move.distance" in v else (0, 1, 2))]
    yield "motor_torque", abs(torque) / ratio * share ** -math.copysign(1, torque), next(filter(None, first), None)
    yield "motor_holding_torque", hold, limits[2] or limits[0] or limits[1]
    yield "brake_torque", hold, get("brake.torque")


@pytest.mark.parametrize("index", sizes([0, 1, 2, 86], range(3, 12), range(12, 300)))
def test_a_sheet_is_answered_rightly_whichever_way_it_is_written(index, tmp_path):
    rng = np.random.default_rng([71, index])
    values = drawn(rng)
    found, told = lsvib.assess(written(values)), lsvib.assess(written(values, rng), tmp_path, units="us")
    assert close(found, told)
    assert close(found, json.loads((tmp_path / "assessment.json").read_text()))
    text = re.sub(r"<style.*?</style>|<[^>]*>", " ", (tmp_path / "index.html").read_text(encoding="utf-8"), flags=re.S)
    assert [line for line in told["brief"] if line not in " ".join(html.unescape(text).split())] == []
    assert len(told["brief"]) == len(found["brief"])
    rows = {key: row for key, row in found["statics"].items() if isinstance(row, dict)}
    weak = any(rows[key]["exceeded"] for key in LIMITED if key in rows)
    assert weak == ("too weak" in found["brief"][0]) == ("weak" in (found["verdict"] or ""))
    most: dict[str, float] = {}
    for ends, way in product(product(*values.values()), (1, -1)):
        for key, value, limit in at_corner(dict(zip(values, ends, strict=True)), way):
            most[key] = max(most.get(key, 0.0), value / (limit or 1.0))
    for key in most.keys() & rows.keys():
        assert rows[key]["worst"] / (rows[key]["limit"] or 1.0) == pytest.approx(most[key], rel=1e-8), key
    for path in rng.permutation(list(values))[:3]:
        seen = not close(found, lsvib.assess(written({**values, path: [3 * end for end in values[path]]})))
        even = path in ("screw.inertia", "motor.inertia", "load.mass") and found["move"] is None
        assert seen or even or re.fullmatch(r"motor\.\w+_torque", path), path  # one limit stands behind another
    row = "rms_torque" if "rms_torque" in rows else "lifting_torque"
    wanted = 1.5 * rows[row]["middle"]
    solved = lsvib.assess(written(values), solve=("load.force", f"{row} = {wanted!r} N*m"))
    assert solved["brief"][0].startswith("load.force = ")
    assert solved["statics"][row]["middle"] == pytest.approx(wanted, rel=1e-8)
