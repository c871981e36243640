"""How another method's run is compared with the true motion.

A method is judged by its own tolerance. An error of up to ``GENEROSITY`` times the tolerance is right, events that are
closer together than that part of the duration may come in any order, and events that are as close to the start or the
end may be missing.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.record import Record, Verdict, distance
from benchmarks.sweeps.paths import same_but_corners, without_clusters

GENEROSITY = 1000.0  # An error of so many times a method's own tolerance is still right.


# What may become of a method on a case; INACCURATE: the right events, an error above what it was asked for.
VERDICTS = (Verdict.RIGHT, Verdict.INACCURATE, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)


class Answer(NamedTuple):
    """Verdict; largest relative error of final state and times, nan unless the events are right."""

    verdict: Verdict
    error: float = math.nan


def compare(duration: float, truth: Record, run: Record, allowed: float) -> Answer:
    """Compare a run with the true motion; ``allowed``: error, relative to the motion and to its duration [s]."""
    gap = allowed * duration
    state_error = distance(run.end, truth)
    ours, theirs = list(zip(truth.times, truth.kinds, strict=True)), list(zip(run.times, run.kinds, strict=True))
    pairs = [(a, b) for a in _trimmed(ours, gap, duration) for b in _trimmed(theirs, gap, duration)]
    for a, b in pairs:
        if [kind for _, kind in a] == [kind for _, kind in b]:
            late = max((abs(x - y) for (x, _), (y, _) in zip(a, b, strict=True)), default=0.0)
            error = max(state_error, float(late) / duration)
            return Answer(Verdict.RIGHT if error <= allowed else Verdict.INACCURATE, error)
    if state_error > allowed:
        return Answer(Verdict.OTHER_MOTION)
    same = any(same_but_corners(_tokens(a, gap), _tokens(b, gap)) for a, b in pairs)
    return Answer(Verdict.RIGHT, state_error) if same else Answer(Verdict.OTHER_EVENTS)


def _trimmed(events: list[tuple[float, str]], gap: float, duration: float) -> Iterator[list[tuple[float, str]]]:
    """The events, all of them first, then without some of those that are next to the start or the end."""
    early = sum(time <= gap for time, _ in events)
    late = sum(time >= duration - gap for time, _ in events)
    for first in range(early + 1):
        for last in range(late + 1):
            yield events[first : max(first, len(events) - last)]


def _tokens(events: list[tuple[float, str]], gap: float) -> list[str]:
    return without_clusters([kind for _, kind in events], [time for time, _ in events], gap)
