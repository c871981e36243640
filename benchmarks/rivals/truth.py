"""Scenes in 40 digits with :mod:`references`, rounded to double at the end."""

import numpy as np
from mpmath import mp, mpf

from benchmarks.record import Record, count_stops
from references import rigid_digits, threads_digits
from benchmarks.rivals.race_scenes import RaceScene
from benchmarks.sweeps.taylor import DIGITS


def reference(scene: RaceScene) -> Record:
    """Compute a scene with the independent reference; takes seconds to a minute."""
    return _threads(scene) if scene.drive.model == "threads" else _rigid(scene)


def _rigid(scene: RaceScene) -> Record:
    result = rigid_digits.simulate(dict(scene.drive), *scene.state, scene.duration, dps=DIGITS, max_events=1_000_000)
    with mp.workdps(DIGITS + rigid_digits.GUARD_DIGITS):
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
    kinds = [event.kind for event in result.events]
    return _rounded(
        (result.u, result.w), result.events, kinds, result.segments[0].mode == rigid_digits.REST, angles, visited
    )


def _threads(scene: RaceScene) -> Record:
    result = threads_digits.simulate(dict(scene.drive), scene.state, scene.duration, dps=DIGITS, max_events=1_000_000)
    with mp.workdps(DIGITS + threads_digits.SPARE_DIGITS):
        angles, visited = [result.state[0]], [result.state]
        row = [mpf(1), mpf(0), mpf(0), mpf(0), mpf(0)]
        for start, _, arc, stay in result.arcs:
            visited += [arc.state(mpf(0)), arc.state(stay)]
            if start + stay < scene.steady_from:
                continue
            late = max(scene.steady_from - start, mpf(0))
            angle = threads_digits.Function(arc, row)
            turns = angle.derivative().roots(late, stay) if stay > late else ()
            angles += [angle(late), angle(stay), *(angle(t) for t in turns)]
    kinds = [event.kind for event in result.events]
    return _rounded(result.state, result.events, kinds, result.arcs[0][1].startswith("rest"), angles, visited)


def _rounded(end_state, events, kinds, starts_at_rest, angles, visited) -> Record:
    return Record(
        end=np.array([float(x) for x in end_state]),
        times=np.array([float(event.time) for event in events]),
        kinds=kinds,
        stops=count_stops(kinds, starts_at_rest),
        extremes=(float(min(angles)), float(max(angles))),
        size=np.abs(np.array([[float(x) for x in state] for state in [*visited, end_state]])).max(axis=0),
    )
