r"""Drives with two coordinates whose threads stay rigid – axial support, rotating nut: mechanics, modes and guards.

The threads slip with a speed ω in the direction d = sgn ω under the law s = d sgn n, where n is the axial contact
force, or they rest. A second body may slide against the ground with Coulomb friction; then its direction a is part of
the mode, with a = 0 while it is held. A model solves Newton's laws in each mode; all else follows from the signs of
speeds and forces.

* n = Q / (positive factor × Γ_s), where Q does not depend on the law. If Γ₊ > 0, the sign of n is that of Q. If Γ₊ > 0
  also while the second body is held, exactly one mode is consistent in each state: with the accelerations as unknowns,
  all pieces of the contact problem have determinants of one sign. At ω = 0, or where the second body stops, that mode
  is found by trying all of them.
* If Γ₊ ≤ 0 (the Painlevé region, in which models refuse the second friction), law s = −1 is followed where it is
  admissible, dQ < 0. Elsewhere, and on arriving at Q = 0, the threads seize: ω jumps to zero by an impact with an
  impulse of the sign of ω. After it, slip under law −1 against ω starts at once if it is admissible and accelerates
  away from rest; otherwise the threads rest, or, beyond the ends of static friction, slip under law −1
  (``resume="contact_sign"`` of the rigid drive).

Under a friction law what is said here of Γ₊ has to hold at all sliding speeds that a motion reaches; one that leaves
them has no branch. Where a speed is zero, the threads slip with the friction of slow sliding. The second friction is
refused: while it holds a body, the force that is left would be no affine function of the state.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

from flint import arb

from lsvib.engine.automaton import (
    SHORT_STAY,
    Automaton,
    Branch,
    Guard,
    Mode,
    Row,
    Surface,
    Transition,
    assemble,
    scaled,
)
from lsvib.engine.exact.arithmetic import sign
from lsvib.engine.exact.modal_form import guard_forms, linear_mode, modal_flow
from lsvib.engine.exact.taylor_form import still_mode, taylor_flow
from lsvib.engine.kernels.layout import Test
from lsvib.errors import InputError
from lsvib.models import friction, sliding
from lsvib.models.drive import NutDrive, SupportDrive
from lsvib.models.mechanics import constant, friction_factor, plus, rate_of, solved
from lsvib.models.model import DIRECTIONS, SIGNS
from lsvib.models.two_bodies_law import under_law

HELD = {**DIRECTIONS, 0: "held"}
SLIPS = tuple((d, q) for d in DIRECTIONS for q in SIGNS)
Side = tuple[Row, Test]  # a row and the test that it has to pass


@dataclass(frozen=True)
class Solution:
    """Newton's laws solved in one mode: affine functions of the state, constant last.

    ``law``: s, 0 at rest; ``field``: rate of the state; ``frozen``: coordinates that keep a value; ``contact``: n [N];
    ``torque``: what the contact (at rest with the bearing) takes from the screw [N m]; ``second_force``: friction of
    the second body.
    """

    law: int
    field: tuple[Row, ...]
    frozen: Mapping[int, arb]
    contact: Row
    torque: Row
    second_force: Row


class TwoBodies(ABC):
    """A drive of a model as rows over its state (u, w, and two of the second body) and 1, and its automaton.

    In steady sliding the threads carry the force ``force`` = R − r_m tan λ c_x Ω − F_0 sgn Ω [N] with the torque
    ``twist`` = r_m ξ_s0 · force [N m] (eq. 8.15). ``reach``: r_m tan λ; ``xi``: ξ_s by law, ``xi_rest`` with static
    friction, and ``same``, whether that is none of its own; ``slowest``: μ of slow sliding; ``pieces`` of a friction
    law, if any, and ``fastest``, the sliding speed [m/s] up to which it leaves Γ₊ its sign; ``turning``: sgn Ω;
    ``slides``, ``bears``: whether there is F_0, T_0; ``speed``, ``deflection``: rows of θ′ and z.

    A model names its ``states``, ``modes``, ``events``, and the ``second`` body with the parameter that is its friction
    against the ground, ``limiting`` (``limited``: whether there is any, ``limit``: its size), and the coordinates
    ``snaps`` that are moved to put the speeds ``slip`` and ``sliding`` on zero. It sets the attributes that are only
    declared here: the typical ``sizes`` of the state, the rows of ``slip``, ``sliding`` and ``nut_speed`` (of the nut
    against the ground [m/s]), the rows of the reset of a seizure, ``impact``, whether Γ₊ ≤ 0, ``paradox``, and whether
    n may pass zero at rest, ``turns_over``.
    """

    states: tuple[str, ...]
    modes: type[IntEnum]
    events: type[IntEnum]
    second: str
    limiting: str
    snaps: tuple[int, int]
    sizes: tuple[float, ...]
    slip: Row
    sliding: Row
    nut_speed: Row
    impact: tuple[Row, ...]
    limited: bool
    limit: arb
    paradox: bool
    turns_over: bool
    fastest: float

    def __init__(self, drive: SupportDrive | NutDrive, slide: bool, bearing: bool) -> None:
        self.d, self.movable, self.drive = drive.exact(), drive.own_damping, drive
        d = self.d
        self.slides, self.bears = slide and drive.slide_friction > 0, bearing and drive.bearing_friction > 0
        self.slide, self.bearing = d.slide_friction * slide, d.bearing_friction * bearing
        self.reach = d.pitch_radius * d.tan_lead
        self.xi = {s: friction_factor(d.steady_friction, d.tan_lead, s) for s in (1, -1)}
        self.same = sign(d.static_friction_coefficient) == 0  # rest then holds as much as slow sliding carries
        self.xi_rest = {s: friction_factor(d.static_friction, d.tan_lead, s) for s in self.xi}
        self.pieces = sliding.pieces_of(drive) if friction.depends_on_speed(drive) else None
        own = self.limiting == "slide_friction"
        self.limited, self.limit = (self.slides, self.slide) if own else (self.bears, self.bearing)
        if self.limited and self.pieces is not None:
            raise InputError(
                f"{self.limiting} = {getattr(self.drive, self.limiting):g} is not followed in model {self.drive.model} "
                f"where friction of the threads depends on speed; leave {self.limiting} out of the physics, or "
                "stribeck_rise and friction_slope at zero."
            )
        self.slowest = d.steady_friction if self.pieces is None else friction.coefficient(d, arb(0))
        self.turning = sign(d.input_speed)
        self.force = d.axial_force - self.reach * d.translation_damping * d.input_speed - self.slide * self.turning
        self.steady_law = law = -1 if sign(self.force * self.turning, "axial_force") < 0 else 1
        self.twist = d.pitch_radius * self.xi[law] * self.force
        torque = d.support_damping * d.input_speed + self.bearing * self.turning + self.twist
        self.deflection = (1, 0, 0, 0, -torque / d.coupling_stiffness)
        self.speed = (0, 1, 0, 0, d.input_speed)

    def in_paradox(self, inertia: arb, mass: arb) -> bool:
        """Return whether Γ₊ = I − ξ₊ tan λ m r_m² ≤ 0, of an effective inertia and mass."""
        if self.pieces is None:
            return sign(inertia - self.turned * mass, "mass") <= 0
        most = sliding.critical_coefficient(inertia, self.d, mass)
        paradox, self.fastest = sliding.paradox_below(self.drive, most)
        return paradox

    @property
    def turned(self) -> arb:
        """ξ₊ tan λ r_m² [m²] of steady sliding."""
        return self.xi[1] * self.reach * self.d.pitch_radius

    @abstractmethod
    def solve(self, direction: int, law: int, way: int, mu: arb | None = None) -> Solution:
        """Solve Newton's laws for slip in a direction (0: rest) under a law, the second body moving one ``way``.

        ``mu``: the coefficient of the threads, by default that of slow sliding.
        """

    def lever(self, law: int, mu: arb | None) -> arb:
        """r_m ξ_s [m], which the torque of the threads is times n; ``mu`` as in :meth:`solve`."""
        if mu is None and self.pieces is None:
            return self.d.pitch_radius * self.xi[law]
        return self.d.pitch_radius * friction_factor(self.slowest if mu is None else mu, self.d.tan_lead, law)

    def solution(
        self, law: int, screw_held: bool, all_held: bool, rate: Row, matrix: Sequence[Row], sides: Sequence[Row]
    ) -> Solution:
        """Solve linear equations for w′, the acceleration of the second body, n, the torque, and the second friction.

        ``rate``: that of the second body; ``screw_held``, ``all_held``: whether θ′ is zero, and that rate as well.
        """
        turn, second, contact, torque, friction = solved(matrix, sides)
        frozen = ({1: -self.d.input_speed} if screw_held else {}) | ({3: 0} if all_held else {})
        return Solution(law, ((0, 1, 0, 0, 0), turn, rate, second), frozen, contact, torque, friction)

    @abstractmethod
    def holds(self, way: int) -> Mapping[int, Mapping[int, Row]]:
        """Return the rows that are positive while static friction keeps the threads from slipping in a direction.

        By the side of rest, a sign of n or 0 alone if that does not matter, and by direction.
        """

    @abstractmethod
    def released(self, direction: int, side: int) -> int:
        """Return the sign of n with which slip begins at the end of static friction."""

    @abstractmethod
    def tied(self, slip: bool, second: bool) -> tuple[Row, ...]:
        """Return the rows of the reset that sets the named speeds to exactly zero."""

    def automaton(self) -> Automaton:
        """Assemble the tables of all modes; the shortest stay that counts as one is set by their time scales [s]."""
        _, _, self.reversal, self.stick, self.turn, self.release, self.seizure, *self.second_kinds = self.events
        # Directions of the second body; without friction a single one stands for all of them.
        self.ways = tuple(HELD) if self.limited else (1,)
        self.slips = tuple(x for x in SLIPS if not self.paradox or x[0] * x[1] < 0)
        self.solutions = {self.slip_name(d, q, a): self.solve(d, d * q, a) for d, q in self.slips for a in self.ways}
        self.lasting = {a: self.solve(0, 1, a) for a in self.ways}  # at rest
        self.held = {a: self.holds(a) for a in self.ways}
        self.sides = tuple(self.held[1])
        self.solutions |= {self._rest(side, a): self.lasting[a] for side in self.sides for a in self.ways}
        self.gauge = {(d, a): self.solve(d, -1, a).contact for d in DIRECTIONS for a in self.ways}  # Q > 0 ⇔ > 0
        self.surfaces: dict[str, Surface] = {}
        self.transitions = {"entry": Transition(tuple(self._entry()))}
        guards = {self.slip_name(d, q, a): self._slip_guards(d, q, a) for d, q in self.slips for a in self.ways}
        guards |= {self._rest(side, a): self._rest_guards(side, a) for side in self.sides for a in self.ways}
        modes = {name: self._mode(name, found) for name, found in guards.items()}
        seen = {mode: self.observables(self.solutions[mode], self.slowest) for mode in modes}
        parts: dict[str, dict[str, Row]] = {}
        if self.pieces is not None:
            parts = under_law(self, modes, seen)
        return assemble(
            states=self.states,
            surfaces=self.surfaces,
            modes=modes,
            transitions=self.transitions,
            observables={name: {mode: rows[name] for mode, rows in seen.items()} for name in OUTPUTS},
            parts=parts,
            shortest_stay=SHORT_STAY * min(scale for mode in modes.values() for scale in mode.flow.time_scales),
            stack=modal_flow if self.pieces is None else taylor_flow,
            forms=guard_forms if self.pieces is None else None,
            rest_codes=tuple(mode.code for name, mode in modes.items() if name.startswith("rest")),
            release_kinds=(self.release,),
            passive=True,
            sprag_kinds=(self.seizure,),
        )

    def observables(self, solution: Solution, mu: arb) -> dict[str, tuple]:
        """Rows of the observables; N is n / (cos λ + s μ sin λ) in slip, n cos λ − T sin λ / r_m at rest (torque T)."""
        d, law = self.d, solution.law
        if law:
            normal = scaled(solution.contact, 1 / (d.cos_lead + law * mu * d.sin_lead))
        else:
            tilted = scaled(solution.torque, -d.sin_lead / d.pitch_radius)
            normal = plus(scaled(solution.contact, d.cos_lead), tilted)
        torque = scaled(self.deflection, -d.coupling_stiffness)
        rows = (normal, solution.contact, torque, self.deflection, self.speed, self.nut_speed)
        return dict(zip(OUTPUTS, rows, strict=True))

    def slip_name(self, d: int, q: int, a: int) -> str:
        """Name of the slip in direction d with n of sign q, the second body moving in direction a."""
        return f"slip_{DIRECTIONS[d]}_{SIGNS[q]}{self._suffix(a)}"

    def _rest(self, side: int, a: int) -> str:
        """Name of the rest on a side (sign of n, 0 if it does not matter), the second body moving in direction a."""
        return f"rest{'_' + SIGNS[side] if side else ''}{self._suffix(a)}"

    def _suffix(self, a: int) -> str:
        return f"_{self.second}_{HELD[a]}" if self.limited else ""

    def _mode(self, name: str, guards: tuple[Guard, ...]) -> Mode:
        solution = self.solutions[name]
        if self.pieces is None:
            flow = linear_mode(solution.field, self.sizes, solution.frozen, self.movable)
        else:
            flow = still_mode([constant(0) if i in solution.frozen else row for i, row in enumerate(solution.field)])
        return Mode(self.modes[name.upper()], flow, guards)

    def guard(self, surface: str, row: Row, side: int, transition: str, snap: int | None = None) -> Guard:
        """Return a guard, note its surface; ``snap``: coordinate that is set on it, by default the most effective."""
        if snap is None:
            weights = [abs(float(x)) * size for x, size in zip(row, self.sizes, strict=False)]
            snap = weights.index(max(weights))
        self.surfaces[surface] = Surface(row, snap)
        return Guard(surface, side, transition)

    def _slip_guards(self, d: int, q: int, a: int) -> tuple[Guard, ...]:
        here, suffix = self.slip_name(d, q, a), self._suffix(a)
        if self.paradox:
            self.transitions[f"contact_{here}"] = Transition(tuple(self._after_seizure(d)), reset=self.impact)
        else:
            turned = Branch(self.slip_name(d, -q, a), self.reversal, sign=-q)
            self.transitions[f"contact_{here}"] = Transition((turned,))
        self.transitions[f"stop{suffix}"] = self._stop(a)
        contact = self.guard(f"contact_{DIRECTIONS[d]}{suffix}", self.gauge[d, a], q, f"contact_{here}")
        stop = self.guard("slip_speed", self.slip, d, f"stop{suffix}", self.snaps[0])
        second = f"second_stop_{DIRECTIONS[d]}"
        if self.limited:
            self.transitions[second] = Transition(tuple(self._second_stopped(d)), reset=self.tied(False, True))
        onward = {way: self.slip_name(d, q, way) for way in DIRECTIONS}
        return (contact, stop, *self._second_guards(here, a, second, onward))

    def _rest_guards(self, side: int, a: int) -> tuple[Guard, ...]:
        here, guards = self._rest(side, a), []
        for d in (self.turning, -self.turning):  # the guards of the mirrored drive come in the same order
            sign_of_n = -d if self.paradox else self.released(d, side)
            released = [Branch(self.slip_name(d, sign_of_n, a), self.release)]
            if not (self.same or self.paradox):  # with static friction alone n might turn over as slip begins
                released.insert(
                    0, Branch(self.slip_name(d, -sign_of_n, a), self.release, (self._turns(d, -sign_of_n, a),))
                )
            transition = f"release_{DIRECTIONS[d]}_{here}"
            self.transitions[transition] = Transition(tuple(released), reset=self.tied(True, a == 0))
            guards.append(self.guard(f"hold_{DIRECTIONS[d]}_{here}", self.held[a][side][d], 1, transition))
        if self.turns_over:
            turned = Branch(self._rest(-side, a), self.reversal, sign=-side)
            self.transitions[f"contact_{here}"] = Transition((turned,))
            row = self.lasting[a].contact
            guards.append(self.guard(f"contact_rest{self._suffix(a)}", row, side, f"contact_{here}"))
        if self.limited:
            self.transitions["second_stop_rest"] = self._all_stopped(self._second_kind)
        onward = {way: self._rest(side, way) for way in DIRECTIONS}
        return (*guards, *self._second_guards(here, a, "second_stop_rest", onward))

    def _second_guards(self, here: str, a: int, stop: str, onward: Mapping[int, str]) -> Iterator[Guard]:
        """Guards of the second body: its speed while it slides, both ends of its friction while it is held."""
        if self.limited and a:
            yield self.guard("second_speed", self.sliding, a, stop, self.snaps[1])
        elif self.limited:
            for way in (self.turning, -self.turning):
                transition = f"second_release_{DIRECTIONS[way]}_{here}"
                reset = self.tied(here.startswith("rest"), True)
                self.transitions[transition] = Transition((Branch(onward[way], self.second_kinds[2]),), reset=reset)
                row = self._room(self.solutions[here], way)
                yield self.guard(f"second_hold_{DIRECTIONS[way]}_{here}", row, 1, transition)

    def _room(self, solution: Solution, way: int) -> Row:
        """Friction that is left to keep the second body from sliding one way."""
        return plus(constant(self.limit), scaled(solution.second_force, -way))

    def _slip_kind(self, d: int, a: int) -> int:
        return self.turn if d else self.stick

    def _second_kind(self, d: int, a: int) -> int:
        return self.second_kinds[1 if a else 0]

    def _stop(self, a: int) -> Transition:
        """Transition in which the threads come to ω = 0."""
        if self.paradox:
            return Transition(tuple(self._beyond_hold((self.stick, self.turn))))
        if a == 0:
            return self._all_stopped(self._slip_kind)
        return Transition(tuple(self._standing(a)), reset=self.tied(True, False))

    def _all_stopped(self, kind: Callable[[int, int], int]) -> Transition:
        return Transition(tuple(self._corner(kind)), reset=self.tied(True, True))

    def _law_holds(self, d: int, q: int, a: int) -> Side:
        """Condition under which Q gives n the sign q."""
        return scaled(self.gauge[d, a], q), Test.POSITIVE if q > 0 else Test.NOT_NEGATIVE

    def _turns(self, d: int, q: int, a: int) -> Side:
        """Condition under which Q gives n the sign q beyond doubt."""
        return scaled(self.gauge[d, a], q), Test.POSITIVE

    def _starts(self, d: int, q: int, a: int) -> Side:
        return scaled(rate_of(self.slip, self.solutions[self.slip_name(d, q, a)].field), d), Test.POSITIVE

    def _slides(self, mode: str, a: int) -> Side:
        return scaled(rate_of(self.sliding, self.solutions[mode].field), a), Test.POSITIVE

    def _side_holds(self, side: int, a: int) -> tuple[Side, ...]:
        return ((scaled(self.lasting[a].contact, side), Test.NOT_NEGATIVE),) if side else ()

    def _rests(self, a: int, kind: int, impulse: int = 0) -> Iterator[Branch]:
        """Branches to rest, on the side that holds; the last one takes what is left."""
        for side in self.sides:
            conditions = () if side == self.sides[-1] else self._side_holds(side, a)
            yield Branch(self._rest(side, a), kind, conditions, impulse)

    def _standing(self, a: int) -> Iterator[Branch]:
        """Branches at ω = 0 where the second body slides or has no friction: slip that accelerates, else rest."""
        if not self.same:
            yield from self._held_at_rest(a, self.stick)
        for d, q in self.slips:
            yield Branch(self.slip_name(d, q, a), self.turn, (self._law_holds(d, q, a), self._starts(d, q, a)))
        yield from self._rests(a, self.stick)

    def _held_at_rest(self, a: int, kind: int) -> Iterator[Branch]:
        """Branches to rest where static friction holds, although sliding friction might not."""
        for side in self.sides:
            stays = tuple((row, Test.NOT_NEGATIVE) for row in self.held[a][side].values())
            yield Branch(self._rest(side, a), kind, (*self._side_holds(side, a), *stays))

    def _second_stopped(self, d: int) -> Iterator[Branch]:
        """The second body stops while the threads slip; it slides on if that accelerates it, else it is held."""
        for a in DIRECTIONS:
            for q in SIGNS:
                mode = self.slip_name(d, q, a)
                yield Branch(mode, self.second_kinds[1], (self._law_holds(d, q, a), self._slides(mode, a)))
        for q in SIGNS:
            yield Branch(self.slip_name(d, q, 0), self.second_kinds[0], (self._law_holds(d, q, 0),) if q > 0 else ())

    def _corner(self, kind: Callable[[int, int], int]) -> Iterator[Branch]:
        """Branches where both are at rest: the one mode whose accelerations, forces and signs agree."""
        for a in self.ways:
            rests = [
                Branch(branch.mode, branch.kind, (*branch.conditions, *self._second_agrees(branch.mode, a)))
                for branch in (self._held_at_rest(a, kind(0, a)) if a or not self.same else ())
            ]
            yield from () if self.same else rests
            for d, q in self.slips:
                mode = self.slip_name(d, q, a)
                conditions = (self._law_holds(d, q, a), self._starts(d, q, a), *self._second_agrees(mode, a))
                yield Branch(mode, kind(d, a), conditions)
            yield from rests if self.same else ()
        yield from self._rests(0, kind(0, 0))

    def _second_agrees(self, mode: str, a: int) -> tuple[Side, ...]:
        if a:
            return (self._slides(mode, a),)
        return tuple((self._room(self.solutions[mode], way), Test.NOT_NEGATIVE) for way in DIRECTIONS)

    def _beyond_hold(self, kinds: tuple[int, int], impulse: int = 0) -> Iterator[Branch]:
        """Branches at ω = 0 for Γ₊ ≤ 0: beyond static friction slip under law −1, else rest; kinds (rest, slip)."""
        rests = list(self._rests(1, kinds[0], impulse))
        for side, rest in zip(self.sides, rests, strict=True):
            for d, row in self.held[1][side].items():
                excess = (scaled(row, -1), Test.POSITIVE)
                yield Branch(self.slip_name(d, -d, 1), kinds[1], (*self._side_holds(side, 1), excess), impulse)
            yield rest

    def _after_seizure(self, d: int) -> Iterator[Branch]:
        """Branches after an impact of sign d, which leaves n of that sign, with which law −1 slips against it."""
        admissible = (scaled(self.gauge[-d, 1], d), Test.POSITIVE)
        yield Branch(self.slip_name(-d, d, 1), self.seizure, (admissible, self._starts(-d, d, 1)), d)
        yield from self._beyond_hold((self.seizure, self.seizure), d)

    def _entry(self) -> Iterator[Branch]:
        """Branches that start a motion: by the signs of the speeds; where one is zero, as on stopping there."""
        ways = tuple(DIRECTIONS) if self.limited else ()
        for d in DIRECTIONS:
            slips = (scaled(self.slip, d), Test.POSITIVE)
            for a in ways or (1,):
                slides = ((scaled(self.sliding, a), Test.POSITIVE),) if ways else ()
                for q in SIGNS:
                    if (d, q) in self.slips:
                        known = () if self.paradox else (self._law_holds(d, q, a),)
                        yield Branch(self.slip_name(d, q, a), self.release, (slips, *slides, *known))
            if ways:
                yield from _under(slips, self._second_stopped(d))
        for a in ways:
            yield from _under((scaled(self.sliding, a), Test.POSITIVE), self._standing(a))
        if ways:
            yield from self._corner(self._slip_kind)
        elif self.paradox:
            yield from self._beyond_hold((self.stick, self.turn))
        else:
            yield from self._standing(1)


def _under(condition: Side, branches: Iterator[Branch]) -> Iterator[Branch]:
    """Branches with one more condition."""
    for branch in branches:
        yield Branch(branch.mode, branch.kind, (condition, *branch.conditions), branch.sign)


OUTPUTS = (  # forces [N], torque [N m], angle [rad], speeds [rad/s] and [m/s]
    "normal_force", "axial_contact_force", "coupling_torque", "coupling_deflection", "screw_speed", "nut_speed",
)  # fmt: skip
