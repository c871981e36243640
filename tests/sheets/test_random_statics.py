"""Random sheets of statics against the balance of forces on each flank, at the corners of window and uncertainties."""

import math
from collections import defaultdict
from functools import reduce
from itertools import product

import numpy as np
import pytest

from lsvib.sheets.report import of_statics
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import statics

WAYS = {"out": (1,), "back": (-1,), "both": (1, -1)}


def drawn(rng) -> dict[str, tuple[float, float]]:
    """Ends of the entries of a sheet, by name and SI unit."""

    def power(low, high, width=0.0):
        value = math.exp(rng.uniform(math.log(low), math.log(high)))
        return value * (1 - width), value * (1 + width)

    force, d = power(1, 5000)[0], power(5e-3, 60e-3)[0]
    forces = [(force, force), (0.0, force), (-force, force), (-force, -force / 3), (0.0, 0.0)]
    tilts = [(0.0, 0.0), (1.57, 1.57), (-1.57, -1.57), (-0.1, 0.1), (0.2, 0.5)]
    found = {
        "thread.lead m": power(0.05 * d, 1.2 * d), "thread.pitch_diameter m": (d, d),
        "thread.half_angle rad": (0.26, 0.26), "screw.root_diameter m": (0.75 * d, 0.75 * d),
        "friction.coefficient ": power(0.02, 0.3, rng.choice([0.0, 0.2])), "load.force N": forces[rng.integers(5)],
        "load.mass kg": power(0.01 * force, 0.2 * force), "load.orientation rad": tilts[rng.integers(5)],
        "operation.speed rad/s": (10.0, 10.0 * rng.integers(1, 5)),
    }  # fmt: skip
    guide, lever = power(0.05 * force, force, 0.1), 0.05 * force * d
    for part in (
        {"friction.static ": power(0.5, 0.8)},
        {"bearing.torque N*m": power(0.1 * lever, 2 * lever, 0.1), "bearing.static N*m": (3 * lever, 4 * lever)},
        {"bearing.collar.coefficient ": power(0.02, 0.2, 0.1), "bearing.collar.mean_diameter m": (1.5 * d, 1.5 * d)},
        {"guide.friction N": guide},
        {"guide.friction N": guide, "guide.static N": (2 * guide[1], 2 * guide[1])},
        {"nut.preload N": (0.3 * force, 0.3 * force)},
        {"damping.rotational N*m*s/rad": (1e-4, 1e-4), "damping.translational N*s/m": (10.0, 10.0)},
    ):
        found |= part if rng.random() < 0.4 else {}
    return found


def threads(force, mu, v, turn):
    """Torque of the nut, of normal force and friction of each flank; ``turn``: 1 against ``force``, −1 with it."""
    angle, other, found = math.atan(v["thread.lead"] / (math.pi * v["thread.pitch_diameter"])), v["nut.preload"], 0.0
    along = math.cos(math.atan(math.cos(angle) * math.tan(v["thread.half_angle"])))  # the part of the normal force
    for axial, s in ((force + other, turn), (other, -turn)):
        normal = axial / (along * math.cos(angle) - s * mu * math.sin(angle))
        found += s * normal * (along * math.sin(angle) + s * mu * math.cos(angle)) * 0.5 * v["thread.pitch_diameter"]
    return found


def at_a_point(v, held, speed):
    """Yield rows and what they are there, with the load that is ``held`` against the travel."""
    per_radian, mu, root = v["thread.lead"] / (2 * math.pi), v["friction.coefficient"], v["screw.root_diameter"]
    collar, bearing = 0.5 * v["bearing.collar.coefficient"] * v["bearing.collar.mean_diameter"], v["bearing.torque"]
    guide = v["guide.friction"]
    load = held + guide + v["damping.translational"] * per_radian * speed
    turn = 1 if load > 0 else -1

    def whole(force, turn, mu=mu, bearing=bearing):
        return threads(force, mu, v, turn) + collar * force + bearing

    torque = whole(abs(load), turn) + v["damping.rotational"] * speed
    yield "torque", max(torque, 0.0)
    bare = threads(abs(load), mu, v, turn) if collar else torque  # between collar and nut
    stresses = (math.hypot(4 * f * root, math.sqrt(3) * 16 * t) for f, t in ((load, bare), (0.0, torque)))
    yield "root_stress", max(stresses) / (math.pi * root**3)
    if held > 0:
        yield "lifting_efficiency", -held * per_radian / whole(held + guide, 1)
    elif not held:
        yield "without load", bearing + guide + v["nut.preload"]
    if held:
        brake = -whole(abs(abs(held) - guide), -1 if abs(held) > guide else 1)
        yield "lowering_efficiency", brake / (abs(held) * per_radian)
    rest, still, standing = v["friction.static"] or mu, v["bearing.static"] or bearing, v["guide.static"] or guide
    yield "holding_torque", -whole(max(abs(held) - standing, 0.0), -1, rest, still)
    if held + standing > 0 and any(v[path] for path in v if path.endswith(".static")):
        yield "starting_torque", whole(held + standing, 1, rest, still)


@pytest.mark.parametrize("index", range(40))
def test_rows_are_those_of_the_balance_of_forces(index):
    """The worst of each; with friction no efficiency where the window touches no load; whether the load stays."""
    rng, worst, sides = np.random.default_rng([67, index]), {}, defaultdict(lambda: {0.0})
    direction, sheet = rng.choice(list(WAYS)), {"name": "drawn"}
    for key, ends in drawn(rng).items():
        (path, _, unit), (low, high) = key.partition(" "), map(float, ends)
        *parts, last = path.split(".")
        texts = [f"{end!r} {unit}" if unit else end for end in (low, high)]
        reduce(lambda at, part: at.setdefault(part, {}), parts, sheet)[last] = texts if low < high else texts[0]
        sides[path] = {low, high} | ({0.0} if low < 0 < high else set())
    sheet["operation"]["direction"] = str(direction)
    forces = sides.pop("load.force")
    weights = [9.80665 * mass * math.sin(tilt) for mass, tilt in product(sides["load.mass"], sides["load.orientation"])]
    low, high = min(forces) + min(weights), max(forces) + max(weights)
    for values in product(*sides.values()):
        v = defaultdict(float, zip(sides, values, strict=True))
        weight, guide = v["load.mass"] * 9.80665 * math.sin(v["load.orientation"]), v["guide.friction"]
        kinks = {min(max(held, low), high) for held in (0.0, guide, -guide)}
        for way, held in product(WAYS[direction], {*kinks, *(force + weight for force in forces)}):
            for name, value in at_a_point(v, way * held, v["operation.speed"]):
                worst[name] = max(worst.get(name, -math.inf), value)
    found = statics(Sheet.of(sheet))
    rows = {name: row.worst for name, row in found.rows.items()}
    rows["torque"] = max(rows.get(f"{way}_torque", 0.0) for way in ("lifting", "lowering"))
    assert bool(found.back_drives) == ("holding_torque" in rows) == (worst["holding_torque"] > 0)
    assert found.back_drives or "drop" not in of_statics(found)[0]
    if "lifting_efficiency" in worst:
        worst["lifting_efficiency"] *= -1 if worst.get("without load", 0.0) <= 0 else 0
    for name in worst.keys() - {"without load", *({"holding_torque"} - rows.keys())}:
        assert rows[name] == pytest.approx(worst[name], rel=1e-6, abs=1e-12), name
    there = {"lifting_efficiency", "starting_torque"}
    assert there & rows.keys() == there & worst.keys()
