"""Newton's laws of a drive with any parts, body by body, with the forces between them as unknowns.

Nothing is eliminated by hand: at every instant one linear system gives the accelerations, the contact force n, the
torque τ of the threads and the friction that holds a body. Nothing of the library is used but the values of a drive.
Numbers are doubles, or flint's balls (:mod:`references.newton`).
"""

import math
import re
from collections import defaultdict

import numpy as np
from flint import arb_mat

SIGN = {"forward": 1, "backward": -1, "held": 0, "positive": 1, "negative": -1}
RATES = {"motor": "psi", "support": "y", "nut": "phi", "threads": "e"}  # coordinates of parts, in their order


def sign(x) -> int:
    return 1 if x > 0 else -1 if x < 0 else 0


def of(function: str, x):
    """A function of a double or of a ball."""
    return getattr(math, function)(x) if isinstance(x, float) else getattr(x, function)()


class Bodies:
    """A drive; its state is that of the package, (u, w) and two numbers for each part.

    ``drive``: its values by name; ``commanded``: the commanded speed as a function of time, ``input_speed`` by default;
    ``parts`` unless the drive says them.
    """

    def __init__(self, drive, commanded=None, parts=None, number=float) -> None:
        self.number, self.commanded = number, commanded or (lambda t: self.p["input_speed"])
        self.p = p = defaultdict(lambda: number(0), {name: number(x) for name, x in drive if x is not None})
        self.q = ["theta", *(RATES[part] for part in (drive.parts if parts is None else parts))]
        self.place = {name: 2 * k for k, name in enumerate(self.q)}
        self.cos, self.sin = of("cos", p["lead_angle"]), of("sin", p["lead_angle"])
        self.tangent = of("tan", p["lead_angle"])
        self.lead, self.sense = p["pitch_radius"] * self.tangent, sign(p["input_speed"])
        force = p["axial_force"] - self.lead * p["translation_damping"] * p["input_speed"]
        self.axial = force = force - p["slide_friction"] * self.sense
        self.collar = p["collar_friction"] * p["collar_radius"]
        self.steady_law = law = sign(force) * self.sense
        torque = (self.lever(law, self.mu(p["input_speed"])) + law * self.collar) * force if law else number(0)
        whole = p["support_damping"] * p["input_speed"] + p["bearing_friction"] * self.sense + torque
        steady = [number(0)] * (2 * len(self.q))
        steady[:2] = -whole / p["coupling_stiffness"], p["input_speed"]
        if "psi" in self.place:  # θ_m − Ω t, from which the coupling is wound up
            steady[self.place["psi"]] = -whole / p["integral_gain"]
            steady[0] -= whole / p["integral_gain"]
        for name, value, stiffness in (("y", force, "support_stiffness"), ("phi", torque, "nut_stiffness")):
            if name in self.place:
                steady[self.place[name]] = value / p[stiffness]
        self.steady = np.array(steady)

    @property
    def sliding(self) -> dict:
        """The mode of steady sliding."""
        turns = dict.fromkeys(("slip", "bearing", "slide"), self.sense)
        return turns | {"contact": self.sense * self.steady_law}

    def law(self, slip):
        """Sum of the friction law at a speed of the slip [rad/s], which may be negative."""
        p, speed = self.p, self.p["pitch_radius"] * abs(slip) / self.cos
        value = p["friction_coefficient"] + p["friction_slope"] * speed
        if p["stribeck_rise"] == 0:
            return value
        fading = speed / p["stribeck_speed"]
        return value + p["stribeck_rise"] * of("exp", -fading * fading if p["stribeck_exponent"] == 2 else -fading)

    def mu(self, slip):
        """Friction coefficient at a speed of the slip [rad/s]."""
        law = self.law(slip)
        return law if law > 0 else self.number(0)

    def static(self) -> float:
        p = self.p
        return p["static_friction_coefficient"] or p["friction_coefficient"] + p["stribeck_rise"]

    def lever(self, law: int, mu):
        """Torque of the threads over the axial contact force."""
        return self.p["pitch_radius"] * (law * mu - self.tangent) / (1 + law * mu * self.tangent)

    def mode(self, name: str) -> dict:
        """Slip, sign of the contact and way of each body in a mode, from its name in lower case."""
        kind, *words = re.split(r"_(?=screw_|nut_)", name)
        first, *contact = kind.removeprefix("slip_").split("_")
        slip = "held" if first == "rest" else first
        ways = dict(word.split("_") for word in words)
        found = {"slip": SIGN[slip], "contact": SIGN[contact[0]] if contact else 0}
        for body, word in (("bearing", "screw"), ("slide", "nut")):
            if self.most(body):
                found[body] = SIGN[ways[word]] if self.free(body) else SIGN[slip]
        return found

    def most(self, body: str) -> float:
        """What dry friction may hold a body with."""
        return max(self.p[f"{body}_friction"], self.p[f"{body}_static_friction"])

    def system(self, state, mode: dict, t: float = 0.0) -> tuple[list[str], list[list], list]:
        """Names of accelerations, n, τ and held friction, and the equations of them at an absolute state."""
        p, q, place = self.p, self.q, self.place
        names = [*q, "x", "n", "tau", *(body for body in ("bearing", "slide") if self.held(body, mode))]
        zero, matrix, sides = self.number(0), [], []
        column = {name: k for k, name in enumerate(names)}

        def at(name, rate=0):
            return state[place[name] + rate] if name in place else 0.0

        def equation(side, **terms):
            row = [zero] * len(names)
            for name, value in terms.items():
                if name in column:
                    row[column[name]] += value
            matrix.append(row)
            sides.append(side)

        slip, travel = self.speeds(state)
        bearing = p["bearing_friction"] * mode.get("bearing", 0)
        slide = p["slide_friction"] * mode.get("slide", 0)
        wound = p["coupling_stiffness"] * (at("theta") - at("psi"))
        if "psi" in place:
            wound += p["coupling_damping"] * (at("theta", 1) - p["input_speed"] - at("psi", 1))
            late = p["input_speed"] + at("psi", 1) - self.commanded(t)
            loop = p["integral_gain"] * at("psi") + p["speed_gain"] * late
            equation(wound - loop, psi=p["motor_inertia"])
        torque = -wound - p["support_damping"] * at("theta", 1)
        law, mu = mode["slip"] * mode["contact"], self.mu(slip)
        equation(torque - bearing, theta=p["screw_inertia"], tau=1, bearing=1, n=law * self.collar)
        equation(p["axial_force"] - p["translation_damping"] * travel - slide, x=p["mass"], n=1, slide=1)
        equation(0, x=1, theta=-self.lead, phi=self.lead, y=-1, e=-1)
        if "y" in place:
            spring = p["support_stiffness"] * at("y") + p["axial_support_damping"] * at("y", 1)
            equation(-spring, y=p["screw_mass"], n=-1)
        if "phi" in place:
            spring = p["nut_stiffness"] * at("phi") + p["nut_damping"] * at("phi", 1)
            equation(-spring, phi=p["nut_inertia"], tau=-1)
        normal = self.pressed(state)
        if mode["slip"]:
            equation(0, tau=1, n=-self.lever(law, mu))
        else:
            equation(0, theta=1, phi=-1)
        if "e" in place and mode["slip"]:
            equation(normal * (self.cos + law * mu * self.sin), n=1)
        elif "e" in place:
            equation(normal / self.cos, n=1, tau=-self.tangent / p["pitch_radius"])
        for body in names[len(q) + 3 :]:
            equation(0, **({"theta": 1} if body == "bearing" else {"x": 1}))
        return names, matrix, sides

    def speeds(self, state) -> tuple:
        """Speed of the slip of the threads, and that of the load."""
        own = {name: state[k + 1] for name, k in self.place.items()}
        slip = own["theta"] - own.get("phi", 0)
        return slip, self.lead * slip + own.get("y", 0) + own.get("e", 0)

    def pressed(self, state):
        """The normal force of compliant threads."""
        k = self.place.get("e")
        p = self.p
        return 0 if k is None else self.cos * (p["contact_stiffness"] * state[k] + p["contact_damping"] * state[k + 1])

    def forces(self, state, mode: dict, t: float = 0.0) -> dict:
        """Accelerations, n, N, τ and held friction at an absolute state."""
        names, matrix, sides = self.system(state, mode, t)
        if self.number is float:
            rows = np.array(matrix)
            scale = np.abs(rows).max(axis=0)  # of masses and inertias
            solved = (np.linalg.solve(rows / scale, sides) / scale).tolist()
        else:
            solved = arb_mat(matrix).solve(arb_mat(len(sides), 1, sides)).entries()
        found, normal, (slip, travel) = dict(zip(names, solved, strict=True)), self.pressed(state), self.speeds(state)
        law = mode["slip"] * mode["contact"]
        found["tau"] += law * self.collar * found["n"]  # at rest it is that of both already
        if "e" not in self.place and mode["slip"]:
            normal = found["n"] / (self.cos + law * self.mu(slip) * self.sin)
        elif "e" not in self.place:
            normal = found["n"] * self.cos - found["tau"] * self.sin / self.p["pitch_radius"]
        return found | {"N": normal, "slip": slip, "travel": travel, "screw": state[1]}

    def held(self, body: str, mode: dict) -> bool:
        """Whether a body that may slide on its own is held."""
        return self.free(body) and mode.get(body) == 0

    def rate(self, t: float, state: np.ndarray, mode: dict) -> np.ndarray:
        """Rate of the absolute state at a time; the angles of screw and motor are those from the command."""
        found, rate = self.forces(state, mode, t), np.empty(len(state), dtype=type(state[0]))
        for name, k in self.place.items():
            rate[k], rate[k + 1] = state[k + 1], found[name]
        rate[0] -= self.commanded(t)
        if "psi" in self.place:
            rate[self.place["psi"]] += self.p["input_speed"] - self.commanded(t)
        return rate

    def margins(self, state: np.ndarray, mode: dict) -> dict:
        """What a mode takes for granted, as numbers that are positive while it lasts.

        By contact, direction (0 for what moves already) and unit: speeds and the contact force in their directions, and
        friction that is left to what is at rest before it moves in a direction. Sizes do not matter.
        """
        p, found = self.p, self.forces(state, mode)
        left = {}
        if mode["contact"]:
            left["contact", 0, "force"] = mode["contact"] * found["N" if "e" in self.place else "n"]
        if mode["slip"]:
            left["slip", 0, "speed"] = mode["slip"] * found["slip"]
        else:
            for way in (1, -1):
                most = self.braked(way, found["n"], mode, self.static(), self.most)
                if not self.free("slide"):  # which may relieve the threads so much that slip could not go on
                    slow, sliding = self.mu(self.number(0)), lambda body: p[f"{body}_friction"]
                    most = max(most, self.braked(way, found["n"], mode, slow, sliding))
                left["slip", way, "torque"] = most - way * found["tau"]
        for body, name, unit in (("bearing", "screw", "torque"), ("slide", "travel", "force")):
            if body in mode and self.free(body) and mode[body]:
                left[body, 0, "speed" if body == "bearing" else "travel"] = mode[body] * found[name]
            elif body in mode and self.free(body):
                left |= {(body, way, unit): self.most(body) - way * found[body] for way in (1, -1)}
        return left

    def braked(self, way: int, normal, mode: dict, mu, dry):
        """Torque against slip in a direction of what then begins to move together; ``dry``: frictions by body.

        At rest the threads carry ``normal``, and n and τ have the share of a bearing that turns with the slip.
        """
        slide, bearing = (0.0 if self.free(body) else way * dry(body) for body in ("slide", "bearing"))
        load = normal if self.free("slide") else self.p["axial_force"] - slide
        load -= bearing * self.tangent / self.p["pitch_radius"] if "e" in self.place else 0.0
        law = way * (mode["contact"] or sign(load) or way)
        return way * (bearing + (self.lever(law, mu) + law * self.collar) * load)

    def excess(self, state: np.ndarray, mode: dict, size: np.ndarray) -> float:
        """By how much a state violates what its mode takes for granted, over the sizes of forces and speeds."""
        p, found = self.p, self.forces(state, mode)
        force = abs(p["axial_force"]) + abs(found["n"]) + self.most("slide") + 1e-6
        torque = p["pitch_radius"] * force + self.most("bearing") + p["coupling_stiffness"] * size[0]
        sizes = {"force": force, "torque": torque, "speed": size[1], "travel": self.lead * size[1]}
        held = {"slip": sizes["speed"], "screw": sizes["speed"], "travel": sizes["travel"]}
        broken = [-margin / sizes[unit] for (*_, unit), margin in self.margins(state, mode).items()]
        for contact, name in (("slip", "slip"), ("bearing", "screw"), ("slide", "travel")):
            if mode.get(contact, 1) == 0 and (contact == "slip" or self.free(contact)):
                broken.append(abs(found[name]) / held[name])
        return max(broken)

    def free(self, body: str) -> bool:
        """Whether a body slides on its own while the threads slip or rest."""
        return "phi" in self.place if body == "bearing" else "y" in self.place or "e" in self.place
