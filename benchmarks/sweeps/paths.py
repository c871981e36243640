"""Motions as far as they are compared: of the engine, and of the references with 40 digits."""

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np
from mpmath import mp, mpf
from references import four_states_digits, rigid_digits

from benchmarks.record import Record
from benchmarks.sweeps.families import Case
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion
from lsvib.models.drive import Drive
from lsvib.models.model import model_of

MOST_EVENTS = 60  # events of a motion; one with 40 digits is then compared in a fraction of a second
# Parts of an arc at which its size is looked at: what dies away at once, or has not begun to, belongs to it as well.
_SAMPLES = [mpf(10) ** -k for k in range(15, 0, -1)] + [mpf(k) / 8 for k in range(1, 8)]
INSTANT = 1e-12  # Events before this part of the duration belong to the start on a guard.
_TOUCHES = {("stick", "release"), ("contact_reversal", "contact_reversal"), ("reversal", "reversal")}
CORNER = "corner"  # stands for events that follow each other at once
_LEAST = 1e-3  # least size of a motion, relative to that of steady sliding; a smaller motion is measured by it


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


def automaton(case: Case) -> Automaton:
    """Build the engine's model of a case; errors of the library where it refuses."""
    model = model_of(case.drive)
    return model.build(case.drive, (*model.options, *case.physics), "contact_sign")


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
    """Record of the engine's motion: its events by their kinds, of four states by the modes that follow."""
    model, counted = model_of(case.drive), ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    size = np.abs(np.vstack([motion.before, motion.after, [motion.start_state, motion.end_state]])).max(axis=0)
    if case.drive.rigid:
        kinds = [model.events(event).name.lower() for event in motion.kind[counted]]
    else:
        names = [model.modes(int(motion.automaton.codes[mode])).name.lower() for mode in motion.mode[counted]]
        seized = np.isin(motion.kind[counted], motion.automaton.sprag_kinds)
        kinds = [_token(*pair) for pair in zip(names, seized, strict=True)]
    return _shortened(case, kinds, motion.time[counted], motion.end_state, size, motion.time.size < MOST_EVENTS)


@lru_cache(maxsize=8)  # a judge that is not content with the answer asks again
def exact_path(case: Case, drive: Drive, start: tuple[float, ...]) -> Record | None:
    """The reference's motion, with 40 digits or with 80 if these do not decide; None if those do not either."""
    for digits in (40, 80):
        with suppress(ArithmeticError, AssertionError), mp.workdps(digits):  # to sample the arcs, too
            return _exact_path(case, drive, start, digits)
    return None


def _exact_path(case: Case, drive: Drive, start: tuple[float, ...], digits: int) -> Record:
    if drive.rigid:
        result = rigid_digits.simulate(dict(drive), *start, case.duration, dps=digits, max_events=MOST_EVENTS)
        kinds = [event.kind for event in result.events]
        visited = [(event.u_before, event.w_before) for event in result.events]
        visited += [(segment.u, segment.w) for segment in result.segments]
        end = result.u, result.w
    else:
        result = four_states_digits.simulate(
            dict(drive), drive.parts[0], case.physics, start, case.duration, dps=digits, max_events=MOST_EVENTS
        )
        names = [four_states_digits.mode_name(event.mode_after, drive.parts[0]) for event in result.events]
        kinds = [_token(name, event.seizure) for name, event in zip(names, result.events, strict=True)]
        visited = [event.state for event in result.events] + result.sampled(_SAMPLES)
        end = result.state
    size = np.abs(np.array([start, end, *visited], dtype=float)).max(axis=0)
    times = np.array([float(event.time) for event in result.events])
    return _shortened(case, kinds, times, end, size, result.complete)


def _token(mode: str, seized: bool) -> str:
    return mode + ("_by_seizure" if seized else "")


@lru_cache(maxsize=2)  # one drive is asked after the other
def _least(drive: Drive, physics: tuple[str, ...]) -> np.ndarray:
    """Smallest size by which each coordinate of a drive with a second body is measured."""
    steady = four_states_digits.FourStatesDrive(drive.parts[0], dict(drive), physics)
    speed = abs(drive.input_speed)
    rate = speed * math.tan(drive.lead_angle) * drive.pitch_radius if drive.parts == ("support",) else speed
    return _LEAST * np.array([abs(float(steady.z0)), speed, abs(float(steady.q0)), rate])


def _shortened(case: Case, kinds: Sequence[str], times: np.ndarray, end, size, complete: bool) -> Record:
    """Leave out what lasts no time: events of the start on a guard, and a touch that is told as two events.

    A motion with a second body that is small counts as large as a part of steady sliding.
    """
    if case.drive.parts in (("support",), ("nut",)):
        size = np.maximum(size, _least(case.drive, case.physics))
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
