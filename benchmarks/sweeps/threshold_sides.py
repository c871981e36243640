"""Which attractor lies on which side of a threshold of the axial force, and the motion over a million periods."""

import math
from typing import NamedTuple

import numpy as np
from references.rigid_digits import simulate

from benchmarks.sweeps.cases import CaseGroup, threshold
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import EventKind, rigid_automaton
from lsvib.engine.motion import follow

_CHUNK = 400_000  # events followed at once


def attractor_is_right(group: CaseGroup, side: int, distance: float) -> bool:
    """Whether the engine finds the attractor that the threshold R_t promises at R = R_t (1 + side · distance).

    ``side``: +1 for a larger, −1 for a smaller |R|. Onset: steady sliding below, slip cycle above (8.19). Stick: slip
    cycle below, stick–slip above. Detach: N changes sign within the cycle below, not above. Global stability, from the
    state in which rest ends: sprag–slip cycle below, steady sliding above (end of Sect. 8.7).
    """
    force, drive = threshold(group)
    drive = drive.replace(axial_force=force * (1 + side * distance))
    start = (drive.support_damping * drive.input_speed / drive.coupling_stiffness, -drive.input_speed)
    if group != CaseGroup.GLOBAL_STABILITY_FORCE:
        start = (1e-3, 0.0)
    found = steady_state(rigid_automaton(drive), start)
    expected = {
        (CaseGroup.ONSET_FORCE, -1): Attractor.STEADY_SLIDING,
        (CaseGroup.ONSET_FORCE, 1): Attractor.OTHER_CYCLE,
        (CaseGroup.STICK_FORCE, -1): Attractor.OTHER_CYCLE,
        (CaseGroup.STICK_FORCE, 1): Attractor.STICK_SLIP_CYCLE,
        (CaseGroup.DETACH_FORCE, -1): Attractor.STICK_SLIP_CYCLE,
        (CaseGroup.DETACH_FORCE, 1): Attractor.STICK_SLIP_CYCLE,
        (CaseGroup.GLOBAL_STABILITY_FORCE, -1): Attractor.SPRAG_SLIP_CYCLE,
        (CaseGroup.GLOBAL_STABILITY_FORCE, 1): Attractor.STEADY_SLIDING,
    }
    right = found.label == expected[group, side]
    if group == CaseGroup.DETACH_FORCE and right:
        right = (found.orbit.kind == EventKind.CONTACT_REVERSAL).any() == (side < 0)
    return bool(right)


class LongRun(NamedTuple):
    """Engine and reference after many periods: number of events, error of the clock [1] and of the state [1]."""

    events: int
    clock_error: float
    state_error: float


def long_run(drive: RigidParameters, periods: int) -> LongRun:
    """Follow a cycle with rest for many periods, to a release from rest, against one period of the reference.

    A release from rest is the same state every time, so that the time of the n-th is t_1 + n T, with t_1 and T from the
    reference with 40 digits.
    """
    automaton = rigid_automaton(drive)
    start = (1e-3, 0.0)
    exact = _releases(drive, start)
    first, period = exact[0].time, exact[1].time - exact[0].time
    begun = follow(automaton, start, math.inf, stop=(EventKind.RELEASE, -1))
    # The clock goes on by the sums of whole chunks, so that the events need not all be kept.
    state, mode, elapsed, events = begun.end_state, begun.end_mode, [begun.end_time], begun.time.size
    per_period = follow(automaton, state, math.inf, mode=mode, stop=(EventKind.RELEASE, -1)).time.size
    left = periods * per_period
    while left:
        part = follow(automaton, state, math.inf, mode=mode, max_events=min(left, _CHUNK // per_period * per_period))
        state, mode, left = part.end_state, part.end_mode, left - part.time.size
        elapsed.append(part.end_time)
        events += part.time.size
    due = first + periods * period
    size = np.array([abs(float(exact[0].u_after)) or 1.0, abs(drive.input_speed)])
    gap = np.abs(state - np.array([float(exact[0].u_after), float(exact[0].w_after)])) / size
    return LongRun(events, abs(float((math.fsum(elapsed) - due) / due)), float(gap.max()))


def _releases(drive: RigidParameters, start: tuple[float, float]) -> list:
    """The first two releases from rest of the reference's motion."""
    duration = 2e-2
    while True:
        result = simulate(dict(drive), *start, duration)
        found = [event for event in result.events if event.kind == "release"]
        if len(found) >= 2:
            return found[:2]
        duration *= 2
