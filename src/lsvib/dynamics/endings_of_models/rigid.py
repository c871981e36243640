"""What the motions of rigid drives end on – attractor, size, forces –, of one or of many at once.

The tables of many drives are made at once, and a compiled search does the common cases, number by number as
:func:`lsvib.dynamics.attractor.steady_state` does, so that all results are the same to the last bit. What it leaves
open goes to that function.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from multiprocessing import get_context

import numpy as np

from lsvib.dynamics import drift_two_states, more_states, poincare_map, recurrences
from lsvib.dynamics.attractor import Attractor, orbit_extremes, steady_state
from lsvib.dynamics.impulses import normal_impulse, seizure_impulses, seizure_speeds
from lsvib.dynamics.kernels import sweep as kernels
from lsvib.dynamics.kernels.plan import CYCLE, OPEN, SETTLED, Facts, SearchLimits
from lsvib.dynamics.kernels.sweep import RESTS, SPRAGS
from lsvib.dynamics.sweep import Ending, Endings, happens
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.kernels import layout
from lsvib.errors import EngineError
from lsvib.models.drive import RigidDrive
from lsvib.models.many import Group, ManyDrives, groups
from lsvib.models.mechanics import coefficients, steady_force
from lsvib.models.model import Resume, find_model
from lsvib.models.rigid import EventKind, MotionMode, rigid_automaton

_SEARCH = SearchLimits(
    chunk=more_states.CHUNK,
    patience=more_states.LONG,
    returns=recurrences.PERIODS,
    solved=recurrences.SOLVED,
    fewest=recurrences.FEWEST,
    repeats=recurrences.REPEATS[0],
    corner=recurrences.CORNERS[0],
    few=drift_two_states.FEW,
    patience_of_return=poincare_map.PATIENCE,
    longest=poincare_map.LONGEST,
    secants=poincare_map.SECANTS,
    wider=poincare_map.WIDER,
    widest=poincare_map.WIDEST,
    slope_step=poincare_map.SLOPE_STEP,
    clear=poincare_map.CLEAR,
)


_BLOCK = 8192  # drives whose tables are made at once: half a gigabyte of numbers for a million would be too many
_SHARE = 50  # open motions that a process takes at a time, some 0.1 s
_WORTH = 1000  # open motions that make it worth while to start processes, which takes some seconds
_WITHOUT_EXTREMES = (Attractor.UNRESOLVED, Attractor.UNBOUNDED)


def ending(drive: RigidDrive, state: Sequence[float], resume: Resume) -> Ending:
    """Return what the motion of a rigid drive from a state (u [rad], w [rad/s]) ends on."""
    automaton = rigid_automaton(drive, resume=resume)
    found = steady_state(automaton, state)
    label = int(found.label)
    if found.label in _WITHOUT_EXTREMES:
        return Ending.without_numbers(found.label)
    if found.orbit is None:  # steady sliding: a drive that turns does not rest for ever
        with many_digits():
            force = float(steady_force(coefficients(drive), drive.exact()))
        return Ending(label, 0, 0.0, math.nan, math.nan, force, 0.0)
    try:
        amplitude = found.amplitude
        force = max(map(abs, orbit_extremes(found.orbit, automaton.observables["normal_force"])))
    except EngineError:  # the rates of a mode lie too far apart to find the extremes
        amplitude = force = math.nan
    impulses = np.abs(seizure_impulses(drive, seizure_speeds(drive, found.orbit)).normal)
    impulse = float(np.max(impulses, initial=0.0))
    return Ending(
        label, happens(find_model(drive.model), found), amplitude, found.period, found.multiplier, force, impulse
    )


def all_endings(
    drives: ManyDrives,
    starts: np.ndarray,
    resume: Resume,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
    others: Mapping[str, float] | None = None,
) -> Endings:
    """Return what the motions of rigid drives (k) end on; arguments as of :func:`lsvib.dynamics.sweep.all_endings`.

    ``workers`` is the number of threads and, if many motions are left open by the compiled search, of processes. A
    rigid drive has no ``others``.
    """
    done = 0

    def tell(more: int) -> None:
        """Count drives that are done, and tell the progress."""
        nonlocal done
        done += more
        if progress is not None and more:
            progress(done, drives.size)

    found, is_open = endings_at_once(drives, starts, resume, workers, tell)
    places = np.flatnonzero(is_open).tolist()
    work = partial(_one, resume=resume)
    cases = ((drives.one(k), tuple(starts[k].tolist())) for k in places)
    apart = workers > 1 and len(places) >= _WORTH
    with get_context("spawn").Pool(workers) if apart else nullcontext() as processes:
        ends = processes.imap(work, cases, _SHARE) if processes else map(work, cases)
        for k, one in zip(places, ends, strict=True):
            found.put(k, one)
            tell(1)
    return found


def endings_at_once(
    drives: ManyDrives,
    starts: np.ndarray,
    resume: Resume,
    workers: int = 1,
    tell: Callable[[int], None] = lambda _: None,
) -> tuple[Endings, np.ndarray]:
    """Return what the motions of rigid drives (k) end on, as far as the compiled search finds it, and what is open (k).

    Arguments as :func:`all_endings` has them; ``tell`` is told how many more are done.
    """
    found, is_open = Endings.unknown(drives.size), np.ones(drives.size, dtype=bool)
    size = max(1, min(_BLOCK, -(-drives.size // workers)))
    blocks = [np.arange(first, min(first + size, drives.size)) for first in range(0, drives.size, size)]
    with ThreadPoolExecutor(workers) as pool:
        for block, left in zip(
            blocks, pool.map(lambda block: _block_endings(drives, block, starts, resume, found), blocks), strict=True
        ):
            is_open[block] = left
            tell(int((~left).sum()))
    return found, is_open


def _one(case: tuple[RigidDrive, tuple[float, float]], resume: Resume) -> Ending:
    """:func:`ending` of a drive and a start, for a process of its own."""
    return ending(*case, resume)


def _block_endings(
    drives: ManyDrives, block: np.ndarray, starts: np.ndarray, resume: Resume, found: Endings
) -> np.ndarray:
    """Write what the motions of a block of drives (j, ascending indices) end on; return which are left open (j)."""
    is_open = np.ones(block.size, dtype=bool)
    for group in groups(drives, resume, block):
        closed, endings = _group_endings(drives, group, starts[group.members])
        found.put(group.members[closed], Endings(*(column[closed] for column in endings)))
        is_open[np.searchsorted(block, group.members[closed])] = False
    return is_open


def _group_endings(drives: ManyDrives, group: Group, starts: np.ndarray) -> tuple[np.ndarray, Endings]:
    """Return which motions of a group (j), from ``starts`` (j, 2), are known to end, and what all end on."""
    automaton, size, found = group.automaton, group.members.size, Endings.unknown(group.members.size)
    if automaton.contracts:  # steady sliding attracts all motions, but without damping
        damped = (automaton.tables.flow[..., layout.ALPHA] > 0).any(axis=1)
        _slides(group, group.safe & damped, found)
        return group.safe & damped, found
    (rest,) = np.flatnonzero(automaton.codes == MotionMode.REST)
    facts = Facts(int(rest), int(EventKind.SEIZURE), int(EventKind.CONTACT_REVERSAL), int(EventKind.RELEASE))
    outcomes, numbers = np.zeros(size, dtype=np.int8), np.full((size, kernels.NUMBERS), np.nan)
    kernels.endings(
        automaton.tables,
        np.flatnonzero(group.safe),
        facts,
        _SEARCH,
        np.ascontiguousarray(starts, dtype=float),
        automaton.observables["normal_force"],
        drives.values["input_speed"][group.members],
        outcomes,
        found.happens,
        numbers,
    )
    _slides(group, outcomes == SETTLED, found)
    cycles = outcomes == CYCLE
    happens = found.happens[cycles]
    labels = np.where(happens & RESTS, Attractor.STICK_SLIP_CYCLE, Attractor.OTHER_CYCLE)
    found.attractor[cycles] = np.where(happens & SPRAGS, Attractor.SPRAG_SLIP_CYCLE, labels)
    found.amplitude[cycles] = numbers[cycles, kernels.AMPLITUDE]
    found.period[cycles] = numbers[cycles, kernels.PERIOD]
    found.multiplier[cycles] = numbers[cycles, kernels.MULTIPLIER]
    found.peak_normal_force[cycles] = numbers[cycles, kernels.FORCE]
    members = group.members[cycles]
    values = {name: drives.values[name][members] for name in ("mass", "pitch_radius", "screw_inertia")}
    impulses = normal_impulse(
        numbers[cycles, kernels.SEIZURE_SPEED], np.sin(drives.values["lead_angle"][members]), **values
    )
    found.peak_normal_impulse[cycles] = np.abs(impulses)
    return outcomes != OPEN, found


def _slides(group: Group, here: np.ndarray, found: Endings) -> None:
    """Write steady sliding for some members of a group."""
    found.attractor[here] = Attractor.STEADY_SLIDING
    found.amplitude[here] = found.peak_normal_impulse[here] = 0.0
    found.peak_normal_force[here] = group.steady_force[here]
