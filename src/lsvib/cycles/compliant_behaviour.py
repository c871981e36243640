"""What drives with compliant threads do, in one word for each, by their motions alone.

As :mod:`lsvib.cycles.behaviour`, one motion next to steady sliding and one from far away on θ′ = 0, but drive by drive:
the tables of such a drive need eigenvalues in 60 digits.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from multiprocessing import get_context
from typing import Any

import numpy as np

from lsvib.cycles.attractors import Attractor, SteadyState, steady_state
from lsvib.cycles.behaviour import Behaviour, behaviour_of, near_and_far
from lsvib.cycles.endings import REVERSES
from lsvib.drives.many import ManyDrives
from lsvib.drives.parameters import RigidParameters, ThreadsParameters
from lsvib.drives.threads import ThreadsEvent, seated_state, threads_automaton

_SHARE = 4  # drives that a process takes at a time, half a second


def compliant_behaviours(
    drive: ThreadsParameters,
    axes: Mapping[str, Sequence[float]],
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> np.ndarray:
    """Return what a drive with compliant threads does (k, int8) over the product of values of its parameters.

    Arguments: the drive; values [SI units] by name; number of processes (``workers``), which changes no label;
    ``progress``, called with the numbers of drives done and in all. Raises ``InputError``.
    """
    drives = [drive.replace(**dict(zip(axes, values, strict=True))) for values in product(*axes.values())]
    found = np.empty(len(drives), dtype=np.int8)

    def take(labels: Any) -> np.ndarray:
        for k, label in enumerate(labels):
            found[k] = label
            if progress is not None:
                progress(k + 1, len(drives))
        return found

    if workers == 1 or len(drives) <= _SHARE:
        return take(map(compliant_behaviour, drives))
    with get_context("spawn").Pool(workers) as pool:
        return take(pool.imap(compliant_behaviour, drives, _SHARE))


def compliant_behaviour(drive: ThreadsParameters) -> Behaviour:
    """Return what one drive with compliant threads does."""
    drives = ManyDrives({name: getattr(drive, name) for name in RigidParameters.model_fields})
    near, far = (seated_state(drive, *start[0].tolist()) for start in near_and_far(drives))
    automaton = threads_automaton(drive)
    found = _behaviour(steady_state(automaton, near))
    if found is not Behaviour.NO_VIBRATION:
        return found
    again = _behaviour(steady_state(automaton, far))
    return again if again in (Behaviour.NO_VIBRATION, Behaviour.UNRESOLVED) else Behaviour.COEXISTENCE


def _behaviour(found: SteadyState) -> Behaviour:
    """The behaviour of one motion."""
    if found.label == Attractor.STEADY_SLIDING:
        return Behaviour.NO_VIBRATION
    reverses = found.orbit is not None and (found.orbit.kind == ThreadsEvent.CONTACT_REVERSAL).any()
    return Behaviour(int(behaviour_of(np.array([int(found.label)]), np.array([REVERSES * bool(reverses)]))[0]))
