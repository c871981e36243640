"""What drives with compliant threads do, in one word for each, by their motions alone.

As :mod:`lsvib.dynamics.behaviour`, one motion next to steady sliding and one from far away on θ′ = 0.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from lsvib.dynamics.attractor import Attractor, SteadyState, steady_state
from lsvib.dynamics.behaviour import Behaviour, behaviour_of, near_and_far
from lsvib.dynamics.sweep import Prepared, happens, in_shares, prepared
from lsvib.models.many import ManyDrives


def compliant_behaviours(
    drives: ManyDrives, resume: str, workers: int = 1, progress: Callable[[int, int], None] | None = None
) -> np.ndarray:
    """Return what drives with compliant threads do (k, int8).

    Arguments: the drives; rule of resuming, contact_sign; number of processes (``workers``), which changes no label;
    ``progress``, called with the numbers of drives done and in all. Raises ``InputError``.
    """
    found = np.empty(drives.size, dtype=np.int8)
    for places, part in in_shares(partial(_share, resume=resume), drives, near_and_far(drives), workers, progress):
        found[places] = part
    return found


def _share(drives: ManyDrives, near: np.ndarray, far: np.ndarray, resume: str) -> np.ndarray:
    found = np.full(drives.size, Behaviour.UNRESOLVED, dtype=np.int8)
    for one in prepared(drives, resume):
        if one.automaton is None:
            continue
        first, again = (one.state(dict(zip("uw", start[one.place].tolist(), strict=True))) for start in (near, far))
        found[one.place] = _behaviour(one, steady_state(one.automaton, first))
        if found[one.place] == Behaviour.NO_VIBRATION:
            other = _behaviour(one, steady_state(one.automaton, again))
            vibrates = other not in (Behaviour.NO_VIBRATION, Behaviour.UNRESOLVED)
            found[one.place] = Behaviour.COEXISTENCE if vibrates else other
    return found


def _behaviour(one: Prepared, found: SteadyState) -> Behaviour:
    """The behaviour of one motion."""
    if found.label == Attractor.STEADY_SLIDING:
        return Behaviour.NO_VIBRATION
    return Behaviour(int(behaviour_of(np.array([int(found.label)]), np.array([happens(one.model, found)]))[0]))
