"""What the motions of many rigid drives end on: the results of :func:`lsvib.cycles.attractors.steady_state`, compiled.

The kernels do the common cases number by number as that function does, so that results are the same to the last bit.
What they leave open, the caller asks that function for (:attr:`Endings.open`).
"""

from dataclasses import dataclass

import numpy as np

from lsvib.cycles import attractors, leaps, return_map
from lsvib.cycles.attractors import Attractor
from lsvib.cycles.impulses import normal_impulse
from lsvib.cycles.kernels import endings as kernels
from lsvib.drives.many import Group, ManyDrives
from lsvib.drives.rigid import EventKind, MotionMode, Resume
from lsvib.engine.kernels import columns

_SEARCH = kernels.Search(
    chunk=attractors.CHUNK,
    patience=attractors.LONG,
    returns=attractors.PERIODS,
    solved=attractors.SOLVED,
    fewest=attractors.FEWEST,
    repeats=attractors.REPEATS[0],
    corner=attractors.CORNERS[0],
    few=leaps.FEW,
    patience_of_return=return_map.PATIENCE,
    longest=return_map.LONGEST,
    secants=return_map.SECANTS,
    wider=return_map.WIDER,
    widest=return_map.WIDEST,
    slope_step=return_map.SLOPE_STEP,
)


@dataclass(frozen=True)
class Endings:
    """What motions end on, arrays (k).

    ``attractor`` (int8, :class:`lsvib.cycles.attractors.Attractor`); ``happens``, what happens on a cycle: the sum of
    ``SPRAGS``, ``RESTS`` and ``REVERSES`` of :mod:`lsvib.cycles.kernels.endings`; ``amplitude`` [rad], ``period`` [s],
    ``multiplier`` [1], ``peak_normal_force`` [N] and ``peak_normal_impulse`` [N s] as of
    :class:`lsvib.data.sweep.Point`. ``open``: where none of this is known.
    """

    attractor: np.ndarray
    happens: np.ndarray
    amplitude: np.ndarray
    period: np.ndarray
    multiplier: np.ndarray
    peak_normal_force: np.ndarray
    peak_normal_impulse: np.ndarray
    open: np.ndarray

    @classmethod
    def unknown(cls, size: int) -> "Endings":
        """Return room for so many, all open."""
        return cls(
            np.full(size, Attractor.UNRESOLVED, dtype=np.int8),
            np.zeros(size, dtype=np.int8),
            *np.full((5, size), np.nan),
            np.ones(size, dtype=bool),
        )


def many_endings(drives: ManyDrives, entries: np.ndarray, start: tuple[float, float], resume: Resume) -> Endings:
    """Return what the motions of some drives (j, ascending indices) end on, all from one start, u [rad] and w [rad/s]."""
    found = Endings.unknown(entries.size)
    for group in drives.groups(resume, entries):
        _group_endings(drives, group, np.searchsorted(entries, group.members), start, found)
    return found


def _group_endings(
    drives: ManyDrives, group: Group, places: np.ndarray, start: tuple[float, float], found: Endings
) -> None:
    """Write what the motions of a group end on to ``found``, at ``places``."""
    automaton, size = group.automaton, group.members.size
    damped = (automaton.tables.flow[..., columns.ALPHA] > 0).any(axis=1)
    if automaton.contracts:  # steady sliding attracts all motions
        _slides(group, places, group.safe & damped, found)
        return
    rest = np.flatnonzero(automaton.codes == MotionMode.REST)
    facts = kernels.Facts(int(rest[0]), int(EventKind.SEIZURE), int(EventKind.CONTACT_REVERSAL))
    outcomes, happens = np.zeros(size, dtype=np.int8), np.zeros(size, dtype=np.int8)
    numbers = np.empty((size, kernels.NUMBERS))
    starts = np.broadcast_to(np.array(start), (size, 2)).copy()
    speed = drives.values["input_speed"][group.members]
    kernels.endings(
        automaton.tables,
        np.flatnonzero(group.safe),
        facts,
        _SEARCH,
        starts,
        -1,
        automaton.observables["normal_force"],
        speed,
        outcomes,
        happens,
        numbers,
    )
    _slides(group, places, outcomes == kernels.SETTLED, found)
    here = outcomes == kernels.CYCLE
    cycles, what = places[here], happens[here]
    found.happens[cycles] = what
    found.attractor[cycles] = np.where(
        what & kernels.SPRAGS,
        Attractor.SPRAG_SLIP_CYCLE,
        np.where(what & kernels.RESTS, Attractor.STICK_SLIP_CYCLE, Attractor.OTHER_CYCLE),
    )
    found.amplitude[cycles] = numbers[here, kernels.AMPLITUDE]
    found.period[cycles] = numbers[here, kernels.PERIOD]
    found.multiplier[cycles] = numbers[here, kernels.MULTIPLIER]
    found.peak_normal_force[cycles] = numbers[here, kernels.FORCE]
    values = {name: drives.values[name][group.members[here]] for name in ("mass", "pitch_radius", "screw_inertia")}
    fastest = numbers[here, kernels.SEIZURE_SPEED]
    found.peak_normal_impulse[cycles] = np.abs(normal_impulse(fastest, drives.sines(group.members[here]), **values))
    found.open[cycles] = False


def _slides(group: Group, places: np.ndarray, where: np.ndarray, found: Endings) -> None:
    """Write steady sliding for the members ``where`` of a group."""
    here = places[where]
    found.attractor[here] = Attractor.STEADY_SLIDING
    found.amplitude[here] = found.peak_normal_impulse[here] = 0.0
    found.peak_normal_force[here] = group.steady_force[where]
    found.open[here] = False
