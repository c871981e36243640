"""Scenes in 40 digits with :mod:`references`, rounded to double at the end."""

import numpy as np
from mpmath import mp, mpf
from references import four_states_digits, rigid_digits
from references.exponential_sums import UNIT, Function

from benchmarks.record import Record, count_stops
from benchmarks.rivals.race_scenes import RaceScene

_DIGITS = 40
_MOST = 1_000_000  # events


def reference(scene: RaceScene) -> Record:
    """Return the true motion of a scene, of a rigid drive or one with compliant threads."""
    with mp.workdps(_DIGITS + four_states_digits.SPARE_DIGITS):
        return _rigid(scene) if scene.drive.rigid else _threads(scene)


def _rigid(scene: RaceScene) -> Record:
    result = rigid_digits.simulate(dict(scene.drive), *scene.state, scene.duration, dps=_DIGITS, max_events=_MOST)
    angles = [result.u]
    ends = [segment.time for segment in result.segments[1:]] + [result.time]
    for segment, end in zip(result.segments, ends, strict=True):
        if end < scene.steady_from:
            continue
        stay, late = end - segment.time, max(scene.steady_from - segment.time, mpf(0))
        if segment.mode == rigid_digits.REST:
            angles.append(segment.u + segment.w * late)
            continue
        flow = rigid_digits.RigidTrueFlow(result.drive, segment.mode[0] * segment.mode[1], segment.u, segment.w)
        turns = flow.extrema((mpf(1), mpf(0), mpf(0)), stay)
        angles += [flow.state(tau)[0] for tau in [late, stay, *turns] if tau >= late]
    visited = [[s.u, s.w] for s in result.segments] + [[e.u_before, e.w_before] for e in result.events]
    return _rounded((result.u, result.w), result.events, result.segments[0].mode == rigid_digits.REST, angles, visited)


def _threads(scene: RaceScene) -> Record:
    drive = dict(scene.drive)
    result = four_states_digits.simulate(
        drive, "threads", (), scene.state, scene.duration, dps=_DIGITS, max_events=_MOST
    )
    angles, visited, start = [result.state[0]], [result.state], mpf(0)
    for mode, state, stay in result.arcs:
        arc = result.drive.mode(mode).arc(state)
        visited += [state, arc.state(stay)]
        late = max(scene.steady_from - start, mpf(0))
        start += stay
        if late <= stay:
            angle = Function(arc, [*UNIT[0], mpf(0)])
            turns = angle.derivative().roots(late, stay) if stay > late else ()
            angles += [angle(late), angle(stay), *(angle(t) for t in turns)]
    return _rounded(result.state, result.events, result.arcs[0][0][0] == 0, angles, visited)


def _rounded(end_state, events, starts_at_rest, angles, visited) -> Record:
    kinds = [event.kind for event in events]
    return Record(
        end=np.array([float(x) for x in end_state]),
        times=np.array([float(event.time) for event in events]),
        kinds=kinds,
        stops=count_stops(kinds, starts_at_rest),
        extremes=(float(min(angles)), float(max(angles))),
        size=np.abs(np.array([[float(x) for x in state] for state in [*visited, end_state]])).max(axis=0),
    )
