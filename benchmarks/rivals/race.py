"""All methods on one scene: interleaved in one process, timed after a discarded run, compared with 40 digits.

Times are processor times of this process: on a quiet machine the same as by the clock on the wall, on a busy one not
inflated by what others do. How much faster one method is than others is asked at an equal error.
"""

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks.judge import Answer, Record, raced
from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid
from benchmarks.rivals.method_list import METHODS
from benchmarks.rivals.race_scenes import RaceScene, scene
from lsvib.drives.friction import depends_on_speed

_TURN = 3e-3  # [s] for which a quick entry is repeated in a round, so that the clock is fine enough
_WARM_UP = 0.01  # part of the duration that is run and discarded first, which loads, compiles and fills caches


@dataclass
class Entry:
    """One method at one setting: its errors, the times of its runs [s] and the shortest of each round, its number of
    events, why it gave up.

    ``first`` [s] is the time of the method's discarded run on the scene, in which what it needs is loaded and compiled.
    """

    method: str
    setting: float
    first: float = float("nan")
    errors: Answer | None = None
    seconds: list[float] = field(default_factory=list)
    rounds: list[float] = field(default_factory=list)
    events: int = -1
    failure: str = ""

    @property
    def fastest(self) -> float:
        """Shortest run [s]."""
        return min(self.seconds, default=float("nan"))

    def of_round(self, number: int) -> float:
        """Shortest run [s] of a round, or of the last one in which the entry ran."""
        return self.rounds[min(number, len(self.rounds) - 1)] if self.rounds else float("nan")


def contest(
    name: str, settings: Mapping[str, Sequence[float]], repeats: int, seconds: float, limit: float, shorten: float = 1.0
) -> tuple[RaceScene, Record, list[Entry]]:
    """Run the methods with their settings on a scene, and its reference.

    ``settings``: for each method its tolerances, steps or widths, none to leave it out; [0] where there is nothing to
    set. Each of ``repeats`` rounds runs every entry, so that a slow spell of the machine hits all alike; an entry
    leaves further rounds after so many ``seconds``, and a run is given up after ``limit`` [s]. ``shorten`` cuts the
    scene to that part of its duration. Methods for non-stiff problems are left out of a stiff scene, those for linear
    fields where friction depends on speed. Raises ``InputError`` if a name is wrong or a package is missing.
    """
    this = scene(name, shorten)
    truth = this.truth()
    hybrid, most = Hybrid(this), 10 * len(truth.kinds) + 100
    law, entries = depends_on_speed(this.drive), list[tuple[Entry, Callable]]()
    with warnings.catch_warnings(), np.errstate(all="ignore"):  # a run that fails is counted, not described
        warnings.simplefilter("ignore")
        for method_name, values in settings.items():
            method = METHODS[method_name]
            if not values or (method.explicit and this.stiff) or (method.linear and law):
                continue
            clock = Clock(limit)
            first = _warm_up(method, this, values[0], clock)
            for setting in values:
                entries.append((Entry(method_name, setting, first), method.prepare(hybrid, setting, clock, most)))
        for _ in range(repeats):
            for entry, function in entries:
                if not entry.failure and (not entry.seconds or sum(entry.seconds) < seconds):
                    _run(entry, function, truth)
    return this, truth, [entry for entry, _ in entries]


def _warm_up(method, this: RaceScene, setting: float, clock: Clock) -> float:
    """Run a method on the first hundredth of a scene; returns how long it took [s]."""
    short = Hybrid(replace(this, duration=_WARM_UP * this.duration))
    start = time.process_time()
    with suppress(GaveUp):  # then the whole run gives up too, and is counted
        method.prepare(short, setting, clock, 1000)()()
    return time.process_time() - start


def _run(entry: Entry, function, truth: Record) -> None:
    """Run an entry once, or a quick one so often that caches and clock have settled; compare its first result."""
    total, outcome, before = 0.0, None, len(entry.seconds)
    try:
        while total < _TURN:
            start = time.process_time()
            outcome = function()
            entry.seconds.append(time.process_time() - start)
            total += entry.seconds[-1]
    except GaveUp as reason:
        entry.failure = str(reason)
        entry.errors = raced(Record(failure=entry.failure), truth)
        return
    entry.rounds.append(min(entry.seconds[before:]))
    if entry.errors is None:
        run = outcome()
        entry.errors, entry.failure = raced(run, truth), run.failure
        entry.events = -1 if run.kinds is None else len(run.kinds)


def time_at_error(points: Iterable[tuple[float, float]], level: float) -> float:
    """Return the time [s] that a method needs for an error of at most ``level``; nan if it never gets there.

    ``points``: pairs (error, time [s]) of its runs. Between two runs error and time are interpolated in logarithms; a
    method whose coarsest run is already better needs the time of its fastest run that is good enough.
    """
    found = math.nan
    runs = sorted((error, seconds) for error, seconds in points if error >= 0 and seconds > 0)
    for k, (error, seconds) in enumerate(runs):
        if error > level:
            continue
        best = seconds
        if k + 1 < len(runs) and runs[k + 1][0] > level and error > 0 and runs[k + 1][1] < seconds:
            worse, quick = runs[k + 1]
            share = math.log(level / error) / math.log(worse / error)
            best = math.exp((1 - share) * math.log(seconds) + share * math.log(quick))
        found = best if math.isnan(found) else min(found, best)
    return found


def fastest(methods: Iterable[Sequence[tuple[float, float]]], level: float) -> float:
    """Return the shortest time [s] in which one of several methods reaches an error; nan if none does."""
    times = [time for time in (time_at_error(points, level) for points in methods) if not math.isnan(time)]
    return min(times, default=math.nan)
