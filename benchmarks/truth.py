"""Motions in 40 digits and more by :mod:`references`, rounded to double at the end."""

import math

import numpy as np
from mpmath import mp, mpf
from references import four_states_digits, friction_law_digits, rigid_digits
from references.exponential_sums import UNIT, Function

from benchmarks.judge import Record, count_stops
from lsvib.models.drive import Drive
from lsvib.models.friction import depends_on_speed

# Parts of an arc at which its size is looked at: what dies away at once, or has not begun to, belongs to it as well.
_SAMPLES = [*(mpf(10) ** -k for k in range(15, 0, -1)), *(mpf(k) / 8 for k in range(1, 8))]


def truth(
    drive: Drive, start, duration: float, physics: tuple[str, ...] | None = None, *,
    digits: int = 40, most: int = 1_000_000, steady_from: float = math.inf,
) -> Record:  # fmt: skip
    """Return the true motion of a drive that is rigid or has one part that complies.

    ``physics``: the frictions of a second body that are there; given, what is told of an event is the mode that follows
    and whether it is a seizure. ``most`` events; ``steady_from`` [s]: from when on u is extreme.
    """
    if depends_on_speed(drive):
        return _law_truth(drive, start, duration, min(steady_from, duration))
    with mp.workdps(digits + four_states_digits.SPARE_DIGITS):
        options = {"dps": digits, "max_events": most}
        if drive.rigid:
            result = rigid_digits.simulate(dict(drive), *start, duration, **options)
            ends = [*(segment.time for segment in result.segments[1:]), result.time]
            arcs = [_rigid_arc(result.drive, *arc) for arc in zip(result.segments, ends, strict=True)]
            visited = [(s.u, s.w) for s in result.segments] + [(e.u_before, e.w_before) for e in result.events]
            kinds, end, rests = [event.kind for event in result.events], (result.u, result.w), result.segments[0].mode
        else:
            model = drive.parts[0]
            result = four_states_digits.simulate(dict(drive), model, physics or (), start, duration, **options)
            arcs = [(stay, *_angle(result.drive.mode(mode).arc(x))) for mode, x, stay in result.arcs]
            visited = [event.state for event in result.events] + result.sampled((0, 1) if physics is None else _SAMPLES)
            kinds, end, rests = (
                [event.kind for event in result.events],
                result.state,
                (result.arcs or [(result.mode,)])[0][0],
            )
            if physics is not None:
                names = [four_states_digits.mode_name(event.mode_after, model) for event in result.events]
                kinds = [by_seizure(*each) for each in zip(names, (e.seizure for e in result.events), strict=True)]
        angles = list(_late_angles(arcs, steady_from)) or [math.inf, -math.inf]
        return Record(
            kinds=kinds,
            times=np.array([float(event.time) for event in result.events]),
            end=np.array(end, dtype=float),
            size=np.abs(np.array([start, end, *visited], dtype=float)).max(axis=0),
            complete=result.complete,
            stops=count_stops(kinds, rests[0] == 0),
            extremes=(float(min(angles)), float(max(angles))),
        )


def _law_truth(drive: Drive, start, duration: float, steady_from: float) -> Record:
    """The true motion of a rigid drive under a friction law, in 33 digits.

    From ``steady_from`` on u is extreme at its ends, at an event, or where θ′ passes Ω.
    """
    motions = [friction_law_digits.simulate(drive.model_dump(), *start, end) for end in (steady_from, duration)]
    if any(motion.end != "time" for motion in motions):
        raise ArithmeticError("the law does not determine the motion to its end")
    early, whole = motions
    late = [event.before for event in whole.events if event.time >= early.time]
    angles = [float(u) for u, _ in (early.state, *late, whole.state)]
    visited = [start, whole.state, *(state for event in whole.events for state in (event.before, event.after))]
    events = [event for event in whole.events if event.kind != "passage"]
    kinds = [event.kind for event in events]
    return Record(
        kinds=kinds,
        times=np.array([float(event.time) for event in events]),
        end=np.array(whole.state, dtype=float),
        size=np.abs(np.array(visited, dtype=float)).max(axis=0),
        stops=count_stops(kinds, start[1] == -drive.input_speed),
        extremes=(min(angles), max(angles)),
    )


def by_seizure(mode: str, seized: bool) -> str:
    """Return what is told of an event of a second body: the mode that follows, and whether it is a seizure."""
    return mode + ("_by_seizure" if seized else "")


def _rigid_arc(drive, segment, end):
    """How long an arc lasts, u as a function of its time, and a function of two times: turns of u between them."""
    if segment.mode == rigid_digits.REST:
        return end - segment.time, lambda t: segment.u + segment.w * t, lambda left, right: ()
    flow = rigid_digits.RigidTrueFlow(drive, segment.mode[0] * segment.mode[1], segment.u, segment.w)
    turns = flow.extrema
    return (
        end - segment.time,
        lambda t: flow.state(t)[0],
        lambda left, right: [t for t in turns((mpf(1), mpf(0), mpf(0)), right) if t >= left],
    )


def _angle(arc):
    angle = Function(arc, [*UNIT[0], mpf(0)])
    return angle, lambda left, right: angle.derivative().roots(left, right) if left < right else ()


def _late_angles(arcs, steady_from):
    """u where it may be extreme from a time [s] on."""
    begin = mpf(0)
    for stay, angle, turns in arcs:
        late, begin = max(steady_from - begin, mpf(0)), begin + stay
        if late <= stay:
            yield from (angle(t) for t in (late, *turns(late, stay), stay))
