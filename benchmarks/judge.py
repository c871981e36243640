"""How far a motion is from the true one, and the verdict on it: of a race, of a method that is asked, of the engine.

In a *race* the events must be those of the true motion in any order, and so must the steady amplitude; errors are
numbers. A method that is *asked* is judged by its own tolerance: an error of up to ``GENEROSITY`` times it is right,
events that are closer together than that part of the duration may come in any order, and events that are as close to
the start or the end may be missing. The engine must have all events in order (:mod:`benchmarks.sweeps.case_judge`).
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from benchmarks.record import Record, Verdict

GENEROSITY = 1000.0  # An error of so many times a method's own tolerance is still right.
CORNER = "corner"  # stands for events that follow each other at once
_AMPLITUDE = 0.05  # a steady amplitude that is further off, in sizes of the motion, belongs to another attractor
# What may become of a method that is asked; INACCURATE: the right events, an error above what it was asked for.
VERDICTS = (Verdict.RIGHT, Verdict.INACCURATE, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)


class Answer(NamedTuple):
    """Verdict; errors of the final state in sizes of the motion, of event times, of the amplitude in sizes of u.

    ``times`` is nan unless the events are those of the true motion in the same order, in a race in seconds, else
    relative to the duration.
    """

    verdict: Verdict
    state: float = math.nan
    times: float = math.nan
    amplitude: float = math.nan

    @property
    def error(self) -> float:
        """Largest relative error of final state and event times [1]; nan where there is none to compare."""
        return float(np.fmax(self.state, self.times))


def distance(end: np.ndarray, other: Record) -> float:
    """Return how far a final state is from that of a record, in sizes of its coordinates [1]."""
    n = min(end.size, other.end.size)  # a regularised model may have more coordinates
    return float(np.max(np.abs(end[:n] - other.end[:n]) / np.where(other.size > 0, other.size, 1.0)[:n]))


def lateness(run: Record, truth: Record) -> float:
    """Return the largest difference of event times [s]; nan unless the events are the same."""
    return float(np.max(np.abs(run.times - truth.times), initial=0.0)) if run.kinds == truth.kinds else math.nan


def without_clusters(kinds: Sequence[str], times: Sequence[float], gap: float) -> list[str]:
    """Return the kinds of events, with each run of events that follow each other within ``gap`` [s] as one corner."""
    tokens: list[str] = []
    for k, kind in enumerate(kinds):
        if k and times[k] - times[k - 1] <= gap:
            tokens[-1] = CORNER
        else:
            tokens.append(kind)
    return tokens


def same_but_corners(left: Sequence[str], right: Sequence[str]) -> bool:
    """Whether two results of :func:`without_clusters` agree; a corner agrees with any event."""
    return len(left) == len(right) and all(a == b or CORNER in (a, b) for a, b in zip(left, right, strict=True))


def raced(run: Record, truth: Record) -> Answer:
    """Compare a run of a race with the truth: RIGHT, OTHER_EVENTS, OTHER_MOTION or GAVE_UP."""
    if run.failure or not np.isfinite(run.end).all():
        return Answer(Verdict.GAVE_UP)
    amplitude = abs(run.amplitude - truth.amplitude) / float(truth.size[0])
    same = run.stops == truth.stops if run.kinds is None else sorted(run.kinds) == sorted(truth.kinds)
    verdict = Verdict.RIGHT if same else Verdict.OTHER_EVENTS
    verdict = verdict if amplitude <= _AMPLITUDE else Verdict.OTHER_MOTION
    return Answer(verdict, distance(run.end, truth), lateness(run, truth), amplitude)


def asked(duration: float, truth: Record, run: Record, allowed: float) -> Answer:
    """Compare the answer of a method with the truth; ``allowed``: error, relative to the motion and its duration."""
    if run.failure or not np.isfinite(run.end).all():
        return Answer(Verdict.GAVE_UP)
    gap, state = allowed * duration, distance(run.end, truth)
    pairs = list(product(_trimmed(truth, gap, duration), _trimmed(run, gap, duration)))
    for a, b in pairs:
        late = lateness(a, b) / duration
        if not math.isnan(late):
            return Answer(Verdict.RIGHT if max(state, late) <= allowed else Verdict.INACCURATE, state, late)
    if state > allowed:
        return Answer(Verdict.OTHER_MOTION)
    tokens = [[without_clusters(one.kinds, one.times, gap) for one in pair] for pair in pairs]
    return (
        Answer(Verdict.RIGHT, state)
        if any(same_but_corners(*pair) for pair in tokens)
        else Answer(Verdict.OTHER_EVENTS)
    )


def _trimmed(run: Record, gap: float, duration: float) -> Iterator[Record]:
    """The events, all of them first, then without some of those that are next to the start or the end."""
    early, late = int((run.times <= gap).sum()), int((run.times >= duration - gap).sum())
    for first, last in product(range(early + 1), range(late + 1)):
        part = slice(first, max(first, len(run.times) - last))
        yield Record(run.kinds[part], run.times[part])
