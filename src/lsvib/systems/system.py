"""A system of your own, linear between events, as a value that answers by its methods."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Self

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib import variables as cf
from lsvib.errors import DivergenceError, InputError
from lsvib.numbers import Progress, names_and_values, shown
from lsvib.systems.assembly import FORCING, Event, made
from lsvib.systems.continuation import CycleBranch, follow_cycle, span_of
from lsvib.systems.cycles import Cycle
from lsvib.systems.ends import End, end_of, ends_of, motion, of_system, start_of, states_of, variables_of
from lsvib.systems.expressions import LARGEST, check_name, parameters
from lsvib.systems.grid import MOST_CELLS, Axis, Grid

KEYS = ("states", "parameters", "harmonics", "clocks", "modes", "events", "surfaces")
_MOST = 1_000_000  # samples, or starts
_WORK = 100_000  # events of a motion of a map
MADE_BY = {
    "source": "lsvib, exact event-driven motions and their return map",
    "references": "docs/systems.md of lsvib",
    "keywords": "piecewise-linear systems, nonsmooth dynamics, periodic motions",
}

State = Mapping[str, float] | None


@dataclass(eq=False, repr=False)
class System:
    """A system that is linear between events: x′ = A x + b in each mode; immutable and checked.

    * ``states``: their names; ``parameters``: numbers, or expressions of other parameters. ``"0.8"`` is the decimal
      0.8, ``0.8`` the double nearest to it.
    * ``modes``: by name, the derivative of each state, affine in states, harmonics and clocks, or ``matrix`` (n, n) and
      ``vector`` (n).
    * ``harmonics``: the rate ω [rad/s] of c = cos ω t and s = sin ω t, under the key ``"c, s"``; ``clocks``: by name,
      the period [s] after which a time returns to zero.
    * ``events``: mappings with ``mode`` (one or several); ``when``, an inequality that comes true, or ``at_clock``, the
      clock that returns to zero; ``reset``, new values of states; ``to``, the mode entered; ``beyond``, the mode after
      infinitely many events in finite time.
    * ``surfaces``: mappings with ``between``, two modes, and ``at``, negative in the first and positive in the second.
      A mode that slides along a surface is named after both, as in ``"slower|faster"``.

    Motions start in a ``mode`` with a ``state`` by name; omitted states and clocks are zero, and harmonics at phase 0.
    Raises ``InputError``; methods also ``EngineError`` where the system does not determine what follows. See also
    docs/systems.md, from a paper to a system; :meth:`lsvib.Drive.system`. The methods' examples use ``impact``:

    >>> from lsvib.systems import System
    >>> impact = System(
    ...     states=["x", "v"], parameters={"r": "0.8"}, harmonics={"c, s": "1"},
    ...     modes={"fly": {"x": "v", "v": "-x - 0.1*v + c"}},
    ...     events=[{"mode": "fly", "when": "x > 1", "reset": {"v": "-r*v"}}],
    ... )
    >>> impact.simulate("fly", {"x": 0.1}, 20.0).sizes["event"], impact.steady_state("fly").label.name
    (6, 'CYCLE')
    """

    states: Sequence[str]
    modes: Mapping[str, Mapping[str, Any]]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    harmonics: Mapping[str, Any] = field(default_factory=dict)
    clocks: Mapping[str, Any] = field(default_factory=dict)
    events: Sequence[Mapping[str, Any]] = ()
    surfaces: Sequence[Mapping[str, Any]] = ()

    def __post_init__(self) -> None:
        self.states = _listed("states", self.states)
        for key in ("parameters", "harmonics", "clocks"):
            setattr(self, key, {name: _value(x) for name, x in names_and_values(key, getattr(self, key)).items()})
        self.harmonics = {_pair(key): x for key, x in self.harmonics.items()}
        self._check_names()
        if not self.states or not self.modes:
            raise InputError("a system needs one state and one mode at least.")
        self.modes = {name: self._mode(name, own) for name, own in names_and_values("modes", self.modes).items()}
        self.events = [self._event(f"events[{k}]", own) for k, own in enumerate(_listed("events", self.events))]
        self.surfaces = [self._surface(f"surfaces[{k}]", x) for k, x in enumerate(_listed("surfaces", self.surfaces))]
        vars(self)["_text"] = f"System({', '.join(f'{key}={value!r}' for key, value in self.keys().items())})"
        made(self)

    @classmethod
    def of(cls, values: Mapping[str, Any], /) -> Self:
        """Make a system from its :meth:`keys`, such as the content of a YAML file; raises ``InputError``."""
        return cls(**_known("system", values, KEYS, ("states", "modes")))

    def keys(self) -> dict[str, Any]:
        """Return the keys of the system, without empty ones.

        >>> System.of(impact.keys()) == impact
        True
        """
        return {key: deepcopy(value) for key in KEYS if (value := getattr(self, key))}

    def replace(self, /, **changes: Any) -> Self:
        """Return a copy with other values of some parameters, or whole keys such as ``events``; raises ``InputError``.

        >>> impact.replace(r=0.5).parameters
        {'r': 0.5}
        """
        keys = self.keys()
        for name, value in changes.items():
            if name not in KEYS:
                self._check_parameter(name)
            (keys["parameters"] if name in self.parameters else keys)[name] = value
        return type(self)(**keys)

    def __setattr__(self, name: str, value: Any) -> None:
        if "_text" in vars(self):
            raise InputError(f"a system cannot be changed; system.replace({name}=...) makes another one.")
        super().__setattr__(name, value)

    def __eq__(self, other: object) -> bool:
        return repr(self) == repr(other) if isinstance(other, System) else NotImplemented

    def __hash__(self) -> int:
        return hash(repr(self))

    def __repr__(self) -> str:
        return str(vars(self)["_text"])

    def simulate(self, mode: str, state: State, duration: float, *, samples: int = 1001) -> xr.Dataset:
        """Return the exact motion from a start, with its events: e^{At} in each mode, and roots of the conditions.

        Arguments: ``duration`` [s]; the number of ``samples``, equidistant in time, both ends included. Returns a
        dataset with the states and the mode over ``time`` [s], and over ``event`` the time and kind of each event, the
        mode that it enters and the states before and after it. Raises ``InputError``, and ``EngineError`` where the
        motion is not determined or grows without bound.

        >>> impact.simulate("fly", {"x": 0.1}, 20.0).event_time.values.round(3).tolist()
        [6.283, 6.6, 12.306, 12.566, 18.85, 19.04]
        """
        own, end = made(self), numbers.start("duration", duration)
        if end < 0:
            raise InputError(f"duration = {end:g} is negative.")
        times = np.linspace(0.0, end, numbers.whole_between("samples", samples, 2, _MOST))
        found = motion(own, *start_of(self, mode, state), end)
        states, modes = found.at(times)
        if not (np.abs(states) < numbers.LARGEST_START).all():
            raise DivergenceError("the motion grows without bound; shorten the duration.")
        kinds = ["touches", "accumulates", *own.automaton.events.values()]
        data: cf.Variables = {
            "mode": cf.flagged("time", modes, "mode of motion", [*own.modes]),
            "event_time": cf.variable("event", found.time, "s", "time of the event"),
            "event_kind": cf.flagged("event", found.kind, "kind of the event", kinds),
            "event_mode": cf.flagged("event", found.mode, "mode of motion after the event", [*own.modes]),
        }
        for when, rows in (("before", found.before), ("after", found.after)):
            data |= states_of(own, "event", rows, f"event_{{}}_{when}", f" {when} the event")
        axes = {
            "time": cf.variable("time", times, "s", "time", "$t$"),
            "event": cf.variable("event", np.arange(found.time.size), "1", "index of the event"),
        }
        about = {"title": "Motion of a system", "initial_state": _start(mode, state)}
        return self._dataset(states_of(own, "time", states), data, axes, about)

    def steady_state(self, mode: str, state: State = None) -> End:
        """Return what the motion from a start ends on, decided by its Poincaré map.

        Returns an :class:`lsvib.systems.End` with ``label``, ``period`` [s], ``multipliers`` [1] and one period as
        ``orbit``; one that is unresolved says why. Raises ``InputError``, ``EngineError``.

        >>> end = impact.steady_state("fly", {"x": 0.1})
        >>> f"{end.label}, {end.period:.6f} s, {abs(end.multipliers[0]):.6f}"
        'cycle, 6.283185 s, 0.584322'
        """
        return end_of(self, mode, state)

    def cycles(
        self,
        starts: Iterable[tuple[str, State]] = (),
        *,
        box: Mapping[str, tuple[float, float]] | None = None,
        count: int = 100,
        seed: int = 0,
    ) -> list[End]:
        """Return what motions from many starts end on, each end once, cycles first; repelling cycles are not found.

        Arguments: ``starts``, pairs of mode and state; ``box``, the least and largest value of some states, between
        which ``count`` more are drawn in all modes, by a generator with this ``seed``. Returns the ends, each with
        its number of ``starts``; an end that few starts reach may be missed. Raises ``InputError``, ``EngineError``.

        >>> [(end.label.value, end.turns, end.starts) for end in impact.cycles(box={"x": (-1, 1)}, count=20)]
        [('cycle', 1, 20)]
        """
        chance = np.random.default_rng(numbers.whole_between("seed", seed, 0, 2**63))
        try:
            spans = [(name, low, high) for name, (low, high) in names_and_values("box", box).items()]
            given = [(mode, state) for mode, state in starts]
        except (TypeError, ValueError):
            raise InputError(
                f"starts = {shown(starts)} are not pairs of mode and state, or box = {shown(box)} has no pairs of "
                "numbers."
            ) from None
        axes = [Axis(*span, 1) for span in spans]
        for _ in range(numbers.whole_between("count", count, 1, _MOST) if axes else 0):
            mode = str(chance.choice([*self.modes]))
            given.append((mode, {axis.coordinate: chance.uniform(axis.start, axis.stop) for axis in axes}))
        if not given:
            raise InputError("give starts, as [(mode, state), ...], or a box to draw them from, as {'x': (-1, 1)}.")
        found, places = ends_of(self, given)
        ends = [replace(end, starts=places.count(k)) for k, end in enumerate(found)]
        return sorted(ends, key=lambda end: (end.cycle is None, end.label, end.period))

    def follow(
        self,
        cycle: End | Cycle,
        parameter: str,
        span: tuple[float, float],
        *,
        points: int = 1000,
        progress: Progress | None = None,
    ) -> CycleBranch:
        """Follow a cycle over a parameter, both ways, by pseudo-arclength continuation, whether it attracts or not.

        Arguments: ``cycle``, an :class:`lsvib.systems.End`, or that of a point of a branch; ``span``, the smallest and
        largest value of the parameter, which enclose the system's own; at most so many ``points`` each way;
        ``progress``, called with the numbers of points done and of all. Returns the branch with its ``points`` and
        ``changes``, each with a ``name`` (docs/systems.md). Raises ``InputError``.

        >>> last = impact.follow(impact.steady_state("fly"), "r", (0.75, 0.85)).points[-1]
        >>> impact.replace(r=last.value).follow(last.cycle, "r", (0.85, 0.9)).points[-1].value  # or another one
        0.9
        """
        own, one = made(self), cycle.cycle if isinstance(cycle, End) else cycle
        if not isinstance(one, Cycle):
            raise InputError("follow takes one cycle, such as system.cycles(...)[0] or branch.points[0].cycle.")
        mine, other = own.automaton, one.orbit.automaton
        pairs = (mine.flow.field, other.flow.field), (mine.tables.surfaces, other.tables.surfaces)
        if not all(np.array_equal(*pair) for pair in pairs):
            raise InputError("the cycle belongs to another system, that of a point to replace(parameter=its value).")
        self._check_parameter(parameter)
        here = float(parameters(self.parameters)[parameter])
        ends, most = span_of("system", parameter, here, span, points)
        branch = follow_cycle(
            one, lambda value: made(self.replace(**{parameter: value})).automaton, parameter, here, ends, most, progress
        )
        found = tuple(replace(x, cycle=of_system(own, x.cycle)) for x in branch.points)
        return replace(branch, points=found, system=json.dumps(self.keys()))

    def sweep(
        self,
        mode: str | None = None,
        state: State = None,
        /,
        *,
        progress: Progress | None = None,
        **over: Sequence[float] | np.ndarray,
    ) -> xr.Dataset:
        """Return what the motion from a start ends on over some parameters; over two, this is a chart.

        Arguments: ``over``, a list of values of each parameter, by name; all combinations are taken. The motion starts
        in the first mode unless another is named; ``progress`` is called with the numbers of motions done and of all.
        Returns a dataset over the parameters with the label, the period [s], also as a multiple of that of the forcing,
        the largest multiplier [1], the extremes of each state and how often each event occurs in a period. Raises
        ``InputError``, ``EngineError``.

        >>> impact.sweep(r=[0.5, 0.8]).multiplier.values.round(6).tolist()
        [0.365201, 0.584322]
        """
        axes, begin = numbers.axes(over, self._check_parameter), mode or next(iter(self.modes))
        dims, shape, ends = (*axes,), tuple(map(len, axes.values())), list[End]()
        for values in product(*axes.values()):
            ends.append(end_of(self.replace(**dict(zip(axes, values, strict=True))), begin, state))
            if progress is not None:
                progress(len(ends), math.prod(shape))
        where = "on the attractor"
        extremes = np.array([[end.extremes(k) for k in range(len(self.states))] for end in ends])
        own = {
            f"{word}_{name}": (extremes[:, k, i], "1", f"{word} value of state {name} {where}")
            for i, word in enumerate(("least", "largest"))
            for k, name in enumerate(self.states)
        }
        events = [end.cycle.itinerary if end.cycle else () for end in ends]
        counts = [Counter(kind for kind, _ in one if kind != FORCING) for one in events]
        kinds = [*dict.fromkeys(kind for count in counts for kind in count)]
        often = np.reshape([count[kind] for count in counts for kind in kinds], (*shape, len(kinds)))
        what = [f"period_{end.turns}" if end.turns else str(end.label) for end in ends]
        words = sorted({*what})
        found = variables_of(dims, ends, shape) | {
            "behaviour": cf.flagged(dims, np.reshape([*map(words.index, what)], shape), f"kind, {where}", words),
            "events": cf.variable((*dims, "kind"), often, "1", "how often an event happens in a period"),
        }
        coordinates = {name: cf.variable(name, np.array(x), "1", f"parameter {name}") for name, x in axes.items()}
        coordinates["kind"] = cf.named_index("kind", "kind of the event", kinds)
        about = {"title": f"Attractors of a system over {', '.join(axes)}", "initial_state": _start(begin, state)}
        return self._dataset(cf.columns(dims, own, shape), found, coordinates, about)

    def map(self, grid: Mapping[str, Any], mode: str | None = None, *, progress: Progress | None = None) -> xr.Dataset:
        """Return what motions from the cells of a grid end on: basins of attraction.

        Arguments: ``grid``, two states, each (start, stop, count), and values of others; ``mode``, by default the first
        one; ``progress``, called with the numbers of rows done and of all. Returns a dataset with the number of the end
        of each cell over both states, ``behaviour``, and over ``end`` its label, period [s], largest multiplier [1],
        state and ``fraction`` of the cells. Raises ``InputError``, ``EngineError``.

        >>> found = impact.map({"x": (-1, 1, 4), "v": (-1, 1, 3)})
        >>> found.behaviour.shape, found.fraction.values.tolist()
        ((3, 4), [1.0])
        """
        own, cells, begin = made(self), Grid.of(grid, [*self.states]), mode or next(iter(self.modes))
        rows, columns = cells.y.centres().tolist(), cells.x.centres().tolist()
        if len(rows) * len(columns) > MOST_CELLS:
            raise InputError(f"grid has {len(rows) * len(columns)} cells; the allowed range is up to {MOST_CELLS}.")

        def starts() -> Iterator[tuple[str, State]]:
            for i, y in enumerate(rows):
                yield from ((begin, {**cells.fixed, cells.x.coordinate: x, cells.y.coordinate: y}) for x in columns)
                if progress is not None:
                    progress(i + 1, len(rows))

        found, places = ends_of(self, starts(), _WORK)
        number, words = np.reshape(places, (len(rows), len(columns))), [f"{x.label}_{k}" for k, x in enumerate(found)]
        share, last = np.bincount(number.ravel()) / number.size, np.array([[*end.state.values()] for end in found])
        dims, axes = (cells.y.coordinate, cells.x.coordinate), cf.Variables()
        data = variables_of("end", found) | {
            "behaviour": cf.flagged(dims, number, "index of the attractor of the motion", words),
            "fraction": cf.variable("end", share, "1", "fraction of the cells"),
        }
        data |= states_of(own, "end", last, "end_{}", " of the equilibrium, or of the cycle where its period begins")
        for name, one in zip(dims, (cells.y, cells.x), strict=True):
            axes[name] = cf.variable(name, one.centres(), "1", f"state {name}", cell_width=one.width)
        axes["end"] = cf.variable("end", np.arange(len(found)), "1", "index of the attractor")
        about = {"title": "Attractors of a system from a grid of starts", "mode": begin}
        return self._dataset({}, data, axes, about)

    def _dataset(self, own: cf.Variables, found: cf.Variables, axes: cf.Variables, about: dict[str, str]) -> xr.Dataset:
        """Return a dataset that says of which system it is; of ``own`` and ``axes`` names are those of the system."""
        names = [*own, *found, *axes]
        if twice := [name for name in names if names.count(name) > 1]:
            raise InputError(f"{twice[0]} is reserved in this result; choose another name.")
        return cf.answer(own | found, axes, {**MADE_BY, "system": json.dumps(self.keys()), **about})

    def _check_parameter(self, name: Any) -> None:
        if name not in [*self.parameters]:
            known = ", ".join(self.parameters) or "none"
            raise InputError(f"{shown(name)} is not a parameter of the system; its parameters are {known}.")

    def _check_names(self) -> None:
        seen: dict[str, str] = {}
        pairs = [name for pair in self.harmonics for name in pair.split(", ")]
        for what, names in zip(KEYS, (self.states, self.parameters, pairs, self.clocks), strict=False):
            for name in names:
                if check_name(name) in seen:
                    raise InputError(f"{name} is used twice, in {seen[name]} and in {what}; choose different names.")
                seen[name] = what

    def _mode(self, mode: str, given: Any) -> dict[str, Any]:
        about, names = f"modes.{mode}", [*self.states]
        if not mode.strip() or "|" in mode:
            raise InputError(f"{shown(mode)} cannot be the name of a mode; | joins the names of sliding modes.")
        if not (isinstance(given, Mapping) and "matrix" in given):
            own = _known(about, given, names, names)
            return {name: _value(own[name]) for name in names}
        own, n = _known(about, given, ("matrix", "vector")), len(names)
        matrix, vector = (np.array(x, dtype=object) for x in (own["matrix"], own.get("vector", [0] * n)))
        if matrix.shape != (n, n) or vector.shape != (n,):
            raise InputError(f"{about} needs a matrix of {n} by {n} numbers and a vector of {n}, one a state.")
        return {"matrix": [[*map(_value, row)] for row in matrix.tolist()], "vector": [*map(_value, vector.tolist())]}

    def _event(self, about: str, given: Any) -> dict[str, Any]:
        own = _known(about, given, Event._fields, ("mode",))
        own["mode"] = [own["mode"]] if isinstance(own["mode"], str) else _listed(f"{about}.mode", own["mode"]) or [None]
        if ("when" in own) == ("at_clock" in own):
            raise InputError(f"{about} needs either when, such as x > 1, or at_clock, the name of a clock.")
        if own.get("at_clock") not in [None, *self.clocks]:
            known = ", ".join(self.clocks) or "none"
            raise InputError(f"{about}.at_clock = {own['at_clock']} is not a clock; clocks are {known}.")
        reset = _known(f"{about}.reset", own.get("reset"), (*self.states, *self.clocks))
        own["reset"] = {name: _value(x) for name, x in reset.items()}
        return {key: x for key, x in own.items() if x}

    def _surface(self, about: str, given: Any) -> dict[str, Any]:
        own = _known(about, given, ("between", "at"), ("between", "at"))
        between = own["between"] = _listed(f"{about}.between", own["between"])
        unknown = [name for name in between if name not in [*self.modes]]
        if unknown or len(between) != 2 or between[0] == between[1]:
            raise InputError(f"{about}.between has {shown(unknown or between)}, not two of {', '.join(self.modes)}.")
        return own


def _start(mode: str, state: State) -> str:
    return json.dumps({"mode": mode, "state": names_and_values("start", state)})


def _listed(about: str, given: Any) -> list[Any]:
    if isinstance(given, (str, Mapping)) or not isinstance(given, Iterable):
        raise InputError(f"{about} = {shown(given)} is not a list.")
    return [*given]


def _known(about: str, given: Any, allowed: Iterable[str], needed: Iterable[str] = ()) -> dict[str, Any]:
    """Return names and values, all of which are allowed, and none of those that are needed missing."""
    own = names_and_values(about, given)
    if wrong := [key for key in own if key not in allowed]:
        raise InputError(f"{wrong[0]} is not a known key of {about}; the known keys are {', '.join(allowed)}.")
    if missing := [key for key in needed if key not in own]:
        raise InputError(f"{about} needs {missing[0]}.")
    return own


def _value(given: Any) -> Any:
    """Return a number or an expression as a plain value; 24 and 24.0 are one, and so are 0.0 and -0.0."""
    if isinstance(given, str):
        return given
    given = given.item() if isinstance(given, np.number) else given
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not abs(given) < LARGEST:
        raise InputError(f"{shown(given)} is neither an expression nor a number below {LARGEST:g}.")
    return float(given) + 0.0


def _pair(key: str) -> str:
    if key.count(",") != 1:
        raise InputError(f"harmonics has {shown(key)}, which is not two names, such as 'c, s'.")
    return ", ".join(name.strip() for name in key.split(","))
