"""The drive with compliant threads as pieces of a dataset: its cycles as curves, its contact as coordinates."""

from collections.abc import Mapping, Sequence

import numpy as np

from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import variable
from lsvib.datasets.phase_plane import Variables
from lsvib.dynamics.attractor import SteadyState, steady_state
from lsvib.engine.automaton import Automaton
from lsvib.models.drive import ThreadsDrive
from lsvib.models.threads import seated_state, threads_automaton

# The critical mass with contact as a variable: unit, words, symbol.
CRITICAL_MASS_WITH_CONTACT = (
    "kg", "mass at which steady sliding with the contact loses its stability", r"$m_\mathrm{cr}$",
)  # fmt: skip


def compliant_cycle(drive: ThreadsDrive, start: Mapping[str, float]) -> tuple[Automaton, SteadyState]:
    """Return the automaton and the attractor of the motion from a seated contact at u [rad], w [rad/s]."""
    automaton = threads_automaton(drive)
    return automaton, steady_state(automaton, seated_state(drive, start["u"], start["w"]))


def compliant_attractors(drives: Sequence[ThreadsDrive], start: Mapping[str, float]) -> list[SteadyState]:
    """Return the attractors that :func:`compliant_cycle` finds for each drive."""
    return [compliant_cycle(drive, start)[1] for drive in drives]


def cycle_curves(dims: Sequence[str], cycles: Sequence[SteadyState], count: int, prefix: str = "cycle") -> Variables:
    """Return cycles as curves in the phase plane, dimensions (*dims, sample), NaN where there is none.

    Variables: ``{prefix}_time`` [s] from a point of the cycle, ``_angle`` [rad], ``_velocity`` [rad/s]; both states of
    each event are among the samples.
    """
    curves = np.full((len(cycles), count, 3), np.nan)
    for curve, steady in zip(curves, cycles, strict=True):
        if steady.orbit is not None:
            times, states, _ = phase_plane.sample(steady.orbit, count)
            curve[:, 0], curve[:, 1:] = times, states[:, :2]
    curves = curves if dims else curves[0]
    dims = (*dims, f"{prefix}_sample")
    time = variable(dims, curves[..., 0], "s", "time along the cycle", "$t$")
    return {f"{prefix}_time": time, **phase_plane.curve(prefix, dims, curves[..., 1:], "on the limit cycle")}
