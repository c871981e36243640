"""What systems of one's own answer, as CF datasets, as JSON and in words."""

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib import variables as cf
from lsvib.errors import DivergenceError, InputError
from lsvib.numbers import names_and_values, shown
from lsvib.systems.assembly import FORCING, Made, made
from lsvib.systems.continuation import CycleBranch, follow_cycle, span_of
from lsvib.systems.cycles import Cycle
from lsvib.systems.ends import End, Known, Label, end_from, end_of, motion, same_end, start_of
from lsvib.systems.expressions import parameters
from lsvib.systems.grid import MOST_CELLS, Axis, Grid
from lsvib.systems.interval_mapper import IntervalMapper
from lsvib.systems.mapper import Starts
from lsvib.systems.system import System

_MOST = 1_000_000  # samples, or starts
_MADE = {
    "source": "lsvib, exact event-driven motions and their return map",
    "references": "docs/systems.md of lsvib",
    "keywords": "piecewise-linear systems, nonsmooth dynamics, periodic motions",
}
_WORK = 100_000  # events of a motion of a map


def _answer(
    system: System, title: str, own: cf.Variables, found: cf.Variables, axes: cf.Variables, **about: Any
) -> xr.Dataset:
    """Return a dataset that says of which system it is; of ``own`` and ``axes`` names are those of the system."""
    names = [*own, *found, *axes]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"{twice[0]} has a meaning of its own in this answer; give what is called so another name.")
    return cf.answer(own | found, axes, {"title": title, **_MADE, "system": json.dumps(system.keys()), **about})


def _words(names: Iterable[str]) -> list[str]:
    """Return names of modes and events as words of flags, which have no blanks."""
    return ["_".join(name.split()) for name in names]


def _states(own: Made, dims: cf.Dims, values: np.ndarray, name: str = "{}", when: str = "") -> cf.Variables:
    """Return states (k, n) as variables, without the forcing's clock."""
    states = [(k, x) for k, x in enumerate(own.automaton.states) if x.isidentifier()]
    return {name.format(x): cf.variable(dims, values[..., k], "1", f"state {x}{when}") for k, x in states}


def simulation(system: System, mode: str, state: Any, duration: Any, samples: Any) -> xr.Dataset:
    """Return the motion of a system as its method ``simulate`` does."""
    own, end = made(system), numbers.start("duration", duration)
    if end < 0:
        raise InputError(f"duration = {end:g} is negative.")
    times = np.linspace(0.0, end, numbers.whole_between("samples", samples, 2, _MOST))
    found = motion(own, *start_of(system, mode, state), end)
    (states, modes), words = found.at(times), _words(own.modes)
    if not (np.abs(states) < numbers.LARGEST_START).all():
        raise DivergenceError("the motion grows without bound; shorten the duration.")
    kinds = ["touches", "accumulates", *_words(own.automaton.events.values())]
    data: cf.Variables = {
        "mode": cf.flagged("time", modes, "mode of motion", words),
        "event_time": cf.variable("event", found.time, "s", "time of the event"),
        "event_kind": cf.flagged("event", found.kind, "kind of the event", kinds),
        "event_mode": cf.flagged("event", found.mode, "mode of motion after the event", words),
    }
    for when, rows in (("before", found.before), ("after", found.after)):
        data |= _states(own, "event", rows, f"event_{{}}_{when}", f" {when} the event")
    axes = {
        "time": cf.variable("time", times, "s", "time", "$t$"),
        "event": cf.variable("event", np.arange(found.time.size), "1", "index of the event"),
    }
    start = json.dumps({"mode": mode, "state": names_and_values("start", state)})
    return _answer(system, "Motion of a system", _states(own, "time", states), data, axes, initial_state=start)


@dataclass(frozen=True)
class Ends:
    """What motions of a system end on, each once, cycles first; how many ``starts`` end so; what was ``searched``."""

    system: System
    ends: tuple[End, ...]
    starts: tuple[int, ...]
    searched: str

    @property
    def cycles(self) -> tuple[End, ...]:
        """The cycles."""
        return tuple(end for end in self.ends if end.cycle is not None)

    def to_json(self) -> dict[str, Any]:
        """Return them as plain numbers and names."""
        ends = [end.to_json() | {"starts": count} for end, count in zip(self.ends, self.starts, strict=True)]
        return {"ends": ends, "searched": self.searched}

    def text(self) -> Iterator[str]:
        """Say them in lines."""
        yield f"Searched: {self.searched}; there may be others."
        for end, count in zip(self.ends, self.starts, strict=True):
            yield from end.text()
            yield f"  reached from {count} start{'s' if count > 1 else ''}"


def all_ends(system: System, starts: Iterable[Any], box: Any, count: Any, seed: Any) -> Ends:
    """Return what motions of a system end on as its method ``cycles`` does."""
    chance = np.random.default_rng(numbers.whole_between("seed", seed, 0, 2**63))
    try:
        pairs = [(name, low, high) for name, (low, high) in names_and_values("box", box).items()]
        given = [(mode, state) for mode, state in starts]
    except (TypeError, ValueError):
        raise InputError(
            f"starts = {shown(starts)} are not pairs of mode and state, or box = {shown(box)} has no pairs of numbers."
        ) from None
    spans = [Axis(*pair, 1) for pair in pairs]
    more = numbers.whole_between("count", count, 1, _MOST) if spans else 0
    for _ in range(more):
        mode = str(chance.choice([*system.modes]))
        given.append((mode, {span.coordinate: chance.uniform(span.start, span.stop) for span in spans}))
    if not given:
        raise InputError("give starts, as [(mode, state), ...], or a box to draw them from, as {'x': (-1, 1)}.")
    found: list[End] = []
    numbered = [_noted(found, end_of(system, *start)) for start in given]
    order = sorted(range(len(found)), key=lambda k: (found[k].cycle is None, found[k].label, found[k].period))
    searched = f"motions from {len(given)} starts" + (f", {more} of them drawn with seed {seed}" if more else "")
    return Ends(system, tuple(found[k] for k in order), tuple(numbered.count(k) for k in order), searched)


def orbits(found: Ends) -> xr.Dataset:
    """Return a period of each cycle of a system that was found as a dataset over ``cycle`` and ``sample``."""
    states = np.array([end.cycle.orbit.at(np.linspace(0.0, end.period, 4001))[0] for end in found.cycles if end.cycle])
    own = made(found.system)
    axes = {"cycle": cf.variable("cycle", np.arange(1, len(states) + 1), "1", "number of the cycle")}
    return _answer(found.system, "Cycles of a system", _states(own, ("cycle", "sample"), states), {}, axes)


def _noted(found: list[End], end: End) -> int:
    """Return the place of an end among some, to which it is added if it is none of them."""
    for k, other in enumerate(found):
        if end is other or same_end(end, other):
            return k
    found.append(end)
    return len(found) - 1


def followed(
    system: System, cycle: Any, parameter: str, span: Any, points: Any, progress: numbers.Progress | None
) -> CycleBranch:
    """Follow a cycle of a system over a parameter as its method ``follow`` does."""
    own, one = made(system).automaton, cycle.cycle if isinstance(cycle, End) else cycle
    if not isinstance(one, Cycle):
        raise InputError("what is followed is one cycle, such as system.cycles(...).cycles[0].")
    other = one.orbit.automaton
    pairs = (own.flow.field, other.flow.field), (own.tables.surfaces, other.tables.surfaces)
    if not all(np.array_equal(*pair) for pair in pairs):
        raise InputError("the cycle belongs to another system; take one that this system ends on.")
    _known(system, parameter)
    here = float(parameters(system.parameters)[parameter])
    ends, most = span_of("system", parameter, here, span, points)

    def at(value: float) -> Made:
        return made(system.replace(**{parameter: value}))

    branch = follow_cycle(one, lambda value: at(value).automaton, parameter, here, ends, most, progress)
    free = made(system).free
    cut = [replace(x, cycle=replace(x.cycle, multipliers=x.cycle.multipliers[:free])) for x in branch.points]
    return replace(branch, points=tuple(cut))


def _known(system: System, name: Any) -> None:
    if name not in [*system.parameters]:
        known = ", ".join(system.parameters) or "none"
        raise InputError(f"{shown(name)} is no parameter of the system; its parameters are {known}.")


def branch_dataset(branch: CycleBranch) -> xr.Dataset:
    """Return a branch of cycles as a dataset along ``point``; its changes are an attribute."""
    values = np.array([point.value for point in branch.points])
    data = {branch.parameter: cf.variable("point", values, "1", f"parameter {branch.parameter}")}
    about = {"title": f"A cycle of a system over {branch.parameter}", **_MADE}
    changes = json.dumps(branch_json(branch)["changes"])
    return cf.answer(data | branch_variables(branch, "1"), {}, {**about, "changes": changes})


def branch_variables(branch: CycleBranch, unit: str) -> cf.Variables:
    """Return what is known of the cycles of a branch along ``point``; ``unit`` of the first state."""
    cycles = [point.cycle for point in branch.points]
    multipliers = np.array([cycle.multipliers for cycle in cycles]).reshape(len(cycles), -1)
    columns = {
        "along": ([point.along for point in branch.points], "1", "length of the branch from its start"),
        "period": ([cycle.period for cycle in cycles], "s", "period of the cycle", "$T$"),
        "amplitude": ([cycle.amplitude for cycle in cycles], unit, "amplitude, half its peak-to-peak"),
        "multiplier_error": ([cycle.multiplier_error for cycle in cycles], "1", "bound of the multipliers' errors"),
        "period_residual": ([cycle.residual for cycle in cycles], "1", "change of the state over a period"),
    }
    data = cf.columns("point", columns)
    data["attracting"] = cf.yes_no("point", [cycle.attracting for cycle in cycles], "whether the cycle attracts")
    for part, word in (("real", "real"), ("imag", "imaginary")):
        dims, about = ("point", "multiplier_number"), f"{word} part of the Floquet multipliers"
        data[f"multiplier_{word}_part"] = cf.variable(dims, getattr(multipliers, part), "1", about)
    return data


def branch_json(branch: CycleBranch) -> dict[str, Any]:
    """Return a branch as plain numbers and names."""
    names = ("attracting", "period", "amplitude", "residual")
    points = [
        {"value": x.value, "multipliers": x.cycle.to_json_multipliers(), **{n: getattr(x.cycle, n) for n in names}}
        for x in branch.points
    ]
    changes = [asdict(x) for x in branch.changes]
    return {"parameter": branch.parameter, "points": points, "changes": changes}


def branch_text(branch: CycleBranch) -> Iterator[str]:
    """Say a branch in lines."""
    name, values = branch.parameter, [point.value for point in branch.points]
    yield f"{len(values)} cycles, {name} from {min(values):.9g} to {max(values):.9g}"
    for change in branch.changes:
        kind = f"{change.kind} ({change.name})" if change.name not in ("", change.kind) else change.kind
        yield f"{kind} at {name} = {change.value:.12g}: {change.what}"


def sweep(
    system: System, mode: str | None, state: Any, over: Mapping[str, Any], progress: numbers.Progress | None
) -> xr.Dataset:
    """Return what a system ends on over its parameters as its method ``sweep`` does."""
    axes, start = numbers.axes(over, partial(_known, system)), mode or next(iter(system.modes))
    dims, sizes = (*axes,), tuple(map(len, axes.values()))
    ends: list[End] = []
    for values in product(*axes.values()):
        ends.append(end_of(system.replace(**dict(zip(axes, values, strict=True))), start, state))
        if progress is not None:
            progress(len(ends), math.prod(sizes))
    extremes = np.array([[end.extremes(k) for k in range(len(system.states))] for end in ends])
    where = "in what the motion ends on"
    own = {
        f"{word}_{name}": (extremes[:, k, i], "1", f"{word} value of state {name} {where}")
        for i, word in enumerate(("least", "largest"))
        for k, name in enumerate(system.states)
    }
    counts = [Counter(kind for kind, _ in end.cycle.itinerary if kind != FORCING) if end.cycle else {} for end in ends]
    kinds = [*dict.fromkeys(kind for count in counts for kind in count)]
    often = np.array([count.get(kind, 0) for count in counts for kind in kinds]).reshape(*sizes, -1)
    what = [f"period_{end.turns}" if end.turns else str(end.label) for end in ends]
    words = sorted({*what})
    found = _ends(dims, ends, sizes) | {
        "behaviour": cf.flagged(dims, np.reshape([*map(words.index, what)], sizes), f"kind, {where}", words),
        "events": cf.variable((*dims, "kind"), often, "1", "how often an event happens in a period"),
    }
    coordinates = {name: cf.variable(name, np.array(x), "1", f"parameter {name}") for name, x in axes.items()}
    coordinates["kind"] = cf.named_index("kind", "kind of the event", _words(kinds))
    about = {"initial_state": json.dumps({"mode": start, "state": names_and_values("start", state)})}
    return _answer(system, f"What a system ends on over {', '.join(axes)}", cf.columns(dims, own, sizes), found,
                   coordinates, **about)  # fmt: skip


def _ends(dims: cf.Dims, ends: Sequence[End], shape: Sequence[int] = (-1,)) -> cf.Variables:
    """Return label, period and the largest multiplier of ends as variables."""
    first = [end.multipliers[0] if end.multipliers.size else math.nan for end in ends]
    leading = [abs(x) if x.imag else x.real for x in first]
    table = {
        "period": ([end.period for end in ends], "s", "period of what the motion ends on", "$T$"),
        "turns": ([end.turns for end in ends], "1", "periods of the forcing in that, or zero"),
        "multiplier": (leading, "1", "largest multiplier, or its magnitude if it is complex"),
    }
    labels = np.reshape([list(Label).index(end.label) for end in ends], shape)
    return {"label": cf.flagged(dims, labels, "what the motion ends on", list(Label))} | cf.columns(dims, table, shape)


def mapped(system: System, grid: Any, mode: str | None, progress: numbers.Progress | None) -> xr.Dataset:
    """Return what motions from a grid end on as the method ``map`` of a system does."""
    own, starts, begin = made(system), Grid.of(grid, system.states), mode or next(iter(system.modes))
    x, y = starts.x.centres(), starts.y.centres()
    if x.size * y.size > MOST_CELLS:
        raise InputError(f"grid has {x.size * y.size} cells; the allowed range is up to {MOST_CELLS}.")
    number = np.empty((y.size, x.size), dtype=np.int64)
    found: list[End] = []
    known = Known.of(own, found)

    def at(i: int, j: int) -> int:
        nonlocal known
        state = {**starts.fixed, starts.x.coordinate: float(x[j]), starts.y.coordinate: float(y[i])}
        place = _noted(found, end_from(own, *start_of(system, begin, state), _WORK, known))
        if len(found) > known.known:
            known = Known.of(own, found)
        return place

    at(0, 0)  # refuses what is no mode
    kinds = _by_intervals(system, starts, begin)
    for kind in () if kinds is None else np.unique(kinds):
        cells = np.argwhere(kinds == kind)
        some = {at(i, j) for i, j in cells[:: 1 + len(cells) // 8]}  # whether they end on one
        number[kinds == kind] = min(some)
        kinds = kinds if len(some) == 1 else None
        if kinds is None:
            break
    for i, j in np.ndindex(number.shape) if kinds is None else ():
        number[i, j] = at(i, j)
        if progress is not None and j + 1 == x.size:
            progress(i + 1, y.size)
    alike = Counter(end.label for end in found)
    words = [f"{end.label}_{k}" if alike[end.label] > 1 else str(end.label) for k, end in enumerate(found)]
    share, ends = np.bincount(number.ravel(), minlength=len(found)) / number.size, _ends("end", found)
    dims = starts.y.coordinate, starts.x.coordinate
    data: cf.Variables = {
        "label": (dims, ends["label"][1][number], ends["label"][2]),
        "behaviour": cf.flagged(dims, number, "number of the end that the motion has", words),
        "fraction": cf.variable("end", share, "1", "fraction of the cells"),
    }
    data |= {f"end_{name}": one for name, one in ends.items()}
    last = np.array([[*end.state.values()] for end in found])
    data |= _states(own, "end", last, "end_{}", " of the equilibrium, or of the cycle as its period begins")
    axes = {
        one.coordinate: cf.variable(one.coordinate, one.centres(), "1", f"state {one.coordinate}", cell_width=one.width)
        for one in (starts.y, starts.x)
    }
    axes["end"] = cf.variable("end", np.arange(len(found)), "1", "number of the end")
    return _answer(system, "What motions of a system from a grid end on", {}, data, axes, mode=begin)


def _by_intervals(system: System, grid: Grid, mode: str) -> np.ndarray | None:
    """Return what becomes of the cells of a grid by intervals of sections, if the system is an oscillator in each mode.

    That is of two states, and its events reset nothing.
    """
    own = made(system.replace(modes={mode: system.keys()["modes"].get(mode), **system.keys()["modes"]}))
    if not isinstance(own.automaton.tables.flow, np.ndarray) or own.automaton.tables.resets.size or grid.fixed:
        return None
    automaton = replace(own.automaton, marks={**own.automaton.marks, "impact": frozenset()})
    size = {one.coordinate: max(abs(one.start), abs(one.stop)) for one in (grid.x, grid.y)}
    middle = {one.coordinate: (one.start + one.stop) / 2 for one in (grid.x, grid.y)}

    def state(given: Mapping[str, float]) -> np.ndarray:
        return start_of(system, mode, given)[1]

    mapper = IntervalMapper(automaton, Starts(state, state(size), [state(size), state(middle)]))
    return mapper.cells(grid, quantities=("label",))["label"]


def summary(found: xr.Dataset, end: End) -> dict[str, Any]:
    """Summarise a motion, and what it ends on, for JSON."""
    last, modes = found.isel(time=-1), cf.flag_names(found["mode"])
    state = {name: float(last[name]) for name in json.loads(found.attrs["system"])["states"]}
    final = state | {"mode": modes[int(last["mode"])]}
    return {"final_state": final, "events": cf.counted(found.event_kind), "end": end.to_json()}
