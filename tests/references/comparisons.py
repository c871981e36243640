"""Comparisons of an engine's motion with references."""

import math
from dataclasses import dataclass

import numpy as np

from lsvib import Drive
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion, follow
from lsvib.models.command import Command
from lsvib.models.model import automaton_of, model_of
from lsvib.models.names import Event
from lsvib.models.rigid import rigid_automaton
from references.contacts import Arc, Contacts, Happening
from references.rigid_digits import RigidTruth, simulate

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
    motion = follow(rigid_automaton(drive, resume=rule), start, t_end, max_events=max_events)
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


def held_against_newton(
    drive: Drive, start: np.ndarray, duration: float, most: int, tolerance: float
) -> tuple[Motion, list[dict]]:
    """Follow a motion and hold each arc against Newton's laws, body by body; returns it with the modes of its arcs.

    States along the arc and at its end, N, and what the mode says of signs and of what friction can hold. The tolerance
    is that of states, over the size of the motion.
    """
    model, laws, n = model_of(drive), Contacts(drive), len(start)
    automaton = automaton_of(drive)
    motion = follow(automaton, start, duration, max_events=most)
    modes, starts, ends, durations = motion.arcs()
    size = np.abs([*starts, *ends]).max(axis=0)
    size = np.maximum(size, 1e-6 * np.tile(size[:2], n // 2))  # some coordinates move by rounding only
    arcs = [laws.mode(model.modes(int(automaton.codes[mode])).name.lower()) for mode in modes]
    seized = np.append(motion.kind == model.events.SEIZURE, False)
    begins = np.cumsum([0.0, *durations[:-1]])
    for mode, what, first, last, begin, time, seizes in zip(
        modes, arcs, starts, ends, begins, durations, seized, strict=False
    ):
        if time < 1e-9:
            continue
        times = begin + np.linspace(0.0, float(time), 9)
        arc = Arc(laws, begin, first + laws.steady, what)
        states = np.vstack([arc.state, arc.through(begin, arc.state, times[1:])])
        found = np.vstack([motion.at(times[1:-1])[0], last])
        # Where a law brings Γ₊ to zero the deceleration grows without bound, and with it what rounding does to the end,
        # before which the steps of the reference become too small.
        jams = seizes and what["slip"] * what["contact"] > 0
        assert len(states) >= (8 if jams else 9), (drive, what)
        error = np.abs(states[1:] - laws.steady - found[: len(states) - 1]) / size
        assert error[:7].max() <= tolerance, (drive, what)
        assert error[7:].max(initial=0.0) <= (1e-6 if jams else tolerance), (drive, what)
        assert max(laws.excess(state, what, size + np.abs(laws.steady)) for state in states) <= 1e-7, (drive, what)
        if what["slip"] or "e" in laws.place:
            normal, middle = laws.forces(states[4], what)["N"], motion.at(times[4:5])[0]
            found, least = automaton.observe("normal_force", middle, np.array([mode])), 1e-12 * abs(drive.axial_force)
            np.testing.assert_allclose(found, normal, rtol=1e-9, atol=least)
            assert not what["slip"] or abs(normal) <= least or normal * what["contact"] > 0
    return motion, arcs


def by_newton(drive: Drive, start, command: Command | None, duration: float, most: int) -> Found:
    """First mode and events of a motion as the reference of dry contacts finds them; the last is its end."""
    laws = Contacts(drive, *((command.times, command.speeds) if command else ()))
    state = start + laws.steady
    state[np.abs(state) < 1e-14 * np.abs(start)] = 0.0  # that is rounding: springs may be relaxed
    return laws.follow(state, duration, most)


def by_package(drive: Drive, start, command: Command | None, duration: float, most: int) -> Found:
    """The same by the package, in the words of the reference."""
    model, laws, n = model_of(drive), Contacts(drive), len(start)
    automaton = model.build(drive, model.physics_of(drive), "contact_sign", command)
    motion = follow(automaton, [*start, *([0.0] if command else [])], duration, max_events=8 * most)  # with passages
    modes = [laws.mode(model.modes(int(automaton.codes[mode])).name.lower()) for mode in motion.arcs()[0]]
    kinds, states = [Event(kind).name.lower() for kind in motion.kind], [*motion.after, motion.end_state]
    found = zip([*motion.time, duration], [*kinds, "end"], states, [*modes[1:], modes[-1]], strict=True)
    events = [Happening(time, kind, state[:n] + laws.steady, mode) for time, kind, state, mode in found]
    begun = np.count_nonzero(motion.time == 0.0)  # what lets go at the start
    return modes[begun], [event for event in events[begun:] if event.kind not in ("passage", "graze")]


def instants(events: list[Happening], most: int) -> list[list[Happening]]:
    """Events by the instant at which they are; not the last one where more may follow."""
    found = []
    for event in events[:most]:
        if not found or event.time - found[-1][0].time > 1e-13 * event.time:
            found.append([])
        found[-1].append(event)
    return found[:-1] if len(events) > most else found


def held_against_contacts(drive: Drive, start, command: Command | None, duration: float, most: int) -> list[str]:
    """Hold modes, events and states of a motion against the reference that finds them itself; returns kinds of events.

    At one instant contacts may stop and let go one after the other; in which order, or that they do, is not said.
    """
    (first, expected), (mode, events) = (way(drive, start, command, duration, most) for way in (by_newton, by_package))
    assert mode == first, drive
    ours, theirs = instants(events, most), instants(expected, most)
    size = np.maximum(np.abs([event.state for event in expected]).max(axis=0), 1e-3 * Contacts(drive).sizes)
    for found, known in zip(ours, theirs, strict=max(len(events), len(expected)) <= most):
        assert abs(found[0].time - known[0].time) <= 1e-9 * known[0].time, (drive, known, found)
        own, other = ([event.kind.rpartition("_")[0] for event in events] for events in (found, known))
        assert own[0] in other or other[0] in own, (drive, known, found)
        assert len(found + known) > 2 or found[0].kind == known[0].kind, (drive, known, found)
        assert found[-1].mode == known[-1].mode, (drive, known, found)
        assert (np.abs(found[-1].state - known[-1].state) <= 1e-8 * size).all(), (drive, known, found)
        assert len(found) < 4, (drive, found)
    return [event.kind for found in ours for event in found if event.kind != "end"]
