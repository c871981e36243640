"""What the motions of drives of any model end on: attractor, size, forces.

Some models have a search of many motions at once (:mod:`lsvib.dynamics.endings_of_models`). The others' drives are
followed one by one, share by share, in processes of their own. The search is that for one drive
(:func:`lsvib.dynamics.attractor.steady_state`), so all results are the same to rounding, and do not depend on how the
drives are shared out.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from multiprocessing import get_context
from typing import Any, NamedTuple, TypeVar

import numpy as np

from lsvib.dynamics import endings_of_models
from lsvib.dynamics.attractor import Attractor, SteadyState, orbit_extremes, steady_state
from lsvib.dynamics.impulses import event_impulses
from lsvib.dynamics.kernels.sweep import RESTS, REVERSES, SPRAGS
from lsvib.dynamics.sweep import Ending, Endings
from lsvib.engine.automaton import Automaton
from lsvib.engine.motion import enter
from lsvib.errors import EngineError
from lsvib.models.drive import Drive
from lsvib.models.many import ManyDrives, automata
from lsvib.models.model import Model, Resume, find_model, of_model

_SHARE = 1024  # most drives whose tables are made at once: arrays pay, and a process has some seconds of work
_LEAST = 64  # drives that a process takes at a time where there are few
_WITHOUT_NUMBERS = (Attractor.UNRESOLVED, Attractor.UNBOUNDED)

Done = TypeVar("Done")


class Prepared(NamedTuple):
    """A drive by its place among others, with its model and its automaton – None if the engine has none."""

    place: int
    model: Model
    drive: Drive
    automaton: Automaton | None

    def state(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the state (n) with these values by name, u [rad] and w [rad/s] and what else the model has."""
        return self.model.initial_state(self.drive, values)


def prepared(drives: ManyDrives, resume: str) -> Iterator[Prepared]:
    """Yield drives of one model, each with all its terms that are not zero; raises ``InputError`` as the model does."""
    model = find_model(drives.drive_class.model)
    for k, drive, automaton in automata(drives, resume):
        yield Prepared(k, model, drive, automaton)


def ending_of(one: Prepared, state: np.ndarray) -> Ending:
    """Return what the motion of a drive from a state ends on."""
    automaton = one.automaton
    if automaton is None:
        return Ending.without_numbers(Attractor.UNRESOLVED)
    found = steady_state(automaton, state)
    force = automaton.observables["normal_force"]
    if found.label in _WITHOUT_NUMBERS or (found.orbit is None and found.label == Attractor.NEUTRAL_FAMILY):
        return Ending.without_numbers(found.label)
    if found.orbit is None:
        mode, _ = enter(automaton, found.state)
        low, high = found.extremes(force[mode])
        return Ending.without_numbers(found.label)._replace(
            amplitude=0.0, peak_normal_force=max(abs(low), abs(high)), peak_normal_impulse=0.0
        )
    try:
        amplitude, peak = found.amplitude, max(map(abs, orbit_extremes(found.orbit, force)))
    except EngineError:  # the rates of a mode lie too far apart to find the extremes
        amplitude = peak = np.nan
    impulse = 0.0
    if np.isin(found.orbit.kind, automaton.sprag_kinds).any():
        impulse = float(np.abs(event_impulses(one.drive, found.orbit).normal).max())
    return Ending(int(found.label), happens(one.model, found), amplitude, found.period, found.multiplier, peak, impulse)


def happens(model: Model, found: SteadyState) -> int:
    """Return what happens on a cycle, as :class:`lsvib.dynamics.sweep.Ending` has it."""
    orbit = found.orbit
    if orbit is None:
        return 0
    codes = orbit.automaton.codes[orbit.arcs()[0]]
    return (
        SPRAGS * (found.label == Attractor.SPRAG_SLIP_CYCLE)
        + RESTS * bool(np.isin(codes, orbit.automaton.rest_codes).any())
        + REVERSES * bool((orbit.kind == model.events["CONTACT_REVERSAL"]).any())
    )


def all_endings(
    drives: ManyDrives,
    starts: np.ndarray,
    resume: Resume,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
    others: Mapping[str, float] | None = None,
) -> Endings:
    """Return what motions of drives of one model (k) end on, each from its own start, u [rad] and w [rad/s] (k, 2).

    A motion depends on nothing but its own drive and start: no number depends on ``workers``, the number of processes
    and, with a search of many motions at once, of threads. ``progress`` is told how many of how many are done.
    ``others``: values of the other states by name, by default those that the model begins with. Raises ``InputError``
    for a rule of resuming that the model does not know.
    """
    at_once = of_model(endings_of_models, drives.drive_class.model, "all_endings", endings_one_by_one)
    found: Endings = at_once(drives, starts, resume, workers, progress, others or {})
    return found


def endings_one_by_one(
    drives: ManyDrives,
    starts: np.ndarray,
    resume: Resume,
    workers: int,
    progress: Callable[[int, int], None] | None,
    others: Mapping[str, float],
) -> Endings:
    """Return what the motions of drives (k) end on, followed one by one; arguments as of :func:`all_endings`."""
    found = Endings.unknown(drives.size)
    parts = in_shares(partial(_share, others=dict(others), resume=resume), drives, (starts,), workers, progress)
    for places, part in parts:
        found.put(places, part)
    return found


def _share(drives: ManyDrives, starts: np.ndarray, others: Mapping[str, float], resume: str) -> Endings:
    found = Endings.unknown(drives.size)
    for one in prepared(drives, resume):
        u, w = starts[one.place].tolist()
        found.put(one.place, ending_of(one, one.state({"u": u, "w": w, **others})))
    return found


def in_shares(
    work: Callable[..., Done],
    drives: ManyDrives,
    columns: Sequence[np.ndarray],
    workers: int,
    progress: Callable[[int, int], None] | None,
) -> Iterator[tuple[slice, Done]]:
    """Yield what ``work`` makes of shares of drives and of the rows (k, ...) that belong to them, in their order."""
    size = max(_LEAST, min(_SHARE, -(-drives.size // (2 * workers))))
    places = [slice(first, min(first + size, drives.size)) for first in range(0, drives.size, size)]
    cases = ((drives.some(np.arange(here.start, here.stop)), *(column[here] for column in columns)) for here in places)

    def told(parts: Any) -> Iterator[tuple[slice, Done]]:
        """Yield each share with its place, and tell the progress."""
        for here, part in zip(places, parts, strict=True):
            yield here, part
            if progress is not None:
                progress(here.stop, drives.size)

    if workers == 1 or len(places) == 1:
        yield from told(work(*case) for case in cases)
        return
    with get_context("spawn").Pool(min(workers, len(places))) as pool:
        yield from told(pool.imap(partial(_on_case, work), cases))


def _on_case(work: Callable[..., Done], case: tuple[Any, ...]) -> Done:
    return work(*case)
