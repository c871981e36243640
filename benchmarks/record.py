"""What judges compare of a motion, whoever computed it, and all verdicts on it."""

import math
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

_STOPS = ("stick", "reversal", "seizure")  # events at which θ′ arrives at zero


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


QUARTILES = (0.25, 0.5, 0.75)


def quartiles(repeats: ArrayLike) -> np.ndarray:
    """Return quartiles (…, 3) of repeats along the last axis; nan if one of them is."""
    return np.moveaxis(np.quantile(repeats, QUARTILES, axis=-1), 0, -1)
