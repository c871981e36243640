"""What a method computes of a scene, what is right, and how far the one is from the other."""

import math
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

_AMPLITUDE = 0.05  # a steady amplitude that is further off, in sizes of the motion, belongs to another attractor
_STOPS = ("stick", "reversal", "seizure")  # events at which θ′ arrives at zero


class RunVerdict(IntEnum):
    """Whether a run shows the motion that really takes place."""

    NOT_RUN = -1
    RIGHT = 0
    WRONG_EVENTS = 1  # another number of events of some kind
    WRONG_ATTRACTOR = 2  # another steady amplitude, or motion where there is none
    GAVE_UP = 3  # over its time, a step that cannot be made, an endless chain of events, overflow


@dataclass
class Run:
    """Result of one run of a method.

    ``times`` [s] and ``kinds`` (names) of its events, if it has any; ``stops``: how often θ′ arrived at zero, for a
    method without events; ``end_state`` (n); ``extremes``: smallest and largest u [rad] in the scene's window;
    ``failure``: why it gave up, else empty.
    """

    end_state: np.ndarray
    times: np.ndarray = field(default_factory=lambda: np.empty(0))
    kinds: list[str] | None = None
    stops: int = 0
    extremes: tuple[float, float] = (math.nan, math.nan)
    failure: str = ""


@dataclass(frozen=True)
class Reference:
    """The motion to 40 digits, rounded to double at the end: as :class:`Run`, and the sizes of the motion (n)."""

    end_state: np.ndarray
    times: np.ndarray
    kinds: list[str]
    stops: int
    extremes: tuple[float, float]
    sizes: np.ndarray

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak of u [rad] in the scene's window."""
        return 0.5 * (self.extremes[1] - self.extremes[0])


@dataclass(frozen=True)
class Errors:
    """Errors of a run: of the final state in sizes of the motion, of event times [s], of the amplitude in sizes of u.

    ``times`` is nan unless the run has the events of the reference in the same order.
    """

    state: float
    times: float
    amplitude: float
    verdict: RunVerdict


def errors(run: Run, reference: Reference) -> Errors:
    """Compare a run with the reference; see :class:`Errors` and :class:`RunVerdict`."""
    if run.failure or not np.isfinite(run.end_state).all():
        return Errors(math.nan, math.nan, math.nan, RunVerdict.GAVE_UP)
    n = min(run.end_state.size, reference.end_state.size)  # a regularised model may have more coordinates
    state = float(np.max(np.abs(run.end_state[:n] - reference.end_state[:n]) / reference.sizes[:n]))
    amplitude = abs(0.5 * (run.extremes[1] - run.extremes[0]) - reference.amplitude) / float(reference.sizes[0])
    times = math.nan
    if run.kinds == reference.kinds:
        times = float(np.max(np.abs(run.times - reference.times), initial=0.0))
    if not amplitude <= _AMPLITUDE:
        verdict = RunVerdict.WRONG_ATTRACTOR
    elif run.kinds is None:
        verdict = RunVerdict.RIGHT if run.stops == reference.stops else RunVerdict.WRONG_EVENTS
    else:
        verdict = RunVerdict.RIGHT if sorted(run.kinds) == sorted(reference.kinds) else RunVerdict.WRONG_EVENTS
    return Errors(state, times, amplitude, verdict)


def count_stops(kinds: list[str], starts_at_rest: bool) -> int:
    """Return how often θ′ arrives at zero in a motion with events of these kinds (names)."""
    return sum(kind in _STOPS for kind in kinds) + starts_at_rest
