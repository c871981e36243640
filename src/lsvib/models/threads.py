r"""Compliant threads: screw and nut are joined by a spring and a damper in the contact (Sect. 5.5, eqs 8.6, 8.7).

          Ω t                θ                               x = r_m tan λ θ + e
    motor ──/\/\/\── k ──▶ (I) screw ═══ k_c ∥ c_c ═══▶ [m] nut ──▶ R
                            c to ground                    c_x to ground

State (u, w, e, v): u = z − z_0 [rad] and w = u′ [rad/s] as in the rigid drive; e = x − r_m tan λ θ [m] is the mismatch
of nut and screw, and v = e′ [m/s]. The contact is compressed by δ = e cos λ. With s = sgn(θ′) sgn(N),

    N = k_c δ + c_c δ′ = cos λ (k_c e + c_c v),                                               (8.6, with damping)
    I θ″ = −k z − c θ′ − r_m N (s μ cos λ − sin λ),      m x″ = R − c_x x′ − N (cos λ + s μ sin λ).    (5.16, 5.17)

Differentiating N twice gives (8.7) for c_c = 0.

Friction. The motion is linear for each combination of the signs of θ′ and N; the law s changes where either of them
passes zero. When θ′ arrives at zero the screw sticks if static friction holds: the friction force F takes what the
torque asks for, F = (−k z / r_m + N sin λ) / cos λ, as long as |F| ≤ μ_s |N|. During rest the nut still moves,
m x″ = R − c_x x′ − N cos λ − F sin λ, so N changes, and slip begins where |F| reaches μ_s |N|.

Painlevé region. Nothing is imposed: N is a function of the state, so a seizure is the fast growth of N under law
s = +1, which stops the screw, and the motion after it follows from the same equations.
"""

from collections.abc import Iterable, Iterator, Mapping
from enum import IntEnum
from typing import Any, ClassVar

import numpy as np
from flint import arb

from lsvib.engine.automaton import Automaton, Branch, Guard, Mode, Surface, Transition, assemble, scaled
from lsvib.engine.exact import arithmetic
from lsvib.engine.exact.arithmetic import double, many_digits, root
from lsvib.engine.exact.modal_form import guard_forms, linear_mode, modal_flow
from lsvib.engine.exact.taylor_form import Split, still_mode, taylor_flow
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, FIRST_MODEL_KIND, GRAZE_KIND, Test
from lsvib.models import friction, sliding
from lsvib.models.drive import ThreadsDrive, once
from lsvib.models.mechanics import Coefficients, LinearParts, Polynomial, coefficients, coefficients_of, plus, rate_of
from lsvib.models.model import DIRECTIONS, SIGNS, Model, Powers, product, seizures_only_by_contact

STATES = ("angle_deviation", "velocity_deviation", "thread_mismatch", "mismatch_rate")


class ThreadsEvent(IntEnum):
    """What happens at an event."""

    GRAZE = GRAZE_KIND
    ACCUMULATION = ACCUMULATION_KIND
    CONTACT_REVERSAL = FIRST_MODEL_KIND  # N changes sign
    STICK = FIRST_MODEL_KIND + 1  # θ′ = 0, and static friction holds
    REVERSAL = FIRST_MODEL_KIND + 2  # θ′ = 0, and the screw turns back
    RELEASE = FIRST_MODEL_KIND + 3  # static friction gives way
    PASSAGE = FIRST_MODEL_KIND + 4  # θ′ passes Ω, where a friction law divides the mode of steady sliding


class ThreadsMode(IntEnum):
    """Modes: direction of the screw, and sign of N."""

    SLIP_FORWARD_POSITIVE = 0
    SLIP_FORWARD_NEGATIVE = 1
    SLIP_BACKWARD_POSITIVE = 2
    SLIP_BACKWARD_NEGATIVE = 3
    REST_POSITIVE = 4
    REST_NEGATIVE = 5


_UNDER_LAW_PLUS = (ThreadsMode.SLIP_FORWARD_POSITIVE, ThreadsMode.SLIP_BACKWARD_NEGATIVE)


@once
def threads_automaton(drive: ThreadsDrive) -> Automaton:
    """Return the automaton of the drive with compliant threads.

    Observables: normal_force [N], coupling_torque [N m], coupling_deflection [rad], screw_speed [rad/s]. Raises
    ``EngineError`` if the coordinates of a mode cannot be distinguished in double precision.
    """
    c, d = coefficients(drive), drive.exact()
    with many_digits():
        build = _SpeedBuild(c, d, drive) if friction.depends_on_speed(drive) else _ThreadsBuild(c, d)
        return build.automaton()


class _ThreadsBuild:
    """Rows over (u, w, e, v, 1) that the model is made of, and its automaton, of one drive or of many at once."""

    flow: ClassVar[dict[str, Any]] = {"stack": modal_flow, "forms": guard_forms}  # how ``assemble`` makes its tables

    def __init__(self, c: Coefficients, d: Any) -> None:
        self.c, self.d = c, d
        self.reach = d.pitch_radius * d.tan_lead
        self.deflection = (1, 0, 0, 0, c.deflection)
        self.speed = (0, 1, 0, 0, d.input_speed)
        self.normal = (0, 0, d.cos_lead * d.contact_stiffness, d.cos_lead * d.contact_damping, 0)
        # Friction that holds the screw at rest.
        pull = scaled(self.deflection, -d.coupling_stiffness / d.pitch_radius / d.cos_lead)
        self.friction = plus(pull, scaled(self.normal, d.tan_lead))
        # The contact gives way by N/k_c, or by as much as damping and inertia let it in a swing of the coupling.
        force = abs(double(d.axial_force)) + 1.0
        stiffness, damping = double(d.contact_stiffness), double(d.contact_damping)
        mass, swing = double(d.mass), double(root(d.screw_inertia / d.coupling_stiffness))
        mismatch = force / (stiffness + damping / swing + mass / swing**2)
        rate = force / (damping + root(stiffness * mass) + mass / swing)
        self.sizes = (0.1, abs(double(d.input_speed)), mismatch, rate)

    def automaton(self) -> Automaton:
        """Return the automaton."""
        surfaces, transitions, modes = self.surfaces(), self.transitions(), self.modes()
        self.divide(modes, transitions, surfaces)
        return assemble(
            states=STATES,
            surfaces=surfaces,
            modes=modes,
            transitions=transitions,
            observables=self.observables(modes),
            shortest_stay=0.0,
            rest_codes=(ThreadsMode.REST_POSITIVE, ThreadsMode.REST_NEGATIVE),
            release_kinds=(ThreadsEvent.RELEASE,),
            sprag_codes=_UNDER_LAW_PLUS if self.jams() else (),
            **self.flow,
        )

    def divide(self, modes: dict[str, Mode], transitions: dict[str, Transition], surfaces: dict[str, Surface]) -> None:
        """Divide modes, in place, where friction depends on speed."""

    def jams(self) -> bool:
        """Whether motions sprag under law s = +1: in the Painlevé region."""
        return self.c.paradox

    def observables(self, modes: Iterable[str]) -> dict[str, dict[str, tuple]]:
        """Return the rows of the observables by name and mode."""
        rows = {
            "normal_force": self.normal,
            "coupling_torque": scaled(self.deflection, -self.d.coupling_stiffness),
            "coupling_deflection": self.deflection,
            "screw_speed": self.speed,
        }
        return {name: dict.fromkeys(modes, row) for name, row in rows.items()}

    def modes(self) -> dict[str, Mode]:
        """Return the modes by name."""
        slips, rest = self.slips(), self.rest()
        modes: dict[str, Mode] = {}
        for direction, where in DIRECTIONS.items():
            for sign, contact in SIGNS.items():
                name = f"slip_{where}_{contact}"
                guards = (Guard("contact", sign, f"contact_reversal_{name}"), Guard("screw_speed", direction, "stop"))
                modes[name] = Mode(ThreadsMode[name.upper()], slips[direction, direction * sign], guards)
        for contact in SIGNS.values():
            name = f"rest_{contact}"
            guards = (Guard(f"hold_{contact}", 1, f"release_forward_{contact}"),)
            guards += (Guard(f"hold_back_{contact}", 1, f"release_backward_{contact}"),)
            modes[name] = Mode(ThreadsMode[name.upper()], rest, guards)
        return modes

    def slips(self) -> dict[tuple[int, int], Any]:
        """Return the flows of slip by direction and law s."""
        found = {law: linear_mode(self._slip_rows(law), self.sizes, None, ThreadsDrive.own_damping) for law in (1, -1)}
        return {(direction, law): found[law] for direction in DIRECTIONS for law in found}

    def _slip_rows(self, law: int, mu: Any = None) -> list[tuple]:
        """Field of slip under law s with a constant coefficient, by default that of steady sliding."""
        d, mu = self.d, self.d.steady_friction if mu is None else mu
        torque = plus(scaled(self.deflection, -d.coupling_stiffness), scaled(self.speed, -d.support_damping))
        lever = d.pitch_radius * (law * mu * d.cos_lead - d.sin_lead)
        acceleration = scaled(plus(torque, scaled(self.normal, -lever)), 1 / d.screw_inertia)
        return self._rows(acceleration, scaled(self.normal, d.cos_lead + law * mu * d.sin_lead))

    def rest(self) -> Any:
        """Return the flow of rest: w stays −Ω, the nut moves on."""
        held = {1: -self.d.input_speed}
        return linear_mode(self._rest_rows(), self.sizes, held, ThreadsDrive.own_damping)

    def _rest_rows(self) -> list[tuple]:
        axial = plus(scaled(self.normal, self.d.cos_lead), scaled(self.friction, self.d.sin_lead))
        return self._rows((0, 0, 0, 0, 0), axial)

    def _rows(self, acceleration: tuple, axial: tuple) -> list[tuple]:
        d = self.d
        travel = plus((0, 0, 0, 1, 0), scaled(self.speed, self.reach))  # x′
        nut = scaled(
            plus((0, 0, 0, 0, d.axial_force), scaled(travel, -d.translation_damping), scaled(axial, -1)), 1 / d.mass
        )
        return [(0, 1, 0, 0, 0), acceleration, (0, 0, 0, 1, 0), plus(nut, scaled(acceleration, -self.reach))]

    def surfaces(self) -> dict[str, Surface]:
        """N = 0, θ′ = 0, and the ends of static friction, positive where it holds: s μ N ∓ F with s = sgn N."""
        # Of e and v the one that moves N more is set on N = 0: the other's rounding would be amplified by their ratio.
        by_mismatch, by_rate = (abs(double(self.normal[i])) * self.sizes[i] for i in (2, 3))
        found = {
            "contact": Surface(self.normal, 2 if arithmetic.sign(by_mismatch - by_rate) >= 0 else 3),
            "screw_speed": Surface(self.speed, 1),
        }
        for sign, contact in SIGNS.items():
            limit = scaled(self.normal, sign * self.d.static_friction)
            found[f"hold_{contact}"] = Surface(plus(limit, scaled(self.friction, -1)), 0)
            found[f"hold_back_{contact}"] = Surface(plus(limit, self.friction), 0)
        return found

    def transitions(self) -> dict[str, Transition]:
        """Entry and stop choose by the signs of θ′ and N and by static friction; N = 0 changes the law."""
        standing = tuple(self._standing())
        found = {"entry": Transition((*self._moving(), *standing)), "stop": Transition(standing)}
        for where in DIRECTIONS.values():
            for sign, contact in SIGNS.items():
                there = f"slip_{where}_{SIGNS[-sign]}"
                reversal = Branch(there, ThreadsEvent.CONTACT_REVERSAL, sign=-sign)
                found[f"contact_reversal_slip_{where}_{contact}"] = Transition((reversal,))
                found[f"release_{where}_{contact}"] = Transition(
                    (Branch(f"slip_{where}_{contact}", ThreadsEvent.RELEASE),)
                )
        return found

    def _contact_has(self, sign: int):
        """Conditions under each of which N has a sign, now or – if it is zero – at once, by N′ or else N″."""
        # On N = 0 the first derivative that is not zero is the same under both laws, with any coefficient.
        rows = self._slip_rows(1)
        rate = rate_of(self.normal, rows)
        zero = ((self.normal, Test.ZERO), (rate, Test.ZERO))
        last = Test.POSITIVE if sign > 0 else Test.NOT_NEGATIVE
        yield ((scaled(self.normal, sign), Test.POSITIVE),)
        yield (*zero[:1], (scaled(rate, sign), Test.POSITIVE))
        yield (*zero, (scaled(rate_of(rate, rows), sign), last))

    def _moving(self):
        for direction, where in DIRECTIONS.items():
            moves = (scaled(self.speed, direction), Test.POSITIVE)
            for sign, contact in SIGNS.items():
                for conditions in self._contact_has(sign):
                    yield Branch(f"slip_{where}_{contact}", ThreadsEvent.RELEASE, (moves, *conditions))

    def _standing(self):
        """At θ′ = 0, for N of either sign: too much friction asked for starts slip, else rest."""
        for sign, contact in SIGNS.items():
            limit = scaled(self.normal, -sign * self.d.static_friction)
            for here in self._contact_has(sign):
                for direction, where in DIRECTIONS.items():
                    excess = (plus(scaled(self.friction, direction), limit), Test.POSITIVE)
                    yield Branch(f"slip_{where}_{contact}", ThreadsEvent.REVERSAL, (*here, excess))
                yield Branch(f"rest_{contact}", ThreadsEvent.STICK, here)


class _SpeedBuild(_ThreadsBuild):
    """The same under a friction law.

    N follows from the state, so friction of any size is followed. Motions are taken to sprag under law s = +1 if
    Γ₊ ≤ 0 in slow sliding, to which the growing force brings them.
    """

    flow: ClassVar[dict[str, Any]] = {"stack": taylor_flow}

    def __init__(self, c: Coefficients, d: Any, drive: ThreadsDrive) -> None:
        super().__init__(c, d)
        self.drive, self.pieces = drive, sliding.pieces_of(drive)

    def divide(self, modes: dict[str, Mode], transitions: dict[str, Transition], surfaces: dict[str, Surface]) -> None:
        """Divide the mode of steady sliding."""
        turning = arithmetic.sign(self.d.input_speed)
        steady = f"slip_{DIRECTIONS[turning]}_{SIGNS[self.c.steady_law * turning]}"
        place = seated_state(self.drive, 0.0, 0.0)
        sliding.divided(steady, ThreadsEvent.PASSAGE, modes, transitions, surfaces, place)

    def jams(self) -> bool:
        """Whether Γ₊ ≤ 0 in slow sliding."""
        most = sliding.critical_coefficient(self.d.screw_inertia, self.d, self.d.mass)
        return double(friction.coefficient(self.d, arb(0))) >= most

    def slips(self) -> dict[tuple[int, int], Any]:
        """Return the flows of slip by direction and law s."""
        d, mu, found = self.d, sliding.probe(self.d), {}
        for law in (1, -1):
            split = Split.of(self._slip_rows(law, 0), self.normal, self._slip_rows(law, mu), self.normal, mu)
            for direction in DIRECTIONS:
                found[direction, law] = split.mode(sliding.speed_row(direction, self.speed, d), self.pieces)
        return found

    def rest(self) -> Any:
        """Return the flow of rest."""
        return still_mode(self._rest_rows())


def seated_state(drive: ThreadsDrive, u: float, w: float) -> np.ndarray:
    """State with the contact compressed as in steady sliding, N = N_0 and v = 0; u [rad], w [rad/s] (eq. 8.15)."""
    c, d = coefficients(drive), drive.exact()
    with many_digits():
        normal = c.net_force / (d.cos_lead + c.steady_law * d.steady_friction * d.sin_lead)
        return np.array([u, w, float(normal / (d.cos_lead * d.contact_stiffness)), 0.0])


def _start(drive: ThreadsDrive, values) -> np.ndarray:
    state = seated_state(drive, values["u"], values["w"])
    state[2:] = values.get("e", state[2]), values.get("v", state[3])
    return state


def _automaton(drive: ThreadsDrive, physics: tuple[str, ...], resume: str) -> Automaton:
    seizures_only_by_contact("threads", resume)
    return threads_automaton(drive)


def _many(d: Any, resume: str) -> Automaton:
    seizures_only_by_contact("threads", resume)
    with many_digits():
        return _ThreadsBuild(coefficients_of(d), d).automaton()


_automaton.many = _many  # type: ignore[attr-defined]


def _characteristic(p: Mapping[str, Any], parts: LinearParts) -> Polynomial:
    """(1 + t²) A B + (k_c + c_c s) D, which is (1 + t²) det(M s² + C s + K) with the matrices of (8.6), (8.7).

    Both, and so with the other models, times g where friction depends on the speed.
    """
    return parts.coupled(1 + parts.t**2, (0, p["contact_damping"], p["contact_stiffness"]))


class ThreadsPowers(Powers):
    """Powers of the drive with compliant threads: the nut moves against the screw at v = e′, the contact's damper too.

    Friction acts on that motion as well, so that its power changes its sign within a mode.
    """

    def __init__(self, drive: ThreadsDrive, automaton: Automaton) -> None:
        super().__init__(drive, automaton)
        self.parting = self.unit[3]
        self.nut = self.nut + self.parting

    def dampers(self) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the damper of the contact, which the mismatch compresses at v cos λ."""
        yield self.drive.contact_damping * self.cosine**2, self.parting

    def friction(self, mode: int) -> Iterator[np.ndarray]:
        """Yield nothing: see :meth:`signed_friction`."""
        yield from ()

    def signed_friction(self, mode: int) -> np.ndarray:
        """Return the power [W] of the friction of the threads; at rest static friction moves with the nut."""
        rows, d = self.rows(mode), self.drive
        normal = rows["normal_force"]
        if self.rests(mode):
            friction = (rows["coupling_torque"] / d.pitch_radius + self.sine * normal) / self.cosine
            return self.sine * product(friction, self.parting)
        law = 1 if self.automaton.codes[mode] in _UNDER_LAW_PLUS else -1
        sliding = d.pitch_radius / self.cosine * self.screw + self.sine * self.parting
        return self.rubbed(law * product(normal, sliding))


MODEL = Model(
    drive=ThreadsDrive,
    build=_automaton,
    start=_start,
    modes=ThreadsMode,
    events=ThreadsEvent,
    optional=("e", "v"),
    states=STATES,
    terms=("support_damping", "translation_damping", "axial_force", "contact_damping"),
    equations="eqs 8.6, 8.7",
    characteristic=_characteristic,
    constrained=lambda p, parts: parts.rigid(),  # in the limit of stiff threads; det M of (8.6) > 0
    constraint="Γ₊ = I − ξ₊ tan λ m r_m² = 0, the limit of stiff threads (eq. 8.20, Lemma 8.1)",
    curves=("flutter",),
    powers=ThreadsPowers,
    excess=lambda parts: (1 + parts.t**2) * parts.times,
    quantities={
        "thread_mismatch": ("mismatch of nut and screw along the axis", "m", "$e$"),
        "mismatch_rate": ("rate of the mismatch of nut and screw", "m s-1", r"$\dot e$"),
    },
    section="5.5",
)
