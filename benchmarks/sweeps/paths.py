"""Motions as far as judges compare them: of the engine, of the Taylor stepper, and of the references with 40 digits."""

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np
from mpmath import mp, mpf

from benchmarks.record import Record
from references import rigid_digits as rigid_reference
from references import threads_digits as threads_reference
from references import two_bodies_digits
from references.two_bodies_laws import TwoBodiesTrueDrive as TwoBodies
from benchmarks.sweeps import taylor
from benchmarks.sweeps.families import Case
from lsvib.drives.parameters import DriveParameters
from lsvib.drives.registry import find_model
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.status import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion

MOST_EVENTS = 60  # events of a motion; one with 40 digits is then compared in a fraction of a second
# Parts of an arc at which its size is looked at: what dies away at once, or has not begun to, belongs to it as well.
_SAMPLES = [mpf(10) ** -k for k in range(15, 0, -1)] + [mpf(k) / 8 for k in range(1, 8)]
_MOST_STEPS = 100_000  # steps of the stepper; motions that need more go to the reference
INSTANT = 1e-12  # Events before this part of the duration belong to the start on a guard.
TOUCHES = {("stick", "release"), ("contact_reversal", "contact_reversal"), ("reversal", "reversal")}
CORNER = "corner"  # stands for events that follow each other at once
_TWO_BODIES = ("support", "nut")  # models with a second body
_LEAST = 1e-3  # least size of a motion, relative to that of steady sliding; a smaller motion is measured by it
_SLIPS = {1: "forward", -1: "backward"}
_CONTACTS = {1: "_positive", -1: "_negative", 0: ""}
_SECONDS = {1: "_forward", -1: "_backward", 0: "_held"}


def without_clusters(kinds: Sequence[str], times: Sequence[float], gap: float) -> list[str]:
    """Return the kinds of events, with each run of events that follow each other within ``gap`` [s] as one corner."""
    tokens: list[str] = []
    for k, kind in enumerate(kinds):
        if k and times[k] - times[k - 1] <= gap:
            tokens[-1] = CORNER
        else:
            tokens.append(kind)
    return tokens


def same_but_corners(left: Sequence[str], right: Sequence[str]) -> bool:
    """Whether two results of :func:`without_clusters` agree; a corner agrees with any event."""
    return len(left) == len(right) and all(a == b or CORNER in (a, b) for a, b in zip(left, right, strict=True))


def is_rigid(case: Case) -> bool:
    """Whether a case is of the rigid drive, which the stepper can follow."""
    return case.drive.model == "rigid"


def automaton(case: Case) -> Automaton:
    """Build the engine's model of a case; errors of the library where it refuses."""
    model = find_model(case.drive.model)
    return model.build(case.drive, (*model.options, *case.physics), "contact_sign")


def engine_path(motion: Motion, case: Case) -> Record:
    """Record of the engine's motion."""
    model, counted = find_model(case.drive.model), ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    size = np.abs(np.vstack([motion.before, motion.after, [motion.start_state, motion.end_state]])).max(axis=0)
    if case.drive.model in _TWO_BODIES:
        pairs = zip(motion.mode[counted], motion.kind[counted] == model.events["SEIZURE"], strict=True)
        kinds = [token(model.modes(int(motion.automaton.codes[mode])).name.lower(), seized) for mode, seized in pairs]
    else:
        kinds = [model.events(event).name.lower() for event in motion.kind[counted]]
    return shortened(case, kinds, motion.time[counted], motion.end_state, size, motion.time.size < MOST_EVENTS)


def stepper_path(case: Case, size: np.ndarray) -> Record | None:
    """The stepper's motion, or None where it would take too many steps; ``size`` is that of the engine's motion."""
    constants = taylor.constants(dict(case.drive))
    rates = np.abs(constants.rates)
    if not case.duration * (rates[:, 1] + np.sqrt(rates[:, 0])).max() < _MOST_STEPS * taylor.PART:
        return None
    times, kinds = np.empty(MOST_EVENTS), np.empty(MOST_EVENTS, dtype=np.int64)
    complete, count, u, w = taylor.run(constants, *case.start, case.duration, times, kinds)
    names = [taylor.KINDS[kind] for kind in kinds[:count]]
    return shortened(case, names, times[:count], (u, w), size, complete)


@lru_cache(maxsize=8)  # a judge that is not content with the answer asks again
def exact_path(case: Case, drive: DriveParameters, start: tuple[float, ...]) -> Record | None:
    """The reference's motion, with 40 digits or with 80 if these do not decide; None if those do not either."""
    for digits in (40, 80):
        with suppress(ArithmeticError, AssertionError), mp.workdps(digits):  # to sample the arcs, too
            return _exact_path(case, drive, start, digits)
    return None


def _exact_path(case: Case, drive: DriveParameters, start: tuple[float, ...], digits: int) -> Record:
    if drive.model == "threads":
        result = threads_reference.simulate(dict(drive), start, case.duration, dps=digits, max_events=MOST_EVENTS)
        kinds, visited = [event.kind for event in result.events], [event.state for event in result.events]
        visited += [arc.state(stay * x) for _, _, arc, stay in result.arcs for x in _SAMPLES if stay]
        end, complete = result.state, result.complete
    elif is_rigid(case):
        result = rigid_reference.simulate(dict(drive), *start, case.duration, dps=digits, max_events=MOST_EVENTS)
        kinds = [event.kind for event in result.events]
        visited = [(event.u_before, event.w_before) for event in result.events]
        visited += [(segment.u, segment.w) for segment in result.segments]
        end, complete = (result.u, result.w), result.complete
    else:
        result = two_bodies_digits.simulate(
            dict(drive), drive.model, case.physics, start, case.duration, dps=digits, max_events=MOST_EVENTS
        )
        kinds = [token(mode_name(event.mode_after, drive.model), event.seizure) for event in result.events]
        visited = [event.state for event in result.events]
        visited += result.sampled(_SAMPLES)
        end, complete = result.state, result.complete
    size = np.abs(np.array([start, end, *visited], dtype=float)).max(axis=0)
    times = np.array([float(event.time) for event in result.events])
    return shortened(case, kinds, times, end, size, complete)


def token(mode: str, seized: bool) -> str:
    """Name of an event of a drive with a second body: the mode after it, and whether it is a seizure."""
    return mode + ("_by_seizure" if seized else "")


def mode_name(mode: tuple, model: str) -> str:
    """Name of a mode (d, q, a) of the reference."""
    slip, contact, second = mode
    name = f"slip_{_SLIPS[slip]}{_CONTACTS[contact]}" if slip else f"rest{_CONTACTS[contact]}"
    body = "nut" if model == "support" else "screw"
    return name if second is None else f"{name}_{body}{_SECONDS[second]}"


@lru_cache(maxsize=2)  # one drive is asked after the other
def _least(drive: DriveParameters, physics: tuple[str, ...]) -> np.ndarray:
    """Smallest size by which each coordinate of a drive with a second body is measured."""
    steady = TwoBodies(drive.model, dict(drive), physics)
    speed = abs(drive.input_speed)
    rate = speed * math.tan(drive.lead_angle) * drive.pitch_radius if drive.model == "support" else speed
    return _LEAST * np.array([abs(steady.z0), speed, abs(steady.q0), rate])


def shortened(case: Case, kinds: Sequence[str], times: np.ndarray, end, size, complete: bool) -> Record:
    """Leave out what lasts no time: events of the start on a guard, and a touch that is told as two events.

    A motion with a second body that is small counts as large as a part of steady sliding.
    """
    if case.drive.model in _TWO_BODIES:
        size = np.maximum(size, _least(case.drive, case.physics))
    kept: list[int] = []
    instant = INSTANT * case.duration
    for k, kind in enumerate(kinds):
        if times[k] <= instant:
            continue
        if kept and (kinds[kept[-1]], kind) in TOUCHES and times[k] - times[kept[-1]] <= instant:
            kept.pop()
            continue
        kept.append(k)
    return Record([kinds[k] for k in kept], np.asarray(times)[kept], np.array(end, dtype=float), size, complete)
