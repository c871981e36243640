r"""The modes of a drive made of parts, and what leads from one to another: its automaton.

The threads slip with a speed ω in the direction d = sgn ω under the law s = d sgn n, or they rest. A body that slides
against the ground on its own (``Mechanism.own``) has its direction, or it is held. What a mode does, the mechanism
solves; all else follows from the signs of speeds and forces.

* Rigid threads, Γ₊ > 0: the sign of n is that of Q. If Γ₊ > 0 also while bodies are held, exactly one mode is
  consistent in each state: with the accelerations as unknowns, all pieces of the contact problem have determinants of
  one sign. At ω = 0, or where a body stops, that mode is found by trying all of them (:meth:`Modes._outcomes`).
* Rigid threads, Γ₊ ≤ 0 (the Painlevé region, in which a body that slides on its own is refused): law s = −1 is followed
  where it is admissible, dQ < 0. Elsewhere, and on arriving at Q = 0, the threads *seize*: docs/physics.md says why,
  and what follows the impact by either rule of ``resume``.
* Compliant threads: nothing is imposed. N is a function of the state, so a seizure is the fast growth of N under law
  s = +1, which stops the screw, and the motion after it follows from the same equations. N changes at rest, too, where
  the load moves on.

Static friction above that of slow sliding leaves several modes consistent; docs/friction.md says which is taken. Where
several contacts need more friction than they have, it is the one with most at rest.

A drive without parts has two states, (u, w), its own fast flow, and Q as in docs/physics.md (8.17). With R = 0 both T_r
and Q are zero in one place of ω = 0, the *corner*. Seizures from one side of it leave the coupling at deflections
z_{n+1} = (c − I c_x / m) z_n² / (2 Γ₋ |Ω|) + O(z_n³), so that infinitely many accumulate in the corner
in finite time; after three or four the next one lies below the digits of a double. The screw rests there for no time,
and is released to the other side.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, reduce
from itertools import chain, product
from typing import Any

import numpy as np

from lsvib.drives import observables
from lsvib.drives.drive import PARTS
from lsvib.drives.mechanics import plus, rate_of
from lsvib.drives.mechanism import Mechanism, Solution
from lsvib.drives.names import DIRECTIONS, HOLDS, HOW, SIGNS, Event, Key, Resume, Ways, codes_of, mode_name
from lsvib.errors import InputError
from lsvib.systems.automaton import SHORT_STAY, Automaton, Branch, Guard, Mode, Surface, Transition, assemble, scaled
from lsvib.systems.exact.arithmetic import Row, added, double, place_of_largest, sign
from lsvib.systems.exact.modal_form import PlanarMode, linear_mode
from lsvib.systems.exact.taylor_form import still_mode
from lsvib.systems.kernels.layout import Test

Side = tuple[Row, Test]  # a row and the test that it has to pass
Candidate = tuple[Key, tuple[Side, ...]]  # a mode and the conditions under which it follows


class Modes:
    """All modes of a drive with rigid or compliant threads, and its automaton.

    Arguments: the mechanism; how motion resumes after a seizure. ``low`` and ``high`` [m/s] are the ends of the
    interval of sliding speed in which Γ₊ > 0; it begins at infinity where there is none. ``seizes``: whether the
    threads can.
    """

    in_series = False  # whether motions are followed by their series, as under a friction law

    def __init__(self, mechanism: Mechanism, resume: Resume = "contact_sign") -> None:
        m = self.m = mechanism
        self.resume = resume
        ahead = m.turning or 1
        self.both = ahead, -ahead  # so that guards of the mirrored drive come in the same order
        self.codes = codes_of(m.own, m.sides)
        self.low, self.high = self._speeds_without_paradox()  # [m/s]
        self.paradox = sign(self.low) > 0
        self.seizes = self.paradox and not m.compliant
        self._refuse()
        self.signs = (1,) if m.idle else tuple(SIGNS)
        directions = [(d, q) for d in DIRECTIONS for q in self.signs if not self.seizes or d * q < 0]
        self.ways = tuple(product(HOW, repeat=len(m.own)))
        self.slips = [(d, q, ways) for d, q in directions for ways in self.ways]
        self.rests = [(0, side, ways) for side in m.sides for ways in self.ways]
        self.surfaces: dict[str, Surface] = {}
        self.transitions: dict[str, Transition] = {}
        self._solved = cache(m.solve)
        self._flows = cache(lambda *known: self._flow(self._solved(*known)))
        self._seen = cache(lambda *known: observables.rows(m, self._solved(*known)))
        self._left = cache(lambda ways, d, side: m.left(self.solution((0, side, ways)), d, side))
        self._carries, self._agrees = cache(self._signed), cache(self._stays)
        self._speeds = {"slip": m.slip, "slide": m.nut_speed, "bearing": m.speed}
        self.planar = len(m.states) == 2 and not self.in_series
        self.corner = self._corner() if self.planar and m.turning else None

    def _corner(self) -> tuple[Row, ...] | None:
        """Return the reset to where rest ends if a double cannot tell its other end, or Q = 0, from there; else None.

        Beside it, on the wrong side by a last place, the screw would stop again at once, and so for ever.
        """
        (end, other), gauge = (self._left((), d, 0) for d in self.both), self.gauge(self.both[0], ())
        place, speed = -end[-1] / end[0], self.m.constant(-self.m.d.input_speed)
        apart = (end[-1] / end[0], other[-1] / end[0]), (place, gauge[1] * speed[-1] / gauge[0], gauge[-1] / gauge[0])
        sizes = (abs(added(*terms, least=0)) for terms in apart)
        near = any(sign(10**13 * x - abs(place)) <= 0 for x in sizes)  # a tenth of it is what rounding may make of u
        return (self.m.constant(place), speed) if near else None

    def _contracts(self) -> bool:
        """Whether the motion enlarges no area (see ``Automaton``): Γ₊ > 0, both C_s > 0 or zero, one friction for all.

        Why, docs/attraction.md says. Static friction above that of sliding makes motions jump where rest begins.
        """
        if not self.planar or self.paradox or not (self.m.turning and self.m.same):
            return False
        return {sign(-self.solution(key).field[1][1], "support_damping") for key in self.slips} in ({0}, {1})

    def _speeds_without_paradox(self) -> tuple[Any, Any]:
        inertia, mass = self.m.effective()
        return (math.inf if sign(inertia - self.m.turned * mass, "mass") <= 0 else 0.0), math.inf

    def _refuse(self) -> None:
        """Refuse dry frictions that leave the motion undetermined."""
        m = self.m
        for name in m.own if self.seizes else ():
            raise InputError(
                f"{self._given(name)} needs a drive outside the Painlevé region: inside it the threads can seize, and "
                f"while the {name} sticks, what follows a seizure is not determined."
            )
        if "slide" in m.own and not m.compliant:
            inertia, mass = m.effective(["slide"])
            if sign(inertia - m.turned * mass, "screw_mass") <= 0:
                raise InputError(
                    f"{self._given('slide')} needs screw_mass < {size_of(inertia / m.turned):.6g} kg: above "
                    "that, the threads jam while the slide sticks, and the motion is not determined."
                )

    def _given(self, body: str) -> str:
        """Say the friction of a body, in sliding or else at rest."""
        sliding = size_of(self.m.limits[body])
        key = "friction" if sliding else "static_friction"
        return f"{body}_{key} = {sliding or size_of(self.m.holding[body]):g}"

    def name(self, key: Key) -> str:
        """Return the name of a mode."""
        return mode_name(key, self.m.own)

    def solution(self, key: Key) -> Solution:
        """Return what Newton's laws say in a mode."""
        return self._solved(*self._known(key))

    def _known(self, key: Key) -> tuple[int, int, Ways]:
        """What Newton's laws depend on: direction of slip, which only friction against the ground feels, law, ways."""
        d, q, ways = key
        return (d if self.m.limits else abs(d)), d * q, ways

    def gauge(self, d: int, ways: Ways) -> Row:
        """Return a row that has the sign of n at rest or in slip in a direction, whatever the law: N, or n under −1."""
        found = self.solution((d, -d, ways))
        return found.normal if self.m.compliant else found.contact

    def automaton(self) -> Automaton:
        """Assemble the tables of all modes."""
        return assemble(**self.layout())

    def without_rest(self) -> Automaton:
        """Assemble those of slip in the direction of the motor alone, for motions that do not reach ω = 0."""
        whole = self.layout()
        names = [self.name(key) for key in self.slips if key[0] == self.m.turning]
        contact = {name: replace(whole["modes"][name], guards=whole["modes"][name].guards[:1]) for name in names}
        transitions = {
            name: replace(transition, branches=tuple(branch for branch in transition.branches if branch.mode in names))
            for name, transition in whole["transitions"].items()
        }
        return assemble(**whole | {"modes": contact, "transitions": transitions, "passive": False})

    def layout(self) -> dict[str, Any]:
        """Return what :func:`lsvib.systems.automaton.assemble` makes the tables of."""
        m = self.m
        self.transitions["entry"] = Transition(tuple(self._entry()))
        keys = [*self.slips, *self.rests]
        guards = {key: self._slip_guards(key) if key[0] else self._rest_guards(key) for key in keys}
        modes = {self.name(key): self._mode(key, guards[key]) for key in keys}
        seen = {self.name(key): self._seen(*self._known(key)) for key in keys}
        parts = self._parts(modes, seen)
        moving = [self.name(key) for key in (self.slips if self.planar else keys)]
        scales = [0.0] if m.compliant else [x for name in moving for x in modes[name].flow.time_scales]
        marked = {"rest": self.rests, "held": [key for key in self.slips if 0 in key[2]]}
        if m.compliant and self.paradox:  # motions sprag under law s = +1
            marked["jam"] = [key for key in self.slips if key[0] * key[1] > 0]
        marks = {mark: frozenset(self.codes[self.name(key)] for key in keys) for mark, keys in marked.items()}
        marks |= {"impact": frozenset(() if m.compliant else [Event.SEIZURE]), "passage": frozenset([Event.PASSAGE])}
        return dict(
            states=m.states,
            surfaces=self.surfaces,
            modes=modes,
            transitions=self.transitions,
            observables={name: {mode: rows[name] for mode, rows in seen.items()} for name in observables.TABLE},
            parts=parts,
            shortest_stay=SHORT_STAY * reduce(np.minimum, scales),
            events={int(event): event.name.lower() for event in Event},
            marks=marks,
            stands=not m.turning,
            passive=not m.compliant,
            contracts=self._contracts(),
        )

    def _mode(self, key: Key, guards: tuple[Guard, ...]) -> Mode:
        beyond = "rest" if self.corner or (self.planar and self.seizes and key[0]) else None
        return Mode(self.codes[self.name(key)], self._flows(*self._known(key)), guards, beyond)

    def _flow(self, found: Solution) -> Any:
        """Return the flow of a mode; with a clock its rates of zero are a chain, which has no modal form."""
        if self.m.command or self.in_series:
            zero = self.m.constant(0)
            return still_mode([zero if i in found.frozen else row for i, row in enumerate(found.field)])
        if not self.planar:
            return linear_mode(found.field, self.m.sizes, found.frozen, PARTS[self.m.parts[-1]][-1])
        stiffness, damping, force = found.field[1]
        return PlanarMode.of(1, -damping, -stiffness, force)

    def _parts(self, modes: dict[str, Mode], seen: dict[str, dict[str, Row]]) -> dict[str, dict[str, Row]]:
        """Return the rows of the observables that count η times, by name and mode: none with constant friction."""
        return {}

    # What bounds a mode

    def _guard(self, surface: str, row: Row, side: int, transition: str, snap: int | None = None) -> Guard:
        """Return a guard, note its surface; ``snap``: coordinate that is set on it, by default the most effective.

        The rounding of another one would be amplified by the ratio of their effects.
        """
        if surface not in self.surfaces:
            if snap is None:
                snap = place_of_largest([abs(double(x)) * size for x, size in zip(row, self.m.sizes, strict=False)])
            self.surfaces[surface] = Surface(row, snap)
        return Guard(surface, side, transition)

    def _slip_guards(self, key: Key) -> tuple[Guard, ...]:
        (d, q, ways), m, suffix, here = key, self.m, self._suffix(key[2]), self.name(key)
        contact: tuple[Guard, ...] = ()
        if not m.idle:
            turned = (Branch(self.name((d, -q, ways)), Event.CONTACT_REVERSAL, sign=-q),)
            branches, reset = (tuple(self._after_seizure(d)), m.impact) if self.seizes else (turned, None)
            self.transitions[f"contact_{here}"] = Transition(branches, reset=reset)
            surface = f"contact_{DIRECTIONS[self._known(key)[0]]}{suffix}"
            contact = (self._guard(surface, self.gauge(d, ways), q, f"contact_{here}"),)
        if f"stop{suffix}" not in self.transitions:
            self.transitions[f"stop{suffix}"] = self._stop("slip", 0, ways)
        stop = self._guard("slip_speed", m.slip, d, f"stop{suffix}", m.place.get("nut", 0) + 1)
        return (*contact, stop, *self._body_guards(key))

    def _held_in(self, ways: Ways) -> list[str]:
        return [body for body, way in zip(self.m.own, ways, strict=True) if way == 0]

    def _suffix(self, ways: Ways) -> str:
        return "".join(f"_{HOLDS[body]}_{HOW[way]}" for body, way in zip(self.m.own, ways, strict=True))

    def _rest_guards(self, key: Key) -> tuple[Guard, ...]:
        (_, side, ways), here, m, guards = key, self.name(key), self.m, []
        # With two states the turning motor alone moves the coupling, and so only to the end that is ahead.
        for d in self.both[:1] if self.planar and m.turning else self.both:
            q = -d if self.seizes else m.released(d, side)
            transition = self._release(key, "slip", d, (d, q, ways))
            left = self._left(ways, d, side)
            guards.append(self._guard(f"hold_{DIRECTIONS[d]}_{here}", left, 1, transition, 0 if m.compliant else None))
        if side and "bearing" in m.tied:  # the bearing holds on where n passes zero
            turned = Branch(self.name((0, -side, ways)), Event.CONTACT_REVERSAL, sign=-side)
            self.transitions[f"contact_{here}"] = Transition((turned,))
            surface = f"contact_rest{self._suffix(ways)}"
            guards.append(self._guard(surface, self.gauge(0, ways), side, f"contact_{here}"))
        return (*guards, *self._body_guards(key))

    def _release(self, key: Key, last: str, onward: int, alone: Key) -> str:
        """Return the name of the transition in which the threads or a body let go; ``alone``: the mode if others stay.

        Where friction falls as it lets go, all forces jump, so that others may let go as well, or n turn over.
        """
        (d, _, ways), jumps = key, not (self.m.same or self.seizes or self.corner)
        where = f"{DIRECTIONS.get(d, 'rest')}{self._suffix(ways)}" if jumps else self.name(key)
        name = f"{last}_release_{DIRECTIONS[onward]}_{where}"
        if name not in self.transitions:
            branches = self._outcomes(d, ways, last, onward) if jumps else [self._branch(alone, last, onward)]
            reset = self.corner or self.m.reset(d == 0, self._held_in(ways))
            self.transitions[name] = Transition(tuple(branches), reset=reset)
        return name

    def _body_guards(self, key: Key) -> Iterator[Guard]:
        """Guards of the bodies: the speed of one that slides, both ends of the friction of one that is held."""
        (d, q, ways), here, m = key, self.name(key), self.m
        for k, (body, way) in enumerate(zip(m.own, ways, strict=True)):
            if way:
                name = f"{body}_stop_{DIRECTIONS[d] if d else 'rest'}{self._suffix(ways)}"
                if name not in self.transitions:
                    self.transitions[name] = self._stop(body, d, ways)
                snap = m.place[m.sliders[0]] + 1 if body == "slide" else 1
                yield self._guard(f"{body}_speed", self._speeds[body], way, name, snap)
                continue
            for onward in self.both:
                name = self._release(key, body, onward, (d, q, (*ways[:k], onward, *ways[k + 1 :])))
                yield self._guard(f"{body}_hold_{DIRECTIONS[onward]}_{here}", self._room(key, body, onward), 1, name)

    def _room(self, key: Key, body: str, way: int) -> Row:
        """Friction that is left to keep a body from sliding one way."""
        return plus(self.m.constant(self.m.holding[body]), scaled(self.solution(key).held[body], -way))

    # Where a speed comes to zero

    def _stop(self, last: str, d: int, ways: Ways) -> Transition:
        """Transition in which the threads (``slip``) or a body come to a stop, by trying what may then move or hold."""
        if self.seizes:
            return Transition(tuple(self._beyond_hold((Event.STICK, Event.REVERSAL))))
        held = [*self._held_in(ways), *({last} & {*self.m.own})]
        return Transition(tuple(self._outcomes(d, ways, last)), reset=self.m.reset(d == 0, held))

    def _outcomes(self, d: int, ways: Ways, last: str = "", onward: int = 0) -> list[Branch]:
        """Branches to all that may follow an instant, rests before slips: the first whose conditions hold is taken.

        Before it the threads slip in a direction d or stand (0), and the bodies go their ``ways``. Now the threads
        (``slip``) or a body, ``last``, stop, or let go and move ``onward``; at the start of a motion neither. In order:

        1. All that stands stays, if it needs no more friction than it has, at this instant and just after it.
        2. Where sliding holds less than rest: the only contact that needs more lets go, and then what it can no longer
           hold; or it alone, and more with it at once.
        3. Some of what stands begins to move so that all accelerations and forces agree: as little as possible, the
           threads last, and of as much first what has just stopped.
        4. All stands, also by what rounding has left.
        """
        before = dict(zip(("slip", *self.m.own), (d, *ways), strict=True))
        before |= {last: onward} if last else {}
        stands = [name for name, way in before.items() if way == 0]

        def amount(begin: tuple[int, ...]) -> tuple[int, bool, int]:
            moving = [name for name, way in zip(stands, begin, strict=True) if way]
            return len(moving), "slip" in moving, len({*moving} - {last})

        _, *begins = sorted(product(HOW, repeat=len(stands)), key=amount)
        candidates = self._agreeing(before, stands) if stands else []
        candidates += [] if self.m.same else self._letting_go_alone(before, stands)
        for begin in begins:
            candidates += self._agreeing(before | dict(zip(stands, begin, strict=True)), stands)
        *others, (key, _) = self._by_sign(before)
        candidates += [*others, (key, ())]
        return [self._branch(key, last, onward, conditions) for key, conditions in candidates]

    def _agreeing(self, now: Mapping[str, int], stands: Sequence[str]) -> list[Candidate]:
        """The modes in which all moves as ``now``, if that agrees with what ``stands`` before it."""
        return [
            (key, (*carries, *chain.from_iterable(self._agrees(name, key) for name in stands)))
            for key, carries in self._by_sign(now)
        ]

    def _letting_go_alone(self, before: Mapping[str, int], stands: Sequence[str]) -> list[Candidate]:
        """What follows where of all that ``stands`` one contact alone needs more friction than it has."""
        found: list[Candidate] = []
        for (key, carries), name, way in product(self._by_sign(before), stands, DIRECTIONS):
            within = chain.from_iterable(self._agrees(other, key) for other in stands if other != name)
            needs = self._now_or_next(scaled(self._spare(name, key, way), -1), key, Test.POSITIVE)
            alone = (*carries, *within, *needs)
            onward = self._agreeing({**before, name: way}, stands)
            found += [(other, (*alone, *conditions)) for other, conditions in onward]
            found.append((key, alone))
        return found

    def _branch(self, key: Key, last: str, onward: int = 0, conditions: tuple[Side, ...] = ()) -> Branch:
        """Return the branch to a mode in which the threads or a body, ``last``, have stopped, or let go ``onward``."""
        body = last if last in self.m.own else ""
        moves = key[2][self.m.own.index(body)] if body else key[0]
        what = "release" if onward else "reversal" if moves else "stick"
        return Branch(self.name(key), Event[f"{body}_{what}".strip("_").upper()], conditions)

    def _by_sign(self, now: Mapping[str, int]) -> list[Candidate]:
        """The modes in which all moves as ``now``, by the sign of n, with the conditions under which it has that."""
        way, *bodies = now.values()
        ways = tuple(bodies)
        if way:
            carries = {} if self.m.idle else self._carries(*self._known((way, -way, ways)))
            return [((way, q, ways), carries.get(q, ())) for q in self.signs]
        row = self.gauge(0, ways)
        signed = {side: ((scaled(row, side), Test.NOT_NEGATIVE),) if side else () for side in self.m.sides}
        return [((0, side, ways), conditions) for side, conditions in signed.items()]

    def _signed(self, d: int, law: int, ways: Ways) -> dict[int, tuple[Side, ...]]:
        """Conditions under which n has a sign in slip, by that sign, now or – if it is zero – at once, by its rates.

        On n = 0 the first derivative that is not zero is the same under both laws, with any coefficient.
        """
        row, field = self.gauge(d, ways), self._solved(d, law, ways).field
        rate, last = rate_of(row, field), {1: Test.POSITIVE, -1: Test.NOT_NEGATIVE}
        leads, second = ((row, Test.LEADS), (rate, Test.LEADS)), rate_of(rate, field)
        return {q: tuple((scaled(x, q), test) for x, test in (*leads, (second, last[q]))) for q in SIGNS}

    def _stays(self, name: str, key: Key) -> tuple[Side, ...]:
        """Conditions under which the threads (``slip``) or a body that stood stay, or begin to move, as a mode says."""
        way = key[0] if name == "slip" else key[2][self.m.own.index(name)]
        if way:
            started = scaled(rate_of(self._speeds[name], self.solution(key).field), way)
            return self._now_or_next(started, key, Test.POSITIVE)
        rows = [self._spare(name, key, onward) for onward in DIRECTIONS]
        return tuple(chain.from_iterable(self._now_or_next(row, key, Test.NOT_NEGATIVE) for row in rows))

    def _spare(self, name: str, key: Key, way: int) -> Row:
        """Friction that is left to keep the threads (``slip``) or a body from moving one way in a mode."""
        return self._left(key[2], way, key[1]) if name == "slip" else self._room(key, name, way)

    def _now_or_next(self, row: Row, key: Key, last: Test) -> tuple[Side, ...]:
        """Conditions under which a function of the state is positive in a mode, or is zero and passes as it changes."""
        return (row, Test.LEADS), (rate_of(row, self.solution(key).field), last)

    def _beyond_hold(self, kinds: tuple[int, int], impulse: int = 0) -> Iterator[Branch]:
        """Branches at ω = 0 for Γ₊ ≤ 0: beyond static friction slip under law −1, else rest; kinds (rest, slip)."""
        for key, condition in self._by_sign({"slip": 0}):
            for d in DIRECTIONS:
                excess = (scaled(self._left((), d, key[1]), -1), Test.POSITIVE)
                yield Branch(self.name((d, -d, ())), kinds[1], (*condition, excess), impulse)
            yield Branch(self.name(key), kinds[0], condition, impulse)

    def _after_seizure(self, d: int) -> Iterator[Branch]:
        """Branches after an impact of sign d, which leaves n of that sign, with which law −1 slips against it."""
        for way in (1, -1) if self.resume == "at_once" else (-d,):
            admissible = (scaled(self.gauge(way, ()), -way), Test.POSITIVE)
            starts = (scaled(rate_of(self.m.slip, self.solution((way, -way, ())).field), way), Test.POSITIVE)
            yield Branch(self.name((way, -way, ())), Event.SEIZURE, (admissible, starts), d)
        yield from self._beyond_hold((Event.SEIZURE, Event.SEIZURE), d)

    def _entry(self) -> Iterator[Branch]:
        """Branches that start a motion: by the signs of the speeds; where some are zero, as on stopping there."""
        m = self.m
        for d in (1, -1, 0):
            slips: tuple[Side, ...] = ((scaled(m.slip, d), Test.POSITIVE),) if d else ()
            if self.seizes:
                if d:
                    yield Branch(self.name((d, -d, ())), Event.RELEASE, slips)
                else:
                    yield from self._beyond_hold((Event.STICK, Event.REVERSAL))
                continue
            for ways in self.ways:
                going = [(body, way) for body, way in zip(m.own, ways, strict=True) if way]
                moving = [(scaled(self._speeds[body], way), Test.POSITIVE) for body, way in going]
                for branch in self._outcomes(d, ways):
                    conditions = (*slips, *moving, *branch.conditions)
                    yield Branch(branch.mode, Event.RELEASE if d else branch.kind, conditions)


def size_of(value: Any) -> float:
    """A number to be shown; of many drives the largest."""
    return float(np.max(double(value)))
