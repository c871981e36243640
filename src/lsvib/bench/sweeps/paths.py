"""Motions as far as judges compare them: of the engine, of the Taylor stepper, and of the references with 40 digits."""

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np
from mpmath import mp, mpf

from lsvib.bench.record import Record
from lsvib.bench.reference import rigid_digits as rigid_reference
from lsvib.bench.reference import threads_digits as threads_reference
from lsvib.bench.reference import two_bodies_digits
from lsvib.bench.reference.two_bodies_laws import TwoBodiesTrueDrive as TwoBodies
from lsvib.bench.second_opinions import strides, taylor, watch
from lsvib.bench.second_opinions.endings import KINDS
from lsvib.bench.second_opinions.stride_constants import FORCE, Ladders, ladders
from lsvib.bench.sweeps.families import Case
from lsvib.drives.parameters import RigidParameters
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
    kind = find_model(case.drive.model)
    return kind.build(case.drive, (*kind.options, *case.physics), "contact_sign")


def engine_path(motion: Motion, case: Case) -> Record:
    """Record of the engine's motion."""
    kind, counted = find_model(case.drive.model), ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    size = np.abs(np.vstack([motion.before, motion.after, [motion.start_state, motion.end_state]])).max(axis=0)
    if case.drive.model in _TWO_BODIES:
        pairs = zip(motion.mode[counted], motion.kind[counted] == kind.events["SEIZURE"], strict=True)
        kinds = [_token(kind.modes(int(motion.automaton.codes[mode])).name.lower(), seized) for mode, seized in pairs]
    else:
        kinds = [kind.events(event).name.lower() for event in motion.kind[counted]]
    return _path(case, kinds, motion.time[counted], motion.end_state, size, motion.time.size < MOST_EVENTS)


def stepper_path(case: Case, size: np.ndarray) -> Record | None:
    """The stepper's motion, or None where it would take too many steps; ``size`` is that of the engine's motion."""
    constants = taylor.constants(dict(case.drive))
    rates = np.abs(constants.rates)
    if not case.duration * (rates[:, 1] + np.sqrt(rates[:, 0])).max() < _MOST_STEPS * taylor.PART:
        return None
    times, kinds = np.empty(MOST_EVENTS), np.empty(MOST_EVENTS, dtype=np.int64)
    complete, count, u, w = taylor.run(constants, *case.start, case.duration, times, kinds)
    names = [KINDS[kind] for kind in kinds[:count]]
    return _path(case, names, times[:count], (u, w), size, complete)


def watched_path(case: Case, constants: watch.WatchConstants, size: np.ndarray) -> Record | None:
    """The motion in closed form, or None where double precision does not tell; ``size``: as for the stepper."""
    times, states = np.empty(MOST_EVENTS), np.empty((MOST_EVENTS, 2))
    kinds, modes = np.empty(MOST_EVENTS, dtype=np.int64), np.empty(MOST_EVENTS, dtype=np.int64)
    end, count, u, w, _ = watch.watch(
        constants, *case.start, watch.ANYWHERE, case.duration, False, times, kinds, modes, states
    )
    if end not in (watch.TIME_REACHED, watch.EVENTS_FULL):
        return None
    names = [KINDS[kind] for kind in kinds[:count]]
    return _path(case, names, times[:count], (u, w), size, end == watch.TIME_REACHED)


def case_ladders(case: Case, longest: float) -> Ladders:
    """Constants of a drive with four states for :func:`strides_path`, for motions up to ``longest`` [s]."""
    return ladders(case.drive.model, dict(case.drive), case.physics, longest)


def strides_path(case: Case, constants: Ladders) -> Record | None:
    """The motion of a drive with four states by strides of propagators, or None where they do not tell."""
    times, size, end = np.empty(MOST_EVENTS), np.empty(4), np.empty(4)
    before, after, fired = (np.empty(MOST_EVENTS, dtype=np.int64) for _ in range(3))
    status, count, _ = strides.follow(
        constants, np.array(case.start), case.duration, strides.MOST_STRIDES, times, before, after, fired,
        np.empty((0, 4)), end, size,
    )  # fmt: skip
    if status not in (strides.TIME_REACHED, strides.EVENTS_FULL):
        return None
    kinds = []
    for one, other, kind in zip(before[:count], after[:count], fired[:count], strict=True):
        if case.drive.model == "threads":
            if constants.direction[one] == 0:
                kinds.append("release")
            elif kind == FORCE:
                kinds.append("contact_reversal")
            else:
                kinds.append("reversal" if constants.direction[other] else "stick")
        else:
            seconds = constants.second[other] if constants.has_second else None
            mode = (constants.direction[other], constants.contact[other], seconds)
            kinds.append(_token(_name(mode, case.drive.model), kind == strides.SEIZURE))
    return _path(case, kinds, times[:count], end, size, status == strides.TIME_REACHED)


def quick_path(case: Case, drive: RigidParameters, start: tuple[float, ...]) -> Record | None:
    """:func:`strides_path` in the place of :func:`exact_path`."""
    moved = case._replace(drive=drive, start=start)
    return strides_path(moved, case_ladders(moved, case.duration))


@lru_cache(maxsize=8)  # a judge that is not content with the answer asks again
def exact_path(case: Case, drive: RigidParameters, start: tuple[float, ...]) -> Record | None:
    """The reference's motion, with 40 digits or with 80 if these do not decide; None if those do not either."""
    for digits in (40, 80):
        with suppress(ArithmeticError, AssertionError), mp.workdps(digits):  # to sample the arcs, too
            return _exact_path(case, drive, start, digits)
    return None


def _exact_path(case: Case, drive: RigidParameters, start: tuple[float, ...], digits: int) -> Record:
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
        kinds = [_token(_name(event.mode_after, drive.model), event.seizure) for event in result.events]
        visited = [event.state for event in result.events]
        visited += result.sampled(_SAMPLES)
        end, complete = result.state, result.complete
    size = np.abs(np.array([start, end, *visited], dtype=float)).max(axis=0)
    times = np.array([float(event.time) for event in result.events])
    return _path(case, kinds, times, end, size, complete)


def _token(mode: str, seized: bool) -> str:
    return mode + ("_by_seizure" if seized else "")


def _name(mode: tuple, model: str) -> str:
    """Name of a mode (d, q, a) of the reference."""
    slip, contact, second = mode
    name = f"slip_{_SLIPS[slip]}{_CONTACTS[contact]}" if slip else f"rest{_CONTACTS[contact]}"
    body = "nut" if model == "support" else "screw"
    return name if second is None else f"{name}_{body}{_SECONDS[second]}"


@lru_cache(maxsize=2)  # one drive is asked after the other
def _least(drive: RigidParameters, physics: tuple[str, ...]) -> np.ndarray:
    """Smallest size by which each coordinate of a drive with a second body is measured."""
    steady = TwoBodies(drive.model, dict(drive), physics)
    speed = abs(drive.input_speed)
    rate = speed * math.tan(drive.lead_angle) * drive.pitch_radius if drive.model == "support" else speed
    return _LEAST * np.array([abs(steady.z0), speed, abs(steady.q0), rate])


def _path(case: Case, kinds: Sequence[str], times: np.ndarray, end, size, complete: bool) -> Record:
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
