r"""Modes, guards and transitions of a drive with two coordinates whose threads stay rigid: axial support, rotating nut.

A model solves Newton's laws in each mode (:mod:`lsvib.models.two_bodies`), and everything else follows from
the signs of speeds and forces.

* n = Q / (positive factor × Γ_s), where Q does not depend on the law. If Γ₊ > 0, the sign of n is that of Q. If Γ₊ > 0
  also while the second body is held, exactly one mode is consistent in each state: with the accelerations as unknowns,
  all pieces of the contact problem have determinants of one sign. At ω = 0, or where the second body stops, that mode
  is found by trying all of them.
* If Γ₊ ≤ 0 (the Painlevé region, in which models refuse the second friction), law s = −1 is followed where it is
  admissible, dQ < 0. Elsewhere, and on arriving at Q = 0, the threads seize: ω jumps to zero by an impact with an
  impulse of the sign of ω. After it, slip under law −1 against ω starts at once if it is admissible and accelerates
  away from rest; otherwise the threads rest, or, beyond the ends of static friction, slip under law −1
  (``resume="contact_sign"`` of the rigid drive).
"""

from collections.abc import Callable, Mapping

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
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.exact.modal_form import guard_forms, linear_mode, modal_flow
from lsvib.engine.kernels.layout import Test
from lsvib.models.drive import NutDrive, SupportDrive, once
from lsvib.models.two_bodies import DIRECTIONS, HELD, SIGNS, SLIPS, Solution, TwoBodies, constant, plus


@once
def automaton_of(model: type[TwoBodies], drive: SupportDrive | NutDrive, slide: bool, bearing: bool) -> Automaton:
    """Return the automaton of a drive; ``slide``, ``bearing``: with F_0, with T_0.

    Observables: normal_force and axial_contact_force [N], coupling_torque [N m], coupling_deflection [rad], screw_speed
    [rad/s], nut_speed [m/s]. Raises ``InputError`` where F_0 or T_0 leaves the motion undetermined (see the models),
    ``EngineError`` if the rates of a mode cannot be separated in double precision.
    """
    with many_digits():
        return _Layout(model(drive, slide, bearing)).automaton()


class _Layout:
    """Collect the surfaces, modes and transitions of a drive, mode by mode."""

    def __init__(self, bodies: TwoBodies) -> None:
        self.b = bodies
        _, _, self.reversal, self.stick, self.turn, self.release, self.seizure, *self.second_kinds = bodies.events
        # Directions of the second body; without friction a single one stands for all of them.
        self.ways = tuple(HELD) if bodies.limited else (1,)
        self.slips = tuple(x for x in SLIPS if not bodies.paradox or x[0] * x[1] < 0)
        self.solutions = {self.name(d, q, a): bodies.solve(d, d * q, a) for d, q in self.slips for a in self.ways}
        self.lasting = {a: bodies.solve(0, 1, a) for a in self.ways}  # at rest
        self.holds = {a: bodies.holds(a) for a in self.ways}
        self.sides = tuple(self.holds[1])
        self.solutions |= {self.rest(side, a): self.lasting[a] for side in self.sides for a in self.ways}
        self.gauge = {(d, a): bodies.solve(d, -1, a).contact for d in DIRECTIONS for a in self.ways}  # Q > 0 ⇔ > 0
        self.order = (bodies.turning, -bodies.turning)  # the guards of the mirrored drive come in the same order
        self.surfaces: dict[str, Surface] = {}
        self.transitions: dict[str, Transition] = {}

    def name(self, d: int, q: int, a: int) -> str:
        """Name of the slip in direction d with n of sign q, the second body moving in direction a."""
        return f"slip_{DIRECTIONS[d]}_{SIGNS[q]}{self._suffix(a)}"

    def rest(self, side: int, a: int) -> str:
        """Name of the rest on a side (sign of n, 0 if it does not matter), the second body moving in direction a."""
        return f"rest{'_' + SIGNS[side] if side else ''}{self._suffix(a)}"

    def _suffix(self, a: int) -> str:
        return f"_{self.b.second}_{HELD[a]}" if self.b.limited else ""

    def automaton(self) -> Automaton:
        """Assemble the tables of all modes; the shortest stay that counts as one is set by their time scales [s]."""
        self.transitions["entry"] = Transition(tuple(self._entry()))
        modes = {}
        for d, q in self.slips:
            for a in self.ways:
                modes[self.name(d, q, a)] = self._mode(self.name(d, q, a), self._slip_guards(d, q, a))
        for side in self.sides:
            for a in self.ways:
                modes[self.rest(side, a)] = self._mode(self.rest(side, a), self._rest_guards(side, a))
        seen = {mode: self.b.observables(self.solutions[mode]) for mode in modes}
        scales = [scale for mode in modes.values() for scale in mode.flow.time_scales]
        return assemble(
            states=self.b.states,
            surfaces=self.surfaces,
            modes=modes,
            transitions=self.transitions,
            observables={name: {mode: rows[name] for mode, rows in seen.items()} for name in seen[self.name(1, -1, 1)]},
            shortest_stay=SHORT_STAY * min(scales),
            stack=modal_flow,
            forms=guard_forms,
            rest_codes=tuple(mode.code for name, mode in modes.items() if name.startswith("rest")),
            release_kinds=(self.release,),
            passive=True,
            sprag_kinds=(self.seizure,),
        )

    def _mode(self, name: str, guards: tuple[Guard, ...]) -> Mode:
        solution = self.solutions[name]
        flow = linear_mode(solution.field, self.b.sizes, solution.frozen, self.b.horizon, self.b.movable)
        return Mode(self.b.modes[name.upper()], flow, guards)

    def _guard(self, surface: str, row: Row, sign: int, transition: str, snap: int | None = None) -> Guard:
        """Return a guard, note its surface; ``snap``: coordinate that is set on it, by default the most effective."""
        if snap is None:
            weights = [abs(float(x)) * size for x, size in zip(row, self.b.sizes, strict=False)]
            snap = weights.index(max(weights))
        self.surfaces[surface] = Surface(row, snap)
        return Guard(surface, sign, transition)

    def _slip_guards(self, d: int, q: int, a: int) -> tuple[Guard, ...]:
        here, suffix = self.name(d, q, a), self._suffix(a)
        if self.b.paradox:
            self.transitions[f"contact_{here}"] = Transition(tuple(self._after_seizure(d)), reset=self.b.impact)
        else:
            turned = Branch(self.name(d, -q, a), self.reversal, sign=-q)
            self.transitions[f"contact_{here}"] = Transition((turned,))
        self.transitions[f"stop{suffix}"] = self._stop(a)
        contact = self._guard(f"contact_{DIRECTIONS[d]}{suffix}", self.gauge[d, a], q, f"contact_{here}")
        stop = self._guard("slip_speed", self.b.slip, d, f"stop{suffix}", self.b.snaps[0])
        if self.b.limited:
            self.transitions[f"second_stop_{DIRECTIONS[d]}"] = Transition(
                tuple(self._second_stopped(d)), reset=self.b.tied(False, True)
            )
        onward = {way: self.name(d, q, way) for way in DIRECTIONS}
        return (contact, stop, *self._second_guards(here, a, f"second_stop_{DIRECTIONS[d]}", onward))

    def _rest_guards(self, side: int, a: int) -> tuple[Guard, ...]:
        here, guards = self.rest(side, a), []
        for d in self.order:
            target = self.name(d, -d if self.b.paradox else self.b.released(d, side), a)
            transition = f"release_{DIRECTIONS[d]}_{here}"
            reset = self.b.tied(True, a == 0)
            self.transitions[transition] = Transition((Branch(target, self.release),), reset=reset)
            guards.append(self._guard(f"hold_{DIRECTIONS[d]}_{here}", self.holds[a][side][d], 1, transition))
        if self.b.turns_over:
            turned = Branch(self.rest(-side, a), self.reversal, sign=-side)
            self.transitions[f"contact_{here}"] = Transition((turned,))
            row = self.lasting[a].contact
            guards.append(self._guard(f"contact_rest{self._suffix(a)}", row, side, f"contact_{here}"))
        if self.b.limited:
            self.transitions["second_stop_rest"] = self._all_stopped(self._second_kind)
        onward = {way: self.rest(side, way) for way in DIRECTIONS}
        return (*guards, *self._second_guards(here, a, "second_stop_rest", onward))

    def _second_guards(self, here: str, a: int, stop: str, onward: Mapping[int, str]):
        """Guards of the second body: its speed while it slides, both ends of its friction while it is held."""
        if not self.b.limited:
            return
        if a:
            yield self._guard("second_speed", self.b.sliding, a, stop, self.b.snaps[1])
            return
        for way in self.order:
            transition = f"second_release_{DIRECTIONS[way]}_{here}"
            reset = self.b.tied(here.startswith("rest"), True)
            self.transitions[transition] = Transition((Branch(onward[way], self.second_kinds[2]),), reset=reset)
            row = self._room(self.solutions[here], way)
            yield self._guard(f"second_hold_{DIRECTIONS[way]}_{here}", row, 1, transition)

    def _room(self, solution: Solution, way: int) -> Row:
        """Friction that is left to keep the second body from sliding one way."""
        return plus(constant(self.b.limit), scaled(solution.second_force, -way))

    def _slip_kind(self, d: int, a: int) -> int:
        return self.turn if d else self.stick

    def _second_kind(self, d: int, a: int) -> int:
        return self.second_kinds[1 if a else 0]

    def _stop(self, a: int) -> Transition:
        """Transition in which the threads come to ω = 0."""
        if self.b.paradox:
            return Transition(tuple(self._beyond_hold((self.stick, self.turn))))
        if a == 0:
            return self._all_stopped(self._slip_kind)
        return Transition(tuple(self._standing(a)), reset=self.b.tied(True, False))

    def _all_stopped(self, kind: Callable[[int, int], int]) -> Transition:
        return Transition(tuple(self._corner(kind)), reset=self.b.tied(True, True))

    def _law_holds(self, d: int, q: int, a: int):
        """Conditions under which Q gives n the sign q."""
        return (scaled(self.gauge[d, a], q), Test.POSITIVE if q > 0 else Test.NOT_NEGATIVE)

    def _starts(self, d: int, q: int, a: int):
        return (scaled(self.solutions[self.name(d, q, a)].slip_rate, d), Test.POSITIVE)

    def _side_holds(self, side: int, a: int) -> tuple:
        return ((scaled(self.lasting[a].contact, side), Test.NOT_NEGATIVE),) if side else ()

    def _standing(self, a: int):
        """Branches at ω = 0 where the second body slides or has no friction: slip that accelerates, else rest."""
        for d, q in self.slips:
            yield Branch(self.name(d, q, a), self.turn, (self._law_holds(d, q, a), self._starts(d, q, a)))
        for side in self.sides:
            last = side == self.sides[-1]
            yield Branch(self.rest(side, a), self.stick, () if last else self._side_holds(side, a))

    def _second_stopped(self, d: int):
        """The second body stops while the threads slip; it slides on if that accelerates it, else it is held."""
        for a in DIRECTIONS:
            for q in SIGNS:
                moves = (scaled(self.solutions[self.name(d, q, a)].second_rate, a), Test.POSITIVE)
                yield Branch(self.name(d, q, a), self.second_kinds[1], (self._law_holds(d, q, a), moves))
        for q in SIGNS:
            yield Branch(self.name(d, q, 0), self.second_kinds[0], (self._law_holds(d, q, 0),) if q > 0 else ())

    def _corner(self, kind: Callable[[int, int], int]):
        """Branches where both are at rest: the one mode whose accelerations, forces and signs agree."""
        for a in self.ways:
            for d, q in self.slips:
                mode = self.name(d, q, a)
                conditions = (self._law_holds(d, q, a), self._starts(d, q, a), *self._second_agrees(mode, a))
                yield Branch(mode, kind(d, a), conditions)
            for side in self.sides:
                mode = self.rest(side, a)
                stays = tuple((row, Test.NOT_NEGATIVE) for row in self.holds[a][side].values())
                if a:
                    conditions = (*self._side_holds(side, a), *stays, *self._second_agrees(mode, a))
                    yield Branch(mode, kind(0, a), conditions)
        for side in self.sides:
            yield Branch(self.rest(side, 0), kind(0, 0), () if side == self.sides[-1] else self._side_holds(side, 0))

    def _second_agrees(self, mode: str, a: int) -> tuple:
        if a:
            return ((scaled(self.solutions[mode].second_rate, a), Test.POSITIVE),)
        return tuple((self._room(self.solutions[mode], way), Test.NOT_NEGATIVE) for way in DIRECTIONS)

    def _beyond_hold(self, kinds: tuple[int, int], sign: int = 0):
        """Branches at ω = 0 for Γ₊ ≤ 0: beyond static friction slip under law −1, else rest; kinds (rest, slip)."""
        for side in self.sides:
            for d, row in self.holds[1][side].items():
                excess = (scaled(row, -1), Test.POSITIVE)
                yield Branch(self.name(d, -d, 1), kinds[1], (*self._side_holds(side, 1), excess), sign)
            last = side == self.sides[-1]
            yield Branch(self.rest(side, 1), kinds[0], () if last else self._side_holds(side, 1), sign)

    def _after_seizure(self, d: int):
        """Transition after an impact of sign d, which leaves n of that sign, with which law −1 slips against it."""
        admissible = (scaled(self.gauge[-d, 1], d), Test.POSITIVE)
        yield Branch(self.name(-d, d, 1), self.seizure, (admissible, self._starts(-d, d, 1)), d)
        yield from self._beyond_hold((self.seizure, self.seizure), d)

    def _entry(self):
        """Transition that starts a motion: by the signs of the speeds; where one is zero, as on stopping there."""
        ways = tuple(DIRECTIONS) if self.b.limited else ()
        for d in DIRECTIONS:
            slips = (scaled(self.b.slip, d), Test.POSITIVE)
            for a in ways or (1,):
                slides = ((scaled(self.b.sliding, a), Test.POSITIVE),) if ways else ()
                for q in SIGNS:
                    if (d, q) in self.slips:
                        known = () if self.b.paradox else (self._law_holds(d, q, a),)
                        yield Branch(self.name(d, q, a), self.release, (slips, *slides, *known))
            if ways:
                yield from _under(slips, self._second_stopped(d))
        for a in ways:
            yield from _under((scaled(self.b.sliding, a), Test.POSITIVE), self._standing(a))
        if ways:
            yield from self._corner(self._slip_kind)
        elif self.b.paradox:
            yield from self._beyond_hold((self.stick, self.turn))
        else:
            yield from self._standing(1)


def _under(condition: tuple, branches):
    """Branches with one more condition."""
    for branch in branches:
        yield Branch(branch.mode, branch.kind, (condition, *branch.conditions), branch.sign)
