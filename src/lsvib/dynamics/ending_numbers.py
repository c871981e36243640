"""The numbers that say what a motion ends on: those of one motion, and of many as arrays."""

import math
from typing import Any, NamedTuple

import numpy as np

from lsvib.dynamics.attractor import Attractor


class Ending(NamedTuple):
    """What a motion ends on; nan where it has no such number.

    ``attractor``, an :class:`lsvib.dynamics.attractor.Attractor`; ``happens``, what happens on a cycle: the sum of
    those of ``SPRAGS``, ``RESTS`` and ``REVERSES`` (the contact force changes its sign) that do; ``amplitude`` [rad],
    half the peak-to-peak of u; ``period`` [s]; ``multiplier`` [1] of the return map, the largest; ``peak_normal_force``
    [N], largest |N| without the impulses of seizures; ``peak_normal_impulse`` [N s], largest |J_N| of a seizure, 0
    without.
    """

    attractor: int
    happens: int
    amplitude: float
    period: float
    multiplier: float
    peak_normal_force: float
    peak_normal_impulse: float

    @classmethod
    def without_numbers(cls, attractor: int) -> "Ending":
        """Return an ending of which only the attractor is known."""
        return cls(int(attractor), 0, *(math.nan,) * 5)


class Endings(NamedTuple):
    """What motions end on, arrays (k) of what :class:`Ending` holds, in the same units."""

    attractor: np.ndarray
    happens: np.ndarray
    amplitude: np.ndarray
    period: np.ndarray
    multiplier: np.ndarray
    peak_normal_force: np.ndarray
    peak_normal_impulse: np.ndarray

    @classmethod
    def unknown(cls, size: int) -> "Endings":
        """Return room for so many."""
        kinds = np.full(size, Attractor.UNRESOLVED, dtype=np.int8), np.zeros(size, dtype=np.int8)
        return cls(*kinds, *(np.full(size, np.nan) for _ in cls._fields[2:]))

    def put(self, places: Any, others: "Endings | Ending") -> None:
        """Copy the endings ``others`` into the places that are given."""
        for mine, theirs in zip(self, others, strict=True):
            mine[places] = theirs
