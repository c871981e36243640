r"""Newton's laws of a drive with its parts, solved in each mode.

          Ω t                θ, x_1                        x = r_m tan λ (θ − θ_2) + x_1 + e,  θ_2
    motor ──/\/\/\── k ──▶ (I, m_1) screw ═══threads═══▶ [m, I_2] nut ──▶ R
                            turning: c, T_0 to ground      along: c_x, F_0 to ground
                            along: k_1 ∥ c_1 to ground     turning: k_2 ∥ c_2 to ground

A motor with a speed controller may drive the coupling: J θ_m″ = K_i (Ω t − θ_m) + K_p (Ω − θ_m′) − T, and then
z = θ − θ_m. A part that a drive does not have is rigid, and its coordinate is absent: the shift x_1 of the screw
belongs to the axial ``support`` (Sect. 5.6), the angle θ_2 to a rotating ``nut`` (Sect. 5.8), the mismatch e of nut and
screw to compliant ``threads`` (Sect. 5.5). With the axial contact force n, the torque τ of the threads,
T = −k z − d z′, the torque of the screw T − c θ′ − T_0 sgn θ′, S = k_1 x_1 + c_1 x_1′, S_2 = k_2 θ_2 + c_2 θ_2′ and
P = R − c_x x′ − F_0 sgn x′,

    I θ″ = T − c θ′ − T_0 sgn θ′ − τ,      m_1 x_1″ = n − S,      I_2 θ_2″ = τ − S_2,      m x″ = P − n.

The threads slip at ω = θ′ − θ_2′. In slip under the law s = sgn ω sgn n the torque is τ = r_m ξ_s n; at rest ω = 0
stays so. Rigid threads have e = 0, and then n = Q / (positive factor × Γ_s), where Q does not depend on the law and

    Γ_s = I_eff − ξ_s tan λ m_eff r_m²,    1 / I_eff = 1 / I + 1 / I_2,    1 / m_eff = 1 / m + 1 / m_1
                                                                                         (8.17, 8.27, 8.28, 8.33)

with the terms of the parts that are there. A thrust collar adds s μ_b r_b to r_m ξ_s, and τ is the torque of both.
Compliant threads carry N = cos λ (k_c e + c_c e′), and (5.16, 5.17, 8.6)

    n = N (cos λ + s μ sin λ) in slip,      n = N / cos λ + tan λ τ / r_m at rest.

The state is (u, w) as in the rigid drive, then the coordinate of each part that is there with its rate: those of
motor, support and nut less their values in steady sliding, where n = R − r_m tan λ c_x Ω − F_0 sgn Ω, and e itself.

Where the commanded speed changes as Ω(t) = Ω_0 + α t (docs/physics.md), time is one more state, the clock.

All that a mode does follows from one linear system, whose unknowns are the accelerations, n, τ and the friction that
holds a body. Its solution is made of affine functions of the state, *rows* of numbers (the constant last): balls of one
drive, or arrays of many.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain
from typing import Any

import numpy as np

from lsvib.drives import friction, mechanics
from lsvib.drives.drive import PARTS
from lsvib.drives.mechanics import plus, together
from lsvib.drives.names import BODIES, CLOCK, COORDINATES, Ways, own_frictions, sides_of_rest
from lsvib.systems.automaton import scaled
from lsvib.systems.exact.arithmetic import Row, added, double, nothing, root, sign

Equation = tuple[Mapping[str, Any], Row]  # coefficients of unknowns by their names, and what stands on the right


@dataclass(frozen=True)
class Solution:
    """Newton's laws solved in one mode: rows over the state.

    ``law``: s, 0 at rest; ``field``: rate of the state; ``frozen``: coordinates that keep a value; ``contact``: n [N];
    ``normal``: N [N]; ``torque``: τ less that of steady sliding [N m]; ``held``: friction [N m, N] that holds a body,
    by its name.
    """

    law: int
    field: tuple[Row, ...]
    frozen: Mapping[int, Any]
    contact: Row
    normal: Row
    torque: Row
    held: Mapping[str, Row]


class Mechanism:
    """A drive in steady sliding and around it, and the solution of its equations in any mode.

    Arguments: ``d``, its parameters as balls or as arrays of doubles; ``parts``, the names of those that are not rigid;
    ``slowest``: μ of slow sliding; ``command``: Ω_0 [rad/s] and α [rad/s²] of a commanded speed that changes, by the
    clock.

    ``states`` names the coordinates, ``place`` says where the displacement of a part stands among them. Of slide and
    bearing ``limits`` are the frictions in sliding [N, N m], ``holding`` those at rest; ``own`` are those whose body
    may slide or be held while the threads slip: elsewhere its speed is that of the slip.
    ``speed`` is the row of θ′, ``slip`` that of ω, ``nut_speed`` that of x′, ``nut_place`` that of x less its value in
    steady sliding, ``sliding`` that of the speed at which the threads slide, ``deflection`` that of z, ``commanded``
    that of Ω(t), ``away`` that of u′; ``force`` [N] and ``steady_law``, s_0, are those of steady sliding; ``sides``:
    the signs of n at rest, or 0 alone where it is constant; ``compliant``: whether the threads are, which N_0 then
    compresses by ``compression`` [m]; ``idle``: whether they have neither friction nor a force to carry, as those of a
    body behind a spring, so that n is not felt; ``braked``: what the ground brakes in steady sliding, the torque on the
    screw [N m] and the force on the load [N].
    """

    def __init__(self, d: Any, parts: Iterable[str], slowest: Any, command: tuple[Any, Any] | None = None) -> None:
        self.d, self.slowest, self.command = d, slowest, command
        self.parts = tuple(part for part in COORDINATES if part == "screw" or part in parts)
        self.states = tuple(chain.from_iterable(COORDINATES[part] for part in self.parts))
        self.states += (CLOCK,) if command else ()
        self._zeros = (0,) * len(self.states)
        self.place = {part: 2 * k for k, part in enumerate(self.parts)}
        self.compliant = "threads" in parts
        self.bodies = [part for part in self.parts if part in BODIES]
        sliding = {"bearing": d.bearing_friction, "slide": d.slide_friction}
        static = {"bearing": d.bearing_static_friction, "slide": d.slide_static_friction}
        self.limits = {name: limit for name, limit in sliding.items() if sign(limit) or sign(static[name])}
        self.holding = {name: static[name] if sign(static[name]) else self.limits[name] for name in self.limits}
        self.own = own_frictions(self.parts, [f"{name}_friction" for name in self.limits])
        self.tied = tuple(name for name in self.limits if name not in self.own)
        self.sides = sides_of_rest(self.parts)
        self.reach = d.pitch_radius * d.tan_lead
        self._bodies = cache(self._equations)
        self.commanded = (*self._zeros[1:], command[1], command[0]) if command else self.constant(d.input_speed)
        # rest then holds as much as slow sliding carries
        self.same = not any(map(sign, (d.static_friction_coefficient, *static.values())))
        of_law = (getattr(d, name) for name in friction.OF_SPEED)
        felt = d.friction_coefficient, d.static_friction_coefficient, *of_law, d.collar
        self.idle = not ({*parts} - {"motor"} or any(map(sign, (*felt, d.axial_force, self.limits.get("slide", 0)))))
        self.turning = sign(d.input_speed)
        xi = {s: self._factor(d.steady_friction, s) for s in (1, -1)}
        self.xi_rest = {s: self._factor(d.static_friction, s) for s in xi}
        self.turned = xi[1] * self.reach * d.pitch_radius  # ξ₊ tan λ r_m² [m²]
        self.braked = {  # by the ground in steady sliding
            "screw": d.support_damping * d.input_speed + self.limits.get("bearing", 0) * self.turning,
            "load": self.reach * d.translation_damping * d.input_speed + self.limits.get("slide", 0) * self.turning,
        }
        self.force = d.axial_force - self.braked["load"]
        self.steady_law = -1 if sign(self.force * self.turning, "axial_force") < 0 else 1
        # torque of the threads, which do not slip where the drive is let go
        self.twist = d.pitch_radius * xi[self.steady_law] * self.force if self.turning else 0
        self.steady_torque = self.braked["screw"] + self.twist
        self._carried = {"contact": self.force, "torque": self.twist}
        self.deflection = self.unit(0, -self.steady_torque / d.coupling_stiffness)
        if "motor" in self.parts:
            self.deflection = plus(self.deflection, scaled(self.unit(self.place["motor"]), -1))
        self.speed = self.unit(1, d.input_speed)
        self.away = plus(self.speed, scaled(self.commanded, -1))  # u′
        rates = self.rates(True, ())
        self.slip, self.nut_speed = self._slip(rates), self._travel(rates)
        self.compression = self.steady_normal_force / (d.cos_lead * d.contact_stiffness) if self.compliant else 0
        places = {part: self.unit(place) for part, place in self.place.items()}
        self.nut_place = plus(self._travel(places), self.constant(-self.compression))
        self.sliding = scaled(self.slip, d.pitch_radius / d.cos_lead)
        self.coupling_torque = plus(self.wound(rates), self.constant(self.steady_torque))

    def constant(self, value: Any) -> Row:
        """Return the row of a constant."""
        return (*self._zeros, value)

    def unit(self, place: int, value: Any = 0) -> Row:
        """Return the row of a coordinate, and a constant."""
        return (*self._zeros[:place], 1, *self._zeros[place + 1 :], value)

    def rubbing(self, mode: Solution) -> Row:
        """Return the row of the friction in τ, τ + r_m tan λ n; at rest with the shares of what else holds."""
        return plus(mode.torque, self.constant(self.twist), scaled(mode.contact, self.reach))

    @cached_property
    def sizes(self) -> tuple[Any, ...]:
        """Typical sizes: 0.1 rad, as in the cycles of Table 8.1, and Ω or that in a swing; none of the clock."""
        return (*chain.from_iterable(map(self._size, self.parts)), *([0.0] if self.command else []))

    def _size(self, part: str) -> tuple[Any, Any]:
        d, speed = self.d, abs(double(self.d.input_speed))
        force, swing = abs(double(d.axial_force)) + 1.0, double(root(d.screw_inertia / d.coupling_stiffness))
        speed = speed if self.turning else 0.1 / swing
        if part == "screw":
            return 0.1, speed
        if part == "support":
            rate, stiffness = double(self.reach) * speed, double(d.support_stiffness)
            return np.maximum(force / stiffness, rate * np.sqrt(double(d.screw_mass) / stiffness)), rate
        if part == "threads":
            # The contact gives way by N/k_c, or by as much as damping and inertia let it in a swing of the coupling.
            stiffness, damping, mass = double(d.contact_stiffness), double(d.contact_damping), double(d.mass)
            place = force / (stiffness + damping / swing + mass / swing**2)
            return place, force / (damping + double(root(d.contact_stiffness * d.mass)) + mass / swing)
        stiffness = double(getattr(d, PARTS[part][1]))
        return 0.1 * np.minimum(double(d.coupling_stiffness) / stiffness, 1.0), speed

    def effective(self, held: Sequence[str] = ()) -> tuple[Any, Any]:
        """Return I_eff [kg m²] and m_eff [kg] while bodies are held."""
        d = self.d
        inertias = None if "bearing" in held else d.screw_inertia, d.nut_inertia if "nut" in self.parts else None
        masses = None if "slide" in held else d.mass, d.screw_mass if "support" in self.parts else None
        return together(*inertias), together(*masses)

    @property
    def steady_normal_force(self) -> Any:
        """Return N_0 of steady sliding [N] (eq. 8.15): N_0 (cos λ + s_0 μ sin λ) = R̃; at rest R cos λ."""
        if not self.turning:
            return self.force * self.d.cos_lead
        return self.force / (self.d.cos_lead + self.steady_law * self.d.steady_friction * self.d.sin_lead)

    def rates(self, slips: bool, held: Iterable[str]) -> dict[str, Row]:
        """Return the rows of θ′, x_1′, θ_2′ and e′ by part, which rest and bodies that are held tie to each other."""
        found = {part: self._late(part, self.unit(self.place[part] + 1), 1) for part in self.parts}
        stands = "bearing" in held or not (slips or "nut" in self.parts)
        found["screw"] = self.constant(0) if stands else self.speed
        if "nut" in self.parts and not slips:
            found["nut"] = found["screw"]
        if "slide" in held:
            last = self.sliders[0]
            found[last] = self.constant(0)
            found[last] = scaled(self._travel(found), -1)
        return found

    def _late(self, part: str, rate: Row, sign: int) -> Row:
        """Add ± (Ω − Ω(t)) to the rate of a motor, or of what turns with the screw: as it is from the command."""
        if part not in BODIES or not BODIES[part].on:
            return rate
        return plus(rate, self.constant(sign * self.d.input_speed), scaled(self.commanded, -sign))

    @property
    def sliders(self) -> list[str]:
        """The parts that let the nut stand along its axis while the threads slip."""
        return [part for part in ("support", "threads") if part in self.parts]

    def _slip(self, rates: Mapping[str, Row]) -> Row:
        return plus(rates["screw"], scaled(rates["nut"], -1)) if "nut" in rates else rates["screw"]

    def _travel(self, rates: Mapping[str, Row]) -> Row:
        return plus(scaled(self._slip(rates), self.reach), *(rates[part] for part in self.sliders))

    def lever(self, law: int, mu: Any) -> Any:
        """r_m ξ_s [m], which the torque of the threads is times n."""
        return self.d.pitch_radius * self._factor(mu, law)

    def _factor(self, mu: Any, law: int) -> Any:
        """ξ_s, and s μ_b r_b / r_m of a collar: it turns with the slip, so that its sign is that of the threads."""
        return mechanics.friction_factor(mu, self.d.tan_lead, law) + law * self.d.collar

    def pressed(self, rates: Mapping[str, Row]) -> Row:
        """Return the row of N = cos λ (k_c e + c_c e′) of compliant threads."""
        spring = self.unit(self.place["threads"])
        row = plus(scaled(spring, self.d.contact_stiffness), scaled(rates["threads"], self.d.contact_damping))
        return scaled(row, self.d.cos_lead)

    def solve(self, direction: int, law: int, ways: Ways = (), mu: Any = None) -> Solution:
        """Solve Newton's laws in slip in a direction (0: rest) under a law, by default with μ of slow sliding."""
        law, (rates, held, bodies) = direction and law, self._bodies(direction, ways)
        mu = self.slowest if mu is None else mu
        threads: list[Equation] = [
            (ties, plus(row, self.constant(added(*(-x * self._carried.get(name, 0) for name, x in ties.items())))))
            for ties, row in self._threads(law, mu, rates)
        ]
        # At rest screw and nut are one first, so that what they give to x″ cancels to the last bit.
        equations = [*bodies, *threads] if direction else [*threads, *bodies]
        equations += [({"screw": 1} if name == "bearing" else self._moved, self.constant(0)) for name in held]
        return self._solution(law, mu, rates, solved(equations), held)

    def _equations(self, direction: int, ways: Ways) -> tuple[Mapping[str, Row], list[str], list[Equation]]:
        """Return rates, what is held, and equations of the bodies: less those of steady sliding, so nothing cancels."""
        d, going = self.d, dict(zip(self.own, ways, strict=True))
        held = [name for name, way in going.items() if way == 0]
        going |= dict.fromkeys(self.tied, direction)  # at rest the shares of threads and ground are not determined
        rates = self.rates(bool(direction), held)
        travel = self.constant(0) if "slide" in held else self._travel(rates)
        wound = self.wound(rates)
        rows = {
            "screw": [wound, self.constant(self.braked["screw"]), scaled(rates["screw"], -d.support_damping)],
            "load": [self.constant(self.braked["load"]), scaled(travel, -d.translation_damping)],
        }
        left = dict(self._inertias)
        for name, way in going.items():
            body = "screw" if name == "bearing" else "load"
            rows[body].append(self.constant(-self.limits[name] * way))
            if name in held:
                left[body] = left[body] | {name: 1}
        for part in self.bodies:
            rows[part] = [self._spring(part, rates)]
            if BODIES[part].on == "screw":
                rows["screw"].append(scaled(rows[part][0], -1))
            if part == "motor":
                rows[part].append(scaled(wound, -1))
        return rates, held, [(left[body], plus(*rows[body])) for body in left]

    def wound(self, rates: Mapping[str, Row]) -> Row:
        """Return the row of the torque that the coupling gives to the screw, −k z − d z′, less ``steady_torque``."""
        torque = scaled((*self.deflection[:-1], 0), -self.d.coupling_stiffness)
        if "motor" in self.parts and sign(self.d.coupling_damping):
            turning = plus(rates["screw"], scaled(self.commanded, -1), scaled(rates["motor"], -1))
            torque = plus(torque, scaled(turning, -self.d.coupling_damping))
        return torque

    @cached_property
    def _moved(self) -> dict[str, Any]:
        """What x″ is made of: the accelerations of the parts by their shares."""
        turns = {"nut": -self.reach} if "nut" in self.parts else {}
        return {"screw": self.reach, **turns, **dict.fromkeys(self.sliders, 1)}

    @cached_property
    def _inertias(self) -> dict[str, dict[str, Any]]:
        """What stands on the left of the equation of each body: its inertia by its acceleration, the threads' force."""
        d = self.d
        left = {"screw": {"screw": d.screw_inertia, "torque": 1}}
        left["load"] = {part: d.mass * x for part, x in self._moved.items()} | {"contact": 1}
        for part in self.bodies:
            pushed = {BODIES[part].pushed: -1} if BODIES[part].pushed else {}
            left[part] = {part: getattr(d, PARTS[part][0])} | pushed
        return left

    def _spring(self, part: str, rates: Mapping[str, Row]) -> Row:
        """Return the force of the spring and the damper of a body, less that in steady sliding."""
        body, (_, *names) = BODIES[part], PARTS[part]
        stiffness, damping = (getattr(self.d, name) for name in names)
        stretched, faster = self.unit(self.place[part]), rates[part]
        if body.on == "screw":
            stretched = plus(stretched, scaled(self.unit(self.place[body.on]), -1))
            faster = plus(faster, self.commanded, scaled(rates[body.on], -1))
        return plus(scaled(stretched, -stiffness), scaled(faster, -damping))

    def _threads(self, law: int, mu: Any, rates: Mapping[str, Row]) -> list[tuple[dict[str, Any], Row]]:
        d, zero = self.d, self.constant(0)
        turns: dict[str, Any] = {"torque": 1, "contact": -self.lever(law, mu)} if law else {"screw": 1}
        if not law and "nut" in self.parts:
            turns["nut"] = -1
        if not self.compliant:
            return [(turns, zero)]
        normal = self.pressed(rates)
        if law:
            return [(turns, zero), ({"contact": 1}, scaled(normal, d.cos_lead + law * mu * d.sin_lead))]
        return [(turns, zero), ({"contact": 1, "torque": -d.tan_lead / d.pitch_radius}, scaled(normal, 1 / d.cos_lead))]

    def _solution(
        self, law: int, mu: Any, rates: Mapping[str, Row], found: Mapping[str, Row], held: Sequence[str]
    ) -> Solution:
        d, field, frozen, zero = self.d, list[Row](), dict[int, Any](), self.constant(0)
        for part, place in self.place.items():
            still = all(map(nothing, rates[part]))
            if still:
                frozen[place + 1] = -d.input_speed if part == "screw" else 0
            field += [self.away if part == "screw" else rates[part], zero if still else found[part]]
        field += [self.constant(1)] if self.command else []
        contact, torque = plus(found["contact"], self.constant(self.force)), found["torque"]
        if self.compliant:
            normal = self.pressed(rates)
        elif law:
            normal = scaled(contact, 1 / (d.cos_lead + law * mu * d.sin_lead))
        elif self.idle:  # the bearing holds all
            normal = scaled(contact, d.cos_lead)
        else:
            whole = plus(torque, self.constant(self.twist))
            normal = plus(scaled(contact, d.cos_lead), scaled(whole, -d.sin_lead / d.pitch_radius))
        return Solution(law, tuple(field), frozen, contact, normal, torque, {name: found[name] for name in held})

    def left(self, rest: Solution, direction: int, side: int) -> Row:
        """Return the static friction [N m] that keeps the threads at ``rest`` from slipping, on a side of n.

        That is ±(r_m ξ_s n − τ) with s = ± sgn n, and what a bearing takes that turns with the slip: at rest τ and n
        count it to the threads. A slide that moves with it opposes the same motion; one that pushed the other way
        could jam the threads at a larger τ, at which slip is possible, too. Where it takes so much of a load that moves
        along that slip would need more torque than that, rest holds as long as slip cannot begin.
        """
        law = direction * side
        if not side:
            most = self._braked(direction, self.holding, self.xi_rest)
            if not self.same:
                slow = {s: self._factor(self.slowest, s) for s in (1, -1)}
                sliding = self._braked(direction, self.limits, slow)
                most = most if sign(added(most, -sliding)) >= 0 else sliding
            return plus(scaled(rest.torque, -direction), self.constant(most))
        torque = plus(rest.torque, self.constant(self.twist))
        threads = plus(scaled(rest.contact, self.d.pitch_radius * self.xi_rest[law]), scaled(torque, -1))
        bearing = self.holding["bearing"] if "bearing" in self.tied else 0
        if self.compliant:  # n = N / cos λ + tan λ τ / r_m
            bearing = bearing * (1 - self.xi_rest[law] * self.d.tan_lead)
        return plus(scaled(threads, direction), self.constant(bearing))

    def _braked(self, direction: int, dry: Mapping[str, Any], factors: Mapping[int, Any]) -> Any:
        """Return the torque [N m] of threads, slide and bearing that let go together, beyond that of steady sliding.

        ``factors``: ξ_s by law.
        """
        held = dry["slide"] * direction if "slide" in self.tied else 0
        lever = (
            self.d.pitch_radius * factors[(sign(self.d.axial_force - held, "axial_force") or -direction) * direction]
        )
        threads = lever * (self.braked["load"] - held) + added(lever * self.force, -self.twist)
        return threads * direction + (dry["bearing"] if "bearing" in self.tied else 0)

    def released(self, direction: int, side: int) -> int:
        """Return the sign of n with which slip begins: the side of rest; without a force the threads resist."""
        load = self.d.axial_force - (self.holding["slide"] * direction if "slide" in self.tied else 0)
        return side or sign(load, "axial_force") or (1 if self.idle else -direction)

    def reset(self, rests: bool, held: Iterable[str]) -> tuple[Row, ...]:
        """Return the rows of the reset that puts speeds on exactly zero: that of the slip, and those of bodies."""
        return self._reset(self.rates(not rests, held))

    def _reset(self, rates: Mapping[str, Row]) -> tuple[Row, ...]:
        rows = []
        for part, place in self.place.items():
            rate = plus(rates[part], self.constant(-self.d.input_speed)) if part == "screw" else rates[part]
            rows += [self.unit(place), self._late(part, rate, -1)]
        return (*rows, *([self.unit(len(rows))] if self.command else []))

    @cached_property
    def impact(self) -> tuple[Row, ...]:
        """Rows of the reset of a seizure: impulses of n and τ that stop the slip; springs and dampers give none.

        The friction factor that they take, I_eff / (m_eff r_m² tan λ), is not larger than ξ₊ where Γ₊ ≤ 0.
        """
        zero = self.constant(0)
        equations = [(left, zero) for left in self._inertias.values()]
        equations.append(({"screw": 1} | ({"nut": -1} if "nut" in self.parts else {}), scaled(self.slip, -1)))
        jumps, rates = solved(equations), self.rates(True, ())
        return self._reset({part: plus(rates[part], jumps[part]) for part in self.parts})


def solved(equations: Sequence[Equation]) -> dict[str, tuple[Any, ...]]:
    """Solve linear equations by elimination.

    The sparsest equation is solved first, so that arrays lose no digits; what cancels is exactly zero, so that steady
    sliding is an equilibrium to the last bit.
    """
    waiting, found = [(dict(left), right) for left, right in equations], dict[str, tuple[Any, ...]]()
    order: list[tuple[str, dict[str, Any], Row]] = []
    while waiting:
        left, right = waiting.pop(min(range(len(waiting)), key=lambda k: len(waiting[k][0])))
        name = min(left, key=lambda name: [name in other for other, _ in waiting].count(True))
        first = left.pop(name)
        left = {key: x / first for key, x in left.items()}
        right = tuple([0 if nothing(x) else x / first for x in right])
        order.append((name, left, right))
        for k, (others, side) in enumerate(waiting):
            if name in others:
                factor = others.pop(name)
                sums = {key: added(others.get(key, 0), -factor * x) for key, x in left.items()}
                kept = {key: x for key, x in (others | sums).items() if not nothing(x)}
                waiting[k] = kept, plus(side, scaled(right, -factor))
    for name, left, right in reversed(order):
        found[name] = plus(right, *(scaled(found[key], -x) for key, x in left.items()))
    return found
