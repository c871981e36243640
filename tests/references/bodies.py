"""Newton's laws of a drive with any parts, body by body, with the forces between them as unknowns.

Nothing is eliminated by hand: in a mode one linear system gives the accelerations, the contact force n, the torque τ of
the threads and the friction that holds a body, each as a row over the state, the commanded speed, its rate, the time,
and 1. Nothing of the library is used but the values of a drive. Numbers are flint's balls.
"""

import re
from collections import defaultdict

import numpy as np
from flint import arb, arb_mat, ctx

SIGN = {"forward": 1, "backward": -1, "held": 0, "positive": 1, "negative": -1}
RATES = {"motor": "psi", "support": "y", "nut": "phi", "threads": "e"}  # coordinates of parts, in their order


def sign(x) -> int:
    """Sign of a number; 0 of a ball that may be zero."""
    return 1 if x > 0 else -1 if x < 0 else 0


class Bodies:
    """A drive; its state is that of the package, (u, w) and two numbers for each part.

    ``drive``: its values by name; ``parts`` unless the drive says them.
    """

    def __init__(self, drive, parts=None) -> None:
        self.precision = ctx.prec
        self.p = p = defaultdict(arb, {name: arb(x) for name, x in drive if x is not None})
        self.q = ["theta", *(RATES[part] for part in (drive.parts if parts is None else parts))]
        self.place, self.size = {name: 2 * k for k, name in enumerate(self.q)}, 2 * len(self.q)
        self.cos, self.sin, self.tangent = p["lead_angle"].cos(), p["lead_angle"].sin(), p["lead_angle"].tan()
        self.lead, self.sense = p["pitch_radius"] * self.tangent, sign(p["input_speed"])
        self.collar = p["collar_friction"] * p["collar_radius"]
        self.rows = np.array([[arb(int(i == j)) for j in range(self.size + 4)] for i in range(self.size + 4)])
        self.commanded, self.one = self.rows[-4], self.rows[-1]
        slides = self.at("y", 1) + self.at("e", 1)
        self.slip = self.at("theta", 1) - self.at("phi", 1)
        self.speeds = {"slip": self.slip, "bearing": self.at("theta", 1), "slide": self.lead * self.slip + slides}
        self.pressed = self.cos * (p["contact_stiffness"] * self.at("e") + p["contact_damping"] * self.at("e", 1))
        self.axial = p["axial_force"] - self.lead * p["translation_damping"] * p["input_speed"]
        self.axial -= p["slide_friction"] * self.sense
        self.steady_law = sign(self.axial) * self.sense
        self.steady = self.steady_state()

    def steady_state(self) -> np.ndarray:
        """State of steady sliding, but for the compression of compliant threads, from which e is counted."""
        p, law = self.p, self.steady_law
        torque = (self.lever(law, self.mu(p["input_speed"])) + law * self.collar) * self.axial if law else arb(0)
        whole = p["support_damping"] * p["input_speed"] + p["bearing_friction"] * self.sense + torque
        found = {"theta": -whole / p["coupling_stiffness"]}
        if "psi" in self.place:  # θ_m − Ω t, from which the coupling is wound up
            found["psi"] = -whole / p["integral_gain"]
            found["theta"] += found["psi"]
        for name, value, stiffness in (("y", self.axial, "support_stiffness"), ("phi", torque, "nut_stiffness")):
            if name in self.place:
                found[name] = value / p[stiffness]
        speeds = {"theta": p["input_speed"]}
        return np.array([x.get(name, arb(0)) for name in self.q for x in (found, speeds)])

    def at(self, name: str, rate: int = 0) -> np.ndarray:
        """The row of a coordinate or of its rate; of a part that is not there, zero."""
        return self.rows[self.place[name] + rate] if name in self.place else 0 * self.rows[0]

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
        return value + p["stribeck_rise"] * (-fading * fading if p["stribeck_exponent"] == 2 else -fading).exp()

    def mu(self, slip):
        """Friction coefficient at a speed of the slip [rad/s]."""
        law = self.law(slip)
        return law if law > 0 else arb(0)

    def static(self):
        return self.p["static_friction_coefficient"] if self.p["static_friction_coefficient"] > 0 else self.law(arb(0))

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
            if self.most(body) > 0:
                found[body] = SIGN[ways[word]] if self.free(body) else SIGN[slip]
        return found

    def most(self, body: str):
        """What dry friction may hold a body with."""
        return max(self.p[f"{body}_friction"], self.p[f"{body}_static_friction"])

    def free(self, body: str) -> bool:
        """Whether a body slides on its own while the threads slip or rest."""
        return "phi" in self.place if body == "bearing" else "y" in self.place or "e" in self.place

    def held(self, body: str, mode: dict) -> bool:
        """Whether a body that may slide on its own is held."""
        return self.free(body) and mode.get(body) == 0

    def equations(self, mode: dict, mu) -> tuple[list[str], arb_mat, list]:
        """Names of accelerations, n, τ and held friction, the matrix of the equations of them, and rows as its sides.

        Of the matrix and the sides one equation each depends on μ, and is affine in it.
        """
        p, at, rows, sides = self.p, self.at, [], []
        names = [*self.q, "x", "n", "tau", *(body for body in ("bearing", "slide") if self.held(body, mode))]

        def equation(side, **terms) -> None:
            rows.append([arb(terms.get(name, 0)) for name in names])
            sides.append(side)

        law, radius = mode["slip"] * mode["contact"], p["pitch_radius"]
        grip, bears = law * mu, self.cos + law * mu * self.sin
        wound = p["coupling_stiffness"] * (at("theta") - at("psi"))
        if "psi" in self.place:
            wound = wound + p["coupling_damping"] * (at("theta", 1) - p["input_speed"] * self.one - at("psi", 1))
            late = p["input_speed"] * self.one + at("psi", 1) - self.commanded
            loop = p["integral_gain"] * at("psi") + p["speed_gain"] * late
            equation(wound - loop, psi=p["motor_inertia"])
        rubbed = (
            wound + p["support_damping"] * at("theta", 1) + p["bearing_friction"] * mode.get("bearing", 0) * self.one
        )
        equation(-rubbed, theta=p["screw_inertia"], tau=1, bearing=1, n=law * self.collar)
        push = (p["axial_force"] - p["slide_friction"] * mode.get("slide", 0)) * self.one
        equation(push - p["translation_damping"] * self.speeds["slide"], x=p["mass"], n=1, slide=1)
        equation(at(""), x=1, theta=-self.lead, phi=self.lead, y=-1, e=-1)
        if "y" in self.place:
            spring = p["support_stiffness"] * at("y") + p["axial_support_damping"] * at("y", 1)
            equation(-spring, y=p["screw_mass"], n=-1)
        if "phi" in self.place:
            spring = p["nut_stiffness"] * at("phi") + p["nut_damping"] * at("phi", 1)
            equation(-spring, phi=p["nut_inertia"], tau=-1)
        if mode["slip"] and "e" in self.place:
            equation(bears * self.pressed, n=1)
            equation(radius * (grip - self.tangent) * self.cos * self.pressed, tau=1)
        elif mode["slip"]:
            equation(at(""), tau=1 + grip * self.tangent, n=-radius * (grip - self.tangent))
        else:
            equation(at(""), theta=1, phi=-1)
            if "e" in self.place:
                equation(self.pressed / self.cos, n=1, tau=-self.tangent / radius)
        for body in names[len(self.q) + 3 :]:
            equation(at(""), **({"theta": 1} if body == "bearing" else {"x": 1}))
        return names, arb_mat(rows), sides

    def forces(self, mode: dict, mu) -> dict:
        """Rows of accelerations, n, N, τ and held friction at a friction coefficient."""
        names, matrix, sides = self.equations(mode, mu)
        found = dict(zip(names, np.array(matrix.solve(arb_mat(list(map(list, sides)))).tolist()), strict=True))
        law = mode["slip"] * mode["contact"]
        normal = found["n"] / (self.cos + law * mu * self.sin)
        if "e" in self.place:
            normal = self.pressed
        elif not mode["slip"]:
            normal = found["n"] * self.cos - found["tau"] * self.sin / self.p["pitch_radius"]
        whole = found["tau"] + law * self.collar * found["n"]  # at rest it is that of both already
        return found | {"N": normal, "tau": whole}

    def rates(self, mode: dict, mu) -> np.ndarray:
        """Rows of the rates of all that rows are over."""
        found, rows = self.forces(mode, mu), []
        late = {"theta": self.commanded, "psi": self.commanded - self.p["input_speed"] * self.one}  # from the command
        for name in self.q:
            rows += [self.at(name, 1) - late.get(name, self.at("")), found[name]]
        return np.array([*rows, self.rows[-3], self.at(""), self.one, self.at("")])

    def margins(self, mode: dict, mu) -> dict:
        """What a mode takes for granted, as rows of what is positive while it lasts.

        By contact, direction (0 for what moves already) and unit: speeds and the contact force in their directions, and
        friction that is left to what is at rest before it moves in a direction. Sizes do not matter.
        """
        found, left = self.forces(mode, mu), {}
        if mode["contact"]:
            left["contact", 0, "force"] = mode["contact"] * found["N" if "e" in self.place else "n"]
        if mode["slip"]:
            left["slip", 0, "speed"] = mode["slip"] * self.slip
        else:
            for way in (1, -1):
                most = self.braked(way, found["n"], mode, self.static(), self.most)
                if not self.free("slide"):  # which may relieve the threads so much that slip could not go on
                    slow, sliding = self.mu(arb(0)), lambda body: self.p[f"{body}_friction"]
                    most = max(most, self.braked(way, found["n"], mode, slow, sliding), key=lambda row: row[-1])
                left["slip", way, "torque"] = most - way * found["tau"]
        for body, unit in (("bearing", "torque"), ("slide", "force")):
            if body in mode and self.free(body) and mode[body]:
                left[body, 0, "speed" if body == "bearing" else "travel"] = mode[body] * self.speeds[body]
            elif body in mode and self.free(body):
                left |= {(body, way, unit): self.most(body) * self.one - way * found[body] for way in (1, -1)}
        return left

    def braked(self, way: int, normal, mode: dict, mu, dry) -> np.ndarray:
        """Torque against slip in a direction of what then begins to move together; ``dry``: frictions by body.

        At rest the threads carry ``normal``, and n and τ have the share of a bearing that turns with the slip.
        """
        slide, bearing = (arb(0) if self.free(body) else way * dry(body) for body in ("slide", "bearing"))
        load = normal if self.free("slide") else (self.p["axial_force"] - slide) * self.one
        load = load - (bearing * self.tangent / self.p["pitch_radius"] if "e" in self.place else 0) * self.one
        law = way * (mode["contact"] or sign(load[-1]) or way)
        return way * (bearing * self.one + (self.lever(law, mu) + law * self.collar) * load)

    def values(self, rows, state, commanded=None) -> list:
        """What rows are at an absolute state."""
        speed = self.p["input_speed"] if commanded is None else commanded
        place = arb_mat([[arb(x)] for x in (*state, speed, 0, 0, 1)])
        return (arb_mat([list(row) for row in rows]) * place).entries()

    def own(self, state, mode: dict) -> dict:
        """Accelerations, forces and speeds at an absolute state, to as many digits as the drive was made with."""
        with ctx.workprec(self.precision):
            rows = self.forces(mode, self.mu(self.values([self.slip], state)[0])) | self.speeds
            return dict(zip(rows, self.values(rows.values(), state), strict=True))
