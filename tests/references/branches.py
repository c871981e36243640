"""Random branches of cycles, and a judge of them that shares no code with what follows them.

A cycle is a state and a period after which its motion by Newton's laws (:mod:`references.series`) is back; where none
is given it is solved for on differences of such motions. Only what attracts beyond an end is asked of the package.
"""

import math
import re
from collections import Counter
from typing import NamedTuple

import numpy as np

from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import model_of, standing_state
from lsvib.dynamics.cycles import Cycle
from lsvib.errors import EngineError, InputError
from lsvib.systems.attractor import steady_state
from lsvib.systems.cycles import cycle_of
from references.drives import COLLAR, LAWS, MOTOR, OWN, POSSIBLE, drawn, power
from references.series import Series

PARTS = (), (), (), ("support",), ("nut",), ("threads",), ("support", "nut"), ("nut", "threads")
DRY = {"slide_friction": power(-0.5, 1), "bearing_friction": power(-3, -1.5)}
UNKNOWN = AssertionError, IndexError, ValueError, np.linalg.LinAlgError  # of own motions, mostly where a law jams


def random_branch(seed: int):
    """A cycle of a random drive, a parameter, and a span around its value; None if the drive has no cycle."""
    rng = np.random.default_rng([seed, 68])
    draws = POSSIBLE | {name: draw for part in PARTS[rng.integers(len(PARTS))] for name, draw in OWN[part].items()}
    draws |= (MOTOR if rng.random() < 0.25 else {}) | (COLLAR if rng.random() < 0.15 else {})
    values = drawn(rng, draws | LAWS[rng.integers(len(LAWS))] | (DRY if rng.random() < 0.3 else {}))
    if "static_friction_coefficient" in values:
        values["static_friction_coefficient"] *= values["friction_coefficient"]
    start = {"u": rng.uniform(-0.2, 0.2), "w": rng.uniform(-2, 2) * values["input_speed"]}
    try:
        drive = Drive(**values)
        states = standing_state(drive), model_of(drive).initial_state(drive, start)
        ends = (cycle_of(steady_state(drive.automaton(), state, max_events=20_000)) for state in states)
        found = [Cycle.of(drive, cycle) for cycle in ends if cycle is not None]
        if not drive.parts and rng.random() < 0.5:
            found = drive.cycles().cycles
    except (InputError, EngineError):
        return None
    cycles = [cycle for cycle in found if 0 < len(cycle.itinerary) < 40]
    names = [name for name, value in drive if isinstance(value, float) and value and name != "stribeck_exponent"]
    parameter, factors = names[rng.integers(len(names))], 10 ** (rng.uniform(0.2, 0.8, 2) * (-1, 1))
    ends = [allowed(drive, parameter, factor) for factor in factors]
    return (cycles[rng.integers(len(cycles))], parameter, tuple(sorted(ends))) if cycles else None


def allowed(drive: Drive, parameter: str, factor: float) -> float:
    """A value of a parameter by a factor away, or by its root, the root of that … so that there is such a drive."""
    for power_of in 0.5 ** np.arange(40):
        try:
            value = float(getattr(drive, parameter) * factor**power_of)
            automaton_of(drive.replace(**{parameter: value}))
        except (InputError, EngineError):
            continue
        return value
    return float(getattr(drive, parameter))


class Closed(NamedTuple):
    """A periodic motion by Newton's laws: a state amid an arc, its period, its events (kind, mode)."""

    state: np.ndarray
    period: float
    events: Counter


def happened(found) -> Counter:
    return Counter((event.kind, tuple(sorted(event.mode.items()))) for event in found)


def named(drive, events) -> Counter:
    """Events (kind, name of the mode) in the words of the reference, without passages, which are none."""
    modes = [(kind, Series(drive).mode(mode)) for kind, mode in events if kind != "passage"]
    return Counter((kind, tuple(sorted(mode.items()))) for kind, mode in modes)


def middle(cycle) -> Closed:
    """A cycle of the package amid its longest arc, of those in which most slides."""
    orbit, laws, model = cycle.orbit, Series(cycle.drive), model_of(cycle.drive)
    modes, _, _, durations = orbit.arcs()
    ways = [laws.mode(model.modes(int(orbit.automaton.codes[mode])).name.lower()) for mode in modes]
    k = max(range(len(ways)), key=lambda k: (sum(ways[k][name] != 0 for name in laws.dry), durations[k]))
    state = orbit.at(np.array([sum(durations[:k]) + durations[k] / 2]))[0][0]
    return Closed(state, cycle.period, named(cycle.drive, cycle.itinerary))


def rate(laws: Series, state: np.ndarray, mode: dict) -> np.ndarray:
    found = laws.own(state + laws.steady, mode)
    return np.column_stack([state[1::2], [float(found[name]) for name in laws.q]]).ravel()


def closed(drive, near: Closed, size) -> Closed | None:
    """The periodic motion of a drive next to a state and a period, by Broyden's method on differences of motions."""
    laws, x, period, matrix, last = Series(drive), near.state.copy(), near.period, None, math.inf
    step = np.zeros(len(x) + 1)
    for _ in range(20):
        first, (*events, end) = laws.follow(x, period, 400)
        there = end.state.astype(float)
        gap, along = np.append((there - x) / size, 0.0), rate(laws, x, first) / size
        if float(end.time) < period or np.abs(gap).max() > 10 * last or np.abs(step).max() > 0.3:
            return None
        if matrix is None or np.abs(gap).max() > 0.5 * last:
            ends = [laws.follow(x + step, period, 400)[1][-1].state for step in 1e-8 * np.diag(size)]
            jacobian = np.array([(one - end.state) / size for one in ends]).T.astype(float) / 1e-8 - np.eye(len(x))
            late = rate(laws, there, end.mode) / size * period
            matrix = np.block([[jacobian, late[:, None]], [along / np.abs(along).max(), 0.0]])
        else:
            matrix = matrix + np.outer(gap, step) / (step @ step)
        last, step = np.abs(gap).max(), np.linalg.solve(matrix, -gap)
        if last < 1e-11 or np.abs(step).max() < 1e-11:
            return Closed(x, period, happened(events))
        x, period = x + step[:-1] * size, period * (1 + step[-1])
    return None


class Judge:
    """What is wrong with a branch of cycles over a span, as sentences in ``faults``; ``held`` counts what was asked."""

    def __init__(self, branch, span) -> None:
        self.branch, self.span, self.points, self.faults = branch, span, branch.points, []
        self.drive, self.held = self.points[0].cycle.drive, Counter()
        self.course()
        whats = {kind: [change for change in branch.changes if change.kind == kind] for kind in ("fold", "end")}
        whats |= {"border": [c for c in branch.changes if c.kind == "itinerary"], "periodic": self.points[::10]}
        for name, asked in whats.items():
            for one in asked:
                try:
                    getattr(self, name)(one)
                    self.held[name] += 1
                except UNKNOWN:
                    self.held[f"{name} not known"] += 1

    def fault(self, *words) -> None:
        self.faults.append(" ".join(f"{word:.12g}" if isinstance(word, float) else str(word) for word in words))

    def at(self, value: float) -> Drive:
        return self.drive.replace(**{self.branch.parameter: value})

    def course(self) -> None:
        """Points in order, in steps as long as is said, without jumps, and none where the branch has been."""
        along, values = (np.array([getattr(point, name) for point in self.points]) for name in ("along", "value"))
        lengths, n = np.diff(along), len(self.points[0].cycle.state)
        ranges = np.array([[*point.cycle.extremes.values()][:n] for point in self.points])
        ranges /= np.maximum(np.abs(ranges).max(axis=(0, 2), keepdims=True), np.finfo(float).tiny)
        counted = np.arcsinh(values / abs(values[np.argmin(np.abs(along))]))
        periods = np.log([point.cycle.period for point in self.points])
        places = np.column_stack([counted, periods, ranges.reshape(len(along), -1)])
        if not (lengths > 0).all() or (np.abs(np.diff(counted)) > 1.001 * lengths + 3e-7).any():
            self.fault("steps are longer than along says")
        jumps = np.abs(np.diff(places, axis=0)).max(axis=1) - 30 * lengths  # extremes may change so much more
        if jumps.max(initial=0.0) > 1e-6:
            self.fault("the branch jumps behind", values[np.argmax(jumps)])
        whole = not any("points" in change.what for change in self.branch.changes)  # else its ways may overlap
        same = [[*named(p.cycle.drive, p.cycle.itinerary).items()] for p in self.points]
        for i, way in enumerate(np.diff(places, axis=0)[:-2]):
            off = places[i + 2 :] - places[i]
            part = np.clip(off @ way / (way @ way), 0, 1)
            apart = np.abs(off - part[:, None] * way).max(axis=1) / np.minimum(along[i + 2 :] - along[i + 1], 0.1)
            back = (i + 2 + j for j in range(1, len(apart)) if apart[j] < 0.01 and same[i] == same[i + 2 + j])
            if any(whole or along[i] * along[k] >= 0 for k in back):
                return self.fault("the branch comes back to", values[i])
        return None

    def periodic(self, point) -> None:
        """A point is a periodic motion, with its events; where law + hardly holds it makes more of a rounding."""
        own = middle(point.cycle)
        _, (*events, end) = Series(point.cycle.drive).follow(own.state, own.period, 400)
        gap = (np.abs(end.state.astype(float) - own.state) / sizes(point)).max()
        most = 1e-4 if "contact_reversal" in dict(point.cycle.itinerary) else 1e-8
        if not gap <= most * max(1.0, point.cycle.leading) or happened(events) != own.events:
            self.fault("no such motion at", point.value, gap, happened(events) - own.events)

    def beside(self, along: float):
        """The last point before a place of the branch and the first behind it, not nearer than differences need."""
        ways = ([point for point in self.points if (point.along - along) * way > 1e-3] for way in (-1, 1))
        pair = [min(points, key=lambda point: abs(point.along - along)) for points in ways]
        others = [c for c in self.branch.changes if pair[0].along < c.along < pair[1].along and c.kind != "stability"]
        assert all(abs(c.along - along) < 1e-12 for c in others), "other changes are too near"
        return pair

    def led(self, point, value: float, width: float = 0.0) -> dict[float, Closed]:
        """Cycles of its events from a point on to 0.01 of ``width`` before a value, by such parts; empty if not all.

        Where Newton's method fails from one to the next, it goes by one between.
        """
        width, found = width or point.value - value, {}
        most = (point.value - value) / width
        ahead = [0.01, 0.03, 0.1, 0.3, 1.0, *(part for part in most * 0.3 ** np.arange(9, -1, -1) if part > 1)]
        while ahead and len(found) + len(ahead) < 30:
            near, part = middle(point.cycle), ahead[-1]
            if len(found) > 1:
                (old, one), (new, near) = [*found.items()][-2:]
                share = (part - new) / (new - old)
                near = Closed(*(b + share * (b - a) for a, b in zip(one[:2], near[:2], strict=True)), near.events)
            there = closed(self.at(value + part * width), near, sizes(point))
            if there is not None and there.events == near.events:
                found[ahead.pop()] = there
            elif not found:
                break
            else:
                ahead.append(0.5 * (part + [*found][-1]))
        return {} if ahead else found

    def border(self, change) -> None:
        """Next to a border are cycles of the events of the points beside it, on one orbit, that differ as is said."""
        pair, value = self.beside(change.along), change.value
        found = [self.led(point, value).get(0.01) for point in pair]
        if None in found:
            return self.fault("no own cycle next to the border", value, *(one is None for one in found))
        apart = abs(math.log(found[0].period / found[1].period))
        most = max(abs(math.log(p.cycle.period / own.period)) for p, own in zip(pair, found, strict=True))
        if apart > 0.1 * most + 1e-7:
            self.fault("the branch jumps at the border", value, *(one.period for one in found))
        before, after = (one.events for one in found)
        for words in re.split(" and (?=gains)", change.what):
            verb, _, told = words.partition(" ")
            events = [event.replace(" ", "_").split("_into_") for event in told.split(", ")]
            if named(self.drive, events) != (before - after if verb == "loses" else after - before):
                self.fault("at the border", value, change.what, "but", before - after, after - before)
        return None

    def fold(self, change) -> None:
        """Two cycles on one side of a fold, none on the other; where their periods meet as a root does, to 1e-9."""
        pair, value = self.beside(change.along), change.value
        width = 0.1 * min((one.value - value for one in pair), key=abs)
        found = [self.led(one, value, width) for one in pair]
        if {} in found or (pair[0].value - value) * (pair[1].value - value) <= 0:
            return self.fault("no two cycles on a side of the fold", value)
        far, gap = ((found[0][part].period / found[1][part].period - 1) ** 2 for part in (0.03, 0.01))
        off = width * (0.01 - 0.02 * gap / (far - gap)) if far != gap else math.inf
        if found[0][0.01].events == found[1][0.01].events and not (gap > 1e-20 and abs(off) <= 1e-9 * abs(value)):
            self.fault("the fold at", value, "is none, or off by", off, *(one[0.01].period for one in found))
        for one in (found[0][0.01], found[1][0.01]):
            beyond = closed(self.at(value - 0.01 * width), one, sizes(pair[0]))
            if beyond is not None and (beyond.period / one.period - 1) ** 2 < 9 * gap:
                self.fault("the cycle goes on beyond the fold", value, beyond.period)
        return None

    def end(self, change) -> None:
        """Where an attracting cycle ends none goes on, from value to value, that comes nearer to it with the step."""
        last, inner = self.points[:: 1 if change.along < 0 else -1][:2]
        told = any(word in change.what for word in ("range", "points", "comes back", "refused"))
        own, here, gaps = middle(last.cycle), last.cycle, [0.0]
        for part in (1e-8, 1e-6, 1e-4, 1e-2) if not told and here.attracting else ():
            away = math.copysign(part * (self.span[1] - self.span[0]), last.value - inner.value)
            drive = self.at(change.value + away)
            try:
                cycle = cycle_of(steady_state(automaton_of(drive), own.state, max_events=100_000))
            except EngineError:
                return
            if cycle is None:
                return
            gap = max(abs(cycle.period / here.period - 1), abs(cycle.amplitude / here.amplitude - 1))
            if not gaps[-1] <= 0.3 * gap + 1e-7 or gap > 0.3:
                return
            own, gaps = middle(Cycle.of(drive, cycle)), [*gaps, gap]
        if len(gaps) > 1:
            self.fault("ends at", change.value, change.what, "but goes on, off by", *gaps[1:])


def sizes(point) -> np.ndarray:
    """Sizes of the coordinates of a cycle; some move by rounding only."""
    size = point.cycle.section.size
    return np.maximum(size, 1e-6 * np.tile(size[:2], len(size) // 2))
