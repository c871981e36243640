"""Random data sheets of catalogue-like drives in plain numbers, and what they say of a drive, by closed forms."""

import math
from itertools import product
from typing import Any

import numpy as np

from benchmarks.sheets.own_motion import GOES_ON, NAMES, ends, grows

TURN = 2 * math.pi
THREADS = {"Tr 8x1.5": (8, 1.5, 1.5), "Tr 8x8 P2": (8, 8, 2), "Tr 10x2": (10, 2, 2), "Tr 12x6 P3": (12, 6, 3),
           "Tr 16x4": (16, 4, 4), "Tr 20x4": (20, 4, 4), "Tr 30x24 P6": (30, 24, 6)}  # fmt: skip
# Entries, their units, how often they are given, and between which values in the units of the sheet.
ENTRIES = {
    "screw.inertia": ("kg cm^2", 0.5, 1e-2, 1), "screw.length": ("mm", 1.0, 100, 800),
    "screw.diameter": ("mm", 0.3, 8, 25),
    "coupling.inertia": ("kg cm^2", 0.2, 1e-3, 0.1), "coupling.gear_ratio": ("", 0.1, 1, 5),
    "coupling.stiffness": ("N m/rad", 1.0, 0.5, 300), "motor.inertia": ("kg cm^2", 0.4, 0.03, 3),
    "motor.bandwidth": ("Hz", 0.4, 5, 100), "motor.holding_torque": ("N cm", 0.4, 10, 500),
    "motor.integral_gain": ("N m/rad", 1.0, 0.1, 30), "motor.speed_gain": ("N m s/rad", 0.8, 1e-3, 0.3),
    "coupling.damping": ("N m s/rad", 0.3, 1e-5, 1e-2), "damping.rotational": ("N m s/rad", 0.65, 1e-6, 5e-3),
    "bearing.viscous": ("N m s/rad", 0.1, 1e-6, 1e-4), "damping.translational": ("N s/m", 0.65, 0.5, 3000),
    "load.mass": ("kg", 1.0, 0.5, 700), "load.force": ("N", 0.8, 5, 3000), "load.orientation": ("deg", 0.2, 1, 60),
    "operation.speed": (("rpm", "rad/s", "mm/s"), 1.0, 0.1, 50), "friction.coefficient": ("", 1.0, 0.04, 0.35),
    "friction.stribeck_rise": ("", 0.25, 0.01, 0.15), "friction.stribeck_speed": ("mm/s", 1.0, 0.5, 60),
    "friction.slope": ("s/m", 0.25, 1e-3, 0.5), "bearing.torque": ("mN m", 0.25, 0.2, 20),
    "bearing.collar.coefficient": ("", 0.12, 0.03, 0.2), "bearing.collar.mean_diameter": ("mm", 1.0, 10, 40),
    "guide.friction": ("N", 0.25, 0.5, 100), "thread.lead": ("mm", 1.0, 1, 15),
    "thread.pitch_diameter": ("mm", 1.0, 8, 30), "thread.half_angle": ("deg", 0.6, 14.5, 30),
    "friction.static": ("", 0.5, 1.05, 2), "bearing.static": ("mN m", 0.6, 1.05, 2),
    "guide.static": ("N", 0.6, 1.05, 2),
}  # fmt: skip
SIZES = {"mm": 1e-3, "kg cm^2": 1e-4, "N cm": 1e-2, "deg": TURN / 360, "rpm": TURN / 60, "mm/s": 1e-3, "mN m": 1e-3}
EITHER = {
    "screw.inertia": ("screw.length", "screw.diameter"),
    "motor.holding_torque": ("motor.integral_gain", "motor.speed_gain"),
    "motor.bandwidth": ("motor.integral_gain", "motor.speed_gain", "motor.holding_torque"),
}  # fmt: skip
NEEDS = {
    "motor.bandwidth": "motor.inertia", "motor.holding_torque": "motor.inertia", "coupling.damping": "motor.inertia",
    "motor.integral_gain": "motor.inertia", "motor.speed_gain": "motor.integral_gain",
    "friction.stribeck_speed": "friction.stribeck_rise", "bearing.static": "bearing.torque",
    "bearing.collar.mean_diameter": "bearing.collar.coefficient", "guide.static": "guide.friction",
}  # fmt: skip
OWN = {
    "c_x": "damping.translational", "mu": "friction.coefficient", "mu_s": "friction.static", "slope": "friction.slope",
    "rise": "friction.stribeck_rise", "v_s": "friction.stribeck_speed", "T": "bearing.torque", "F": "guide.friction",
    "T_s": "bearing.static", "F_s": "guide.static", "mu_b": "bearing.collar.coefficient", "m": "load.mass",
    "d_b": "bearing.collar.mean_diameter",
}  # fmt: skip
Place = tuple[int, float, float]  # direction, speed of the screw [rad/s], force [N]


class OwnSheet:
    """A random sheet, ``written`` for the package; ``entries``: kind and two numbers of each, in SI units.

    ``near``: two of three are brought next to where jerks end, or nudges decay.
    """

    def __init__(self, seed: int | list[int], near: bool = True) -> None:
        self.rng, self.entries = np.random.default_rng([67, *np.ravel(seed)]), {}
        self.written: dict[str, Any] = {"name": f"drive {seed}"}
        self.size = self.rng.choice([*THREADS, ""])
        self.tilt = self.one(["horizontal", "vertical"])
        self.directions = {"out": (1,), "back": (-1,), "both": (1, -1)}[self.put("operation.direction", self.one(
            ["out", "back", "both"]))]  # fmt: skip
        self.unit, left_out = self.one(ENTRIES["operation.speed"][0]), set()
        for path, (unit, share, low, high) in ENTRIES.items():
            needed = NEEDS.get(path, path) == path or NEEDS[path] in self.entries
            if path in left_out or not needed or (self.size and "thread" in path) or self.rng.random() > share:
                continue
            value, last = self.power(low, high), path.split(".")[-1]
            if last == "static":
                parts = [NEEDS.get(path, "friction.coefficient"), "friction.stribeck_rise"][: 2 if not unit else 1]
                value *= 1.3 * sum(self.ends(p)[1] for p in parts if p in self.entries) / SIZES.get(unit, 1.0)
            if path in ("load.force", "friction.slope", "load.orientation"):
                value *= self.one([-1, 1])
            left_out |= {*EITHER.get(path, ())}
            self.enter(path, value, self.unit if last == "speed" else unit)
        if self.size:
            self.put("thread.size", str(self.size))
        if "load.orientation" not in self.entries:
            self.put("load.orientation", "vertical" if "load.force" not in self.entries else self.tilt)
            self.tilt = self.written["load"]["orientation"]
        self.balance(int(np.ravel(seed)[-1]) % 3 if near else 0)

    def one(self, options):
        return options[int(self.rng.integers(len(options)))]

    def power(self, low: float, high: float) -> float:
        return math.exp(self.rng.uniform(math.log(low), math.log(high)))

    def put(self, path: str, text: Any) -> Any:
        *parts, last = path.split(".")
        part = self.written
        for name in parts:
            part = part.setdefault(name, {})
        part[last] = text
        return text

    def enter(self, path: str, value: float, unit: str, kind: str = "") -> None:
        """Put an entry there as one value, a range or a distribution, with six digits in its unit."""
        width = 0.01 if "thread" in path or "diameter" in path else self.power(0.03, 0.25)
        width = self.power(0.2, 0.8) if path in ("load.force", "operation.speed") else width
        kind = kind or self.one(["value", "value", "range", "normal", "lognormal"])
        kind = "range" if kind == "lognormal" and (value < 0 or "static" in path) else kind
        pair = {"range": sorted([value * (1 - width), value * (1 + width)]), "normal": [value, abs(value) * width / 4]}
        numbers = [float(f"{x:.6g}") for x in pair.get(kind, [value])]
        texts: list[Any] = [f"{x!r} {unit}" if unit else x for x in numbers]
        form: Any = {"value": texts[0], "range": texts, "normal": dict(zip(("mean", "std"), texts, strict=False))}
        numbers = [x * SIZES.get(unit, 1.0) for x in numbers]
        if kind == "lognormal":
            factor = float(f"{1 + width / 3:.4g}")
            form[kind], numbers = {"median": texts[0], "factor": factor}, [*numbers, factor]
        self.put(path, form[kind])
        self.entries[path] = kind, *numbers

    def ends(self, path: str) -> tuple[float, float]:
        kind, a, b = (*self.entries[path], self.entries[path][1])[:3]
        return (a - 4 * b, a + 4 * b) if kind == "normal" else (a / b**4, a * b**4) if kind == "lognormal" else (a, b)

    @property
    def window(self) -> list[str]:
        return [path for path in ("load.force", "operation.speed") if self.entries.get(path, "v")[0] == "range"]

    @property
    def random(self) -> list[str]:
        return [path for path, entry in self.entries.items() if entry[0] != "value" and path not in self.window]

    @property
    def law(self) -> bool:
        return "friction.stribeck_rise" in self.entries or "friction.static" in self.entries

    def middles(self) -> dict[str, float]:
        return {path: sum(self.ends(path)) / 2 if e[0] == "range" else e[1] for path, e in self.entries.items()}

    def draws(self, count: int) -> list[dict[str, float]]:
        """Return entries of random drives."""
        rng, found = np.random.default_rng(68), [self.middles() for _ in range(count)]
        for one, path in product(found, self.random):
            kind, a, b = self.entries[path]
            score = np.clip(rng.normal(), -4, 4)
            one[path] = (
                a + (b - a) * rng.random() if kind == "range" else a + b * score if kind == "normal" else a * b**score
            )
        return found

    def corners(self, most: int) -> list[dict[str, float]]:
        """Return entries at ends of the uncertain ones, so many of the combinations."""
        pairs = {path: self.ends(path) for path in self.random}
        rows = np.random.default_rng(69).integers(0, 2, (most if len(pairs) > 5 else 2 ** len(pairs), len(pairs)))
        rows = rows if len(pairs) > 5 else np.array([*product((0, 1), repeat=len(pairs))])
        return [self.middles() | {path: pairs[path][k] for path, k in zip(pairs, row, strict=True)} for row in rows]

    def quantities(self, e: dict[str, float], what: str = "", factor: float = 1.0) -> dict[str, Any]:
        """Return the quantities of a drive from its entries, one of them times a factor: what follows from it does."""

        def own(name: str, value: float) -> float:
            return value * factor if name == what else value

        if self.size:
            outer, lead, pitch = (1e-3 * x for x in THREADS[self.size])
            diameter, half_angle = outer - pitch / 2, math.radians(15)
        else:
            lead, diameter = e["thread.lead"], e["thread.pitch_diameter"]
            half_angle = e.get("thread.half_angle", 0.0)
        q: dict[str, Any] = {name: own(name, e.get(path, 0.0)) for name, path in OWN.items()}
        q |= {"lead": own("lead", lead), "diameter": own("diameter", diameter), "exponent": 1}
        q["half_angle"], gear = own("half_angle", half_angle), e.get("coupling.gear_ratio", 1.0) ** 2
        cylinder = 7850 * math.pi / 32 * e.get("screw.diameter", q["diameter"]) ** 4 * e.get("screw.length", 0.0)
        q["I"] = own("I", e.get("screw.inertia", cylinder) + e.get("coupling.inertia", 0.0))
        q["k"], q["d"] = own("k", e["coupling.stiffness"] * gear), own("d", e.get("coupling.damping", 0.0) * gear)
        q["c"] = own("c", e.get("damping.rotational", 0.0) + e.get("bearing.viscous", 0.0))
        q["J"], rate = own("J", e.get("motor.inertia", 0.0) * gear), TURN * e.get("motor.bandwidth", 0.0)
        gains = e.get("motor.integral_gain", e.get("motor.holding_torque", 0.0) * 50), e.get("motor.speed_gain", 0.0)
        k_i, k_p = (rate**2 * (q["J"] + q["I"]) / 4, rate * (q["J"] + q["I"])) if rate else (x * gear for x in gains)
        q["K_i"], q["K_p"] = own("K_i", k_i), own("K_p", k_p)
        angle = {"horizontal": 0.0, "vertical": math.pi / 2}[self.tilt]
        q["weight"] = q["m"] * 9.80665 * math.sin(e.get("load.orientation", angle))
        for name, path, scale in (("force", "load.force", 1.0), ("speed", "operation.speed", TURN / q["lead"])):
            pair = self.ends(path) if path in self.window else (e.get(path, 0.0),) * 2
            q[name] = [own(name, x * (scale if name == "speed" and self.unit == "mm/s" else 1.0)) for x in pair]
        return q

    def at(self, q: dict[str, Any], place: Place, law: bool | None = None) -> np.ndarray:
        """Return a drive at a point of operation as ``ends`` and ``grows`` take it.

        Friction without a law is that at the speed, unless ``law`` asks for its slope.
        """
        direction, speed, force = place
        tangent, law = q["lead"] / (math.pi * q["diameter"]), self.law if law is None else law
        cosine = 1 / math.sqrt(1 + tangent**2)
        flank = math.sqrt(1 + (cosine * math.tan(q["half_angle"])) ** 2)
        own = {name: q[name] * flank for name in ("mu", "mu_s", "rise", "slope")}
        own["slope"] *= law
        own["mu"] -= 0 if self.law else own["slope"] * q["diameter"] / 2 * speed / cosine
        own |= {"r": q["diameter"] / 2, "tan": tangent, "cos": cosine, "R": -(force + q["weight"]),
                "collar": q["mu_b"] * q["d_b"] / 2, "F_s": max(q["F"], q["F_s"]), "T_s": max(q["T"], q["T_s"]),
                "mu_s": own["mu_s"] or own["mu"] + own["rise"], "speed": direction * speed}  # fmt: skip
        return np.array([float({**q, **own}[name]) for name in NAMES])

    def places(self, q: dict[str, Any], dense: bool = False) -> list[Place]:
        """Ends and middle of the window, or more of it, also beside where nothing presses the threads."""
        speeds, found = [*q["speed"][:1], *np.geomspace(*q["speed"], 9 if dense else 3)[1:-1], q["speed"][1]], []
        for way, w in product(self.directions, speeds[:1] if speeds[0] == speeds[-1] else speeds):
            low, high = q["force"]
            none = -q["weight"] - way * (q["F"] + q["lead"] / TURN * q["c_x"] * w)
            forces = {*np.linspace(low, high, 5 if dense else 3).tolist()}
            forces |= {none + x * (high - low) for x in (-1e-3, 1e-3)} if dense and low < none < high else set()
            found += [(way, w, force) for force in sorted(forces)]
        return found

    def growth(self, q: dict[str, Any]) -> float:
        """The fastest growth of a small nudge anywhere in the window, over the size of its rate."""
        return float(grows(np.array([self.at(q, place, law=True) for place in self.places(q, dense=True)])).max())

    def end(self, q: dict[str, Any], place: Place, knock: float | None = None, most: int = 250_000):
        return ends(self.at(q, place), knock, most)

    def going_on(self, q: dict[str, Any], knock: float | None = None, most: int = 250_000) -> list[Place]:
        """Return where in the window motions from rest, or after a knock, go on."""
        return [place for place in self.places(q) if self.end(q, place, knock, most)[0] == GOES_ON]

    def balance(self, kind: int) -> None:
        """Leave out a motor that cannot do it; bring a third next to where jerks end, a third to where nudges decay."""
        q = self.quantities(self.middles())
        load = (
            (max(map(abs, q["force"])) + abs(q["weight"])) * q["diameter"] * (q["mu"] + q["lead"] / q["diameter"] / 3)
        )
        if q["J"] and load > 5 * q["K_i"]:
            self.written.pop("motor")
            self.written["coupling"].pop("damping", None)
            self.entries = {p: e for p, e in self.entries.items() if "motor" not in p and p != "coupling.damping"}
            q = self.quantities(self.middles())
        beside = self.rng.uniform(0.97, 1.12)
        if kind == 1:
            speeds = q["speed"][0] * np.geomspace(0.02, 50, 40)
            jerky = [bool(self.going_on(q | {"speed": [speed, speed]}, most=20_000)) for speed in speeds.tolist()]
            if True in jerky and not jerky[-1]:
                turns = TURN / q["lead"] if self.unit == "mm/s" else 1.0
                edge = speeds[len(jerky) - jerky[::-1].index(True)] / turns / SIZES.get(self.unit, 1.0)
                self.enter("operation.speed", edge * beside, self.unit, "normal")
        elif kind == 2 and "bearing.viscous" not in self.entries:
            wave = math.sqrt(q["I"] * q["k"])
            grows = [self.growth(q | {"c": c}) > 0 for c in wave * np.geomspace(1e-4, 10, 80)]
            if True in grows and not grows[-1]:
                edge = wave * np.geomspace(1e-4, 10, 80)[len(grows) - grows[::-1].index(True)]
                self.enter("damping.rotational", edge * beside, "N m s/rad", "range")
