"""Motions in 40 digits, 22 under a friction law, by :mod:`references`, rounded to double at the end."""

import math
from collections.abc import Iterator

import numpy as np
from flint import ctx
from mpmath import mp, mpf
from references import rigid_digits
from references.series import SPARE, Happening, Series

from benchmarks.judge import Record, count_stops
from lsvib.drives.drive import Drive

# Parts of an arc at which its size is looked at: what dies away at once, or has not begun to, belongs to it as well.
_SAMPLES = [*(10.0**-k for k in range(15, 0, -1)), *(k / 8 for k in range(1, 8))]


def truth(
    drive: Drive, start, duration: float, physics: tuple[str, ...] | None = None, *,
    digits: int = 40, most: int = 1_000_000, steady_from: float = math.inf,
) -> Record:  # fmt: skip
    """Return the true motion of a drive.

    ``physics``: the frictions of a second body; given, what is told of an event is the mode that follows
    and whether it is a seizure. ``most`` events; ``steady_from`` [s]: from when on u is extreme.
    """
    if drive.rigid and not (drive.stribeck_rise or drive.friction_slope):
        return _closed(drive, start, duration, digits, most, steady_from)
    laws = Series(drive, digits=digits)
    watched = {
        "turn": lambda place, _: place[1, 0] - laws.p["input_speed"],
        "steady": lambda place, _: place[laws.size + 2, 0] - steady_from,
    }
    first, (*found, last) = laws.follow(start, duration, most, watched if steady_from <= duration else None)
    events = [event for event in found if event.kind not in watched]
    late = [float(event.state[0]) for event in (*found, last) if float(event.time) >= steady_from]
    kinds = [event.kind if physics is None else told(laws, event) for event in events]
    states = [*_visited(laws, () if physics is None else _SAMPLES)]
    return Record(
        kinds=kinds,
        times=np.array([float(event.time) for event in events]),
        end=last.state.astype(float),
        size=np.abs(np.array([start, last.state, *states], dtype=float)).max(axis=0),
        complete=last.kind == "end" and len(events) < most,
        stops=count_stops(kinds, first["slip"] == 0),
        extremes=(min(late, default=math.inf), max(late, default=-math.inf)),
    )


def _visited(laws: Series, parts) -> Iterator[np.ndarray]:
    """States at parts of each arc, or at its ends."""
    with ctx.workdps(laws.digits + SPARE):
        for arc, end in laws.arcs:
            whole = (end[laws.size + 2, 0] - arc.place[laws.size + 2, 0]) / (1 + arc.form.loss * arc.mu)
            places = [(arc.matrix * (whole * part)).exp() * arc.place for part in parts] or [arc.place, end]
            yield from (np.array(place.entries()[: laws.size]) - laws.steady for place in places)


def told(laws: Series, event: Happening) -> str:
    """The mode after an event, as the package calls it, and whether the event is a seizure."""
    words = {1: "forward", -1: "backward", 0: "held"}
    name = ["slip", words[event.mode["slip"]]] if event.mode["slip"] else ["rest"]
    name += [{1: "positive", -1: "negative"}[event.mode["contact"]]] if event.mode["contact"] else []
    bodies = (("bearing", "screw"), ("slide", "nut"))
    name += [word for body, part in bodies if body in laws.dry for word in (part, words[event.mode[body]])]
    return by_seizure("_".join(name), event.kind == "seizure")


def _closed(drive: Drive, start, duration: float, digits: int, most: int, steady_from: float) -> Record:
    """The motion of a rigid drive without a law."""
    with mp.workdps(digits + SPARE):
        result = rigid_digits.simulate(dict(drive), *start, duration, dps=digits, max_events=most)
        ends = [*(segment.time for segment in result.segments[1:]), result.time]
        arcs = [_rigid_arc(result.drive, *arc) for arc in zip(result.segments, ends, strict=True)]
        visited = [(s.u, s.w) for s in result.segments] + [(e.u_before, e.w_before) for e in result.events]
        kinds, end = [event.kind for event in result.events], (result.u, result.w)
        angles = list(_late_angles(arcs, steady_from)) or [math.inf, -math.inf]
        return Record(
            kinds=kinds,
            times=np.array([float(event.time) for event in result.events]),
            end=np.array(end, dtype=float),
            size=np.abs(np.array([start, end, *visited], dtype=float)).max(axis=0),
            complete=result.complete,
            stops=count_stops(kinds, result.segments[0].mode[0] == 0),
            extremes=(float(min(angles)), float(max(angles))),
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


def _late_angles(arcs, steady_from):
    """u where it may be extreme from a time [s] on."""
    begin = mpf(0)
    for stay, angle, turns in arcs:
        late, begin = max(steady_from - begin, mpf(0)), begin + stay
        if late <= stay:
            yield from (angle(t) for t in (late, *turns(late, stay), stay))
