"""Motions as far as they are compared: of the engine, and of the references with 40 digits."""

from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np
from references.bodies import Bodies

from benchmarks.judge import Record
from benchmarks.sweeps.families import Case
from benchmarks.truth import by_seizure, truth
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.friction import depends_on_speed
from lsvib.drives.model import model_of
from lsvib.drives.names import Event
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import layout
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.systems.motion import Motion

MOST_EVENTS = 60  # events of a motion; one with 40 digits is then compared in a fraction of a second
INSTANT = 1e-12  # Events before this part of the duration belong to the start on a guard.
_TOUCHES = {("stick", "release"), ("contact_reversal", "contact_reversal"), ("reversal", "reversal")}
_LEAST = 1e-3  # least size of a motion, relative to that of steady sliding; a smaller motion is measured by it


def automaton(case: Case) -> Automaton:
    """Build the engine's model of a case; errors of the library where it refuses."""
    return automaton_of(case.drive)


def most_events(drive: Drive) -> int:
    """How many events of a motion the engine is asked for, passages among them, of which a law makes many."""
    return MOST_EVENTS * (4 if depends_on_speed(drive) else 1)


def fields(automaton: Automaton) -> np.ndarray:
    """Return A and b of every mode of x′ = A x + b, (m, n, n + 1)."""
    flow = automaton.tables.flow
    if not isinstance(flow, np.ndarray):
        return flow.field
    table = np.zeros((len(flow), 2, 3))
    table[:, 0, 1] = 1.0
    table[:, 1] = np.stack([-flow[:, layout.A0], -flow[:, layout.A1], flow[:, layout.B]], axis=1)
    return table


def engine_path(motion: Motion, case: Case) -> Record:
    """Record of the engine's motion: its events by their kinds, with parts or a law by the modes that follow."""
    model, counted = model_of(case.drive), ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND, Event.PASSAGE))
    size = np.abs(np.vstack([motion.before, motion.after, [motion.start_state, motion.end_state]])).max(axis=0)
    if case.drive.rigid and not depends_on_speed(case.drive):
        kinds = [model.events(event).name.lower() for event in motion.kind[counted]]
    else:
        names = [model.modes(int(motion.automaton.codes[mode])).name.lower() for mode in motion.mode[counted]]
        seized = motion.automaton.marked(motion.kind[counted], "impact")
        kinds = [by_seizure(*pair) for pair in zip(names, seized, strict=True)]
    whole = motion.time.size < most_events(case.drive) and len(kinds) < MOST_EVENTS
    return _shortened(case, kinds, motion.time[counted], motion.end_state, size, whole)


@lru_cache(maxsize=8)  # a judge that is not content with the answer asks again
def exact_path(case: Case, drive: Drive, start: tuple[float, ...]) -> Record | None:
    """The reference's motion, with 40 digits or with 80 if these do not decide; None if those do not either."""
    for digits in (40, 80):
        with suppress(ArithmeticError, AssertionError):
            path = truth(drive, start, case.duration, case.physics, digits=digits, most=MOST_EVENTS)
            return _shortened(case, path.kinds, path.times, path.end, path.size, path.complete)
    return None


@lru_cache(maxsize=2)  # one drive is asked after the other
def _least(drive: Drive) -> np.ndarray:
    """Smallest size by which each coordinate of a drive with more than one body is measured."""
    laws, speed = Bodies(drive), abs(drive.input_speed)
    rates = [speed * (float(laws.lead) if name in "ye" else 1.0) for name in laws.q]
    return _LEAST * np.array(
        [x for y, rate in zip(laws.steady[::2], rates, strict=True) for x in (abs(float(y)), rate)]
    )


def _shortened(case: Case, kinds: Sequence[str], times: np.ndarray, end, size, complete: bool) -> Record:
    """Leave out what lasts no time: events of the start on a guard, and a touch that is told as two events.

    A motion with a second body that is small counts as large as a part of steady sliding.
    """
    if case.drive.parts and case.drive.parts != ("threads",):
        size = np.maximum(size, _least(case.drive))
    kept: list[int] = []
    instant = INSTANT * case.duration
    for k, kind in enumerate(kinds):
        if times[k] <= instant:
            continue
        if kept and (kinds[kept[-1]], kind) in _TOUCHES and times[k] - times[kept[-1]] <= instant:
            kept.pop()
            continue
        kept.append(k)
    return Record([kinds[k] for k in kept], np.asarray(times)[kept], np.array(end, dtype=float), size, complete)
