"""Newton's laws of a drive with any parts, body by body, with the forces between them as unknowns, in doubles.

Nothing is eliminated by hand: at every instant one linear system gives the accelerations, the contact force n, the
torque τ of the threads and the friction that holds a body. Nothing of the library is used but the values of a drive.
"""

import math
import re

import numpy as np
from scipy.integrate import solve_ivp

SIGN = {"forward": 1, "backward": -1, "held": 0, "positive": 1, "negative": -1}
RATES = {"motor": "psi", "support": "y", "nut": "phi", "threads": "e"}  # coordinates of parts, in their order


class Bodies:
    """A drive; its state is that of the package, (u, w) and two numbers for each part.

    ``commanded``: the commanded speed as a function of time, ``input_speed`` by default.
    """

    def __init__(self, drive, commanded=None) -> None:
        self.commanded = commanded or (lambda t: drive.input_speed)
        self.p = {name: getattr(drive, name) or 0.0 for name in type(drive).model_fields}
        self.q = ["theta", *(RATES[part] for part in drive.parts)]
        self.place = {name: 2 * k for k, name in enumerate(self.q)}
        p = self.p
        self.tangent = math.tan(p["lead_angle"])
        self.lead, self.sense = p["pitch_radius"] * self.tangent, math.copysign(1, p["input_speed"])
        force = p["axial_force"] - self.lead * p["translation_damping"] * p["input_speed"]
        force -= p["slide_friction"] * self.sense
        self.collar = p["collar_friction"] * p["collar_radius"]
        law = math.copysign(1, force * self.sense)
        torque = (self.lever(law, self.mu(p["input_speed"])) + law * self.collar) * force
        whole = p["support_damping"] * p["input_speed"] + p["bearing_friction"] * self.sense + torque
        self.steady = np.zeros(2 * len(self.q))
        self.steady[:2] = -whole / p["coupling_stiffness"], p["input_speed"]
        if "psi" in self.place:  # θ_m − Ω t, from which the coupling is wound up
            self.steady[self.place["psi"]] = -whole / p["integral_gain"]
            self.steady[0] -= whole / p["integral_gain"]
        for name, value, stiffness in (("y", force, "support_stiffness"), ("phi", torque, "nut_stiffness")):
            if name in self.place:
                self.steady[self.place[name]] = value / p[stiffness]

    def law(self, slip: float) -> float:
        """Sum of the friction law at a speed of the slip [rad/s], which may be negative."""
        p, speed = self.p, self.p["pitch_radius"] * abs(slip) / math.cos(self.p["lead_angle"])
        fading = (speed / p["stribeck_speed"]) ** p["stribeck_exponent"] if p["stribeck_speed"] else 0.0
        return p["friction_coefficient"] + p["stribeck_rise"] * math.exp(-fading) + p["friction_slope"] * speed

    def mu(self, slip: float) -> float:
        """Friction coefficient at a speed of the slip [rad/s]."""
        return max(self.law(slip), 0.0)

    def static(self) -> float:
        p = self.p
        return p["static_friction_coefficient"] or p["friction_coefficient"] + p["stribeck_rise"]

    def lever(self, law: float, mu: float) -> float:
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
            if self.p[f"{body}_friction"]:
                found[body] = SIGN[ways[word]] if self.free(body) else SIGN[slip]
        return found

    def forces(self, state: np.ndarray, mode: dict, t: float = 0.0) -> dict:
        """Accelerations, n, N, τ and held friction at an absolute state."""
        p, q, place = self.p, self.q, self.place
        names = [*q, "x", "n", "tau", *(body for body in ("bearing", "slide") if self.held(body, mode))]
        matrix, sides, rows = np.zeros((len(names), len(names))), np.zeros(len(names)), iter(range(len(names)))
        column = {name: k for k, name in enumerate(names)}

        def at(name, rate=0):
            return state[place[name] + rate] if name in place else 0.0

        def equation(side, **terms):
            row = next(rows)
            sides[row] = side
            for name, value in terms.items():
                if name in column:
                    matrix[row, column[name]] += value

        slip = at("theta", 1) - at("phi", 1)
        travel = self.lead * slip + at("y", 1) + at("e", 1)
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
        normal = math.cos(p["lead_angle"]) * (p["contact_stiffness"] * at("e") + p["contact_damping"] * at("e", 1))
        sine, cosine = math.sin(p["lead_angle"]), math.cos(p["lead_angle"])
        if mode["slip"]:
            equation(0, tau=1, n=-self.lever(law, mu))
        else:
            equation(0, theta=1, phi=-1)
        if "e" in place and mode["slip"]:
            equation(normal * (cosine + law * mu * sine), n=1)
        elif "e" in place:
            equation(normal / cosine, n=1, tau=-self.tangent / p["pitch_radius"])
        for body in names[len(q) + 3 :]:
            equation(0, **({"theta": 1} if body == "bearing" else {"x": 1}))
        scale = np.abs(matrix).max(axis=0)  # of masses and inertias
        found = dict(zip(names, np.linalg.solve(matrix / scale, sides) / scale, strict=True))
        found["tau"] += law * self.collar * found["n"]  # at rest it is that of both already
        if "e" not in place:
            normal = found["n"] * cosine - found["tau"] * sine / p["pitch_radius"]
            normal = found["n"] / (cosine + law * mu * sine) if mode["slip"] else normal
        return found | {"N": normal, "slip": slip, "travel": travel, "screw": at("theta", 1)}

    def held(self, body: str, mode: dict) -> bool:
        """Whether a body that may slide on its own is held."""
        return self.free(body) and mode.get(body) == 0

    def rate(self, t: float, state: np.ndarray, mode: dict) -> np.ndarray:
        """Rate of the absolute state at a time; the angles of screw and motor are those from the command."""
        found, rate = self.forces(state, mode, t), np.empty_like(state)
        for name, k in self.place.items():
            rate[k], rate[k + 1] = state[k + 1], found[name]
        rate[0] -= self.commanded(t)
        if "psi" in self.place:
            rate[self.place["psi"]] += self.p["input_speed"] - self.commanded(t)
        return rate

    def moved(self, state: np.ndarray, mode: dict, times: np.ndarray, size: np.ndarray):
        """Absolute states (times, n) along an arc that begins at the first time; apart where the law comes to zero."""

        def kink(_, x):
            return self.law(x[1] - (x[self.place["phi"] + 1] if "phi" in self.place else 0.0)) if mode["slip"] else 1.0

        def run(begin, state, end, **more):
            return solve_ivp(
                lambda t, x: self.rate(t, x, mode), (begin, end), state, "DOP853", rtol=3e-14, atol=1e-16 * size, **more
            )

        kink.terminal = True
        found, time = [state], times[0]
        while len(found) < len(times):
            done = run(time, state, times[-1], t_eval=times[len(found) :], events=kink)
            found += list(done.y.T) if len(done.t) else []
            if done.status == 1:  # between steps it is less exact: once more, and over the kink by next to nothing
                (stop,) = done.t_events[0]
                on, step = run(time, state, stop).y[:, -1], min(1e-12 * times[-1], times[-1] - stop)
                time, state = stop + step, on + step * self.rate(stop, on, mode)
            elif done.status < 0:  # where the threads jam the last step would be too small
                assert len(found) == len(times) - 1
                found.append(run(time, state, times[-1]).y[:, -1])
        return np.array(found)

    def excess(self, state: np.ndarray, mode: dict, size: np.ndarray) -> float:
        """By how much a state violates what its mode takes for granted, over the sizes of forces and speeds."""
        p, found = self.p, self.forces(state, mode)
        force, speed = abs(p["axial_force"]) + abs(found["n"]) + p["slide_friction"] + 1e-6, size[1]
        torque = p["pitch_radius"] * force + p["bearing_friction"] + p["coupling_stiffness"] * size[0]
        broken = []
        if mode["slip"]:
            broken += [-mode["slip"] * found["slip"] / speed, -mode["contact"] * found["n"] / force]
        else:
            broken.append(abs(found["slip"]) / speed)
            tied = {b: p[f"{b}_friction"] for b in ("bearing", "slide") if b in mode and not self.free(b)}
            for way in (1, -1):
                load = p["axial_force"] - way * p["slide_friction"] if "slide" in tied else found["n"]
                law = math.copysign(1, way * load)
                most = (self.lever(law, self.static()) + law * self.collar) * load * way + tied.get("bearing", 0)
                broken.append((way * found["tau"] - most) / torque)
        for body, name, limit in (("bearing", "screw", torque), ("slide", "travel", force)):
            if body in mode and self.free(body):
                own = speed if body == "bearing" else self.lead * speed
                if mode[body]:
                    broken.append(-mode[body] * found[name] / own)
                else:
                    broken += [abs(found[name]) / own, (abs(found[body]) - p[f"{body}_friction"]) / limit]
        return max(broken)

    def free(self, body: str) -> bool:
        """Whether a body slides on its own while the threads slip or rest."""
        return "phi" in self.place if body == "bearing" else "y" in self.place or "e" in self.place
