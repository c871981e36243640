"""Comparisons of an engine's motion with references."""

import math
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import model_of
from lsvib.drives.names import Event
from lsvib.drives.scene import Command
from lsvib.dynamics.impulses import work
from lsvib.errors import EngineError, InputError
from lsvib.systems.attractor import steady_state
from lsvib.systems.kernels import layout
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.systems.motion import Motion, follow
from references.bodies import Bodies
from references.drives import drive_with_parts
from references.rigid_digits import RigidTruth, simulate
from references.series import Happening, Series

RULES = ("contact_sign", "at_once")
Found = tuple[dict, list[Happening]]  # the first mode of a motion and what happens after it


@dataclass(frozen=True)
class Comparison:
    """An engine's motion, the reference's, and what separates them (errors relative to the size of the motion)."""

    motion: Motion
    reference: RigidTruth
    state_error: float
    time_error: float  # [s]; nan if the events are not the same
    kinds: list[str]
    reference_kinds: list[str]


def compare(drive: Drive, start, t_end: float, rule: str = "contact_sign", max_events: int = 10_000) -> Comparison:
    """Follow a motion both ways; its size is the largest |u| and |w| at its start, its events and its end."""
    expected = simulate(dict(drive), *start, t_end, resume_rule=rule, max_events=max_events)
    motion = follow(automaton_of(drive, resume=rule), start, t_end, max_events=max_events)
    visited = [[s.u, s.w] for s in expected.segments] + [[e.u_before, e.w_before] for e in expected.events]
    size = np.abs(np.array([*visited, [expected.u, expected.w]], dtype=float)).max(axis=0)
    gap = [abs(float(motion.end_state[0] - expected.u)), abs(float(motion.end_state[1] - expected.w))]
    ours = ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    kinds = [Event(kind).name.lower() for kind in motion.kind[ours]]
    theirs = [event.kind for event in expected.events]
    error = float(np.max(np.array(gap) / np.where(size > 0, size, 1.0)))  # a size of 0: the equilibrium itself
    pairs = zip(motion.time[ours], expected.events, strict=False)
    late = max((abs(float(event.time - time)) for time, event in pairs), default=0.0)
    return Comparison(motion, expected, error, late if kinds == theirs else math.nan, kinds, theirs)


def by_newton(drive: Drive, start, command: Command | None, duration: float, most: int, watched=None) -> Found:
    """First mode and events of a motion as Newton's laws find them, rounded to doubles; the last is its end.

    ``watched``: gives what is watched, from the laws.
    """
    laws = Series(drive, *((command.times, command.speeds) if command else ()))
    first, events = laws.follow(start, duration, most, watched and watched(laws))
    return first, [Happening(float(x.time), x.kind, x.state.astype(float), x.mode) for x in events]


def by_package(drive: Drive, start, command: Command | None, duration: float, most: int, inner=("passage",)) -> Found:
    """The same by the package, in the words of the reference, without events that are ``inner`` ones."""
    model, laws, n = model_of(drive), Series(drive), len(start)
    automaton = automaton_of(drive, command=command)
    motion = follow(automaton, [*start, *([0.0] if command else [])], duration, max_events=8 * most)  # with passages
    modes = [laws.mode(model.modes(int(automaton.codes[mode])).name.lower()) for mode in motion.arcs()[0]]
    kinds, states = [Event(kind).name.lower() for kind in motion.kind], [*motion.after, motion.end_state]
    found = zip([*motion.time, duration], [*kinds, "end"], states, [*modes[1:], modes[-1]], strict=True)
    events = [Happening(time, kind, state[:n], mode) for time, kind, state, mode in found]
    begun = np.count_nonzero(motion.time == 0.0)  # what lets go at the start
    return modes[begun], [event for event in events[begun:] if event.kind not in ("graze", *inner)]


def instants(events: list[Happening], most: int) -> list[list[Happening]]:
    """Events by the instant at which they are; not the last one where more may follow."""
    found = []
    for event in events[:most]:
        if not found or event.time - found[-1][0].time > 1e-13 * event.time:
            found.append([])
        found[-1].append(event)
    return found[:-1] if len(events) > most else found


def held(
    drive: Drive, start, command: Command | None, duration: float, most: int, state: float = 1e-8, time: float = 0.0
) -> list[str]:
    """Hold a motion of the package against the reference (:func:`alike`)."""
    ways = (way(drive, start, command, duration, most) for way in (by_newton, by_package))
    return alike(drive, *ways, most, state, time)


def alike(drive: Drive, known: Found, found: Found, most: int, state: float, time: float) -> list[str]:
    """Hold modes, events and states of a motion against those that are known; returns the kinds of its events.

    Tolerances: ``state`` of the size of the motion, ``time`` [s], or 1e-9 of the time. At one instant contacts may stop
    and let go one after the other; in which order, or that they do, is not said.
    """
    (first, expected), (mode, events) = known, found
    assert mode == first, drive
    ours, theirs, laws = instants(events, most), instants(expected, most), Bodies(drive)
    # Coordinates are resolved to a part of steady sliding, and of what moves in a millisecond.
    rates = [(drive.input_speed or 1.0) * (float(laws.lead) if name in "ye" else 1.0) for name in laws.q]
    least = 1e-3 * (np.abs(laws.steady.astype(float)) + np.abs(np.kron(rates, [1e-3, 1.0])))
    size = np.maximum(np.abs([event.state for event in expected]).max(axis=0), least)
    for found, known in zip(ours, theirs, strict=max(len(events), len(expected)) <= most):
        assert abs(found[0].time - known[0].time) <= (time or 1e-9 * known[0].time), (drive, known, found)
        own, other = ([event.kind.rpartition("_")[0] for event in events] for events in (found, known))
        assert own[0] in other or other[0] in own, (drive, known, found)
        assert len(found + known) > 2 or found[0].kind == known[0].kind, (drive, known, found)
        assert found[-1].mode == known[-1].mode, (drive, known, found)
        assert (np.abs(found[-1].state - known[-1].state) <= state * size).all(), (drive, known, found)
        assert len(found) < 4, (drive, found)
    return [event.kind for found in ours for event in found if event.kind != "end"]


def liouville(cycle) -> float:
    """The multiplier of a cycle of slip of a rigid drive."""
    modes, _, _, durations = cycle.orbit.arcs()
    return math.exp(-float(np.sum(cycle.orbit.automaton.tables.flow[modes, layout.A1] * durations)))


def balanced(seeds, draw=drive_with_parts, **more: bool) -> list[tuple[str, ...]]:
    """Assert that the energy of the cycles of random drives balances; the parts of the drives that have one.

    To rounding; of those that jam, where the force grows as the inverse root of the time left, to twice the root of it.
    """
    found = []
    for drive, start in (draw(seed, **more) for seed in seeds):
        with suppress(InputError, EngineError):
            automaton = automaton_of(drive)
            orbit = steady_state(automaton, start, max_events=20_000).orbit
            if orbit is not None and orbit.time.size:
                jams = automaton.marked(orbit.kind, "impact").any() and (drive.stribeck_rise or drive.friction_slope)
                assert abs(work(drive, orbit).balance) <= (3e-8 if jams else 1e-13), drive
                found.append(drive.parts)
    return found
