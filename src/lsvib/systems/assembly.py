r"""From a :class:`lsvib.systems.system.System` to the automaton that the engine runs.

The coordinates are the states, the pairs cos ω t, sin ω t of harmonics, the clocks, and the *forcing's clock* where
there are harmonics and no clock has their common period. As it returns, an event that changes nothing else, it sets all
pairs to (1, 0), so that their rounding does not add up, and they and all clocks have multipliers zero.

A surface σ = 0 divides a mode *below*, x′ = f₁ where σ < 0, from one *above*, x′ = f₂. With r_i = ∇σ·f_i, a motion on
it goes above where r₁ ≥ 0 and r₂ > 0, below where r₁ < 0 and r₂ ≤ 0, and slides along it where r₁ > 0 > r₂; where one
of them is zero, its next derivative decides. If Δ = f₂ − f₁ is the same all along σ = 0, sliding is a linear mode,

    x′ = f₁ − (r₁ / ∇σ·Δ) Δ,

which is left where r₁ or r₂ comes to zero (Filippov). One coordinate is eliminated by σ = 0, so that no chain is left.
What follows where a mode that slides meets another surface is not determined: its motions end there in a sentence.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, reduce
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from lsvib.errors import EngineError, InputError
from lsvib.numbers import shown
from lsvib.systems.automaton import Branch, Guard, Mode, Surface, Transition, assemble, scaled
from lsvib.systems.exact.arithmetic import many_digits, place_of_largest
from lsvib.systems.exact.modal_form import PlanarMode, linear_mode
from lsvib.systems.exact.taylor_form import TaylorMode, settled_region, still_mode
from lsvib.systems.expressions import Affine, Reader, linear, parameters, plus
from lsvib.systems.kernels.law import EXPONENT, FROM, PIECE, TO
from lsvib.systems.kernels.layout import FIRST_MODEL_KIND, Test

MOST_STATES = 12  # that tests have tried, with those of the forcing
FORCING = "phase 0"  # the forcing's clock, and the event at which it returns
_MOST = 100  # modes and kinds of events are numbers of eight bits
# Part of the shortest time scale below which stays, many in a row, are an accumulation: of two states nothing but the
# sum of stays is rounded, of more a stay on a wall is the root of a difference, and so of the root of a rounding.
_SHORT = 1e-20, 1e-6
_ROUNDED = 1e-13  # part of a coefficient that doubles may leave of a difference which is none


class Event(NamedTuple):
    """What happens in some modes, by its keys."""

    mode: Sequence[str]
    when: str | None = None
    at_clock: str | None = None
    reset: Mapping[str, Any] = {}
    to: str | None = None
    beyond: str | None = None


class Border(NamedTuple):
    """A surface between two modes, its row σ, and r₁, r₂ on it; ``slides``: name of the mode of sliding, if any."""

    below: str
    above: str
    at: Affine
    text: str
    rises: tuple[Affine, Affine]
    slides: str | None
    crosses: bool  # whether each motion that comes to it goes through


@lru_cache(maxsize=256)
def made(system: Any) -> "Made":
    """Return what is made from a system; shared by all that are equal, so nobody may change it."""
    with many_digits():
        return Made(system)


class Made:
    """What is made from a system: its ``automaton``, and what else has to be known to ask it.

    ``modes`` by name and index; ``borders`` of the surfaces; ``own`` states; ``period`` [s] of the forcing, None
    without one and nan where its parts have none in common; ``brief``: time [s] that is nothing but where events
    accumulate; ``begin``: the coordinates (n) where the forcing begins; ``free``: how many multipliers a cycle has,
    without those that the forcing or the direction of motion give it.
    """

    def __init__(self, system: Any) -> None:
        self.system, self.own, self.known = system, len(system.states), parameters(system.parameters)
        self.rates = self._positive("harmonics", system.harmonics)
        self.times = dict(zip(system.clocks, self._positive("clocks", system.clocks), strict=True))
        common, self.master = _common([*(2 * arb.pi() / x for x in self.rates), *self.times.values()]), None
        forced = self.rates or self.times
        self.period = (math.nan if common is None else float(common)) if forced else None
        self.free = self.own if forced else self.own - 1
        if self.rates and common is not None:
            self.master = next((name for name, x in self.times.items() if (x - common).contains(0)), FORCING)
            self.times.setdefault(self.master, common)
        self.names = (*system.states, *(name for pair in system.harmonics for name in pair.split(", ")), *self.times)
        self.n = len(self.names)
        if self.n > MOST_STATES:
            raise InputError(f"the system has {self.n} states with its forcing; at most {MOST_STATES} are allowed.")
        self.begin = np.zeros(self.n)
        self.begin[self.own : self.own + 2 * len(self.rates) : 2] = 1.0
        self.reader = Reader(self.names, self.known)
        self.unit: list[Affine] = [tuple(arb(1) if i == j else 0 for j in range(self.n + 1)) for i in range(self.n + 1)]
        self.fields = {name: self._field(f"modes.{name}", own) for name, own in system.modes.items()}
        self.kinds, self.surfaces, self.transitions = dict[str, int](), dict[str, Surface](), dict[str, Transition]()
        self.borders, self.slides = list[Border](), dict[str, Border]()
        self.events, self.beyond = [Event(**own) for own in system.events], dict[str, str]()
        for k, own in enumerate(system.surfaces):
            self._divide(f"surfaces[{k}].at", own["between"], own["at"])
        self._check_events()
        self.modes = {name: k for k, name in enumerate(self.fields)}
        self._assemble()

    def _positive(self, key: str, given: Mapping[str, Any]) -> list[arb]:
        found = [Reader((), self.known).number(x, f"{key}.{name}") for name, x in given.items()]
        for name, x in zip(given, found, strict=True):
            if not x > 0:
                raise InputError(f"{key} = {given[name]} of {name.replace(', ', ' and ')} is not positive.")
        return found

    def _field(self, about: str, given: Mapping[str, Any]) -> list[Affine]:
        if "vector" in given and "matrix" in given:
            rows = [self.reader.affine(x, f"{about}.vector") for x in given["vector"]]
            for i, own in enumerate(given["matrix"]):
                for unit, x in zip(self.unit, own, strict=False):
                    rows[i] = plus(rows[i], scaled(unit, self.reader.number(x, f"{about}.matrix")))
        else:
            rows = [self.reader.affine(given[name], f"{about}.{name}") for name in self.system.states]
        for k, rate in enumerate(self.rates):
            cosine, sine = self.unit[self.own + 2 * k : self.own + 2 * k + 2]
            rows += [scaled(sine, -rate), scaled(cosine, rate)]
        return rows + [self.unit[-1] for _ in self.times]

    def _check_events(self) -> None:
        """Refuse a mode that is none, and one that neither an event nor a surface leads to, or from, beside others."""
        linked = {name for own in self.system.surfaces for name in own["between"]}
        for k, event in enumerate(self.events):
            for name in (*event.mode, *filter(None, (event.to, event.beyond))):
                if name not in [*self.fields]:
                    raise InputError(f"events[{k}] names the mode {shown(name)}; modes are {', '.join(self.fields)}.")
            linked |= {*event.mode, event.to, event.beyond} if event.to or event.beyond else set()
            for mode in event.mode if event.beyond else ():
                if self.beyond.setdefault(mode, str(event.beyond)) != event.beyond:
                    raise InputError(f"mode {mode} has two modes beyond an accumulation; only one can follow.")
        if alone := [name for name in self.system.modes if name not in linked and len(self.system.modes) > 1]:
            raise InputError(f"modes.{alone[0]} is linked with no other mode, neither by an event nor by a surface.")

    # Surfaces

    def _divide(self, about: str, between: Sequence[str], text: str) -> None:
        """Make the border of a surface, and the mode of sliding."""
        at, (below, above) = self._checked(self.reader.affine(text, about), about, text), between
        first, second = self.fields[below], self.fields[above]
        low, high = (_off(_rate(at, rows), at) for rows in (first, second))
        jump = [_off(plus(y, x, -1), at) for x, y in zip(first, second, strict=True)]
        across = plus(high, low, -1)
        size = max(abs(float(x)) for row in (*first, *second) for x in row)
        fixed = all(abs(float(x)) <= _ROUNDED * size for row in jump for x in row[:-1])
        least = _ROUNDED * max(abs(float(x)) for row in (low, high) for x in row)
        pushes = not (fixed or not linear(across)) or float(across[-1]) < -least  # against each other, somewhere
        slides = f"{below}|{above}" if fixed and pushes and (linear(low) or low[-1] > 0) else None
        self.borders.append(Border(below, above, at, text, (low, high), slides, not pushes))
        if slides:
            if slides in self.fields:
                raise InputError(f"two surfaces separate {below} and {above}; only one may, so use more modes.")
            rows = [plus(x, scaled(low, -y[-1] / across[-1])) for x, y in zip(first, jump, strict=True)]
            planar = self.n == 2 and rows[0] == self.unit[1]
            self.fields[slides] = rows if planar else [_off(row, at) for row in rows]
            self.slides[slides] = self.borders[-1]

    def _on(self, border: Border, otherwise: str | None, kind: int = 0) -> list[Branch]:
        """Branches of what is on a surface, or off it by a reset; ``otherwise``, a mode that follows if none holds."""
        (low, high), (below, above), at = border.rises, border[:2], border.at

        def branch(mode: str, *conditions: tuple[Affine, Test]) -> Branch:
            what = "slides along" if mode == border.slides else "crosses"
            return Branch(mode, kind or self._kind(f"{what} {border.text}"), conditions)

        found = [branch(above, (at, Test.POSITIVE)), branch(below, (scaled(at, -1), Test.POSITIVE))]
        if otherwise:
            return [*found, branch(otherwise)]
        up, down = _off(_rate(high, self.fields[above]), at), _off(_rate(low, self.fields[below]), at)
        fall, drop = scaled(high, -1), scaled(low, -1)
        found += [
            branch(above, (high, Test.LEADS), (up, Test.POSITIVE), (low, Test.NOT_NEGATIVE)),
            branch(below, (drop, Test.LEADS), (scaled(down, -1), Test.POSITIVE), (fall, Test.NOT_NEGATIVE)),
        ]
        return found + [branch(x, (low, Test.NOT_NEGATIVE), (fall, Test.NOT_NEGATIVE)) for x in [border.slides] if x]

    def _bounds(self, mode: str) -> Iterator[Guard]:
        """Guards of surfaces beside a mode; of one that slides r₁ and r₂, and surfaces that end on this one."""
        own = self.slides.get(mode)
        for k, border in enumerate(self.borders):
            if mode in border[:2]:
                side, onward = (-1, border.above) if mode == border.below else (1, border.below)
                branches = self._on(border, onward if border.crosses else None)
                yield self._guard(f"surface {k}", border.at, side, self._transition(f"{k} {mode}", branches))
        if own is None:
            return
        for k, onward in enumerate(own[:2]):
            if linear(own.rises[k]):
                branches = [Branch(onward, self._kind(f"leaves {own.text}"))]
                name = self._transition(f"{mode} to {onward}", branches)
                yield self._guard(name, own.rises[k], 1 - 2 * k, name)
        for border, k in product(self.borders, (0, 1)):
            if border is not own and border[k] in own[:2] and linear(row := _off(border.at, own.at)):
                name = self._transition(f"{mode} at {border.text} of {border[k]}", [])  # what follows is not known
                yield self._guard(name, row, 2 * k - 1, name)

    # Events

    def _kind(self, name: str) -> int:
        return self.kinds.setdefault(name, FIRST_MODEL_KIND + len(self.kinds))

    def _guard(self, name: str, row: Affine, side: int, transition: str) -> Guard:
        self.surfaces.setdefault(name, Surface(row, place_of_largest([abs(float(x)) for x in row[:-1]])))
        return Guard(name, side, transition)

    def _transition(self, name: str, branches: Sequence[Branch], reset: Any = None) -> str:
        self.transitions.setdefault(name, Transition(tuple(branches), reset))
        return name

    def _checked(self, row: Affine, about: str, text: str) -> Affine:
        if not linear(row):
            raise InputError(f"{about} = {text!r} does not depend on the state there, so it cannot be an event.")
        return row

    def _guards(self, mode: str) -> Iterator[Guard]:
        """Guards of a mode: clocks, events, surfaces; an event that holds beside a surface does so along it."""
        slides = self.slides.get(mode)
        sides = {*slides[:2]} if slides else {mode}
        own = [(k, x) for k, x in enumerate(self.events) if mode in x.mode or sides <= {*x.mode}]
        at_clock, taken = {event.at_clock: k for k, event in own}, dict[Any, int]()
        for name, period in self.times.items():
            row = (*scaled(self.unit[self.names.index(name)], -1)[:-1], period)
            yield self._guard(f"clock {name}", row, 1, self._happens(mode, at_clock.get(name), None, name))
        for k, event in own:
            about = f"events[{k}].when"
            key: Any = event.at_clock
            if event.when is not None:
                row = self.reader.comparison(event.when, about)
                row = self._checked(_off(row, slides.at) if slides else row, about, event.when)
                key = _key(row)
                yield self._guard(f"event {k} {mode}", scaled(row, -1), 1, self._happens(mode, k, row))
            if taken.setdefault(key, k) != k:
                raise InputError(f"events[{taken[key]}] and events[{k}] happen at once in {mode}; make them one.")
        yield from self._bounds(mode)

    def _reset(self, given: Mapping[str, Any], about: str, clock: str = "") -> tuple[Affine, ...] | None:
        """Return the rows of a reset; ``clock``: one that returns to zero, which may set the forcing to its begin."""
        rows = self.unit[:-1]
        for name, text in given.items():
            rows[self.names.index(name)] = self.reader.affine(text, f"{about}.{name}")
        nothing = scaled(self.unit[-1], 0)
        if clock:
            rows[self.names.index(clock)] = nothing
        if clock == self.master:
            rows[self.own : self.own + 2 * len(self.rates)] = [self.unit[-1], nothing] * len(self.rates)
        return tuple(rows) if given or clock else None

    def _happens(self, mode: str, k: int | None, row: Affine | None, clock: str = "") -> str:
        """Transition of an event in a mode, as a condition comes true or as a clock returns, at which none may be."""
        event = Event([mode]) if k is None else self.events[k]
        to, reset = event.to, self._reset(event.reset, f"events[{k}].reset", clock)
        if row and to in (None, mode):
            left = _off(_rate(row, (*reset, self.unit[-1])), row) if reset else self.unit[-1]
            if not linear(left) and left[-1] > 0:
                what = "happens again where it leads" if reset else "changes nothing: give a reset, or a mode to enter"
                raise InputError(f"events[{k}] of mode {mode}, {event.when!r}, {what}.")
        returns = FORCING if clock == FORCING else f"{clock} returns" + (f" to {to}" if to else "")
        kind = self._kind(returns if clock else str(event.when))
        stays = k is not None and not to and mode in self.slides
        branches = self._on(self.slides[mode], None, kind) if stays else [*self._into(to or mode, kind)]
        return self._transition(f"{clock or k} in {mode}", branches, reset)

    def _into(self, mode: str, kind: int, known: Any = (), before: tuple[str, ...] = ()) -> Iterator[Branch]:
        """Branches into a mode, or on from it where an event that resets nothing, or a surface, is past already."""
        for row, onward in self._outlets(mode):
            if onward not in (mode, *before):
                yield from self._into(onward, kind, (*known, (row, Test.POSITIVE)), (*before, mode))
        yield Branch(mode, kind, known)

    def _outlets(self, mode: str) -> Iterator[tuple[Affine, str]]:
        """Affine functions that are positive where a mode is left at once, with the mode that follows."""
        for k, event in enumerate(self.events):
            if mode in event.mode and event.when and event.to and not event.reset:
                yield self.reader.comparison(event.when, f"events[{k}].when"), event.to
        for border in self.borders:
            if mode in border[:2]:
                yield (border.at, border.above) if mode == border.below else (scaled(border.at, -1), border.below)

    # All together

    def _assemble(self) -> None:
        flows = self._flows()
        planar = isinstance(next(iter(flows.values())), PlanarMode)
        self._transition("entry", [*self._into(next(iter(self.fields)), FIRST_MODEL_KIND)])
        guards = {name: tuple(self._guards(name)) for name in self.fields}
        if max(len(self.kinds), len(self.fields)) > _MOST:
            raise InputError(f"the system has more than {_MOST} modes or kinds of events.")
        flows = {name: self._settling(flow, guards[name], self.slides.get(name)) for name, flow in flows.items()}
        modes = {name: Mode(k, flows[name], guards[name], self.beyond.get(name)) for name, k in self.modes.items()}
        scales = [float(x) for flow in flows.values() for x in flow.time_scales if 0 < x < math.inf]
        shortest = min([*scales, *map(float, (*self.times.values(), *(1 / x for x in self.rates)))], default=1.0)
        self.brief = _SHORT[1] * shortest
        self.automaton = assemble(
            self.names, self.surfaces, modes, self.transitions, {}, _SHORT[not planar] * shortest,
            events={kind: name for name, kind in self.kinds.items()},
            marks={
                "held": frozenset(self.modes[name] for name in self.slides),
                "passage": frozenset(kind for name, kind in self.kinds.items() if name == FORCING),
            },
        )  # fmt: skip

    def _flows(self) -> dict[str, Any]:
        """Return the flow of each mode: one oscillator, a modal form, or where one has none a series for all."""
        if self.n == 2 and all(rows[0] == self.unit[1] and rows[1][0] <= 0 for rows in self.fields.values()):
            signed = {name: (-x, -y, z) for name, (_, (x, y, z)) in self.fields.items()}
            return {name: PlanarMode.of(1, y, x, z) for name, (x, y, z) in signed.items()}
        try:
            return {name: linear_mode(rows, [1.0] * self.n, None, "it") for name, rows in self.fields.items()}
        except (EngineError, ArithmeticError):
            return {name: still_mode(rows) for name, rows in self.fields.items()}

    def _settling(self, flow: Any, guards: Sequence[Guard], slides: Border | None) -> Any:
        """Return a mode in series with the region around its equilibrium that no motion leaves, if it has one."""
        if not isinstance(flow, TaylorMode) or self.times:
            return flow
        field = flow.field.copy()
        if slides:  # σ is zero and stays so: where it fell by itself, the motion would be the same
            row = np.array([*map(float, slides.at)])
            k = int(np.argmax(np.abs(row[:-1])))
            field[k] -= np.abs(field).max() * row / row[k]
        if not abs(np.linalg.det(field[:, :-1])) > 0:
            return flow
        law = np.zeros((1, PIECE))  # that never ends, and of nothing
        law[0, [FROM, TO, EXPONENT]] = -math.inf, math.inf, 1.0
        inward = [one.sign * np.array([*map(float, self.surfaces[one.surface].row)]) for one in guards]
        place = np.linalg.solve(field[:, :-1], -field[:, -1])
        still = replace(flow, field=field, speed=np.eye(self.n + 1)[-1], pieces=law)
        return replace(flow, settled=settled_region(still, inward, place))


def _common(periods: Sequence[arb]) -> arb | None:
    """Return the period of which all others are a whole part, None if none is."""
    longest = max(periods, key=float, default=arb(0))
    return longest if longest and all((longest / x).unique_fmpz() is not None for x in periods) else None


def _rate(row: Affine, field: Sequence[Affine]) -> Affine:
    """Return the rate of an affine function along a field, or of a field of constants what it is after a reset."""
    return reduce(plus, (scaled(own, x) for x, own in zip(row, field, strict=False)))


def _off(row: Affine, surface: Affine) -> Affine:
    """Return an affine function as it is on a surface, without the coordinate that counts there most."""
    k = max(linear(surface), key=lambda i: (abs(float(surface[i])), -i))
    return tuple(0 if i == k else x for i, x in enumerate(plus(row, scaled(surface, -row[k] / surface[k]))))


def _key(row: Affine) -> tuple[float, ...]:
    """Return what affine functions with one zero set, and one sign, have in common."""
    size = max(abs(float(row[i])) for i in linear(row))
    return tuple(float(f"{float(x) / size:.12e}") + 0.0 for x in row)
