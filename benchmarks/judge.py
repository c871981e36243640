"""What judges compare of a motion, whoever computed it, how far it is from the true one, and all verdicts on it.

In a race the events must be those of the true motion in any order, and the steady amplitude must be its amplitude. In
sweeps the engine must have all events in order (:mod:`benchmarks.sweeps.case_judge`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

_STOPS = ("stick", "reversal", "seizure")  # events at which θ′ arrives at zero
QUARTILES = (0.25, 0.5, 0.75)
CORNER = "corner"  # stands for events that follow each other at once
_AMPLITUDE = 0.05  # a steady amplitude that is further off, in sizes of the motion, belongs to another attractor


class Verdict(IntEnum):
    """What became of an answer that was compared with another one; a comparison uses those that it can tell apart."""

    NOT_RUN = -1
    RIGHT = 0
    REFUSED = 1  # one clear sentence instead of an answer
    BEYOND_INPUT = 2  # the digits that decide are not in the input
    CORNER = 3  # other events within an instant, where two guards meet or events accumulate; the same before and after
    INACCURATE = 4  # the right events, an error above the tolerance
    WRONG = 5  # other events, or another answer
    UNBALANCED = 6  # right events, time and state, but the energy of the motion does not balance
    OTHER_EVENTS = 7  # events missed or invented, but the motion goes on or ends as it should
    OTHER_MOTION = 8  # another end or another steady amplitude, or motion where there is none
    GAVE_UP = 9  # too much time or effort, a step that cannot be made, an endless chain of events, overflow


@dataclass(frozen=True)
class Record:
    """A motion as far as it is compared.

    ``kinds`` (names) and ``times`` [s] of its events, with a second body the mode after the event and whether it is a
    seizure, None for a method without events; ``end`` (n): final state; ``size`` (n): of each coordinate;
    ``complete``: False if it was cut off after too many events, and then there is no final state to compare;
    ``stops``: how often θ′ arrived at zero; ``extremes``: smallest and largest u [rad] once the scene is steady;
    ``failure``: why a method gave up, else empty.
    """

    kinds: list[str] | None = None
    times: np.ndarray = field(default_factory=lambda: np.empty(0))
    end: np.ndarray = field(default_factory=lambda: np.empty(0))
    size: np.ndarray = field(default_factory=lambda: np.empty(0))
    complete: bool = True
    stops: int = 0
    extremes: tuple[float, float] = (math.nan, math.nan)
    failure: str = ""

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak of u [rad] once the scene is steady."""
        return 0.5 * (self.extremes[1] - self.extremes[0])


def count_stops(kinds: list[str], starts_at_rest: bool) -> int:
    """Return how often θ′ arrives at zero in a motion with events of these kinds (names)."""
    return sum(kind in _STOPS for kind in kinds) + starts_at_rest


def quartiles(repeats: ArrayLike) -> np.ndarray:
    """Return quartiles (…, 3) of repeats along the last axis; nan if one of them is."""
    return np.moveaxis(np.quantile(repeats, QUARTILES, axis=-1), 0, -1)


class Answer(NamedTuple):
    """Verdict; errors of the final state in sizes of the motion, of event times [s], of the amplitude in sizes of u.

    ``times`` is nan unless the events are those of the true motion in the same order.
    """

    verdict: Verdict
    state: float = math.nan
    times: float = math.nan
    amplitude: float = math.nan


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
