"""The drive with compliant threads as pieces of a dataset: its cycles as curves, its contact as coordinates."""

from collections.abc import Mapping, Sequence

import numpy as np

from lsvib.cycles.attractors import SteadyState, steady_state
from lsvib.data import phase_plane
from lsvib.data.attributes import attributes
from lsvib.data.phase_plane import Variables
from lsvib.drives.many_threads import automata_of
from lsvib.drives.parameters import ThreadsParameters
from lsvib.drives.threads import seated_state, threads_automaton
from lsvib.engine.automaton import Automaton

CRITICAL_MASS_WITH_CONTACT = "mass at which steady sliding with the contact loses its stability"


def compliant_cycle(drive: ThreadsParameters, start: Mapping[str, float]) -> tuple[Automaton, SteadyState]:
    """Return the automaton and the attractor of the motion from a seated contact at u [rad], w [rad/s]."""
    automaton = threads_automaton(drive)
    return automaton, steady_state(automaton, seated_state(drive, start["u"], start["w"]))


def compliant_attractors(drives: Sequence[ThreadsParameters], start: Mapping[str, float]) -> list[SteadyState]:
    """Return the attractors that :func:`compliant_cycle` finds for each drive, with all tables made at once."""
    seats = (seated_state(drive, start["u"], start["w"]) for drive in drives)
    return [steady_state(automaton, seat) for automaton, seat in zip(automata_of(drives), seats, strict=True)]


def cycle_curves(dims: Sequence[str], cycles: Sequence[SteadyState], count: int, prefix: str = "cycle") -> Variables:
    """Return cycles as curves in the phase plane, dimensions (*dims, sample), NaN where there is none.

    Variables: ``{prefix}_time`` [s] from a point of the cycle, ``_angle`` [rad], ``_velocity`` [rad/s]; both states of
    each event are among the samples.
    """
    curves = np.full((3, len(cycles), count), np.nan)
    for k, steady in enumerate(cycles):
        if steady.orbit is not None:
            times, states, _ = phase_plane.sample(steady.orbit, count)
            curves[:, k] = times, states[:, 0], states[:, 1]
    dims = (*dims, f"{prefix}_sample")
    shape = (len(cycles), count) if len(dims) == 2 else (count,)
    time, angle, velocity = curves.reshape(3, *shape)
    return {
        f"{prefix}_time": (dims, time, attributes("s", "time along the cycle", "$t$")),
        f"{prefix}_angle": (dims, angle, attributes("rad", "deviation on the limit cycle", "$u$")),
        f"{prefix}_velocity": (
            dims,
            velocity,
            attributes("rad s-1", "rate of the deviation on the limit cycle", r"$\dot u$"),
        ),
    }
