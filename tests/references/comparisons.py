"""Comparisons of an engine's motion with references."""

import math
from dataclasses import dataclass

import numpy as np

from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion, follow
from lsvib.models.command import Command
from lsvib.models.drive import Drive
from lsvib.models.model import model_of
from lsvib.models.names import Event
from lsvib.models.rigid import rigid_automaton
from references.bodies import Bodies
from references.rigid_digits import RigidTruth, simulate

RULES = ("contact_sign", "at_once")


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
    drive: Drive, start: np.ndarray, duration: float, most: int, tolerance: float, command: Command | None = None
) -> tuple[Motion, list[dict]]:
    """Follow a motion and hold each arc against Newton's laws, body by body; returns it with the modes of its arcs.

    States along the arc and at its end, N, and what the mode says of signs and of what friction can hold. The tolerance
    is that of states, over the size of the motion.
    """
    model, laws, n = model_of(drive), Bodies(drive, command and command.at), len(start)
    automaton = model.build(drive, model.physics_of(drive), "contact_sign", command)
    motion = follow(automaton, [*start, *([0.0] if command else [])], duration, max_events=most)
    modes, starts, ends, durations = motion.arcs()
    starts, ends = starts[:, :n], ends[:, :n]
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
        states = laws.moved(first + laws.steady, what, times, size + np.abs(laws.steady))
        found = np.vstack([motion.at(times[1:-1])[0][:, :n], last])
        error = np.abs(states[1:] - laws.steady - found) / size
        # Where a law brings Γ₊ to zero the deceleration grows without bound, and with it what rounding does to the end.
        jams = seizes and what["slip"] * what["contact"] > 0
        assert error[:-1].max() <= tolerance, (drive, what)
        assert error[-1].max() <= (1e-6 if jams else tolerance), (drive, what)
        assert max(laws.excess(state, what, size + np.abs(laws.steady)) for state in states) <= 1e-7, (drive, what)
        if what["slip"] or "e" in laws.place:
            normal, middle = laws.forces(states[4], what)["N"], motion.at(times[4:5])[0]
            found, least = automaton.observe("normal_force", middle, np.array([mode])), 1e-12 * abs(drive.axial_force)
            np.testing.assert_allclose(found, normal, rtol=1e-9, atol=least)
            assert not what["slip"] or abs(normal) <= least or normal * what["contact"] > 0
    return motion, arcs
