"""Stick–slip of the rigid drive under a static friction above that of sliding, against the closed form of its arcs.

Rest ends in the same state whatever came before: the reference, which follows a motion with 40 digits, is on the cycle
from its first release on.
"""

from itertools import pairwise

import numpy as np
import pytest
from mpmath import mp, mpf
from references.draws import drawn, one_of, power, signed, uniform
from references.rigid_digits import REST, RigidTrueFlow, simulate

import lsvib
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.models.rigid import rigid_automaton

DRIVES = 20


def cycle(drive):
    """Period [s] and amplitude [rad] of the stick–slip that a motion comes to; None where it comes to another end."""
    truth = simulate(dict(drive), 0.2, 0.0, 1.0, max_events=12)
    released = [k for k, event in enumerate(truth.events) if event.kind == "release"]
    if len(released) < 2:
        return None
    first, last = released[-2:]
    places = []
    for arc, after in pairwise(truth.segments[first + 1 : last + 2]):
        places.append(arc.u)
        if arc.mode != REST:
            flow = RigidTrueFlow(truth.drive, arc.mode[0] * arc.mode[1], arc.u, arc.w)
            places += [flow.state(t)[0] for t in flow.extrema((mpf(1), mpf(0), mpf(0)), after.time - arc.time)]
    return truth.events[last].time - truth.events[first].time, (max(places) - min(places)) / 2


def drives():
    """Random drives, turning and loaded either way."""
    rng = np.random.default_rng(20261126)
    while True:
        friction = rng.uniform(0.1, 0.25) if rng.random() < 0.7 else 0.218
        static = friction * rng.uniform(1.1, 2.0)
        yield lsvib.Drive.of(
            drawn(
                rng, friction_coefficient=friction, static_friction_coefficient=static, mass=uniform(0.3, 4.0),
                support_damping=power(-5.0, -3.7), translation_damping=one_of(0.0, rng.uniform(1.0, 50.0)),
                axial_force=signed(uniform(20.0, 150.0)), input_speed=signed(uniform(2.0, 30.0)),
            )
        )  # fmt: skip


def test_period_and_amplitude():
    signs, compared = set(), 0
    with mp.workdps(40):
        for drive in drives():
            expected = cycle(drive)
            if expected is None:
                continue
            found = steady_state(rigid_automaton(drive), [0.2, 0.0])
            assert found.label == Attractor.STICK_SLIP_CYCLE, drive
            for ours, theirs in zip((found.period, found.amplitude), expected, strict=True):
                assert abs(ours - theirs) <= 1e-12 * theirs, drive
            assert found.multiplier == pytest.approx(0.0, abs=1e-9)
            signs.add((drive.input_speed > 0, drive.axial_force > 0))
            compared += 1
            if compared == DRIVES:
                break
    assert len(signs) == 4
