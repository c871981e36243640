"""All methods on one scene: interleaved in one process, timed after a discarded run, compared with 40 digits.

Times are processor times of this process: on a quiet machine the same as by the clock on the wall, on a busy one not
inflated by what others do.
"""

import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lsvib.accuracy.catalogue import find_method
from lsvib.accuracy.hybrid import Clock, GaveUp, Hybrid
from lsvib.accuracy.references import reference
from lsvib.accuracy.result import Errors, Reference, Run, errors
from lsvib.accuracy.scenes import Scene, scene

_WARM_UP = 0.01  # of the duration, discarded: loads, compiles and fills caches


@dataclass(frozen=True)
class Budget:
    """``repeats``: runs of each entry at most; ``seconds`` after which an entry is not repeated again; ``limit`` [s] of
    one run, after which it gives up.
    """

    repeats: int
    seconds: float
    limit: float


@dataclass
class Entry:
    """One method at one setting: its errors, the times of its runs [s], its number of events, why it gave up."""

    method: str
    setting: float
    errors: Errors | None = None
    seconds: list[float] = field(default_factory=list)
    events: int = -1
    failure: str = ""

    @property
    def fastest(self) -> float:
        """Shortest run [s]."""
        return min(self.seconds, default=float("nan"))

    @property
    def median(self) -> float:
        """Median run [s]."""
        return statistics.median(self.seconds) if self.seconds else float("nan")


def contest(
    name: str, settings: Mapping[str, Sequence[float]], budget: Budget, duration: float | None = None
) -> tuple[Scene, Reference, list[Entry]]:
    """Run the methods with their settings on a scene, and its reference.

    Each round runs every entry once, so that a slow spell of the machine hits all alike. Methods for non-stiff problems
    are left out of a stiff scene. Raises ``InputError`` if a name is wrong or a package is missing.
    """
    this = scene(name, duration)
    truth = reference(this)
    hybrid, limit = Hybrid(this), 10 * len(truth.kinds) + 100
    entries, functions = [], []
    for method_name, values in settings.items():
        method = find_method(method_name)
        if method.explicit and not this.explicit:
            continue
        clock = Clock(budget.limit)
        values = values or [0.0]
        _warm_up(method, this, values[0], clock)
        for setting in values:
            entries.append(Entry(method_name, setting))
            functions.append(method.prepare(hybrid, setting, clock, limit))
    for _ in range(budget.repeats):
        for entry, function in zip(entries, functions, strict=True):
            if not entry.failure and (not entry.seconds or sum(entry.seconds) < budget.seconds):
                _run(entry, function, truth)
    return this, truth, entries


def _warm_up(method, this: Scene, setting: float, clock: Clock) -> None:
    short = Hybrid(scene(this.name, _WARM_UP * this.duration))
    try:
        method.prepare(short, setting, clock, 1000)().run()
    except GaveUp:
        pass  # then the whole run does so too, and is counted


def _run(entry: Entry, function, truth: Reference) -> None:
    start = time.process_time()
    try:
        outcome = function()
    except GaveUp as reason:
        entry.failure = str(reason)
        entry.errors = errors(Run(np.array([np.nan]), failure=entry.failure), truth)
        return
    entry.seconds.append(time.process_time() - start)
    if entry.errors is None:
        run = outcome.run()
        entry.errors, entry.failure = errors(run, truth), run.failure
        entry.events = -1 if run.kinds is None else len(run.kinds)
